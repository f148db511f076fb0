//! A leg: the stretch of a line between two pins, as a word with a parameter a letter, and what can be done to both.
//!
//! Holds no pins: a leg knows no ends but its strip's.

use glam::DVec3;

use crate::ids::{HalfedgeId, TriangleId};
use crate::mesh::SurfaceMesh;
use crate::spot::{Spot, crossing_position, crossing_spot, parameter_at};
use crate::strip::{entered_triangle, push_reduced};
use crate::surface_point::SurfacePoint;

/// The stretch of a line between two pins, or a whole closed line without pins.
///
/// Crossing `i` lies on the edge of `word[i]` at `(1 - t) low + t high`, where `t = parameters[i]` in 0..=1 and `low` is
/// the end with the lower vertex id. At 0 or 1 the line runs through a mesh vertex.
#[derive(Clone, PartialEq, Debug)]
pub struct Leg {
    /// The triangle that the leg starts in.
    pub first: TriangleId,
    /// Reduced word of crossed half-edges, each seen from the triangle that is left.
    pub word: Vec<HalfedgeId>,
    /// One a letter.
    pub parameters: Vec<f64>,
}

impl Leg {
    /// A leg through the midpoints of its edges: the first polyline of step B.
    pub fn through_midpoints(first: TriangleId, word: Vec<HalfedgeId>) -> Self {
        let parameters = vec![0.5; word.len()];
        Self { first, word, parameters }
    }

    /// A leg that crosses nothing.
    pub fn empty(first: TriangleId) -> Self {
        Self { first, word: Vec::new(), parameters: Vec::new() }
    }

    /// The leg, leaving one that crosses nothing.
    pub fn take(&mut self) -> Self {
        let first = self.first;
        std::mem::replace(self, Self::empty(first))
    }

    /// The triangle that the leg ends in.
    pub fn last_triangle(&self, mesh: &SurfaceMesh) -> TriangleId {
        self.word.last().map_or(self.first, |&h| entered_triangle(mesh, h))
    }

    /// Length of the leg from point `from` to point `to`, in the units of the positions.
    pub fn length(&self, mesh: &SurfaceMesh, from: &SurfacePoint, to: &SurfacePoint) -> f64 {
        let crossings = self.word.iter().zip(&self.parameters).map(|(&h, &t)| crossing_position(mesh, h, t));
        let mut last = mesh.position_of(from);
        crossings.chain([mesh.position_of(to)]).map(|p| std::mem::replace(&mut last, p).distance(p)).sum()
    }

    /// Appends a letter with its parameter, or takes the last one back when the new one crosses the same edge again.
    pub fn push(&mut self, mesh: &SurfaceMesh, letter: HalfedgeId, parameter: f64) {
        if self.word.last().is_some_and(|&last| mesh.twin(last) == Some(letter)) {
            self.word.pop();
            self.parameters.pop();
        } else {
            self.word.push(letter);
            self.parameters.push(parameter);
        }
    }

    /// Takes out a full turn round a mesh vertex that the last letter has closed: the strip is back where the line, which
    /// stays at the vertex meanwhile, was before.
    fn cut_full_turn(&mut self, mesh: &SurfaceMesh) {
        let spot_at = |i: usize| crossing_spot(mesh, self.word[i], self.parameters[i]);
        let Some(last) = self.word.len().checked_sub(1) else { return };
        let vertex = spot_at(last);
        if !matches!(vertex, Spot::Vertex(_)) {
            return;
        }
        let here = self.last_triangle(mesh);
        let run = (0..=last).rev().take_while(|&i| spot_at(i) == vertex);
        if let Some(start) = run.filter(|&i| self.word[i].triangle() == here).last() {
            self.word.truncate(start);
            self.parameters.truncate(start);
        }
    }

    /// This leg without the full turns that it makes round mesh vertices while the line stays there; `None` without any.
    pub fn without_full_turns(&self, mesh: &SurfaceMesh) -> Option<Self> {
        let is_end = |&t: &f64| t == 0.0 || t == 1.0;
        if !self.parameters.windows(2).any(|pair| pair.iter().all(is_end)) {
            return None;
        }
        let mut cut = Self::empty(self.first);
        for (&h, &t) in self.word.iter().zip(&self.parameters) {
            cut.push(mesh, h, t);
            cut.cut_full_turn(mesh);
        }
        (cut.word.len() < self.word.len()).then_some(cut)
    }

    /// The strip between the ends of this leg after they were moved by the ways `at_start` and `at_end` (words of what
    /// each crossed), `first` being where the first way led. Without parameters.
    pub fn between_moved(
        &self,
        mesh: &SurfaceMesh,
        first: TriangleId,
        at_start: &[HalfedgeId],
        at_end: &[HalfedgeId],
    ) -> Self {
        let mut word = Vec::with_capacity(at_start.len() + self.word.len() + at_end.len());
        let back = at_start.iter().rev().filter_map(|&h| mesh.twin(h));
        for letter in back.chain(self.word.iter().copied()).chain(at_end.iter().copied()) {
            push_reduced(mesh, &mut word, letter);
        }
        // A pin on an edge or vertex is left by any triangle that holds it: the one that the word begins in.
        let first = if at_start.is_empty() { self.first } else { first };
        Self { first, word, parameters: Vec::new() }
    }

