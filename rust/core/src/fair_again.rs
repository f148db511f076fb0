//! A fair line made again where picks have moved, and taken from the line before elsewhere.
//!
//! ```text
//!     ----o----------o==========o     o==========o----------o----     --- taken over     === made again
//!                  x          .   \ /   .          x                  x   fixed samples, which hold the direction
//!                                  o
//! ```
//!
//! What a pick does to a spline fades from pick to pick, to 0.27 at equal distances. The legs at the change and those next
//! to it are made again, as many as it takes for what is left to be small. Each leg is measured by where the picks were when
//! it was made, so that it stays near over a long drag, and a pick that comes back takes its share back. The curve is a draft
//! (`smooth_fair`). Holds which legs; the curve is made there.

use std::sync::Arc;

use glam::DVec3;

use crate::error::{Error, Result};
use crate::kept::{KeptFair, MadeAt};
use crate::mesh::SurfaceMesh;
use crate::pauses::Pauses;
use crate::report::{Observer, Report, Step, StopReason};
use crate::route::Route;
use crate::samples::{InputSize, Samples, end_piece};
use crate::smooth_fair::{DRAFT, FairTask, Lowering, choose_detail_size, smooth_fair, spacing_on};
use crate::surface_point::SurfacePoint;

/// What is left of a change one leg further: 0.27 at equal distances, more where a short leg follows a long one.
const FADING: f64 = 0.3;

/// A leg is made again when it may be off by this share of an edge,
const TOLERANCE: f64 = 0.1;
/// or by this share of what the pick has moved: a pick that goes far at once is still on its way.
const TOLERANCE_OF_SHIFT: f64 = 0.05;

/// The fixed sample beside a stretch is so many pieces away from it.
const CLAMP_PIECES: f64 = 4.0;

/// The line before, for a fair line with other picks.
#[derive(Clone, Copy, Debug)]
pub struct FairBefore<'a> {
    /// What it was.
    pub route: &'a Route,
    /// What it has kept.
    pub kept: &'a KeptFair,
    /// How far the furthest pick has moved; `None` when there are more or fewer.
    pub shift: Option<f64>,
    /// For each leg of the new input, the leg of the old one that is the same.
    pub same: &'a [Option<usize>],
}

/// Smooths `route`, the input, of which most legs are those of the line before. Returns when each leg was made, for
/// [`KeptFair::made_at`].
///
/// # Errors
/// As [`smooth_fair`].
pub fn smooth_fair_again(
    task: &FairTask,
    before: &FairBefore,
    route: &mut Route,
    report: &mut Report,
    observer: &mut dyn Observer,
) -> Result<Vec<MadeAt>> {
    let count = route.legs.len();
    // Where picks are not pinned, the legs of the line are not those of its input, and closeness couples all of them.
    if !task.is_pinned.iter().all(|&pinned| pinned) || before.route.legs.len() != before.kept.input.len() {
        smooth_fair(task, route, report, observer)?;
        return Ok(Vec::new());
    }
    let input = route.clone();
    let size = InputSize::of(task.mesh, &input, &mut Pauses::new(observer, Step::Relax))?;
    let (made_at, is_open) = choose_legs(task.mesh, before, &input, size.edge);
    if is_open.iter().all(|&open| open) {
        smooth_fair(task, route, report, observer)?;
        return Ok(Vec::new());
    }
    for i in (0..count).filter(|&i| !is_open[i]) {
        if let Some(k) = before.same[i] {
            route.legs[i].clone_from(&before.route.legs[k]);
        }
    }
    report.detail_size = Some(choose_detail_size(&size, &input, task.is_pinned, task.options.detail_size)?);
    let begins = |i: usize| is_open[i] && !(if i > 0 { is_open[i - 1] } else { input.closed && is_open[count - 1] });
    let mut is_settled = true;
    for start in (0..count).filter(|&i| begins(i)) {
        let legs: Vec<usize> = (start..start + count).map(|i| i % count).take_while(|&i| is_open[i]).collect();
        is_settled &= smooth_stretch(task, &input, &legs, route, report, observer)?;
    }
    report.stop_reason = match is_settled {
        false => StopReason::MaxIterations,
        true if route.touches_vertex() => StopReason::ConvergedAtVertices,
        true => StopReason::Converged,
    };
    Ok(made_at)
}

