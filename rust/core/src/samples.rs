//! Samples of a line, with the strips between them: how `fair` holds a curve.
//!
//! Samples lie inside triangles, so that they can move freely; pins lie where they were given. A curve can be thinned
//! (fewer samples) and refined again. Holds no smoothing.

use glam::DVec3;

use crate::error::Result;
use crate::ids::TriangleId;
use crate::large::LargeVec;
use crate::leg::Leg;
use crate::mesh::SurfaceMesh;
use crate::pauses::Pauses;
use crate::route::Route;
use crate::spot::{crossing_point, in_triangle};
use crate::strip::{entered_triangle, push_reduced};
use crate::surface_point::SurfacePoint;
use crate::trace::moved_inside;

/// Pieces that the line between two neighbouring pins or picks is cut into at least, so that a curve through a few
/// large triangles is round as well.
const FEWEST_PIECES: usize = 4;

/// A piece between two samples is taken for at least this share of the spacing, where points coincide.
const SHORTEST_PIECE: f64 = 1e-3;

/// See the module. Closed: as many pieces as samples, the last one back to the first sample; open: one fewer.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Samples {
    /// Whether the last sample is joined to the first.
    pub closed: bool,
    /// Where they lie.
    pub points: LargeVec<SurfacePoint>,
    /// Samples that do not move.
    pub is_pinned: LargeVec<bool>,
    /// Where they were on the input, in space.
    pub anchors: LargeVec<DVec3>,
    /// The unit of length that `steps` are in, in the units of the positions: the spacing that was asked for.
    pub unit: f64,
    /// Length of the input between neighbouring samples; above 0.
    pub steps: LargeVec<f64>,
    /// Strips between neighbouring samples; parameters play no part.
    pub legs: LargeVec<Leg>,
}

/// How long a route with pins is, and what it crosses.
#[derive(Clone, Copy, Debug)]
pub struct InputSize {
    /// In the units of the positions.
    pub length: f64,
    /// Mean length of the edges that it crosses; where it crosses none, its own length.
    pub edge: f64,
    /// How many edges that are.
    pub crossings: usize,
    /// How many legs it has.
    pub legs: usize,
}

impl InputSize {
    /// Of a route.
    ///
    /// # Errors
    /// [`crate::Error::Interrupted`] at one of the `pauses`.
    pub fn of(mesh: &SurfaceMesh, route: &Route, pauses: &mut Pauses) -> Result<Self> {
        let (mut length, mut edges, mut crossings) = (0.0, 0.0, 0);
        for (i, leg) in route.legs.iter().enumerate() {
            for &h in &leg.word {
                pauses.tick()?;
                edges += mesh.edge_length(h);
            }
            crossings += leg.word.len();
            if let (Some(start), Some(end)) = (route.start_pin(i), route.end_pin(i)) {
                length += leg.length(mesh, start, end);
            }
            pauses.ticks(leg.word.len())?;
        }
        let edge = if crossings > 0 { edges / crossings as f64 } else { length };
        Ok(Self { length, edge, crossings, legs: route.legs.len() })
    }
}

/// A ring without pins as a route from a point on it back to the same; any other route as it is.
pub fn with_seam(mesh: &SurfaceMesh, route: Route) -> Route {
    let [leg] = &route.legs[..] else { return route };
    let (true, Some(&first), Some(&last)) = (route.pins.is_empty(), leg.word.first(), leg.word.last()) else {
        return route;
    };
    let count = leg.word.len();
    let start = in_triangle(mesh, &crossing_point(mesh, first, leg.parameters[0]), leg.first);
    let end = in_triangle(mesh, &crossing_point(mesh, last, leg.parameters[count - 1]), leg.first);
    Route { pins: vec![between(leg.first, start, end, 0.5)], ..route }
}

impl Samples {
    /// Samples of `input`, a route with pins, at most `spacing` apart, which is above 0; only pins with their flag in `is_pinned` stay fixed.
    ///
    /// # Errors
    /// [`crate::Error::Interrupted`] at one of the `pauses`.
    pub fn of_route(
        mesh: &SurfaceMesh,
        input: &Route,
        is_pinned: &[bool],
        spacing: f64,
        pauses: &mut Pauses,
    ) -> Result<Self> {
        let mut samples = Self { closed: input.closed, unit: spacing, ..Self::default() };
        for (i, leg) in input.legs.iter().enumerate() {
            let (Some(start), Some(end)) = (input.start_pin(i), input.end_pin(i)) else { continue };
            let mut piece = Leg { first: leg.first, word: Vec::new(), parameters: Vec::new() };
            if is_pinned[i] {
                samples.push(mesh, *start, true);
            } else {
                // It lies where the leg before it ends; what leads on from there belongs to the piece that begins here.
                let before = if i == 0 { input.legs.len() - 1 } else { i - 1 };
                piece.first = input.legs[before].last_triangle(mesh);
                piece.word = input.join(mesh, i).unwrap_or_default();
                samples.push(mesh, inner_sample(mesh, start, piece.first), false);
            }
            let length = leg.length(mesh, start, end);
            let pieces = ((length / spacing).ceil() as usize).max(FEWEST_PIECES);
            let step = (length / spacing / pieces as f64).max(SHORTEST_PIECE);
            let mut cuts =
                cut_leg(mesh, leg, [start, end], pieces - 1, |k| (k + 1) as f64 / pieces as f64, piece, pauses)?;
            samples.reserve(pieces);
            for &point in cuts.points.iter() {
                pauses.tick()?;
                samples.push(mesh, point, false);
            }
            for leg in cuts.legs.iter_mut() {
                pauses.tick()?;
                samples.steps.push(step);
                samples.legs.push(leg.take());
            }
        }
        if let (false, Some(last)) = (input.closed, input.pins.last()) {
            samples.push(mesh, *last, true);
        }
        Ok(samples)
    }

