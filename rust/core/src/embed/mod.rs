//! Lines put into the mesh: which vertices they add, into which pieces they cut the triangles that they meet, and the
//! chain of edges that each becomes.
//!
//! Only what the lines touch is looked at; arrays of the whole mesh are made in `cut`. Inside one triangle everything is
//! decided exactly (`arrangement`); between triangles, by the order of parameters along the edges.

pub mod arrangement;
pub mod crossings;
pub mod cut;
pub mod fewest;
pub mod loops;
pub mod nodes;
pub mod polygon_pieces;
pub mod rings;
pub mod spacing;
pub mod triangulation;

use std::collections::{BTreeMap, BTreeSet, HashMap};

use glam::DVec2;

use crate::error::{Error, OptionError, Result};
use crate::ids::TriangleId;
use crate::mesh::SurfaceMesh;
use crate::polyline::Polyline;
use crate::spot::in_triangle;
use crate::surface_point::SurfacePoint;

use arrangement::Arrangement;
use nodes::{NewVertex, Nodes, distance_from_segment};
use spacing::{Chains, keep_apart};
use triangulation::Row;

/// Barycentric distance within which points of a line go to a vertex, an edge or each other. In the float32 coordinates
/// of other programs, vertices of a fine scan that are nearer than this to each other would fall together.
pub const DEFAULT_TOLERANCE: f64 = 1e-3;

/// Larger ones would let the snapping of one end of an edge reach the other.
pub const LARGEST_TOLERANCE: f64 = 0.25;

/// Smaller ones are taken for this: parameters that differ by less are rounding.
const SMALLEST_TOLERANCE: f64 = 1e-12;

/// A vertex on a line.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct ChainPoint {
    /// Number of the vertex: of the mesh, or of a new one.
    pub vertex: u32,
    /// Where on the line: the number of the segment and how far along it.
    pub parameter: f64,
}

/// A mesh triangle that was cut, and its pieces.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct CutTriangle {
    /// Which.
    pub triangle: TriangleId,
    /// Its pieces, turned as it is; at least two.
    pub pieces: Vec<[u32; 3]>,
}

/// See the module.
#[derive(Debug)]
pub struct Embedding {
    /// New vertices; the first has the number of the mesh's vertices.
    pub new: Vec<NewVertex>,
    /// Triangles that were cut, by number.
    pub cut: Vec<CutTriangle>,
    /// For each line the vertices along it, consecutive ones joined by an edge; a closed one does not repeat its first.
    pub chains: Vec<Vec<ChainPoint>>,
    /// For each line whether it is closed.
    pub closed: Vec<bool>,
    /// Points of lines that were moved.
    pub snapped: usize,
    /// How far a vertex of a chain is from its line at most, as a part of the sides of an equilateral triangle onto which its
    /// triangle is laid.
    pub largest_move: f64,
    /// Triangles that hold a segment of a line, by number.
    pub visited: Vec<u32>,
}

/// How a segment becomes a chain.
enum Way {
    /// Its ends fell together.
    Point,
    /// Along a mesh edge.
    Edge,
    /// As one of the chains in its triangle.
    Across(usize),
}

