//! skeleton
#![allow(missing_docs, clippy::todo)]
use glam::DVec3;
use crate::{error::*, surface_point::*};
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct MeshReport { pub vertices: usize, pub triangles: usize, pub faces: usize, pub edges: usize, pub boundary_edges: usize, pub wall_edges: usize, pub pinched_vertices: usize, pub parts: usize, pub unreferenced_vertices: usize, pub zero_area_triangles: usize }
#[derive(Debug)]
pub struct SurfaceMesh;
impl SurfaceMesh {
    /// `triangle_faces`: the polygon of each triangle.
    pub fn new(_positions: Vec<DVec3>, _triangles: Vec<[u32; 3]>, _triangle_faces: Option<Vec<u32>>) -> std::result::Result<Self, MeshError> { todo!() }
    pub fn report(&self) -> MeshReport { todo!() }
    pub fn positions(&self) -> &[DVec3] { todo!() }
    pub fn triangles(&self) -> &[[u32; 3]] { todo!() }
    /// Where surface points lie when the vertices are at `positions` (one a row of the mesh's own).
    pub fn positions_of(&self, _points: &[SurfacePoint], _positions: &[DVec3]) -> Vec<DVec3> { todo!() }
}
