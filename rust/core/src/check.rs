//! Every promise of the contract about a finished line, checked from the mesh and the line alone.
//!
//! For tests, fuzzers and debug builds. Must not repair anything, and must not rely on how the line was made: places are
//! compared by their corners and weights, exactly, and the strip is walked anew.

mod error;

use arrayvec::ArrayVec;

pub use error::CheckError;

use crate::ids::{HalfedgeId, TriangleId, VertexId};
use crate::mesh::SurfaceMesh;
use crate::polyline::Polyline;
use crate::surface_point::SurfacePoint;

/// Barycentric parts sum to 1 within the rounding of three divisions and two additions.
const SUM_SLACK: f64 = 8.0 * f64::EPSILON;

/// Corners that a point hangs on, with their weights, lowest vertex first: three inside a triangle, two on an edge, one at
/// a mesh vertex. The same place has the same support from whichever triangle it is seen.
type Support = ArrayVec<(VertexId, f64), 3>;

/// Checks every promise that the mesh and the line can tell.
///
/// # Errors
/// The first broken promise, with the elements that break it.
///
/// Cost: O(points + strip).
pub fn check_polyline(mesh: &SurfaceMesh, line: &Polyline) -> Result<(), CheckError> {
    check_sizes(mesh, line)?;
    check_points(mesh, line)?;
    let supports: Vec<Support> = line.surface_points.iter().map(|p| support_of(mesh, p)).collect();
    check_inner_points(mesh, line, &supports)?;
    check_segments(mesh, line, &supports)?;
    check_joints(mesh, line, &supports)?;
    check_strip(mesh, line)?;
    walk_strip(mesh, line, &supports)?;
    check_pins(mesh, line, &supports)?;
    check_route(mesh, line)?;
    check_bytes(mesh, line)
}

/// Triangles that the strip of `line` holds more than once and that of `step_b` (the same picks with filter `none`) does
/// not: loops that smoothing has made.
///
/// Two legs that meet in a pin at a sharp angle may share triangles with good reason: the count is 0 for lines whose inner
/// picks are not pinned.
pub fn count_new_repeats(step_b: &Polyline, line: &Polyline) -> usize {
    let before = repeated_triangles(step_b);
    repeated_triangles(line).iter().filter(|t| before.binary_search(t).is_err()).count()
}

/// Triangles that a strip holds more than once, each once, in order of their ids.
fn repeated_triangles(line: &Polyline) -> Vec<TriangleId> {
    let mut sorted = line.strip.clone();
    sorted.sort_unstable();
    let mut repeated: Vec<_> = sorted.windows(2).filter(|pair| pair[0] == pair[1]).map(|pair| pair[0]).collect();
    repeated.dedup();
    repeated
}

fn check_sizes(mesh: &SurfaceMesh, line: &Polyline) -> Result<(), CheckError> {
    let count = line.points.len();
    let least = if line.closed { 2 } else { 1 };
    let segments = if line.closed { count } else { count.saturating_sub(1) };
    for (array, found, expected, is_right) in [
        ("points", count, least, count >= least),
        ("surface_points", line.surface_points.len(), count, line.surface_points.len() == count),
        ("segment_triangles", line.segment_triangles.len(), segments, line.segment_triangles.len() == segments),
        ("strip", line.strip.len(), 1, !line.strip.is_empty()),
    ] {
        if !is_right {
            return Err(CheckError::Size { array, found, expected });
        }
    }
    let triangles = mesh.triangles().len();
    let in_range = |array, ids: &mut dyn Iterator<Item = TriangleId>| match ids
        .enumerate()
        .find(|(_, t)| t.index() >= triangles)
    {
        Some((place, t)) => Err(CheckError::TriangleOutOfRange { array, place, triangle: t.0, triangles }),
        None => Ok(()),
    };
    in_range("surface_points", &mut line.surface_points.iter().map(|p| p.triangle))?;
    in_range("segment_triangles", &mut line.segment_triangles.iter().copied())?;
    in_range("strip", &mut line.strip.iter().copied())?;
    in_range("route.pins", &mut line.route.pins.iter().map(|p| p.triangle))
}

