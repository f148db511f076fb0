//! Step C of a line by the paper's filters, in stages: what each kind of stage does with the crossings, and which comes next.
//!
//! Holds the state that a line's stages share, and their limits of moves and steps. Which stages there are is in
//! `sliding_stages`, the rounds of steps C and D are in `smooth_sliding`.

use std::collections::VecDeque;
use std::ops::{ControlFlow, Range};

use glam::DVec3;

use crate::error::{Error, Result};
use crate::filter::{Edge, Side, SlidingFilter, Target};
use crate::pauses::Pauses;
use crate::relax::beads::Beads;
use crate::relax::heap::relax_by_heap;
use crate::relax::implicit::{ImplicitOutcome, relax_implicitly, relax_ranges_implicitly};
use crate::relax::newton::{NEWTON_TOLERANCE, relax_by_newton};
use crate::relax::sweeps::relax_by_sweeps;
use crate::relax::swing::{SlideEnd, SlideOutcome};
use crate::report::{Observer, Report, Step};
use crate::sliding_stages::{MOVES_BEFORE_STEPS, Order, STEPS_A_ROUND, Stage, moves_a_spell};
use crate::smooth::go_on;

/// The first implicit step, in the motion's own time: about as far as each crossing is from its target.
const FIRST_TIME_STEP: f64 = 1.0;

/// Time steps of a line that is not brought to rest by its first ones: no longer than this at first, so that the steps after a
/// spell begin gently.
const LONGEST_FIRST_STEP: f64 = 64.0;

/// Steps of all crossings at once do good as long as they are not shorter than this.
const GOOD_TIME_STEP: f64 = 1.0;

/// Spells of moves one by one within one step C.
const MOST_SPELLS: u32 = 30;

/// Moves of the heap where Newton has failed for good, for each crossing; the line is then as near its limit as it gets.
const MOVES_AFTER_NEWTON: u64 = 500;

/// Times that Newton is tried within one step C.
const NEWTON_STARTS: u32 = 8;

/// Moves of the heap between two tries, for each vertex.
const MOVES_BETWEEN_STARTS: u64 = 20;

/// A filter whose vertices stay where they are as near to its curve as at their targets, to rounding. Where the curve runs along
/// an edge the nearest point is any of a stretch, and which one is found jumps with the last bit of the neighbours.
struct Content<'a, F>(&'a F);

impl<F: SlidingFilter> Content<'_, F> {
    /// What was found, or `t` where that is as near.
    fn or_stay(&self, edge: &Edge, before: &[DVec3], after: &[DVec3], t: f64, found: Target) -> Target {
        let stays = found.t != t && self.0.is_as_near(edge, before, after, t, found);
        if stays { Target { t, ..found } } else { found }
    }
}

impl<F: SlidingFilter> SlidingFilter for Content<'_, F> {
    fn reach(&self) -> usize {
        self.0.reach()
    }

    fn target(&self, edge: &Edge, before: &[DVec3], after: &[DVec3], t: f64, near: Option<f64>) -> Target {
        self.or_stay(edge, before, after, t, self.0.target(edge, before, after, t, near))
    }

    #[inline(always)]
    fn target_of_four(
        &self,
        edge: &Edge,
        points: &[DVec3; 4],
        inner: usize,
        t: f64,
        near: Option<f64>,
    ) -> Option<Target> {
        let found = self.0.target_of_four(edge, points, inner, t, near)?;
        let before: Side = points[..=inner].iter().rev().copied().collect();
        Some(self.or_stay(edge, &before, &points[inner + 1..], t, found))
    }

    fn measure(&self, points: &[DVec3]) -> f64 {
        self.0.measure(points)
    }
}

/// What step C slides: the beads of a line, and those of them that may be off their targets (`None`: all).
pub struct Sliders<'a> {
    /// All crossings and pins.
    pub beads: &'a mut Beads,
    /// Ranges of beads.
    pub may_be_off: Option<&'a [Range<usize>]>,
    /// In which they move where they do not move at once.
    pub order: Order,
}

