//! The point of the surface that is nearest to a point in space.
//!
//! Holds the way through the tree of boxes, nearest box first, and the nearest point of one triangle. Knows nothing of
//! lines.
//!
//! Source: C. Ericson 2005, *Real-Time Collision Detection*, sections 5.1.5 and 6.5 (we judge every candidate by its
//! distance instead of by regions, so that a sliver gives no wrong answer).

use glam::DVec3;

use crate::error::{OptionError, Result};
use crate::ids::TriangleId;
use crate::mesh::SurfaceMesh;
use crate::mesh_arrays::MAX_COORDINATE;
use crate::report::{Observer, Step};
use crate::smooth::go_on;
use crate::surface_point::SurfacePoint;
use crate::triangle_tree::{BRANCHES, LEAF, POINT_ROUNDING, TriangleTree};

/// Points that are looked up between two calls of the observer: about a millisecond.
pub(crate) const POINTS_PER_OBSERVATION: usize = 512;

/// More than the rounding of a product of three squared lengths.
const ABOVE: f64 = 1.0 + 64.0 * f64::EPSILON;

/// A point of the surface and how far it is from the point that was asked for.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct ClosestPoint {
    /// Where it is; on an edge one part of `barycentric` is exactly 0, on a mesh vertex two are.
    pub point: SurfacePoint,
    /// In the units of the positions.
    pub distance: f64,
}

/// A candidate: squared distance first, ties by the lower triangle.
#[derive(Clone, Copy, Debug)]
struct Candidate {
    square: f64,
    point: SurfacePoint,
}

impl TriangleTree {
    /// The point of the surface nearest to `p`, which must be finite; ties go to the lower triangle. `None` on a mesh
    /// without triangles.
    ///
    /// `hint`: a triangle that is likely to be near; it changes the cost and never the answer.
    pub fn closest(&self, mesh: &SurfaceMesh, p: DVec3, hint: Option<TriangleId>) -> Option<ClosestPoint> {
        let rounding = POINT_ROUNDING * self.extent;
        let mut best: Option<Candidate> = hint.map(|triangle| nearest_in_triangle(mesh, triangle, p, rounding));
        // A square above that of the distance of the best one, however that is rounded.
        let reach_of = |best: &Candidate| (best.square.sqrt() + 4.0 * rounding).powi(2) * ABOVE;
        let mut reach = best.as_ref().map_or(f64::INFINITY, reach_of);
        // Boxes that are still to be looked at: distance, level, place in the level; the nearest last.
        let mut stack: Vec<(f64, u32, u32)> = Vec::with_capacity(BRANCHES * self.levels.len());
        let top = self.levels.len() - 1;
        stack.extend(self.levels[top].first().map(|bounds| (bounds.square_to(p), top as u32, 0)));
        while let Some((square, level, place)) = stack.pop() {
            // Equal ones are looked at, as ties go by triangle.
            if best.is_some_and(|b| square > b.square) {
                continue;
            }
            let (level, place) = (level as usize, place as usize);
            if level == 0 {
                for i in place * LEAF..((place + 1) * LEAF).min(mesh.triangles().len()) {
                    let triangle = mesh.dual_graph().triangle_at(i);
                    if is_further(mesh.corners(triangle).map(|v| mesh.position(v)), p, reach) {
                        continue;
                    }
                    let new = nearest_in_triangle(mesh, triangle, p, rounding);
                    if best.is_none_or(|old| new.is_before(&old)) {
                        (best, reach) = (Some(new), reach_of(&new));
                    }
                }
                continue;
            }
            let below = &self.levels[level - 1];
            let first = stack.len();
            for (child, bounds) in below.iter().enumerate().skip(place * BRANCHES).take(BRANCHES) {
                let square = bounds.square_to(p);
                if best.is_none_or(|b| square <= b.square) {
                    stack.push((square, level as u32 - 1, child as u32));
                }
            }
            stack[first..].sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(b.2.cmp(&a.2)));
        }
        best.map(|b| ClosestPoint { point: b.point, distance: mesh.position_of(&b.point).distance(p) })
    }
}

impl Candidate {
    fn is_before(&self, other: &Self) -> bool {
        self.square < other.square || self.square == other.square && self.point.triangle < other.point.triangle
    }
}

