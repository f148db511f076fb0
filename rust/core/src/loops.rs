//! Loops of a strip that smoothing has made, and cutting them out (the paper, section 6, figure 13).
//!
//! A strip that comes back to a triangle makes a loop. One that step B's strip made already is the caller's own route (a
//! figure eight is legal) and stays; one that is new and bounds a disc is cut out: the line then crosses the triangle
//! once. A new loop that bounds no disc goes round something, so it stays too.
//!
//! Works on words alone; positions play no part.

use std::collections::{HashMap, HashSet};

use crate::ids::{HalfedgeId, TriangleId, VertexId};
use crate::mesh::SurfaceMesh;
use crate::route::Route;
use crate::strip::{entered_triangle, triangles_of};

/// Triangles that the search for a disc visits at most on each side, for each letter of the loop, and at least
/// [`DISC_FLOOR`]: loops made by smoothing are small, and a long search would cost more than the loop harms.
const DISC_TRIANGLES_PER_LETTER: usize = 64;
/// See [`DISC_TRIANGLES_PER_LETTER`].
const DISC_FLOOR: usize = 4096;

/// The triangles that the strip of each leg visits more than once, in order of their ids.
#[derive(Clone, Debug, Default)]
pub struct OwnRepeats {
    repeated: Vec<Vec<TriangleId>>,
}

impl OwnRepeats {
    /// Notes what step B's strip repeats.
    pub fn of_route(mesh: &SurfaceMesh, route: &Route) -> Self {
        let of_leg = |word: &[HalfedgeId], first: TriangleId| {
            repeats_of(&mut strip_once(mesh, first, word, route.pins.is_empty()))
        };
        Self { repeated: route.legs.iter().map(|leg| of_leg(&leg.word, leg.first)).collect() }
    }

    /// Follows the places where the route itself crosses or meets itself over the mesh vertices that the last round has
    /// passed: a figure eight that is smoothed is still a figure eight. For filters that keep the shape of a line; one
    /// that shortens it would undo such a loop anyway.
    pub fn follow(&mut self, mesh: &SurfaceMesh, route: &Route) {
        let is_ring = route.pins.is_empty();
        for (leg, own) in route.legs.iter().zip(&mut self.repeated).filter(|(_, own)| !own.is_empty()) {
            follow_own(mesh, own, &mut strip_once(mesh, leg.first, &leg.word, is_ring));
        }
    }

    /// Cuts all new loops that bound discs out of the route's legs; returns how many.
    pub fn cut_new_loops(&self, mesh: &SurfaceMesh, route: &mut Route) -> u64 {
        let mut cuts = 0;
        let is_ring = route.pins.is_empty();
        for (leg, own) in route.legs.iter_mut().zip(&self.repeated) {
            while let Some((start, end)) = find_new_loop(mesh, leg.first, &leg.word, own, is_ring) {
                leg.cut(mesh, start, end, is_ring);
                cuts += 1;
            }
        }
        cuts
    }
}

/// Adds to the route's own repeats those of its strip now that are near them: a vertex pass exchanges triangles round one
/// vertex, so what it has moved has a vertex in common with where it was.
fn follow_own(mesh: &SurfaceMesh, own: &mut Vec<TriangleId>, strip: &mut [TriangleId]) {
    let mut others = repeats_of(strip);
    others.retain(|triangle| own.binary_search(triangle).is_err());
    // Several passes may have moved it on in one round: from one to the next.
    let mut near: HashSet<VertexId> = own.iter().flat_map(|&t| mesh.corners(t)).collect();
    loop {
        let (found, rest): (Vec<_>, Vec<_>) =
            others.iter().partition(|&&t| mesh.corners(t).iter().any(|v| near.contains(v)));
        if found.is_empty() {
            break;
        }
        near.extend(found.iter().flat_map(|&t| mesh.corners(t)));
        own.extend(found);
        others = rest;
    }
    own.sort_unstable();
}

/// Triangles of a strip; a ring does not repeat its first.
fn strip_once(mesh: &SurfaceMesh, first: TriangleId, word: &[HalfedgeId], is_ring: bool) -> Vec<TriangleId> {
    let mut triangles = triangles_of(mesh, first, word);
    if is_ring {
        triangles.pop();
    }
    triangles
}

/// What is in `triangles` more than once, each once and in order; sorts them. Strips that repeat nothing are the rule, and
/// for them this costs less than hashing.
fn repeats_of(triangles: &mut [TriangleId]) -> Vec<TriangleId> {
    triangles.sort_unstable();
    let mut repeats: Vec<_> = triangles.windows(2).filter(|pair| pair[0] == pair[1]).map(|pair| pair[0]).collect();
    repeats.dedup();
    repeats
}

