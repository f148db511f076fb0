//! Step B for lines that will be straightened: a strip whose shortest line is near the shortest of all.
//!
//! The paper's dual path (`search`) is a staircase: measured in barycentres, it can lead round the wrong side of a hill.
//! Here the search carries windows (`window`) instead: the source of a view, unfolded along the strip, so that what is
//! measured is the length of a line. Of the views that enter a triangle only the one that promises the shortest line to
//! the goal goes on (at slivers one a side, since their sides are far apart), so the search visits a triangle once, as a
//! dual search does, and what it finds is near the shortest line, not always it.
//!
//! Holds the search alone. Source: the order is that of A* (P. Hart, N. Nilsson, B. Raphael 1968), the views are those of
//! J. Mitchell, D. Mount, C. Papadimitriou 1987, *The Discrete Geodesic Problem*, one a triangle, which is ours.

use std::cmp::Ordering;
use std::collections::HashMap;
use std::ops::ControlFlow;

use glam::DVec3;

use crate::error::Error;
use crate::ids::{HalfedgeId, TriangleId, VertexId};
use crate::mesh::SurfaceMesh;
use crate::pool::Pool;
use crate::queue::Queue;
use crate::report::{Observer, Step};
use crate::search::FoundStrip;
use crate::spot::{Spot, spot_of, triangles_round};
use crate::surface_point::SurfacePoint;
use crate::window::{FlatTriangle, Window};
use crate::window_promise::{Exit, Promise, place_beside};

/// A triangle is a sliver when its height over its longest side is below this share of that side. Measured: with one view
/// a triangle lines on a mesh of slivers are 0.8 % longer than the shortest on average, with this 0.5 %; scans, where few
/// triangles are this flat, take 1 % more pops.
const SLIVER: f64 = 0.1;

/// Windows taken from the queue between two calls of the observer; about a millisecond.
const POPS_PER_OBSERVATION: u64 = 4096;

/// Work space for more windows than this is given back after a search.
const KEPT_VIEWS: usize = 1 << 16;

/// In a window's `parent`: it comes from the start.
const NO_PARENT: u32 = u32::MAX;

/// What a search knows of an entry, which is a triangle or a side of a sliver: the place of the window that waits there, and a
/// stamp, for which see `search`. A tuple, as `vec![..; n]` writes every page of a struct of zeroes, but not of a tuple.
type Entry = (u32, u32);

/// Where a window came in.
#[derive(Clone, Copy, Debug)]
struct View {
    /// The window's edge, seen from the triangle that is entered.
    entered: HalfedgeId,
    parent: u32,
}

/// A window that waits: all that is needed of it once it is its turn, in one line of memory.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
struct Waiting {
    promise: Promise,
    entered: HalfedgeId,
    /// Its place among the views.
    view: u32,
}

#[derive(Debug, Default)]
struct Scratch {
    entries: Vec<Entry>,
    /// All windows so far, in the order in which they were made: what is left of them once they have gone on.
    views: Vec<View>,
    /// The windows that wait, one an entry, and free places among them. So few wait at a time that a search needs a third of
    /// the memory that keeping all of them would take.
    waiting: Vec<Waiting>,
    free: Vec<u32>,
    /// Of views and places of windows, packed by [`pack`]. Where a window waits that is another view's, this one was
    /// replaced.
    queue: Queue<u128>,
    stamp: u32,
}

/// What searches share: which triangles are slivers, and work space of finished searches, taken up again by the next.
#[derive(Debug)]
pub struct WindowGraph {
    /// One bit a triangle.
    slivers: Vec<u64>,
    /// The mean of all barycentres.
    middle: DVec3,
    triangle_count: usize,
    pool: Pool<Scratch>,
}

impl WindowGraph {
    /// Finds the slivers. Cost: O(triangles).
    pub(crate) fn new(positions: &[DVec3], triangles: &[[u32; 3]]) -> Self {
        let is_sliver = |t: &[u32; 3]| is_sliver(t.map(|v| positions[v as usize]));
        let bits = |row: &[[u32; 3]]| row.iter().rev().fold(0, |bits, t| bits << 1 | u64::from(is_sliver(t)));
        let sum: DVec3 = triangles.iter().flatten().map(|&v| positions[v as usize]).sum();
        Self {
            slivers: triangles.chunks(64).map(bits).collect(),
            middle: sum / (3.0 * triangles.len() as f64),
            triangle_count: triangles.len(),
            pool: Pool::default(),
        }
    }

