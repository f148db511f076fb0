//! The driver: options are checked, picks joined (steps A and B), their route smoothed (steps C and D), and put together.
//!
//! Holds no geometry of its own; every step lies in a room of its own.

use std::ops::ControlFlow;

use glam::DVec3;

use crate::error::{Error, Result};
use crate::fair_again::{FairBefore, smooth_fair_again};
use crate::filter::cubic::Cubic;
use crate::filter::linear::Linear;
use crate::join::{Input, join_picks, place_picks};
use crate::kept::{Kept, KeptFair, LegNote, LegStart, Made};
use crate::leg_by_leg::smooth_leg_by_leg;
use crate::mesh::SurfaceMesh;
use crate::options::{Filter, Options, Solver};
use crate::pauses::Pauses;
use crate::polyline::{Polyline, length_of};
use crate::report::{Observer, Report, Step, StopReason};
use crate::route::Route;
use crate::smooth_fair::{FairTask, smooth_fair};
use crate::smooth_geodesic::smooth_geodesic;
use crate::smooth_sliding::smooth_sliding;
use crate::spot::join_at;
use crate::surface_point::Pick;

/// A smooth line through or near `picks`.
///
/// # Errors
/// Options or picks out of range, picks that are not connected, a closed line that collapses, or
/// [`Error::Interrupted`] when the observer says so.
pub fn polyline(
    mesh: &SurfaceMesh,
    picks: &[Pick],
    options: &Options,
    observer: &mut dyn Observer,
) -> Result<Polyline> {
    Ok(polyline_kept(mesh, picks, options, observer)?.line)
}

/// As [`polyline`], with what `remake` needs for the same line with other picks.
///
/// # Errors
/// As [`polyline`].
pub fn polyline_kept(
    mesh: &SurfaceMesh,
    picks: &[Pick],
    options: &Options,
    observer: &mut dyn Observer,
) -> Result<Made> {
    options.check()?;
    let mut report = Report::default();
    go_on(observer, Step::Search)?;
    let stations = place_picks(mesh, picks, options)?;
    let input = join_picks(mesh, &stations, options, &mut report, observer)?;
    let (line, notes, fair) = smooth_input(mesh, input, None, options, report, observer)?;
    Ok(Made { line, kept: Kept { options: options.clone(), stations, notes, fair } })
}

/// Smooths what steps A and B made, wherever it came from: pins, strips and start parameters. `report` holds the work of
/// those steps; `before` the line that some legs were taken from. Returns what [`Kept`] holds as well.
///
/// # Errors
/// A closed line that collapses, or [`Error::Interrupted`] when the observer says so.
pub fn smooth_input(
    mesh: &SurfaceMesh,
    input: Input,
    before: Option<&FairBefore>,
    options: &Options,
    mut report: Report,
    observer: &mut dyn Observer,
) -> Result<(Polyline, Vec<LegNote>, KeptFair)> {
    let Input { mut route, is_pinned, is_drawn, known } = input;
    report.kept_legs = known.iter().flatten().count();
    let start_of = |(i, note): (usize, &Option<LegNote>)| match note {
        Some(note) => note.start,
        None if options.filter == Filter::None => LegStart::without_length(mesh, &route.legs[i]),
        None => LegStart::of_leg(mesh, &route, i),
    };
    let starts: Vec<LegStart> = known.iter().enumerate().map(start_of).collect();
    go_on(observer, Step::Search)?;
    if options.filter != Filter::None {
        if report.kept_legs == 0 && (options.stages || route.pins.is_empty()) {
            let (points, strip_triangles) =
                Polyline::outline_with_pauses(mesh, &route, &mut Pauses::new(observer, Step::Search))?.expect(FITS);
            go_on(observer, Step::Search)?;
            note_start(&mut report, &points, route.closed, strip_triangles, options);
        } else {
            note_kept_start(mesh, &mut report, &route, &starts);
        }
    }
    let mut stop_reasons = vec![StopReason::Converged; known.len()];
    let mut fair = KeptFair::default();
    match options.filter {
        _ if route.legs.is_empty() => {}
        Filter::None => route.part_equal_points(mesh),
        Filter::Geodesic => {
            let mut work = mesh.workspaces().take();
            let straighten = |leg: &mut Route, report: &mut Report| {
                smooth_geodesic(mesh, leg, options, &mut work, report, &mut *observer)
            };
            stop_reasons = smooth_leg_by_leg(mesh, &mut route, &known, options.stages, &mut report, straighten)?;
            mesh.workspaces().put_back(work.trimmed());
        }
        Filter::Linear => {
            let straighten = |leg: &mut Route, report: &mut Report| {
                if options.solver == Solver::Auto {
                    // The locally shortest line is near the filter's fixed point, on the right side of nearly every vertex.
                    straighten_start(mesh, leg, options, report, &mut *observer)?;
                }
                smooth_sliding(mesh, leg, &[None], &Linear, options, report, &mut *observer)
            };
            stop_reasons = smooth_leg_by_leg(mesh, &mut route, &known, options.stages, &mut report, straighten)?;
        }
        Filter::Cubic => {
            let filter = Cubic { knots: options.knots, support: options.support };
            smooth_sliding(mesh, &mut route, &known, &filter, options, &mut report, observer)?;
            // A leg that found no rest before is not looked at as long as nothing next to it moves.
            let unrest = known.iter().flatten().map(|note| note.stop_reason).filter(|&r| r >= StopReason::Cycle).max();
            let own = report.stop_reason;
            report.stop_reason = own.max(unrest.unwrap_or(own));
            stop_reasons = known.iter().map(|note| note.map_or(own, |n| n.stop_reason.max(own))).collect();
        }
        Filter::Fair => {
            if !is_drawn {
                let straighten =
                    |leg: &mut Route, report: &mut Report| straighten_start(mesh, leg, options, report, &mut *observer);
                smooth_leg_by_leg(mesh, &mut route, &known, false, &mut report, straighten)?;
            }
            fair.input.clone_from(&route.legs);
            let task = FairTask { mesh, is_pinned: &is_pinned, is_drawn, is_draft: report.kept_legs > 0, options };
            match before.filter(|_| task.is_draft) {
                Some(before) => fair.made_at = smooth_fair_again(&task, before, &mut route, &mut report, observer)?,
                None => smooth_fair(&task, &mut route, &mut report, observer)?,
            }
        }
    }
    go_on(observer, Step::Assemble)?;
    let mut line = assemble(mesh, route, report, observer)?;
    if options.filter == Filter::None {
        note_start(&mut line.report, &line.points, line.closed, line.strip.len(), options);
    }
    // A single pin does not hold a closed line open.
    if line.closed && line.points.len() < 2 {
        return Err(Error::Collapsed { iterations: line.report.iterations });
    }
    let notes = starts.into_iter().zip(stop_reasons).map(|(start, stop_reason)| LegNote { start, stop_reason });
    Ok((line, notes.collect(), fair))
}

