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

/// Numbers of elements that are not plain inner ones.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct AdjacencyCounts {
    /// Edges, each counted once.
    pub edges: usize,
    /// Edges of one triangle.
    pub boundary_edges: usize,
    /// Edges of three or more triangles.
    pub wall_edges: usize,
    /// See [`VertexKind::Pinched`].
    pub pinched_vertices: usize,
    /// See [`VertexKind::Unreferenced`].
    pub unreferenced_vertices: usize,
}

/// Twins and fans of a triangle mesh.
#[derive(Debug)]
pub struct Adjacency {
    twins: Vec<u32>,
    kinds: Vec<VertexKind>,
    counts: AdjacencyCounts,
}

impl Adjacency {
    /// Finds twins by counting sort over the lower end vertex, then walks the fan of every vertex once.
    ///
    /// `triangles` must hold indices below `vertex_count`, three different ones a row.
    /// Cost: O(triangles), plus sorting within vertices of high valence.
    pub fn new(triangles: &[[u32; 3]], vertex_count: usize) -> Self {
        let (twins, mut counts) = pair_halfedges(triangles, vertex_count);
        let mut adjacency = Self { twins, kinds: vec![VertexKind::Unreferenced; vertex_count], counts };
        // For each vertex one half-edge that touches it, to begin the walk round it; needed here alone.
        let mut spokes = vec![HalfedgeId(0); vertex_count];
        let mut corner_counts = vec![0u32; vertex_count];
        for (f, corners) in triangles.iter().enumerate() {
            for (c, &v) in corners.iter().enumerate() {
                corner_counts[v as usize] += 1;
                spokes[v as usize] = HalfedgeId((3 * f + c) as u32);
            }
        }
        for (v, &corner_count) in corner_counts.iter().enumerate() {
            let kind = adjacency.classify(triangles, VertexId(v as u32), spokes[v], corner_count);
            adjacency.kinds[v] = kind;
            match kind {
                VertexKind::Unreferenced => counts.unreferenced_vertices += 1,
                VertexKind::Pinched => counts.pinched_vertices += 1,
                VertexKind::Inner | VertexKind::Boundary => {}
            }
        }
        adjacency.counts = counts;
        adjacency
    }

    /// The same edge seen from the triangle on its other side; `None` at boundaries and walls.
    #[inline]
    pub fn twin(&self, halfedge: HalfedgeId) -> Option<HalfedgeId> {
        let twin = self.twins[halfedge.index()];
        (twin != NO_TWIN).then_some(HalfedgeId(twin))
    }

    /// How the triangles at a vertex lie.
    #[inline]
    pub fn kind(&self, vertex: VertexId) -> VertexKind {
        self.kinds[vertex.index()]
    }

    /// Numbers of special elements.
    pub fn counts(&self) -> AdjacencyCounts {
        self.counts
    }

    /// Parts of the mesh, where a part is what can be reached across crossable edges. Cost: O(triangles).
    pub fn count_parts(&self) -> usize {
        let triangle_count = self.twins.len() / 3;
        let mut is_seen = vec![false; triangle_count];
        let mut open = Vec::new();
        let mut parts = 0;
        for first in 0..triangle_count {
            if is_seen[first] {
                continue;
            }
            parts += 1;
            is_seen[first] = true;
            open.push(first);
            while let Some(f) = open.pop() {
                for h in TriangleId(f as u32).halfedges() {
                    if let Some(twin) = self.twin(h) {
                        let g = twin.triangle().index();
                        if !is_seen[g] {
                            is_seen[g] = true;
                            open.push(g);
                        }
                    }
                }
            }
        }
        parts
    }

