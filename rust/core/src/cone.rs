//! Mesh vertices as cones: what a line that passes near one turns.
//!
//! A piecewise flat surface has all its curvature at vertices. A straight line that passes a vertex on the left sees all
//! of the curvature on its right, and none when it passes on the other side: which way it turns, compared with a smooth
//! surface of the same shape, jumps by the vertex's angle defect from one side to the other. Here the curvature of a
//! vertex is spread over the strip of its star's least height, so that the turn goes over from one side to the other
//! without a jump:
//!
//! ```text
//!      turn   defect / 2 .    |\.                 A line through the vertex bisects its angles, which is what both
//!                   .-'  |    |  '-.              sides' limits say: plus or minus defect / 2 from the line of the
//!      ------------'-----+----+-----'---> offset  one side or the other.
//!             -radius    0   radius
//! ```
//!
//! Holds no line: one vertex at a time, and a cache of them.

use std::f64::consts::TAU;

use crate::ids::{HalfedgeId, TriangleId};
use crate::mesh::SurfaceMesh;
use crate::vertex_pass::corner_angle;

/// See the module.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct Cone {
    /// 2 pi less the angles of its triangles, in radians; 0 where a line may not pass over the vertex.
    pub defect: f64,
    /// Least height of its triangles over the sides opposite.
    pub radius: f64,
    /// A third of its triangles' area.
    pub area: f64,
}

impl Cone {
    /// The cone at the vertex that `spoke` begins at. Cost: O(valence).
    fn at(mesh: &SurfaceMesh, spoke: HalfedgeId) -> Self {
        let vertex = mesh.ends(spoke)[0];
        if !mesh.is_passable(vertex) {
            return Self::default();
        }
        let mut cone = Self { defect: TAU, radius: f64::INFINITY, area: 0.0 };
        // Summed from the same triangle on, whichever line asks first, so that all get the same bits.
        let next =
            |here: HalfedgeId| mesh.twin(mesh.other_spoke(here, vertex)).filter(|h| h.triangle() != spoke.triangle());
        let lowest = std::iter::successors(Some(spoke), |&here| next(here)).map(HalfedgeId::triangle).min();
        let first = lowest.into_iter().flat_map(TriangleId::halfedges).find(|&h| mesh.ends(h)[0] == vertex);
        let first = first.unwrap_or(spoke);
        let mut here = first;
        loop {
            let triangle = here.triangle();
            let [a, b, c] = mesh.corners(triangle).map(|v| mesh.position(v));
            let double_area = (b - a).cross(c - a).length();
            let opposite = triangle.halfedges().into_iter().find(|&h| !mesh.touches(h, vertex));
            let base = opposite.map_or(0.0, |h| mesh.edge_length(h));
            cone.defect -= corner_angle(mesh, triangle, vertex);
            cone.area += double_area / 6.0;
            cone.radius = cone.radius.min(double_area / base);
            match mesh.twin(mesh.other_spoke(here, vertex)) {
                Some(next) if next.triangle() != first.triangle() => here = next,
                _ => return cone,
            }
        }
    }

    /// What a line turns that has the vertex `offset` to its left, in radians, positive to the left, for a line that was
    /// unfolded past the vertex. 0 further away than the radius.
    pub fn turn(&self, offset: f64) -> f64 {
        let nearness = 1.0 - offset.abs() / self.radius;
        // Not a number where the star has no height.
        if nearness > 0.0 { 0.5 * self.defect * nearness * offset.signum() } else { 0.0 }
    }
}

/// Cones that were asked for, each measured once.
#[derive(Clone, Debug, Default)]
pub struct Cones {
    /// For each mesh vertex 1 + its place in `known`, 0 for none: zeroed memory that is not touched costs nothing.
    places: Vec<u32>,
    known: Vec<Cone>,
}

impl Cones {
    /// The cone at the vertex that `spoke` begins at.
    pub fn get(&mut self, mesh: &SurfaceMesh, spoke: HalfedgeId) -> Cone {
        let vertex = mesh.ends(spoke)[0].index();
        if self.places.is_empty() {
            self.places = vec![0; mesh.positions().len()];
        }
        if self.places[vertex] == 0 {
            self.known.push(Cone::at(mesh, spoke));
            self.places[vertex] = self.known.len() as u32;
        }
        self.known[self.places[vertex] as usize - 1]
    }
}
