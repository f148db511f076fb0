//! Where on the mesh a point of a line lies (on a vertex, inside an edge, inside a triangle), and how crossings become
//! surface points.
//!
//! Holds single points alone; strips and lines are in `leg` and `route`.

use std::ops::ControlFlow;

use glam::DVec3;

use crate::ids::{HalfedgeId, TriangleId, VertexId};
use crate::mesh::SurfaceMesh;
use crate::strip::turn_word;
use crate::surface_point::SurfacePoint;

/// Where on the mesh a point of a line lies.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Spot {
    /// On a mesh vertex.
    Vertex(VertexId),
    /// Inside an edge: the lower of its half-edges, and the parameter from the lower end.
    Edge(HalfedgeId, f64),
    /// Inside a triangle.
    Inside(TriangleId),
}

impl Spot {
    /// Whether the place lies on the edge of `letter`.
    pub fn is_on(&self, mesh: &SurfaceMesh, letter: HalfedgeId) -> bool {
        match *self {
            Self::Vertex(v) => mesh.touches(letter, v),
            Self::Edge(edge, _) => letter == edge || mesh.twin(letter) == Some(edge),
            Self::Inside(_) => false,
        }
    }
}

/// The letters that lead from triangle `from` to triangle `to`, both of which hold `point`, without leaving it.
pub fn join_at(mesh: &SurfaceMesh, point: &SurfacePoint, from: TriangleId, to: TriangleId) -> Option<Vec<HalfedgeId>> {
    if from == to {
        return Some(Vec::new());
    }
    match spot_of(mesh, point) {
        Spot::Vertex(v) => turn_word(mesh, v, from, to),
        Spot::Edge(edge, _) => {
            let letter = [Some(edge), mesh.twin(edge)].into_iter().flatten().find(|h| h.triangle() == from)?;
            (mesh.twin(letter)?.triangle() == to).then(|| vec![letter])
        }
        Spot::Inside(_) => None,
    }
}

/// Triangles that hold a point and can be reached from its own without leaving it: one inside a triangle, up to two on
/// an edge, the fan at a vertex. The point's own triangle comes first.
pub fn triangles_round(mesh: &SurfaceMesh, point: &SurfacePoint) -> Vec<TriangleId> {
    // As many as there are round nearly all vertices, at once.
    let mut found = Vec::with_capacity(8);
    let _: ControlFlow<()> = visit_round(mesh, point, |triangle| {
        found.push(triangle);
        ControlFlow::Continue(())
    });
    found
}

/// Whether a triangle is one of [`triangles_round`] a point.
pub fn is_round(mesh: &SurfaceMesh, point: &SurfacePoint, triangle: TriangleId) -> bool {
    let look = |t| if t == triangle { ControlFlow::Break(()) } else { ControlFlow::Continue(()) };
    visit_round(mesh, point, look).is_break()
}

/// Visits [`triangles_round`] a point until `visit` breaks off.
fn visit_round(
    mesh: &SurfaceMesh,
    point: &SurfacePoint,
    mut visit: impl FnMut(TriangleId) -> ControlFlow<()>,
) -> ControlFlow<()> {
    let own = point.triangle;
    visit(own)?;
    match spot_of(mesh, point) {
        Spot::Inside(_) => {}
        Spot::Edge(edge, _) => {
            for h in [Some(edge), mesh.twin(edge)].into_iter().flatten().filter(|h| h.triangle() != own) {
                visit(h.triangle())?;
            }
        }
        Spot::Vertex(v) => {
            for start in own.halfedges().into_iter().filter(|&h| mesh.touches(h, v)) {
                let mut exit = start;
                while let Some(twin) = mesh.twin(exit) {
                    if twin.triangle() == own {
                        return ControlFlow::Continue(());
                    }
                    visit(twin.triangle())?;
                    exit = mesh.other_spoke(twin, v);
                }
            }
        }
    }
    ControlFlow::Continue(())
}

/// Barycentric parts of a point in another triangle that holds it.
pub fn in_triangle(mesh: &SurfaceMesh, point: &SurfacePoint, triangle: TriangleId) -> [f64; 3] {
    let own = mesh.corners(point.triangle);
    mesh.corners(triangle).map(|v| own.iter().position(|&c| c == v).map_or(0.0, |k| point.barycentric[k]))
}

/// Where a surface point lies, judged by exact zeroes.
pub fn spot_of(mesh: &SurfaceMesh, point: &SurfacePoint) -> Spot {
    let corners = mesh.corners(point.triangle);
    let b = point.barycentric;
    let is_zero = b.map(|x| x == 0.0);
    match is_zero.iter().filter(|&&z| z).count() {
        2 => Spot::Vertex(corners[is_zero.iter().position(|z| !z).unwrap_or(0)]),
        1 => {
            let off = is_zero.iter().position(|&z| z).unwrap_or(0);
            let (i, j) = ((off + 1) % 3, (off + 2) % 3);
            let t = if corners[i] < corners[j] { b[j] } else { b[i] };
            Spot::Edge(lower_halfedge(mesh, point.triangle.halfedge(i as u32)), t)
        }
        _ => Spot::Inside(point.triangle),
    }
}

/// Where a crossing lies.
pub fn crossing_spot(mesh: &SurfaceMesh, halfedge: HalfedgeId, t: f64) -> Spot {
    let [low, high] = mesh.sorted_ends(halfedge);
    if t == 0.0 {
        Spot::Vertex(low)
    } else if t == 1.0 {
        Spot::Vertex(high)
    } else {
        Spot::Edge(lower_halfedge(mesh, halfedge), t)
    }
}

/// A crossing as a point of the triangle that is left.
pub fn crossing_point(mesh: &SurfaceMesh, halfedge: HalfedgeId, t: f64) -> SurfacePoint {
    let [first, second] = mesh.ends(halfedge);
    let side = halfedge.side() as usize;
    let (from, to) = if first < second { (side, (side + 1) % 3) } else { ((side + 1) % 3, side) };
    let mut barycentric = [0.0; 3];
    barycentric[from] = 1.0 - t;
    barycentric[to] = t;
    SurfacePoint { triangle: halfedge.triangle(), barycentric }
}

/// Where a crossing is in space, to the bit the same as its surface point, but for the sign of zeroes: the third corner's
/// part is 0, so it need not be looked up.
#[inline]
pub fn crossing_position(mesh: &SurfaceMesh, halfedge: HalfedgeId, t: f64) -> DVec3 {
    let [low, high] = mesh.sorted_ends(halfedge);
    (1.0 - t) * mesh.position(low) + t * mesh.position(high)
}

/// The parameter of an end of an edge.
#[inline]
pub fn parameter_at(mesh: &SurfaceMesh, halfedge: HalfedgeId, vertex: VertexId) -> f64 {
    if mesh.sorted_ends(halfedge)[0] == vertex { 0.0 } else { 1.0 }
}

fn lower_halfedge(mesh: &SurfaceMesh, halfedge: HalfedgeId) -> HalfedgeId {
    mesh.twin(halfedge).map_or(halfedge, |twin| twin.min(halfedge))
}
