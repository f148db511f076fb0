//! Step D for the paper's filters: pass a mesh vertex only if the filter itself finds the other side better.
//!
//! The paper swaps every fan that the line has merged with, which cycles at saddles and gets stuck where several vertices
//! of the line have merged: each one's neighbours are at the mesh vertex too, so none has a reason to move. Here the
//! vertices of a side that is open to the line are placed together, where the straight line of the unfolded fan crosses
//! the spokes, relaxed together with the filter, and kept only if the filter's measure fell. The side may be the strip's
//! own: then merged vertices are freed.

use std::collections::HashMap;
use std::f64::consts::PI;
use std::ops::{ControlFlow, Range};

use glam::DVec3;

use crate::error::Result;
use crate::filter::geodesic::unwind;
use crate::filter::{Edge, Side, SlidingFilter};
use crate::ids::{HalfedgeId, VertexId};
use crate::mesh::SurfaceMesh;
use crate::pauses::Pauses;
use crate::relax::beads::Beads;
use crate::relax::funnel::{Funnel, shortest_crossings};
use crate::relax::heap::relax_by_heap;
use crate::relax::implicit::relax_implicitly;
use crate::report::Report;
use crate::route::Route;
use crate::spot::{crossing_position, parameter_at};
use crate::unfold::Unfolding;
use crate::vertex_pass::{ANGLE_SLACK, Run, angle_between, measure_sides, other_side_word};

/// The joint relaxation of a new fan is finer than the line's threshold, so that the comparison is not decided by it.
const FAN_THRESHOLD: f64 = 1e-6;

/// Moves that the joint relaxation of a new fan may take for each of its vertices.
const FAN_MOVES: u64 = 200;

/// Steps of all vertices of a new fan at once, which come before its moves,
const FAN_STEPS: u64 = 20;
/// and how long the first one is: there are few vertices, and nothing to be passed on the way.
const FIRST_FAN_STEP: f64 = 8.0;

/// A pass must lower the measure by more than this share: less is rounding and could go back and forth.
const GAIN: f64 = 1e-9;

/// Work space; kept for its memory.
#[derive(Debug, Default)]
pub struct PassWork {
    unfolding: Unfolding,
    funnel: Funnel,
    /// At each mesh vertex so far: times that vertices of the line were freed on their own side, and passes kept.
    changes: HashMap<VertexId, [u32; 2]>,
    /// The fan that was refused last at each mesh vertex, freed or passed: the same again would be refused again.
    refused: HashMap<(VertexId, usize), Attempt>,
    /// Whether a vertex that was changed once is left alone: set when the line has come back to a strip, or found no rest.
    pub is_strict: bool,
    /// Whether the vertices of a new fan are first moved all at once, which takes far fewer steps than one by one.
    pub at_once: bool,
}

impl PassWork {
    /// Forgets at which vertices the line was changed: what it did on its way says nothing of where it comes to rest.
    pub fn forget_changes(&mut self) {
        self.changes.clear();
        self.is_strict = false;
    }
}

/// All that decides whether a fan is kept.
#[derive(PartialEq, Debug)]
struct Attempt {
    fan: Vec<HalfedgeId>,
    /// The stretch that it would replace, with the fixed points on both sides.
    old: Vec<DVec3>,
    fixed_before: usize,
    threshold: f64,
}

/// Places in [`PassWork::changes`].
const FREED: usize = 0;
const PASSED: usize = 1;

/// Changes of one kind at one mesh vertex after which the line stays there: it came back every time, so the side is no better once
/// the whole line has been relaxed, whatever the fan alone says.
const MAX_CHANGES_AT_VERTEX: u32 = 3;

/// A vertex of the line counts as merged with a mesh vertex when it is nearer than this, in barycentric units.
///
/// Sliding one vertex at a time only approaches a mesh vertex: several crowd there, ever closer, and never arrive. A
/// generous distance does no harm, since a pass is kept only if the filter's measure falls.
pub const MERGING: f64 = 1e-2;