/// Straightens a route that another filter starts from: its rounds are neither limited nor counted, nor kept as stages.
fn straighten_start(
    mesh: &SurfaceMesh,
    route: &mut Route,
    options: &Options,
    report: &mut Report,
    observer: &mut dyn Observer,
) -> Result<()> {
    let start = Options { max_iterations: None, stages: false, ..options.clone() };
    let mut work = mesh.workspaces().take();
    smooth_geodesic(mesh, route, &start, &mut work, report, observer)?;
    mesh.workspaces().put_back(work.trimmed());
    report.iterations = 0;
    Ok(())
}

/// Notes in `report` what the line was before any smoothing.
fn note_start(report: &mut Report, points: &[DVec3], closed: bool, strip_triangles: usize, options: &Options) {
    report.start_length = length_of(points, closed);
    report.strip_triangles = strip_triangles;
    if options.stages {
        report.stages.push(points.to_vec());
    }
}

/// The same from what was noted of the legs, some of which may be smooth already; without stages.
fn note_kept_start(mesh: &SurfaceMesh, report: &mut Report, route: &Route, starts: &[LegStart]) {
    // Folded from 0, as the sum of nothing is -0 in Rust.
    report.start_length = starts.iter().fold(0.0, |sum, start| sum + start.length);
    let letters: usize = starts.iter().map(|start| start.letters).sum();
    let joins = (0..starts.len()).filter(|&i| route.closed || i > 0).filter_map(|i| {
        let before = starts[(i + starts.len() - 1) % starts.len()].last;
        Some(join_at(mesh, route.start_pin(i)?, before, starts[i].first)?.len())
    });
    let is_round = route.closed && letters > 0;
    report.strip_triangles = 1 + letters + joins.sum::<usize>() - usize::from(is_round);
}

/// Why a route can be assembled.
const FITS: &str = "legs of a route that the driver made fit its pins";

fn assemble(mesh: &SurfaceMesh, route: Route, report: Report, observer: &mut dyn Observer) -> Result<Polyline> {
    let mut pauses = Pauses::new(observer, Step::Assemble);
    Ok(Polyline::assemble_with_pauses(mesh, route, report, &mut pauses)?.expect(FITS))
}

/// Tells the observer of a step; an error when it wants to stop.
pub fn go_on(observer: &mut dyn Observer, step: Step) -> Result<()> {
    match observer.step(step) {
        ControlFlow::Continue(()) => Ok(()),
        ControlFlow::Break(()) => Err(Error::Interrupted),
    }
}
