//! Where lines become vertices of the mesh: points near a vertex or an edge are moved to it, and points that are nearly
//! equal become one.
//!
//! Distances are barycentric: along an edge a part of its length, inside a triangle a part of its heights. Holds no
//! segments.

use std::collections::HashMap;

use crate::mesh::SurfaceMesh;
use crate::spot::{Spot, spot_of};
use crate::surface_point::SurfacePoint;

use super::arrangement::distance;
use super::paths::Path;

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
    /// New vertices in the order in which lines meet them; the first has the number of the mesh's vertices.
    pub new: Vec<NewVertex>,
    /// For each line and each of its points the vertex.
    pub of_points: Vec<Vec<u32>>,
    /// New vertices on each edge with any, by rising parameter. Looked up, never walked through.
    pub on_edges: HashMap<[u32; 2], Vec<(f64, u32)>>,
    /// The same edges in order, each with a triangle that has it.
    pub edges: Vec<([u32; 2], u32)>,
    /// Points that were moved to a vertex, an edge or another point that they were not on.
    pub snapped: usize,
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

/// A vertex of the mesh, or the place of a new one in a list.
#[derive(Clone, Copy)]
enum Found {
    Old(u32),
    New(usize),
}

impl Nodes {
    /// The vertices of `lines`, nothing closer than `tolerance` (below a third) to anything else along an edge or inside a
    /// triangle.
    pub fn gather(mesh: &SurfaceMesh, lines: &[Path], tolerance: f64) -> Self {
        let mut snapped = 0;
        let mut entries: Vec<Entry> = Vec::new();
        for (line, path) in lines.iter().enumerate() {
            for (index, point) in path.points.iter().enumerate() {
                let (site, moved) = settle_point(mesh, point, tolerance);
                snapped += usize::from(moved.is_some());
                entries.push(Entry { site, point: moved.unwrap_or(*point), line, index });
            }
        }
        // Equal places side by side; ties in the order of the lines, so that the result does not hang on the sort.
        entries.sort_by(|a, b| key(a).partial_cmp(&key(b)).expect("barycentric parts are numbers"));
        let mut found: Vec<Vec<Found>> = lines.iter().map(|line| vec![Found::Old(0); line.points.len()]).collect();
        let mut candidates: Vec<NewVertex> = Vec::new();
        let mut group_start = 0;
        for (i, entry) in entries.iter().enumerate() {
            if i == 0 || !is_same_group(&entries[i - 1], entry) {
                group_start = candidates.len();
            }
            let near = candidates[group_start..].iter().rposition(|c| match (entry.site, c.edge) {
                (Site::Edge(_, t), Some((_, other))) => t - other <= tolerance,
                _ => distance(c.point.barycentric, entry.point.barycentric) <= tolerance,
            });
            found[entry.line][entry.index] = match (entry.site, near) {
                (Site::Vertex(v), _) => Found::Old(v),
                (_, Some(near)) => {
                    snapped += usize::from(
                        candidates[group_start + near].point.barycentric != entry.point.barycentric
                            && candidates[group_start + near].point.triangle == entry.point.triangle,
                    );
                    Found::New(group_start + near)
                }
                (site, None) => {
                    let edge = if let Site::Edge(ends, t) = site { Some((ends, t)) } else { None };
                    candidates.push(NewVertex { point: entry.point, edge });
                    Found::New(candidates.len() - 1)
                }
            };
        }
        Self::number(mesh, &candidates, found, snapped)
    }

    /// Numbers the new vertices in the order in which lines meet them.
    fn number(mesh: &SurfaceMesh, candidates: &[NewVertex], found: Vec<Vec<Found>>, snapped: usize) -> Self {
        let old = mesh.positions().len() as u32;
        let mut nodes = Self { snapped, ..Self::default() };
        let mut numbers = vec![u32::MAX; candidates.len()];
        for line in found {
            let mut vertices = Vec::with_capacity(line.len());
            for point in line {
                vertices.push(match point {
                    Found::Old(v) => v,
                    Found::New(c) => {
                        if numbers[c] == u32::MAX {
                            numbers[c] = old + nodes.new.len() as u32;
                            nodes.new.push(candidates[c]);
                        }
                        numbers[c]
                    }
                });
            }
            nodes.of_points.push(vertices);
        }
        // Candidates are in the order of edges and parameters already.
        for (candidate, &number) in candidates.iter().zip(&numbers) {
            if let Some((ends, t)) = candidate.edge {
                let list = nodes.on_edges.entry(ends).or_default();
                if list.is_empty() {
                    nodes.edges.push((ends, candidate.point.triangle.0));
                }
                list.push((t, number));
            }
        }
        nodes
    }

    /// The new vertices on an edge, from its end `from`, each with its parameter from there.
    pub fn along(&self, from: u32, to: u32) -> Vec<(f64, u32)> {
        let list = self.on_edges.get(&[from.min(to), from.max(to)]).map_or(&[][..], Vec::as_slice);
        if from < to { list.to_vec() } else { list.iter().rev().map(|&(t, v)| (1.0 - t, v)).collect() }
    }
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
    let small: Vec<usize> = (0..3).filter(|&k| b[k] < tolerance).collect();
    match (spot_of(mesh, point), small.as_slice()) {
        (Spot::Vertex(v), _) => (Site::Vertex(v.0), None),
        // On an edge two parts sum to 1, so one more small part means an end.
        (_, [i, j]) => (Site::Vertex(corners[3 - i - j].0), Some(*point)),
        (Spot::Edge(edge, t), _) => (Site::Edge(mesh.sorted_ends(edge).map(|v| v.0), t), None),
        (Spot::Inside(_), &[k]) => {
            let (i, j) = ((k + 1) % 3, (k + 2) % 3);
            let sum = b[i] + b[j];
            let mut barycentric = [0.0; 3];
            (barycentric[i], barycentric[j]) = (b[i] / sum, b[j] / sum);
            let (low, high) = if corners[i] < corners[j] { (i, j) } else { (j, i) };
            let site = Site::Edge([corners[low].0, corners[high].0], barycentric[high]);
            (site, Some(SurfacePoint { triangle: point.triangle, barycentric }))
        }
        (Spot::Inside(_), _) => (Site::Inside, None),
    }
}
