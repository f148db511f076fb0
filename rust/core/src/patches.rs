//! The patches that lines part a mesh into, after the lines were put into it.
//!
//! A patch is what can be reached without stepping over an edge of a line. Looks at the cut mesh alone; knows no lines but
//! by their edges.

use std::collections::{BTreeSet, HashMap, HashSet};

use glam::DVec3;

use crate::adjacency::{Adjacency, other_spoke};
use crate::embed::Embedding;
use crate::ids::{HalfedgeId, TriangleId, VertexId};
use crate::mesh::SurfaceMesh;

/// One patch.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct Patch {
    /// Triangles of the cut mesh.
    pub triangles: u32,
    /// Their area.
    pub area: f64,
    /// Stretches of its outline between corners, over all its loops: corners are where lines meet or end, or come to the
    /// mesh's boundary. A loop without a corner has one side; a line that ends inside the patch is passed on both sides.
    pub sides: u32,
    /// Closed loops of its outline.
    pub loops: u32,
    /// Euler characteristic of the patch, opened along the lines: 1 for a disc.
    pub euler: i64,
}

/// The patches of a cut mesh.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Patches {
    /// The patch of each triangle of the cut mesh. Patches are numbered by their lowest triangle.
    pub of_triangles: Vec<u32>,
    /// What is known of each.
    pub patches: Vec<Patch>,
    /// For each patch the corners that its sides lie between, vertices of the cut mesh, in order round each loop in turn.
    pub corners: Vec<Vec<u32>>,
    /// Pairs of patches that meet at a line, lower first, each once; a patch that meets itself there is a pair with itself.
    pub neighbours: Vec<[u32; 2]>,
}

/// The cut mesh as a walker sees it.
struct Opened<'a> {
    triangles: &'a [[u32; 3]],
    adjacency: Adjacency,
    is_line_end: Vec<bool>,
    lines: HashSet<[u32; 2]>,
}

/// Parts the mesh that `embedding` made, whose triangles are `triangles`, along all its lines. Cost: O(triangles).
pub fn find_patches(mesh: &SurfaceMesh, embedding: &Embedding, triangles: &[[u32; 3]]) -> Patches {
    let vertex_count = mesh.positions().len() + embedding.new.len();
    let edges = embedding.line_edges();
    let mut is_line_end = vec![false; vertex_count];
    edges.iter().flatten().for_each(|&v| is_line_end[v as usize] = true);
    let opened = Opened {
        triangles,
        adjacency: Adjacency::new(triangles, vertex_count),
        is_line_end,
        lines: edges.iter().copied().collect(),
    };
    let mut found = opened.flood();
    let place = |v: u32| match (v as usize).checked_sub(mesh.positions().len()) {
        None => mesh.positions()[v as usize],
        Some(new) => mesh.position_of(&embedding.new[new].point),
    };
    for (corners, &patch) in triangles.iter().zip(&found.of_triangles) {
        let [a, b, c]: [DVec3; 3] = corners.map(place);
        let patch = &mut found.patches[patch as usize];
        patch.triangles += 1;
        patch.area += (b - a).cross(c - a).length() / 2.0;
    }
    let corners = find_corners(embedding, &edges);
    opened.outline(&mut found, &corners);
    found
}

/// Vertices where lines meet or end.
fn find_corners(embedding: &Embedding, edges: &[[u32; 2]]) -> HashSet<u32> {
    let mut counts = HashMap::<u32, u32>::new();
    edges.iter().flatten().for_each(|&v| *counts.entry(v).or_default() += 1);
    let ends = embedding.chains.iter().zip(&embedding.closed).filter(|(_, closed)| !**closed);
    let ends = ends.flat_map(|(chain, _)| [chain[0].vertex, chain[chain.len() - 1].vertex]);
    counts.iter().filter(|(_, count)| **count != 2).map(|(&v, _)| v).chain(ends).collect()
}

