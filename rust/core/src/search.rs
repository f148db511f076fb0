//! Step B: the shortest path in the dual graph between two picks (the paper, section 4).
//!
//! Nodes are triangles, edges join triangles that share a crossable edge, and weigh the distance of the barycentres.
//! Holds the one search loop and what searches share; the nodes themselves are in [`crate::dual_nodes`]. Knows nothing of
//! polylines.

use std::ops::ControlFlow;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use glam::DVec3;

use crate::dual_nodes::{KeptNodes, MeshNodes, NONE, Nodes, OnDemand};
use crate::error::Error;
use crate::ids::{HalfedgeId, TriangleId};
use crate::landmarks::{Aim, Landmarks};
use crate::mesh::SurfaceMesh;
use crate::pool::Pool;
use crate::queue::{Queue, ShortKeys};
use crate::report::{Observer, Step};
use crate::strip::entered_triangle;

/// Triangles taken from the queue between two calls of the observer; about a millisecond.
const POPS_PER_OBSERVATION: u64 = 4096;

/// A mesh of fewer triangles needs no landmarks: searching all of it takes less than half a millisecond. Measured: on 5 800
/// triangles they take a search across from 290 microseconds to 27, on 19 500 from 1 400 to 300.
const LANDMARK_TRIANGLES: usize = 4_000;

/// Landmarks are chosen once searches have taken this many triangles from their queues for each triangle of the mesh:
/// choosing costs about what was spent by then, so that never having chosen would have cost half as much at worst.
const POPS_BEFORE_LANDMARKS: u64 = 16;

/// A search that has taken this many triangles without an end turns to the landmarks: near picks are found before, and need
/// not have bounds prepared for each of the triangles round the goal, which costs as much as ten pops.
const POPS_BEFORE_AIM: u64 = 12;

/// Rounding of a sum of some ten thousand weights, as a share of it.
const COST_ROUNDING: f64 = 1e-11;

/// Stamps of one search: its first one and, added to it, some of the next three.
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

#[derive(Debug, Default)]
struct Scratch {
    visits: Vec<Visit>,
    queue: Queue<u64>,
    stamp: u32,
}

/// What a mesh keeps for searches of its dual graph.
#[derive(Debug)]
pub struct KeptGraph {
    nodes: KeptNodes,
    /// Work space of finished searches, taken up again by the next.
    pool: Pool<Scratch>,
    landmarks: OnceLock<Option<Landmarks>>,
    /// Pops of all searches so far.
    total_pops: AtomicU64,
    /// Set by the one thread that chooses landmarks; others search without meanwhile.
    is_choosing: AtomicBool,
}

/// The dual graph of a mesh.
#[derive(Clone, Copy, Debug)]
pub struct DualGraph<'a> {
    mesh: &'a SurfaceMesh,
    kept: &'a KeptGraph,
}

/// A strip of triangles between two picks.
#[derive(Clone, PartialEq, Debug)]
pub struct FoundStrip {
    /// Its first triangle.
    pub first: TriangleId,
    /// The half-edges that are crossed, each seen from the triangle that is left.
    pub word: Vec<HalfedgeId>,
    /// Sum of the weights.
    pub cost: f64,
    /// Triangles taken from the queue.
    pub pops: u64,
}

impl FoundStrip {
    /// The same strip the other way round.
    pub fn reversed(self, mesh: &SurfaceMesh) -> Self {
        let first = self.word.last().map_or(self.first, |&h| entered_triangle(mesh, h));
        Self { first, word: self.word.iter().rev().filter_map(|&h| mesh.twin(h)).collect(), ..self }
    }
}

/// Where a search may start or end.
#[derive(Clone, PartialEq, Debug)]
pub struct SearchEnd {
    /// Triangles that hold the pick: one, or all round an edge or a vertex.
    pub triangles: Vec<TriangleId>,
    /// What distances to this end are measured from: the barycentre of the only triangle (so that costs are those of the
    /// plain dual graph), or the pick's own position where several triangles compete.
    pub anchor: DVec3,
}

/// See [`DualGraph::hold_landmarks`].
#[derive(Debug)]
pub struct HeldLandmarks<'a> {
    /// None: another thread was choosing or holding already.
    is_choosing: Option<&'a AtomicBool>,
}

impl Drop for HeldLandmarks<'_> {
    fn drop(&mut self) {
        if let Some(is_choosing) = self.is_choosing {
            is_choosing.store(false, Ordering::Release);
        }
    }
}

impl KeptGraph {
    /// Before the first search.
    pub fn new(nodes: KeptNodes) -> Self {
        Self {
            nodes,
            pool: Pool::default(),
            landmarks: OnceLock::new(),
            total_pops: AtomicU64::new(0),
            is_choosing: AtomicBool::new(false),
        }
    }
}

impl<'a> DualGraph<'a> {
    /// The graph of a mesh, with what that mesh keeps of it.
    pub(crate) fn new(mesh: &'a SurfaceMesh, kept: &'a KeptGraph) -> Self {
        Self { mesh, kept }
    }

