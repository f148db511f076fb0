//! The `fair` filter on a whole line: its input, curves of ever more samples, and the stop reason.
//!
//! Holds the rules of `detail_size`, of the samples' spacing and of the length of steps; the energy and one step are in
//! `filter::fair`.

use crate::error::{Error, OptionError, Result};
use crate::filter::fair::FairCurve;
use crate::mesh::SurfaceMesh;
use crate::options::Options;
use crate::report::{Observer, Report, Step, StopReason};
use crate::route::Route;
use crate::samples::{Samples, mean_edge_length, route_length, with_seam};
use crate::self_crossings::count_self_crossings;
use crate::smooth::go_on;
use crate::smooth_geodesic::points_of;
use crate::span::SpanWork;

/// Without closeness to something else: this share of the mean distance between picks, along the input (the contract).
const DEFAULT_DETAIL_SHARE: f64 = 0.25;

/// The detail size along a stroke, as a share of its length: wiggles of a sixteenth of the stroke lose half their height.
/// It is one mean edge at least.
const STROKE_DETAIL_SHARE: f64 = 0.01;

/// Samples a mean edge: the curve then has a corner in every triangle that it crosses, as finely as a polyline can.
const SAMPLES_PER_EDGE: f64 = 2.0;

/// Samples a detail size at least, for the damping law to hold to two hundredths; and never more than
/// [`MOST_SAMPLES_PER_EDGE`], as a wiggle within one triangle has no place on the line.
const SAMPLES_PER_DETAIL: f64 = 2.0;
/// See [`SAMPLES_PER_DETAIL`].
const MOST_SAMPLES_PER_EDGE: f64 = 8.0;

/// The first curve has every so-manieth sample at most, and at least [`COARSE_PIECES`] pieces from pin to pin. A coarse
/// curve finds its place at large without being caught by the curvature of single mesh vertices, and costs less.
const COARSEST_STRIDE: usize = 16;
/// See [`COARSEST_STRIDE`].
const COARSE_PIECES: usize = 8;

/// The first step on a curve leaves alone what is longer than so many of its pieces.
const FIRST_REACH: f64 = 16.0;
/// A step whose energy falls by more than [`GOOD_SHARE`] of what its model says lets the next reach further by this, and
/// one that falls by less than [`POOR_SHARE`] halves its reach (as trust regions are steered).
const REACH_GROWTH: f64 = 2.0;
/// See [`REACH_GROWTH`].
const GOOD_SHARE: f64 = 0.5;
/// See [`REACH_GROWTH`].
const POOR_SHARE: f64 = 0.25;
/// A step that would have to be held back to less than this share of a piece has nowhere to go.
const LEAST_REACH: f64 = 0.125;

/// A curve is settled when a step moves nothing by more than this share of a piece,
const SETTLED_MOVE: f64 = 1e-7;
/// or when the energy can fall by no more than this share of it,
const SETTLED_FALL: f64 = 1e-10;
/// or when it fell by less than this share in each of [`SLOW_STEPS`] steps: the last curve, and the coarser ones.
const SLOW_FALL: f64 = 1e-5;
/// See [`SLOW_FALL`].
const SLOW_FALL_COARSE: f64 = 1e-2;
/// See [`SLOW_FALL`].
const SLOW_STEPS: u32 = 3;

/// Rounds without a limit of the caller's; measured lines take up to a hundred.
const ROUND_BOUND: u32 = 1000;

/// Smooths `input`, a route through *all* picks or along a stroke; pins that `is_pinned` does not name (one flag a pin of
/// the route) only shape it. `is_drawn`: it is a stroke.
///
/// # Errors
/// [`OptionError`] for a closed line that nothing holds, [`Error::Collapsed`], [`Error::Interrupted`].
pub fn smooth_fair(
    mesh: &SurfaceMesh,
    route: &mut Route,
    is_pinned: &[bool],
    is_drawn: bool,
    options: &Options,
    report: &mut Report,
    observer: &mut dyn Observer,
) -> Result<()> {
    let crossings_before = count_self_crossings(mesh, route);
    let input = with_seam(mesh, route.clone());
    let is_pinned = if route.pins.is_empty() { &[false] } else { is_pinned };
    let edge = mean_edge_length(mesh, &input);
    let length = route_length(mesh, &input);
    let own_size = is_drawn.then(|| (STROKE_DETAIL_SHARE * length).max(edge));
    let detail_size = choose_detail_size(&input, is_pinned, length, options.detail_size.or(own_size))?;
    report.detail_size = Some(detail_size);
    let spacing = (edge / SAMPLES_PER_EDGE).min((detail_size / SAMPLES_PER_DETAIL).max(edge / MOST_SAMPLES_PER_EDGE));
    // All in one place: any unit will do.
    let spacing = if spacing > 0.0 { spacing } else { 1.0 };
    let samples = Samples::of_route(mesh, &input, is_pinned, spacing);
    let mut stride = coarsest_stride(&samples, detail_size / spacing);
    let mut kept = samples.kept_at(stride);
    let mut lowering = Lowering {
        mesh,
        limit: options.max_iterations.unwrap_or(ROUND_BOUND),
        length: length / spacing,
        stages: options.stages,
        work: SpanWork::default(),
        report,
        observer,
    };
    let mut curve = lowering.open_curve(samples.thinned(mesh, &kept), detail_size);
    let stop_reason = loop {
        let slow_fall = if stride == 1 { SLOW_FALL } else { SLOW_FALL_COARSE };
        if !lowering.lower(&mut curve, slow_fall)? {
            break StopReason::MaxIterations;
        }
        if stride == 1 {
            break StopReason::Converged;
        }
        stride /= 2;
        let finer = samples.kept_at(stride);
        let places: Vec<usize> = kept.iter().filter_map(|i| finer.binary_search(i).ok()).collect();
        let legs: Vec<_> = curve.spans.iter().map(|span| span.leg.clone()).collect();
        let fine = samples.thinned(mesh, &finer).refined(mesh, &places, &curve.points, &legs);
        curve = lowering.open_curve(fine, detail_size);
        kept = finer;
    };
    *route = curve.to_route(mesh).ok_or(Error::Collapsed { iterations: report.iterations })?;
    report.new_self_crossings = count_self_crossings(mesh, route).saturating_sub(crossings_before);
    report.stop_reason = match stop_reason {
        StopReason::Converged if route.touches_vertex() => StopReason::ConvergedAtVertices,
        other => other,
    };
    Ok(())
}