fn check_points(mesh: &SurfaceMesh, line: &Polyline) -> Result<(), CheckError> {
    for (point, (at, &found)) in line.surface_points.iter().zip(&line.points).enumerate() {
        let [b0, b1, b2] = at.barycentric;
        // Written so that a part that is not a number is refused.
        let is_point = at.barycentric.iter().all(|&b| b >= 0.0) && (b0 + b1 + b2 - 1.0).abs() <= SUM_SLACK;
        if !is_point {
            return Err(CheckError::NotBarycentric { point, barycentric: at.barycentric });
        }
        let [p0, p1, p2] = mesh.corners(at.triangle).map(|v| mesh.position(v));
        let expected = (b0 * p0 + b1 * p1) + b2 * p2;
        if found.to_array().map(f64::to_bits) != expected.to_array().map(f64::to_bits) || !found.is_finite() {
            return Err(CheckError::PointOff { point, found, expected });
        }
    }
    Ok(())
}

fn check_inner_points(mesh: &SurfaceMesh, line: &Polyline, supports: &[Support]) -> Result<(), CheckError> {
    for (point, support) in supports.iter().enumerate().filter(|(_, s)| s.len() == 3) {
        if !line.route.pins.iter().any(|pin| support_of(mesh, pin) == *support) {
            return Err(CheckError::InsideWithoutPin { point, triangle: line.surface_points[point].triangle });
        }
    }
    Ok(())
}

fn check_segments(mesh: &SurfaceMesh, line: &Polyline, supports: &[Support]) -> Result<(), CheckError> {
    let count = supports.len();
    let is_pin = |point: usize| line.route.pins.iter().any(|pin| support_of(mesh, pin) == supports[point]);
    for (segment, &triangle) in line.segment_triangles.iter().enumerate() {
        let (first, second) = (segment, (segment + 1) % count);
        for point in [first, second] {
            if !holds(mesh, triangle, &supports[point]) {
                return Err(CheckError::SegmentOutside { segment, point, triangle });
            }
        }
        if supports[first] == supports[second] {
            return Err(CheckError::PlaceTwice { first, second });
        }
        let position = line.points[first];
        if position == line.points[second]
            && !has_coincident(mesh, &supports[first], &supports[second])
            && !(is_flat(mesh, triangle) && [first, second].iter().all(|&i| is_pin(i)))
        {
            return Err(CheckError::PointsEqual { first, second, position });
        }
    }
    Ok(())
}

/// The triangle changes only at points on what both triangles share.
fn check_joints(mesh: &SurfaceMesh, line: &Polyline, supports: &[Support]) -> Result<(), CheckError> {
    for (segment, &triangle) in line.segment_triangles.iter().enumerate() {
        let second = (segment + 1) % supports.len();
        let Some(&to) = line.segment_triangles.get(if line.closed { second } else { segment + 1 }) else { continue };
        let is_joined = triangle == to
            || match supports[second].len() {
                1 => true,
                2 => crossings_between(mesh, triangle, to).any(|h| edge_holds(mesh, h, &supports[second])),
                _ => false,
            };
        if !is_joined {
            return Err(CheckError::SegmentsApart { point: second, from: triangle, to });
        }
    }
    Ok(())
}

/// The strip by itself: unbroken, and turning back only where a pin lies.
fn check_strip(mesh: &SurfaceMesh, line: &Polyline) -> Result<(), CheckError> {
    let strip = &line.strip;
    let count = strip.len();
    let is_ring = line.closed && count > 1;
    let at = |place: usize| strip[place % count];
    for place in 0..if is_ring { count } else { count - 1 } {
        let (from, to) = (at(place), at(place + 1));
        if crossings_between(mesh, from, to).next().is_none() {
            return Err(CheckError::StripBroken { place, from, to });
        }
    }
    for place in 0..if is_ring { count } else { count.saturating_sub(2) } {
        let middle = at(place + 1);
        // Two triangles that share two edges make a ring of two.
        let turns_back = at(place) == at(place + 2) && crossings_between(mesh, at(place), middle).count() == 1;
        if turns_back && !line.route.pins.iter().any(|pin| holds(mesh, middle, &support_of(mesh, pin))) {
            return Err(CheckError::Backtrack { place: (place + 1) % count, triangle: middle });
        }
    }
    Ok(())
}

