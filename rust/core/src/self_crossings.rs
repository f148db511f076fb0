//! How often a line crosses itself.
//!
//! Two segments cross where they lie in one triangle and each has the ends of the other on both sides. Lines that touch
//! in a point of theirs (a pin that is passed twice, a mesh vertex on both) are not counted. Changes nothing.

use glam::DVec2;

use crate::ids::TriangleId;
use crate::mesh::SurfaceMesh;
use crate::polyline::Polyline;
use crate::report::Report;
use crate::route::Route;
use crate::spot::in_triangle;

/// Self-crossings of a line. Cost: O(n log n) for n segments, and quadratic in how many share one triangle.
pub fn count_self_crossings(mesh: &SurfaceMesh, route: &Route) -> usize {
    let Some(line) = Polyline::assemble(mesh, route.clone(), Report::default()) else { return 0 };
    let count = line.points.len();
    // Barycentric coordinates are as good as any for what lies on which side.
    let place = |point: usize, triangle: TriangleId| {
        let parts = in_triangle(mesh, &line.surface_points[point], triangle);
        DVec2::new(parts[1], parts[2])
    };
    let mut segments: Vec<(TriangleId, [DVec2; 2])> = line
        .segment_triangles
        .iter()
        .enumerate()
        .map(|(i, &triangle)| (triangle, [place(i, triangle), place((i + 1) % count, triangle)]))
        .collect();
    segments.sort_by_key(|segment| segment.0);
    let groups = segments.chunk_by(|a, b| a.0 == b.0);
    groups
        .map(|group| {
            let pairs = group.iter().enumerate().flat_map(|(i, a)| group[i + 1..].iter().map(move |b| (a.1, b.1)));
            pairs.filter(|&(a, b)| is_crossing(a, b)).count()
        })
        .sum()
}

fn is_crossing([a, b]: [DVec2; 2], [c, d]: [DVec2; 2]) -> bool {
    let side = |p: DVec2, q: DVec2, r: DVec2| (q - p).perp_dot(r - p);
    side(a, b, c) * side(a, b, d) < 0.0 && side(c, d, a) * side(c, d, b) < 0.0
}
