//! How often a line crosses itself.
//!
//! Two segments cross where they lie in one triangle and each has the ends of the other on both sides. Lines that touch
//! in a point of theirs (a pin that is passed twice, a mesh vertex on both) are not counted. Changes nothing.

use glam::DVec2;

use crate::error::Result;
use crate::ids::TriangleId;
use crate::mesh::SurfaceMesh;
use crate::pauses::Pauses;
use crate::polyline::Polyline;
use crate::report::Report;
use crate::route::Route;
use crate::spot::in_triangle;

/// Segments that are put in order without a look at limits, about: a millisecond.
const SEGMENTS_A_PART: usize = 1 << 13;

/// Self-crossings of a line. Cost: O(n log n) for n segments, and quadratic in how many share one triangle.
///
/// # Errors
/// [`crate::Error::Interrupted`] at one of the `pauses`.
pub fn count_self_crossings(mesh: &SurfaceMesh, route: &Route, pauses: &mut Pauses) -> Result<usize> {
    let line = Polyline::assemble_with_pauses(mesh, route.clone(), Report::default(), pauses)?;
    let Some(line) = line else { return Ok(0) };
    let count = line.points.len();
    // Barycentric coordinates are as good as any for what lies on which side.
    let place = |point: usize, triangle: TriangleId| {
        let parts = in_triangle(mesh, &line.surface_points[point], triangle);
        DVec2::new(parts[1], parts[2])
    };
    // Put in order by triangle in parts, each of which is soon done.
    let triangles = mesh.triangles().len();
    let parts = 1 + count / SEGMENTS_A_PART;
    let mut segments: Vec<Vec<(TriangleId, [DVec2; 2])>> = vec![Vec::new(); parts];
    for (i, &triangle) in line.segment_triangles.iter().enumerate() {
        pauses.tick()?;
        let segment = [place(i, triangle), place((i + 1) % count, triangle)];
        segments[triangle.index() * parts / triangles].push((triangle, segment));
    }
    let mut crossings = 0;
    for mut part in segments {
        pauses.ticks(part.len())?;
        part.sort_by_key(|segment| segment.0);
        for group in part.chunk_by(|a, b| a.0 == b.0) {
            for (i, a) in group.iter().enumerate() {
                for b in &group[i + 1..] {
                    pauses.tick()?;
                    crossings += usize::from(is_crossing(a.1, b.1));
                }
            }
        }
    }
    Ok(crossings)
}

fn is_crossing([a, b]: [DVec2; 2], [c, d]: [DVec2; 2]) -> bool {
    let side = |p: DVec2, q: DVec2, r: DVec2| (q - p).perp_dot(r - p);
    side(a, b, c) * side(a, b, d) < 0.0 && side(c, d, a) * side(c, d, b) < 0.0
}