/// When each leg was made once those with their flag are made again; `edge` is the mean length of the edges that the input
/// crosses.
fn choose_legs(mesh: &SurfaceMesh, before: &FairBefore, input: &Route, edge: f64) -> (Vec<MadeAt>, Vec<bool>) {
    let count = input.legs.len();
    let length = |i: usize| Some(input.legs[i].length(mesh, input.start_pin(i)?, input.end_pin(i)?));
    let longest = (0..count).filter(|&i| before.same[i].is_none()).filter_map(length).fold(0.0, f64::max);
    // A pick that came or went has moved as far as it could.
    let shift = before.shift.unwrap_or(longest);
    let tolerance = (TOLERANCE * edge).max(TOLERANCE_OF_SHIFT * shift);
    let distances = distances_from(before.same, input.closed);
    let places = |route: &Route| -> Arc<[DVec3]> { route.pins.iter().map(|pin| mesh.position_of(pin)).collect() };
    let (old_pins, new_pins) = (places(before.route), places(input));
    // Pins are told apart by their order.
    let are_in_place = old_pins.len() == new_pins.len() && (0..count).all(|i| before.same[i].is_none_or(|k| k == i));
    let (mut made_at, mut is_open) = (Vec::with_capacity(count), Vec::with_capacity(count));
    for (i, (same, distance)) in before.same.iter().zip(distances).enumerate() {
        let note = same.map(|k| {
            let fresh = || MadeAt { pins: old_pins.clone(), off: 0.0 };
            let note = before.kept.made_at.get(k).cloned().unwrap_or_else(fresh);
            if are_in_place {
                return note;
            }
            let off = note.off + drift(&note.pins, &old_pins, k, input.closed) + shift * FADING.powi(distance as i32);
            MadeAt { pins: new_pins.clone(), off }
        });
        let near = note.filter(|note| note.off + drift(&note.pins, &new_pins, i, input.closed) <= tolerance);
        is_open.push(near.is_none());
        made_at.push(near.unwrap_or_else(|| MadeAt { pins: new_pins.clone(), off: 0.0 }));
    }
    (made_at, is_open)
}

/// How far leg `leg` may have come off as all pins of a line went from `then` to `now`.
fn drift(then: &[DVec3], now: &[DVec3], leg: usize, closed: bool) -> f64 {
    let count = now.len();
    let ends = [leg, (leg + 1) % count];
    let legs_between =
        |a: usize, b: usize| if closed { a.abs_diff(b).min(count - a.abs_diff(b)) } else { a.abs_diff(b) };
    let share = |pin: usize| FADING.powi(ends.map(|end| legs_between(pin, end)).into_iter().min().unwrap_or(0) as i32);
    let moved = then.iter().zip(now).enumerate().filter(|(_, (a, b))| a != b);
    moved.map(|(pin, (a, b))| share(pin) * a.distance(*b)).sum()
}

/// For each leg how many legs it is away from one that is not the same.
fn distances_from(same: &[Option<usize>], closed: bool) -> Vec<usize> {
    let count = same.len();
    let mut distances: Vec<usize> = same.iter().map(|k| if k.is_none() { 0 } else { count }).collect();
    for _ in 0..if closed { 2 } else { 1 } {
        for i in 1..count + usize::from(closed) {
            distances[i % count] = distances[i % count].min(distances[i - 1] + 1);
        }
        for i in (usize::from(!closed)..count).rev() {
            let (here, next) = if closed { (i, (i + 1) % count) } else { (i - 1, i) };
            distances[here] = distances[here].min(distances[next] + 1);
        }
    }
    distances
}

/// Makes the consecutive legs `legs` of `route` again, whose other legs are as they were. False at the limit of rounds.
fn smooth_stretch(
    task: &FairTask,
    input: &Route,
    legs: &[usize],
    route: &mut Route,
    report: &mut Report,
    observer: &mut dyn Observer,
) -> Result<bool> {
    let mesh = task.mesh;
    let (Some(&first), Some(&last), count) = (legs.first(), legs.last(), input.legs.len()) else { return Ok(true) };
    let pins: Vec<SurfacePoint> =
        legs.iter().filter_map(|&i| input.start_pin(i)).chain(input.end_pin(last)).copied().collect();
    let stretch = Route { closed: false, legs: legs.iter().map(|&i| input.legs[i].clone()).collect(), pins };
    let detail_size = report.detail_size.unwrap_or(f64::INFINITY);
    let mut pauses = Pauses::new(observer, Step::Relax);
    let spacing = spacing_on(&InputSize::of(mesh, &stretch, &mut pauses)?, detail_size);
    let mut samples = Samples::of_route(mesh, &stretch, &vec![true; stretch.pins.len()], spacing, &mut pauses)?;
    let sides = [
        (true, first.checked_sub(1).or(input.closed.then(|| count - 1))),
        (false, Some((last + 1) % count).filter(|&next| next > 0 || input.closed)),
    ];
    let mut is_clamped = [false; 2];
    for (side, &(is_start, leg)) in sides.iter().enumerate() {
        let Some(leg) = leg else { continue };
        let (Some(start), Some(end)) = (input.start_pin(leg), input.end_pin(leg)) else { continue };
        let (own, of_input) = (route.legs[leg].length(mesh, start, end), input.legs[leg].length(mesh, start, end));
        let share = (CLAMP_PIECES * spacing / own).min(0.5);
        let at = if is_start { 1.0 - share } else { share };
        let clamp = end_piece(mesh, &route.legs[leg], [start, end], !is_start, at, &mut pauses)?;
        if let Some((point, piece)) = clamp {
            samples.clamp(mesh, is_start, point, piece, share * of_input);
            is_clamped[side] = true;
        }
    }
    let mut lowering = Lowering::new(task, report, observer);
    let (curve, is_settled) = lowering.refine(&samples, detail_size, &DRAFT)?;
    let made = curve.to_route(mesh, &mut lowering.pauses)?;
    lowering.finish();
    let made = made.ok_or(Error::Collapsed { iterations: 0 })?;
    let made = made.legs.into_iter().skip(usize::from(is_clamped[0]));
    for (&i, leg) in legs.iter().zip(made) {
        route.legs[i] = leg;
    }
    Ok(is_settled)
}
