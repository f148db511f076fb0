//! skeleton
#![allow(missing_docs, clippy::todo)]
use glam::DVec3;
use crate::{error::*, ids::*, mesh::*, report::*, surface_point::*};
#[derive(Clone, Debug)]
pub struct Polyline { pub closed: bool, pub points: Vec<DVec3>, pub surface_points: Vec<SurfacePoint>, pub segment_triangles: Vec<TriangleId>, pub strip: Vec<TriangleId>, pub report: Report }
impl Polyline {
    pub fn length(&self) -> f64 { todo!() }
    /// One bool a step of the strip (strip.len() - 2 of them, or so).
    pub fn strip_bits(&self) -> Vec<bool> { todo!() }
    pub fn to_bytes(&self) -> Vec<u8> { todo!() }
    pub fn from_bytes(_mesh: &SurfaceMesh, _bytes: &[u8]) -> std::result::Result<Self, OptionError> { todo!() }
}
