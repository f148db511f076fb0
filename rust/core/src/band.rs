//! The band round a line: its strip and the ring of triangles about it, unrolled, so that a triangle that the line comes
//! by twice is there twice and nothing that lies in the way is jumped over.
//!
//! ```text
//!        x---y---z        the strip's triangles (s), glued where the line crosses; across each other side the
//!       / \ f / \ \       triangle there (o), and round each of the strip's vertices the fan (f) between two of those
//!      / o \ / o \ \
//!     a-----b-----c
//!      \ s / \ s / \ ...
//! ```
//!
//! Where the mesh has polygons, those that the band meets are in it whole. Holds no costs.

use crate::adjacency::other_spoke;
use crate::ids::{HalfedgeId, TriangleId, VertexId};
use crate::mesh::SurfaceMesh;

/// Polygons beside the strip are completed up to this many triangles: a large cap is of no use to a path along its rim.
const MOST_OF_A_POLYGON: usize = 64;

/// A triangle in the band.
#[derive(Clone, Copy, Debug)]
pub struct BandTriangle {
    /// Which triangle of the mesh.
    pub triangle: TriangleId,
    /// The triangle of the strip that it is near, by its place.
    pub place: usize,
    /// The band's triangles across its sides.
    across: [Option<u32>; 3],
}

/// See the module.
#[derive(Debug)]
pub struct Band {
    triangles: Vec<BandTriangle>,
    /// Union-find over the corners of the band's triangles, `3 i + k`: corners that are glued are one vertex.
    roots: Vec<u32>,
    strip_length: usize,
}

impl Band {
    /// The band of a strip, whose consecutive triangles share a crossable edge.
    pub fn new(mesh: &SurfaceMesh, strip: &[TriangleId]) -> Self {
        let mut band = Self { triangles: Vec::new(), roots: Vec::new(), strip_length: strip.len() };
        for (place, &triangle) in strip.iter().enumerate() {
            band.push(triangle, place);
        }
        let crossed: Vec<Option<HalfedgeId>> = strip
            .windows(2)
            .map(|pair| {
                pair[0].halfedges().into_iter().find(|&h| mesh.twin(h).map(HalfedgeId::triangle) == Some(pair[1]))
            })
            .collect();
        for (i, letter) in crossed.iter().enumerate() {
            if let Some(h) = *letter {
                band.glue(mesh, i as u32, h, i as u32 + 1);
            }
        }
        for (place, triangle) in strip.iter().enumerate() {
            for h in triangle.halfedges() {
                band.reach(mesh, place as u32, h, place);
            }
        }
        band.close_fans(mesh, strip, &crossed);
        if mesh.triangle_faces().is_some() {
            band.complete_polygons(mesh);
        }
        band
    }

    /// All triangles; those of the strip first.
    pub fn triangles(&self) -> &[BandTriangle] {
        &self.triangles
    }

    /// The vertex of the band at a corner.
    pub fn vertex(&self, triangle: u32, corner: usize) -> u32 {
        self.root(3 * triangle + corner as u32)
    }

    /// One more than the largest vertex of the band.
    pub fn vertex_bound(&self) -> usize {
        self.roots.len()
    }

    /// The mesh's vertex that a vertex of the band lies over.
    pub fn over(&self, mesh: &SurfaceMesh, vertex: u32) -> VertexId {
        mesh.corners(self.triangles[vertex as usize / 3].triangle)[vertex as usize % 3]
    }

    /// The band's triangles across a triangle's sides.
    pub fn across(&self, triangle: u32) -> [Option<u32>; 3] {
        self.triangles[triangle as usize].across
    }

    /// The band's triangles of the polygon that `start` belongs to, as far as they hang together with it.
    pub fn polygon_of(&self, mesh: &SurfaceMesh, start: u32) -> Vec<u32> {
        let mut found = vec![start];
        let mut next = 0;
        while next < found.len() {
            let here = found[next];
            next += 1;
            for h in self.triangles[here as usize].triangle.halfedges() {
                let other = self.triangles[here as usize].across[h.side() as usize];
                if let Some(other) = other.filter(|other| !is_polygon_edge(mesh, h) && !found.contains(other)) {
                    found.push(other);
                }
            }
        }
        found
    }

    fn push(&mut self, triangle: TriangleId, place: usize) -> u32 {
        let id = self.triangles.len() as u32;
        self.triangles.push(BandTriangle { triangle, place, across: [None; 3] });
        self.roots.extend(3 * id..3 * id + 3);
        id
    }

    fn root(&self, mut corner: u32) -> u32 {
        while self.roots[corner as usize] != corner {
            corner = self.roots[corner as usize];
        }
        corner
    }

    fn unite(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        self.roots[a.max(b) as usize] = a.min(b);
    }

    /// Glues `from` to `to` across `h`, a side of `from`'s triangle whose twin is one of `to`'s.
    fn glue(&mut self, mesh: &SurfaceMesh, from: u32, h: HalfedgeId, to: u32) {
        let Some(twin) = mesh.twin(h) else { return };
        self.triangles[from as usize].across[h.side() as usize] = Some(to);
        self.triangles[to as usize].across[twin.side() as usize] = Some(from);
        for v in mesh.ends(h) {
            self.unite(self.corner(mesh, from, v), self.corner(mesh, to, v));
        }
    }

