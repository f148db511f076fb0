//! The `geodesic` filter on one leg: a locally shortest line between two fixed points, exactly.
//!
//! Step C is the funnel, step D the two-angle rule, and both stay local: after a vertex was passed, only the stretch
//! between the neighbouring corners is straightened again. Every change shortens the line, so it ends. Closed lines
//! without pins are in `closed_geodesic`.
//!
//! Source: the loop is the paper's (steps C and D); the exact parts are Lee & Preparata 1984 (funnel) and Xin & Wang
//! 2007 (which side of a vertex).

use std::collections::HashMap;
use std::f64::consts::PI;
use std::ops::Range;

use glam::{DVec2, DVec3};

use crate::chain::{Chain, END, START};
use crate::error::Result;
use crate::filter::workspace::Workspace;
use crate::ids::{HalfedgeId, VertexId};
use crate::leg::Leg;
use crate::mesh::SurfaceMesh;
use crate::pauses::Pauses;
use crate::relax::funnel::cross_portal;
use crate::report::Report;
use crate::spot::{Spot, parameter_at, spot_of};
use crate::surface_point::SurfacePoint;
use crate::unfold::Unfolding;
use crate::vertex_pass::{ANGLE_SLACK, angle_between, measure_sides, other_side_word};

/// Changes at one mesh vertex after which it is left as it is. In exact arithmetic a handful is enough, as every change
/// shortens the line; more are rounding at needles, and would go on for ever.
const MAX_CHANGES_AT_VERTEX: u32 = 60;

/// Letters of a stretch that take milliseconds to unfold.
const LONG_STRETCH: usize = 10_000;

/// One fixed end of a leg.
#[derive(Clone, Copy, Debug)]
struct Anchor {
    position: DVec3,
    spot: Spot,
}

/// A leg while it is being straightened.
#[derive(Debug)]
pub struct GeodesicLeg {
    chain: Chain,
    start: Anchor,
    end: Anchor,
    /// Corners that may have to be passed or released.
    active: Vec<u32>,
    changes: HashMap<VertexId, u32>,
    /// Letters dropped at the start, in the order of the word; they turn round the start point.
    pub dropped_at_start: Vec<HalfedgeId>,
    /// Letters dropped at the end, in the order of the word.
    pub dropped_at_end: Vec<HalfedgeId>,
    /// Whether a vertex was left because it had changed too often.
    pub is_capped: bool,
}

impl GeodesicLeg {
    /// Straightens the leg's strip once (step C of the first round).
    ///
    /// # Errors
    /// [`crate::Error::Interrupted`] at one of the `pauses`.
    pub fn new(
        mesh: &SurfaceMesh,
        leg: &Leg,
        start: &SurfacePoint,
        end: &SurfacePoint,
        work: &mut Workspace,
        report: &mut Report,
        pauses: &mut Pauses,
    ) -> Result<Self> {
        let anchor = |p: &SurfacePoint| Anchor { position: mesh.position_of(p), spot: spot_of(mesh, p) };
        let is_long = leg.word.len() > LONG_STRETCH;
        let mut pause = || if is_long { pauses.pause() } else { Ok(()) };
        pause()?;
        let chain = Chain::new(leg.first, &leg.word);
        pause()?;
        let mut this = Self {
            chain,
            start: anchor(start),
            end: anchor(end),
            active: Vec::new(),
            changes: HashMap::new(),
            dropped_at_start: Vec::new(),
            dropped_at_end: Vec::new(),
            is_capped: false,
        };
        this.straighten(mesh, START, END, work, report, pauses)?;
        Ok(this)
    }

    /// Whether anything is left to look at.
    pub fn is_active(&self) -> bool {
        !self.active.is_empty()
    }