/// Walks along strip and line together: the strip changes triangles only at points of the line, and the segments follow
/// each other in the strip's order, once round where the line is closed.
fn walk_strip(mesh: &SurfaceMesh, line: &Polyline, supports: &[Support]) -> Result<(), CheckError> {
    let count = line.strip.len();
    if !line.closed {
        return walk_from(mesh, line, supports, 0, count - 1);
    }
    // The first segment may lie anywhere in the ring, and a triangle may come twice.
    let first = line.segment_triangles[0];
    let mut found = Err(CheckError::StripTooShort { segment: 0, triangle: first });
    for start in (0..count).filter(|&i| line.strip[i] == first) {
        found = walk_from(mesh, line, supports, start, if count > 1 { count } else { 0 });
        if found.is_ok() {
            break;
        }
    }
    found
}

/// Takes `steps` steps along the strip from place `start`, which is that of the first segment where the line is closed.
fn walk_from(
    mesh: &SurfaceMesh,
    line: &Polyline,
    supports: &[Support],
    start: usize,
    steps: usize,
) -> Result<(), CheckError> {
    let (count, points) = (line.strip.len(), supports.len());
    let is_pin = |support: &Support| line.route.pins.iter().any(|pin| support_of(mesh, pin) == *support);
    let (first_joint, last_joint) = if line.closed { (1, points) } else { (0, points - 1) };
    // Numbers of steps after which the strip may be at the segment. Round a pinned vertex the strip may turn as often as
    // its legs ask, and come by the segment's triangle more than once; elsewhere there is one.
    let mut reached = vec![0];
    for joint in first_joint..=last_joint {
        let (point, is_last) = (joint % points, joint == last_joint);
        let may_turn = supports[point].len() == 1 && is_pin(&supports[point]);
        let mut next_reached = Vec::new();
        let mut fault = None;
        for &before in &reached {
            let mut taken = before;
            loop {
                let place = (start + taken) % count;
                let triangle = line.strip[place];
                let goal = line.segment_triangles.get(joint).filter(|_| !is_last).copied();
                if goal.map_or(taken == steps, |goal| goal == triangle) {
                    next_reached.push(taken);
                    if is_last || !may_turn {
                        break;
                    }
                }
                if taken == steps {
                    fault = fault.or(goal.map(|triangle| CheckError::StripTooShort { segment: joint, triangle }));
                    break;
                }
                let next = line.strip[(place + 1) % count];
                if !crossings_between(mesh, triangle, next).any(|h| edge_holds(mesh, h, &supports[point])) {
                    fault = fault.or(Some(CheckError::StripOffLine { place, triangle, point }));
                    break;
                }
                taken += 1;
            }
        }
        if let (true, Some(fault)) = (next_reached.is_empty(), fault) {
            return Err(fault);
        }
        next_reached.sort_unstable();
        next_reached.dedup();
        reached = next_reached;
    }
    Ok(())
}

fn check_pins(mesh: &SurfaceMesh, line: &Polyline, supports: &[Support]) -> Result<(), CheckError> {
    let pins = &line.route.pins;
    let missing = |pin: usize| Err(CheckError::PinMissing { pin, at: pins[pin] });
    let mut from = 0;
    // The last pin of a closed line may be the place where the first one is.
    let ring = || supports.iter().chain(supports.first().filter(|_| line.closed));
    for (pin, at) in pins.iter().enumerate() {
        let wanted = support_of(mesh, at);
        match ring().skip(from).position(|support| *support == wanted) {
            Some(offset) => from += offset,
            None => return missing(pin),
        }
    }
    // A line with pins begins at one, and an open line ends at one.
    let is_at = |pin: usize, point: usize| support_of(mesh, &pins[pin]) == supports[point];
    if !pins.is_empty() && !is_at(0, 0) {
        return missing(0);
    }
    if !line.closed && !pins.is_empty() && !is_at(pins.len() - 1, supports.len() - 1) {
        return missing(pins.len() - 1);
    }
    Ok(())
}

