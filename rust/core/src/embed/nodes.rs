//! Where lines become vertices of the mesh: points near a vertex or an edge are moved to it, and points that are nearly
//! equal become one.
//!
//! Distances are those in an equilateral triangle with sides of length 1, onto which each triangle is laid: along an edge
//! a part of its length. Holds no segments.

use std::collections::HashMap;

use crate::ids::TriangleId;
use crate::mesh::SurfaceMesh;
use crate::polyline::Polyline;
use crate::spot::{Spot, in_triangle, spot_of};
use crate::surface_point::SurfacePoint;

use super::triangulation::Row;

/// Height of the equilateral triangle with sides of length 1.
pub const HEIGHT: f64 = 0.866_025_403_784_438_6;

/// A vertex that a line adds to the mesh.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct NewVertex {
    /// Where it is; its triangle holds it.
    pub point: SurfacePoint,
    /// The mesh edge that it lies inside, lower end first, and the parameter from there; `None` inside a triangle.
    pub edge: Option<([u32; 2], f64)>,
}

/// The vertices of all points of some lines.
#[derive(Debug, Default)]
pub struct Nodes {
    /// New vertices; the first has the number of the mesh's vertices.
    pub new: Vec<NewVertex>,
    /// For each line and each of its points the vertex.
    pub of_points: Vec<Vec<u32>>,
    /// New vertices on each edge with any, by rising parameter. Looked up, never walked through.
    pub on_edges: HashMap<[u32; 2], Vec<(f64, u32)>>,
    /// New vertices inside each triangle with any. Looked up, never walked through.
    pub inside: HashMap<u32, Vec<u32>>,
    /// Points that were moved to a vertex, an edge or another point that they were not on.
    pub snapped: usize,
    /// Number of the first new vertex.
    old: u32,
}

/// Where a point comes to lie once it is close to nothing but what it lies on.
#[derive(Clone, Copy, PartialEq)]
enum Site {
    Vertex(u32),
    Edge([u32; 2], f64),
    Inside,
}

/// One point of one line.
struct Entry {
    site: Site,
    point: SurfacePoint,
    line: usize,
    index: usize,
}

impl Nodes {
    /// The vertices of `lines`, none nearer than `tolerance` (below a third) to another of the same edge or triangle, those
    /// inside a triangle no nearer than that to its sides.
    pub fn gather(mesh: &SurfaceMesh, lines: &[&Polyline], tolerance: f64) -> Self {
        let mut nodes = Self { old: mesh.positions().len() as u32, ..Self::default() };
        let mut entries: Vec<Entry> = Vec::new();
        for (line, polyline) in lines.iter().enumerate() {
            for (index, point) in polyline.surface_points.iter().enumerate() {
                let (site, moved) = settle_point(mesh, point, tolerance);
                nodes.snapped += usize::from(moved.is_some());
                entries.push(Entry { site, point: moved.unwrap_or(*point), line, index });
            }
        }
        // Equal places side by side; ties in the order of the lines, so that the result does not hang on the sort.
        entries.sort_by(|a, b| key(a).partial_cmp(&key(b)).expect("barycentric parts are numbers"));
        nodes.of_points = lines.iter().map(|line| vec![0; line.surface_points.len()]).collect();
        let mut group_start = 0;
        for (i, entry) in entries.iter().enumerate() {
            if i == 0 || !is_same_group(&entries[i - 1], entry) {
                group_start = nodes.new.len();
            }
            let near = nodes.new[group_start..].iter().rposition(|c| match (entry.site, c.edge) {
                (Site::Edge(_, t), Some((_, other))) => t - other < tolerance,
                _ => distance(c.point.barycentric, entry.point.barycentric) < tolerance,
            });
            nodes.of_points[entry.line][entry.index] = match (entry.site, near) {
                (Site::Vertex(v), _) => v,
                (_, Some(near)) => {
                    let there = nodes.new[group_start + near].point;
                    nodes.snapped += usize::from(
                        there.barycentric != entry.point.barycentric && there.triangle == entry.point.triangle,
                    );
                    nodes.old + (group_start + near) as u32
                }
                (Site::Edge(ends, t), None) => nodes.add(NewVertex { point: entry.point, edge: Some((ends, t)) }),
                (Site::Inside, None) => nodes.add(NewVertex { point: entry.point, edge: None }),
            };
        }
        nodes
    }

