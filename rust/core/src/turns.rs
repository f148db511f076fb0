//! How a line turns at each of its vertices, measured on the surface, and how that changes when vertices slide.
//!
//! ```text
//!         left end
//!            |   ,.- out          turn = angle(in, edge) - angle(out, edge),
//!       in   | /                  both from the direction to the left end;
//!     -------*                    0: straight in the unfolded triangles,
//!            |                    above 0: to the left
//!         right end
//! ```
//!
//! Left is a matter of walking along the strip, not of winding. Holds no energy and no solver.

use glam::DVec3;

use crate::ids::{HalfedgeId, VertexId};
use crate::mesh::SurfaceMesh;
use crate::route::{Route, Spot, crossing_position, spot_of};
use crate::vertex_pass::{angle_between, corner_angle};

/// A vertex of the line.
#[derive(Clone, Copy, Debug)]
pub struct Node {
    /// Where it is.
    pub position: DVec3,
    /// Leg and letter of a crossing; `None` for a pin.
    pub crossing: Option<(usize, usize)>,
    /// From the low to the high end of a crossing's edge; zero for a pin.
    pub slide: DVec3,
    /// Parameter of a crossing.
    pub parameter: f64,
}

/// The turn at a node, and its change when nodes slide by one unit of their parameters.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct Turn {
    /// Radians, to the left.
    pub angle: f64,
    /// Change with the node before.
    pub by_previous: f64,
    /// Change with the node itself.
    pub by_self: f64,
    /// Change with the node after.
    pub by_next: f64,
}

/// All nodes of a line and their turns.
#[derive(Clone, Debug)]
pub struct LineTurns {
    /// In order.
    pub nodes: Vec<Node>,
    /// One a node; none at the ends of an open line.
    pub turns: Vec<Turn>,
    /// Unit vectors in the surface, across the line, to the left; one a node.
    pub left: Vec<DVec3>,
    /// Length of the segment after each node; 0 after the last of an open line.
    pub lengths: Vec<f64>,
    /// Whether the last node is before the first.
    pub closed: bool,
}

/// What a node hangs on.
#[derive(Clone, Debug)]
enum Hold {
    /// An edge; the vector from its right to its left end.
    Edge { across: DVec3 },
    /// The inside of a triangle; its normal, towards someone for whom left is left.
    Inside { normal: DVec3 },
    /// A mesh vertex that is a pin, the spokes round which the strip turns there, and whether the vertex is their left end.
    Vertex { vertex: VertexId, spokes: Vec<HalfedgeId>, is_left: bool },
}

impl LineTurns {
    /// Measures a route; `None` when its legs do not fit its pins or it is a single point.
    pub fn of_route(mesh: &SurfaceMesh, route: &Route) -> Option<Self> {
        let (nodes, holds) = walk_nodes(mesh, route)?;
        let count = nodes.len();
        if count < 2 {
            return None;
        }
        let zero = Vec::new();
        let mut line = Self { nodes, turns: zero, left: Vec::new(), lengths: Vec::new(), closed: route.closed };
        let segment = |i: usize| line.next(i).map(|j| line.nodes[j].position - line.nodes[i].position);
        let segments: Vec<DVec3> = (0..count).map(|i| segment(i).unwrap_or(DVec3::ZERO)).collect();
        let normals: Vec<DVec3> = (0..count)
            .map(|i| line.next(i).map_or(DVec3::ZERO, |j| segment_left(segments[i], &holds[i], &holds[j])))
            .collect();
        line.lengths = segments.iter().map(|s| s.length()).collect();
        let mut turns = vec![Turn::default(); count];
        let mut left = vec![DVec3::ZERO; count];
        for i in 0..count {
            let (before, after) = (line.previous(i), line.next(i));
            let in_left = before.map_or(DVec3::ZERO, |j| normals[j]);
            let out_left = after.map_or(DVec3::ZERO, |_| normals[i]);
            left[i] = (in_left + out_left).normalize_or_zero();
            let (Some(j), Some(k)) = (before, after) else { continue };
            let (way_in, way_out) = (segments[j], segments[i]);
            let (a, b) =
                (in_left / line.lengths[j].max(f64::MIN_POSITIVE), out_left / line.lengths[i].max(f64::MIN_POSITIVE));
            turns[i] = Turn {
                angle: turn_angle(mesh, &line.nodes[i], &holds[i], way_in, way_out),
                by_previous: a.dot(line.nodes[j].slide),
                by_self: -(a + b).dot(line.nodes[i].slide),
                by_next: b.dot(line.nodes[k].slide),
            };
        }
        (line.turns, line.left) = (turns, left);
        Some(line)
    }