fn check_route(mesh: &SurfaceMesh, line: &Polyline) -> Result<(), CheckError> {
    let (pins, legs) = (line.route.pins.len(), &line.route.legs);
    let closed = line.closed;
    let is_right = if closed { legs.len() == pins.max(1) } else { legs.len() + 1 == pins };
    if !is_right || line.route.closed != closed {
        return Err(CheckError::LegCount { legs: legs.len(), pins, closed });
    }
    for (i, leg) in legs.iter().enumerate() {
        let broken = |letter: usize| Err(CheckError::WordBroken { leg: i, letter });
        let mut triangle = leg.first;
        let mut entered: Option<HalfedgeId> = None;
        for (letter, &h) in leg.word.iter().enumerate() {
            let is_next = h.triangle().index() < mesh.triangles().len() && h.triangle() == triangle;
            let Some(twin) = Some(h).filter(|_| is_next && entered != Some(h)).and_then(|h| mesh.twin(h)) else {
                return broken(letter);
            };
            (triangle, entered) = (twin.triangle(), Some(twin));
        }
        if pins == 0 && (leg.word.is_empty() || triangle != leg.first || entered == leg.word.first().copied()) {
            return broken(leg.word.len());
        }
        if leg.parameters.len() != leg.word.len() {
            let (found, expected) = (leg.parameters.len(), leg.word.len());
            return Err(CheckError::Size { array: "parameters of a leg", found, expected });
        }
        if let Some((letter, &parameter)) = leg.parameters.iter().enumerate().find(|(_, t)| !(0.0..=1.0).contains(*t)) {
            return Err(CheckError::ParameterOff { leg: i, letter, parameter });
        }
    }
    Ok(())
}

fn check_bytes(mesh: &SurfaceMesh, line: &Polyline) -> Result<(), CheckError> {
    let differ = |field| Err(CheckError::BytesDiffer { field });
    let Ok(back) = Polyline::from_bytes(mesh, &line.to_bytes(mesh)) else { return differ("everything") };
    for (field, is_equal) in [
        ("closed", back.closed == line.closed),
        ("route", back.route == line.route),
        ("surface_points", back.surface_points == line.surface_points),
        ("points", back.points == line.points),
        ("segment_triangles", back.segment_triangles == line.segment_triangles),
        ("strip", back.strip == line.strip),
    ] {
        if !is_equal {
            return differ(field);
        }
    }
    Ok(())
}

fn support_of(mesh: &SurfaceMesh, point: &SurfacePoint) -> Support {
    let mut support: Support =
        mesh.corners(point.triangle).into_iter().zip(point.barycentric).filter(|&(_, weight)| weight != 0.0).collect();
    support.sort_unstable_by_key(|&(vertex, _)| vertex);
    support
}

fn holds(mesh: &SurfaceMesh, triangle: TriangleId, support: &Support) -> bool {
    let corners = mesh.corners(triangle);
    support.iter().all(|(vertex, _)| corners.contains(vertex))
}

fn edge_holds(mesh: &SurfaceMesh, edge: HalfedgeId, support: &Support) -> bool {
    support.iter().all(|&(vertex, _)| mesh.touches(edge, vertex))
}

/// Sides of `from` across which `to` lies.
fn crossings_between(mesh: &SurfaceMesh, from: TriangleId, to: TriangleId) -> impl Iterator<Item = HalfedgeId> + '_ {
    from.halfedges().into_iter().filter(move |&h| mesh.twin(h).is_some_and(|twin| twin.triangle() == to))
}

/// Whether two of the corners that two places hang on are at the same position.
/// Whether a triangle has no area: two pins in it may be at one place, and neither can move.
fn is_flat(mesh: &SurfaceMesh, triangle: TriangleId) -> bool {
    let [a, b, c] = mesh.corners(triangle).map(|v| mesh.position(v));
    (b - a).cross(c - a).length_squared() == 0.0
}

fn has_coincident(mesh: &SurfaceMesh, a: &Support, b: &Support) -> bool {
    let mut corners: ArrayVec<VertexId, 6> = a.iter().chain(b).map(|&(vertex, _)| vertex).collect();
    corners.sort_unstable();
    let is_twin =
        |i: usize, j: usize| corners[i] != corners[j] && mesh.position(corners[i]) == mesh.position(corners[j]);
    (0..corners.len()).any(|i| (0..i).any(|j| is_twin(i, j)))
}
