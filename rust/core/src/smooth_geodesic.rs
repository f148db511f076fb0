//! The `geodesic` filter on a whole line: all legs round by round, or the one closed leg without pins.
//!
//! Holds the limits and the stop reason; the geometry is in `filter::geodesic` and `filter::closed_geodesic`.

use glam::DVec3;

use crate::error::Result;
use crate::filter::closed_geodesic::straighten_loop;
use crate::filter::geodesic::{GeodesicLeg, cross_straight};
use crate::filter::workspace::Workspace;
use crate::leg::Leg;
use crate::loops::OwnRepeats;
use crate::mesh::SurfaceMesh;
use crate::options::Options;
use crate::pauses::Pauses;
use crate::polyline::{Polyline, length_of};
use crate::report::{Observer, Report, Step, StopReason};
use crate::route::Route;
use crate::smooth::go_on;
use crate::spot::crossing_position;
use crate::unfold::Unfolding;

/// Rounds that a line of `letters` crossings may take without a limit of the caller's: measured lines take up to 170
/// rounds for 1 500 crossings (slivers); this is never reached, but it is finite.
fn round_bound(letters: usize) -> u32 {
    1000 + 20 * letters.min(1 << 26) as u32
}

/// Runs after the first, when that one ends because the two-angle rule would go on for ever,
const MOST_RUNS: u32 = 16;
/// and the share by which a run must shorten the line to be followed by another.
const SETTLED_FALL: f64 = 1e-12;

/// A crossing this near to a vertex, in what that one may have been moved by, may be where it is by the shaking alone.
const SNAP_REACHES: f64 = 64.0;

/// What the shaking can have moved a crossing by, as a share of its edge, on short edges too.
const NEAR_SHARE: f64 = 1e-6;

/// Straightens all legs of `route` until each is locally shortest.
///
/// # Errors
/// [`crate::Error::Collapsed`], [`crate::Error::Interrupted`].
pub fn smooth_geodesic(
    mesh: &SurfaceMesh,
    route: &mut Route,
    options: &Options,
    work: &mut Workspace,
    report: &mut Report,
    observer: &mut dyn Observer,
) -> Result<()> {
    let limit = options.max_iterations.unwrap_or_else(|| round_bound(count_letters(route)));
    let bounds = (limit, options.stages);
    let own_repeats = OwnRepeats::of_route(mesh, route);
    let finish = loop {
        let finish = straighten_or_shake(mesh, route, &own_repeats, bounds, work, report, observer)?;
        let before = count_letters(route);
        route.snap_to_vertices(mesh);
        // A full turn that is cut at a vertex may take with it what led there and back: then the line is not straight any more.
        let is_shorter = count_letters(route) < before;
        if !is_shorter || report.iterations >= limit {
            break if is_shorter { Finish::Limited } else { finish };
        }
    };
    report.stop_reason = match (finish, route.touches_vertex()) {
        (Finish::Settled, false) => StopReason::Converged,
        (Finish::Settled, true) => StopReason::ConvergedAtVertices,
        (Finish::Cycling, _) => StopReason::Cycle,
        (Finish::Limited, _) => StopReason::MaxIterations,
    };
    Ok(())
}

fn count_letters(route: &Route) -> usize {
    route.legs.iter().map(|leg| leg.word.len()).sum()
}

/// Straightens the line on the mesh itself, and on the shaken one where the two-angle rule has no end there.
fn straighten_or_shake(
    mesh: &SurfaceMesh,
    route: &mut Route,
    own_repeats: &OwnRepeats,
    bounds: (u32, bool),
    work: &mut Workspace,
    report: &mut Report,
    observer: &mut dyn Observer,
) -> Result<Finish> {
    let mut finish = straighten(mesh, route, own_repeats, bounds, work, report, observer)?;
    if !matches!(finish, Finish::Cycling) {
        return Ok(finish);
    }
    let length_of_route = |route: &Route| points_of(mesh, route).map_or(0.0, |points| length_of(&points, route.closed));
    go_on(observer, Step::VertexPass)?;
    let mut length = length_of_route(route);
    for _ in 0..MOST_RUNS {
        if !matches!(finish, Finish::Cycling) {
            break;
        }
        // Where edges have no length, no angle tells which side of a vertex is better.
        finish = straighten(&mesh.shaken().mesh, route, own_repeats, bounds, work, report, observer)?;
        snap_shaken(mesh, route);
        straighten_between_vertices(mesh, route);
        // In needles angles are below what double precision can tell: there length is the judge.
        let before = std::mem::replace(&mut length, length_of_route(route));
        if matches!(finish, Finish::Cycling) && length >= before * (1.0 - SETTLED_FALL) {
            finish = Finish::Settled;
        }
    }
    go_on(observer, Step::VertexPass)?;
    Ok(finish)
}

