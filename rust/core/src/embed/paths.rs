//! Lines as they are put into the mesh: with a point more wherever two of their segments cross too near an edge.
//!
//! Such a crossing is moved to the edge, as any other point of a line is; it has to be a point of both lines before the
//! points are sorted along the edges.

use crate::ids::TriangleId;
use crate::mesh::SurfaceMesh;
use crate::polyline::Polyline;
use crate::spot::in_triangle;
use crate::surface_point::SurfacePoint;

use super::triangulation::{Row, turn};

/// A line as points and the triangles between them.
#[derive(Clone, Debug)]
pub struct Path {
    /// Whether a last segment leads back to the first point.
    pub closed: bool,
    /// The points.
    pub points: Vec<SurfacePoint>,
    /// Where each is on the line: the number of the segment and how far along it.
    pub parameters: Vec<f64>,
    /// The triangle that holds segment `i` whole.
    pub triangles: Vec<TriangleId>,
}

/// A segment of a line, in a triangle.
struct Segment {
    triangle: TriangleId,
    line: usize,
    index: usize,
    ends: [Row; 2],
}

/// A point to be added to a line.
struct Addition {
    line: usize,
    index: usize,
    part: f64,
    point: SurfacePoint,
}

/// The paths of lines. Cost: O(n log n), and the square of how many segments share a triangle.
pub fn find_paths(mesh: &SurfaceMesh, lines: &[&Polyline], tolerance: f64) -> Vec<Path> {
    let mut segments = Vec::new();
    for (line, polyline) in lines.iter().enumerate() {
        let points = &polyline.surface_points;
        for (index, &triangle) in polyline.segment_triangles.iter().enumerate() {
            let ends = [points[index], points[(index + 1) % points.len()]].map(|p| in_triangle(mesh, &p, triangle));
            segments.push(Segment { triangle, line, index, ends });
        }
    }
    segments.sort_by_key(|segment| (segment.triangle, segment.line, segment.index));
    let mut additions: Vec<Addition> = Vec::new();
    for group in segments.chunk_by(|a, b| a.triangle == b.triangle) {
        for (i, one) in group.iter().enumerate() {
            for other in &group[..i] {
                let Some((row, parts)) = cross(one.ends, other.ends) else { continue };
                if row.iter().all(|&b| b >= tolerance) {
                    continue;
                }
                let point = SurfacePoint { triangle: one.triangle, barycentric: row };
                for (segment, part) in [one, other].into_iter().zip(parts) {
                    additions.push(Addition { line: segment.line, index: segment.index, part, point });
                }
            }
        }
    }
    additions.sort_by(|a, b| (a.line, a.index).cmp(&(b.line, b.index)).then(a.part.total_cmp(&b.part)));
    let mut next = additions.into_iter().peekable();
    let path = |(line, polyline): (usize, &&Polyline)| {
        let count = polyline.segment_triangles.len();
        let mut path =
            Path { closed: polyline.closed, points: Vec::new(), parameters: Vec::new(), triangles: Vec::new() };
        for (index, &point) in polyline.surface_points.iter().enumerate() {
            path.points.push(point);
            path.parameters.push(index as f64);
            let Some(&triangle) = polyline.segment_triangles.get(index).filter(|_| index < count) else { continue };
            path.triangles.push(triangle);
            while let Some(added) = next.next_if(|added| (added.line, added.index) == (line, index)) {
                path.points.push(added.point);
                path.parameters.push(index as f64 + added.part);
                path.triangles.push(triangle);
            }
        }
        path
    };
    lines.iter().enumerate().map(path).collect()
}

/// Where two segments cross strictly inside both, and how far along each.
fn cross([a, b]: [Row; 2], [c, d]: [Row; 2]) -> Option<(Row, [f64; 2])> {
    let (to_c, to_d) = (turn(a, b, c), turn(a, b, d));
    if to_c * to_d >= 0.0 {
        return None;
    }
    let (to_a, to_b) = (turn(c, d, a), turn(c, d, b));
    if to_a * to_b >= 0.0 {
        return None;
    }
    let (s, t) = (to_a / (to_a - to_b), to_c / (to_c - to_d));
    let mixed: Row = std::array::from_fn(|i| ((1.0 - s) * a[i] + s * b[i]).max(0.0));
    let sum: f64 = mixed.iter().sum();
    Some((mixed.map(|x| x / sum), [s, t]))
}