    /// Where the search keeps what it knows of the triangle that is entered, or of its side if that is a sliver.
    #[inline]
    fn entry_of(&self, entered: HalfedgeId) -> usize {
        let triangle = entered.triangle();
        let is_sliver = self.slivers[triangle.index() / 64] >> (triangle.0 % 64) & 1 == 1;
        if is_sliver { self.triangle_count + entered.index() } else { triangle.index() }
    }

    fn take_scratch(&self) -> Scratch {
        let entries = 4 * self.triangle_count;
        let mut scratch = self.pool.take();
        if scratch.entries.len() != entries || scratch.stamp > u32::MAX - 4 {
            // `vec![..; n]` of zeroes asks the system for zeroed pages, which cost nothing until they are touched.
            scratch.entries = vec![(0, 0); entries];
            scratch.stamp = 0;
        }
        scratch.stamp += 2;
        scratch.views.clear();
        scratch.waiting.clear();
        scratch.free.clear();
        scratch.queue.clear();
        scratch
    }

    fn put_back(&self, mut scratch: Scratch) {
        if scratch.views.capacity() > KEPT_VIEWS {
            // What a search across a large mesh has used is worth more to others than the millisecond to get it again.
            scratch = Scratch { entries: scratch.entries, stamp: scratch.stamp, ..Scratch::default() };
        }
        self.pool.put_back(scratch);
    }
}

/// A strip between two points whose shortest line is near the shortest line of the surface; `None` when no strip joins
/// them. Its `cost` is the length of a line in it. Ties go to the window that was made first, so the answer depends on the
/// mesh alone. Cost: O(n log n) for the triangles that are nearer, by way of both points, than the line is long.
///
/// The search begins at the point that is further from the middle of the mesh, whichever is asked for first, so that a
/// line is the same the other way round.
///
/// # Errors
/// [`Error::Interrupted`] when the observer says so.
pub fn find_taut_strip(
    mesh: &SurfaceMesh,
    from: &SurfacePoint,
    to: &SurfacePoint,
    observer: &mut dyn Observer,
) -> Result<Option<FoundStrip>, Error> {
    let graph = mesh.window_graph();
    let rank = |p: &SurfacePoint| mesh.position_of(p).distance_squared(graph.middle);
    let order = rank(from).total_cmp(&rank(to)).then_with(|| from.triangle.cmp(&to.triangle));
    let is_backward = order == Ordering::Less;
    let (begin, end) = if is_backward { (to, from) } else { (from, to) };
    let mut scratch = graph.take_scratch();
    let search = Search { mesh, graph, goal: mesh.position_of(end), scratch: &mut scratch };
    let found = search.find(begin, end, observer);
    if mesh.keeps_work_space() {
        graph.put_back(scratch);
    }
    Ok(found?.map(|found| if is_backward { found.reversed(mesh) } else { found }))
}

struct Search<'a> {
    mesh: &'a SurfaceMesh,
    graph: &'a WindowGraph,
    goal: DVec3,
    scratch: &'a mut Scratch,
}

/// A triangle as it lies behind the edge by which it is entered.
struct Wedge {
    /// The ends of that edge, lower id first.
    ends: [VertexId; 2],
    apex: VertexId,
    /// The sides from the first end to the apex, and from the second.
    sides: [HalfedgeId; 2],
}

impl Wedge {
    /// Without a branch: of the edges of a mesh as many run one way as the other.
    #[inline]
    fn of(mesh: &SurfaceMesh, entered: HalfedgeId) -> Self {
        /// The two other sides, by twice the side that is entered and one more where its first corner has the higher id.
        const SIDES: [[u8; 2]; 6] = [[2, 1], [1, 2], [0, 2], [2, 0], [1, 0], [0, 1]];
        let triangle = entered.triangle();
        let side = (entered.0 - 3 * triangle.0) as usize;
        let corners = mesh.corners(triangle);
        let [a, b, apex] = [0, 1, 2].map(|k| corners[(side + k) % 3]);
        let sides = SIDES[(2 * side + usize::from(a > b)) % 6].map(|side| triangle.halfedge(side.into()));
        Self { ends: [a.min(b), a.max(b)], apex, sides }
    }
}