/// Rounds on all legs, and loops cut out, until neither changes anything; at most so many, with or without stages.
fn straighten(
    mesh: &SurfaceMesh,
    route: &mut Route,
    own_repeats: &OwnRepeats,
    (limit, stages): (u32, bool),
    work: &mut Workspace,
    report: &mut Report,
    observer: &mut dyn Observer,
) -> Result<Finish> {
    loop {
        let changes = |report: &Report| report.vertex_passes + report.loops_removed;
        let before = changes(report);
        let finish = if route.pins.is_empty() {
            smooth_loop(mesh, route, limit, stages, work, report, observer)?
        } else {
            smooth_legs(mesh, route, limit, stages, work, report, observer)?
        };
        // Cutting a loop shortens the line, so this ends; measured, it happens on CAD slivers alone.
        go_on(observer, Step::VertexPass)?;
        if changes(report) == before {
            // At most letters at the ends were dropped: what the strip repeats, it repeated before.
            return Ok(finish);
        }
        let cuts = own_repeats.cut_new_loops(mesh, route);
        go_on(observer, Step::VertexPass)?;
        report.loops_removed += cuts;
        if cuts == 0 || report.iterations >= limit {
            return Ok(finish);
        }
    }
}

/// Crossings nearer to a vertex than the shaken mesh can tell are at it.
fn snap_shaken(mesh: &SurfaceMesh, route: &mut Route) {
    for leg in &mut route.legs {
        for (&letter, t) in leg.word.iter().zip(&mut leg.parameters) {
            let length = mesh.edge_length(letter);
            let [low, high] = mesh.sorted_ends(letter).map(|v| SNAP_REACHES * mesh.shaken().reach(v.index()));
            if *t <= 0.5 && *t * length <= low {
                *t = 0.0;
            } else if *t > 0.5 && (1.0 - *t) * length <= high {
                *t = 1.0;
            }
        }
    }
}

/// Crossings where the line between two neighbouring vertices of it is straight on the mesh itself: next to short segments
/// what a vertex was moved by would be a bend that can be seen.
fn straighten_between_vertices(mesh: &SurfaceMesh, route: &mut Route) {
    let ends = |i: usize| Some([route.start_pin(i)?, route.end_pin(i)?].map(|pin| mesh.position_of(pin)));
    let ends: Vec<_> = (0..route.legs.len()).map(ends).collect();
    let (mut unfolding, mut word, mut straight) = (Unfolding::default(), Vec::new(), Vec::new());
    for (leg, ends) in route.legs.iter_mut().zip(ends) {
        let at_vertex = |i: usize| [0.0, 1.0].contains(&leg.parameters[i]);
        let bounds: Vec<usize> = (0..leg.word.len()).filter(|&i| at_vertex(i)).collect();
        let place = |i: usize| crossing_position(mesh, leg.word[i], leg.parameters[i]);
        let count = leg.word.len();
        // From each vertex to the next, and from and to the pins; of a loop on beyond its last letter, across the seam.
        let mut stretches: Vec<_> =
            bounds.windows(2).map(|pair| (pair[0] + 1..pair[1], place(pair[0]), place(pair[1]))).collect();
        match (ends, bounds.first(), bounds.last()) {
            (Some([start, end]), Some(&first), Some(&last)) => {
                stretches.push((0..first, start, place(first)));
                stretches.push((last + 1..count, place(last), end));
            }
            (Some([start, end]), ..) => stretches.push((0..count, start, end)),
            (None, Some(&first), Some(&last)) => stretches.push((last + 1..count + first, place(last), place(first))),
            (None, ..) => {}
        }
        for (letters, start, end) in stretches {
            straight.clear();
            word.clear();
            word.extend(letters.clone().map(|i| leg.word[i % count]));
            unfolding.unfold(mesh, start, &word, end);
            cross_straight(mesh, &unfolding, &word, &mut straight);
            let is_near = |(i, s): (usize, &f64)| (leg.parameters[i % count] - s).abs() <= NEAR_SHARE;
            // Across an edge without length the strip unfolds in no one way.
            if letters.clone().zip(&straight).all(is_near) {
                letters.zip(&straight).for_each(|(i, &s)| leg.parameters[i % count] = s);
            }
        }
    }
}

enum Finish {
    Settled,
    Cycling,
    Limited,
}