impl Embedding {
    /// Puts `lines`, all of `mesh`, into it. `tolerance` is barycentric, from 0 to [`LARGEST_TOLERANCE`].
    ///
    /// # Errors
    /// A tolerance out of range. [`Error::Tangled`] where rounding made the segments in a triangle cross for ever, which
    /// has not been seen.
    ///
    /// Cost: O(n log n) in the points of the lines, and the square of how many segments share a triangle; on a mesh with
    /// walls, once through its triangles where a line runs into one.
    pub fn new(mesh: &SurfaceMesh, lines: &[&Polyline], tolerance: f64) -> Result<Self> {
        if !(0.0..=LARGEST_TOLERANCE).contains(&tolerance) {
            let message = format!("found {tolerance}, expected a part of an edge from 0 to {LARGEST_TOLERANCE}");
            return Err(OptionError::new("tolerance", message).into());
        }
        let tolerance = tolerance.max(SMALLEST_TOLERANCE);
        let mut nodes = Nodes::gather(mesh, lines, tolerance);
        let mut works: BTreeMap<u32, Chains> = BTreeMap::new();
        let ways: Vec<Vec<Way>> = lines
            .iter()
            .zip(&nodes.of_points)
            .map(|(line, ids)| sort_segments(&nodes, line, ids, &mut works))
            .collect();
        keep_apart(mesh, &mut nodes, &mut works, tolerance);
        let mut routes = find_routes(&nodes, lines, &ways, &works);
        let numbers = nodes.renumber(routes.iter().flatten().flatten().copied());
        let all = routes.iter_mut().flatten().flatten().chain(works.values_mut().flatten().flatten());
        all.for_each(|vertex| *vertex = nodes.renumbered(&numbers, *vertex));
        let mut new = nodes.new.clone();
        let mut cut = Vec::with_capacity(works.len());
        let mut bends = HashMap::new();
        for t in find_triangles(mesh, &nodes) {
            let chains = works.get(&t).map_or(&[][..], Vec::as_slice);
            let pieces = arrange(mesh, &nodes, TriangleId(t), chains, &mut new, &mut bends)?;
            if pieces.len() > 1 {
                cut.push(CutTriangle { triangle: TriangleId(t), pieces });
            }
        }
        let mut largest_move: f64 = 0.0;
        let mut chains = Vec::with_capacity(lines.len());
        for ((line, routes), ids) in lines.iter().zip(&routes).zip(&nodes.of_points) {
            let mut chain = vec![ChainPoint { vertex: ids[0], parameter: 0.0 }];
            for (i, (route, &triangle)) in routes.iter().zip(&line.segment_triangles).enumerate() {
                let points = [i, (i + 1) % ids.len()].map(|at| in_triangle(mesh, &line.surface_points[at], triangle));
                let route = route.iter().map(|&vertex| (vertex, nodes.row(mesh, triangle, vertex)));
                let route: Vec<_> = route.collect();
                for (vertex, row) in with_bends(&route, &new, &bends, mesh.positions().len()) {
                    largest_move = largest_move.max(distance_from_segment(row, points[0], points[1]));
                    let last = chain[chain.len() - 1];
                    if last.vertex != vertex {
                        // A vertex that drew the line to itself may lie a little behind the one before.
                        let parameter = i as f64 + part_of(row, route[0].1, route[route.len() - 1].1);
                        chain.push(ChainPoint { vertex, parameter: parameter.max(last.parameter) });
                    }
                }
            }
            if line.closed && chain.len() > 1 && chain[0].vertex == chain[chain.len() - 1].vertex {
                chain.pop();
            }
            chains.push(chain);
        }
        let closed = lines.iter().map(|line| line.closed).collect();
        let mut visited: Vec<u32> = lines.iter().flat_map(|line| &line.segment_triangles).map(|t| t.0).collect();
        visited.sort_unstable();
        visited.dedup();
        Ok(Self { new, cut, chains, closed, snapped: nodes.snapped, largest_move, visited })
    }

    /// The edges of a line, in its direction.
    pub fn edges_of(&self, line: usize) -> impl Iterator<Item = [u32; 2]> + '_ {
        let chain = &self.chains[line];
        let count = if self.closed[line] && chain.len() > 2 { chain.len() } else { chain.len() - 1 };
        (0..count).map(move |i| [chain[i].vertex, chain[(i + 1) % chain.len()].vertex])
    }

    /// The edges of all lines, each once, lower end first, in order.
    pub fn line_edges(&self) -> Vec<[u32; 2]> {
        let all = (0..self.chains.len()).flat_map(|line| self.edges_of(line)).map(|[a, b]| [a.min(b), a.max(b)]);
        let mut edges: Vec<_> = all.collect();
        edges.sort_unstable();
        edges.dedup();
        edges
    }
}

