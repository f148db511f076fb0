//! Step D, *topological step*: the two sides of a mesh vertex that a line runs through, and the strip round the other one.
//!
//! ```text
//!            \   other side  /
//!             \      |      /          The line comes from p, touches v and goes on to q. The strip crosses
//!        p ....\_____v_____/.... q     some of v's edges ("spokes") on its own side: the run. The other side's
//!              /    /|\    \           spokes lead from the triangle before the run to the one after it as well.
//!             /    / | \    \
//!               strip's side (run)
//! ```
//!
//! A side is open to the line when its angle, unfolded, is below pi. Both at least pi: the vertex is where the line
//! belongs. Source: S.-Q. Xin, G.-J. Wang 2007, *Efficiently Determining a Locally Exact Shortest Path on Polyhedral
//! Surfaces*; the paper (section 6) swaps without asking, which cycles at saddles.

use crate::ids::{HalfedgeId, TriangleId, VertexId};
use crate::mesh::SurfaceMesh;
use crate::strip::entered_triangle;

/// An angle counts as below pi when it is by more than this, in radians: far above the rounding of a sum of corner
/// angles (1e-15 each), far below what a line could gain (the gain grows with the square).
pub const ANGLE_SLACK: f64 = 1e-10;

/// The angle of a triangle's corner at `vertex`, in radians; 0 where a side at the corner has no length.
#[inline]
pub fn corner_angle(mesh: &SurfaceMesh, triangle: TriangleId, vertex: VertexId) -> f64 {
    let corners = mesh.corners(triangle);
    let k = corners.iter().position(|&c| c == vertex).unwrap_or(0);
    let apex = mesh.position(vertex);
    angle_between(mesh.position(corners[(k + 1) % 3]) - apex, mesh.position(corners[(k + 2) % 3]) - apex)
}

/// The angle between two directions, right to rounding also where it is tiny or near pi.
#[inline]
pub fn angle_between(u: glam::DVec3, v: glam::DVec3) -> f64 {
    u.cross(v).length().atan2(u.dot(v))
}

/// Angles of both sides of a vertex, unfolded, between the line's way in and its way out.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Sides {
    /// The side that the strip is on.
    pub own: f64,
    /// The other side; infinite where a line may not be passed over the vertex.
    pub other: f64,
}

/// A run: the letters of a strip that cross spokes of one vertex, where the line runs through it.
///
/// `angle_in` is the angle, in the triangle before the run, between the way in and the first spoke; `angle_out`, in the
/// triangle after it, between the last spoke and the way out.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Run {
    /// The vertex.
    pub vertex: VertexId,
    /// First letter.
    pub first: HalfedgeId,
    /// Last letter.
    pub last: HalfedgeId,
    /// Radians.
    pub angle_in: f64,
    /// Radians.
    pub angle_out: f64,
}

/// The angles on both sides of a run; both infinite where there is no telling: where the run goes along an edge without length,
/// or does not turn round its vertex in one sense, which happens among triangles without area. Cost: O(valence).
pub fn measure_sides(mesh: &SurfaceMesh, run: &Run) -> Sides {
    let mut own = run.angle_in + run.angle_out;
    let mut letter = run.first;
    let unknown = Sides { own: f64::INFINITY, other: f64::INFINITY };
    if has_point_edge(mesh, run.first.triangle(), run.vertex) {
        return unknown;
    }
    while letter != run.last {
        let Some(entered) = mesh.twin(letter) else { return unknown };
        own += corner_angle(mesh, entered.triangle(), run.vertex);
        if has_point_edge(mesh, entered.triangle(), run.vertex) {
            return unknown;
        }
        letter = mesh.other_spoke(entered, run.vertex);
        if letter == run.first {
            return unknown;
        }
    }
    if has_point_edge(mesh, entered_triangle(mesh, run.last), run.vertex) {
        return unknown;
    }
    let other = if mesh.is_passable(run.vertex) {
        let (before, after) = (run.first.triangle(), entered_triangle(mesh, run.last));
        let mut other = corner_angle(mesh, before, run.vertex) - run.angle_in + corner_angle(mesh, after, run.vertex)
            - run.angle_out;
        for letter in other_side_word(mesh, run) {
            let entered = entered_triangle(mesh, letter);
            if entered != after {
                other += corner_angle(mesh, entered, run.vertex);
            }
        }
        other
    } else {
        f64::INFINITY
    };
    Sides { own, other }
}

/// Whether an edge of a triangle that `vertex` is an end of has no length: directions there are anything.
fn has_point_edge(mesh: &SurfaceMesh, triangle: TriangleId, vertex: VertexId) -> bool {
    let corners = mesh.corners(triangle);
    corners.iter().filter(|&&c| mesh.position(c) == mesh.position(vertex)).count() > 1
}

/// The letters round the other side of a passable vertex, from the triangle before the run to the one after it.
/// Cost: O(valence).
pub fn other_side_word(mesh: &SurfaceMesh, run: &Run) -> Vec<HalfedgeId> {
    let (before, after) = (run.first.triangle(), entered_triangle(mesh, run.last));
    if before == after {
        return Vec::new();
    }
    let mut word = Vec::with_capacity(8);
    let mut letter = mesh.other_spoke(run.first, run.vertex);
    loop {
        word.push(letter);
        let entered = mesh.twin(letter).expect("every spoke of a passable vertex has a twin");
        if entered.triangle() == after || entered.triangle() == before {
            return word;
        }
        letter = mesh.other_spoke(entered, run.vertex);
    }
}
