//! The one loop of step B: A* over the nodes of the dual graph, whatever they are read from.
//!
//! Holds the search and its work space, no mesh; what searches share and when landmarks are chosen is in [`crate::search`].

use std::ops::ControlFlow;

use glam::DVec3;

use crate::dual_nodes::{NONE, Nodes};
use crate::error::Error;
use crate::ids::{HalfedgeId, TriangleId};
use crate::landmarks::{Aim, Landmarks};
use crate::queue::{Queue, ShortKeys};
use crate::report::{Observer, Step};
use crate::search::{FoundStrip, POPS_PER_OBSERVATION, SearchEnd};

/// A search that has taken this many triangles without an end turns to the landmarks: near picks are found before, and need
/// not have bounds prepared for each of the triangles round the goal, which costs as much as ten pops.
const POPS_BEFORE_AIM: u64 = 12;

/// Rounding of a sum of some ten thousand weights, as a share of it.
const COST_ROUNDING: f64 = 1e-11;

/// Stamps of one search: its first one and, added to it, the parts below.
const STAMPS: u32 = 8;
/// Part of a stamp: the search ends at this node. Alone: it was not reached yet.
const GOAL: u32 = 1;
/// Part of a stamp: the node was reached.
const REACHED: u32 = 2;
/// Part of a stamp: the node was taken from the queue, and no way to it has been found since that is cheaper.
const CLOSED: u32 = 4;

/// What a search knows of a node. `stamp` tells to which search it belongs, so that nothing has to be cleared
/// between searches and a near search costs nothing on a large mesh.
#[derive(Clone, Copy, Debug)]
struct Visit {
    cost: f64,
    /// `3 * node + side` that was crossed to get here; [`NONE`] at a source.
    via: u32,
    stamp: u32,
}

/// Work space of a search, kept for the next one.
#[derive(Debug, Default)]
pub struct Scratch {
    visits: Vec<Visit>,
    queue: Queue<u64>,
    /// The first stamp of the search; those of earlier ones are lower.
    stamp: u32,
}

impl Scratch {
    /// Makes it ready for a search among `count` nodes.
    pub fn begin(&mut self, count: usize) {
        let is_worn = self.stamp > u32::MAX - 2 * STAMPS;
        if self.visits.len() != count || is_worn {
            // `vec![..; n]` of zeroes asks the system for zeroed pages, which cost nothing until they are touched.
            self.visits = vec![Visit { cost: 0.0, via: 0, stamp: 0 }; count];
            self.stamp = 0;
        }
        self.stamp += STAMPS;
        self.queue.clear();
    }
}

/// A search on its way.
struct Search<'a, N> {
    nodes: &'a N,
    visits: &'a mut [Visit],
    queue: &'a mut Queue<u64>,
    keys: ShortKeys,
    stamp: u32,
    /// Where distances to the end are measured from.
    anchor: DVec3,
    aim: Option<(&'a Landmarks, Aim)>,
}

/// A node that was taken from the queue.
#[derive(Clone, Copy)]
struct Taken {
    id: u32,
    cost: f64,
    position: DVec3,
}