    /// The barycentre of a triangle.
    #[inline]
    pub fn barycentre(&self, triangle: TriangleId) -> DVec3 {
        match &self.kept.nodes {
            KeptNodes::Records(records) => records.position(records.node(triangle)),
            KeptNodes::OnDemand(kept) => self.nodes(kept).position(triangle.0),
        }
    }

    /// The triangle at a place of the Morton curve, counted from 0.
    #[inline]
    pub fn triangle_at(&self, place: usize) -> TriangleId {
        self.kept.nodes.triangle_at(place, self.mesh)
    }

    /// The cheapest strip from one end to the other, `None` when they are not connected.
    ///
    /// A* with the straight distance, which no path undercuts; equal in cost to Dijkstra's. Of strips that cost the same to
    /// the bit, the one whose last triangles come first on the Morton curve, so the answer depends on the mesh alone. A
    /// large mesh that is asked often gets landmarks, after which searches take fewer pops and find the same.
    ///
    /// # Errors
    /// [`Error::Interrupted`] when the observer says so.
    ///
    /// Source: P. Hart, N. Nilsson, B. Raphael 1968, *A Formal Basis for the Heuristic Determination of Minimum Cost
    /// Paths*; the weights are the paper's (section 4).
    pub fn find_strip(
        &self,
        from: &SearchEnd,
        to: &SearchEnd,
        observer: &mut dyn Observer,
    ) -> Result<Option<FoundStrip>, Error> {
        if let Some(&near) = from.triangles.first() {
            self.choose_landmarks_if_due(near, observer)?;
        }
        let mut scratch = self.take_scratch();
        let landmarks = self.kept.landmarks.get().and_then(Option::as_ref);
        let result = match &self.kept.nodes {
            KeptNodes::Records(records) => search(records, landmarks, from, to, &mut scratch, observer),
            KeptNodes::OnDemand(kept) => search(&self.nodes(kept), landmarks, from, to, &mut scratch, observer),
        };
        if self.mesh.keeps_work_space() {
            self.kept.pool.put_back(scratch);
        }
        if let Ok(Some(found)) = &result {
            self.kept.total_pops.fetch_add(found.pops, Ordering::Relaxed);
        }
        result
    }

    /// [`DualGraph::choose_landmarks`], where the mesh is large and has been asked often.
    ///
    /// # Errors
    /// [`Error::Interrupted`] when the observer says so.
    pub fn choose_landmarks_if_due(&self, near: TriangleId, observer: &mut dyn Observer) -> Result<(), Error> {
        let triangles = self.mesh.triangles().len();
        let is_due = triangles >= LANDMARK_TRIANGLES
            && self.kept.total_pops.load(Ordering::Relaxed) >= POPS_BEFORE_LANDMARKS * triangles as u64;
        if is_due { self.choose_landmarks(near, observer) } else { Ok(()) }
    }

    /// As long as the result lives no landmarks are chosen: searches that go on side by side then count the same pops
    /// whichever comes first.
    pub fn hold_landmarks(&self) -> HeldLandmarks<'a> {
        let is_own = !self.kept.is_choosing.swap(true, Ordering::Acquire);
        HeldLandmarks { is_choosing: is_own.then_some(&self.kept.is_choosing) }
    }

    /// Chooses landmarks in the part of the mesh that holds `near`, unless they are there or another thread is at it.
    ///
    /// # Errors
    /// [`Error::Interrupted`] when the observer says so.
    pub fn choose_landmarks(&self, near: TriangleId, observer: &mut dyn Observer) -> Result<(), Error> {
        let kept = self.kept;
        if kept.landmarks.get().is_some() || kept.is_choosing.swap(true, Ordering::Acquire) {
            return Ok(());
        }
        let chosen = match &kept.nodes {
            KeptNodes::Records(records) => choose_among(records, near, observer),
            KeptNodes::OnDemand(kept) => choose_among(&self.nodes(kept), near, observer),
        };
        let result = chosen.map(|landmarks| {
            // No other thread got here, so this sets.
            let _ = kept.landmarks.set(landmarks);
        });
        kept.is_choosing.store(false, Ordering::Release);
        result
    }

    fn nodes(&self, kept: &'a OnDemand) -> MeshNodes<'a> {
        MeshNodes { mesh: self.mesh, kept }
    }

    fn take_scratch(&self) -> Scratch {
        let count = self.mesh.triangles().len();
        let mut scratch = self.kept.pool.take();
        let is_worn = scratch.stamp > u32::MAX - 2 * STAMPS;
        if scratch.visits.len() != count || is_worn {
            // `vec![..; n]` of zeroes asks the system for zeroed pages, which cost nothing until they are touched.
            scratch.visits = vec![Visit { cost: 0.0, via: 0, stamp: 0 }; count];
            scratch.stamp = 0;
        }
        scratch.stamp += STAMPS;
        scratch.queue.clear();
        scratch
    }
}

