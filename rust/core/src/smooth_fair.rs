//! The `fair` filter on a whole line: its input, curves of ever more samples, and the stop reason.
//!
//! Holds the rules of `detail_size`, of the samples' spacing and of the length of steps; the energy and one step are in
//! `filter::fair`.

use crate::error::{Error, OptionError, Result};
use crate::filter::fair::FairCurve;
use crate::large::LargeVec;
use crate::mesh::SurfaceMesh;
use crate::options::Options;
use crate::pauses::Pauses;
use crate::report::{Observer, Report, Step, StopReason};
use crate::route::Route;
use crate::samples::{InputSize, Samples, with_seam};
use crate::self_crossings::count_self_crossings;
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

/// Samples for each crossing of the input, and for each of its legs, at most: on sound triangles there are one to five a
/// crossing. Where a line crosses short edges of long needles, edges say nothing of what lies between.
const MOST_SAMPLES_PER_CROSSING: f64 = 16.0;
/// See [`MOST_SAMPLES_PER_CROSSING`].
const MOST_SAMPLES_PER_LEG: f64 = 64.0;

/// The first curve has every so-manieth sample at most, and at least [`COARSE_PIECES`] pieces from pin to pin. A coarse
/// curve finds its place at large without being caught by the curvature of single mesh vertices, and costs less.
const COARSEST_STRIDE: usize = 16;
/// See [`COARSEST_STRIDE`].
const COARSE_PIECES: usize = 8;

/// A step whose energy falls by more than [`GOOD_SHARE`] of what its model says lets the next reach further by this, and
/// one that falls by less than [`POOR_SHARE`] halves its reach (as trust regions are steered).
const REACH_GROWTH: f64 = 2.0;
/// See [`REACH_GROWTH`].
const GOOD_SHARE: f64 = 0.5;
/// See [`REACH_GROWTH`].
const POOR_SHARE: f64 = 0.25;
/// After a step that did not lower the energy the next one that is tried is shorter than this share of it: a shorter reach
/// need not make a shorter step.
const SHORTER: f64 = 0.75;
/// A step that would have to be held back to less than this share of a piece has nowhere to go.
const LEAST_REACH: f64 = 0.125;

/// The first step on a curve leaves alone what is longer than so many of its pieces.
const FIRST_REACH: f64 = 16.0;
/// A curve is settled when a step moves nothing by more than this share of a piece,
const SETTLED_MOVE: f64 = 1e-7;
/// or when the energy can fall by no more than this share of it; for other reasons see [`Pace`].
const SETTLED_FALL: f64 = 1e-10;
/// On needles the model can be so wrong that a curve creeps for thousands of steps. A curve is settled, too, when so many steps
/// in a row
const CREEPING_STEPS: u32 = 32;
/// have each moved nothing by more than this share of a piece,
const CREEPING_MOVE: f64 = 1e-3;
/// and lowered the energy by no more than this share of it.
const CREEPING_FALL: f64 = 1e-3;

/// How long a curve is lowered. A step is slow when it promises, and lets the energy fall by, less than a share of it.
pub struct Pace {
    slow_fall: f64,
    /// Until so many slow steps were made in a row; with 0, as soon as a step promises no more.
    slow_steps: u32,
    /// Or until so many steps in a row did not lower it.
    refused_steps: u32,
    /// Or, where the model is trusted, until the energy fell by what was promised, to that share of what is left of it: what
    /// the step has left undone is as little.
    trusts_model: bool,
}

/// How curves of ever more samples are lowered.
pub struct Paces {
    coarse: Pace,
    last: Pace,
    /// The last curve has every so-manieth sample.
    finest_stride: usize,
}

/// A coarse curve that went on to its own place of rest would find one that is due to where its few samples lie on the
/// mesh; one that is left too early leads the finer ones to another valley. The last curve is then within a tenth of an edge of
/// where ever smaller steps would take it.
const FINAL: Paces = Paces {
    coarse: Pace { slow_fall: 1e-2, slow_steps: 2, refused_steps: u32::MAX, trusts_model: false },
    last: Pace { slow_fall: 1e-5, slow_steps: 0, refused_steps: u32::MAX, trusts_model: false },
    finest_stride: 1,
};

/// A draft goes the same way, so it ends near the final curve: at an edge between samples instead of half an edge.
pub const DRAFT: Paces = Paces {
    coarse: Pace { slow_fall: 2e-2, slow_steps: 0, refused_steps: 2, trusts_model: true },
    last: Pace { slow_fall: 2e-3, slow_steps: 0, refused_steps: 2, trusts_model: true },
    finest_stride: 2,
};

/// Rounds without a limit of the caller's; measured lines take up to a hundred, on needles of 1e-13 up to four thousand.
const ROUND_BOUND: u32 = 20_000;

/// What is asked of a fair line.
#[derive(Clone, Copy, Debug)]
pub struct FairTask<'a> {
    /// What it lies on.
    pub mesh: &'a SurfaceMesh,
    /// One flag a pin of the route: the others only shape the line.
    pub is_pinned: &'a [bool],
    /// Whether the route is a stroke.
    pub is_drawn: bool,
    /// Whether a line is wanted at once, while picks are moved: with half of the samples, and less settled.
    pub is_draft: bool,
    /// The caller's.
    pub options: &'a Options,
}

