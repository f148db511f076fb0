//! The pieces round vertices where lines meet, in order, for telling on which side of a line another leaves.
//!
//! Looks at no positions: after the cut the order of edges round a vertex is all there is to know.

use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};

use super::Embedding;
use crate::adjacency::other_spoke;
use crate::ids::{TriangleId, VertexId};
use crate::mesh::SurfaceMesh;

/// The neighbours round one vertex, in order; where a boundary or a wall is in between, the walk ends there.
#[derive(Clone, Debug, Default)]
pub struct Ring {
    /// For each neighbour the neighbours that a piece joins it with, each with the name of the piece.
    links: BTreeMap<u32, Vec<(u32, u32)>>,
}

impl Ring {
    fn add(&mut self, a: u32, b: u32, piece: u32) {
        self.links.entry(a).or_default().push((b, piece));
        self.links.entry(b).or_default().push((a, piece));
    }

    /// A piece at the edge to `neighbour`.
    pub fn piece_at(&self, neighbour: u32) -> Option<u32> {
        self.links.get(&neighbour)?.first().map(|&(_, piece)| piece)
    }

    /// Going round from the edge to `start` by way of `piece`: the first of the edges to `wanted`, and the piece just before
    /// it. `None` where the way ends before.
    pub fn first_of(&self, start: u32, piece: u32, wanted: &[u32]) -> Option<(u32, u32)> {
        let (mut here, mut by) = (start, piece);
        for _ in 0..=self.links.len() {
            let &(next, _) = self.links.get(&here)?.iter().find(|&&(_, p)| p == by)?;
            if wanted.contains(&next) {
                return Some((next, by));
            }
            let onward = self.links.get(&next)?;
            // A boundary has one piece, a wall three or more: nothing is on the other side of it.
            let [one, other] = onward[..] else { return None };
            (here, by) = (next, if one.1 == by { other.1 } else { one.1 });
        }
        None
    }

    /// Whether the way from `a` to `b` parts `c` from `d`, all four different; `None` where that cannot be told.
    pub fn parts(&self, [a, b]: [u32; 2], [c, d]: [u32; 2]) -> Option<bool> {
        let mut sides = [None, None];
        for &(_, piece) in self.links.get(&a)? {
            let (mut from, mut by) = (a, piece);
            // What is met before b on this side of a.
            while let Some((met, before)) = self.first_of(from, by, &[b, c, d]) {
                if met == b {
                    break;
                }
                sides[usize::from(met == d)] = Some(piece);
                let [one, other] = self.links.get(&met)?[..] else { break };
                (from, by) = (met, if one.1 == before { other.1 } else { one.1 });
            }
        }
        let [c_side, d_side] = sides;
        Some(c_side? != d_side?)
    }
}

/// Rings of the vertices in `wanted`, and a triangle of the mesh at each that is old.
pub fn find_rings(
    mesh: &SurfaceMesh,
    embedding: &Embedding,
    wanted: &HashSet<u32>,
) -> (HashMap<u32, Ring>, HashMap<u32, TriangleId>) {
    let mut rings: HashMap<u32, Ring> = HashMap::new();
    let mut homes: HashMap<u32, TriangleId> = HashMap::new();
    let mut add = |name: u32, corners: [u32; 3]| {
        for k in 0..3 {
            let [v, a, b] = [corners[k], corners[(k + 1) % 3], corners[(k + 2) % 3]];
            if wanted.contains(&v) {
                rings.entry(v).or_default().add(a, b, name);
            }
        }
    };
    let is_cut: HashSet<u32> = embedding.cut.iter().map(|cut| cut.triangle.0).collect();
    // Pieces have the names that come after those of the triangles.
    let pieces = embedding.cut.iter().flat_map(|cut| &cut.pieces);
    for (name, piece) in (mesh.triangles().len() as u32..).zip(pieces) {
        add(name, *piece);
    }
    // Triangles that were not cut are at old vertices alone: those of the fans that lines come through.
    let mut whole: BTreeSet<u32> = BTreeSet::new();
    for &t in embedding.visited.iter().chain(embedding.cut.iter().map(|cut| &cut.triangle.0)) {
        for v in mesh.corners(TriangleId(t)).into_iter().filter(|v| wanted.contains(&v.0)) {
            homes.entry(v.0).or_insert(TriangleId(t));
            whole.extend(fan_of(mesh, v, TriangleId(t)));
        }
    }
    for &t in whole.iter().filter(|t| !is_cut.contains(t)) {
        add(t, mesh.triangles()[t as usize]);
    }
    (rings, homes)
}

/// The triangles round `v` that can be reached from `start` across edges at `v`.
fn fan_of(mesh: &SurfaceMesh, v: VertexId, start: TriangleId) -> Vec<u32> {
    let mut found = vec![start.0];
    for first in start.halfedges().into_iter().filter(|&h| mesh.touches(h, v)) {
        let mut exit = first;
        while let Some(twin) = mesh.twin(exit) {
            if twin.triangle() == start {
                return found;
            }
            found.push(twin.triangle().0);
            exit = other_spoke(mesh.triangles(), twin, v);
        }
    }
    found
}