impl Search<'_> {
    fn find(
        mut self,
        from: &SurfacePoint,
        to: &SurfacePoint,
        observer: &mut dyn Observer,
    ) -> Result<Option<FoundStrip>, Error> {
        let (sources, goals) = (triangles_round(self.mesh, from), triangles_round(self.mesh, to));
        if let Some(&first) = sources.iter().find(|t| goals.contains(t)) {
            let cost = self.mesh.position_of(from).distance(self.goal);
            return Ok(Some(FoundStrip { first, word: Vec::new(), cost, pops: 0 }));
        }
        self.start(from, &sources);
        self.run(&goals, observer)
    }

    /// Puts a window on every edge by which a line can leave the triangles that hold the start.
    fn start(&mut self, from: &SurfacePoint, sources: &[TriangleId]) {
        let mesh = self.mesh;
        let (spot, position): (Spot, DVec3) = (spot_of(mesh, from), mesh.position_of(from));
        for letter in sources.iter().flat_map(|t| t.halfedges()).filter(|&h| !spot.is_on(mesh, h)) {
            let ends = mesh.ends(letter);
            let places = ends.map(|v| mesh.position(v));
            let length = places[0].distance(places[1]);
            let Some(entered) = mesh.twin(letter) else { continue };
            let exit = Exit { places, length, is_upward: ends[0] < ends[1] };
            let window = Window::whole(position, places[0], places[1], length);
            self.push(entered, self.graph.entry_of(entered), NO_PARENT, &Promise::new(&window, &exit, self.goal));
        }
    }

    fn run(&mut self, goals: &[TriangleId], observer: &mut dyn Observer) -> Result<Option<FoundStrip>, Error> {
        let mesh = self.mesh;
        let closed = self.scratch.stamp + 1;
        let mut pops = 0u64;
        // Most triangles are not of the goal's: one bit tells.
        let goal_bits = goals.iter().fold(0u64, |bits, goal| bits | 1 << (goal.0 % 64));
        while let Some((_, item)) = self.scratch.queue.pop() {
            let (id, slot) = unpack(item);
            let waiting = &self.scratch.waiting[slot as usize];
            if waiting.view != id {
                continue;
            }
            let &Waiting { promise: Promise { ref window, length: base, .. }, entered, .. } = waiting;
            let triangle = entered.triangle();
            self.scratch.free.push(slot);
            self.scratch.entries[self.graph.entry_of(entered)].1 = closed;
            pops += 1;
            if pops % POPS_PER_OBSERVATION == 0 && observer.step(Step::Search) == ControlFlow::Break(()) {
                return Err(Error::Interrupted);
            }
            if goal_bits >> (triangle.0 % 64) & 1 == 1 && goals.contains(&triangle) {
                let word = without_repeats(mesh, self.trace(id));
                let cost = self.length_to_goal(entered, window);
                return Ok(Some(FoundStrip { first: word[0].triangle(), word, cost, pops }));
            }
            let Wedge { ends: [a, b], apex: c, sides } = Wedge::of(mesh, entered);
            // Where the next triangle is entered, unless a window that goes on has been there already.
            let [behind_a, behind_b] = sides.map(|letter| {
                let entered = mesh.twin(letter)?;
                let entry = self.graph.entry_of(entered);
                (self.scratch.entries[entry].1 != closed).then_some((entered, entry))
            });
            if behind_a.is_none() && behind_b.is_none() {
                continue;
            }
            let [at_a, at_b, at_c] = [a, b, c].map(|v| mesh.position(v));
            let triangle = FlatTriangle::new([at_a, at_b, at_c], base);
            let window = *window;
            if let Some((entered, entry)) = behind_a {
                let exit = Exit { places: [at_a, at_c], length: triangle.first_side, is_upward: a < c };
                let promise = Promise::new(&window.behind_first_side(&triangle), &exit, self.goal);
                self.push(entered, entry, id, &promise);
            }
            if let Some((entered, entry)) = behind_b {
                let exit = Exit { places: [at_b, at_c], length: triangle.second_side, is_upward: b < c };
                let window = window.reversed(base).behind_first_side(&triangle.mirrored());
                let promise = Promise::new(&window, &exit, self.goal);
                self.push(entered, entry, id, &promise);
            }
        }
        Ok(None)
    }

    /// Takes up a window by which `entered` can be entered, unless one that promises as little waits there.
    #[inline(always)]
    fn push(&mut self, entered: HalfedgeId, entry: usize, parent: u32, promise: &Promise) {
        let Scratch { entries, views, waiting, free, queue, stamp } = &mut self.scratch;
        let known = &mut entries[entry];
        let view = views.len() as u32;
        let window = Waiting { promise: *promise, entered, view };
        let slot = if known.1 == *stamp {
            let place = &mut waiting[known.0 as usize];
            // By their bits, as the queue has them.
            if promise.estimate.to_bits() >= place.promise.estimate.to_bits() {
                return;
            }
            *place = window;
            known.0
        } else {
            let slot = match free.pop() {
                Some(slot) => {
                    waiting[slot as usize] = window;
                    slot
                }
                None => {
                    waiting.push(window);
                    waiting.len() as u32 - 1
                }
            };
            *known = (slot, *stamp);
            slot
        };
        queue.push(promise.estimate, pack(view, slot));
        views.push(View { entered, parent });
    }

    /// Length of the line through a window of one of the goal's triangles.
    fn length_to_goal(&self, entered: HalfedgeId, window: &Window) -> f64 {
        let places = self.mesh.sorted_ends(entered).map(|v| self.mesh.position(v));
        let (along, off) = place_beside(places, places[0].distance(places[1]), self.goal);
        window.lengths_to(along, off).iter().sum()
    }

    /// The letters up to a window.
    fn trace(&self, mut id: u32) -> Vec<HalfedgeId> {
        let before = |id: u32| Some(self.scratch.views[id as usize].parent).filter(|&parent| parent != NO_PARENT);
        let mut word = Vec::with_capacity(std::iter::successors(Some(id), |&id| before(id)).count());
        while id != NO_PARENT {
            let view = &self.scratch.views[id as usize];
            word.extend(self.mesh.twin(view.entered));
            id = view.parent;
        }
        word.reverse();
        word
    }
}

