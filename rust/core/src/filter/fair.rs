//! The `fair` filter: the smoothest curve near the input, as an energy of samples.
//!
//! ```text
//!   energy = sum |a_i|^2 / h_i  +  sum h_i |x_i - q_i|^2 / detail_size^4
//!
//!   a_i = (way to x_i+1) / step_i  -  (way from x_i-1) / step_i-1      x_i   samples on the surface
//!   h_i = (step_i-1 + step_i) / 2                                       q_i   where they were on the input
//! ```
//!
//! The way to a neighbour is the span's first direction times its length; all is measured in the surface, so the energy
//! is that of a spline with the input's arc length for its parameter: integral of the squared second derivative along
//! the surface, plus closeness. In the plane it is quadratic and its least the natural cubic spline (for samples ever
//! closer); on a surface it is lowered by Gauss-Newton steps (`fair_step`), in each of which a sample moves straight ahead on the
//! surface (`trace`), over as many triangles and vertices as it takes.
//!
//! Lengths are in the samples' own unit, so that no power of them is too large or too small.
//!
//! Source: L. Noakes, G. Heinzinger, B. Paden 1989, *Cubic Splines on Curved Spaces*; discretised here.

use std::sync::Arc;

use glam::{DVec2, DVec3};

use crate::error::Result;
use crate::filter::fair_step::FairStep;
use crate::large::LargeVec;
use crate::leg::Leg;
use crate::mesh::SurfaceMesh;
use crate::pauses::Pauses;
use crate::report::Report;
use crate::route::Route;
use crate::samples::Samples;
use crate::span::{Span, SpanWork};
use crate::spot::spot_of;
use crate::surface_point::SurfacePoint;
use crate::trace::trace;
use crate::turn::{Heading, Turn, turn_at};

/// A detail size below this, in the samples' unit, is taken for it: the curve is its input either way.
const LEAST_DETAIL: f64 = 1e-3;

/// A curve crosses at most so many times as many edges as its input, and where that is less [`MOST_CROSSINGS`], or on small
/// meshes [`MOST_CROSSINGS_PER_TRIANGLE`]. Round a tube of needles a smooth curve would wind millions of times.
const MOST_CROSSINGS_PER_INPUT: usize = 64;
const MOST_CROSSINGS: usize = 20_000;
const MOST_CROSSINGS_PER_TRIANGLE: usize = 8;

/// A curve in the making.
#[derive(Clone, Debug)]
pub struct FairCurve {
    /// What does not change: pins, anchors and steps; without points and legs.
    pub(super) input: Arc<Samples>,
    /// Edges that the input crosses.
    crossings: usize,
    /// 1 / detail size to the fourth; 0 for no closeness.
    pub(super) closeness: f64,
    /// Where the samples are now.
    pub points: LargeVec<SurfacePoint>,
    /// Spans between neighbouring samples.
    pub spans: LargeVec<Span>,
    pub(super) frames: LargeVec<Frame>,
    /// See the module.
    pub energy: f64,
}

/// Directions at a sample, in a plane whose x axis is the way in (at the start of an open curve the way out) and whose y
/// axis is to the left of it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    /// The axes in space; at pins they play no part.
    pub axes: [DVec3; 2],
    /// Directions of the chords of the spans before and after.
    pub chord_in: DVec2,
    pub chord_out: DVec2,
    /// Whether left is right at the next sample.
    pub flips: bool,
}

impl FairCurve {
    /// The curve where the samples are now, `detail_size` in the units of the positions.
    ///
    /// # Errors
    /// [`crate::Error::Interrupted`] at one of the `pauses`.
    pub fn new(
        mesh: &SurfaceMesh,
        samples: Samples,
        detail_size: f64,
        work: &mut SpanWork,
        report: &mut Report,
        pauses: &mut Pauses,
    ) -> Result<Self> {
        let mut samples = samples;
        let (points, legs) = (std::mem::take(&mut samples.points), samples.legs.take());
        let crossings = legs.iter().map(|leg| leg.word.len()).sum();
        pauses.pause()?;
        let spans = relax_all(mesh, &points, legs, work, report, pauses)?;
        let closeness = (detail_size / samples.unit).max(LEAST_DETAIL).powi(-4);
        let input = Arc::new(samples);
        Self { input, crossings, closeness, points, spans, frames: LargeVec::default(), energy: 0.0 }
            .measured(mesh, pauses)
    }