impl SurfaceMesh {
    /// The points of the surface nearest to `points`, one for each row. The first call builds a tree, at O(triangles).
    ///
    /// A point that is equally near to several triangles belongs to the lowest. A result within rounding of an edge or a
    /// vertex lies on it exactly.
    ///
    /// # Errors
    /// A row that is not finite, or beyond 1e150; any row on a mesh without triangles: the message names `argument`.
    /// [`crate::Error::Interrupted`].
    pub fn closest_points(
        &self,
        points: &[DVec3],
        argument: &'static str,
        observer: &mut dyn Observer,
    ) -> Result<Vec<ClosestPoint>> {
        let tree = self.triangle_tree();
        let mut last: Option<TriangleId> = None;
        let mut found = Vec::with_capacity(points.len());
        for (row, &point) in points.iter().enumerate() {
            if row % POINTS_PER_OBSERVATION == 0 {
                go_on(observer, Step::Search)?;
            }
            check_point(row, point, argument)?;
            let closest = tree.closest(self, point, last).ok_or_else(|| {
                OptionError::new(
                    argument,
                    "the mesh has no triangles, so no point of it is near; pass a mesh with some",
                )
            })?;
            last = Some(closest.point.triangle);
            found.push(closest);
        }
        Ok(found)
    }
}

pub(crate) fn check_point(row: usize, point: DVec3, argument: &'static str) -> Result<(), OptionError> {
    if point.is_finite() && point.abs().max_element() <= MAX_COORDINATE {
        return Ok(());
    }
    Err(OptionError::new(
        argument,
        format!(
            "row {row} is {:?}, expected three finite numbers of at most 1e150; correct or leave out that row",
            point.to_array()
        ),
    ))
}

/// Whether all of a triangle is further from `p` than the square root of `reach`, by a plane between them: it is upright on
/// the way from `p` to the triangle's middle, and no corner lies on its near side. Nearly all that are further are found so, where
/// `p` is many triangles away too, at a tenth of the cost of their nearest points; false tells nothing.
fn is_further(corners: [DVec3; 3], p: DVec3, reach: f64) -> bool {
    let [a, b, c] = corners.map(|corner| p - corner);
    let way = a + b + c;
    let height = a.dot(way).min(b.dot(way)).min(c.dot(way));
    let least = reach * way.length_squared();
    // Also false where squares are too small to have all their digits.
    height > 0.0 && least > f64::MIN_POSITIVE / f64::EPSILON && height * height > least
}

/// The point of one triangle that is nearest to `p`. One that is at most `rounding` nearer than the nearest of an edge,
/// or of a vertex, gives way to that.
fn nearest_in_triangle(mesh: &SurfaceMesh, triangle: TriangleId, p: DVec3, rounding: f64) -> Candidate {
    let corners = mesh.corners(triangle).map(|v| mesh.position(v));
    let candidate = |barycentric: [f64; 3], at: DVec3| Candidate {
        square: at.distance_squared(p),
        point: SurfacePoint { triangle, barycentric },
    };
    let mut best: Option<Candidate> = None;
    let mut keep = |new: Candidate| {
        let is_nearer = |old: Candidate| {
            let gain = old.square - new.square;
            gain > 0.0 && old.square.sqrt() - new.square.sqrt() > rounding
        };
        if best.is_none_or(is_nearer) {
            best = Some(new);
        }
    };
    // From the vertices over the edges to the inside: of equals the simplest stays.
    let squares = corners.map(|corner| corner.distance_squared(p));
    let nearest = (1..3).fold(0, |k, i| if squares[i] < squares[k] { i } else { k });
    let mut at_vertex = [0.0; 3];
    at_vertex[nearest] = 1.0;
    keep(candidate(at_vertex, corners[nearest]));
    let mut on_edges: [Option<Candidate>; 3] = [None; 3];
    for (side, slot) in on_edges.iter_mut().enumerate() {
        // From the lower vertex to the higher, so that both triangles of an edge find the same point of it.
        let ends = [side, (side + 1) % 3];
        let ids = mesh.ends(triangle.halfedge(side as u32));
        let [low, high] = if ids[0] < ids[1] { ends } else { [ends[1], ends[0]] };
        let along = corners[high] - corners[low];
        let t = (p - corners[low]).dot(along) / along.length_squared();
        // Also false where the edge has no length.
        if t > 0.0 && t < 1.0 {
            let mut barycentric = [0.0; 3];
            (barycentric[low], barycentric[high]) = (1.0 - t, t);
            *slot = Some(candidate(barycentric, (1.0 - t) * corners[low] + t * corners[high]));
        }
    }
    let nearest_edge = on_edges.into_iter().flatten().min_by(|a, b| a.square.total_cmp(&b.square));
    nearest_edge.into_iter().for_each(&mut keep);
    if let Some(barycentric) = project_inside(corners, p) {
        let [a, b, c] = barycentric;
        keep(candidate(barycentric, (a * corners[0] + b * corners[1]) + c * corners[2]));
    }
    best.unwrap_or(candidate(at_vertex, corners[nearest]))
}