    fn classify(&self, triangles: &[[u32; 3]], vertex: VertexId, first: HalfedgeId, corner_count: u32) -> VertexKind {
        if corner_count == 0 {
            return VertexKind::Unreferenced;
        }
        let mut walked = 1;
        let mut exit = first;
        while let Some(twin) = self.twin(exit) {
            exit = other_spoke(triangles, twin, vertex);
            if exit == first {
                return if walked == corner_count { VertexKind::Inner } else { VertexKind::Pinched };
            }
            walked += 1;
        }
        // The fan is open on one side: walk to its other end.
        let mut exit = other_spoke(triangles, first, vertex);
        while let Some(twin) = self.twin(exit) {
            exit = other_spoke(triangles, twin, vertex);
            walked += 1;
        }
        if walked == corner_count { VertexKind::Boundary } else { VertexKind::Pinched }
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

/// The twin table, with edges, boundaries and walls counted.
fn pair_halfedges(triangles: &[[u32; 3]], vertex_count: usize) -> (Vec<u32>, AdjacencyCounts) {
    let ends = |corners: &[u32; 3], side: usize| {
        let (a, b) = (corners[side], corners[(side + 1) % 3]);
        if a < b { (a, b) } else { (b, a) }
    };
    let mut starts = vec![0u32; vertex_count + 1];
    for corners in triangles {
        for side in 0..3 {
            starts[ends(corners, side).0 as usize + 1] += 1;
        }
    }
    for v in 0..vertex_count {
        starts[v + 1] += starts[v];
    }
    // Half-edges by lower end; each entry is (higher end, half-edge) in one word, so that sorting it orders by both.
    let mut entries = vec![0u64; 3 * triangles.len()];
    let mut cursor = starts.clone();
    for (f, corners) in triangles.iter().enumerate() {
        for side in 0..3 {
            let (low, high) = ends(corners, side);
            let slot = &mut cursor[low as usize];
            entries[*slot as usize] = (u64::from(high) << 32) | (3 * f + side) as u64;
            *slot += 1;
        }
    }
    let mut twins = vec![NO_TWIN; 3 * triangles.len()];
    let mut counts = AdjacencyCounts::default();
    for v in 0..vertex_count {
        let bucket = &mut entries[starts[v] as usize..starts[v + 1] as usize];
        bucket.sort_unstable();
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
    (twins, counts)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_triangles_of_opposite_winding_are_twins_across_their_edge() {
        for second in [[1, 3, 2], [1, 2, 3]] {
            let adjacency = Adjacency::new(&[[0, 1, 2], second], 4);
            let twin = adjacency.twin(HalfedgeId(1)).map(HalfedgeId::triangle);
            assert_eq!(twin, Some(TriangleId(1)), "winding {second:?}");
            assert_eq!(adjacency.counts().boundary_edges, 4);
            assert_eq!(adjacency.kind(VertexId(1)), VertexKind::Boundary);
        }
    }

    #[test]
    fn an_edge_of_three_triangles_is_a_wall_and_pinches_its_ends() {
        let adjacency = Adjacency::new(&[[0, 1, 2], [0, 1, 3], [0, 1, 4]], 6);
        assert_eq!(adjacency.twin(HalfedgeId(0)), None);
        let counts = adjacency.counts();
        assert_eq!((counts.wall_edges, counts.boundary_edges, counts.edges), (1, 6, 7));
        assert_eq!(adjacency.kind(VertexId(0)), VertexKind::Pinched);
        assert_eq!(adjacency.kind(VertexId(5)), VertexKind::Unreferenced);
        assert_eq!(adjacency.count_parts(), 3);
    }

    #[test]
    fn a_tetrahedron_has_inner_vertices_only_and_two_on_one_vertex_pinch_it() {
        let one = [[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]];
        let adjacency = Adjacency::new(&one, 4);
        assert!((0..4).all(|v| adjacency.kind(VertexId(v)) == VertexKind::Inner));
        let second = one.map(|t| t.map(|v| if v == 0 { 0 } else { v + 3 }));
        let both: Vec<_> = one.into_iter().chain(second).collect();
        let adjacency = Adjacency::new(&both, 7);
        assert_eq!(adjacency.kind(VertexId(0)), VertexKind::Pinched);
        assert_eq!(adjacency.counts().pinched_vertices, 1);
        assert_eq!(adjacency.count_parts(), 2);
    }
}
