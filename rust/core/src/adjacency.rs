//! Which triangles meet at which edges, and how the triangles round a vertex lie.
//!
//! Built from indices alone, without looking at winding: a twin is found by its two end vertices, so inconsistent
//! and non-orientable meshes (a Moebius strip) are as good as any. Holds no positions.

use crate::ids::{HalfedgeId, TriangleId, VertexId};

/// In the twin table: nothing to cross to (a boundary or a wall).
const NO_TWIN: u32 = u32::MAX;

/// How the triangles at a vertex lie, where triangles belong together when they share a crossable edge.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum VertexKind {
    /// No triangle uses it.
    Unreferenced,
    /// One closed ring of triangles: a line may be passed over it.
    Inner,
    /// One open fan.
    Boundary,
    /// More than one fan or ring: a line is never passed over it.
    Pinched,
}

/// Numbers of edges.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct EdgeCounts {
    /// Edges, each counted once.
    pub edges: usize,
    /// Edges of one triangle.
    pub boundary_edges: usize,
    /// Edges of three or more triangles.
    pub wall_edges: usize,
}

/// Numbers of vertices that are not plain ones.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct VertexCounts {
    /// See [`VertexKind::Pinched`].
    pub pinched: usize,
    /// See [`VertexKind::Unreferenced`].
    pub unreferenced: usize,
}

/// Where to begin the walk round a vertex, and how many corners it has to find.
#[derive(Clone, Copy, Debug, Default)]
struct Spoke {
    /// A half-edge that touches the vertex; any, where there is no corner.
    halfedge: u32,
    corners: u32,
}

/// Twins and fans of a triangle mesh.
#[derive(Debug)]
pub struct Adjacency {
    twins: Vec<u32>,
    spokes: Vec<Spoke>,
    edge_counts: EdgeCounts,
}

impl Adjacency {
    /// Finds twins by counting sort over the lower end vertex.
    ///
    /// `triangles` must hold indices below `vertex_count`, three different ones a row.
    /// Cost: O(triangles), plus sorting within vertices of high valence.
    pub fn new(triangles: &[[u32; 3]], vertex_count: usize) -> Self {
        let mut spokes = vec![Spoke::default(); vertex_count];
        let mut ends = vec![0u32; vertex_count];
        for (f, &[a, b, c]) in triangles.iter().enumerate() {
            for (side, v, low) in [(0, a, a.min(b)), (1, b, b.min(c)), (2, c, c.min(a))] {
                let spoke = &mut spokes[v as usize];
                *spoke = Spoke { halfedge: (3 * f + side) as u32, corners: spoke.corners + 1 };
                ends[low as usize] += 1;
            }
        }
        let (twins, edge_counts) = pair_halfedges(triangles, ends, MOST_ENTRIES);
        Self { twins, spokes, edge_counts }
    }

    /// The same edge seen from the triangle on its other side; `None` at boundaries and walls.
    #[inline]
    pub fn twin(&self, halfedge: HalfedgeId) -> Option<HalfedgeId> {
        let twin = self.twins[halfedge.index()];
        (twin != NO_TWIN).then_some(HalfedgeId(twin))
    }

    /// How the triangles at a vertex lie. `triangles` are those that the table was made of. Cost: O(valence).
    pub fn kind(&self, triangles: &[[u32; 3]], vertex: VertexId) -> VertexKind {
        let Spoke { halfedge, corners } = self.spokes[vertex.index()];
        if corners == 0 {
            return VertexKind::Unreferenced;
        }
        let first = HalfedgeId(halfedge);
        let mut walked = 1;
        let mut exit = first;
        while let Some(twin) = self.twin(exit) {
            exit = other_spoke(triangles, twin, vertex);
            if exit == first {
                return if walked == corners { VertexKind::Inner } else { VertexKind::Pinched };
            }
            walked += 1;
        }
        // The fan is open on one side: walk to its other end.
        let mut exit = other_spoke(triangles, first, vertex);
        while let Some(twin) = self.twin(exit) {
            exit = other_spoke(triangles, twin, vertex);
            walked += 1;
        }
        if walked == corners { VertexKind::Boundary } else { VertexKind::Pinched }
    }

    /// How many triangles have a corner at `vertex`.
    #[inline]
    pub fn corners_at(&self, vertex: VertexId) -> u32 {
        self.spokes[vertex.index()].corners
    }

    /// Numbers of special edges.
    pub fn edge_counts(&self) -> EdgeCounts {
        self.edge_counts
    }