/// How many samples of the finest curve the first one takes one of: a power of two.
fn coarsest_stride(samples: &Samples, samples_per_detail: f64) -> usize {
    let runs = samples.is_pinned.iter().filter(|&&p| p).count().max(1);
    let pieces = samples.points.len() / runs;
    let is_fit =
        |stride: usize| pieces / stride >= COARSE_PIECES && stride as f64 * SAMPLES_PER_DETAIL <= samples_per_detail;
    let mut stride = 1;
    while 2 * stride <= COARSEST_STRIDE && is_fit(2 * stride) {
        stride *= 2;
    }
    stride
}

/// The detail size, `given` or by the contract's rules; `length` is the input's.
fn choose_detail_size(input: &Route, is_pinned: &[bool], length: f64, given: Option<f64>) -> Result<f64> {
    let pin_count = is_pinned.iter().filter(|&&p| p).count();
    let inner =
        if input.closed { is_pinned } else { is_pinned.get(1..is_pinned.len().saturating_sub(1)).unwrap_or(&[]) };
    let size = match given {
        Some(size) => size,
        None if inner.iter().all(|&p| p) => f64::INFINITY,
        None => DEFAULT_DETAIL_SHARE * length / input.legs.len().max(1) as f64,
    };
    if input.closed && size == f64::INFINITY && pin_count < 3 {
        return Err(OptionError::new(
            "detail_size",
            format!(
                "an infinite detail size leaves a closed line to its pins alone, and it needs 3, found {pin_count}; \
                 pin more picks or give a finite detail size"
            ),
        )
        .into());
    }
    Ok(size)
}

/// What stays the same while curves are lowered.
struct Lowering<'a> {
    mesh: &'a SurfaceMesh,
    limit: u32,
    /// Of the input, in the samples' unit.
    length: f64,
    stages: bool,
    work: SpanWork,
    report: &'a mut Report,
    observer: &'a mut dyn Observer,
}

impl Lowering<'_> {
    fn open_curve(&mut self, samples: Samples, detail_size: f64) -> FairCurve {
        let curve = FairCurve::new(self.mesh, samples, detail_size, &mut self.work, self.report);
        self.report.energies = vec![curve.energy / curve.unit()];
        curve
    }

    /// Lowers the energy of a curve as far as it goes; false at the limit of rounds.
    fn lower(&mut self, curve: &mut FairCurve, slow_fall: f64) -> Result<bool> {
        let piece = self.length / curve.spans.len() as f64;
        let mut reach = FIRST_REACH * piece;
        let mut slow_steps = 0;
        loop {
            go_on(self.observer, Step::Relax)?;
            let Some(step) = curve.step(self.mesh, reach, &mut self.work.cones) else { return Ok(true) };
            self.report.newton_steps += 1;
            let next = curve.moved(self.mesh, &step, &mut self.work, self.report);
            let fall = curve.energy - next.energy;
            let is_settled = curve.relative_size(&step) <= SETTLED_MOVE || step.fall <= SETTLED_FALL * curve.energy;
            if fall > 0.0 {
                slow_steps = if fall < slow_fall * curve.energy { slow_steps + 1 } else { 0 };
                *curve = next;
                self.report.iterations += 1;
                self.report.energies.push(curve.energy / curve.unit());
                if self.stages {
                    self.report.stages.extend(curve.to_route(self.mesh).and_then(|route| points_of(self.mesh, &route)));
                }
            }
            let share = fall / step.fall;
            if share > GOOD_SHARE {
                reach = if reach < self.length { reach * REACH_GROWTH } else { f64::INFINITY };
            } else if share.is_nan() || share < POOR_SHARE {
                reach = reach.min(self.length) / 2.0;
            }
            if is_settled || slow_steps == SLOW_STEPS || reach < LEAST_REACH * piece {
                return Ok(true);
            }
            if self.report.iterations >= self.limit {
                return Ok(false);
            }
        }
    }
}
