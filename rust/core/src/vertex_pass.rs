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

use glam::DVec3;

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
pub fn angle_between(u: DVec3, v: DVec3) -> f64 {
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
    let unknown = Sides { own: f64::INFINITY, other: f64::INFINITY };
    let spokes = Spokes { mesh, vertex: run.vertex, apex: mesh.position(run.vertex) };
    // Spokes without length, of the triangles of the run and of those before and after it, give angles no meaning.
    let (first, outer) = (spokes.way(run.first), mesh.other_spoke(run.first, run.vertex));
    let way_outer = spokes.way(outer);
    if first == DVec3::ZERO || way_outer == DVec3::ZERO {
        return unknown;
    }
    let mut own = run.angle_in + run.angle_out;
    // Corners of the vertex that were walked through, the one before the run among them.
    let mut walked = 1;
    let (mut letter, mut way) = (run.first, first);
    while letter != run.last {
        let Some((next, way_next)) = spokes.next(letter) else { return unknown };
        own += angle_between(way, way_next);
        walked += 1;
        (letter, way) = (next, way_next);
        if letter == run.first || way == DVec3::ZERO {
            return unknown;
        }
    }
    let (before, Some(entered)) = (run.first.triangle(), mesh.twin(run.last)) else { return unknown };
    let after = entered.triangle();
    let way_after = spokes.way(mesh.other_spoke(entered, run.vertex));
    if way_after == DVec3::ZERO {
        return unknown;
    }
    let mut other = angle_between(first, way_outer) - run.angle_in + angle_between(way, way_after) - run.angle_out;
    let mut is_closed = true;
    if before != after {
        walked += 1;
        let (mut letter, mut way) = (outer, way_outer);
        loop {
            let Some(entered) = mesh.twin(letter) else {
                is_closed = false;
                break;
            };
            if entered.triangle() == after || entered.triangle() == before {
                break;
            }
            letter = mesh.other_spoke(entered, run.vertex);
            let way_next = spokes.way(letter);
            other += angle_between(way, way_next);
            walked += 1;
            way = way_next;
        }
    }
    // A ring that holds every corner of the vertex is an inner one; what else there is may be seen by a walk of its own.
    let is_passable = is_closed && (walked == mesh.adjacency().corners_at(run.vertex) || mesh.is_passable(run.vertex));
    Sides { own, other: if is_passable { other } else { f64::INFINITY } }
}

/// The edges at a vertex, as ways from it.
struct Spokes<'a> {
    mesh: &'a SurfaceMesh,
    vertex: VertexId,
    apex: DVec3,
}

impl Spokes<'_> {
    /// From the vertex to the other end of a spoke.
    #[inline]
    fn way(&self, spoke: HalfedgeId) -> DVec3 {
        self.mesh.position(self.mesh.other_end(spoke, self.vertex)) - self.apex
    }

    /// The spoke by which the triangle behind `spoke` is left, and its way; `None` at a boundary.
    #[inline]
    fn next(&self, spoke: HalfedgeId) -> Option<(HalfedgeId, DVec3)> {
        let next = self.mesh.other_spoke(self.mesh.twin(spoke)?, self.vertex);
        Some((next, self.way(next)))
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Six triangles round vertex 0 in the plane, of which the first `count` are there, and some more.
    fn fan(count: u32, more: &[[u32; 3]]) -> SurfaceMesh {
        let turn = |i: u32| f64::from(i) * std::f64::consts::FRAC_PI_3;
        let rim = (0..6).map(|i| DVec3::new(turn(i).cos(), turn(i).sin(), 0.0));
        let above = [DVec3::new(0.0, 0.0, 1.0), DVec3::new(1.0, 0.0, 1.0)];
        let positions = std::iter::once(DVec3::ZERO).chain(rim).chain(above).collect();
        let triangles = (0..count).map(|i| [0, 1 + i, 1 + (i + 1) % 6]).chain(more.iter().copied()).collect();
        SurfaceMesh::new(positions, triangles, None).expect("legal")
    }

    /// The run over the spokes to vertices 2 and 3, from the triangle 0 to 2, in and out at a third of a corner.
    fn sides(mesh: &SurfaceMesh) -> Sides {
        let sixth = std::f64::consts::FRAC_PI_3;
        let run = Run {
            vertex: VertexId(0),
            first: TriangleId(0).halfedge(2),
            last: TriangleId(1).halfedge(2),
            angle_in: sixth / 3.0,
            angle_out: sixth / 3.0,
        };
        measure_sides(mesh, &run)
    }

    #[test]
    fn both_sides_of_an_inner_vertex_make_a_full_turn() {
        let Sides { own, other } = sides(&fan(6, &[]));
        assert!((own - 5.0 / 9.0 * std::f64::consts::PI).abs() < 1e-14, "{own}");
        assert!((own + other - std::f64::consts::TAU).abs() < 1e-14, "{other}");
    }

    #[test]
    fn boundaries_and_pinched_vertices_have_no_other_side() {
        let inner = sides(&fan(6, &[]));
        // A triangle that hangs on the vertex alone, and one that makes an edge of it a wall.
        for mesh in [fan(5, &[]), fan(6, &[[0, 7, 8]]), fan(6, &[[0, 5, 7]])] {
            let Sides { own, other } = sides(&mesh);
            assert_eq!((own, other), (inner.own, f64::INFINITY));
        }
    }
}