    /// Adds a vertex; its number.
    pub fn add(&mut self, vertex: NewVertex) -> u32 {
        let number = self.old + self.new.len() as u32;
        match vertex.edge {
            Some((ends, t)) => {
                let list = self.on_edges.entry(ends).or_default();
                list.insert(list.partition_point(|&(other, _)| other < t), (t, number));
            }
            None => self.inside.entry(vertex.point.triangle.0).or_default().push(number),
        }
        self.new.push(vertex);
        number
    }

    /// Numbers the new vertices anew, in the order in which `used` has them first, and forgets those that it has not.
    /// Returns the new number of each vertex of the old ones; `u32::MAX` for those that are gone.
    pub fn renumber(&mut self, used: impl Iterator<Item = u32>) -> Vec<u32> {
        let mut numbers = vec![u32::MAX; self.new.len()];
        let before = std::mem::take(&mut self.new);
        (self.on_edges, self.inside) = (HashMap::new(), HashMap::new());
        for vertex in used {
            let place = self.place(vertex).filter(|&place| numbers[place] == u32::MAX);
            if let Some(place) = place {
                numbers[place] = self.add(before[place]);
            }
        }
        let old = self.old;
        for vertex in self.of_points.iter_mut().flatten() {
            *vertex = renumbered(&numbers, old, *vertex);
        }
        numbers
    }

    /// The new number of a vertex by what [`Self::renumber`] returned.
    pub fn renumbered(&self, numbers: &[u32], vertex: u32) -> u32 {
        renumbered(numbers, self.old, vertex)
    }

    /// The place of a vertex among the new ones.
    pub fn place(&self, vertex: u32) -> Option<usize> {
        vertex.checked_sub(self.old).map(|place| place as usize)
    }

    /// The new vertices on an edge, from its end `from`, each with its parameter from there.
    pub fn along(&self, from: u32, to: u32) -> Vec<(f64, u32)> {
        let list = self.on_edges.get(&[from.min(to), from.max(to)]).map_or(&[][..], Vec::as_slice);
        if from < to { list.to_vec() } else { list.iter().rev().map(|&(t, v)| (1.0 - t, v)).collect() }
    }

    /// The mesh vertices that a vertex hangs on, where it lies on an edge or is one of the mesh; `None` inside a triangle.
    pub fn ends_of(&self, vertex: u32) -> Option<[u32; 2]> {
        self.place(vertex).map_or(Some([vertex; 2]), |new| self.new[new].edge.map(|(ends, _)| ends))
    }

    /// The edge that both vertices lie on, lower end first.
    pub fn common_edge(&self, a: u32, b: u32) -> Option<[u32; 2]> {
        let mut ends = [self.ends_of(a)?, self.ends_of(b)?].concat();
        ends.sort_unstable();
        ends.dedup();
        (ends.len() == 2).then(|| [ends[0], ends[1]])
    }

    /// The new vertices strictly between two vertices of one edge, from `a` to `b`.
    pub fn between(&self, a: u32, b: u32) -> Vec<u32> {
        let Some([low, high]) = self.common_edge(a, b) else { return Vec::new() };
        let parameter = |vertex: u32| match self.place(vertex) {
            None => f64::from(u8::from(vertex == high)),
            Some(new) => self.new[new].edge.map_or(0.0, |(_, t)| t),
        };
        let (start, end) = (parameter(a), parameter(b));
        let all = self.along(low, high).into_iter();
        let mut found: Vec<u32> =
            all.filter(|&(t, _)| t > start.min(end) && t < start.max(end)).map(|(_, vertex)| vertex).collect();
        if start > end {
            found.reverse();
        }
        found
    }