    /// One round: step D at every corner that may need it, and then step C on the stretches that changed.
    ///
    /// # Errors
    /// [`crate::Error::Interrupted`] at one of the `pauses`.
    pub fn advance(
        &mut self,
        mesh: &SurfaceMesh,
        work: &mut Workspace,
        report: &mut Report,
        pauses: &mut Pauses,
    ) -> Result<()> {
        let mut round = std::mem::take(&mut self.active);
        round.sort_unstable();
        round.dedup();
        self.active.reserve(round.len());
        let mut changed = Vec::with_capacity(round.len());
        for corner in round {
            pauses.tick()?;
            // A corner whose run a neighbour's pass has cut is measured anew first, and looked at in the next round.
            let is_measured =
                corner != START && corner != END && self.chain.is_alive(corner) && !self.chain.is_cut(corner);
            if is_measured {
                changed.extend(self.change_at(mesh, corner, report));
            }
        }
        changed.sort_unstable();
        changed.dedup();
        for from in changed {
            pauses.tick()?;
            // Where a later change removed `from`, it noted the corner before it.
            if self.chain.is_alive(from) {
                self.straighten(mesh, from, self.chain.next_corner(from), work, report, pauses)?;
            }
        }
        Ok(())
    }

    /// Step D at one corner, if the line is better off without it there. Returns the corner before the change.
    ///
    /// Neighbouring corners may change in one round: the old line lies in the new strip as well, so no change can make
    /// another one wrong.
    fn change_at(&mut self, mesh: &SurfaceMesh, corner: u32, report: &mut Report) -> Option<u32> {
        if let Some(rest) = self.unwound(mesh, corner) {
            // The strip goes round the vertex once or more: that is a loop, whatever the angles.
            report.loops_removed += 1;
            return Some(self.chain.replace_run(mesh, corner, &rest).0);
        }
        let run = self.chain.run(corner);
        let sides = measure_sides(mesh, &run);
        let limit = PI - ANGLE_SLACK;
        if sides.own.is_infinite() {
            // No angle tells: as where vertices are changed without end.
            self.is_capped = true;
            return None;
        }
        if sides.own >= limit && sides.other >= limit {
            return None;
        }
        let changes = self.changes.entry(run.vertex).or_insert(0);
        *changes += 1;
        if *changes > MAX_CHANGES_AT_VERTEX {
            self.is_capped = true;
            return None;
        }
        if sides.own <= sides.other {
            let previous = self.chain.previous_corner(corner);
            self.chain.remove_corner(corner);
            return Some(previous);
        }
        report.vertex_passes += 1;
        Some(self.chain.replace_run(mesh, corner, &other_side_word(mesh, &run)).0)
    }

    /// The run without its full turns, or `None` when it has none.
    fn unwound(&self, mesh: &SurfaceMesh, corner: u32) -> Option<Vec<HalfedgeId>> {
        // Nearly none has any.
        if self.chain.is_winding(mesh, corner) { unwind(mesh, &self.chain.run_letters(corner)) } else { None }
    }

    /// Step C on the stretch between two neighbouring corners or ends.
    fn straighten(
        &mut self,
        mesh: &SurfaceMesh,
        from: u32,
        to: u32,
        work: &mut Workspace,
        report: &mut Report,
        pauses: &mut Pauses,
    ) -> Result<()> {
        work.unfolded = None;
        self.chain.stretch(from, to, &mut work.links, &mut work.letters);
        let is_long = work.letters.len() > LONG_STRETCH;
        let mut pause = || if is_long { pauses.pause() } else { Ok(()) };
        pause()?;
        let kept = self.trim(mesh, from, to, &work.letters);
        work.links.truncate(kept.end);
        work.links.drain(..kept.start);
        work.letters.truncate(kept.end);
        work.letters.drain(..kept.start);
        let (a, b) = (self.anchor_position(mesh, from, true), self.anchor_position(mesh, to, false));
        self.active.extend([from, to]);
        if work.letters.is_empty() {
            self.measure_direct(mesh, from, to, a, b);
            return Ok(());
        }
        report.funnels += 1;
        pause()?;
        work.unfolding.unfold_while(mesh, a, &work.letters, b, &mut pause)?;
        work.unfolded = Some([a, b]);
        pause()?;
        work.funnel.run(&work.unfolding);
        pause()?;
        self.place_corners(mesh, from, to, work, pauses)
    }