    /// The node after `i`.
    pub fn next(&self, i: usize) -> Option<usize> {
        let count = self.nodes.len();
        if i + 1 < count { Some(i + 1) } else { self.closed.then_some(0) }
    }

    /// The node before `i`.
    pub fn previous(&self, i: usize) -> Option<usize> {
        if i > 0 { Some(i - 1) } else { self.closed.then_some(self.nodes.len() - 1) }
    }
}

/// Which ends of a letter are left and right, after a letter whose ends are known and in the triangle that it enters.
fn next_ends(
    mesh: &SurfaceMesh,
    before: HalfedgeId,
    [left, right]: [VertexId; 2],
    next: HalfedgeId,
) -> Option<[VertexId; 2]> {
    let entered = mesh.twin(before)?;
    if entered == next {
        // Back where it came from, at a pin: what was left is right.
        return Some([right, left]);
    }
    let apex = mesh.apex(entered);
    Some(if mesh.touches(next, left) { [left, apex] } else { [apex, right] })
}

/// Nodes of a route in order, and what each hangs on.
fn walk_nodes(mesh: &SurfaceMesh, route: &Route) -> Option<(Vec<Node>, Vec<Hold>)> {
    let (mut nodes, mut holds) = (Vec::new(), Vec::new());
    let first_letter = route.legs.iter().flat_map(|leg| leg.word.first()).next().copied();
    let mut known: Option<(HalfedgeId, [VertexId; 2])> = None;
    let advance = |letter: HalfedgeId, known: &mut Option<(HalfedgeId, [VertexId; 2])>| {
        let ends = match *known {
            Some((before, ends)) => next_ends(mesh, before, ends, letter)?,
            None => mesh.ends(letter),
        };
        *known = Some((letter, ends));
        Some(ends)
    };
    for k in 0..route.pins.len().max(route.legs.len()) {
        if let Some(pin) = route.pins.get(k) {
            let spokes = route.join(mesh, k)?;
            let spot = spot_of(mesh, pin);
            let entry = known;
            let mut ends = None;
            // The turn round the first pin of a closed line ends where the walk begins: its ends are found from there.
            if k > 0 {
                for &spoke in &spokes {
                    ends = advance(spoke, &mut known);
                }
            }
            let position = mesh.position_of(pin);
            let hold = match (spot, ends) {
                (Spot::Vertex(vertex), _) if !spokes.is_empty() => {
                    let ends = ends.or_else(|| ends_before(mesh, &spokes, first_letter))?;
                    Hold::Vertex { vertex, is_left: ends[0] == vertex, spokes }
                }
                (Spot::Edge(..), Some([left, right])) => {
                    Hold::Edge { across: mesh.position(left) - mesh.position(right) }
                }
                _ => Hold::Inside { normal: inside_normal(mesh, pin.triangle, entry, first_letter, route, k) },
            };
            nodes.push(Node { position, crossing: None, slide: DVec3::ZERO, parameter: 0.5 });
            holds.push(hold);
        }
        let Some(leg) = route.legs.get(k) else { continue };
        for (i, (&letter, &t)) in leg.word.iter().zip(&leg.parameters).enumerate() {
            let [left, right] = advance(letter, &mut known)?;
            let [low, high] = mesh.sorted_ends(letter).map(|v| mesh.position(v));
            let position = crossing_position(mesh, letter, t);
            nodes.push(Node { position, crossing: Some((k, i)), slide: high - low, parameter: t });
            holds.push(Hold::Edge { across: mesh.position(left) - mesh.position(right) });
        }
    }
    Some((nodes, holds))
}