/// A view and a window as one item of the queue: of equal estimates the view that was made first comes first.
fn pack(view: u32, window: u32) -> u64 {
    u64::from(view) << 32 | u64::from(window)
}

/// The inverse of [`pack`].
fn unpack(item: u64) -> (u32, u32) {
    ((item >> 32) as u32, item as u32)
}

/// The word without the letters between two visits of one triangle. Slivers may be entered by several sides, and where
/// vertices coincide rounding can find a way round one no longer than the direct one.
fn without_repeats(mesh: &SurfaceMesh, word: Vec<HalfedgeId>) -> Vec<HalfedgeId> {
    let mut triangles: Vec<TriangleId> = word.iter().map(|letter| letter.triangle()).collect();
    triangles.sort_unstable();
    if triangles.windows(2).all(|pair| pair[0] != pair[1]) {
        return word;
    }
    let mut kept: Vec<HalfedgeId> = Vec::with_capacity(word.len());
    let mut place_of: HashMap<TriangleId, usize> = HashMap::with_capacity(word.len() + 1);
    for letter in word {
        if let Some(&place) = place_of.get(&letter.triangle()) {
            kept.drain(place..).skip(1).for_each(|dropped| {
                place_of.remove(&dropped.triangle());
            });
        }
        place_of.insert(letter.triangle(), kept.len());
        kept.push(letter);
    }
    debug_assert!(kept.windows(2).all(|pair| mesh.twin(pair[0]).is_some_and(|h| h.triangle() == pair[1].triangle())));
    kept
}

/// See [`SLIVER`].
fn is_sliver([a, b, c]: [DVec3; 3]) -> bool {
    let (ab, ac, bc) = (b - a, c - a, c - b);
    let longest = ab.length_squared().max(ac.length_squared()).max(bc.length_squared());
    // Twice the area is the longest side times its height.
    ab.cross(ac).length() <= SLIVER * longest
}