    fn reserve(&mut self, more: usize) {
        self.points.reserve(more);
        self.is_pinned.reserve(more);
        self.anchors.reserve(more);
        self.steps.reserve(more);
        self.legs.reserve(more);
    }

    fn push(&mut self, mesh: &SurfaceMesh, point: SurfacePoint, is_pinned: bool) {
        self.points.push(point);
        self.is_pinned.push(is_pinned);
        self.anchors.push(mesh.position_of(&point));
    }

    /// Adds a fixed sample before the first one (`at_start`) or after the last of an open curve, joined to it by `leg`, on
    /// which the input is `length` long, in the units of the positions: it holds the curve's direction there.
    pub fn clamp(&mut self, mesh: &SurfaceMesh, at_start: bool, point: SurfacePoint, leg: Leg, length: f64) {
        let step = (length / self.unit).max(SHORTEST_PIECE);
        let (sample, piece) = if at_start { (0, 0) } else { (self.points.len(), self.steps.len()) };
        self.points.insert(sample, point);
        self.is_pinned.insert(sample, true);
        self.anchors.insert(sample, mesh.position_of(&point));
        self.steps.insert(piece, step);
        self.legs.insert(piece, leg);
    }

    /// The samples that a thinner curve keeps: pins, and every `stride`-th after each.
    ///
    /// # Errors
    /// As [`Samples::of_route`].
    pub fn kept_at(&self, stride: usize, pauses: &mut Pauses) -> Result<LargeVec<usize>> {
        let count = self.points.len();
        let first_pin = self.is_pinned.iter().position(|&p| p).unwrap_or(0);
        // Those before the first pin are counted from the last one, on a ring.
        let last_pin = self.is_pinned.iter().rposition(|&p| p).unwrap_or(0);
        let mut since_pin = count - last_pin;
        let mut kept = LargeVec::with_capacity(count / stride + 1);
        for (i, &is_pinned) in self.is_pinned.iter().enumerate() {
            pauses.tick()?;
            since_pin = if is_pinned || i == first_pin { 0 } else { since_pin };
            if since_pin % stride == 0 {
                kept.push(i);
            }
            since_pin += 1;
        }
        Ok(kept)
    }

    /// The pieces of this curve that piece `k` of the curve of the samples `kept` is made of, as places in `steps` that may
    /// lie beyond the seam.
    fn piece_of(&self, kept: &[usize], k: usize) -> std::ops::Range<usize> {
        kept[k]..kept.get(k + 1).copied().unwrap_or(kept[0] + self.points.len())
    }

    /// The curve of the samples `kept` alone.
    ///
    /// # Errors
    /// As [`Samples::of_route`].
    pub fn thinned(&self, mesh: &SurfaceMesh, kept: &[usize], pauses: &mut Pauses) -> Result<Self> {
        let mut thin = self.spaced(kept, pauses)?;
        let count = self.steps.len();
        for k in 0..thin.steps.len() {
            let pieces = self.piece_of(kept, k);
            let mut leg = Leg::empty(self.legs[pieces.start % count].first);
            for i in pieces {
                pauses.tick()?;
                self.legs[i % count].word.iter().for_each(|&h| push_reduced(mesh, &mut leg.word, h));
            }
            thin.legs.push(leg);
        }
        Ok(thin)
    }

    /// The samples `kept` alone, without strips between them.
    ///
    /// # Errors
    /// As [`Samples::of_route`].
    pub fn spaced(&self, kept: &[usize], pauses: &mut Pauses) -> Result<Self> {
        let mut thin = Self { closed: self.closed, unit: self.unit, ..Self::default() };
        thin.reserve(kept.len());
        let count = self.steps.len();
        for (k, &i) in kept.iter().enumerate() {
            pauses.tick()?;
            thin.points.push(self.points[i]);
            thin.is_pinned.push(self.is_pinned[i]);
            thin.anchors.push(self.anchors[i]);
            if self.closed || k + 1 < kept.len() {
                thin.steps.push(self.piece_of(kept, k).map(|i| self.steps[i % count]).sum());
            }
        }
        Ok(thin)
    }