/// The foot of `p` in the plane of the triangle, where it lies inside.
fn project_inside([a, b, c]: [DVec3; 3], p: DVec3) -> Option<[f64; 3]> {
    let (u, v, w) = (b - a, c - a, p - a);
    // In units of the triangle's size: fourth powers of lengths neither overflow nor vanish.
    let size = u.abs().max(v.abs()).max_element();
    if size == 0.0 {
        return None;
    }
    let (u, v, w) = (u / size, v / size, w / size);
    let normal = u.cross(v);
    let square = normal.length_squared();
    let (second, third) = (w.cross(v).dot(normal) / square, u.cross(w).dot(normal) / square);
    let first = 1.0 - second - third;
    // Also none where the area is 0.
    (first > 0.0 && second > 0.0 && third > 0.0).then_some([first, second, third])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::NoObserver;

    fn square() -> SurfaceMesh {
        let positions = [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]].map(|[x, y]| DVec3::new(x, y, 0.0)).to_vec();
        SurfaceMesh::new(positions, vec![[0, 1, 2], [0, 2, 3]], None).expect("a square")
    }

    #[test]
    fn inside_on_an_edge_and_at_a_vertex() {
        let mesh = square();
        let at = |x: f64, y: f64, z: f64| {
            mesh.closest_points(&[DVec3::new(x, y, z)], "points", &mut NoObserver).expect("finite")[0]
        };
        let inside = at(1.5, 0.5, 3.0);
        assert_eq!((inside.point.triangle, inside.distance), (TriangleId(0), 3.0));
        let edge = at(1.0, -4.0, 3.0);
        assert_eq!(edge.point, SurfacePoint { triangle: TriangleId(0), barycentric: [0.5, 0.5, 0.0] });
        assert_eq!(edge.distance, 5.0);
        let vertex = at(-1.0, 3.0, 0.0);
        assert_eq!(vertex.point, SurfacePoint { triangle: TriangleId(1), barycentric: [0.0, 0.0, 1.0] });
        // The diagonal belongs to both: the lower id.
        assert_eq!(at(1.0, 1.0, 1.0).point, SurfacePoint { triangle: TriangleId(0), barycentric: [0.5, 0.0, 0.5] });
    }

    #[test]
    fn what_is_left_out_is_further_and_far_away_nearly_all_of_it_is_left_out() {
        let mut seed = 1u64;
        let mut number = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (seed >> 11) as f64 / (1u64 << 53) as f64 - 0.5
        };
        let (mut left_out, mut further) = (0, 0);
        for i in 0..20_000 {
            let mut point = || DVec3::new(number(), number(), number());
            let corners = [point(), point(), point()];
            let p = f64::from(i % 40) * point();
            let mesh = SurfaceMesh::new(corners.to_vec(), vec![[0, 1, 2]], None).expect("a triangle");
            let square = nearest_in_triangle(&mesh, TriangleId(0), p, 0.0).square;
            assert!(!is_further(corners, p, square * ABOVE), "{p} is no further than it is");
            assert!(!is_further(corners, p, 1.01 * square));
            if i % 40 > 10 {
                further += 1;
                left_out += u32::from(is_further(corners, p, 0.9 * square));
            }
        }
        assert!(10 * left_out > 9 * further, "{left_out} of {further}");
    }

    #[test]
    fn a_triangle_without_area_is_its_edges() {
        let positions = vec![DVec3::ZERO, DVec3::X, DVec3::new(3.0, 0.0, 0.0)];
        let mesh = SurfaceMesh::new(positions, vec![[0, 1, 2]], None).expect("a needle");
        let found = mesh.closest_points(&[DVec3::new(2.0, 1.0, 0.0)], "points", &mut NoObserver).expect("finite")[0];
        assert_eq!((mesh.position_of(&found.point), found.distance), (DVec3::new(2.0, 0.0, 0.0), 1.0));
        let found = mesh.closest_points(&[DVec3::new(5.0, 0.0, 0.0)], "points", &mut NoObserver).expect("finite")[0];
        assert_eq!((mesh.position_of(&found.point), found.distance), (DVec3::new(3.0, 0.0, 0.0), 2.0));
    }

    #[test]
    fn what_is_not_finite_or_too_far_is_refused_by_its_row() {
        for wrong in [f64::NAN, f64::INFINITY, 2e150] {
            let error = square().closest_points(&[DVec3::ZERO, DVec3::new(0.0, wrong, 0.0)], "points", &mut NoObserver);
            let message = error.expect_err("refused").to_string();
            assert!(message.starts_with("points: row 1 is [0.0, "), "{message}");
        }
        let empty = SurfaceMesh::new(Vec::new(), Vec::new(), None).expect("nothing");
        assert!(empty.closest_points(&[DVec3::ZERO], "points", &mut NoObserver).is_err());
        assert_eq!(empty.closest_points(&[], "points", &mut NoObserver), Ok(Vec::new()));
    }
}