/// Ends of the last of `spokes`, told backwards from the first letter of the line, which begins with its ends in order.
fn ends_before(mesh: &SurfaceMesh, spokes: &[HalfedgeId], first: Option<HalfedgeId>) -> Option<[VertexId; 2]> {
    let (last, first) = (*spokes.last()?, first?);
    let ends = mesh.ends(last);
    let forward = next_ends(mesh, last, ends, first)?;
    Some(if forward == mesh.ends(first) { ends } else { [ends[1], ends[0]] })
}

/// The normal of a pin's triangle, towards someone for whom left is left: from the letter by which the line came in, or the
/// one by which it leaves.
fn inside_normal(
    mesh: &SurfaceMesh,
    pin_triangle: crate::ids::TriangleId,
    entry: Option<(HalfedgeId, [VertexId; 2])>,
    first_letter: Option<HalfedgeId>,
    route: &Route,
    pin: usize,
) -> DVec3 {
    let (triangle, left, right, apex, sign) = match (entry, first_letter) {
        (Some((letter, [left, right])), _) => match mesh.twin(letter) {
            Some(entered) => (entered.triangle(), left, right, mesh.apex(entered), 1.0),
            None => return DVec3::ZERO,
        },
        (None, Some(letter)) if route.legs.get(pin).is_some() => {
            let [left, right] = mesh.ends(letter);
            (letter.triangle(), left, right, mesh.apex(letter), -1.0)
        }
        _ => {
            let [a, b, c] = mesh.corners(pin_triangle);
            (pin_triangle, a, b, c, 1.0)
        }
    };
    let _ = triangle;
    let l = mesh.position(left);
    (sign * (mesh.position(right) - l).cross(mesh.position(apex) - l)).normalize_or_zero()
}

/// The unit vector in the surface to the left of a segment, from what its ends hang on.
fn segment_left(segment: DVec3, from: &Hold, to: &Hold) -> DVec3 {
    let square = segment.length_squared();
    if square == 0.0 {
        return DVec3::ZERO;
    }
    let across = |hold: &Hold| match hold {
        Hold::Edge { across } => {
            let side = *across - segment * (across.dot(segment) / square);
            Some((side.length() / across.length().max(f64::MIN_POSITIVE), side))
        }
        Hold::Inside { normal } => Some((0.5, normal.cross(segment) / square.sqrt())),
        Hold::Vertex { .. } => None,
    };
    // The edge that lies most across the segment tells best.
    let best = match (across(from), across(to)) {
        (Some(a), Some(b)) => {
            if a.0 >= b.0 {
                a.1
            } else {
                b.1
            }
        }
        (Some(a), None) => a.1,
        (None, Some(b)) => b.1,
        (None, None) => DVec3::ZERO,
    };
    best.normalize_or_zero()
}

fn turn_angle(mesh: &SurfaceMesh, node: &Node, hold: &Hold, way_in: DVec3, way_out: DVec3) -> f64 {
    match hold {
        Hold::Edge { across } => angle_between(*across, way_in) - angle_between(*across, way_out),
        Hold::Inside { normal } => normal.dot(way_in.cross(way_out)).atan2(way_in.dot(way_out)),
        Hold::Vertex { vertex, spokes, is_left } => {
            let far = |spoke: HalfedgeId| {
                let [a, b] = mesh.ends(spoke);
                mesh.position(if a == *vertex { b } else { a }) - node.position
            };
            let (Some(&first), Some(&last)) = (spokes.first(), spokes.last()) else { return 0.0 };
            let inner: f64 = spokes[1..].iter().map(|&h| corner_angle(mesh, h.triangle(), *vertex)).sum();
            let own = angle_between(-way_in, far(first)) + inner + angle_between(far(last), way_out);
            // The strip passes on the right of a vertex that is the left end of its spokes.
            if *is_left { own - std::f64::consts::PI } else { std::f64::consts::PI - own }
        }
    }
}