    /// Numbers of special vertices. Cost: O(triangles).
    pub fn count_vertices(&self, triangles: &[[u32; 3]]) -> VertexCounts {
        let mut counts = VertexCounts::default();
        for v in 0..self.spokes.len() {
            match self.kind(triangles, VertexId(v as u32)) {
                VertexKind::Unreferenced => counts.unreferenced += 1,
                VertexKind::Pinched => counts.pinched += 1,
                VertexKind::Inner | VertexKind::Boundary => {}
            }
        }
        counts
    }

    /// Parts of the mesh, where a part is what can be reached across crossable edges. Cost: O(triangles).
    pub fn count_parts(&self) -> usize {
        self.label_parts().iter().max().map_or(0, |&last| last as usize + 1)
    }

    /// The part of every triangle, numbered from 0 by their first triangles. Cost: O(triangles).
    pub fn label_parts(&self) -> Vec<u32> {
        const UNSEEN: u32 = u32::MAX;
        let triangle_count = self.twins.len() / 3;
        let mut labels = vec![UNSEEN; triangle_count];
        let mut open = Vec::new();
        let mut part = 0;
        for first in 0..triangle_count {
            if labels[first] != UNSEEN {
                continue;
            }
            labels[first] = part;
            open.push(first);
            while let Some(f) = open.pop() {
                for h in TriangleId(f as u32).halfedges() {
                    if let Some(twin) = self.twin(h) {
                        let g = twin.triangle().index();
                        if labels[g] == UNSEEN {
                            labels[g] = part;
                            open.push(g);
                        }
                    }
                }
            }
            part += 1;
        }
        labels
    }
}

/// The other side of `halfedge`'s triangle that touches `vertex`, which must be an end of `halfedge`.
///
/// ```text
///            v
///          / | \          walking round v: cross `halfedge`, take the twin,
///        /   |   \        then `other_spoke(twin, v)` is the next one to cross
///      /_____|_____\
///        other  halfedge
/// ```
#[inline]
pub fn other_spoke(triangles: &[[u32; 3]], halfedge: HalfedgeId, vertex: VertexId) -> HalfedgeId {
    if triangles[halfedge.triangle().index()][halfedge.side() as usize] == vertex.0 {
        halfedge.previous()
    } else {
        halfedge.next()
    }
}

/// Half-edges that are sorted at a time, at most, but for those of one vertex: of ten million triangles all at once would take as
/// much memory as positions and triangles. Up to 1.4 million triangles it is once.
const MOST_ENTRIES: usize = 1 << 22;

/// The twin table, with edges, boundaries and walls counted. `ends[v]`: half-edges whose lower end is `v`.
fn pair_halfedges(triangles: &[[u32; 3]], mut ends: Vec<u32>, most_entries: usize) -> (Vec<u32>, EdgeCounts) {
    let mut start = 0;
    for end in &mut ends {
        start += std::mem::replace(end, start);
    }
    let mut twins = vec![NO_TWIN; 3 * triangles.len()];
    let mut counts = EdgeCounts::default();
    // Half-edges by lower end, for some vertices at a time; each entry is (higher end, half-edge) in one word, so that sorting
    // it orders by both.
    let mut from = 0;
    while from < ends.len() {
        // Entries are counted from the first of these vertices.
        let start = ends[from];
        let vertices = from..from + ends[from..].partition_point(|&end| (end - start) as usize <= most_entries).max(1);
        from = vertices.end;
        let all = ends.get(from).copied().unwrap_or(3 * triangles.len() as u32);
        let mut entries = vec![0u64; (all - start) as usize];
        for (f, &[a, b, c]) in triangles.iter().enumerate() {
            for (side, v, w) in [(0, a, b), (1, b, c), (2, c, a)] {
                let low = v.min(w) as usize;
                if vertices.contains(&low) {
                    // From the start of the vertex's entries to their end.
                    let slot = &mut ends[low];
                    entries[(*slot - start) as usize] = (u64::from(v.max(w)) << 32) | (3 * f + side) as u64;
                    *slot += 1;
                }
            }
        }
        let mut first = start;
        for &end in &ends[vertices] {
            let bucket = &mut entries[(first - start) as usize..(end - start) as usize];
            first = end;
            pair_bucket(bucket, &mut twins, &mut counts);
        }
    }
    (twins, counts)
}