    /// Letters next to an end of a stretch that touch it are crossed there: a corner takes them into its run, a pin
    /// drops them (the line may leave a pin by any triangle that holds it).
    ///
    /// Returns which of the stretch's letters are left.
    fn trim(&mut self, mesh: &SurfaceMesh, from: u32, to: u32, letters: &[HalfedgeId]) -> Range<usize> {
        let mut rest = letters;
        while let Some((&letter, tail)) = rest.split_first() {
            if from == START && self.start.spot.is_on(mesh, letter) {
                self.dropped_at_start.push(self.chain.drop_first(mesh));
            } else if from != START && mesh.touches(letter, self.chain.vertex(from)) {
                self.chain.absorb_next(from);
            } else {
                break;
            }
            rest = tail;
        }
        let start = letters.len() - rest.len();
        while let Some((&letter, head)) = rest.split_last() {
            if to == END && self.end.spot.is_on(mesh, letter) {
                self.dropped_at_end.insert(0, self.chain.drop_last());
            } else if to != END && mesh.touches(letter, self.chain.vertex(to)) {
                self.chain.absorb_previous(to);
            } else {
                break;
            }
            rest = head;
        }
        start..start + rest.len()
    }

    fn anchor_position(&self, mesh: &SurfaceMesh, corner: u32, is_start: bool) -> DVec3 {
        match corner {
            START | END => {
                if is_start {
                    self.start.position
                } else {
                    self.end.position
                }
            }
            _ => mesh.position(self.chain.vertex(corner)),
        }
    }

    /// Angles at the ends of a stretch without letters: both ends lie in one triangle.
    fn measure_direct(&mut self, mesh: &SurfaceMesh, from: u32, to: u32, a: DVec3, b: DVec3) {
        if from != START {
            let run = self.chain.run(from);
            let angle = angle_between(far_end(mesh, run.last, run.vertex) - a, b - a);
            self.chain.set_angle_out(from, angle);
        }
        if to != END {
            let run = self.chain.run(to);
            let angle = angle_between(far_end(mesh, run.first, run.vertex) - b, a - b);
            self.chain.set_angle_in(to, angle);
        }
    }

    /// Makes corners of what the funnel found, and measures the angles at all corners of the stretch.
    fn place_corners(
        &mut self,
        mesh: &SurfaceMesh,
        from: u32,
        to: u32,
        work: &Workspace,
        pauses: &mut Pauses,
    ) -> Result<()> {
        let unfolding = &work.unfolding;
        let at = |end: u32| unfolding.ends[end as usize].at;
        // Runs first, as a letter that two corners share goes to the earlier one.
        let mut runs: Vec<(u32, u32, u32)> = Vec::with_capacity(work.funnel.corners.len());
        let mut free = 0;
        for &end in &work.funnel.corners {
            pauses.tick()?;
            let portal_end = unfolding.ends[end as usize];
            let (first, last) = (portal_end.first.max(free), portal_end.last);
            if first <= last {
                runs.push((end, first, last));
                free = last + 1;
            }
        }
        let goes_to = |i: usize| runs.get(i).map_or(unfolding.end, |&(next, ..)| at(next));
        if from != START {
            let far = mesh.other_end(self.chain.run(from).last, self.chain.vertex(from));
            self.chain.set_angle_out(from, planar_angle(unfolding.start, portal_place(unfolding, 0, far), goes_to(0)));
        }
        let mut corner = from;
        let mut came_from = unfolding.start;
        for (i, &(end, first, last)) in runs.iter().enumerate() {
            pauses.tick()?;
            let vertex = unfolding.ends[end as usize].vertex;
            let id = self.chain.insert_corner(corner, vertex, work.links[first as usize], work.links[last as usize]);
            self.chain.set_angle_in(id, planar_angle(at(end), at(unfolding.other_end(first, end)), came_from));
            self.chain.set_angle_out(id, planar_angle(at(end), at(unfolding.other_end(last, end)), goes_to(i + 1)));
            self.active.push(id);
            came_from = at(end);
            corner = id;
        }
        if to != END {
            let far = mesh.other_end(self.chain.run(to).first, self.chain.vertex(to));
            let last = unfolding.portals.len() - 1;
            self.chain.set_angle_in(to, planar_angle(unfolding.end, portal_place(unfolding, last, far), came_from));
        }
        Ok(())
    }