/// How step C ended.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct StepEnd {
    /// As of moves one by one; steps of all crossings at once count as settled.
    pub end: SlideEnd,
    /// Whether Newton has brought the line to its fixed point.
    pub by_newton: bool,
}

/// The stages of one line, and how far they have come.
pub struct Stages {
    /// Those to come.
    left: VecDeque<Stage>,
    stage: Stage,
    /// Moves of the line by the end of this stage.
    most_moves: u64,
    crossings: usize,
    time_step: f64,
    /// Whether steps of all crossings at once come before the next spell of moves one by one.
    needs_steps: bool,
}

impl Stages {
    /// Begins the first of `stages`; `threshold`: of a line without any.
    pub fn new(stages: VecDeque<Stage>, threshold: f64, crossings: usize) -> Self {
        let mut stages = Self {
            left: stages,
            stage: Stage::OneByOne { threshold, moves: None },
            most_moves: 0,
            crossings,
            time_step: FIRST_TIME_STEP,
            needs_steps: false,
        };
        stages.go_to_next(0);
        stages
    }

    /// How near to rest this stage brings the line, in barycentric units.
    pub fn threshold(&self) -> f64 {
        self.stage.threshold()
    }

    /// Whether this stage moves all crossings at once, as a start.
    pub fn is_start(&self) -> bool {
        matches!(self.stage, Stage::Implicit { .. })
    }

    /// Whether this stage has steps of all crossings at once to make.
    pub fn has_steps(&self) -> bool {
        matches!(self.stage, Stage::Implicit { steps: 1.., .. })
    }

    /// Begins the next stage after so many moves; false if there is none.
    pub fn go_to_next(&mut self, moves: u64) -> bool {
        let Some(next) = self.left.pop_front() else { return false };
        match next {
            Stage::OneByOne { moves: Some(more), .. } | Stage::Newton { moves: more, .. } => {
                self.most_moves = moves + more
            }
            _ => {}
        }
        (self.stage, self.needs_steps) = (next, true);
        true
    }

    /// Begins the next stage where moves one by one have run out or left vertices in the middle of a swing; false if there is
    /// none for that.
    pub fn go_on_from(&mut self, end: SlideEnd, moves: u64) -> bool {
        let is_over = match end {
            SlideEnd::Settled => false,
            SlideEnd::Swinging => self.left.len() == 1,
            SlideEnd::Stopped => true,
        };
        is_over && matches!(self.left.back(), Some(Stage::Rest { .. })) && self.go_to_next(moves)
    }

    /// Whether a line that moves one by one have brought to rest has no stages to come but such as it passes over.
    pub fn is_last_at_rest(&self) -> bool {
        self.left.iter().all(|stage| matches!(stage, Stage::Rest { .. }))
    }

    /// One step C.
    ///
    /// # Errors
    /// [`Error::Interrupted`].
    pub fn relax(
        &mut self,
        sliders: &mut Sliders,
        filter: &impl SlidingFilter,
        report: &mut Report,
        observer: &mut dyn Observer,
    ) -> Result<StepEnd> {
        let slid = |end| Ok(StepEnd { end, by_newton: false });
        match self.stage {
            Stage::Newton { threshold, .. } => {
                if settle_by_newton(sliders.beads, filter, report, observer)? {
                    return Ok(StepEnd { end: SlideEnd::Settled, by_newton: true });
                }
                // The heap goes on from the best place that Newton found.
                let share = MOVES_AFTER_NEWTON * self.crossings as u64;
                let moves = self.most_moves.saturating_sub(report.moves).min(share);
                slid(sliders.slide_one_by_one(filter, threshold, moves, report, observer)?.end)
            }
            Stage::OneByOne { threshold, .. } => {
                let moves = self.most_moves.saturating_sub(report.moves);
                slid(sliders.slide_one_by_one(filter, threshold, moves, report, observer)?.end)
            }
            Stage::Implicit { threshold, steps } => {
                let moves = MOVES_BEFORE_STEPS * self.crossings as u64;
                sliders.slide_one_by_one(filter, threshold, moves, report, observer)?;
                let most = STEPS_A_ROUND.min(steps);
                let outcome = sliders.step(filter, threshold, most, &mut self.time_step, report, observer)?;
                let left = if outcome.is_settled { 0 } else { steps - most };
                self.stage = Stage::Implicit { threshold, steps: left };
                slid(SlideEnd::Settled)
            }
            Stage::Rest { .. } => slid(self.bring_to_rest(sliders, filter, report, observer)?),
        }
    }