/// Pairs the half-edges of one lower end.
#[inline]
fn pair_bucket(bucket: &mut [u64], twins: &mut [u32], counts: &mut EdgeCounts) {
    sort_few(bucket);
    let mut rest: &[u64] = bucket;
    while let Some(&first) = rest.first() {
        let same = rest.iter().take_while(|&&e| e >> 32 == first >> 32).count();
        counts.edges += 1;
        match same {
            1 => counts.boundary_edges += 1,
            2 => {
                let (a, b) = (rest[0] as u32, rest[1] as u32);
                twins[a as usize] = b;
                twins[b as usize] = a;
            }
            _ => counts.wall_edges += 1,
        }
        rest = &rest[same..];
    }
}

/// Sorts what nearly always are a handful of entries: by insertion, without a call.
#[inline]
fn sort_few(entries: &mut [u64]) {
    /// More than this are left to the general sort; insertion takes the square of the number.
    const FEW: usize = 24;
    if entries.len() > FEW {
        return entries.sort_unstable();
    }
    for i in 1..entries.len() {
        let entry = entries[i];
        let mut place = i;
        while place > 0 && entries[place - 1] > entry {
            entries[place] = entries[place - 1];
            place -= 1;
        }
        entries[place] = entry;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pairs_are_the_same_however_many_are_sorted_at_a_time() {
        // A fan round vertex 0, the rest of a grid behind it, a wall, a boundary and vertices without triangles.
        let grid = (0..40u32).flat_map(|k| {
            let (a, b) = (k + k / 8, k + k / 8 + 9);
            [[a, a + 1, b], [a + 1, b + 1, b]]
        });
        let triangles: Vec<[u32; 3]> = grid.chain([[0, 1, 60], [60, 61, 0], [0, 63, 60]]).collect();
        let count_ends = || {
            let mut ends = vec![0; 70];
            triangles.iter().flat_map(|&[a, b, c]| [a.min(b), b.min(c), c.min(a)]).for_each(|v| ends[v as usize] += 1);
            ends
        };
        let at_once = pair_halfedges(&triangles, count_ends(), usize::MAX);
        assert!(at_once.1.wall_edges > 0 && at_once.1.boundary_edges > 0, "{:?}", at_once.1);
        for most in [0, 1, 7, 50] {
            assert_eq!(pair_halfedges(&triangles, count_ends(), most), at_once, "{most} at a time");
        }
    }

    #[test]
    fn two_triangles_of_opposite_winding_are_twins_across_their_edge() {
        for second in [[1, 3, 2], [1, 2, 3]] {
            let triangles = [[0, 1, 2], second];
            let adjacency = Adjacency::new(&triangles, 4);
            let twin = adjacency.twin(HalfedgeId(1)).map(HalfedgeId::triangle);
            assert_eq!(twin, Some(TriangleId(1)), "winding {second:?}");
            assert_eq!(adjacency.edge_counts().boundary_edges, 4);
            assert_eq!(adjacency.kind(&triangles, VertexId(1)), VertexKind::Boundary);
        }
    }

    #[test]
    fn an_edge_of_three_triangles_is_a_wall_and_pinches_its_ends() {
        let triangles = [[0, 1, 2], [0, 1, 3], [0, 1, 4]];
        let adjacency = Adjacency::new(&triangles, 6);
        assert_eq!(adjacency.twin(HalfedgeId(0)), None);
        let counts = adjacency.edge_counts();
        assert_eq!((counts.wall_edges, counts.boundary_edges, counts.edges), (1, 6, 7));
        assert_eq!(adjacency.kind(&triangles, VertexId(0)), VertexKind::Pinched);
        assert_eq!(adjacency.kind(&triangles, VertexId(5)), VertexKind::Unreferenced);
        assert_eq!(adjacency.count_vertices(&triangles), VertexCounts { pinched: 2, unreferenced: 1 });
        assert_eq!(adjacency.count_parts(), 3);
    }

    #[test]
    fn a_tetrahedron_has_inner_vertices_only_and_two_on_one_vertex_pinch_it() {
        let one = [[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]];
        let adjacency = Adjacency::new(&one, 4);
        assert!((0..4).all(|v| adjacency.kind(&one, VertexId(v)) == VertexKind::Inner));
        let second = one.map(|t| t.map(|v| if v == 0 { 0 } else { v + 3 }));
        let both: Vec<_> = one.into_iter().chain(second).collect();
        let adjacency = Adjacency::new(&both, 7);
        assert_eq!(adjacency.kind(&both, VertexId(0)), VertexKind::Pinched);
        assert_eq!(adjacency.count_vertices(&both).pinched, 1);
        assert_eq!(adjacency.count_parts(), 2);
    }
}
