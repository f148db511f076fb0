//! A point on the surface: a triangle and barycentric coordinates, and what a caller may pick.
//!
//! Holds the checks of barycentric coordinates; knows nothing of polylines.

use glam::DVec3;

use crate::error::OptionError;
use crate::ids::TriangleId;

/// Most negative barycentric part that is taken for rounding (the contract of `picks`).
pub const BARYCENTRIC_SLACK: f64 = 1e-9;

/// Largest distance of the sum of barycentric parts from 1 that is taken for rounding (the contract of `picks`).
pub const BARYCENTRIC_SUM_SLACK: f64 = 1e-6;

/// A sum this close to 1 is 1 but for the rounding of three parts and two additions.
const SUM_ROUNDING: f64 = 4.0 * f64::EPSILON;

/// A point of the surface. On an edge one part of `barycentric` is exactly 0, on a mesh vertex two are.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct SurfacePoint {
    /// A triangle that holds the point.
    pub triangle: TriangleId,
    /// Weights of its corners; none negative, their sum 1 to rounding.
    pub barycentric: [f64; 3],
}

/// What a caller picks. Ids are wide so that a wrong one can be named.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Pick {
    /// A polygon where the mesh has `triangle_faces`, else a triangle; stands for its middle.
    Face(i128),
    /// A point inside a triangle.
    Point {
        /// Row of `triangles`.
        triangle: i128,
        /// Weights of its corners.
        barycentric: [f64; 3],
    },
}

impl SurfacePoint {
    /// The barycentre of a triangle.
    pub fn barycentre(triangle: TriangleId) -> Self {
        Self { triangle, barycentric: [1.0 / 3.0; 3] }
    }

    /// Clamps and normalises `barycentric`; an error where it is no point of the triangle.
    pub fn checked(triangle: TriangleId, barycentric: [f64; 3], argument: &'static str) -> Result<Self, OptionError> {
        let sum: f64 = barycentric.iter().sum();
        let is_inside = barycentric.iter().all(|&b| b >= -BARYCENTRIC_SLACK);
        let is_whole = (sum - 1.0).abs() <= BARYCENTRIC_SUM_SLACK;
        if !is_inside || !is_whole {
            return Err(OptionError::new(
                argument,
                format!(
                    "the point in triangle {} has barycentric {barycentric:?} with sum {sum}; expected three parts of \
                     at least 0 with sum 1: pass the weights of the triangle's three corners",
                    triangle.0
                ),
            ));
        }
        let clamped = barycentric.map(|b| b.max(0.0));
        let total: f64 = clamped.iter().sum();
        // Parts whose sum is 1 to rounding are kept to the bit: a point read from one line and given to the next is the
        // same. A single part that is not 0 becomes exactly 1: the point is that vertex.
        let is_vertex = clamped.iter().filter(|&&b| b > 0.0).count() == 1;
        let is_normal = (total - 1.0).abs() <= SUM_ROUNDING && !is_vertex;
        let barycentric = if is_normal { clamped } else { clamped.map(|b| b / total) };
        Ok(Self { triangle, barycentric })
    }

    /// Where the point is: `(b0 p0 + b1 p1) + b2 p2`, in that order, which the contract promises to the bit.
    #[inline]
    pub fn position(&self, corners: [DVec3; 3]) -> DVec3 {
        let [b0, b1, b2] = self.barycentric;
        (b0 * corners[0] + b1 * corners[1]) + b2 * corners[2]
    }
}
