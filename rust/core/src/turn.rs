//! How far a line turns where it runs through a point of an edge or through a mesh vertex.
//!
//! Turning is to the left as seen in the *winding* of the triangle before the point: counter-clockwise in its own order
//! of corners. Holds no line: only the two directions at the point.

use std::f64::consts::PI;

use glam::DVec3;

use crate::ids::{HalfedgeId, TriangleId, VertexId};
use crate::mesh::SurfaceMesh;
use crate::spot::Spot;
use crate::vertex_pass::{angle_between, corner_angle};

/// A way through a point: a triangle and a direction in its plane.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Heading {
    /// The triangle.
    pub triangle: TriangleId,
    /// Any length.
    pub direction: DVec3,
}

/// A turn of a line at a point.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct Turn {
    /// Radians, positive to the left in the winding of the triangle before the point. At an inner vertex angles are
    /// scaled so that they sum to a full turn.
    pub angle: f64,
    /// Whether the triangle after the point has the other winding.
    pub flips: bool,
}

/// The angle from `u` to `v` in the plane of a triangle, positive counter-clockwise in its winding.
pub fn signed_angle(mesh: &SurfaceMesh, triangle: TriangleId, u: DVec3, v: DVec3) -> f64 {
    u.cross(v).dot(mesh.normal(triangle)).atan2(u.dot(v))
}

/// Whether the winding of the two triangles at a letter is opposite.
#[inline]
pub fn flips_winding(mesh: &SurfaceMesh, letter: HalfedgeId, entered: HalfedgeId) -> bool {
    mesh.ends(letter)[0] == mesh.ends(entered)[0]
}

/// The turn of a line that comes by `before` and leaves by `after` at a point that lies at `spot`.
pub fn turn_at(mesh: &SurfaceMesh, spot: Spot, before: Heading, after: Heading) -> Turn {
    match spot {
        Spot::Vertex(v) => turn_at_vertex(mesh, v, before, after),
        Spot::Edge(edge, _) if before.triangle != after.triangle => turn_at_edge(mesh, edge, before, after),
        _ => {
            let angle = signed_angle(mesh, before.triangle, before.direction, after.direction);
            Turn { angle, flips: false }
        }
    }
}

fn turn_at_edge(mesh: &SurfaceMesh, edge: HalfedgeId, before: Heading, after: Heading) -> Turn {
    let letter = [Some(edge), mesh.twin(edge)].into_iter().flatten().find(|h| h.triangle() == before.triangle);
    let Some((letter, entered)) = letter.and_then(|h| Some((h, mesh.twin(h)?))) else {
        return Turn { angle: 0.0, flips: false };
    };
    let [a, b] = mesh.ends(letter).map(|v| mesh.position(v));
    let along = (b - a).normalize_or_zero();
    // In the frame (along, inwards) of the triangle before: counter-clockwise is from `along` to inwards, for a
    // half-edge runs counter-clockwise round its triangle. After the edge, ahead is against inwards.
    let inwards = |apex: VertexId| {
        let offset = mesh.position(apex) - a;
        (offset - offset.dot(along) * along).normalize_or_zero()
    };
    let (back, ahead) = (inwards(mesh.apex(letter)), inwards(mesh.apex(entered)));
    let angle_of = |x: f64, y: f64| y.atan2(x);
    let arrival = angle_of(before.direction.dot(along), before.direction.dot(back));
    let departure = angle_of(after.direction.dot(along), -after.direction.dot(ahead));
    let angle = wrapped(departure - arrival);
    Turn { angle, flips: flips_winding(mesh, letter, entered) }
}

/// Into -pi..pi.
fn wrapped(angle: f64) -> f64 {
    if angle > PI {
        angle - 2.0 * PI
    } else if angle < -PI {
        angle + 2.0 * PI
    } else {
        angle
    }
}

fn turn_at_vertex(mesh: &SurfaceMesh, vertex: VertexId, before: Heading, after: Heading) -> Turn {
    // Both ways round, from the way back (against `before.direction`) to the way out.
    let spokes: Vec<HalfedgeId> =
        before.triangle.halfedges().into_iter().filter(|&h| mesh.touches(h, vertex)).collect();
    let [first, second] = spokes[..] else { return Turn { angle: 0.0, flips: false } };
    // Counter-clockwise round the vertex leads from the side that leaves it to the side that comes to it.
    let (leaving, coming) = if mesh.ends(first)[0] == vertex { (first, second) } else { (second, first) };
    let back = -before.direction;
    if before.triangle == after.triangle {
        let angle = signed_angle(mesh, before.triangle, before.direction, after.direction);
        return Turn { angle, flips: false };
    }
    let right = sweep(mesh, vertex, coming, back, &after);
    let left = sweep(mesh, vertex, leaving, back, &after);
    match (right, left) {
        (Some(right), Some(left)) => {
            let total = right.angle + left.angle;
            let angle = if total > 0.0 { PI * (right.angle - left.angle) / total } else { 0.0 };
            Turn { angle, flips: right.flips }
        }
        (Some(right), None) => Turn { angle: right.angle - PI, flips: right.flips },
        (None, Some(left)) => Turn { angle: PI - left.angle, flips: left.flips },
        (None, None) => Turn { angle: 0.0, flips: false },
    }
}

/// The angle round `vertex` from direction `back`, in the triangle of `spoke`, over `spoke` and on to the way out.
fn sweep(mesh: &SurfaceMesh, vertex: VertexId, spoke: HalfedgeId, back: DVec3, after: &Heading) -> Option<Turn> {
    let apex = mesh.position(vertex);
    let along = |spoke: HalfedgeId| mesh.position(mesh.other_end(spoke, vertex)) - apex;
    let start = spoke.triangle();
    let mut turn = Turn { angle: angle_between(back, along(spoke)), flips: false };
    let mut spoke = spoke;
    loop {
        let entered = mesh.twin(spoke)?;
        if entered.triangle() == start {
            return None;
        }
        turn.flips ^= flips_winding(mesh, spoke, entered);
        if entered.triangle() == after.triangle {
            turn.angle += angle_between(along(entered), after.direction);
            return Some(turn);
        }
        turn.angle += corner_angle(mesh, entered.triangle(), vertex);
        spoke = mesh.other_spoke(entered, vertex);
    }
}
