//! The mesh after the cut, as arrays: what no line met keeps its row.
//!
//! Row `i` of the triangles is triangle `i`, or the first piece of it; the other pieces come after all of them. The same
//! holds for polygons, which are in the order of their face ids.

use std::collections::{BTreeMap, HashMap, HashSet};

use glam::DVec3;

use super::Embedding;
use super::loops::{outline, outline_of_two};
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
        let (rows, row_count) = self.rows_of_pieces(mesh);
        let faces = polygons.faces();
        let mut touched: Vec<u32> = self.visited.iter().chain(rows.keys()).map(|&t| faces[t as usize]).collect();
        touched.sort_unstable();
        touched.dedup();
        let mut touched = touched.into_iter().peekable();
        let joiner = Joiner { mesh, embedding: self, rows, line_edges: self.line_edges().into_iter().collect() };
        let mut made = CutPolygons { of_triangles: vec![0; row_count as usize], ..CutPolygons::default() };
        made.corners.reserve(mesh.triangles().len() * 3);
        let mut later: Vec<(u32, JoinedPiece)> = Vec::new();
        polygons.for_each(|face, own| {
            let is_touched = touched.next_if_eq(&face).is_some();
            if !is_touched && made.push_whole(mesh, face, own) {
                return;
            }
            let (pieces, is_changed) = joiner.join(own);
            let mut pieces = pieces.into_iter();
            if let Some(first) = pieces.next() {
                let polygon = made.push(&first.corners, face, &first.rows);
                if is_changed {
                    made.changed.push(polygon);
                }
            }
            later.extend(pieces.map(|piece| (face, piece)));
        });
        for (face, piece) in later {
            let polygon = made.push(&piece.corners, face, &piece.rows);
            made.changed.push(polygon);
        }
        made.offsets.push(made.corners.len() as u32);
        made
    }

    /// For each cut triangle its pieces with their rows among the triangles after the cut, and how many rows there are.
    fn rows_of_pieces(&self, mesh: &SurfaceMesh) -> (BTreeMap<u32, Vec<Row>>, u32) {
        let mut rows: BTreeMap<u32, Vec<Row>> = BTreeMap::new();
        let mut next = mesh.triangles().len() as u32;
        for cut in &self.cut {
            let list = rows.entry(cut.triangle.0).or_default();
            list.push((cut.triangle.0, cut.pieces[0]));
            list.extend((next..).zip(cut.pieces[1..].iter().copied()));
            next += cut.pieces.len() as u32 - 1;
        }
        (rows, next)
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
    fn push(&mut self, corners: &[u32], face: u32, rows: &[u32]) -> u32 {
        let polygon = self.parents.len() as u32;
        self.offsets.push(self.corners.len() as u32);
        self.corners.extend_from_slice(corners);
        self.parents.push(face);
        rows.iter().for_each(|&row| self.of_triangles[row as usize] = polygon);
        polygon
    }

    /// Adds a polygon that no line met; false where its triangles are none.
    fn push_whole(&mut self, mesh: &SurfaceMesh, face: u32, own: &[u32]) -> bool {
        let corners = |t: u32| mesh.triangles()[t as usize];
        match *own {
            [t] => {
                self.push(&corners(t), face, own);
                true
            }
            [s, t] => outline_of_two(corners(s), corners(t)).map(|outline| self.push(&outline, face, own)).is_some(),
            _ => {
                let triangles: Vec<_> = own.iter().map(|&t| corners(t)).collect();
                outline(&triangles).map(|outline| self.push(&outline, face, own)).is_some()
            }
        }
    }
}

/// A triangle after the cut, by its row.
type Row = (u32, [u32; 3]);

/// A polygon after the cut, and the rows of its triangles.
struct JoinedPiece {
    corners: Vec<u32>,
    rows: Vec<u32>,
}

/// Joins the pieces of polygons that lines met.
struct Joiner<'a> {
    mesh: &'a SurfaceMesh,
    embedding: &'a Embedding,
    rows: BTreeMap<u32, Vec<Row>>,
    line_edges: HashSet<[u32; 2]>,
}

impl Joiner<'_> {
    /// The polygons that the triangles `own` of one polygon become, and whether that is another than it was.
    fn join(&self, own: &[u32]) -> (Vec<JoinedPiece>, bool) {
        let before: Vec<[u32; 3]> = own.iter().map(|&t| self.mesh.triangles()[t as usize]).collect();
        let mut members: Vec<Row> = Vec::new();
        for (&t, &corners) in own.iter().zip(&before) {
            match self.rows.get(&t) {
                Some(pieces) => members.extend_from_slice(pieces),
                None => members.push((t, corners)),
            }
        }
        let triangles: Vec<[u32; 3]> = members.iter().map(|row| row.1).collect();
        let is_line = |a: u32, b: u32| self.line_edges.contains(&[a, b]);
        let length = |a: u32, b: u32| self.place(a).distance(self.place(b));
        let mut pieces = join_pieces(&triangles, is_line, length);
        let whole = outline(&before);
        let order = whole.clone().unwrap_or_else(|| before.as_flattened().to_vec());
        let places: HashMap<u32, usize> = order.iter().enumerate().rev().map(|(i, &v)| (v, i)).collect();
        // New vertices come after all old ones.
        let place_of = |v: u32| places.get(&v).copied().unwrap_or(usize::MAX);
        for PolygonPiece { corners, .. } in &mut pieces {
            let first = (0..corners.len()).min_by_key(|&i| (place_of(corners[i]), corners[i]));
            corners.rotate_left(first.unwrap_or(0));
        }
        pieces.sort_by_key(|piece| (place_of(piece.corners[0]), piece.members[0]));
        let is_changed = pieces.len() > 1 || whole.as_ref() != Some(&pieces[0].corners);
        let named = |piece: PolygonPiece| JoinedPiece {
            corners: piece.corners,
            rows: piece.members.into_iter().map(|m| members[m as usize].0).collect(),
        };
        (pieces.into_iter().map(named).collect(), is_changed)
    }

    fn place(&self, v: u32) -> DVec3 {
        match (v as usize).checked_sub(self.mesh.positions().len()) {
            None => self.mesh.positions()[v as usize],
            Some(new) => self.mesh.position_of(&self.embedding.new[new].point),
        }
    }
}
