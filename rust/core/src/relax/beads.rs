//! The vertices of a line as step C sees them: points that slide on their mesh edges, and fixed points between them.
//!
//! Holds what the ways to move them share: edges, parameters, positions, and who is whose neighbour.

use std::ops::Range;

use glam::DVec3;

use crate::filter::{Edge, Side};
use crate::mesh::SurfaceMesh;
use crate::route::Route;

/// The neighbours of a vertex, nearest first; kept for its memory.
#[derive(Clone, Debug, Default)]
pub struct Neighbours {
    /// Towards the start of the line.
    pub before: Side,
    /// Towards its end.
    pub after: Side,
}

/// A line's vertices in order.
#[derive(Clone, Debug, Default)]
pub struct Beads {
    /// The edge of each vertex; both ends equal for a fixed one.
    pub edges: Vec<Edge>,
    /// Parameters on the edges.
    pub parameters: Vec<f64>,
    /// Where each vertex is: `edges[i].at(parameters[i])`.
    pub positions: Vec<DVec3>,
    /// Whether a vertex stays where it is.
    pub is_fixed: Vec<bool>,
    /// Whether the last vertex is a neighbour of the first.
    pub closed: bool,
}

impl Beads {
    /// All crossings and pins of a route.
    pub fn of_route(mesh: &SurfaceMesh, route: &Route) -> Self {
        let count = route.pins.len() + route.legs.iter().map(|leg| leg.word.len()).sum::<usize>();
        let mut beads = Self {
            edges: Vec::with_capacity(count),
            parameters: Vec::with_capacity(count),
            positions: Vec::with_capacity(count),
            is_fixed: Vec::with_capacity(count),
            closed: route.closed,
        };
        for k in 0..route.pins.len().max(route.legs.len()) {
            if let Some(pin) = route.pins.get(k) {
                beads.push_fixed(mesh.position_of(pin));
            }
            let Some(leg) = route.legs.get(k) else { continue };
            for (&letter, &t) in leg.word.iter().zip(&leg.parameters) {
                let [low, high] = mesh.sorted_ends(letter).map(|v| mesh.position(v));
                beads.push(Edge { low, high }, t);
            }
        }
        beads
    }

    /// The beads of the legs with their flag in `is_open` of the route that the beads were made from, and `margin` more on
    /// each side, and as many at both ends of an open line; `None` if these are all.
    pub fn near_open(&self, route: &Route, is_open: &[bool], margin: usize) -> Option<Vec<Range<usize>>> {
        if is_open.iter().all(|&open| open) {
            return None;
        }
        let mut is_near = vec![false; self.len()];
        let mut next = 0;
        for (k, &open) in is_open.iter().enumerate() {
            // As there are legs that are not open, there are pins.
            let end = next + 1 + route.legs[k].word.len();
            if open {
                is_near[next..end].fill(true);
                let (mut low, mut high) = (next, end - 1);
                for _ in 0..margin {
                    low = self.step(low, false).unwrap_or(low);
                    high = self.step(high, true).unwrap_or(high);
                    (is_near[low], is_near[high]) = (true, true);
                }
            }
            next = end;
        }
        if !self.closed {
            // What is an end now may have been a pin with neighbours beyond it.
            let count = margin.min(self.len());
            is_near[..count].fill(true);
            is_near[self.len() - count..].fill(true);
        }
        Some(ranges_of(&is_near))
    }

    /// The beads that are not where those of `before` are, in the same order on the same edges, and up to `margin` more on each
    /// side of them. Finds what step D has done to a line, which is little as a rule; where there is too much to be followed, all the rest.
    pub fn changed_since(&self, before: &Self, margin: usize) -> Vec<Range<usize>> {
        let is_same = |i: usize, j: usize| {
            i < self.len()
                && j < before.len()
                && self.parameters[i] == before.parameters[j]
                && self.edges[i] == before.edges[j]
                && self.is_fixed[i] == before.is_fixed[j]
        };
        let mut is_near = vec![false; self.len()];
        let mut mark = |from: usize, to: usize| {
            is_near[from..to].fill(true);
            for (start, forward) in [(to.min(self.len() - 1), true), (from.max(1) - 1, false)] {
                let next = |&at: &usize| self.step(at, forward);
                std::iter::successors(Some(start), next).take(margin).for_each(|at| is_near[at] = true);
            }
        };
        let (mut i, mut j) = (0, 0);
        while i < self.len() || j < before.len() {
            if is_same(i, j) {
                (i, j) = (i + 1, j + 1);
                continue;
            }
            // The nearest place where both go on alike.
            let skips = (1..=MOST_SKIPPED).flat_map(|both| (0..=both).map(move |here| (here, both - here)));
            let mut places = skips.map(|(here, there)| (i + here, j + there));
            let next = places.find(|&(i, j)| is_same(i, j) && is_same(i + 1, j + 1));
            let (to, there) = next.unwrap_or((self.len(), before.len()));
            mark(i, to);
            (i, j) = (to, there);
        }
        ranges_of(&is_near)
    }

