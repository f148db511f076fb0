//! The mesh after the cut, as arrays: what no line met keeps its row.
//!
//! Row `i` of the triangles is triangle `i`, or the first piece of it; the other pieces come after all of them. The same
//! holds for polygons, which are in the order of their face ids.

use std::collections::{BTreeMap, HashSet};

use glam::DVec3;

use super::Embedding;
use super::polygon_pieces::{PolygonPiece, join_pieces};
use crate::mesh::SurfaceMesh;

/// Triangles after the cut.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct CutTriangles {
    /// Corners of each.
    pub triangles: Vec<[u32; 3]>,
    /// The triangle of the mesh that each is a piece of, or is.
    pub parents: Vec<u32>,
}

/// Polygons after the cut.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct CutPolygons {
    /// Corners of all of them, one after another.
    pub corners: Vec<u32>,
    /// Where each begins in `corners`, and at last their number.
    pub offsets: Vec<u32>,
    /// The face id that each is a piece of, or is.
    pub parents: Vec<u32>,
    /// The polygon that each triangle after the cut belongs to.
    pub of_triangles: Vec<u32>,
    /// Polygons that are not as before: pieces, and those with a new vertex on their outline; in order.
    pub changed: Vec<u32>,
}

impl Embedding {
    /// Places of all vertices, those of the mesh first.
    pub fn positions(&self, mesh: &SurfaceMesh) -> Vec<DVec3> {
        let mut positions = Vec::with_capacity(mesh.positions().len() + self.new.len());
        positions.extend_from_slice(mesh.positions());
        positions.extend(self.new.iter().map(|vertex| mesh.position_of(&vertex.point)));
        positions
    }

    /// The polygon edge that a new vertex lies on, lower end first, and its parameter from there; `None` inside a polygon,
    /// also on a side of its triangles.
    pub fn polygon_edge(&self, mesh: &SurfaceMesh, new: usize) -> Option<([u32; 2], f64)> {
        let (ends, t) = self.new[new].edge?;
        let triangle = self.new[new].point.triangle;
        let side = triangle.halfedges().into_iter().find(|&h| mesh.sorted_ends(h).map(|v| v.0) == ends)?;
        let is_inner = mesh
            .triangle_faces()
            .zip(mesh.twin(side))
            .is_some_and(|(faces, twin)| faces[triangle.index()] == faces[twin.triangle().index()]);
        (!is_inner).then_some((ends, t))
    }

    /// Triangles after the cut.
    pub fn triangles(&self, mesh: &SurfaceMesh) -> CutTriangles {
        let extra: usize = self.cut.iter().map(|cut| cut.pieces.len() - 1).sum();
        let count = mesh.triangles().len();
        let mut triangles = Vec::with_capacity(count + extra);
        triangles.extend_from_slice(mesh.triangles());
        let mut parents: Vec<u32> = Vec::with_capacity(count + extra);
        parents.extend(0..count as u32);
        for cut in &self.cut {
            triangles[cut.triangle.index()] = cut.pieces[0];
            triangles.extend_from_slice(&cut.pieces[1..]);
            parents.extend(std::iter::repeat_n(cut.triangle.0, cut.pieces.len() - 1));
        }
        CutTriangles { triangles, parents }
    }

