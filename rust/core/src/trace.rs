//! Walking straight ahead on the surface: where a point comes to lie when it is moved along a direction.
//!
//! ```text
//!         /\        At each edge the direction is turned into the next triangle's plane about that edge,
//!    .---/--\--->   so the way is straight when the two triangles are unfolded.
//!       /____\
//! ```
//!
//! Source: K. Polthier, M. Schmies 1998, *Straightest Geodesics on Polyhedral Surfaces*. Where the way would leave the
//! surface, or cross a wall, it ends. Holds no optimisation.

use glam::DVec3;

use crate::ids::{HalfedgeId, TriangleId};
use crate::mesh::SurfaceMesh;
use crate::strip::push_reduced;
use crate::surface_point::SurfacePoint;

/// How far inside its triangle a traced point stays, in barycentric units: then the triangle that holds it is the only
/// one, and directions from it are right to half of the digits.
pub const INSIDE: f64 = 1e-7;

/// Moves `from`, which lies inside its triangle, along `way`: a direction in the plane of that triangle, as long as the
/// way to go. The letters that are crossed, `most` or fewer, are appended to `word`, whose backtracks cancel; `None` where
/// the way goes on.
///
/// The result lies inside its triangle, at least [`INSIDE`] from each side. Cost: O(letters).
pub fn trace(
    mesh: &SurfaceMesh,
    from: &SurfacePoint,
    way: DVec3,
    most: usize,
    word: &mut Vec<HalfedgeId>,
) -> Option<SurfacePoint> {
    let mut here = *from;
    let mut way = way;
    for crossed in 0.. {
        let Some(rates) = barycentric_rates(mesh, here.triangle, way) else { break };
        let b = here.barycentric;
        // The corner whose part vanishes first, and the share of the way until then.
        let reach = |k: usize| if rates[k] < 0.0 { b[k] / -rates[k] } else { f64::INFINITY };
        let corner = [1, 2].into_iter().fold(0, |best, k| if reach(k) < reach(best) { k } else { best });
        let share = reach(corner);
        if share > 1.0 {
            here.barycentric = std::array::from_fn(|k| b[k] + rates[k]);
            break;
        }
        here.barycentric = std::array::from_fn(|k| if k == corner { 0.0 } else { (b[k] + share * rates[k]).max(0.0) });
        let exit = here.triangle.halfedge((corner as u32 + 1) % 3);
        let Some((next, turned)) = cross(mesh, exit, &here, way) else { break };
        if crossed == most {
            return None;
        }
        push_reduced(mesh, word, exit);
        here = next;
        way = (1.0 - share) * turned;
    }
    Some(moved_inside(here))
}

/// The point a little further inside its triangle where it is nearer than [`INSIDE`] to a side.
pub fn moved_inside(point: SurfacePoint) -> SurfacePoint {
    let b = point.barycentric.map(|part| part.max(INSIDE));
    let sum: f64 = b.iter().sum();
    SurfacePoint { barycentric: b.map(|part| part / sum), ..point }
}

/// How fast the barycentric parts change along `way`; `None` in a triangle without area.
fn barycentric_rates(mesh: &SurfaceMesh, triangle: TriangleId, way: DVec3) -> Option<[f64; 3]> {
    let [p0, p1, p2] = mesh.corners(triangle).map(|v| mesh.position(v));
    let (u, v) = (p1 - p0, p2 - p0);
    let normal = u.cross(v);
    let square = normal.length_squared();
    let (second, third) = (way.cross(v).dot(normal) / square, u.cross(way).dot(normal) / square);
    (second.is_finite() && third.is_finite()).then_some([-second - third, second, third])
}

/// The point and the direction in the triangle beyond `exit`; `None` at a boundary, a wall, or a triangle without height.
fn cross(mesh: &SurfaceMesh, exit: HalfedgeId, here: &SurfacePoint, way: DVec3) -> Option<(SurfacePoint, DVec3)> {
    let entered = mesh.twin(exit)?;
    let [a, b] = mesh.ends(exit);
    let start = mesh.position(a);
    let along = (mesh.position(b) - start).try_normalize()?;
    let offset = mesh.position(mesh.apex(entered)) - start;
    let ahead = (offset - offset.dot(along) * along).try_normalize()?;
    let turned = way.dot(along) * along + way.cross(along).length() * ahead;
    let corners = mesh.corners(entered.triangle());
    let own = mesh.corners(exit.triangle());
    let part = |vertex| own.iter().position(|&v| v == vertex).map_or(0.0, |k| here.barycentric[k]);
    let barycentric = corners.map(|v| if v == a || v == b { part(v) } else { 0.0 });
    Some((SurfacePoint { triangle: entered.triangle(), barycentric }, turned))
}