    /// The unit of length, in the units of the positions.
    pub fn unit(&self) -> f64 {
        self.input.unit
    }

    /// Length of the input, in the samples' unit.
    pub fn input_length(&self) -> f64 {
        self.input.steps.iter().sum()
    }

    pub(super) fn count(&self) -> usize {
        self.points.len()
    }

    /// The span before a sample and the one after it.
    pub(super) fn neighbours(&self, i: usize) -> (Option<usize>, Option<usize>) {
        let before = if i > 0 { Some(i - 1) } else { self.input.closed.then(|| self.count() - 1) };
        (before, (i < self.spans.len()).then_some(i))
    }

    /// Length of the input that a sample stands for.
    pub(super) fn weight(&self, i: usize) -> f64 {
        let (before, after) = self.neighbours(i);
        0.5 * [before, after].into_iter().flatten().map(|span| self.input.steps[span]).sum::<f64>()
    }

    /// How far a sample is from where it was on the input.
    pub(super) fn offset(&self, mesh: &SurfaceMesh, i: usize) -> DVec3 {
        (mesh.position_of(&self.points[i]) - self.input.anchors[i]) / self.input.unit
    }

    /// How fast the curve runs along a span: its length over that of the input.
    pub(super) fn speed(&self, span: usize) -> f64 {
        self.spans[span].length / self.input.unit / self.input.steps[span]
    }

    fn measured(mut self, mesh: &SurfaceMesh, pauses: &mut Pauses) -> Result<Self> {
        self.frames = LargeVec::with_capacity(self.count());
        for i in 0..self.count() {
            pauses.tick()?;
            let frame = self.frame(mesh, i);
            self.frames.push(frame);
        }
        self.energy = 0.0;
        for i in 0..self.count() {
            pauses.tick()?;
            let bending = self.acceleration(i).map_or(0.0, |a| a.length_squared() / self.weight(i));
            let off = self.offset(mesh, i);
            self.energy += bending + self.closeness * self.weight(i) * off.length_squared();
        }
        Ok(self)
    }

    fn frame(&self, mesh: &SurfaceMesh, i: usize) -> Frame {
        let (before, after) = self.neighbours(i);
        let (before, after) = (before.map(|k| &self.spans[k]), after.map(|k| &self.spans[k]));
        let sign = |flips: bool| if flips { -1.0 } else { 1.0 };
        let (heading, turn) = match (before.map(|s| s.end), after.map(|s| s.start)) {
            (Some(into), Some(out)) if into.direction != DVec3::ZERO && out.direction != DVec3::ZERO => {
                (into, turn_at(mesh, spot_of(mesh, &self.points[i]), into, out))
            }
            (Some(into), _) if into.direction != DVec3::ZERO => (into, Turn::default()),
            (into, out) => (
                out.or(into).unwrap_or(Heading { triangle: self.points[i].triangle, direction: DVec3::X }),
                Turn::default(),
            ),
        };
        let left = mesh.normal(heading.triangle).cross(heading.direction);
        let bend_in = before.map_or(0.0, |s| s.bend_in);
        let bend_out = after.map_or(0.0, |s| s.bend_out);
        Frame {
            axes: [heading.direction, left],
            chord_in: DVec2::from_angle(-bend_in),
            chord_out: DVec2::from_angle(turn.angle + sign(turn.flips) * bend_out),
            flips: turn.flips ^ after.is_some_and(|s| s.flips),
        }
    }

    /// The second difference at a sample; none at the ends of an open curve.
    pub(super) fn acceleration(&self, i: usize) -> Option<DVec2> {
        let (before, after) = self.neighbours(i);
        let (before, after) = (before?, after?);
        Some(self.speed(after) * self.frames[i].chord_out - self.speed(before) * self.frames[i].chord_in)
    }

