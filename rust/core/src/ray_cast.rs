//! Where rays first meet the surface.
//!
//! Holds the way through the tree of boxes along a ray, and the meeting of a ray with one triangle. Both sides of a
//! triangle are met; a ray through an edge or a vertex meets one of the triangles there and never slips between them.
//! Knows nothing of lines or cameras.
//!
//! Source: S. Woop, C. Benthin, I. Wald 2013, *Watertight Ray/Triangle Intersection* (sections 3 and 4: we compute in
//! double precision throughout, without their fall-back). The test of a box is T. Ize 2013, *Robust BVH Ray Traversal*.

use glam::DVec3;

use crate::closest_point::{POINTS_PER_OBSERVATION, check_point};
use crate::error::{OptionError, Result};
use crate::mesh::SurfaceMesh;
use crate::report::{Observer, Step};
use crate::smooth::go_on;
use crate::surface_point::SurfacePoint;
use crate::triangle_tree::{BRANCHES, Bounds, LEAF, TriangleTree};

/// Makes up for the rounding of a distance to the far side of a box: Ize 2013, section 3.
const FAR: f64 = 1.0 + 4.0 * f64::EPSILON;

/// Where a ray first meets the surface.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct RayHit {
    /// Where it is; one part of `barycentric` is exactly 0 where the ray goes through an edge, as far as doubles tell.
    pub point: SurfacePoint,
    /// From the origin, in the units of the positions, at least 0.
    pub distance: f64,
}

/// A half-line, and what Woop 2013 prepares of it: the axis along which it goes furthest comes last, and a shear lays it
/// upon that axis.
struct Ray {
    origin: DVec3,
    inverse: DVec3,
    axes: [usize; 3],
    shear: DVec3,
}

impl Ray {
    /// `direction` must be of length 1.
    fn new(origin: DVec3, direction: DVec3) -> Self {
        let size = direction.abs();
        let along = if size.x >= size.y && size.x >= size.z {
            0
        } else if size.y >= size.z {
            1
        } else {
            2
        };
        let axes = [(along + 1) % 3, (along + 2) % 3, along];
        let depth = direction[along];
        let shear = DVec3::new(direction[axes[0]] / depth, direction[axes[1]] / depth, 1.0 / depth);
        Self { origin, inverse: direction.recip(), axes, shear }
    }

    /// How far along the ray the box begins, no more than `limit`; `None` where the ray misses it.
    fn enter(&self, bounds: &Bounds, limit: f64) -> Option<f64> {
        let (mut near, mut far) = (0.0f64, limit);
        for axis in 0..3 {
            // Where the ray runs in the plane of a side this is 0 times infinity: NaN, which `max` and `min` pass over.
            let low = (bounds.low[axis] - self.origin[axis]) * self.inverse[axis];
            let high = (bounds.high[axis] - self.origin[axis]) * self.inverse[axis];
            near = near.max(low.min(high));
            far = far.min(low.max(high) * FAR);
        }
        (near <= far).then_some(near)
    }

    /// The distance and the weights of the corners where the ray meets a triangle.
    fn meet(&self, corners: [DVec3; 3]) -> Option<(f64, [f64; 3])> {
        let [[ax, ay, az], [bx, by, bz], [cx, cy, cz]] = corners.map(|corner| {
            let p = corner - self.origin;
            let [x, y, z] = self.axes.map(|axis| p[axis]);
            [x - self.shear.x * z, y - self.shear.y * z, self.shear.z * z]
        });
        // The same edge from its two sides gives the same number with the other sign, so no ray slips between.
        let weights = [cx * by - cy * bx, ax * cy - ay * cx, bx * ay - by * ax];
        if weights.iter().any(|&w| w < 0.0) && weights.iter().any(|&w| w > 0.0) {
            return None;
        }
        let sum = weights[0] + weights[1] + weights[2];
        // Seen from its edge, or without an area.
        if sum == 0.0 {
            return None;
        }
        let parts = weights.map(|w| w / sum);
        let distance = parts[0] * az + parts[1] * bz + parts[2] * cz;
        (distance >= 0.0).then_some((distance, parts))
    }
}

impl TriangleTree {
    /// The first meeting of one ray; of equally near triangles the lowest. `direction` must be of length 1.
    fn first_hit(&self, mesh: &SurfaceMesh, origin: DVec3, direction: DVec3) -> Option<RayHit> {
        let ray = Ray::new(origin, direction);
        let mut best: Option<RayHit> = None;
        let limit = |best: &Option<RayHit>| best.map_or(f64::INFINITY, |hit| hit.distance * FAR);
        // Boxes that are still to be looked at: where the ray enters, level, place in the level; the nearest last.
        let mut stack: Vec<(f64, u32, u32)> = Vec::with_capacity(BRANCHES * self.levels.len());
        let top = self.levels.len() - 1;
        stack.extend(
            self.levels[top].first().and_then(|b| ray.enter(b, f64::INFINITY)).map(|near| (near, top as u32, 0)),
        );
        while let Some((near, level, place)) = stack.pop() {
            if near > limit(&best) {
                continue;
            }
            let (level, place) = (level as usize, place as usize);
            if level == 0 {
                for i in place * LEAF..((place + 1) * LEAF).min(mesh.triangles().len()) {
                    let triangle = mesh.dual_graph().triangle_at(i);
                    let Some((distance, barycentric)) =
                        ray.meet(mesh.corners(triangle).map(|vertex| mesh.position(vertex)))
                    else {
                        continue;
                    };
                    let is_first = best.is_none_or(|old| {
                        distance < old.distance || distance == old.distance && triangle < old.point.triangle
                    });
                    if is_first {
                        best = Some(RayHit { point: SurfacePoint { triangle, barycentric }, distance });
                    }
                }
                continue;
            }
            let below = &self.levels[level - 1];
            let first = stack.len();
            for (child, bounds) in below.iter().enumerate().skip(place * BRANCHES).take(BRANCHES) {
                stack.extend(ray.enter(bounds, limit(&best)).map(|near| (near, level as u32 - 1, child as u32)));
            }
            stack[first..].sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(b.2.cmp(&a.2)));
        }
        best
    }
}

