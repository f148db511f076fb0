//! The `geodesic` filter on a closed line without pins: a closed locally shortest line, exactly.
//!
//! A closed strip has no fixed point to start from, so one is found: the shortest line from a point of one edge, once
//! round the unfolded strip, to the same point is a convex function of that point (the strip is flat and simply
//! connected once it is unfolded). If the best such line touches a vertex, the rest is an open line from that vertex to
//! itself; if not, it is straight all the way and finished. An anchor vertex that need not be on the line is let go.

use std::collections::HashSet;
use std::f64::consts::PI;
use std::hash::{DefaultHasher, Hash, Hasher};

use glam::DVec2;

use crate::error::{Error, Result};
use crate::filter::geodesic::{GeodesicLeg, cross_straight, unwind};
use crate::filter::workspace::Workspace;
use crate::ids::{HalfedgeId, VertexId};
use crate::leg::Leg;
use crate::mesh::SurfaceMesh;
use crate::pauses::Pauses;
use crate::relax::funnel::Funnel;
use crate::report::{Observer, Report, Step};
use crate::spot::{crossing_position, parameter_at};
use crate::strip::{push_reduced, reduce_seam};
use crate::surface_point::SurfacePoint;
use crate::unfold::{Unfolding, ahead_of};
use crate::vertex_pass::{ANGLE_SLACK, Run, angle_between, measure_sides, other_side_word};

/// Halvings of the parameter of the anchor: one bit of an f64 each.
const HALVINGS: u32 = 60;

/// How near to the ends of the anchor's edge a loop is tried, as a share of the edge: at the ends themselves the start
/// would lie on portals, where the funnel has no direction to begin with.
const MARGIN: f64 = 1e-12;

/// A closed line shorter than this, relative to its longest crossed edge, is a point.
const COLLAPSED_LENGTH: f64 = 1e-12;

/// What a closed line is held by.
enum Loop {
    /// Nothing: it is straight.
    Straight(Leg),
    /// A vertex.
    Anchored(Anchored),
}

/// A closed strip and a vertex that holds it; the letters of the run round that vertex come first in the word.
struct Anchored {
    word: Vec<HalfedgeId>,
    vertex: VertexId,
    run_length: usize,
}

/// How an anchored loop goes on.
enum Next {
    /// And whether a vertex was left because it had changed too often.
    Done(Leg, bool),
    Again(Loop),
}

/// Straightens a closed strip; also tells whether a vertex was left because it had changed too often. `on_round` is told
/// the line after each round and says whether another may follow.
///
/// # Errors
/// [`Error::Collapsed`] when the line shrinks to a point, [`Error::Interrupted`].
pub fn straighten_loop(
    mesh: &SurfaceMesh,
    word: Vec<HalfedgeId>,
    work: &mut Workspace,
    report: &mut Report,
    observer: &mut dyn Observer,
    mut on_round: impl FnMut(&Leg, &mut Report) -> bool,
) -> Result<(Leg, bool)> {
    let mut state = relax_loop(mesh, word, report, &mut Pauses::new(observer, Step::Relax))?;
    let mut seen = HashSet::new();
    loop {
        match state {
            Loop::Straight(leg) => {
                on_round(&leg, report);
                return Ok((leg, false));
            }
            Loop::Anchored(anchored) => {
                let mut pauses = Pauses::new(observer, Step::VertexPass);
                pauses.pause()?;
                // Where edges have no length, no side of an anchor need be the better one, and anchors take turns for ever.
                let is_last = !seen.insert((anchored.vertex, digest(&anchored.word)));
                match relax_anchored(mesh, anchored, is_last, work, report, &mut pauses, &mut on_round)? {
                    Next::Done(leg, is_capped) => return Ok((leg, is_capped)),
                    Next::Again(next) => state = next,
                }
            }
        }
    }
}

/// A number that tells words from each other. It is the same in every run; should two words share one, the loop rests early and
/// is straightened on the shaken mesh.
fn digest(word: &[HalfedgeId]) -> u64 {
    let mut hasher = DefaultHasher::new();
    word.hash(&mut hasher);
    hasher.finish()
}