/// How each segment of a line becomes a chain; those across triangles are added to the works.
fn sort_segments(nodes: &Nodes, line: &Polyline, ids: &[u32], works: &mut BTreeMap<u32, Chains>) -> Vec<Way> {
    let way = |(i, triangle): (usize, &TriangleId)| {
        let (a, b) = (ids[i], ids[(i + 1) % ids.len()]);
        if a == b {
            return Way::Point;
        }
        if nodes.common_edge(a, b).is_some() {
            return Way::Edge;
        }
        let chains = works.entry(triangle.0).or_default();
        chains.push(vec![a, b]);
        Way::Across(chains.len() - 1)
    };
    line.segment_triangles.iter().enumerate().map(way).collect()
}

/// For each line and each of its segments the vertices from end to end, those between two on one edge included. A line of
/// one point has one segment.
fn find_routes(
    nodes: &Nodes,
    lines: &[&Polyline],
    ways: &[Vec<Way>],
    works: &BTreeMap<u32, Chains>,
) -> Vec<Vec<Vec<u32>>> {
    let of_line = |((line, ways), ids): ((&&Polyline, &Vec<Way>), &Vec<u32>)| {
        if ways.is_empty() {
            return vec![ids.clone()];
        }
        let of_segment = |(i, way): (usize, &Way)| {
            let ends = [ids[i], ids[(i + 1) % ids.len()]];
            let chain = match way {
                Way::Point => &ends[..1],
                Way::Edge => &ends[..],
                Way::Across(chain) => &works[&line.segment_triangles[i].0][*chain],
            };
            let mut route = vec![chain[0]];
            for pair in chain.windows(2) {
                route.extend(nodes.between(pair[0], pair[1]));
                route.push(pair[1]);
            }
            route
        };
        ways.iter().enumerate().map(of_segment).collect()
    };
    lines.iter().zip(ways).zip(&nodes.of_points).map(of_line).collect()
}

/// The triangles with new vertices on their edges or inside, or with a side on a line, in order.
fn find_triangles(mesh: &SurfaceMesh, nodes: &Nodes) -> BTreeSet<u32> {
    let mut found: BTreeSet<u32> = BTreeSet::new();
    let mut walls: BTreeSet<[u32; 2]> = BTreeSet::new();
    let has_walls = mesh.adjacency().edge_counts().wall_edges > 0;
    for vertex in &nodes.new {
        let own = vertex.point.triangle;
        found.insert(own.0);
        let Some((ends, _)) = vertex.edge else { continue };
        let side = own.halfedges().into_iter().find(|&h| mesh.sorted_ends(h).map(|v| v.0) == ends);
        match side.and_then(|h| mesh.twin(h)) {
            Some(twin) => {
                found.insert(twin.triangle().0);
            }
            None if has_walls => {
                walls.insert(ends);
            }
            None => {}
        }
    }
    if !walls.is_empty() {
        for (t, &[a, b, c]) in mesh.triangles().iter().enumerate() {
            if [[a, b], [b, c], [c, a]].iter().any(|&[p, q]| walls.contains(&[p.min(q), p.max(q)])) {
                found.insert(t as u32);
            }
        }
    }
    found
}

/// Vertices between two that are joined by a piece of a line, where rounding made them; by the triangle's piece, lower end
/// first.
type Bends = HashMap<[u32; 2], Vec<u32>>;