    fn corner(&self, mesh: &SurfaceMesh, triangle: u32, v: VertexId) -> u32 {
        let corners = mesh.corners(self.triangles[triangle as usize].triangle);
        3 * triangle + corners.iter().position(|&c| c == v).unwrap_or(0) as u32
    }

    /// The triangle across a side, made where there is none yet.
    fn reach(&mut self, mesh: &SurfaceMesh, from: u32, h: HalfedgeId, place: usize) -> Option<u32> {
        if let Some(there) = self.triangles[from as usize].across[h.side() as usize] {
            return Some(there);
        }
        let to = self.push(mesh.twin(h)?.triangle(), place);
        self.glue(mesh, from, h, to);
        Some(to)
    }

    /// Round each vertex of the strip, the triangles on the outside from the first triangle of the strip at it to the last.
    fn close_fans(&mut self, mesh: &SurfaceMesh, strip: &[TriangleId], crossed: &[Option<HalfedgeId>]) {
        for (first, triangle) in strip.iter().enumerate() {
            for v in mesh.corners(*triangle) {
                let goes_on = |i: usize| crossed.get(i).copied().flatten().is_some_and(|h| mesh.touches(h, v));
                if first > 0 && goes_on(first - 1) {
                    continue;
                }
                let last = (first..strip.len()).find(|&i| !goes_on(i)).unwrap_or(first);
                let spokes = |i: usize| strip[i].halfedges().into_iter().filter(|&h| mesh.touches(h, v));
                let exit = crossed.get(first).copied().flatten();
                let start = spokes(first).find(|&h| Some(h) != exit);
                let entry = last.checked_sub(1).and_then(|i| crossed[i]).and_then(|h| mesh.twin(h));
                let end = if first == last {
                    spokes(last).find(|&h| Some(h) != start)
                } else {
                    spokes(last).find(|&h| Some(h) != entry)
                };
                if let (Some(start), Some(end)) = (start, end) {
                    self.close_fan(mesh, v, (first, start), (last, end));
                }
            }
        }
    }

    /// Walks round `v` from one side of the strip to the other, outside of it; where a boundary is in the way, from both.
    fn close_fan(&mut self, mesh: &SurfaceMesh, v: VertexId, start: (usize, HalfedgeId), end: (usize, HalfedgeId)) {
        if mesh.twin(start.1) == Some(end.1) {
            return;
        }
        let ((first, start), (last, end)) = (start, end);
        if self.walk_fan(mesh, v, (first, start), Some((last, end))) {
            self.walk_fan(mesh, v, (last, end), None);
        }
    }

    /// Returns whether a boundary stopped it.
    fn walk_fan(
        &mut self,
        mesh: &SurfaceMesh,
        v: VertexId,
        (place, start): (usize, HalfedgeId),
        goal: Option<(usize, HalfedgeId)>,
    ) -> bool {
        let Some(mut here) = self.reach(mesh, place as u32, start, place) else { return true };
        let mut twin = mesh.twin(start);
        while let Some(entered) = twin {
            let spoke = other_spoke(mesh.triangles(), entered, v);
            twin = mesh.twin(spoke);
            if let Some((last, end)) = goal.filter(|(_, end)| twin == Some(*end)) {
                if let Some(there) = self.reach(mesh, last as u32, end, last) {
                    for k in 0..3 {
                        self.unite(3 * here + k, 3 * there + k);
                    }
                }
                return false;
            }
            if twin == mesh.twin(start) {
                return false;
            }
            match self.reach(mesh, here, spoke, goal.map_or(place, |(last, _)| (place + last) / 2)) {
                Some(next) => here = next,
                None => return true,
            }
        }
        true
    }

    fn complete_polygons(&mut self, mesh: &SurfaceMesh) {
        for start in 0..self.triangles.len() as u32 {
            let is_strip = (start as usize) < self.strip_length;
            let mut open = vec![start];
            let mut added = 0;
            while let Some(here) = open.pop() {
                for h in self.triangles[here as usize].triangle.halfedges() {
                    let is_open = self.triangles[here as usize].across[h.side() as usize].is_none();
                    if is_open && !is_polygon_edge(mesh, h) && (is_strip || added < MOST_OF_A_POLYGON) {
                        let place = self.triangles[here as usize].place;
                        open.extend(self.reach(mesh, here, h, place));
                        added += 1;
                    }
                }
            }
        }
    }
}

/// Whether a side of a triangle is an edge of its polygon, and not a diagonal in it.
pub fn is_polygon_edge(mesh: &SurfaceMesh, h: HalfedgeId) -> bool {
    let faces = mesh.triangle_faces().zip(mesh.twin(h));
    faces.is_none_or(|(faces, twin)| faces[h.triangle().index()] != faces[twin.triangle().index()])
}