/// Finds the best point of the first letter's edge to go round from.
fn relax_loop(mesh: &SurfaceMesh, mut word: Vec<HalfedgeId>, report: &mut Report, pauses: &mut Pauses) -> Result<Loop> {
    let collapsed = Err(Error::Collapsed { iterations: report.iterations });
    reduce_seam(mesh, &mut word);
    let Some(&first) = word.first() else { return collapsed };
    if mesh.ends(first).into_iter().any(|v| word.iter().all(|&h| mesh.touches(h, v))) {
        return collapsed;
    }
    let rest = &word[1..];
    let [low, high] = mesh.sorted_ends(first);
    let (low_at, high_at) = (mesh.position(low), mesh.position(high));
    let mut unfolding = Unfolding::default();
    pauses.ticks(rest.len())?;
    unfolding.unfold(mesh, low_at, rest, low_at);
    pauses.ticks(rest.len())?;
    let [start_low, end_low] = [unfolding.start, unfolding.end];
    let (start_high, end_high) = {
        let [a, b] = unfolding.portals[0].map(|e| unfolding.ends[e as usize]);
        let below = ahead_of(mesh.position(a.vertex), mesh.position(b.vertex), a.at, b.at, high_at);
        let [a, b] = unfolding.portals[unfolding.portals.len() - 1].map(|e| unfolding.ends[e as usize]);
        let end = ahead_of(mesh.position(a.vertex), mesh.position(b.vertex), a.at, b.at, high_at);
        (DVec2::new(below.x, -below.y), end)
    };
    let (start_edge, end_edge) = (start_high - start_low, end_high - end_low);
    let mut funnel = Funnel::default();
    let mut go_round = |unfolding: &mut Unfolding, s: f64| {
        unfolding.start = start_low + s * start_edge;
        unfolding.end = end_low + s * end_edge;
        report.funnels += 1;
        funnel.run(unfolding);
        let at = |e: &u32| unfolding.ends[*e as usize].at;
        let first = funnel.corners.first().map_or(unfolding.end, at);
        let last = funnel.corners.last().map_or(unfolding.start, at);
        let (out, back) = (first - unfolding.start, unfolding.end - last);
        let slope = back.normalize_or_zero().dot(end_edge) - out.normalize_or_zero().dot(start_edge);
        (funnel.corners.clone(), slope)
    };
    // If nothing is in the way, the squared distance is a parabola in s.
    let (gap, growth) = (end_low - start_low, end_edge - start_edge);
    let parabola = if growth.length_squared() > 0.0 { -gap.dot(growth) / growth.length_squared() } else { 0.5 };
    let mut s = parabola.clamp(MARGIN, 1.0 - MARGIN);
    let (mut corners, mut slope) = go_round(&mut unfolding, s);
    let is_best = corners.is_empty() || (s == MARGIN && slope >= 0.0) || (s == 1.0 - MARGIN && slope <= 0.0);
    if !is_best {
        let (mut below, mut above) = (MARGIN, 1.0 - MARGIN);
        for _ in 0..HALVINGS {
            if slope > 0.0 {
                above = s
            } else {
                below = s
            }
            s = 0.5 * (below + above);
            pauses.pause()?;
            (corners, slope) = go_round(&mut unfolding, s);
        }
    }
    pauses.ticks(rest.len())?;
    let longest = word.iter().map(|&h| edge_length(mesh, h)).fold(0.0, f64::max);
    if corners.is_empty() {
        if unfolding.start.distance(unfolding.end) <= COLLAPSED_LENGTH * longest {
            return collapsed;
        }
        let is_low = s <= 2.0 * MARGIN;
        if is_low || s >= 1.0 - 2.0 * MARGIN {
            let vertex = if is_low { low } else { high };
            return Ok(Loop::Anchored(Anchored { word, vertex, run_length: 1 }));
        }
        let mut leg = Leg { first: first.triangle(), word: word.clone(), parameters: vec![s] };
        cross_straight(mesh, &unfolding, rest, &mut leg.parameters);
        return Ok(Loop::Straight(leg));
    }
    let end = unfolding.ends[corners[0] as usize];
    let run_length = (end.last - end.first + 1) as usize;
    word.rotate_left(end.first as usize + 1);
    Ok(Loop::Anchored(Anchored { word, vertex: end.vertex, run_length }))
}