/// Cuts one triangle along the chains in it.
fn arrange(
    mesh: &SurfaceMesh,
    nodes: &Nodes,
    triangle: TriangleId,
    chains: &[Vec<u32>],
    new: &mut Vec<NewVertex>,
    bends: &mut Bends,
) -> Result<Vec<[u32; 3]>> {
    let corners = mesh.corners(triangle).map(|v| v.0);
    let mut numbers = corners.to_vec();
    let mut sides: [Vec<Row>; 3] = Default::default();
    for (k, rows) in sides.iter_mut().enumerate() {
        for (t, vertex) in nodes.along(corners[k], corners[(k + 1) % 3]) {
            let mut row = [0.0; 3];
            (row[k], row[(k + 1) % 3]) = (1.0 - t, t);
            rows.push(row);
            numbers.push(vertex);
        }
    }
    let own = nodes.inside.get(&triangle.0).map_or(&[][..], Vec::as_slice);
    let inside: Vec<Row> = own.iter().map(|&vertex| nodes.row(mesh, triangle, vertex)).collect();
    numbers.extend(own);
    let local: HashMap<u32, u32> = numbers.iter().zip(0..).map(|(&number, i)| (number, i)).collect();
    let mut pieces: Vec<[u32; 2]> = chains.iter().flat_map(|chain| chain.windows(2)).map(|p| [p[0], p[1]]).collect();
    pieces.retain(|&[a, b]| nodes.common_edge(a, b).is_none());
    pieces.iter_mut().for_each(|ends| ends.sort_unstable());
    pieces.sort_unstable();
    pieces.dedup();
    let tangled = Error::Tangled { triangle: triangle.index() };
    let mut arrangement = Arrangement::new([&sides[0], &sides[1], &sides[2]], &inside);
    for [a, b] in &pieces {
        // A segment lies in its triangle, so its ends are among the triangle's points.
        let (Some(&a), Some(&b)) = (local.get(a), local.get(b)) else { return Err(tangled) };
        arrangement.add_segment(a, b);
    }
    arrangement.settle(flatten(mesh, triangle)).map_err(|_| tangled)?;
    for &barycentric in &arrangement.rows()[numbers.len()..] {
        numbers.push((mesh.positions().len() + new.len()) as u32);
        new.push(NewVertex { point: SurfacePoint { triangle, barycentric }, edge: None });
    }
    for (segment, ends) in pieces.into_iter().enumerate() {
        let chain = arrangement.chain(segment);
        if chain.len() > 2 {
            bends.insert(ends, chain[1..chain.len() - 1].iter().map(|&p| numbers[p as usize]).collect());
        }
    }
    Ok(arrangement.pieces().iter().map(|piece| piece.map(|p| numbers[p as usize])).collect())
}

/// A route with the vertices that rounding made on it, each with its place in the triangle.
fn with_bends(route: &[(u32, Row)], new: &[NewVertex], bends: &Bends, old: usize) -> Vec<(u32, Row)> {
    let mut found = vec![route[0]];
    for pair in route.windows(2) {
        let (a, b) = (pair[0].0, pair[1].0);
        let between = bends.get(&[a.min(b), a.max(b)]).map_or(&[][..], Vec::as_slice);
        let place = |&vertex: &u32| (vertex, new[vertex as usize - old].point.barycentric);
        if a < b {
            found.extend(between.iter().map(place));
        } else {
            found.extend(between.iter().rev().map(place));
        }
        found.push(pair[1]);
    }
    found
}

/// How far along a segment a point is.
fn part_of(row: Row, start: Row, end: Row) -> f64 {
    let along: Row = std::array::from_fn(|i| end[i] - start[i]);
    let square: f64 = along.iter().map(|x| x * x).sum();
    if square == 0.0 {
        return 1.0;
    }
    ((0..3).map(|i| along[i] * (row[i] - start[i])).sum::<f64>() / square).clamp(0.0, 1.0)
}

/// The corners of a triangle in its own plane.
fn flatten(mesh: &SurfaceMesh, triangle: TriangleId) -> [DVec2; 3] {
    let [a, b, c] = mesh.corners(triangle).map(|v| mesh.position(v));
    let (along, up) = (b - a, c - a);
    let length = along.length();
    let x = up.dot(along) / length;
    [DVec2::ZERO, DVec2::new(length, 0.0), DVec2::new(x, along.cross(up).length() / length)]
}