fn smooth_legs(
    mesh: &SurfaceMesh,
    route: &mut Route,
    limit: u32,
    stages: bool,
    work: &mut Workspace,
    report: &mut Report,
    observer: &mut dyn Observer,
) -> Result<Finish> {
    let mut pauses = Pauses::new(observer, Step::Relax);
    pauses.pause()?;
    let mut solvers: Vec<GeodesicLeg> = Vec::with_capacity(route.legs.len());
    for (i, leg) in route.legs.iter().enumerate() {
        let (Some(start), Some(end)) = (route.start_pin(i), route.end_pin(i)) else { continue };
        solvers.push(GeodesicLeg::new(mesh, leg, start, end, work, report, &mut pauses)?);
    }
    report.iterations += 1;
    let take_legs = |solvers: &[GeodesicLeg], work: &mut Workspace| -> Vec<Leg> {
        solvers.iter().map(|solver| solver.to_leg(mesh, work)).collect()
    };
    let keep_stage = |route: &Route, legs: Vec<Leg>, report: &mut Report| {
        if stages {
            report.stages.extend(points_of(mesh, &Route { legs, ..route.clone() }));
        }
    };
    if stages {
        keep_stage(route, take_legs(&solvers, work), report);
    }
    while solvers.iter().any(GeodesicLeg::is_active) && report.iterations < limit {
        let mut pauses = Pauses::new(observer, Step::VertexPass);
        pauses.pause()?;
        let before = (report.vertex_passes, report.funnels, report.loops_removed);
        for solver in solvers.iter_mut().filter(|s| s.is_active()) {
            solver.advance(mesh, work, report, &mut pauses)?;
        }
        // The last round only finds that nothing is left to do.
        if (report.vertex_passes, report.funnels, report.loops_removed) != before
            || solvers.iter().any(GeodesicLeg::is_active)
        {
            report.iterations += 1;
            if stages {
                keep_stage(route, take_legs(&solvers, work), report);
            }
        }
    }
    route.legs = take_legs(&solvers, work);
    Ok(if solvers.iter().any(GeodesicLeg::is_active) {
        Finish::Limited
    } else if solvers.iter().any(|s| s.is_capped) {
        Finish::Cycling
    } else {
        Finish::Settled
    })
}

fn smooth_loop(
    mesh: &SurfaceMesh,
    route: &mut Route,
    limit: u32,
    stages: bool,
    work: &mut Workspace,
    report: &mut Report,
    observer: &mut dyn Observer,
) -> Result<Finish> {
    go_on(observer, Step::Relax)?;
    let word = std::mem::take(&mut route.legs[0].word);
    let shape = Route { closed: true, pins: Vec::new(), legs: Vec::new() };
    let mut is_limited = false;
    let (leg, is_capped) = straighten_loop(mesh, word, work, report, observer, |leg, report| {
        report.iterations += 1;
        if stages {
            report.stages.extend(points_of(mesh, &Route { legs: vec![leg.clone()], ..shape.clone() }));
        }
        is_limited = report.iterations >= limit;
        !is_limited
    })?;
    route.legs[0] = leg;
    Ok(match (is_limited, is_capped) {
        (true, _) => Finish::Limited,
        (false, true) => Finish::Cycling,
        (false, false) => Finish::Settled,
    })
}

/// Points of a route, for the stages; `None` never happens for routes that a filter made.
pub fn points_of(mesh: &SurfaceMesh, route: &Route) -> Option<Vec<DVec3>> {
    Polyline::outline(mesh, route).map(|(points, _)| points)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ids::TriangleId;

    /// A ring of `count` letters, one for each spoke of vertex 0 in the plane, the rim at distance 1.
    fn ring(count: u32) -> (SurfaceMesh, Route) {
        let turn = |i: u32| f64::from(i) * std::f64::consts::TAU / f64::from(count);
        let rim = (0..count).map(|i| DVec3::new(turn(i).cos(), turn(i).sin(), 0.0));
        let positions = std::iter::once(DVec3::ZERO).chain(rim).collect();
        let triangles = (0..count).map(|i| [0, 1 + i, 1 + (i + 1) % count]).collect();
        let mesh = SurfaceMesh::new(positions, triangles, None).expect("legal");
        // Triangle i lies between spokes i and i + 1; letter i crosses spoke i out of triangle i - 1.
        let word: Vec<_> = (0..count).map(|i| TriangleId((i + count - 1) % count).halfedge(2)).collect();
        let leg = Leg { first: word[0].triangle(), parameters: vec![0.5; word.len()], word };
        (mesh, Route { closed: true, pins: Vec::new(), legs: vec![leg] })
    }

    #[test]
    fn a_loop_is_straight_between_its_vertices_across_its_seam_too() {
        let (mesh, mut route) = ring(12);
        // Through the rim at spokes 10 and 2, and straight between them, but for what shaking leaves.
        let straight = [(11, 0.5 / 0.75_f64.sqrt()), (0, 0.5), (1, 0.5 / 0.75_f64.sqrt())];
        let parameters = &mut route.legs[0].parameters;
        (parameters[2], parameters[10]) = (1.0, 1.0);
        straight.into_iter().zip([1e-8, -3e-8, 2e-8]).for_each(|((i, t), off)| parameters[i] = t + off);
        let before = parameters.clone();
        straighten_between_vertices(&mesh, &mut route);
        let after = &route.legs[0].parameters;
        for (i, t) in straight {
            assert!((after[i] - t).abs() < 1e-15, "letter {i} at {} of {t}", after[i]);
        }
        // Round the vertex there is no straight way from spoke 2 to spoke 10.
        assert_eq!(after[2..=10], before[2..=10]);
    }
}
