//! The driver: options are checked, picks joined (steps A and B), their route smoothed (steps C and D), and put together.
//!
//! Holds no geometry of its own; every step lies in a room of its own.

use std::ops::ControlFlow;

use glam::DVec3;

use crate::error::{Error, Result};
use crate::filter::cubic::Cubic;
use crate::filter::linear::Linear;
use crate::join::{Input, join_picks};
use crate::mesh::SurfaceMesh;
use crate::options::{Filter, Options, Solver};
use crate::polyline::{Polyline, length_of};
use crate::report::{Observer, Report, Step};
use crate::route::Route;
use crate::smooth_fair::smooth_fair;
use crate::smooth_geodesic::smooth_geodesic;
use crate::smooth_sliding::smooth_sliding;
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
    options.check()?;
    let mut report = Report::default();
    go_on(observer, Step::Search)?;
    let input = join_picks(mesh, picks, options, &mut report, observer)?;
    smooth_input(mesh, input, options, report, observer)
}

/// Smooths what steps A and B made, wherever it came from: pins, strips and start parameters. `report` holds the work of
/// those steps.
///
/// # Errors
/// A closed line that collapses, or [`Error::Interrupted`] when the observer says so.
pub fn smooth_input(
    mesh: &SurfaceMesh,
    input: Input,
    options: &Options,
    mut report: Report,
    observer: &mut dyn Observer,
) -> Result<Polyline> {
    let Input { mut route, is_pinned, is_drawn } = input;
    if options.filter != Filter::None {
        let (points, strip_triangles) = Polyline::outline(mesh, &route).expect(FITS);
        note_start(&mut report, &points, route.closed, strip_triangles, options);
    }
    match options.filter {
        _ if route.legs.is_empty() => {}
        Filter::None => {}
        Filter::Geodesic => smooth_geodesic(mesh, &mut route, options, &mut report, observer)?,
        Filter::Linear if options.solver == Solver::Auto => {
            // The locally shortest line is near the filter's fixed point, on the right side of nearly every vertex.
            straighten_start(mesh, &mut route, options, &mut report, observer)?;
            smooth_sliding(mesh, &mut route, &Linear, options, &mut report, observer)?;
        }
        Filter::Linear => smooth_sliding(mesh, &mut route, &Linear, options, &mut report, observer)?,
        Filter::Cubic => {
            smooth_sliding(
                mesh,
                &mut route,
                &Cubic { knots: options.knots, support: options.support },
                options,
                &mut report,
                observer,
            )?;
        }
        Filter::Fair => {
            if !is_drawn {
                straighten_start(mesh, &mut route, options, &mut report, observer)?;
            }
            smooth_fair(mesh, &mut route, &is_pinned, is_drawn, options, &mut report, observer)?;
        }
    }
    go_on(observer, Step::Assemble)?;
    let mut line = assemble(mesh, route, report);
    if options.filter == Filter::None {
        note_start(&mut line.report, &line.points, line.closed, line.strip.len(), options);
    }
    // A single pin does not hold a closed line open.
    if line.closed && line.points.len() < 2 {
        return Err(Error::Collapsed { iterations: line.report.iterations });
    }
    Ok(line)
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
    smooth_geodesic(mesh, route, &start, report, observer)?;
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

/// Why a route can be assembled.
const FITS: &str = "legs of a route that the driver made fit its pins";

fn assemble(mesh: &SurfaceMesh, route: Route, report: Report) -> Polyline {
    Polyline::assemble(mesh, route, report).expect(FITS)
}

/// Tells the observer of a step; an error when it wants to stop.
pub fn go_on(observer: &mut dyn Observer, step: Step) -> Result<()> {
    match observer.step(step) {
        ControlFlow::Continue(()) => Ok(()),
        ControlFlow::Break(()) => Err(Error::Interrupted),
    }
}