    /// Spells of moves one by one, and steps of all crossings at once after each that has not brought the line to rest.
    fn bring_to_rest(
        &mut self,
        sliders: &mut Sliders,
        filter: &impl SlidingFilter,
        report: &mut Report,
        observer: &mut dyn Observer,
    ) -> Result<SlideEnd> {
        let Stage::Rest { threshold, steps, mut moves } = self.stage else { return Ok(SlideEnd::Stopped) };
        let mut time_step = FIRST_TIME_STEP;
        let mut end = SlideEnd::Stopped;
        for _ in 0..MOST_SPELLS {
            if self.needs_steps {
                let mut left = steps;
                while left > 0 {
                    let most = STEPS_A_ROUND.min(left);
                    let outcome = sliders.step(filter, GOAL * threshold, most, &mut time_step, report, observer)?;
                    let does_good = !outcome.is_settled && time_step >= GOOD_TIME_STEP;
                    left = if does_good { left - most } else { 0 };
                }
                time_step = time_step.clamp(FIRST_TIME_STEP, LONGEST_FIRST_STEP);
            }
            let most = moves.min(moves_a_spell(sliders.beads.len()));
            let outcome = sliders.slide_one_by_one(&Content(filter), threshold, most, report, observer)?;
            moves -= outcome.moves;
            self.stage = Stage::Rest { threshold, steps, moves };
            end = outcome.end;
            self.needs_steps = end != SlideEnd::Settled;
            if self.needs_steps {
                // The steps move what they will, and more than was off at first may be then.
                sliders.may_be_off = None;
            }
            if !self.needs_steps || moves == 0 {
                break;
            }
        }
        Ok(end)
    }
}

/// Steps of all crossings at once end at this share of the threshold, so that nothing is left to move one by one.
const GOAL: f64 = 0.5;

impl Sliders<'_> {
    /// At most so many steps of all crossings at once, the first of which is `time_step` long.
    fn step(
        &mut self,
        filter: &impl SlidingFilter,
        threshold: f64,
        most: u64,
        time_step: &mut f64,
        report: &mut Report,
        observer: &mut dyn Observer,
    ) -> Result<ImplicitOutcome> {
        let ask = || go_on(observer, Step::Relax);
        let outcome = match self.may_be_off {
            None => relax_implicitly(self.beads, filter, threshold, most, time_step, ask)?,
            Some(near) => relax_ranges_implicitly(self.beads, near, filter, threshold, most, time_step, ask)?,
        };
        report.newton_steps += outcome.steps;
        Ok(outcome)
    }

    /// One crossing after the other, which the observer may end.
    fn slide_one_by_one(
        &mut self,
        filter: &impl SlidingFilter,
        threshold: f64,
        move_limit: u64,
        report: &mut Report,
        observer: &mut dyn Observer,
    ) -> Result<SlideOutcome> {
        let mut is_stopped = false;
        let on_pause = || {
            let flow = observer.step(Step::Relax);
            is_stopped = flow == ControlFlow::Break(());
            flow
        };
        let outcome = match self.order {
            Order::Heap => relax_by_heap(self.beads, filter, threshold, move_limit, self.may_be_off, on_pause),
            Order::Sweeps => relax_by_sweeps(self.beads, filter, threshold, move_limit, self.may_be_off, on_pause),
        };
        report.moves += outcome.moves;
        if is_stopped { Err(Error::Interrupted) } else { Ok(outcome) }
    }
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
        let mut all = Sliders { beads: &mut *beads, may_be_off: None, order: Order::Heap };
        all.slide_one_by_one(filter, NEWTON_TOLERANCE, moves, report, observer)?;
    }
    Ok(false)
}
