//! Lines whose legs do not know of each other: each leg between two pins is smoothed as a line of its own.
//!
//! So a leg depends on its own picks alone, to the bit, and can be taken over into a line in which other picks have
//! changed. Holds how the reports of the legs become that of the line.

use glam::DVec3;

use crate::error::Result;
use crate::kept::LegNote;
use crate::mesh::SurfaceMesh;
use crate::report::{Report, StopReason};
use crate::route::Route;
use crate::smooth_geodesic::points_of;

/// Smooths each leg of `route` that nothing is known of by `smooth`, which is given a route of that leg alone; a ring
/// without pins whole. Returns why each leg's smoothing ended.
///
/// # Errors
/// Those of `smooth`.
pub fn smooth_leg_by_leg(
    mesh: &SurfaceMesh,
    route: &mut Route,
    known: &[Option<LegNote>],
    with_stages: bool,
    report: &mut Report,
    mut smooth: impl FnMut(&mut Route, &mut Report) -> Result<()>,
) -> Result<Vec<StopReason>> {
    if route.pins.is_empty() {
        smooth(route, report)?;
        return Ok(vec![report.stop_reason; route.legs.len()]);
    }
    let mut stop_reasons = Vec::with_capacity(route.legs.len());
    let mut stages: Vec<Vec<Vec<DVec3>>> = Vec::new();
    for (i, note) in known.iter().enumerate() {
        let (Some(&start), Some(&end)) = (route.start_pin(i), route.end_pin(i)) else { continue };
        let mut leg_report = Report::default();
        let pins = vec![start, end];
        let mut alone = Route { closed: false, pins, legs: vec![route.legs[i].take()] };
        match note {
            Some(note) => leg_report.stop_reason = note.stop_reason,
            None => smooth(&mut alone, &mut leg_report)?,
        }
        stop_reasons.push(leg_report.stop_reason);
        if with_stages {
            let mut of_leg = std::mem::take(&mut leg_report.stages);
            if of_leg.is_empty() {
                of_leg.extend(points_of(mesh, &alone));
            }
            stages.push(of_leg);
        }
        route.legs[i] = alone.legs.swap_remove(0);
        add_counts(report, &leg_report);
    }
    report.stop_reason = stop_reasons.iter().copied().max().unwrap_or(StopReason::Converged);
    let rounds = stages.iter().map(Vec::len).max().unwrap_or(0);
    report.stages.extend((0..rounds).map(|round| join_stages(&stages, round, route.closed)));
    Ok(stop_reasons)
}

/// Work adds up; rounds go on side by side.
fn add_counts(report: &mut Report, leg: &Report) {
    report.iterations = report.iterations.max(leg.iterations);
    report.moves += leg.moves;
    report.newton_steps += leg.newton_steps;
    report.funnels += leg.funnels;
    report.vertex_passes += leg.vertex_passes;
    report.loops_removed += leg.loops_removed;
}

/// The points of all legs after a round, or after their last one; pins, which two legs have in common, once.
fn join_stages(stages: &[Vec<Vec<DVec3>>], round: usize, closed: bool) -> Vec<DVec3> {
    let mut points: Vec<DVec3> = Vec::new();
    for of_leg in stages {
        let leg_points = &of_leg[round.min(of_leg.len() - 1)];
        points.extend(&leg_points[usize::from(!points.is_empty())..]);
    }
    if closed && points.len() > 1 {
        points.pop();
    }
    points
}
