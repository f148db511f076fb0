//! Lines put into the mesh: which vertices they add, into which pieces they cut the triangles that they meet, and the
//! chain of edges that each becomes.
//!
//! Only what the lines touch is looked at; arrays of the whole mesh are made in `cut`. Inside one triangle everything is
//! decided exactly (`arrangement`); between triangles, by the order of parameters along the edges.

pub mod arrangement;
pub mod crossings;
pub mod cut;
pub mod loops;
pub mod nodes;
pub mod paths;
pub mod polygon_pieces;
pub mod rings;
pub mod triangulation;

use std::collections::{BTreeMap, BTreeSet};

use glam::DVec2;

use crate::error::{Error, OptionError, Result};
use crate::ids::TriangleId;
use crate::mesh::SurfaceMesh;
use crate::polyline::Polyline;
use crate::surface_point::SurfacePoint;

use arrangement::Arrangement;
use nodes::{NewVertex, Nodes};
use paths::{Path, find_paths};
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
    /// Triangles that hold a segment of a line, by number.
    pub visited: Vec<u32>,
}

/// What happens in one triangle.
#[derive(Default)]
struct Work {
    inside: Vec<u32>,
    segments: Vec<[u32; 2]>,
}

/// What becomes of one triangle.
struct Arranged {
    pieces: Vec<[u32; 3]>,
    /// For each segment the points between its ends, parameters from 0 to 1.
    chains: Vec<Vec<ChainPoint>>,
}