    /// Cancels backtracks across the seam of a ring, whose inside must be reduced.
    pub fn reduce_seam(&mut self, mesh: &SurfaceMesh) {
        let count = self.word.len();
        let is_backtrack = |k: usize| 2 * k + 1 < count && mesh.twin(self.word[count - 1 - k]) == Some(self.word[k]);
        let cut = (0..).take_while(|&k| is_backtrack(k)).count();
        self.word.truncate(count - cut);
        self.word.drain(..cut);
        self.parameters.truncate(count - cut);
        self.parameters.drain(..cut);
        if let Some(&letter) = self.word.first() {
            self.first = letter.triangle();
        }
    }

    /// Takes out letters `start..end` (across the seam of a ring when `start >= end`), after which the strip is in the
    /// triangle where it was before them, and cancels the backtracks that this makes.
    pub fn cut(&mut self, mesh: &SurfaceMesh, start: usize, end: usize, is_ring: bool) {
        let old = self.take();
        let kept = if start < end { (0..start, end..old.word.len()) } else { (0..0, end..start) };
        for i in kept.0.chain(kept.1) {
            self.push(mesh, old.word[i], old.parameters[i]);
        }
        if is_ring {
            self.reduce_seam(mesh);
        }
        if let Some(&letter) = self.word.first() {
            self.first = letter.triangle();
        }
    }

    /// Moves crossing `i` next to a pin that lies within rounding of the crossed edge, where both have the same point; tells
    /// whether it did.
    pub fn part_from(&mut self, mesh: &SurfaceMesh, pin: Option<DVec3>, i: usize) -> bool {
        let (Some(&letter), Some(t)) = (self.word.get(i), self.parameters.get_mut(i)) else { return false };
        let is_equal = pin == Some(crossing_position(mesh, letter, *t));
        if is_equal {
            *t = nudged(mesh, letter, *t);
        }
        is_equal
    }

    /// See [`crate::route::Route::snap_to_vertices`]; `is_ring`: the leg is a closed line without pins. Tells whether
    /// crossings were parted.
    pub fn snap_to_vertices(&mut self, mesh: &SurfaceMesh, is_ring: bool) -> bool {
        for (&h, t) in self.word.iter().zip(&mut self.parameters) {
            let point = crossing_position(mesh, h, *t);
            let [low, high] = mesh.sorted_ends(h);
            if point == mesh.position(low) {
                *t = 0.0;
            } else if point == mesh.position(high) {
                *t = 1.0;
            }
        }
        self.part_equal_points(mesh, is_ring)
    }

    /// Parts neighbouring crossings that have the same point, or puts both on the vertex that their edges share; tells
    /// whether there were any.
    pub fn part_equal_points(&mut self, mesh: &SurfaceMesh, is_ring: bool) -> bool {
        let count = self.word.len();
        let Some(&first) = self.word.first() else { return false };
        let mut is_changed = false;
        let mut before = crossing_position(mesh, first, self.parameters[0]);
        for i in (1..count).chain(is_ring.then_some(0)) {
            let j = (i + count - 1) % count;
            let (h, k) = (self.word[j], self.word[i]);
            let (s, t) = (self.parameters[j], self.parameters[i]);
            let here = crossing_position(mesh, k, t);
            let is_equal = i != j && here == std::mem::replace(&mut before, here);
            if is_equal && crossing_spot(mesh, h, s) != crossing_spot(mesh, k, t) {
                // Neighbouring letters share one end; two equal points on them are within rounding of it, or of vertices
                // that are within rounding of each other.
                let shared = mesh.ends(h).into_iter().find(|&v| mesh.touches(k, v));
                let near = 1e-12 * edge_size(mesh, h);
                if let Some(v) = shared.filter(|&v| mesh.position(v).distance(crossing_position(mesh, h, s)) < near) {
                    self.parameters[j] = parameter_at(mesh, h, v);
                    self.parameters[i] = parameter_at(mesh, k, v);
                } else {
                    self.parameters[i] = nudged(mesh, k, t);
                }
                before = crossing_position(mesh, k, self.parameters[i]);
                is_changed = true;
            }
        }
        is_changed
    }
}

/// A parameter next to `t` whose point differs: edges of a triangle without area can have points in common, and a line
/// has no two equal points in a row.
fn nudged(mesh: &SurfaceMesh, letter: HalfedgeId, t: f64) -> f64 {
    let point = crossing_position(mesh, letter, t);
    // Where the sense changes, two nudges would lead back; so not in the middle, where many crossings lie.
    let towards = if t < 0.7 { 1.0 } else { -1.0 };
    (0..40)
        .map(|power| t + towards * f64::EPSILON * f64::from(2).powi(power))
        .find(|&next| (0.0..=1.0).contains(&next) && crossing_position(mesh, letter, next) != point)
        .unwrap_or(t)
}

/// Length of an edge, and of what rounding of its coordinates is relative to.
fn edge_size(mesh: &SurfaceMesh, letter: HalfedgeId) -> f64 {
    let [a, b] = mesh.ends(letter).map(|v| mesh.position(v));
    a.distance(b) + a.abs().max_element()
}
