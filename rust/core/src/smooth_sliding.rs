//! The paper's filters on a whole line: step C by sliding vertices, step D where they meet mesh vertices, and again.
//!
//! Holds the rounds, limits and stop reasons. How one vertex is passed is in `sliding_pass`.

use std::collections::HashSet;

use crate::error::{Error, Result};
use crate::filter::SlidingFilter;
use crate::ids::HalfedgeId;
use crate::kept::LegNote;
use crate::leg::Leg;
use crate::loops::OwnRepeats;
use crate::mesh::SurfaceMesh;
use crate::options::{Filter, Options, PAPER_MAX_ITERATIONS, Solver};
use crate::pauses::Pauses;
use crate::relax::beads::Beads;
use crate::relax::newton::NEWTON_TOLERANCE;
use crate::relax::swing::SlideEnd;
use crate::report::{Observer, Report, Step, StopReason};
use crate::route::Route;
use crate::sliding_pass::{MERGING, PassWork, pass_vertices};
use crate::sliding_stages::{Order, choose_stages};
use crate::sliding_steps::{Sliders, Stages, StepEnd};
use crate::smooth::go_on;
use crate::smooth_geodesic::points_of;
use crate::spot::spot_of;
use crate::strip::entered_triangle;
use crate::surface_point::SurfacePoint;

/// Smooths `route` by a filter of the paper's kind. Legs that something is known of are at rest: they are looked at only
/// where what lies next to them moves, and passed over vertices only once they have moved themselves.
///
/// # Errors
/// [`Error::Collapsed`], [`Error::Interrupted`].
pub fn smooth_sliding(
    mesh: &SurfaceMesh,
    route: &mut Route,
    known: &[Option<LegNote>],
    filter: &impl SlidingFilter,
    options: &Options,
    report: &mut Report,
    observer: &mut dyn Observer,
) -> Result<()> {
    let by_newton = options.filter == Filter::Linear && options.solver == Solver::Auto;
    let last_threshold = if by_newton { NEWTON_TOLERANCE } else { options.threshold };
    let limit = options.max_iterations.unwrap_or(PAPER_MAX_ITERATIONS);
    let mut is_open: Vec<bool> = known.iter().map(Option::is_none).collect();
    let crossings: usize = (0..known.len()).filter(|&i| is_open[i]).map(|i| route.legs[i].word.len()).sum();
    let is_draft = known.iter().any(Option::is_some);
    let stages = choose_stages(filter, options, by_newton, last_threshold, crossings, is_draft);
    let order = Order::of(filter, options);
    let mut stages = Stages::new(stages, last_threshold, crossings);
    let mut seen: HashSet<Vec<(HalfedgeId, u8)>> = HashSet::new();
    let mut work = PassWork::default();
    work.at_once = options.solver == Solver::Auto;
    let mut is_finer = false;
    // The line before the last passes, when Newton had brought it to rest.
    let mut settled: Option<Route> = None;
    // The line of the last step C, when sweeps had brought each of its crossings to rest to a threshold; the paper's heap judges all
    // anew.
    let mut rested: Option<(Beads, f64)> = None;
    let mut own_repeats = OwnRepeats::of_route(mesh, route);
    go_on(observer, Step::Relax)?;
    loop {
        trim_legs(mesh, route);
        go_on(observer, Step::Relax)?;
        let mut beads = Beads::of_route(mesh, route);
        go_on(observer, Step::Relax)?;
        let margin = 2 * filter.reach();
        let may_be_off = match &rested {
            Some((before, threshold)) if *threshold == stages.threshold() => Some(beads.changed_since(before, margin)),
            _ => beads.near_open(route, &is_open, margin),
        };
        let mut sliders = Sliders { beads: &mut beads, may_be_off: may_be_off.as_deref(), order };
        let StepEnd { end, by_newton: is_newton } = stages.relax(&mut sliders, filter, report, observer)?;
        if let (true, false, Some(before)) = (by_newton, is_newton, settled.take()) {
            // The passes of the last round lead to a strip on which the line does not come to rest: without them.
            *route = before;
            work.is_strict = true;
            continue;
        }
        beads.write_to(route, &mut is_open);
        let is_at_rest = end == SlideEnd::Settled && order == Order::Sweeps && !stages.is_start();
        rested = is_at_rest.then(|| (beads, stages.threshold()));
        go_on(observer, Step::Relax)?;
        route.snap_to_vertices(mesh);
        if is_finer {
            // The same step C goes on.
            report.stages.pop();
        } else {
            report.iterations += 1;
        }
        if options.stages {
            report.stages.extend(points_of(mesh, route));
        }
        if is_newton {
            settled = Some(route.clone());
        }
        if stages.go_on_from(end, report.moves) {
            is_finer = true;
            continue;
        }
        if end == SlideEnd::Stopped {
            report.stop_reason = StopReason::MaxIterations;
            return Ok(());
        }
        refuse_collapsed(mesh, route, report.iterations)?;
        go_on(observer, Step::VertexPass)?;
        let has_rounds = report.iterations < limit;
        let passes_before = report.vertex_passes;
        let changes = if has_rounds {
            let mut pauses = Pauses::new(observer, Step::VertexPass);
            pass_vertices(mesh, route, &is_open, filter, stages.threshold(), report, &mut work, &mut pauses)?
        } else {
            0
        };
        go_on(observer, Step::VertexPass)?;
        if changes > 0 {
            if filter.reach() > 1 {
                own_repeats.follow(mesh, route);
                go_on(observer, Step::VertexPass)?;
            }
            let cuts = own_repeats.cut_new_loops(mesh, route);
            report.loops_removed += cuts;
            refuse_collapsed(mesh, route, report.iterations)?;
        } else if stages.has_steps() {
            is_finer = true;
            continue;
        } else if !stages.is_last_at_rest() {
            is_finer = true;
            if stages.is_start() {
                work.forget_changes();
                seen.clear();
            }
            stages.go_to_next(report.moves);
            continue;
        } else {
            let has_merged = has_crossing_near_vertex(route, MERGING);
            report.stop_reason = match end {
                SlideEnd::Swinging => StopReason::Cycle,
                // Whether step D would have found something to do was not asked.
                _ if !has_rounds && has_merged => StopReason::MaxIterations,
                _ if has_crossing_near_vertex(route, AT_VERTEX) => StopReason::ConvergedAtVertices,
                _ => StopReason::Converged,
            };
            return Ok(());
        }
        is_finer = false;
        if stages.is_start() && !stages.has_steps() && stages.go_to_next(report.moves) {
            work.forget_changes();
            seen.clear();
        }
        // Freeing merged vertices leaves the strip as it was and is limited vertex by vertex.
        if report.vertex_passes > passes_before && !seen.insert(state_of(route)) {
            if work.is_strict {
                report.stop_reason = StopReason::Cycle;
                return Ok(());
            }
            // The line came back from where it was passed to: from now on no vertex is passed that was passed before.
            work.is_strict = true;
        }
    }
}