    /// The straightened leg with its parameters, and the vertices that it runs through.
    pub fn to_leg(&self, mesh: &SurfaceMesh, work: &mut Workspace) -> Leg {
        let (first, letters) = (self.chain.first_triangle(), self.chain.link_count());
        let mut leg = Leg { first, word: Vec::with_capacity(letters), parameters: Vec::with_capacity(letters) };
        let mut from = START;
        loop {
            let to = self.chain.next_corner(from);
            self.chain.stretch(from, to, &mut work.links, &mut work.others);
            let (a, b) = (self.anchor_position(mesh, from, true), self.anchor_position(mesh, to, false));
            work.unfold_others(mesh, a, b);
            cross_straight(mesh, &work.unfolding, &work.letters, &mut leg.parameters);
            leg.word.extend_from_slice(&work.letters);
            if to == END {
                return leg;
            }
            for letter in self.chain.run_letters(to) {
                leg.word.push(letter);
                leg.parameters.push(parameter_at(mesh, letter, self.chain.vertex(to)));
            }
            from = to;
        }
    }

    /// Vertices that the line runs through between its ends, each with the letters of its run.
    pub fn corner_runs(&self) -> Vec<(VertexId, Vec<HalfedgeId>)> {
        let mut runs = Vec::new();
        let mut corner = self.chain.next_corner(START);
        while corner != END {
            runs.push((self.chain.vertex(corner), self.chain.run_letters(corner)));
            corner = self.chain.next_corner(corner);
        }
        runs
    }
}

/// Appends the parameters at which the straight line from start to end crosses the portals of an unfolding.
pub fn cross_straight(mesh: &SurfaceMesh, unfolding: &Unfolding, letters: &[HalfedgeId], parameters: &mut Vec<f64>) {
    for (&letter, &[left, right]) in letters.iter().zip(&unfolding.portals) {
        let (left, right) = (&unfolding.ends[left as usize], &unfolding.ends[right as usize]);
        let t = cross_portal(unfolding.start, unfolding.end, left.at, right.at);
        parameters.push(if mesh.sorted_ends(letter)[0] == left.vertex { t } else { 1.0 - t });
    }
}

/// A run of letters round one vertex without its full turns; `None` when it has none.
pub fn unwind(mesh: &SurfaceMesh, letters: &[HalfedgeId]) -> Option<Vec<HalfedgeId>> {
    let before = letters.first()?.triangle();
    let last_return = letters.iter().rposition(|&h| crate::strip::entered_triangle(mesh, h) == before)?;
    Some(letters[last_return + 1..].to_vec())
}

fn planar_angle(apex: DVec2, u: DVec2, v: DVec2) -> f64 {
    let (u, v) = (u - apex, v - apex);
    u.perp_dot(v).abs().atan2(u.dot(v))
}

/// Where `vertex`, an end of letter `letter`'s portal, lies in the plane.
fn portal_place(unfolding: &Unfolding, letter: usize, vertex: VertexId) -> DVec2 {
    let [left, right] = unfolding.portals[letter];
    let (left, right) = (&unfolding.ends[left as usize], &unfolding.ends[right as usize]);
    if left.vertex == vertex { left.at } else { right.at }
}

/// Where the far end of a spoke of `vertex` is.
fn far_end(mesh: &SurfaceMesh, spoke: HalfedgeId, vertex: VertexId) -> DVec3 {
    mesh.position(mesh.other_end(spoke, vertex))
}