    /// The beads of a range as an open line of its own, with up to `flank` fixed ones more on each side, and the place here of
    /// each.
    pub fn chain_of(&self, range: &Range<usize>, flank: usize) -> (Self, Vec<usize>) {
        let walk = |from: usize, forward: bool| {
            let next = move |&at: &usize| self.step(at, forward).filter(|at| !range.contains(at));
            std::iter::successors(Some(from), next).skip(1).take(flank)
        };
        let mut places: Vec<usize> = walk(range.start, false).collect();
        places.reverse();
        let before = places.len();
        places.extend(range.clone());
        let inner = before..places.len();
        places.extend(walk(range.end - 1, true));
        let mut chain = Self::default();
        for (k, &i) in places.iter().enumerate() {
            if inner.contains(&k) && !self.is_fixed[i] {
                chain.push(self.edges[i], self.parameters[i]);
            } else {
                chain.push_fixed(self.positions[i]);
            }
        }
        (chain, places)
    }

    /// Writes the parameters back to the route that the beads were made from; sets the flag of each leg that has changed.
    pub fn write_to(&self, route: &mut Route, is_changed: &mut [bool]) {
        let mut next = 0;
        for k in 0..route.pins.len().max(route.legs.len()) {
            next += usize::from(k < route.pins.len());
            let Some((leg, changed)) = route.legs.get_mut(k).zip(is_changed.get_mut(k)) else { continue };
            let count = leg.parameters.len();
            let parameters = &self.parameters[next..next + count];
            *changed |= leg.parameters != parameters;
            leg.parameters.copy_from_slice(parameters);
            next += count;
        }
    }

    /// Appends a sliding vertex.
    pub fn push(&mut self, edge: Edge, t: f64) {
        self.edges.push(edge);
        self.parameters.push(t);
        self.positions.push(edge.at(t));
        self.is_fixed.push(false);
    }

    /// Appends a fixed vertex.
    pub fn push_fixed(&mut self, position: DVec3) {
        self.edges.push(Edge { low: position, high: position });
        self.parameters.push(0.0);
        self.positions.push(position);
        self.is_fixed.push(true);
    }

    /// Moves vertex `i` along its edge.
    #[inline]
    pub fn slide(&mut self, i: usize, t: f64) {
        self.parameters[i] = t;
        self.positions[i] = self.edges[i].at(t);
    }

    /// Number of vertices.
    pub fn len(&self) -> usize {
        self.positions.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.positions.is_empty()
    }

    /// The vertex after (`forward`) or before `i`; `None` at the ends of an open line.
    #[inline]
    pub fn step(&self, i: usize, forward: bool) -> Option<usize> {
        let count = self.len();
        match (forward, self.closed) {
            (true, _) if i + 1 < count => Some(i + 1),
            (true, true) => Some(0),
            (false, _) if i > 0 => Some(i - 1),
            (false, true) => Some(count - 1),
            _ => None,
        }
    }

    /// Neighbours on both sides, `reach` each; where one side has fewer, the other gives as many more.
    #[inline]
    pub fn neighbourhood(&self, i: usize, reach: usize, found: &mut Neighbours) {
        found.before.clear();
        found.after.clear();
        self.extend_side(i, false, reach, &mut found.before);
        self.extend_side(i, true, reach, &mut found.after);
        match (found.before.len() < reach, found.after.len() < reach) {
            (true, false) => self.extend_side(i, true, 2 * reach - found.before.len(), &mut found.after),
            (false, true) => self.extend_side(i, false, 2 * reach - found.after.len(), &mut found.before),
            _ => {}
        }
    }

    /// Adds neighbours on one side, nearest first, until there are `count`.
    #[inline]
    fn extend_side(&self, i: usize, forward: bool, count: usize, side: &mut Side) {
        let mut at = i;
        let mut distance = 0;
        while side.len() < count {
            let Some(next) = self.step(at, forward).filter(|&next| next != i) else { break };
            at = next;
            distance += 1;
            if distance > side.len() {
                side.push(self.positions[at]);
            }
        }
    }