impl Opened<'_> {
    fn ends(&self, h: HalfedgeId) -> [u32; 2] {
        let corners = self.triangles[h.triangle().index()];
        [corners[h.side() as usize], corners[(h.side() as usize + 1) % 3]]
    }

    fn is_line(&self, h: HalfedgeId) -> bool {
        let [a, b] = self.ends(h);
        self.is_line_end[a as usize] && self.is_line_end[b as usize] && self.lines.contains(&[a.min(b), a.max(b)])
    }

    /// The side across, unless that is another patch or nothing.
    fn inner_twin(&self, h: HalfedgeId) -> Option<HalfedgeId> {
        self.adjacency.twin(h).filter(|_| !self.is_line(h))
    }

    fn flood(&self) -> Patches {
        let mut found = Patches { of_triangles: vec![u32::MAX; self.triangles.len()], ..Patches::default() };
        let mut open = Vec::new();
        for first in 0..self.triangles.len() as u32 {
            if found.of_triangles[first as usize] != u32::MAX {
                continue;
            }
            let patch = found.patches.len() as u32;
            found.patches.push(Patch::default());
            found.of_triangles[first as usize] = patch;
            open.push(first);
            while let Some(t) = open.pop() {
                for h in TriangleId(t).halfedges() {
                    let next = self.inner_twin(h).map(|twin| twin.triangle().0);
                    if let Some(next) = next.filter(|&t| found.of_triangles[t as usize] == u32::MAX) {
                        found.of_triangles[next as usize] = patch;
                        open.push(next);
                    }
                }
            }
        }
        found
    }

    /// Walks the outline of every patch: loops, sides, neighbours, and with the vertices inside the Euler characteristic.
    fn outline(&self, found: &mut Patches, corners: &HashSet<u32>) {
        let of_triangles = found.of_triangles.clone();
        let patch_of = |h: HalfedgeId| of_triangles[h.triangle().index()];
        let count = 3 * self.triangles.len();
        let mut is_walked = vec![false; count];
        let mut is_corner_seen = vec![false; count];
        let mut neighbours = BTreeSet::new();
        found.corners = vec![Vec::new(); found.patches.len()];
        for start in (0..count as u32).map(HalfedgeId) {
            if is_walked[start.index()] || self.inner_twin(start).is_some() {
                continue;
            }
            let patch = patch_of(start) as usize;
            let [first, mut v] = self.ends(start);
            let (mut side, mut stops, mut length) = (start, 0, 0i64);
            loop {
                is_walked[side.index()] = true;
                length += 1;
                let twin = self.adjacency.twin(side);
                if let Some(other) = twin.map(patch_of) {
                    neighbours.insert([other.min(patch as u32), other.max(patch as u32)]);
                }
                let next = self.next_side(side, v, &mut is_corner_seen);
                if corners.contains(&v) || self.is_line(side) != self.is_line(next) {
                    stops += 1;
                    found.corners[patch].push(v);
                }
                if next == start && v == first {
                    break;
                }
                let [a, b] = self.ends(next);
                (side, v) = (next, if a == v { b } else { a });
            }
            let patch = &mut found.patches[patch];
            patch.loops += 1;
            patch.sides += stops.max(1);
            patch.euler += length;
        }
        // With F triangles, B sides on the outline and I vertices inside: V = B + I, E = (3 F + B) / 2, and so
        // 2 (V - E + F) = B + 2 I - F.
        for (t, &patch) in found.of_triangles.iter().enumerate() {
            found.patches[patch as usize].euler -= 1;
            for h in TriangleId(t as u32).halfedges() {
                if !is_corner_seen[h.index()] {
                    self.mark_ring(h, &mut is_corner_seen);
                    found.patches[patch as usize].euler += 2;
                }
            }
        }
        found.patches.iter_mut().for_each(|patch| patch.euler /= 2);
        found.neighbours = neighbours.into_iter().collect();
    }

    /// The next side of the outline round `v`; marks the corners that are passed.
    fn next_side(&self, side: HalfedgeId, v: u32, is_seen: &mut [bool]) -> HalfedgeId {
        let mut h = side;
        loop {
            is_seen[self.corner(h.triangle(), v)] = true;
            let spoke = other_spoke(self.triangles, h, VertexId(v));
            match self.inner_twin(spoke) {
                Some(twin) => h = twin,
                None => return spoke,
            }
        }
    }

    /// Marks the corners round a vertex inside a patch, named by a half-edge whose first end it is.
    fn mark_ring(&self, first: HalfedgeId, is_seen: &mut [bool]) {
        let v = self.ends(first)[0];
        let mut h = first;
        while !is_seen[self.corner(h.triangle(), v)] {
            is_seen[self.corner(h.triangle(), v)] = true;
            let spoke = other_spoke(self.triangles, h, VertexId(v));
            let Some(twin) = self.inner_twin(spoke) else { return };
            h = twin;
        }
    }

    /// Place of a corner of a triangle among all.
    fn corner(&self, triangle: TriangleId, v: u32) -> usize {
        let k = self.triangles[triangle.index()].iter().position(|&c| c == v).unwrap_or(0);
        3 * triangle.index() + k
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::options::{Filter, Options};
    use crate::report::NoObserver;
    use crate::smooth::polyline;
    use crate::surface_point::Pick;

    fn patches_of(ends: &[[(i128, [f64; 3]); 2]]) -> Patches {
        let positions = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(|[x, y]| DVec3::new(x, y, 0.0)).to_vec();
        let mesh = SurfaceMesh::new(positions, vec![[0, 1, 2], [0, 2, 3]], None).expect("a square");
        let options = Options { filter: Filter::Geodesic, ..Options::default() };
        let line = |ends: &[(i128, [f64; 3]); 2]| {
            let picks = ends.map(|(triangle, barycentric)| Pick::Point { triangle, barycentric });
            polyline(&mesh, &picks, &options, &mut NoObserver).expect("a line")
        };
        let lines: Vec<_> = ends.iter().map(line).collect();
        let embedding = Embedding::new(&mesh, &lines.iter().collect::<Vec<_>>(), 1e-3).expect("a cut");
        find_patches(&mesh, &embedding, &embedding.triangles(&mesh).triangles)
    }

    #[test]
    fn a_square_without_lines_is_one_disc() {
        let found = patches_of(&[]);
        assert_eq!(found.patches, [Patch { triangles: 2, area: 1.0, sides: 1, loops: 1, euler: 1 }]);
    }

    #[test]
    fn two_crossing_lines_make_four_discs_of_three_sides() {
        // Along the bottom's middle to the top's, and left to right, straight through the diagonal.
        let found =
            patches_of(&[[(0, [0.5, 0.5, 0.0]), (1, [0.0, 0.5, 0.5])], [(1, [0.4, 0.0, 0.6]), (0, [0.0, 0.4, 0.6])]]);
        assert_eq!(found.patches.len(), 4);
        assert!(found.patches.iter().all(|patch| (patch.sides, patch.loops, patch.euler) == (3, 1, 1)));
        assert_eq!(found.neighbours.len(), 4);
        assert!((found.patches.iter().map(|patch| patch.area).sum::<f64>() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_line_that_ends_inside_parts_nothing() {
        let found = patches_of(&[[(0, [0.5, 0.5, 0.0]), (1, [0.2, 0.3, 0.5])]]);
        assert_eq!(found.patches.len(), 1);
        assert_eq!(found.neighbours, [[0, 0]]);
        assert_eq!((found.patches[0].loops, found.patches[0].euler), (1, 1));
    }
}