/// Smooths `route`, which goes through *all* picks or along a stroke.
///
/// # Errors
/// [`OptionError`] for a closed line that nothing holds, [`Error::Collapsed`], [`Error::Interrupted`].
pub fn smooth_fair(task: &FairTask, route: &mut Route, report: &mut Report, observer: &mut dyn Observer) -> Result<()> {
    let &FairTask { mesh, is_pinned, is_drawn, is_draft, options } = task;
    let mut pauses = Pauses::new(observer, Step::Relax);
    let crossings_before = count_self_crossings(mesh, route, &mut pauses)?;
    pauses.pause()?;
    let input = with_seam(mesh, route.clone());
    let is_pinned = if route.pins.is_empty() { &[false] } else { is_pinned };
    let size = InputSize::of(mesh, &input, &mut pauses)?;
    let own_size = is_drawn.then(|| (STROKE_DETAIL_SHARE * size.length).max(size.edge));
    let detail_size = choose_detail_size(&size, &input, is_pinned, options.detail_size.or(own_size))?;
    report.detail_size = Some(detail_size);
    let samples = Samples::of_route(mesh, &input, is_pinned, spacing_on(&size, detail_size), &mut pauses)?;
    pauses.pause()?;
    let mut lowering = Lowering::new(task, report, observer);
    let (curve, is_settled) = lowering.refine(&samples, detail_size, if is_draft { &DRAFT } else { &FINAL })?;
    let made = curve.to_route(mesh, &mut lowering.pauses)?;
    lowering.finish();
    *route = made.ok_or(Error::Collapsed { iterations: report.iterations })?;
    let crossings = count_self_crossings(mesh, route, &mut Pauses::new(observer, Step::Relax))?;
    report.new_self_crossings = crossings.saturating_sub(crossings_before);
    report.stop_reason = match is_settled {
        false => StopReason::MaxIterations,
        true if route.touches_vertex() => StopReason::ConvergedAtVertices,
        true => StopReason::Converged,
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

/// How far apart samples of an input are.
pub fn spacing_on(size: &InputSize, detail_size: f64) -> f64 {
    let &InputSize { length, edge, crossings, legs } = size;
    let spacing = (edge / SAMPLES_PER_EDGE).min((detail_size / SAMPLES_PER_DETAIL).max(edge / MOST_SAMPLES_PER_EDGE));
    let most = MOST_SAMPLES_PER_CROSSING * crossings as f64 + MOST_SAMPLES_PER_LEG * legs as f64;
    let spacing = spacing.max(length / most);
    // All in one place: any unit will do.
    if spacing > 0.0 { spacing } else { 1.0 }
}

/// The detail size, `given` or by the contract's rules.
pub fn choose_detail_size(size: &InputSize, input: &Route, is_pinned: &[bool], given: Option<f64>) -> Result<f64> {
    let pin_count = is_pinned.iter().filter(|&&p| p).count();
    let inner =
        if input.closed { is_pinned } else { is_pinned.get(1..is_pinned.len().saturating_sub(1)).unwrap_or(&[]) };
    let chosen = match given {
        Some(given) => given,
        None if inner.iter().all(|&p| p) => f64::INFINITY,
        None => DEFAULT_DETAIL_SHARE * size.length / size.legs.max(1) as f64,
    };
    if input.closed && chosen == f64::INFINITY && pin_count < 3 {
        return Err(OptionError::new(
            "detail_size",
            format!(
                "an infinite detail size leaves a closed line to its pins alone, and it needs 3, found {pin_count}; \
                 pin more picks or give a finite detail size"
            ),
        )
        .into());
    }
    Ok(chosen)
}

/// Where the numbers of `some` are in `all`, which holds them; both rise.
fn places_in(all: &[usize], some: &[usize], pauses: &mut Pauses) -> Result<LargeVec<usize>> {
    let mut places = LargeVec::with_capacity(some.len());
    for (place, number) in all.iter().enumerate() {
        pauses.tick()?;
        if some.get(places.len()) == Some(number) {
            places.push(place);
        }
    }
    Ok(places)
}

/// What stays the same while curves are lowered.
pub struct Lowering<'a> {
    mesh: &'a SurfaceMesh,
    limit: u32,
    stages: bool,
    work: SpanWork,
    report: &'a mut Report,
    /// Of the lowering.
    pub pauses: Pauses<'a>,
}

impl<'a> Lowering<'a> {
    /// For a task; the report is told of every curve.
    pub fn new(task: &FairTask<'a>, report: &'a mut Report, observer: &'a mut dyn Observer) -> Self {
        Self {
            mesh: task.mesh,
            limit: task.options.max_iterations.unwrap_or(ROUND_BOUND),
            stages: task.options.stages,
            work: SpanWork::with_cones(task.mesh.take_cones()),
            report,
            pauses: Pauses::new(observer, Step::Relax),
        }
    }

    fn open_curve(&mut self, samples: Samples, detail_size: f64) -> Result<FairCurve> {
        let curve = FairCurve::new(self.mesh, samples, detail_size, &mut self.work, self.report, &mut self.pauses)?;
        self.report.energies = vec![curve.energy / curve.unit()];
        Ok(curve)
    }

    /// Ends the work.
    pub fn finish(self) {
        self.mesh.put_back_cones(self.work.cones);
    }

    /// Curves of ever more of the samples, each lowered; the last one, and whether it came to rest.
    ///
    /// # Errors
    /// [`Error::Interrupted`].
    pub fn refine(&mut self, samples: &Samples, detail_size: f64, paces: &Paces) -> Result<(FairCurve, bool)> {
        let mut stride = coarsest_stride(samples, detail_size / samples.unit);
        let finest = paces.finest_stride.min(stride);
        let mut kept = samples.kept_at(stride, &mut self.pauses)?;
        self.pauses.pause()?;
        let coarse = samples.thinned(self.mesh, &kept, &mut self.pauses)?;
        let mut curve = self.open_curve(coarse, detail_size)?;
        loop {
            let is_settled = self.lower(&mut curve, if stride == finest { &paces.last } else { &paces.coarse })?;
            if stride == finest || !is_settled {
                return Ok((curve, is_settled));
            }
            stride /= 2;
            let finer = samples.kept_at(stride, &mut self.pauses)?;
            let places = places_in(&finer, &kept, &mut self.pauses)?;
            let legs: Vec<_> = curve.spans.iter().map(|span| &span.leg).collect();
            let fine = samples.spaced(&finer, &mut self.pauses)?;
            let fine = fine.refined(self.mesh, &places, &curve.points, &legs, &mut self.pauses)?;
            curve = self.open_curve(fine, detail_size)?;
            kept = finer;
        }
    }

    /// Lowers the energy of a curve as far as it goes; false at the limit of rounds.
    fn lower(&mut self, curve: &mut FairCurve, pace: &Pace) -> Result<bool> {
        let length = curve.input_length();
        let piece = length / curve.spans.len() as f64;
        let mut reach = FIRST_REACH * piece;
        let mut slow_steps = 0;
        let mut refused_size = f64::INFINITY;
        let mut refused_steps = 0;
        let mut creeping_steps = 0;
        // As long as the curve stays where it is.
        let mut system = None;
        loop {
            self.pauses.pause()?;
            let known = match system.take() {
                Some(known) => known,
                None => curve.system(self.mesh, &mut self.work.cones, &mut self.pauses)?,
            };
            let Some(step) = curve.step(&known, reach, &mut self.pauses)? else { return Ok(true) };
            self.report.newton_steps += 1;
            let size = step.size;
            if size > SHORTER * refused_size && reach >= LEAST_REACH * piece {
                reach = reach.min(length) / 2.0;
                system = Some(known);
                continue;
            }
            let little = pace.slow_fall * curve.energy;
            if pace.slow_steps == 0 && step.fall < little {
                return Ok(true);
            }
            let next = curve.moved(self.mesh, &step, &mut self.work, self.report, &mut self.pauses)?;
            let fall = next.as_ref().map_or(f64::NEG_INFINITY, |next| curve.energy - next.energy);
            let is_settled = size <= SETTLED_MOVE || step.fall <= SETTLED_FALL * curve.energy;
            // A step that was taken back counts as well, where it promised no more.
            match fall.max(step.fall) < little {
                true => slow_steps += 1,
                false if fall > 0.0 => slow_steps = 0,
                false => {}
            }
            let is_creeping = size <= CREEPING_MOVE && fall <= CREEPING_FALL * curve.energy;
            creeping_steps = if is_creeping { creeping_steps + 1 } else { 0 };
            refused_size = if fall > 0.0 { f64::INFINITY } else { size };
            refused_steps = if fall > 0.0 { 0 } else { refused_steps + 1 };
            match next {
                Some(next) if fall > 0.0 => {
                    *curve = next;
                    self.report.iterations += 1;
                    self.report.energies.push(curve.energy / curve.unit());
                    if self.stages {
                        let route = curve.to_route(self.mesh, &mut self.pauses)?;
                        self.report.stages.extend(route.and_then(|route| points_of(self.mesh, &route)));
                    }
                }
                _ => system = Some(known),
            }
            let share = fall / step.fall;
            if share > GOOD_SHARE {
                reach = if reach < length { reach * REACH_GROWTH } else { f64::INFINITY };
            } else if share.is_nan() || share < POOR_SHARE {
                reach = reach.min(length) / 2.0;
            }
            let is_slow = slow_steps > 0 && slow_steps >= pace.slow_steps;
            let is_as_promised = pace.trusts_model && (fall - step.fall).abs() < pace.slow_fall * curve.energy;
            let is_stuck = refused_steps == pace.refused_steps || creeping_steps == CREEPING_STEPS;
            if is_settled || is_slow || is_as_promised || is_stuck || reach < LEAST_REACH * piece {
                return Ok(true);
            }
            if self.report.iterations >= self.limit {
                return Ok(false);
            }
        }
    }
}