impl SurfaceMesh {
    /// Where the rays from `origins` along `directions` (of any length but 0) first meet the surface, from either side:
    /// one entry for each ray, `None` where it meets nothing. The first call builds a tree, at O(triangles).
    ///
    /// Triangles without area are never met. Of equally near ones the lowest is told.
    ///
    /// # Errors
    /// Unequal counts; a row that is not finite, or beyond 1e150; a direction of length 0. The messages name
    /// `origins` or `directions`. [`crate::Error::Interrupted`].
    pub fn ray_cast(
        &self,
        origins: &[DVec3],
        directions: &[DVec3],
        observer: &mut dyn Observer,
    ) -> Result<Vec<Option<RayHit>>> {
        if origins.len() != directions.len() {
            let problem = format!(
                "found {} rows for {} rows of origins, expected one direction for each origin; pass as many",
                directions.len(),
                origins.len()
            );
            return Err(OptionError::new("directions", problem).into());
        }
        let mut hits = Vec::with_capacity(origins.len());
        for (row, (&origin, &direction)) in origins.iter().zip(directions).enumerate() {
            if row % POINTS_PER_OBSERVATION == 0 {
                go_on(observer, Step::Search)?;
            }
            check_point(row, origin, "origins")?;
            check_point(row, direction, "directions")?;
            // Scaled first, so that no square overflows or vanishes.
            let direction = direction / direction.abs().max_element();
            if !direction.is_finite() {
                let problem = format!("row {row} has no length, expected a direction; correct or leave out that row");
                return Err(OptionError::new("directions", problem).into());
            }
            hits.push(if self.triangles().is_empty() {
                None
            } else {
                self.triangle_tree().first_hit(self, origin, direction.normalize())
            });
        }
        Ok(hits)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ids::TriangleId;
    use crate::report::NoObserver;

    fn square() -> SurfaceMesh {
        let positions = [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]].map(|[x, y]| DVec3::new(x, y, 0.0)).to_vec();
        SurfaceMesh::new(positions, vec![[0, 1, 2], [0, 2, 3]], None).expect("a square")
    }

    fn cast(mesh: &SurfaceMesh, origin: [f64; 3], direction: [f64; 3]) -> Option<RayHit> {
        mesh.ray_cast(&[origin.into()], &[direction.into()], &mut NoObserver).expect("a ray")[0]
    }

    #[test]
    fn from_both_sides_and_past_it() {
        for (z, down) in [(3.0, -5.0), (-3.0, 1e-3)] {
            let hit = cast(&square(), [1.5, 0.5, z], [0.0, 0.0, down]).expect("met");
            assert_eq!(hit.point, SurfacePoint { triangle: TriangleId(0), barycentric: [0.25, 0.5, 0.25] });
            assert_eq!(hit.distance, 3.0);
        }
        assert_eq!(cast(&square(), [1.5, 0.5, 3.0], [0.0, 0.0, 1.0]), None, "behind the origin");
        assert_eq!(cast(&square(), [2.5, 0.5, 3.0], [0.0, 0.0, -1.0]), None, "beside the square");
        assert_eq!(cast(&square(), [-1.0, 0.5, 0.0], [1.0, 0.0, 0.0]), None, "in its plane");
        assert_eq!(cast(&square(), [1.5, 0.5, 0.0], [0.0, 0.0, 1.0]).expect("from the surface").distance, 0.0);
    }

    #[test]
    fn edges_and_vertices_let_nothing_through() {
        let at_edge = cast(&square(), [1.0, 1.0, 1.0], [0.0, 0.0, -1.0]).expect("the diagonal");
        assert_eq!(at_edge.point, SurfacePoint { triangle: TriangleId(0), barycentric: [0.5, 0.0, 0.5] });
        assert!(cast(&square(), [0.0, 0.0, 1.0], [0.0, 0.0, -1.0]).is_some(), "a vertex");
        assert!(cast(&square(), [2.0, 1.0, 1.0], [0.0, 0.0, -1.0]).is_some(), "the boundary");
    }

    #[test]
    fn wrong_rays_are_refused_by_their_row() {
        let refused = |origins: &[DVec3], directions: &[DVec3]| {
            square().ray_cast(origins, directions, &mut NoObserver).expect_err("refused").to_string()
        };
        assert!(refused(&[DVec3::ZERO], &[]).starts_with("directions: found 0 rows for 1"));
        assert!(refused(&[DVec3::ZERO], &[DVec3::ZERO]).starts_with("directions: row 0 has no length"));
        assert!(refused(&[DVec3::NAN], &[DVec3::X]).starts_with("origins: row 0 is [NaN"));
        let empty = SurfaceMesh::new(Vec::new(), Vec::new(), None).expect("nothing");
        assert_eq!(cast(&empty, [0.0; 3], [1.0; 3]), None);
    }
}