    /// These samples, whose strips play no part, where a thinner curve of the samples `kept` has them, which has come to lie
    /// at `points`, joined by `legs`.
    ///
    /// # Errors
    /// As [`Samples::of_route`].
    pub fn refined(
        mut self,
        mesh: &SurfaceMesh,
        kept: &[usize],
        points: &[SurfacePoint],
        legs: &[&Leg],
        pauses: &mut Pauses,
    ) -> Result<Self> {
        let count = self.steps.len();
        self.legs.clear();
        for (k, leg) in legs.iter().enumerate() {
            let pieces = self.piece_of(kept, k);
            let (start, end) = (&points[k], &points[(k + 1) % points.len()]);
            let total: f64 = pieces.clone().map(|i| self.steps[i % count]).sum();
            let (mut done, steps) = (0.0, &self.steps);
            let share = |j: usize| {
                done += steps[(pieces.start + j) % count];
                done / total
            };
            let piece = Leg::empty(leg.first);
            let mut cuts = cut_leg(mesh, leg, [start, end], pieces.len() - 1, share, piece, pauses)?;
            self.points[pieces.start % count] = *start;
            for (i, &point) in pieces.clone().skip(1).zip(cuts.points.iter()) {
                self.points[i % count] = point;
            }
            self.legs.extend(cuts.legs.iter_mut().map(Leg::take));
        }
        // On a ring the first of the kept samples need not be the first of these.
        self.legs.rotate_right(kept.first().copied().unwrap_or(0));
        Ok(self)
    }
}

/// Points that cut a leg, and the strips between them.
struct Cuts {
    points: LargeVec<SurfacePoint>,
    legs: LargeVec<Leg>,
}

/// The piece of a leg from its start (`at_start`) to `share` of its length, or from there to its end: where it was cut, and
/// its strip.
///
/// # Errors
/// As [`Samples::of_route`].
pub fn end_piece(
    mesh: &SurfaceMesh,
    leg: &Leg,
    [start, end]: [&SurfacePoint; 2],
    at_start: bool,
    share: f64,
    pauses: &mut Pauses,
) -> Result<Option<(SurfacePoint, Leg)>> {
    let mut cuts = cut_leg(mesh, leg, [start, end], 1, |_| share, Leg::empty(leg.first), pauses)?;
    let piece = cuts.legs.get_mut(usize::from(!at_start)).map(Leg::take);
    Ok(cuts.points.first().copied().zip(piece))
}

/// Cuts a leg in `count` places at shares of its length, which are asked for one after the other and rise; `piece` holds
/// what lies before the leg's first letter.
fn cut_leg(
    mesh: &SurfaceMesh,
    leg: &Leg,
    [start, end]: [&SurfacePoint; 2],
    count: usize,
    mut share_of: impl FnMut(usize) -> f64,
    mut piece: Leg,
    pauses: &mut Pauses,
) -> Result<Cuts> {
    let length = leg.length(mesh, start, end);
    pauses.ticks(leg.word.len())?;
    let mut cuts = Cuts { points: LargeVec::with_capacity(count), legs: LargeVec::with_capacity(count + 1) };
    let mut share = (count > 0).then(|| share_of(0));
    let (mut triangle, mut here, mut done) = (leg.first, *start, 0.0);
    for i in 0..=leg.word.len() {
        let letter = leg.word.get(i).map(|&h| (h, leg.parameters[i]));
        let next = letter.map_or(*end, |(h, t)| crossing_point(mesh, h, t));
        let segment = mesh.position_of(&here).distance(mesh.position_of(&next));
        pauses.tick()?;
        while let Some(next_share) = share {
            let ahead = next_share * length - done;
            // The last segment takes what rounding has left over.
            if ahead > segment && letter.is_some() {
                break;
            }
            pauses.tick()?;
            let part = if segment > 0.0 { (ahead / segment).min(1.0) } else { 0.5 };
            let (a, b) = (in_triangle(mesh, &here, triangle), in_triangle(mesh, &next, triangle));
            let next_piece = Leg { first: triangle, word: Vec::new(), parameters: Vec::new() };
            cuts.legs.push(std::mem::replace(&mut piece, next_piece));
            cuts.points.push(moved_inside(between(triangle, a, b, part)));
            share = (cuts.points.len() < count).then(|| share_of(cuts.points.len()));
        }
        done += segment;
        here = next;
        if let Some((h, _)) = letter {
            push_reduced(mesh, &mut piece.word, h);
            triangle = entered_triangle(mesh, h);
        }
    }
    cuts.legs.push(piece);
    Ok(cuts)
}

/// `point`, which `triangle` holds, moved a little inside it.
fn inner_sample(mesh: &SurfaceMesh, point: &SurfacePoint, triangle: TriangleId) -> SurfacePoint {
    moved_inside(SurfacePoint { triangle, barycentric: in_triangle(mesh, point, triangle) })
}

fn between(triangle: TriangleId, a: [f64; 3], b: [f64; 3], share: f64) -> SurfacePoint {
    SurfacePoint { triangle, barycentric: std::array::from_fn(|k| (1.0 - share) * a[k] + share * b[k]) }
}