/// A crossing nearer than this to a mesh vertex, in barycentric units, is at it when the stop reason is told.
const AT_VERTEX: f64 = 1e-6;

fn has_crossing_near_vertex(route: &Route, distance: f64) -> bool {
    route.legs.iter().flat_map(|leg| &leg.parameters).any(|&t| t <= distance || t >= 1.0 - distance)
}

/// The strip of a route, and which crossings are at mesh vertices, in a form that is equal for equal ones.
fn state_of(route: &Route) -> Vec<(HalfedgeId, u8)> {
    let place = |t: f64| u8::from(t <= MERGING) + 2 * u8::from(t >= 1.0 - MERGING);
    let mut state = Vec::new();
    for leg in &route.legs {
        state.extend(leg.word.iter().zip(&leg.parameters).map(|(&h, &t)| (h, place(t))));
        state.push((HalfedgeId(u32::MAX), 0));
    }
    if route.pins.is_empty() {
        // A closed line without pins has no first letter: begin with the lowest.
        state.pop();
        let lowest = state.iter().enumerate().min_by_key(|&(_, &letter)| letter).map_or(0, |(i, _)| i);
        state.rotate_left(lowest);
    }
    state
}

/// A closed line whose strip is gone, or turns round a single vertex, has shrunk to a point.
pub fn refuse_collapsed(mesh: &SurfaceMesh, route: &Route, iterations: u32) -> Result<()> {
    if !route.pins.is_empty() {
        return Ok(());
    }
    let word = &route.legs[0].word;
    let is_point = word
        .first()
        .is_none_or(|&first| mesh.ends(first).into_iter().any(|v| word.iter().all(|&h| mesh.touches(h, v))));
    if is_point { Err(Error::Collapsed { iterations }) } else { Ok(()) }
}

/// Drops letters next to a pin that lie on its own edge or touch its own vertex: the line may leave a pin by any triangle
/// that holds it.
pub fn trim_legs(mesh: &SurfaceMesh, route: &mut Route) {
    for i in 0..route.legs.len() {
        let (start, end) = (route.start_pin(i).copied(), route.end_pin(i).copied());
        if let (Some(start), Some(end)) = (start, end) {
            trim_leg(mesh, &mut route.legs[i], &start, &end);
        }
    }
}

fn trim_leg(mesh: &SurfaceMesh, leg: &mut Leg, start: &SurfacePoint, end: &SurfacePoint) {
    let (start, end) = (spot_of(mesh, start), spot_of(mesh, end));
    let at_start = leg.word.iter().take_while(|&&h| start.is_on(mesh, h)).count();
    if at_start > 0 {
        leg.first = entered_triangle(mesh, leg.word[at_start - 1]);
        leg.word.drain(..at_start);
        leg.parameters.drain(..at_start);
    }
    let at_end = leg.word.iter().rev().take_while(|&&h| end.is_on(mesh, h)).count();
    let kept = leg.word.len() - at_end;
    leg.word.truncate(kept);
    leg.parameters.truncate(kept);
}
