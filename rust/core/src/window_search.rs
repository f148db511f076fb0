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

/// A triangle is a sliver when its height over its longest side is below this share of that side. Measured: with one view
/// a triangle lines on a mesh of slivers are 0.8 % longer than the shortest on average, with this 0.5 %; scans, where few
/// triangles are this flat, take 1 % more pops.
const SLIVER: f64 = 0.1;

/// What the straight rest of a line weighs in an estimate beside its way so far. Above 1 the search heads for the goal more
/// and visits less. Measured: 1.02 takes 10 % fewer pops across a scan and finds lines as short; from 1.05 on lines on
/// slivers get longer.
const REST_WEIGHT: f64 = 1.02;

/// What the straight distance from the middle of a window's edge to the goal adds to an estimate, as a share. Where a line
/// bends at a vertex, windows on several edges promise the same; this decides between them, not rounding. Small, so that
/// it decides nothing else.
const TIE_BREAK: f64 = 1.0 / 4096.0;

/// Windows taken from the queue between two calls of the observer; about a millisecond.
const POPS_PER_OBSERVATION: u64 = 4096;

/// Work space for more windows than this is given back after a search.
const KEPT_VIEWS: usize = 1 << 16;

/// In a window's `parent`: it comes from the start.
const NO_PARENT: u32 = u32::MAX;

/// What a search knows of an entry, which is a triangle or a side of a sliver: the least estimate that waits there (rounded:
/// it only spares windows that would come too late), and a stamp, for which see `search`. A tuple, as `vec![..; n]` writes
/// every page of a struct of zeroes, but not of a tuple.
type Entry = (f32, u32);

/// Where a window came in.
#[derive(Clone, Copy, Debug)]
struct View {
    /// The window's edge, seen from the triangle that is entered.
    entered: HalfedgeId,
    parent: u32,
}

/// A window that waits, in the direction of its edge from the end with the lower vertex id, and the length of the edge.
type Waiting = (Window, f64);

#[derive(Debug, Default)]
struct Scratch {
    entries: Vec<Entry>,
    /// All windows so far, in the order in which they were made: what is left of them once they have gone on.
    views: Vec<View>,
    /// The windows that wait, and free places among them. So few wait at a time that a search needs a third of the memory
    /// that keeping all of them would take.
    windows: Vec<Waiting>,
    free: Vec<u32>,
    /// Of views and windows, packed by [`pack`].
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
            scratch.entries = vec![(0.0, 0); entries];
            scratch.stamp = 0;
        }
        scratch.stamp += 2;
        scratch.views.clear();
        scratch.windows.clear();
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

/// A side by which a line leaves a triangle: its ends in some direction, and its length.
struct Exit {
    letter: HalfedgeId,
    ends: [VertexId; 2],
    places: [DVec3; 2],
    length: f64,
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
            let exit = Exit { letter, ends, places, length };
            self.push(&exit, NO_PARENT, || Window::whole(position, places[0], places[1], length));
        }
    }

    fn run(&mut self, goals: &[TriangleId], observer: &mut dyn Observer) -> Result<Option<FoundStrip>, Error> {
        let mesh = self.mesh;
        let closed = self.scratch.stamp + 1;
        let mut pops = 0u64;
        while let Some((_, item)) = self.scratch.queue.pop() {
            let (id, slot) = unpack(item);
            let View { entered, .. } = self.scratch.views[id as usize];
            let (window, base) = self.scratch.windows[slot as usize];
            self.scratch.free.push(slot);
            let (_, stamp) = &mut self.scratch.entries[self.graph.entry_of(entered)];
            if *stamp == closed {
                continue;
            }
            *stamp = closed;
            pops += 1;
            if pops % POPS_PER_OBSERVATION == 0 && observer.step(Step::Search) == ControlFlow::Break(()) {
                return Err(Error::Interrupted);
            }
            if goals.contains(&entered.triangle()) {
                let word = without_repeats(mesh, self.trace(id));
                let cost = self.length_to_goal(entered, &window);
                return Ok(Some(FoundStrip { first: word[0].triangle(), word, cost, pops }));
            }
            let ([a, b], c) = (mesh.ends(entered), mesh.apex(entered));
            let is_turned = a > b;
            let ([a, b], [to_a, to_b]) = if is_turned {
                ([b, a], [entered.next(), entered.previous()])
            } else {
                ([a, b], [entered.previous(), entered.next()])
            };
            let [at_a, at_b, at_c] = [a, b, c].map(|v| mesh.position(v));
            let triangle = FlatTriangle::new([at_a, at_b, at_c], base);
            let exit = Exit { letter: to_a, ends: [a, c], places: [at_a, at_c], length: triangle.first_side };
            self.push(&exit, id, || window.behind_first_side(&triangle));
            let exit = Exit { letter: to_b, ends: [b, c], places: [at_b, at_c], length: triangle.second_side };
            self.push(&exit, id, || window.reversed(base).behind_first_side(&triangle.mirrored()));
        }
        Ok(None)
    }

    /// Takes up the window that lies on `exit` in its direction, unless it comes too late.
    #[inline]
    fn push(&mut self, exit: &Exit, parent: u32, window: impl FnOnce() -> Window) {
        let Some(entered) = self.mesh.twin(exit.letter) else { return };
        let Scratch { entries, views, windows, free, queue, stamp } = &mut self.scratch;
        let known = &mut entries[self.graph.entry_of(entered)];
        if known.1 == *stamp + 1 {
            return;
        }
        let window = window();
        let (along, off) = place_beside(exit.places, exit.length, self.goal);
        let from_middle = 0.5 * exit.length - along;
        let [so_far, rest] = window.lengths_to(along, off);
        let estimate = so_far + REST_WEIGHT * rest + TIE_BREAK * (from_middle * from_middle + off * off).sqrt();
        if known.1 == *stamp && estimate as f32 > known.0 {
            return;
        }
        *known = (estimate as f32, *stamp);
        let is_upward = exit.ends[0] < exit.ends[1];
        let waiting = (if is_upward { window } else { window.reversed(exit.length) }, exit.length);
        let slot = match free.pop() {
            Some(slot) => {
                windows[slot as usize] = waiting;
                slot
            }
            None => {
                windows.push(waiting);
                windows.len() as u32 - 1
            }
        };
        queue.push(estimate, pack(views.len() as u32, slot));
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

/// Where a point lies beside an edge of length `length`: along it, and off its line.
#[inline]
fn place_beside([a, b]: [DVec3; 2], length: f64, point: DVec3) -> (f64, f64) {
    let offset = point - a;
    if length == 0.0 {
        return (0.0, offset.length());
    }
    let direction = (b - a) * length.recip();
    (offset.dot(direction), offset.cross(direction).length())
}

/// See [`SLIVER`].
fn is_sliver([a, b, c]: [DVec3; 3]) -> bool {
    let (ab, ac, bc) = (b - a, c - a, c - b);
    let longest = ab.length_squared().max(ac.length_squared()).max(bc.length_squared());
    // Twice the area is the longest side times its height.
    ab.cross(ac).length() <= SLIVER * longest
}