    /// The four neighbours nearest to vertex `i` in the order of the line, and which of them is the one before it: two on each
    /// side, or as many more of the other side as one side has fewer. `None` at an end, and where there are not four.
    #[inline]
    pub fn four_around(&self, i: usize) -> Option<([usize; 4], usize)> {
        let count = self.len();
        if count < 5 {
            return None;
        }
        if i >= 2 && i + 2 < count {
            return Some(([i - 2, i - 1, i + 1, i + 2], 1));
        }
        if self.closed {
            return Some(([(i + count - 2) % count, (i + count - 1) % count, (i + 1) % count, (i + 2) % count], 1));
        }
        match i {
            1 => Some(([0, 2, 3, 4], 0)),
            _ if i + 2 == count => Some(([count - 5, count - 4, count - 3, count - 1], 2)),
            _ => None,
        }
    }

    /// Neighbours that vertex `i` has on one side, counted up to `most`.
    #[inline]
    pub fn count_neighbours(&self, i: usize, forward: bool, most: usize) -> usize {
        let others = self.len() - 1;
        most.min(match (self.closed, forward) {
            (true, _) => others,
            (false, true) => others - i,
            (false, false) => i,
        })
    }
}

/// Beads that one change may put in the place of others, both counted, so that what follows is found again.
const MOST_SKIPPED: usize = 64;

/// The stretches of set flags.
fn ranges_of(flags: &[bool]) -> Vec<Range<usize>> {
    let starts = (0..flags.len()).filter(|&i| flags[i] && (i == 0 || !flags[i - 1]));
    let end_of = |start: usize| (start..flags.len()).find(|&i| !flags[i]).unwrap_or(flags.len());
    starts.map(|start| start..end_of(start)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    impl Beads {
        /// Vertices on a fence of parallel edges, up and down in short waves and long ones so high, between fixed ones.
        pub fn on_a_fence(count: usize, long_wave: f64) -> Self {
            let mut beads = Self::default();
            beads.push_fixed(DVec3::ZERO);
            for i in 1..count {
                let x = i as f64;
                let edge = Edge { low: DVec3::new(x, -2.0, 0.0), high: DVec3::new(x, 2.0, 0.3 * (0.2 * x).sin()) };
                beads.push(edge, 0.5 + 0.2 * (1.7 * x).sin() + long_wave * (0.11 * x).sin());
            }
            beads.push_fixed(DVec3::new(count as f64, 0.0, 0.0));
            beads
        }
    }

    /// Beads on edges that are told by the numbers, in their middles.
    fn beads(numbers: &[i32], closed: bool) -> Beads {
        let mut beads = Beads { closed, ..Beads::default() };
        for &number in numbers {
            let low = DVec3::new(f64::from(number), 0.0, 0.0);
            beads.push(Edge { low, high: low + DVec3::Y }, 0.5);
        }
        beads
    }

    #[test]
    fn what_has_changed_is_found_with_its_neighbours() {
        let all: Vec<i32> = (0..200).collect();
        let changed = |now: &Beads| -> Vec<(usize, usize)> {
            let ranges = now.changed_since(&beads(&all, now.closed), 4);
            ranges.into_iter().map(|range| (range.start, range.end)).collect()
        };
        let ask = |now: &[i32], closed| changed(&beads(now, closed));
        assert_eq!(ask(&all, false), []);
        // Three others in the place of two.
        let now = [&all[..50], &[500, 501, 502], &all[52..]].concat();
        assert_eq!(ask(&now, false), [(46, 57)]);
        // Two lost, and two places at once.
        assert_eq!(ask(&[&all[..50], &all[52..]].concat(), false), [(46, 54)]);
        let now = [&all[..20], &[500], &all[21..100], &[501, 502], &all[100..]].concat();
        assert_eq!(ask(&now, false), [(16, 25), (96, 106)]);
        // Across the seam of a ring, and at the ends of an open line.
        assert_eq!(ask(&[&[500], &all[1..]].concat(), true), [(0, 5), (197, 200)]);
        assert_eq!(ask(&[&[500], &all[1..]].concat(), false), [(0, 5)]);
        assert_eq!(ask(&all[..150], false), [(146, 150)]);
        // One that has moved on its edge; too much to be followed.
        let mut moved = beads(&all, false);
        moved.slide(100, 0.25);
        assert_eq!(changed(&moved), [(96, 105)]);
        assert_eq!(ask(&[&all[..50], &all[150..]].concat(), false), [(46, 100)]);
    }
}