/// The open line from the anchor round to itself, and then whether the anchor stays. `is_last`: it stays in any case, as it has
/// been here before.
fn relax_anchored(
    mesh: &SurfaceMesh,
    anchored: Anchored,
    is_last: bool,
    work: &mut Workspace,
    report: &mut Report,
    pauses: &mut Pauses,
    on_round: &mut impl FnMut(&Leg, &mut Report) -> bool,
) -> Result<Next> {
    let Anchored { word, vertex, run_length } = anchored;
    pauses.pause()?;
    let collapsed = Err(Error::Collapsed { iterations: report.iterations });
    let (run, rest) = word.split_at(run_length);
    let Some(&first) = rest.first() else { return collapsed };
    let pin = point_at_vertex(mesh, first, vertex);
    let open = Leg { first: first.triangle(), word: rest.to_vec(), parameters: Vec::new() };
    let mut solver = GeodesicLeg::new(mesh, &open, &pin, &pin, work, report, pauses)?;
    pauses.pause()?;
    let whole = |solver: &GeodesicLeg, work: &mut Workspace| {
        let leg = solver.to_leg(mesh, work);
        let mut turn = Vec::new();
        for &letter in solver.dropped_at_end.iter().chain(run).chain(&solver.dropped_at_start) {
            push_reduced(mesh, &mut turn, letter);
        }
        (leg, unwind(mesh, &turn).unwrap_or(turn))
    };
    let (mut may_go_on, mut is_held) = (true, true);
    while solver.is_active() && may_go_on && is_held {
        pauses.pause()?;
        solver.advance(mesh, work, report, pauses)?;
        pauses.pause()?;
        let (leg, turn) = whole(&solver, work);
        // Without a turn the line goes by the anchor: from here on it would only be held back there.
        is_held = !turn.is_empty();
        may_go_on = on_round(&with_turn(mesh, &leg, &turn, vertex), report);
    }
    let (leg, turn) = whole(&solver, work);
    if leg.word.is_empty() {
        return collapsed;
    }
    let done = |is_capped: bool| {
        let closed = with_turn(mesh, &leg, &turn, vertex);
        let iterations = report.iterations;
        if closed.word.is_empty() { Err(Error::Collapsed { iterations }) } else { Ok(Next::Done(closed, is_capped)) }
    };
    if !may_go_on || solver.is_capped || is_last {
        return done(solver.is_capped || is_last);
    }
    let new_turn = match (turn.first(), turn.last()) {
        (Some(&first), Some(&last)) => {
            let run = measure_turn(mesh, &leg, vertex, first, last);
            let sides = measure_sides(mesh, &run);
            let limit = PI - ANGLE_SLACK;
            if sides.own >= limit && sides.other >= limit {
                return done(sides.own.is_infinite());
            }
            if sides.own <= sides.other {
                turn
            } else {
                report.vertex_passes += 1;
                other_side_word(mesh, &run)
            }
        }
        _ => turn,
    };
    let corners = solver.corner_runs();
    let mut word = leg.word;
    for letter in new_turn {
        push_reduced(mesh, &mut word, letter);
    }
    reduce_seam(mesh, &mut word);
    // Hold on to a corner far from the old anchor; without one the loop is free again.
    let middle = corners.len() / 2;
    let far_first = corners[middle..].iter().chain(&corners[..middle]);
    for (vertex, letters) in far_first {
        let found = word.windows(letters.len()).position(|window| window == letters.as_slice());
        if let Some(start) = found.filter(|_| word.len() > letters.len()) {
            word.rotate_left(start);
            return Ok(Next::Again(Loop::Anchored(Anchored { word, vertex: *vertex, run_length: letters.len() })));
        }
    }
    Ok(Next::Again(relax_loop(mesh, word, report, pauses)?))
}

/// The closed leg: the open line and the letters that turn round the anchor. Where the line goes by the anchor, it may go to
/// it and back: that cancels.
fn with_turn(mesh: &SurfaceMesh, leg: &Leg, turn: &[HalfedgeId], vertex: VertexId) -> Leg {
    let mut closed = leg.clone();
    for &letter in turn {
        closed.push(mesh, letter, parameter_at(mesh, letter, vertex));
    }
    closed.reduce_seam(mesh);
    closed
}

fn measure_turn(mesh: &SurfaceMesh, leg: &Leg, vertex: VertexId, first: HalfedgeId, last: HalfedgeId) -> Run {
    let centre = mesh.position(vertex);
    let far = |spoke: HalfedgeId| mesh.position(mesh.other_end(spoke, vertex)) - centre;
    let at = |i: usize| crossing_position(mesh, leg.word[i], leg.parameters[i]) - centre;
    Run {
        vertex,
        first,
        last,
        angle_in: angle_between(far(first), at(leg.word.len() - 1)),
        angle_out: angle_between(far(last), at(0)),
    }
}

fn point_at_vertex(mesh: &SurfaceMesh, letter: HalfedgeId, vertex: VertexId) -> SurfacePoint {
    let triangle = letter.triangle();
    let barycentric = mesh.corners(triangle).map(|c| if c == vertex { 1.0 } else { 0.0 });
    SurfacePoint { triangle, barycentric }
}

fn edge_length(mesh: &SurfaceMesh, letter: HalfedgeId) -> f64 {
    let [a, b] = mesh.ends(letter);
    mesh.position(a).distance(mesh.position(b))
}
