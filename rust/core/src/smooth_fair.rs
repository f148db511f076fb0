//! The `fair` filter on a whole line: its input, the rounds of Gauss-Newton steps and vertex passes, and the stop reason.
//!
//! Holds the rules of `detail_size`; the energy and one step are in `filter::fair`.

use std::collections::HashMap;

use crate::error::{OptionError, Result};
use crate::filter::fair::{END_GAP, Input, step_fair};
use crate::ids::VertexId;
use crate::join::merge_unpinned;
use crate::loops::OwnRepeats;
use crate::mesh::SurfaceMesh;
use crate::options::Options;
use crate::polyline::length_of;
use crate::report::{Observer, Report, Step, StopReason};
use crate::route::Route;
use crate::sliding_pass::pass_pressed;
use crate::smooth::go_on;
use crate::smooth_geodesic::{points_of, smooth_geodesic};
use crate::smooth_sliding::{refuse_collapsed, trim_legs};

/// Without closeness to something else: this share of the mean distance between picks, along the input.
const DEFAULT_DETAIL_SHARE: f64 = 0.25;

/// Times that a mesh vertex is passed; a line that comes back over it once more belongs there.
const MAX_PASSES_AT_VERTEX: u32 = 3;

/// A step that moves no vertex by more than this share of the mean segment is the last.
const SETTLED_MOVE: f64 = 1e-7;

/// Rounds without a limit of the caller's: each is one step, and moves the line over one row of mesh
/// vertices at most.
fn round_bound(letters: usize) -> u32 {
    200 + 4 * letters.min(1 << 28) as u32
}

/// Smooths a route whose pins are *all* picks; those that `is_pinned` does not name are let go after they have shaped the
/// input. `is_pinned` has one flag a pin of the route.
///
/// # Errors
/// [`OptionError`] for a closed line that nothing holds, [`crate::Error::Collapsed`], [`crate::Error::Interrupted`].
pub fn smooth_fair(
    mesh: &SurfaceMesh,
    route: &mut Route,
    is_pinned: &[bool],
    options: &Options,
    report: &mut Report,
    observer: &mut dyn Observer,
) -> Result<()> {
    let input_options = Options { max_iterations: None, stages: false, ..options.clone() };
    smooth_geodesic(mesh, route, &input_options, report, observer)?;
    report.iterations = 0;
    let points = points_of(mesh, route).unwrap_or_default();
    let detail_size = choose_detail_size(is_pinned, &points, route, options)?;
    report.detail_size = Some(detail_size);
    let input = Input { points, closed: route.closed, detail_size };
    merge_unpinned(mesh, route, is_pinned)?;
    if input.points.len() < 2 {
        return Ok(());
    }
    relax_route(mesh, route, &input, options, report, observer)
}

fn choose_detail_size(is_pinned: &[bool], points: &[glam::DVec3], route: &Route, options: &Options) -> Result<f64> {
    let pin_count = is_pinned.iter().filter(|&&p| p).count();
    let inner =
        if route.closed { is_pinned } else { is_pinned.get(1..is_pinned.len().saturating_sub(1)).unwrap_or(&[]) };
    let size = match options.detail_size {
        Some(size) => size,
        None if inner.iter().all(|&p| p) => f64::INFINITY,
        None => DEFAULT_DETAIL_SHARE * length_of(points, route.closed) / route.legs.len().max(1) as f64,
    };
    if route.closed && size == f64::INFINITY && pin_count < 3 {
        return Err(OptionError::new(
            "detail_size",
            format!("an infinite detail size leaves a closed line to its pins, and it needs 3, found {pin_count}; pin more picks or give a finite detail size"),
        )
        .into());
    }
    Ok(size)
}

fn relax_route(
    mesh: &SurfaceMesh,
    route: &mut Route,
    input: &Input,
    options: &Options,
    report: &mut Report,
    observer: &mut dyn Observer,
) -> Result<()> {
    let letters: usize = route.legs.iter().map(|leg| leg.word.len()).sum();
    let limit = options.max_iterations.unwrap_or_else(|| round_bound(letters));
    let own_repeats = OwnRepeats::of_route(mesh, route);
    let mut passed: HashMap<VertexId, u32> = HashMap::new();
    loop {
        trim_legs(mesh, route);
        let gapped = |t: &mut f64| *t = t.clamp(END_GAP, 1.0 - END_GAP);
        route.legs.iter_mut().flat_map(|leg| &mut leg.parameters).for_each(gapped);
        go_on(observer, Step::Relax)?;
        let is_blocked =
            |v: VertexId| !mesh.is_passable(v) || passed.get(&v).is_some_and(|&times| times >= MAX_PASSES_AT_VERTEX);
        let Some(step) = step_fair(mesh, route, input, is_blocked) else { return Ok(()) };
        report.newton_steps += 1;
        report.iterations += 1;
        if options.stages {
            report.stages.extend(points_of(mesh, route));
        }
        if report.iterations >= limit {
            report.stop_reason = StopReason::MaxIterations;
            return Ok(());
        }
        go_on(observer, Step::VertexPass)?;
        let passes = pass_pressed(mesh, route, &step.pressing, END_GAP, MAX_PASSES_AT_VERTEX, &mut passed);
        report.vertex_passes += passes;
        if passes > 0 {
            report.loops_removed += own_repeats.cut_new_loops(mesh, route);
            refuse_collapsed(mesh, route, report.iterations)?;
        } else if step.largest_move <= SETTLED_MOVE {
            let at_end = |&t: &f64| t <= END_GAP || t >= 1.0 - END_GAP;
            let is_at_vertex = route.legs.iter().flat_map(|leg| &leg.parameters).any(at_end);
            report.stop_reason = if is_at_vertex { StopReason::ConvergedAtVertices } else { StopReason::Converged };
            return Ok(());
        }
    }
}
