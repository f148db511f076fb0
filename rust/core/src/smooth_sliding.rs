//! The paper's filters on a whole line: step C by sliding vertices, step D where they meet mesh vertices, and again.
//!
//! Holds the rounds, limits and stop reasons. How one vertex is passed is in `sliding_pass`.

use std::collections::HashSet;
use std::ops::{ControlFlow, Range};

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
use crate::relax::heap::{HeapEnd, HeapOutcome, relax_by_heap};
use crate::relax::implicit::{relax_implicitly, relax_ranges_implicitly};
use crate::relax::newton::{NEWTON_TOLERANCE, relax_by_newton};
use crate::report::{Observer, Report, Step, StopReason};
use crate::route::Route;
use crate::sliding_pass::{MERGING, PassWork, pass_vertices};
use crate::sliding_stages::{STEPS_A_ROUND, Stage, choose_stages};
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
    let mut stages =
        choose_stages(filter, options, by_newton, last_threshold, crossings, known.iter().any(Option::is_some));
    let mut stage = stages.pop_front().unwrap_or(Stage::Heap { threshold: last_threshold, moves: None });
    let mut most_moves = 0;
    if let Stage::Heap { moves: Some(moves), .. } = stage {
        most_moves = moves;
    }
    let mut seen: HashSet<Vec<(HalfedgeId, u8)>> = HashSet::new();
    let mut work = PassWork::default();
    work.at_once = options.solver == Solver::Auto;
    let mut is_finer = false;
    let mut time_step = FIRST_TIME_STEP;
    // The line before the last passes, when Newton had brought it to rest.
    let mut settled: Option<Route> = None;
    let mut own_repeats = OwnRepeats::of_route(mesh, route);
    go_on(observer, Step::Relax)?;
    loop {
        trim_legs(mesh, route);
        go_on(observer, Step::Relax)?;
        let mut beads = Beads::of_route(mesh, route);
        go_on(observer, Step::Relax)?;
        let is_newton = by_newton && settle_by_newton(&mut beads, filter, report, observer)?;
        if let (true, false, Some(before)) = (by_newton, is_newton, settled.take()) {
            // The passes of the last round lead to a strip on which the line does not come to rest: without them.
            *route = before;
            work.is_strict = true;
            continue;
        }
        let end = if is_newton {
            HeapEnd::Settled
        } else if let Stage::Implicit { threshold, steps } = &mut stage {
            let near_open = beads.near_open(route, &is_open, 2 * filter.reach());
            let (most, time_step) = (STEPS_A_ROUND.min(*steps), &mut time_step);
            let ask = || go_on(observer, Step::Relax);
            let outcome = match near_open {
                None => relax_implicitly(&mut beads, filter, *threshold, most, time_step, ask)?,
                Some(near) => relax_ranges_implicitly(&mut beads, &near, filter, *threshold, most, time_step, ask)?,
            };
            report.newton_steps += outcome.steps;
            *steps = if outcome.is_settled { 0 } else { *steps - most };
            HeapEnd::Settled
        } else {
            // Also where Newton did not settle: the heap goes on from the best place that it found.
            let share = if by_newton { MOVES_AFTER_NEWTON * crossings as u64 } else { most_moves };
            let moves_left = most_moves.saturating_sub(report.moves).min(share);
            let first = beads.near_open(route, &is_open, 2 * filter.reach());
            let outcome = slide_by_heap(&mut beads, filter, stage.threshold(), moves_left, first.as_deref(), observer)?;
            report.moves += outcome.moves;
            outcome.end
        };
        beads.write_to(route, &mut is_open);
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
        match end {
            HeapEnd::Stopped => {
                report.stop_reason = StopReason::MaxIterations;
                return Ok(());
            }
            HeapEnd::Swinging | HeapEnd::Settled => {}
        }
        refuse_collapsed(mesh, route, report.iterations)?;
        go_on(observer, Step::VertexPass)?;
        let has_rounds = report.iterations < limit;
        let passes_before = report.vertex_passes;
        let changes = if has_rounds {
            let mut pauses = Pauses::new(observer, Step::VertexPass);
            pass_vertices(mesh, route, &is_open, filter, stage.threshold(), report, &mut work, &mut pauses)?
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
        } else if matches!(stage, Stage::Implicit { steps: 1.., .. }) {
            is_finer = true;
            continue;
        } else if let Some(next) = stages.pop_front() {
            is_finer = true;
            if matches!(stage, Stage::Implicit { .. }) {
                work.forget_changes();
                seen.clear();
            }
            go_to(&mut stage, next, &mut most_moves, report.moves);
            continue;
        } else {
            let has_merged = has_crossing_near_vertex(route, MERGING);
            report.stop_reason = match end {
                HeapEnd::Swinging => StopReason::Cycle,
                // Whether step D would have found something to do was not asked.
                _ if !has_rounds && has_merged => StopReason::MaxIterations,
                _ if has_crossing_near_vertex(route, AT_VERTEX) => StopReason::ConvergedAtVertices,
                _ => StopReason::Converged,
            };
            return Ok(());
        }
        is_finer = false;
        if let (Stage::Implicit { steps: 0, .. }, Some(&next)) = (stage, stages.front()) {
            stages.pop_front();
            work.forget_changes();
            seen.clear();
            go_to(&mut stage, next, &mut most_moves, report.moves);
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

/// Begins a stage after so many moves.
fn go_to(stage: &mut Stage, next: Stage, most_moves: &mut u64, moves: u64) {
    if let Stage::Heap { moves: Some(more), .. } = next {
        *most_moves = moves + more;
    }
    *stage = next;
}

/// The first implicit step, in the motion's own time: about as far as each crossing is from its target.
const FIRST_TIME_STEP: f64 = 1.0;

/// A crossing nearer than this to a mesh vertex, in barycentric units, is at it when the stop reason is told.
const AT_VERTEX: f64 = 1e-6;

fn has_crossing_near_vertex(route: &Route, distance: f64) -> bool {
    route.legs.iter().flat_map(|leg| &leg.parameters).any(|&t| t <= distance || t >= 1.0 - distance)
}

/// Newton, and where it gets stuck (vertices that go on and off the ends of their edges) some moves of the heap and Newton
/// again. False when even that does not settle.
fn settle_by_newton(
    beads: &mut Beads,
    filter: &impl SlidingFilter,
    report: &mut Report,
    observer: &mut dyn Observer,
) -> Result<bool> {
    for _ in 0..NEWTON_STARTS {
        let outcome = relax_by_newton(beads, &mut Pauses::new(observer, Step::Relax))?;
        report.newton_steps += outcome.steps;
        if outcome.is_settled {
            return Ok(true);
        }
        let moves = MOVES_BETWEEN_STARTS * beads.len() as u64;
        report.moves += slide_by_heap(beads, filter, NEWTON_TOLERANCE, moves, None, observer)?.moves;
    }
    Ok(false)
}

/// The heap, which the observer may end.
fn slide_by_heap(
    beads: &mut Beads,
    filter: &impl SlidingFilter,
    threshold: f64,
    move_limit: u64,
    first: Option<&[Range<usize>]>,
    observer: &mut dyn Observer,
) -> Result<HeapOutcome> {
    let mut is_stopped = false;
    let outcome = relax_by_heap(beads, filter, threshold, move_limit, first, || {
        let flow = observer.step(Step::Relax);
        is_stopped = flow == ControlFlow::Break(());
        flow
    });
    if is_stopped { Err(Error::Interrupted) } else { Ok(outcome) }
}

/// Moves of the heap where Newton has failed for good, for each crossing; the line is then as near its limit as it gets.
const MOVES_AFTER_NEWTON: u64 = 500;

/// Times that Newton is tried within one step C.
const NEWTON_STARTS: u32 = 8;

/// Moves of the heap between two tries, for each vertex.
const MOVES_BETWEEN_STARTS: u64 = 20;

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