/// How a segment becomes a chain.
enum Way {
    /// Its ends fell together.
    Point,
    /// Along a mesh edge.
    Edge,
    /// As a segment of the work in a triangle.
    Across { triangle: u32, segment: usize },
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
        let paths = find_paths(mesh, lines, tolerance);
        let nodes = Nodes::gather(mesh, &paths, tolerance);
        let mut works = find_works(mesh, &nodes);
        let ways: Vec<Vec<Way>> = paths
            .iter()
            .zip(&nodes.of_points)
            .map(|(line, ids)| sort_segments(mesh, &nodes, line, ids, &mut works))
            .collect();
        let mut new = nodes.new.clone();
        let mut cut = Vec::with_capacity(works.len());
        let mut chains_across: BTreeMap<u32, Vec<Vec<ChainPoint>>> = BTreeMap::new();
        for (&triangle, work) in &works {
            let Arranged { pieces, chains } = arrange(mesh, &nodes, TriangleId(triangle), work, tolerance, &mut new)?;
            if pieces.len() > 1 {
                cut.push(CutTriangle { triangle: TriangleId(triangle), pieces });
            }
            chains_across.insert(triangle, chains);
        }
        let mut chains = Vec::with_capacity(lines.len());
        for ((path, ways), ids) in paths.iter().zip(&ways).zip(&nodes.of_points) {
            let mut chain = vec![ChainPoint { vertex: ids[0], parameter: 0.0 }];
            for (i, way) in ways.iter().enumerate() {
                let (a, b) = (ids[i], ids[(i + 1) % ids.len()]);
                let (start, end) = (path.parameters[i], path.parameters.get(i + 1));
                // The last segment of a closed line ends at the next whole number.
                let end = end.copied().unwrap_or_else(|| start.floor() + 1.0);
                let inner = match way {
                    Way::Point => Vec::new(),
                    Way::Edge => chain_along_edge(mesh, &nodes, a, b),
                    Way::Across { triangle, segment } => chains_across[triangle][*segment].clone(),
                };
                let inner = inner.into_iter().map(|p| (p.vertex, start + (end - start) * p.parameter));
                for (vertex, parameter) in inner.chain([(b, end)]) {
                    let last = chain[chain.len() - 1];
                    if last.vertex != vertex {
                        // A vertex that drew the line to itself may lie a little behind the one before.
                        chain.push(ChainPoint { vertex, parameter: parameter.max(last.parameter) });
                    }
                }
            }
            if path.closed && chain.len() > 1 && chain[0].vertex == chain[chain.len() - 1].vertex {
                chain.pop();
            }
            chains.push(chain);
        }
        let closed = lines.iter().map(|line| line.closed).collect();
        let mut visited: Vec<u32> = lines.iter().flat_map(|line| &line.segment_triangles).map(|t| t.0).collect();
        visited.sort_unstable();
        visited.dedup();
        Ok(Self { new, cut, chains, closed, snapped: nodes.snapped, visited })
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

/// The mesh vertices that a vertex hangs on, where it lies on an edge or is one of the mesh; `None` inside a triangle.
fn ends_of(mesh: &SurfaceMesh, nodes: &Nodes, vertex: u32) -> Option<[u32; 2]> {
    match (vertex as usize).checked_sub(mesh.positions().len()) {
        None => Some([vertex; 2]),
        Some(new) => nodes.new[new].edge.map(|(ends, _)| ends),
    }
}

/// The edge that both vertices lie on, lower end first.
fn common_edge(mesh: &SurfaceMesh, nodes: &Nodes, a: u32, b: u32) -> Option<[u32; 2]> {
    let mut ends = [ends_of(mesh, nodes, a)?, ends_of(mesh, nodes, b)?].concat();
    ends.sort_unstable();
    ends.dedup();
    (ends.len() == 2).then(|| [ends[0], ends[1]])
}

/// How each segment of a line becomes a chain; those across triangles are added to the works.
fn sort_segments(
    mesh: &SurfaceMesh,
    nodes: &Nodes,
    path: &Path,
    ids: &[u32],
    works: &mut BTreeMap<u32, Work>,
) -> Vec<Way> {
    let way = |(i, triangle): (usize, &TriangleId)| {
        let (a, b) = (ids[i], ids[(i + 1) % ids.len()]);
        if a == b {
            return Way::Point;
        }
        if common_edge(mesh, nodes, a, b).is_some() {
            return Way::Edge;
        }
        let work = works.entry(triangle.0).or_default();
        work.segments.push([a, b]);
        Way::Across { triangle: triangle.0, segment: work.segments.len() - 1 }
    };
    path.triangles.iter().enumerate().map(way).collect()
}

/// The triangles with new vertices on their edges or inside.
fn find_works(mesh: &SurfaceMesh, nodes: &Nodes) -> BTreeMap<u32, Work> {
    let mut works: BTreeMap<u32, Work> = BTreeMap::new();
    let mut walls: BTreeSet<[u32; 2]> = BTreeSet::new();
    let has_walls = mesh.adjacency().edge_counts().wall_edges > 0;
    for &(ends, triangle) in &nodes.edges {
        let own = TriangleId(triangle).halfedges().into_iter().find(|&h| mesh.sorted_ends(h).map(|v| v.0) == ends);
        let twin = own.and_then(|h| mesh.twin(h));
        works.entry(triangle).or_default();
        match twin {
            Some(twin) => {
                works.entry(twin.triangle().0).or_default();
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
                works.entry(t as u32).or_default();
            }
        }
    }
    for (i, vertex) in nodes.new.iter().enumerate() {
        if vertex.edge.is_none() {
            works.entry(vertex.point.triangle.0).or_default().inside.push((mesh.positions().len() + i) as u32);
        }
    }
    works
}

/// Cuts one triangle.
fn arrange(
    mesh: &SurfaceMesh,
    nodes: &Nodes,
    triangle: TriangleId,
    work: &Work,
    tolerance: f64,
    new: &mut Vec<NewVertex>,
) -> Result<Arranged> {
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
    let inside: Vec<Row> =
        work.inside.iter().map(|&v| new[v as usize - mesh.positions().len()].point.barycentric).collect();
    numbers.extend(&work.inside);
    let local = |vertex: u32| numbers.iter().position(|&n| n == vertex).map(|i| i as u32);
    // A segment lies in its triangle, so its ends are among the triangle's points.
    let ends = work.segments.iter().map(|&[a, b]| Some([local(a)?, local(b)?])).collect::<Option<Vec<_>>>();
    let ends = ends.ok_or(Error::Tangled { triangle: triangle.index() })?;
    let attempt = |tolerance: f64| {
        let mut arrangement = Arrangement::new([&sides[0], &sides[1], &sides[2]], &inside, tolerance);
        ends.iter().for_each(|&[a, b]| arrangement.add_segment(a, b));
        arrangement.settle(flatten(mesh, triangle)).map(|()| arrangement)
    };
    // Where points that draw segments to themselves send them round in circles, they stop drawing.
    let arrangement =
        attempt(tolerance).or_else(|_| attempt(0.0)).map_err(|_| Error::Tangled { triangle: triangle.index() })?;
    for &barycentric in &arrangement.rows()[numbers.len()..] {
        numbers.push((mesh.positions().len() + new.len()) as u32);
        new.push(NewVertex { point: SurfacePoint { triangle, barycentric }, edge: None });
    }
    let pieces = arrangement.pieces().iter().map(|piece| piece.map(|p| numbers[p as usize])).collect();
    let chains = (0..work.segments.len())
        .map(|segment| {
            let chain = arrangement.chain(segment);
            let (start, end) =
                (arrangement.rows()[chain[0] as usize], arrangement.rows()[chain[chain.len() - 1] as usize]);
            let along: Row = std::array::from_fn(|i| end[i] - start[i]);
            let square: f64 = along.iter().map(|x| x * x).sum();
            let inner = chain.iter().take(chain.len() - 1).skip(1);
            inner
                .map(|&p| {
                    let row = arrangement.rows()[p as usize];
                    let s = (0..3).map(|i| along[i] * (row[i] - start[i])).sum::<f64>() / square;
                    ChainPoint { vertex: numbers[p as usize], parameter: s.clamp(0.0, 1.0) }
                })
                .collect()
        })
        .collect();
    Ok(Arranged { pieces, chains })
}

/// The corners of a triangle in its own plane.
fn flatten(mesh: &SurfaceMesh, triangle: TriangleId) -> [DVec2; 3] {
    let [a, b, c] = mesh.corners(triangle).map(|v| mesh.position(v));
    let (along, up) = (b - a, c - a);
    let length = along.length();
    let x = up.dot(along) / length;
    [DVec2::ZERO, DVec2::new(length, 0.0), DVec2::new(x, along.cross(up).length() / length)]
}

/// The points strictly between two vertices of one edge, from `a` to `b`.
fn chain_along_edge(mesh: &SurfaceMesh, nodes: &Nodes, a: u32, b: u32) -> Vec<ChainPoint> {
    let Some([low, high]) = common_edge(mesh, nodes, a, b) else { return Vec::new() };
    let parameter = |vertex: u32| match (vertex as usize).checked_sub(mesh.positions().len()) {
        None => f64::from(u8::from(vertex == high)),
        Some(new) => nodes.new[new].edge.map_or(0.0, |(_, t)| t),
    };
    let (start, end) = (parameter(a), parameter(b));
    let between = nodes.along(low, high).into_iter().filter(|&(t, _)| t > start.min(end) && t < start.max(end));
    let mut chain: Vec<_> =
        between.map(|(t, vertex)| ChainPoint { vertex, parameter: (t - start) / (end - start) }).collect();
    if start > end {
        chain.reverse();
    }
    chain
}