/// Letters `start..end` of the innermost new loop that bounds a disc; `start >= end` across the seam of a ring.
fn find_new_loop(
    mesh: &SurfaceMesh,
    first: TriangleId,
    word: &[HalfedgeId],
    own: &[TriangleId],
    is_ring: bool,
) -> Option<(usize, usize)> {
    let triangles = strip_once(mesh, first, word, is_ring);
    let is_own = |triangle: &TriangleId| own.binary_search(triangle).is_ok();
    if repeats_of(&mut triangles.clone()).iter().all(is_own) {
        return None;
    }
    let mut last_visit: HashMap<TriangleId, usize> = HashMap::with_capacity(word.len() + 1);
    for (i, triangle) in triangles.into_iter().enumerate() {
        let Some(before) = last_visit.insert(triangle, i) else { continue };
        if is_own(&triangle) {
            continue;
        }
        let inner = &word[before..i];
        let outer: Vec<HalfedgeId> = if is_ring { [&word[i..], &word[..before]].concat() } else { Vec::new() };
        let inner_first = !is_ring || inner.len() <= outer.len();
        for is_inner in [inner_first, !inner_first] {
            let (letters, range) = if is_inner { (inner, (before, i)) } else { (outer.as_slice(), (i, before)) };
            if !letters.is_empty() && bounds_disc(mesh, letters) {
                return Some(range);
            }
        }
    }
    None
}

/// Whether a closed strip bounds a disc on one of its sides.
fn bounds_disc(mesh: &SurfaceMesh, ring: &[HalfedgeId]) -> bool {
    let triangles: HashSet<TriangleId> = ring.iter().map(|&h| entered_triangle(mesh, h)).collect();
    if triangles.len() != ring.len() {
        // It has a loop of its own, which will be looked at first.
        return false;
    }
    let Some(sides) = rim_edges(mesh, ring) else { return false };
    let budget = DISC_FLOOR.max(DISC_TRIANGLES_PER_LETTER * ring.len());
    sides.iter().any(|rim| rim.is_empty() || encloses_disc(mesh, &triangles, rim, budget))
}

/// The edges along both sides of a closed strip, seen from the strip; `None` when the strip is one-sided. A side without
/// edges is a single vertex that the strip turns round.
fn rim_edges(mesh: &SurfaceMesh, ring: &[HalfedgeId]) -> Option<[Vec<HalfedgeId>; 2]> {
    let mut rims = [Vec::new(), Vec::new()];
    let [mut left, mut right] = mesh.ends(ring[0]);
    let start: [VertexId; 2] = [left, right];
    for k in 0..ring.len() {
        let entered = mesh.twin(ring[k])?;
        let next = ring[(k + 1) % ring.len()];
        let apex = mesh.apex(entered);
        let rim = entered.triangle().halfedges().into_iter().find(|&h| h != entered && h != next)?;
        if mesh.touches(next, left) {
            right = apex;
            rims[1].push(rim);
        } else {
            left = apex;
            rims[0].push(rim);
        }
    }
    ([left, right] == start).then_some(rims)
}

/// Whether what lies beyond a rim, away from the strip, is a disc that the rim encloses whole.
fn encloses_disc(mesh: &SurfaceMesh, strip: &HashSet<TriangleId>, rim: &[HalfedgeId], budget: usize) -> bool {
    let rim_set: HashSet<HalfedgeId> = rim.iter().copied().collect();
    let mut inside: HashSet<TriangleId> = HashSet::new();
    let mut open: Vec<TriangleId> = Vec::new();
    let mut inner_sides = 0usize;
    // Rim edges that fold onto each other leave no triangle between them.
    for &h in rim {
        match mesh.twin(h) {
            None => return false,
            Some(twin) if rim_set.contains(&twin) => {}
            Some(twin) if strip.contains(&twin.triangle()) => return false,
            Some(twin) => {
                if inside.insert(twin.triangle()) {
                    open.push(twin.triangle());
                }
            }
        }
    }
    while let Some(triangle) = open.pop() {
        if inside.len() > budget {
            return false;
        }
        for h in triangle.halfedges() {
            let Some(twin) = mesh.twin(h) else { return false };
            if rim_set.contains(&twin) {
                continue;
            }
            if strip.contains(&twin.triangle()) {
                return false;
            }
            inner_sides += 1;
            if inside.insert(twin.triangle()) {
                open.push(twin.triangle());
            }
        }
    }
    let on_rim: HashSet<VertexId> = rim.iter().flat_map(|&h| mesh.ends(h)).collect();
    let inner: HashSet<VertexId> =
        inside.iter().flat_map(|&t| mesh.corners(t)).filter(|v| !on_rim.contains(v)).collect();
    let folded = rim.iter().filter(|&&h| mesh.twin(h).is_some_and(|t| rim_set.contains(&t))).count() / 2;
    // Euler's characteristic of the inside together with its rim, each rim edge and vertex counted once: 1 for a disc.
    let edges = inner_sides / 2 + rim.len() - folded;
    let vertices = inner.len() + on_rim.len();
    vertices + inside.len() == edges + 1
}