    /// The curve after a step: samples go straight ahead on the surface, and the spans follow. `None` when it would cross
    /// far more edges than its input does.
    ///
    /// # Errors
    /// As [`FairCurve::new`].
    pub fn moved(
        &self,
        mesh: &SurfaceMesh,
        step: &FairStep,
        work: &mut SpanWork,
        report: &mut Report,
        pauses: &mut Pauses,
    ) -> Result<Option<Self>> {
        let few = MOST_CROSSINGS.min(MOST_CROSSINGS_PER_TRIANGLE * mesh.triangles().len());
        let most = few.max(MOST_CROSSINGS_PER_INPUT * self.crossings);
        let mut points = LargeVec::copied(&self.points, || pauses.tick())?;
        // What each sample crosses ends at its place in `ends` and begins where the one before it ends.
        let (mut crossed, mut ends) = (LargeVec::default(), LargeVec::with_capacity(points.len()));
        let mut word = Vec::new();
        for i in 0..points.len() {
            pauses.tick()?;
            if !self.input.is_pinned[i] {
                let [x, y] = self.frames[i].axes;
                let way = self.input.unit * (step.ways[i].x * x + step.ways[i].y * y);
                let left = most - crossed.len();
                let Some(point) = trace(mesh, &self.points[i], way, left, &mut word) else { return Ok(None) };
                points[i] = point;
                crossed.append(&mut word);
            }
            ends.push(crossed.len());
        }
        let crossed_by = |i: usize| &crossed[if i > 0 { ends[i - 1] } else { 0 }..ends[i]];
        let mut legs = Vec::with_capacity(self.spans.len());
        let mut left = most;
        for (i, span) in self.spans.iter().enumerate() {
            pauses.tick()?;
            let next = (i + 1) % points.len();
            let leg = span.leg.between_moved(mesh, points[i].triangle, crossed_by(i), crossed_by(next));
            let Some(rest) = left.checked_sub(leg.word.len()) else { return Ok(None) };
            left = rest;
            legs.push(leg);
        }
        let spans = relax_all(mesh, &points, legs, work, report, pauses)?;
        let (input, crossings) = (Arc::clone(&self.input), self.crossings);
        let frames = LargeVec::default();
        let moved = Self { input, crossings, closeness: self.closeness, points, spans, frames, energy: 0.0 };
        Ok(Some(moved.measured(mesh, pauses)?))
    }

    /// The curve as a line: its crossings alone, between its pins. `None` when a closed curve without pins crosses
    /// nothing any more.
    ///
    /// # Errors
    /// As [`FairCurve::new`].
    pub fn to_route(&self, mesh: &SurfaceMesh, pauses: &mut Pauses) -> Result<Option<Route>> {
        let (count, is_pinned) = (self.spans.len(), &self.input.is_pinned);
        let pins: Vec<usize> = (0..self.count()).filter(|&i| is_pinned[i]).collect();
        let start = pins.first().copied().unwrap_or(0);
        let mut legs: Vec<Leg> = Vec::new();
        for i in (0..count).map(|k| (start + k) % count) {
            let span = &self.spans[i].leg;
            pauses.ticks(1 + span.word.len())?;
            if legs.is_empty() || is_pinned[i] {
                legs.push(Leg { first: span.first, word: Vec::new(), parameters: Vec::new() });
            }
            let Some(leg) = legs.last_mut() else { continue };
            for (&h, &t) in span.word.iter().zip(&span.parameters) {
                leg.push(mesh, h, t);
            }
        }
        pauses.pause()?;
        let mut legs: Vec<Leg> = legs.into_iter().map(|leg| leg.without_full_turns(mesh).unwrap_or(leg)).collect();
        if pins.is_empty() {
            legs[0].reduce_seam(mesh);
            if legs[0].word.is_empty() {
                return Ok(None);
            }
        }
        let pins = pins.iter().map(|&i| self.points[i]).collect();
        let mut route = Route { closed: self.input.closed, pins, legs };
        pauses.pause()?;
        route.snap_to_vertices(mesh);
        pauses.pause()?;
        Ok(Some(route))
    }
}

/// Spans between neighbouring points in the strips `legs`.
fn relax_all(
    mesh: &SurfaceMesh,
    points: &[SurfacePoint],
    legs: Vec<Leg>,
    work: &mut SpanWork,
    report: &mut Report,
    pauses: &mut Pauses,
) -> Result<LargeVec<Span>> {
    let mut legs = LargeVec::from(legs);
    let mut spans = LargeVec::with_capacity(legs.len());
    for (i, leg) in legs.iter_mut().enumerate() {
        let (from, to) = (&points[i], &points[(i + 1) % points.len()]);
        spans.push(Span::relax(mesh, from, to, leg.take(), work, report, pauses)?);
    }
    Ok(spans)
}