    /// Barycentric parts of a vertex in a triangle that holds it.
    pub fn row(&self, mesh: &SurfaceMesh, triangle: TriangleId, vertex: u32) -> Row {
        match self.place(vertex) {
            None => mesh.corners(triangle).map(|v| f64::from(u8::from(v.0 == vertex))),
            Some(new) => in_triangle(mesh, &self.new[new].point, triangle),
        }
    }
}

fn renumbered(numbers: &[u32], old: u32, vertex: u32) -> u32 {
    vertex.checked_sub(old).map_or(vertex, |place| numbers[place as usize])
}

/// Distance in the equilateral triangle with sides of length 1.
pub fn distance(a: Row, b: Row) -> f64 {
    ((0..3).map(|i| (a[i] - b[i]) * (a[i] - b[i])).sum::<f64>() / 2.0).sqrt()
}

/// Distance of `p` from the segment from `a` to `b`, likewise.
pub fn distance_from_segment(p: Row, a: Row, b: Row) -> f64 {
    let along: Row = std::array::from_fn(|i| b[i] - a[i]);
    let length: f64 = along.iter().map(|x| x * x).sum();
    if length == 0.0 {
        return distance(p, a);
    }
    let s = ((0..3).map(|i| along[i] * (p[i] - a[i])).sum::<f64>() / length).clamp(0.0, 1.0);
    distance(p, std::array::from_fn(|i| a[i] + s * along[i]))
}

/// The point of side `k` (the side opposite to corner `k`) nearest to a point, as the parameter from corner `k + 1` to
/// corner `k + 2`.
pub fn foot(row: Row, k: usize) -> f64 {
    row[(k + 2) % 3] + row[k] / 2.0
}

/// Vertices first, then by edge and parameter, then by triangle and place in it.
fn key(entry: &Entry) -> (u8, u32, u32, [f64; 3], usize, usize) {
    let (kind, a, b, place) = match entry.site {
        Site::Vertex(v) => (0, v, 0, [0.0; 3]),
        Site::Edge([low, high], t) => (1, low, high, [t, 0.0, 0.0]),
        Site::Inside => (2, entry.point.triangle.0, 0, entry.point.barycentric),
    };
    (kind, a, b, place, entry.line, entry.index)
}

fn is_same_group(a: &Entry, b: &Entry) -> bool {
    match (a.site, b.site) {
        (Site::Edge(one, _), Site::Edge(other, _)) => one == other,
        (Site::Inside, Site::Inside) => a.point.triangle == b.point.triangle,
        _ => false,
    }
}

/// Where a point comes to lie, and the point itself if that is another one.
fn settle_point(mesh: &SurfaceMesh, point: &SurfacePoint, tolerance: f64) -> (Site, Option<SurfacePoint>) {
    let corners = mesh.corners(point.triangle);
    let b = point.barycentric;
    // The side that the point lies on or is nearest to, and where there.
    let (k, t) = match spot_of(mesh, point) {
        Spot::Vertex(v) => return (Site::Vertex(v.0), None),
        Spot::Edge(edge, t) => {
            let ends = mesh.sorted_ends(edge).map(|v| v.0);
            if t >= tolerance && 1.0 - t >= tolerance {
                return (Site::Edge(ends, t), None);
            }
            return (Site::Vertex(ends[usize::from(t > 0.5)]), Some(*point));
        }
        Spot::Inside(_) => {
            let k = (0..3).min_by(|&i, &j| b[i].total_cmp(&b[j])).unwrap_or(0);
            if b[k] * HEIGHT >= tolerance {
                return (Site::Inside, None);
            }
            (k, foot(b, k))
        }
    };
    let (i, j) = ((k + 1) % 3, (k + 2) % 3);
    if t < tolerance || 1.0 - t < tolerance {
        return (Site::Vertex(corners[if t > 0.5 { j } else { i }].0), Some(*point));
    }
    let mut barycentric = [0.0; 3];
    (barycentric[i], barycentric[j]) = (1.0 - t, t);
    let (low, high) = if corners[i] < corners[j] { (i, j) } else { (j, i) };
    let site = Site::Edge([corners[low].0, corners[high].0], barycentric[high]);
    (site, Some(SurfacePoint { triangle: point.triangle, barycentric }))
}