/// The mesh vertex that a crossing has merged with.
pub fn merged_vertex(mesh: &SurfaceMesh, letter: HalfedgeId, t: f64) -> Option<VertexId> {
    let [low, high] = mesh.sorted_ends(letter);
    if t <= MERGING {
        Some(low)
    } else if t >= 1.0 - MERGING {
        Some(high)
    } else {
        None
    }
}

/// Letters of a leg from which on each change of it takes a millisecond: what comes after is moved.
const LONG_LEG: usize = 20_000;

/// Tries every mesh vertex that the legs with their flag in `is_open` run through between their pins; returns at how many the line changed.
///
/// # Errors
/// [`crate::Error::Interrupted`] at one of the `pauses`.
#[expect(clippy::too_many_arguments, reason = "all of them are the state of one round")]
pub fn pass_vertices(
    mesh: &SurfaceMesh,
    route: &mut Route,
    is_open: &[bool],
    filter: &impl SlidingFilter,
    threshold: f64,
    report: &mut Report,
    work: &mut PassWork,
    pauses: &mut Pauses,
) -> Result<u64> {
    let mut changes = 0;
    for leg in (0..route.legs.len()).filter(|&leg| is_open[leg]) {
        if route.pins.is_empty() {
            begin_between_vertices(mesh, route);
        }
        let mut from = 0;
        while let Some((vertex, letters)) = next_run(mesh, route, leg, from) {
            from = letters.end;
            pauses.tick()?;
            if let Some(new_end) = try_pass(mesh, route, leg, vertex, letters, filter, threshold, report, work) {
                changes += 1;
                from = new_end;
                if route.legs[leg].word.len() > LONG_LEG {
                    pauses.pause()?;
                }
            }
        }
        if route.pins.is_empty() {
            cancel_seam(mesh, route);
        }
    }
    Ok(changes)
}

/// Turns a closed word so that no run goes across its seam.
fn begin_between_vertices(mesh: &SurfaceMesh, route: &mut Route) {
    let leg = &mut route.legs[0];
    let vertex = |i: usize| merged_vertex(mesh, leg.word[i], leg.parameters[i]);
    let count = leg.word.len();
    let start = (0..count).find(|&i| vertex(i).is_none() || vertex(i) != vertex((i + count - 1) % count));
    if let Some(start) = start {
        leg.word.rotate_left(start);
        leg.parameters.rotate_left(start);
        leg.first = leg.word[0].triangle();
    }
}

/// Cancels backtracks across the seam of a closed word.
fn cancel_seam(mesh: &SurfaceMesh, route: &mut Route) {
    let leg = &mut route.legs[0];
    while leg.word.len() >= 2 && mesh.twin(leg.word[leg.word.len() - 1]) == Some(leg.word[0]) {
        leg.word.pop();
        leg.parameters.pop();
        leg.word.remove(0);
        leg.parameters.remove(0);
    }
    if let Some(&letter) = leg.word.first() {
        leg.first = letter.triangle();
    }
}

/// The next mesh vertex on a leg from letter `from` on, and the letters that cross it.
fn next_run(mesh: &SurfaceMesh, route: &Route, leg: usize, from: usize) -> Option<(VertexId, Range<usize>)> {
    let leg = &route.legs[leg];
    let (first, vertex) =
        (from..leg.word.len()).find_map(|i| Some(i).zip(merged_vertex(mesh, leg.word[i], leg.parameters[i])))?;
    let is_here = |i: &usize| merged_vertex(mesh, leg.word[*i], leg.parameters[*i]) == Some(vertex);
    let end = (first + 1..leg.word.len()).find(|i| !is_here(i)).unwrap_or(leg.word.len());
    Some((vertex, first..end))
}

