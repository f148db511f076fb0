//! Step B: the shortest path in the dual graph between two picks (the paper, section 4).
//!
//! Nodes are triangles, edges join triangles that share a crossable edge, and weigh the distance of the barycentres.
//! Holds what searches share and when landmarks are chosen; the loop itself is in [`crate::dual_search`], the nodes in
//! [`crate::dual_nodes`]. Knows nothing of polylines.

use std::ops::ControlFlow;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use glam::DVec3;

use crate::dual_nodes::{KeptNodes, MeshNodes, NONE, Nodes, OnDemand};
use crate::dual_search::{Scratch, search};
use crate::error::Error;
use crate::ids::{HalfedgeId, TriangleId};
use crate::landmarks::Landmarks;
use crate::mesh::SurfaceMesh;
use crate::pool::Pool;
use crate::report::{Observer, Step};
use crate::strip::entered_triangle;

/// Triangles taken from the queue between two calls of the observer; about a millisecond.
pub const POPS_PER_OBSERVATION: u64 = 4096;

/// A mesh of fewer triangles needs no landmarks: searching all of it takes less than half a millisecond. Measured: on 5 800
/// triangles they take a search across from 290 microseconds to 27, on 19 500 from 1 400 to 300.
const LANDMARK_TRIANGLES: usize = 4_000;

/// Landmarks are chosen once searches have taken this many triangles from their queues for each triangle of the mesh:
/// choosing costs about what was spent by then, so that never having chosen would have cost half as much at worst.
const POPS_BEFORE_LANDMARKS: u64 = 16;

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
        let mut scratch = self.kept.pool.take();
        scratch.begin(self.mesh.triangles().len());
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
