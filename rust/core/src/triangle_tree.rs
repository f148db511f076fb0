//! The tree of boxes over the triangles of a mesh, in the order of the Morton curve.
//!
//! Built when a mesh is first asked for a closest point or a ray. Holds no search: those are in `closest_point` and
//! `ray_cast`.
//!
//! Source: G. Morton 1966 for the order.

use glam::DVec3;

use crate::ids::TriangleId;
use crate::mesh::SurfaceMesh;

/// Triangles in a leaf. Measured on a scan of 269k triangles: 1 to 8 take the same time within the noise.
pub(crate) const LEAF: usize = 4;

/// Boxes below each box.
pub(crate) const BRANCHES: usize = 8;

/// Rounding of a point that is a sum of three weighted corners, relative to the largest coordinate.
pub(crate) const POINT_ROUNDING: f64 = 8.0 * f64::EPSILON;

/// Takes the rounding of a squared distance off, so that the distance to a box is never above that to what is in it.
const BELOW: f64 = 1.0 - 16.0 * f64::EPSILON;

/// A box with sides along the axes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bounds {
    pub low: DVec3,
    pub high: DVec3,
}

/// The tree. Level 0 are the boxes of the leaves; each further level has one box for `BRANCHES` of the one before.
#[derive(Debug)]
pub struct TriangleTree {
    pub(crate) levels: Vec<Vec<Bounds>>,
    /// Largest coordinate of a corner: what rounding is relative to.
    pub(crate) extent: f64,
}

impl Bounds {
    const EMPTY: Self = Self { low: DVec3::INFINITY, high: DVec3::NEG_INFINITY };

    #[inline]
    pub fn of_triangle(mesh: &SurfaceMesh, triangle: TriangleId) -> Self {
        Self::of_corners(mesh.corners(triangle).map(|v| mesh.position(v)))
    }

    #[inline]
    pub fn of_corners([a, b, c]: [DVec3; 3]) -> Self {
        Self { low: a.min(b).min(c), high: a.max(b).max(c) }
    }

    #[inline]
    pub fn grown(self, by: DVec3) -> Self {
        Self { low: self.low - by, high: self.high + by }
    }

    fn join(self, other: Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    /// Squared distance to the box, 0 inside.
    #[inline]
    pub fn square_to(&self, p: DVec3) -> f64 {
        (self.low - p).max(p - self.high).max(DVec3::ZERO).length_squared() * BELOW
    }
}

impl TriangleTree {
    /// The tree over the triangles of a mesh. Cost: O(triangles); 14 bytes a triangle are kept.
    pub fn new(mesh: &SurfaceMesh) -> Self {
        let count = mesh.triangles().len();
        let mut extent = 0.0f64;
        let mut leaves = Vec::with_capacity(count.div_ceil(LEAF));
        for start in (0..count).step_by(LEAF) {
            let mut bounds = Bounds::EMPTY;
            for place in start..count.min(start + LEAF) {
                bounds = bounds.join(Bounds::of_triangle(mesh, mesh.dual_graph().triangle_at(place)));
            }
            extent = extent.max(bounds.low.abs().max(bounds.high.abs()).max_element());
            leaves.push(bounds);
        }
        // A point of a triangle is rounded, so it may lie a little outside of the box of the corners.
        let slack = DVec3::splat(POINT_ROUNDING * extent);
        for bounds in &mut leaves {
            *bounds = bounds.grown(slack);
        }
        let mut levels = vec![leaves];
        while let Some(last) = levels.last().filter(|level| level.len() > 1) {
            let above = last.chunks(BRANCHES).map(|c| c.iter().copied().fold(Bounds::EMPTY, Bounds::join)).collect();
            levels.push(above);
        }
        Self { levels, extent }
    }
}
