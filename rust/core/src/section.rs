//! A straight walk over the surface from one point to another: the section of the surface with a plane.
//!
//! ```text
//!        /\    /\          the plane holds both points and is upright on the surface;
//!   a --/--\--/--\-- b     each triangle that it enters it leaves by one other side
//!      /____\/____\
//! ```
//!
//! Joins points that are near each other as a stroke would, crossings included. Holds no search: where the walk does not
//! arrive, step B has to.

use glam::DVec3;

use crate::ids::{HalfedgeId, TriangleId};
use crate::leg::Leg;
use crate::mesh::SurfaceMesh;
use crate::spot::{crossing_position, spot_of};
use crate::surface_point::SurfacePoint;

/// A walk may be this many times as long as the straight line through space. Half a turn round a ball is 1.6; what is
/// longer goes round something that the stroke did not follow.
const MAX_DETOUR: f64 = 2.0;

/// A plane whose normal is shorter than this, relative to what it was made of, is upright on nothing.
const MIN_TILT: f64 = 1e-6;

/// One end of a walk.
#[derive(Clone, Copy, Debug)]
pub struct WalkEnd<'a> {
    /// Where it is.
    pub point: &'a SurfacePoint,
    /// The triangles that hold it.
    pub triangles: &'a [TriangleId],
}

/// The straight walk from `from` to `to`, which have no triangle in common, with the places where it crosses edges.
///
/// `None` when it meets a boundary or a wall, or would be more than twice as long as the distance through space (unless
/// the two triangles are neighbours). Cost: O(letters).
pub fn walk_straight(mesh: &SurfaceMesh, from: WalkEnd<'_>, to: WalkEnd<'_>) -> Option<Leg> {
    let normal = |point: &SurfacePoint| {
        let [a, b, c] = mesh.corners(point.triangle).map(|v| mesh.position(v));
        (b - a).cross(c - a).normalize_or_zero()
    };
    let (first, second) = (normal(from.point), normal(to.point));
    let along = (mesh.position_of(to.point) - mesh.position_of(from.point)).normalize_or_zero();
    // Where windings differ, the two normals cancel; each alone will do.
    [first + second, first, second]
        .into_iter()
        .filter_map(|up| Some(along.cross(up)).filter(|across| across.length() > MIN_TILT))
        .find_map(|across| walk_in_plane(mesh, from, to, along, across))
}

fn walk_in_plane(mesh: &SurfaceMesh, from: WalkEnd<'_>, to: WalkEnd<'_>, along: DVec3, across: DVec3) -> Option<Leg> {
    let (start, goal) = (mesh.position_of(from.point), mesh.position_of(to.point));
    let longest = MAX_DETOUR * start.distance(goal);
    // Where the plane crosses an edge: strictly on one side of it at one end, and not at the other.
    let crossing = |h: HalfedgeId| {
        let [low, high] = mesh.sorted_ends(h).map(|v| (mesh.position(v) - start).dot(across));
        ((low < 0.0) != (high < 0.0)).then(|| (low / (low - high)).clamp(0.0, 1.0))
    };
    // The way out of the triangles round the start that leads most straight to the goal.
    let spot = spot_of(mesh, from.point);
    let mut best: Option<(f64, HalfedgeId, f64)> = None;
    for h in from.triangles.iter().flat_map(|t| t.halfedges()).filter(|&h| !spot.is_on(mesh, h)) {
        let Some(t) = crossing(h) else { continue };
        let ahead = (crossing_position(mesh, h, t) - start).normalize_or_zero().dot(along);
        if ahead > best.map_or(0.0, |b| b.0) {
            best = Some((ahead, h, t));
        }
    }
    let (_, mut letter, mut t) = best?;
    let mut leg = Leg { first: letter.triangle(), word: Vec::new(), parameters: Vec::new() };
    let (mut last, mut length) = (start, 0.0);
    loop {
        let place = crossing_position(mesh, letter, t);
        length += last.distance(place);
        last = place;
        leg.word.push(letter);
        leg.parameters.push(t);
        let entered = mesh.twin(letter)?;
        let is_there = to.triangles.contains(&entered.triangle());
        let is_neighbour = is_there && leg.word.len() == 1;
        if length + place.distance(goal) > longest && !is_neighbour {
            return None;
        }
        if is_there {
            return Some(leg);
        }
        // A section that is closed comes back to where it began.
        if entered.triangle() == leg.first {
            return None;
        }
        (letter, t) = [entered.next(), entered.previous()].into_iter().find_map(|h| Some((h, crossing(h)?)))?;
    }
}