/// Passes one vertex if the filter's measure falls; returns the end of the new letters in the leg's word.
#[expect(clippy::too_many_arguments, reason = "all of them are the state of one round")]
fn try_pass(
    mesh: &SurfaceMesh,
    route: &mut Route,
    leg: usize,
    vertex: VertexId,
    letters: Range<usize>,
    filter: &impl SlidingFilter,
    threshold: f64,
    report: &mut Report,
    work: &mut PassWork,
) -> Option<usize> {
    if !mesh.is_passable(vertex) {
        return None;
    }
    let most_changes = if work.is_strict { 1 } else { MAX_CHANGES_AT_VERTEX };
    let changes = work.changes.get(&vertex).copied().unwrap_or_default();
    if let Some(rest) = unwind(mesh, &route.legs[leg].word[letters.clone()]) {
        // Whole turns round the vertex are a loop, whatever the angles; what is left of the run crosses the vertex itself.
        let (window, rest) = reduced(mesh, &route.legs[leg].word, letters, rest);
        let parameters: Vec<f64> = rest.iter().map(|&h| parameter_at(mesh, h, vertex)).collect();
        let end = window.start + rest.len();
        route.legs[leg].word.splice(window.clone(), rest);
        route.legs[leg].parameters.splice(window, parameters);
        report.loops_removed += 1;
        return Some(end);
    }
    let word = &route.legs[leg].word;
    let centre = mesh.position(vertex);
    let (&before, &after) = (
        neighbours(mesh, route, leg, letters.start, false, 1).first()?,
        neighbours(mesh, route, leg, letters.end, true, 1).first()?,
    );
    let far = |spoke: HalfedgeId| mesh.position(mesh.other_end(spoke, vertex)) - centre;
    let (first, last) = (word[letters.start], word[letters.end - 1]);
    let run = Run {
        vertex,
        first,
        last,
        angle_in: angle_between(far(first), before - centre),
        angle_out: angle_between(far(last), after - centre),
    };
    let sides = measure_sides(mesh, &run);
    let own = (sides.own, route.legs[leg].word[letters.clone()].to_vec(), FREED);
    let other = (sides.other, if sides.other < PI { other_side_word(mesh, &run) } else { Vec::new() }, PASSED);
    let both = if sides.own <= sides.other { [own, other] } else { [other, own] };
    for (angle, fan, kind) in both {
        if angle >= PI - ANGLE_SLACK {
            break;
        }
        if changes[kind] >= most_changes {
            continue;
        }
        if let Some(end) =
            try_fan(mesh, route, leg, letters.clone(), fan, (vertex, kind), filter, threshold, report, work)
        {
            report.vertex_passes += kind as u64;
            work.changes.entry(vertex).or_default()[kind] += 1;
            return Some(end);
        }
    }
    None
}