    /// Polygons after the cut; triangles where the mesh has no `triangle_faces`.
    pub fn polygons(&self, mesh: &SurfaceMesh) -> CutPolygons {
        let Some(polygons) = mesh.polygons() else {
            return self.triangles_as_polygons(mesh);
        };
        let line_edges: HashSet<[u32; 2]> = self.line_edges().into_iter().collect();
        // Rows of the pieces of each cut triangle.
        let mut rows: BTreeMap<u32, Vec<(u32, [u32; 3])>> = BTreeMap::new();
        let mut next = mesh.triangles().len() as u32;
        for cut in &self.cut {
            let list = rows.entry(cut.triangle.0).or_default();
            list.push((cut.triangle.0, cut.pieces[0]));
            for &piece in &cut.pieces[1..] {
                list.push((next, piece));
                next += 1;
            }
        }
        let faces = polygons.faces();
        let touched = self.visited.iter().chain(rows.keys());
        let touched: HashSet<u32> = touched.map(|&t| faces[t as usize]).collect();
        let place = |v: u32| match (v as usize).checked_sub(mesh.positions().len()) {
            None => mesh.positions()[v as usize],
            Some(new) => mesh.position_of(&self.new[new].point),
        };
        let mut made = CutPolygons { of_triangles: vec![0; next as usize], ..CutPolygons::default() };
        made.corners.reserve(mesh.triangles().len() * 3);
        let mut later: Vec<(u32, PolygonPiece, Vec<u32>)> = Vec::new();
        let mut members: Vec<(u32, [u32; 3])> = Vec::new();
        polygons.for_each(|face, own| {
            members.clear();
            if touched.contains(&face) {
                for &t in own {
                    match rows.get(&t) {
                        Some(pieces) => members.extend_from_slice(pieces),
                        None => members.push((t, mesh.triangles()[t as usize])),
                    }
                }
            } else {
                members.extend(own.iter().map(|&t| (t, mesh.triangles()[t as usize])));
            }
            let triangles: Vec<[u32; 3]> = members.iter().map(|m| m.1).collect();
            let plain = (!touched.contains(&face)).then(|| super::loops::outline(&triangles)).flatten();
            if let Some(corners) = plain {
                let polygon = made.push(&corners, face);
                for &t in own {
                    made.of_triangles[t as usize] = polygon;
                }
                return;
            }
            let own_triangles: Vec<[u32; 3]> = own.iter().map(|&t| mesh.triangles()[t as usize]).collect();
            let before = super::loops::outline(&own_triangles);
            let is_line = |a: u32, b: u32| line_edges.contains(&[a, b]);
            let mut pieces = join_pieces(&triangles, is_line, |a, b| place(a).distance(place(b)));
            let order = before.clone().unwrap_or_else(|| own_triangles.as_flattened().to_vec());
            pieces.iter_mut().for_each(|piece| begin_early(&mut piece.corners, &order));
            pieces.sort_by_key(|piece| (place_in(&order, piece.corners[0]), piece.members[0]));
            let is_changed = pieces.len() > 1 || before.as_ref() != Some(&pieces[0].corners);
            for (i, piece) in pieces.into_iter().enumerate() {
                let rows: Vec<u32> = piece.members.iter().map(|&m| members[m as usize].0).collect();
                if i > 0 {
                    later.push((face, piece, rows));
                    continue;
                }
                let polygon = made.push(&piece.corners, face);
                if is_changed {
                    made.changed.push(polygon);
                }
                rows.iter().for_each(|&row| made.of_triangles[row as usize] = polygon);
            }
        });
        for (face, piece, rows) in later {
            let polygon = made.push(&piece.corners, face);
            made.changed.push(polygon);
            rows.iter().for_each(|&row| made.of_triangles[row as usize] = polygon);
        }
        made.offsets.push(made.corners.len() as u32);
        made
    }

    fn triangles_as_polygons(&self, mesh: &SurfaceMesh) -> CutPolygons {
        let CutTriangles { triangles, parents } = self.triangles(mesh);
        let count = triangles.len() as u32;
        let cut = self.cut.iter().map(|cut| cut.triangle.0);
        CutPolygons {
            corners: triangles.into_flattened(),
            offsets: (0..=count).map(|i| 3 * i).collect(),
            parents,
            of_triangles: (0..count).collect(),
            changed: cut.chain(mesh.triangles().len() as u32..count).collect(),
        }
    }
}

impl CutPolygons {
    fn push(&mut self, corners: &[u32], face: u32) -> u32 {
        self.offsets.push(self.corners.len() as u32);
        self.corners.extend_from_slice(corners);
        self.parents.push(face);
        self.parents.len() as u32 - 1
    }
}

/// Place of a vertex in the outline that a polygon had; new ones come last.
fn place_in(order: &[u32], vertex: u32) -> usize {
    order.iter().position(|&v| v == vertex).unwrap_or(usize::MAX)
}

/// Turns the outline so that it begins with the corner that came first before.
fn begin_early(corners: &mut [u32], order: &[u32]) {
    let first = (0..corners.len()).min_by_key(|&i| (place_in(order, corners[i]), corners[i]));
    corners.rotate_left(first.unwrap_or(0));
}