/// The cheapest strip from one end to the other among these nodes, in work space that was made ready; see
/// [`crate::search::DualGraph::find_strip`].
///
/// # Errors
/// [`Error::Interrupted`] when the observer says so.
pub fn search(
    nodes: &impl Nodes,
    landmarks: Option<&Landmarks>,
    from: &SearchEnd,
    to: &SearchEnd,
    scratch: &mut Scratch,
    observer: &mut dyn Observer,
) -> Result<Option<FoundStrip>, Error> {
    let Scratch { visits, queue, stamp } = scratch;
    let keys = ShortKeys::of_items_below(visits.len());
    let mut search = Search { nodes, visits, queue, keys, stamp: *stamp, anchor: to.anchor, aim: None };
    let goals = to.triangles.iter().map(|t| nodes.node(*t));
    let straight = |id: u32| nodes.position(id).distance(to.anchor);
    for goal in goals.clone() {
        search.visits[goal as usize].stamp = search.stamp | GOAL;
    }
    for source in &from.triangles {
        let id = nodes.node(*source);
        let cost = nodes.position(id).distance(from.anchor);
        search.enter(id, cost, NONE, straight(id));
    }
    let mut best: Option<(f64, u32)> = None;
    // Whatever could still be part of a strip that costs the same is looked at, so that the choice among such strips does
    // not hang on the order of the search.
    let mut largest_estimate = f64::INFINITY;
    let mut pops = 0u64;
    let mut next_look = POPS_BEFORE_AIM;
    while let Some(key) = search.queue.pop_key() {
        // Rounded down, so no node is left out; what is taken a little too early is opened again.
        let (estimate, id) = keys.split(key);
        if estimate > largest_estimate {
            break;
        }
        let visit = &mut search.visits[id as usize];
        if visit.stamp & CLOSED != 0 {
            continue;
        }
        visit.stamp |= CLOSED;
        let Visit { cost, stamp, .. } = *visit;
        pops += 1;
        if pops == next_look {
            if pops == POPS_BEFORE_AIM {
                // Bounds may rise on the way: a record that was closed too early for it is opened again.
                let ends = goals.clone().map(|goal| (goal, straight(goal)));
                search.aim = landmarks.and_then(|l| Some((l, l.aim_at(ends)?)));
            } else if observer.step(Step::Search) == ControlFlow::Break(()) {
                return Err(Error::Interrupted);
            }
            next_look = (pops / POPS_PER_OBSERVATION + 1) * POPS_PER_OBSERVATION;
        }
        if stamp & GOAL != 0 {
            let candidate = (cost + straight(id), id);
            let is_before = |best: (f64, u32)| {
                candidate.0 < best.0 || (candidate.0 == best.0 && nodes.place(id) < nodes.place(best.1))
            };
            let (cost, goal) = best.filter(|&best| !is_before(best)).unwrap_or(candidate);
            best = Some((cost, goal));
            largest_estimate = cost * (1.0 + COST_ROUNDING);
        }
        let (position, [a, b, c]) = nodes.position_and_neighbours(id);
        let taken = Taken { id, cost, position };
        search.reach(taken, 0, a);
        search.reach(taken, 1, b);
        search.reach(taken, 2, c);
    }
    Ok(best.map(|(cost, goal)| {
        let (first, word) = trace(nodes, search.visits, goal);
        FoundStrip { first, word, cost, pops }
    }))
}

impl<N: Nodes> Search<'_, N> {
    /// Goes from the node that was taken across one of its sides.
    // In line three times: measured 3 to 4 % of a search, as branches are guessed for each side by itself.
    #[inline(always)]
    fn reach(&mut self, from: Taken, side: u32, next: u32) {
        if next == NONE {
            return;
        }
        let Visit { cost: known_cost, via: known_via, stamp } = self.visits[next as usize];
        let is_known = stamp >= self.stamp + REACHED;
        // Most neighbours, the one that was come from among them: no way through here is cheaper, as weights are not
        // negative, nor as cheap in the sense below.
        if is_known & (known_cost <= from.cost) {
            return;
        }
        let position = self.nodes.position(next);
        let new_cost = from.cost + from.position.distance(position);
        let via = 3 * from.id + side;
        // A closed node can still improve by rounding, as the bounds are consistent only in exact arithmetic; then it is
        // opened again.
        if !is_known | (new_cost < known_cost) {
            self.enter(next, new_cost, via, position.distance(self.anchor));
        } else if new_cost == known_cost && new_cost > from.cost && known_via != NONE {
            let place = |via: u32| (self.nodes.place(via / 3), via % 3);
            if place(via) < place(known_via) {
                self.visits[next as usize].via = via;
            }
        }
    }

    /// Notes the cheapest way to a node so far, and puts the node into the queue.
    #[inline(always)]
    fn enter(&mut self, id: u32, cost: f64, via: u32, straight: f64) {
        let visit = &mut self.visits[id as usize];
        let goal = if visit.stamp >= self.stamp { visit.stamp & GOAL } else { 0 };
        *visit = Visit { cost, via, stamp: self.stamp | REACHED | goal };
        let rest = self.aim.as_ref().map_or(straight, |(landmarks, aim)| straight.max(landmarks.bound(id, aim)));
        self.queue.push_key(self.keys.key(cost + rest, id));
    }
}

/// The way to `goal`: its first triangle and its letters.
fn trace(nodes: &impl Nodes, visits: &[Visit], goal: u32) -> (TriangleId, Vec<HalfedgeId>) {
    let before = |id: u32| Some(visits[id as usize].via).filter(|&via| via != NONE).map(|via| via / 3);
    let letters = std::iter::successors(before(goal), |&id| before(id)).count();
    let mut word = Vec::with_capacity(letters);
    let mut id = goal;
    loop {
        let via = visits[id as usize].via;
        if via == NONE {
            word.reverse();
            return (nodes.triangle(id), word);
        }
        id = via / 3;
        word.push(nodes.triangle(id).halfedge(via % 3));
    }
}