/// Puts the letters of a fan in the place of a run, if the filter's measure falls; returns the end of the new letters.
#[expect(clippy::too_many_arguments, reason = "all of them are the state of one round")]
fn try_fan(
    mesh: &SurfaceMesh,
    route: &mut Route,
    leg: usize,
    letters: Range<usize>,
    fan: Vec<HalfedgeId>,
    place: (VertexId, usize),
    filter: &impl SlidingFilter,
    threshold: f64,
    report: &mut Report,
    work: &mut PassWork,
) -> Option<usize> {
    let (window, fan) = reduced(mesh, &route.legs[leg].word, letters, fan);
    let reach = filter.reach();
    let before = neighbours(mesh, route, leg, window.start, false, reach);
    let after = neighbours(mesh, route, leg, window.end, true, reach);
    let (&start, &end) = (before.first()?, after.first()?);
    let old_leg = &route.legs[leg];
    let crossings = window.clone().map(|i| crossing_position(mesh, old_leg.word[i], old_leg.parameters[i]));
    let old: Vec<DVec3> = before.iter().rev().copied().chain(crossings).chain(after.iter().copied()).collect();
    let threshold = threshold.min(FAN_THRESHOLD);
    let attempt = Attempt { fan, old, fixed_before: before.len(), threshold };
    if work.refused.get(&place) == Some(&attempt) {
        return None;
    }
    let fan = &attempt.fan;
    let mut parameters = Vec::with_capacity(fan.len());
    report.funnels += 1;
    shortest_crossings(mesh, start, fan, end, &mut work.unfolding, &mut work.funnel, &mut parameters);
    let mut beads = Beads::default();
    before.iter().rev().for_each(|&p| beads.push_fixed(p));
    for (&letter, &t) in fan.iter().zip(&parameters) {
        let [low, high] = mesh.sorted_ends(letter).map(|v| mesh.position(v));
        beads.push(Edge { low, high }, t);
    }
    after.iter().for_each(|&p| beads.push_fixed(p));
    let moves = FAN_MOVES * (fan.len() as u64 + 1);
    if work.at_once {
        let mut time_step = FIRST_FAN_STEP;
        let outcome = relax_implicitly(&mut beads, filter, threshold, FAN_STEPS, &mut time_step, || Ok(()));
        report.newton_steps += outcome.map_or(0, |outcome| outcome.steps);
    }
    let outcome = relax_by_heap(&mut beads, filter, threshold, moves, None, || ControlFlow::Continue(()));
    report.moves += outcome.moves;
    let (was, is) = (filter.measure(&attempt.old), filter.measure(&beads.positions));
    // Written so that a measure that is not a number is refused.
    let is_better = is < was * (1.0 - GAIN);
    if !is_better {
        work.refused.insert(place, attempt);
        return None;
    }
    let fan = attempt.fan;
    parameters.copy_from_slice(&beads.parameters[before.len()..before.len() + fan.len()]);
    let new_end = window.start + fan.len();
    let leg = &mut route.legs[leg];
    leg.word.splice(window.clone(), fan);
    leg.parameters.splice(window, parameters);
    Some(new_end)
}

/// The letters to replace and the letters to put there, after backtracks at both seams have cancelled.
fn reduced(
    mesh: &SurfaceMesh,
    word: &[HalfedgeId],
    letters: Range<usize>,
    mut fan: Vec<HalfedgeId>,
) -> (Range<usize>, Vec<HalfedgeId>) {
    let Range { mut start, mut end } = letters;
    let cancels = |a: HalfedgeId, b: HalfedgeId| mesh.twin(a) == Some(b);
    loop {
        if start > 0 && fan.first().is_some_and(|&h| cancels(word[start - 1], h)) {
            start -= 1;
            fan.remove(0);
        } else if end < word.len() && fan.last().is_some_and(|&h| cancels(h, word[end])) {
            end += 1;
            fan.pop();
        } else if fan.is_empty() && start > 0 && end < word.len() && cancels(word[start - 1], word[end]) {
            start -= 1;
            end += 1;
        } else {
            return (start..end, fan);
        }
    }
}

/// Up to `reach` places of the line before letter `letter` of a leg (or from it on, `forward`), nearest first, across
/// pins.
fn neighbours(mesh: &SurfaceMesh, route: &Route, leg: usize, letter: usize, forward: bool, reach: usize) -> Side {
    let mut side = Side::new();
    let legs = route.legs.len();
    let (mut leg, mut letter) = (leg, letter);
    // A line of few crossings may be walked round once; its own letters are then neighbours of each other.
    let mut left = 2 + route.legs.iter().map(|l| l.word.len() + 1).sum::<usize>();
    while side.len() < reach && left > 0 {
        left -= 1;
        let here = &route.legs[leg];
        let next = if forward { (letter < here.word.len()).then_some(letter) } else { letter.checked_sub(1) };
        match next {
            Some(i) => {
                side.push(crossing_position(mesh, here.word[i], here.parameters[i]));
                letter = if forward { i + 1 } else { i };
            }
            None => {
                let pin = if forward { route.end_pin(leg) } else { route.start_pin(leg) };
                side.extend(pin.map(|pin| mesh.position_of(pin)));
                let is_end = !route.closed && if forward { leg + 1 == legs } else { leg == 0 };
                if is_end {
                    break;
                }
                leg = if forward { (leg + 1) % legs } else { (leg + legs - 1) % legs };
                letter = if forward { 0 } else { route.legs[leg].word.len() };
            }
        }
    }
    side
}