/// Landmarks among these nodes. See [`DualGraph::choose_landmarks`].
fn choose_among(nodes: &impl Nodes, near: TriangleId, observer: &mut dyn Observer) -> Result<Option<Landmarks>, Error> {
    let neighbours = |id: u32, visit: &mut dyn FnMut(u32, f64)| {
        let position = nodes.position(id);
        for next in nodes.neighbours(id).into_iter().filter(|&next| next != NONE) {
            visit(next, position.distance(nodes.position(next)));
        }
    };
    let mut pops = 0u64;
    let pause = || {
        pops += 1;
        let is_time = pops % POPS_PER_OBSERVATION == 0;
        if is_time && observer.step(Step::Search) == ControlFlow::Break(()) { Err(Error::Interrupted) } else { Ok(()) }
    };
    Landmarks::choose(nodes.count(), nodes.node(near), neighbours, pause)
}

/// [`DualGraph::find_strip`] among these nodes.
fn search(
    nodes: &impl Nodes,
    landmarks: Option<&Landmarks>,
    from: &SearchEnd,
    to: &SearchEnd,
    scratch: &mut Scratch,
    observer: &mut dyn Observer,
) -> Result<Option<FoundStrip>, Error> {
    let Scratch { visits, queue, stamp: first_stamp } = scratch;
    let (visits, first_stamp) = (visits.as_mut_slice(), *first_stamp);
    let keys = ShortKeys::of_items_below(visits.len());
    let goals = to.triangles.iter().map(|t| nodes.node(*t));
    let straight = |id: u32| nodes.position(id).distance(to.anchor);
    let mut aim: Option<(&Landmarks, Aim)> = None;
    // Stamps of earlier searches are lower.
    let reached = |before: u32| first_stamp | REACHED | if before >= first_stamp { before & GOAL } else { 0 };
    for goal in goals.clone() {
        visits[goal as usize].stamp = first_stamp | GOAL;
    }
    for source in &from.triangles {
        let id = nodes.node(*source);
        let cost = nodes.position(id).distance(from.anchor);
        let visit = &mut visits[id as usize];
        *visit = Visit { cost, via: NONE, stamp: reached(visit.stamp) };
        queue.push_key(keys.key(cost + straight(id), id));
    }
    let mut best: Option<(f64, u32)> = None;
    // Whatever could still be part of a strip that costs the same is looked at, so that the choice among such strips does
    // not hang on the order of the search.
    let mut largest_estimate = f64::INFINITY;
    let mut pops = 0u64;
    let mut next_look = POPS_BEFORE_AIM;
    while let Some(key) = queue.pop_key() {
        // Rounded down, so no node is left out; what is taken a little too early is opened again.
        let (estimate, id) = keys.split(key);
        if estimate > largest_estimate {
            break;
        }
        let visit = &mut visits[id as usize];
        if visit.stamp & CLOSED != 0 {
            continue;
        }
        visit.stamp |= CLOSED;
        let Visit { cost, stamp, .. } = *visit;
        pops += 1;
        if pops == next_look {
            if pops == POPS_BEFORE_AIM {
                // Bounds may rise on the way: a record that was closed too early for it is opened again.
                aim = landmarks.and_then(|l| Some((l, l.aim_at(goals.clone().map(|goal| (goal, straight(goal))))?)));
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
        let (position, neighbours) = nodes.position_and_neighbours(id);
        for (side, &next) in (0..).zip(&neighbours) {
            if next == NONE {
                continue;
            }
            let visit = &mut visits[next as usize];
            let is_known = visit.stamp >= first_stamp + REACHED;
            // Most neighbours, the one that was come from among them: no way through here is cheaper, as weights are
            // not negative, nor as cheap in the sense below.
            if is_known & (visit.cost <= cost) {
                continue;
            }
            let next_position = nodes.position(next);
            let new_cost = cost + position.distance(next_position);
            let via = 3 * id + side;
            // A closed node can still improve by rounding, as the bounds are consistent only in exact arithmetic;
            // then it is opened again.
            if !is_known | (new_cost < visit.cost) {
                *visit = Visit { cost: new_cost, via, stamp: reached(visit.stamp) };
                let straight = next_position.distance(to.anchor);
                let rest = aim.as_ref().map_or(straight, |(landmarks, aim)| straight.max(landmarks.bound(next, aim)));
                queue.push_key(keys.key(new_cost + rest, next));
            } else if new_cost == visit.cost && new_cost > cost && visit.via != NONE {
                let place = |via: u32| (nodes.place(via / 3), via % 3);
                if place(via) < place(visit.via) {
                    visit.via = via;
                }
            }
        }
    }
    Ok(best.map(|(cost, goal)| {
        let (first, word) = trace(nodes, visits, goal);
        FoundStrip { first, word, cost, pops }
    }))
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
