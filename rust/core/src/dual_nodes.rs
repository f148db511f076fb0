//! The nodes of the dual graph: a node a triangle, with its barycentre and the nodes across its sides.
//!
//! Kept in flat records ordered along a Morton curve, so that neighbours in space are neighbours in memory; or, on meshes so
//! large that memory counts for more, read from the mesh each time. Both tell the same to the bit, but number the nodes
//! differently; [`Nodes::place`] is the same. Holds no search.

use std::sync::OnceLock;

use glam::DVec3;

use crate::adjacency::Adjacency;
use crate::ids::TriangleId;
use crate::mesh::SurfaceMesh;
use crate::morton::{CurveOrder, Frame, barycentre, curve_order};

/// No node across this side.
pub const NONE: u32 = u32::MAX;

/// The dual graph as a search walks it.
pub trait Nodes {
    /// How many there are.
    fn count(&self) -> usize;

    /// Where a node is: the barycentre of its triangle.
    fn position(&self, node: u32) -> DVec3;

    /// Nodes across sides 0, 1, 2; [`NONE`] where a line cannot cross.
    fn neighbours(&self, node: u32) -> [u32; 3];

    /// Both, for what is cheaper to look up at once.
    #[inline]
    fn position_and_neighbours(&self, node: u32) -> (DVec3, [u32; 3]) {
        (self.position(node), self.neighbours(node))
    }

    /// The node's triangle.
    fn triangle(&self, node: u32) -> TriangleId;

    /// The inverse of [`Nodes::triangle`].
    fn node(&self, triangle: TriangleId) -> u32;

    /// A number that grows along the Morton curve.
    fn place(&self, node: u32) -> u64;
}

/// What a mesh keeps of the nodes.
#[derive(Debug)]
pub enum KeptNodes {
    /// All there is to know: 44 bytes a triangle.
    Records(Records),
    /// Nothing that is not asked for.
    OnDemand(OnDemand),
}

/// What is kept of nodes that are read from the mesh, once it was asked for.
#[derive(Debug, Default)]
pub struct OnDemand {
    frame: OnceLock<Frame>,
    /// Triangles along the curve: 4 bytes each.
    order: OnceLock<Vec<u32>>,
}

impl KeptNodes {
    /// The triangle at a place of the Morton curve, counted from 0. Without records the first call sorts all triangles.
    #[inline]
    pub fn triangle_at(&self, place: usize, mesh: &SurfaceMesh) -> TriangleId {
        match self {
            Self::Records(records) => records.triangle(place as u32),
            Self::OnDemand(kept) => {
                TriangleId(kept.order.get_or_init(|| curve_order(mesh.positions(), mesh.triangles()))[place])
            }
        }
    }
}

/// One triangle as a search sees it: all it needs in one place.
#[derive(Clone, Copy, Debug)]
struct Record {
    position: DVec3,
    neighbours: [u32; 3],
    triangle: u32,
}

/// Nodes in the order of the Morton curve.
#[derive(Debug)]
pub struct Records {
    records: Vec<Record>,
    record_of: Vec<u32>,
}

impl Records {
    /// Builds the records. Cost: O(triangles).
    pub fn new(placed: &CurveOrder, adjacency: &Adjacency) -> Self {
        let CurveOrder { barycentres, order } = placed;
        let mut record_of = vec![0; order.len()];
        for (record, &triangle) in order.iter().enumerate() {
            record_of[triangle as usize] = record as u32;
        }
        // In the order of the triangles: what is read lies together then, and only the record that is written does not.
        let unset = Record { position: DVec3::ZERO, neighbours: [NONE; 3], triangle: NONE };
        let mut records = vec![unset; order.len()];
        for (triangle, (&record, &position)) in (0..).zip(record_of.iter().zip(barycentres)) {
            let neighbours = TriangleId(triangle)
                .halfedges()
                .map(|h| adjacency.twin(h).map_or(NONE, |t| record_of[t.triangle().index()]));
            records[record as usize] = Record { position, neighbours, triangle };
        }
        Self { records, record_of }
    }
}

impl Nodes for Records {
    fn count(&self) -> usize {
        self.records.len()
    }

    #[inline]
    fn position(&self, node: u32) -> DVec3 {
        self.records[node as usize].position
    }

    #[inline]
    fn neighbours(&self, node: u32) -> [u32; 3] {
        self.records[node as usize].neighbours
    }

    #[inline]
    fn position_and_neighbours(&self, node: u32) -> (DVec3, [u32; 3]) {
        let record = &self.records[node as usize];
        (record.position, record.neighbours)
    }

    #[inline]
    fn triangle(&self, node: u32) -> TriangleId {
        TriangleId(self.records[node as usize].triangle)
    }

    #[inline]
    fn node(&self, triangle: TriangleId) -> u32 {
        self.record_of[triangle.index()]
    }

    #[inline]
    fn place(&self, node: u32) -> u64 {
        node.into()
    }
}

/// Nodes read from the mesh, numbered as its triangles.
#[derive(Clone, Copy, Debug)]
pub struct MeshNodes<'a> {
    /// Whose triangles they are.
    pub mesh: &'a SurfaceMesh,
    /// What that mesh keeps of them.
    pub kept: &'a OnDemand,
}

impl Nodes for MeshNodes<'_> {
    fn count(&self) -> usize {
        self.mesh.triangles().len()
    }

    #[inline]
    fn position(&self, node: u32) -> DVec3 {
        barycentre(self.mesh.positions(), &self.mesh.triangles()[node as usize])
    }

    #[inline]
    fn neighbours(&self, node: u32) -> [u32; 3] {
        TriangleId(node).halfedges().map(|h| self.mesh.twin(h).map_or(NONE, |t| t.triangle().0))
    }

    #[inline]
    fn triangle(&self, node: u32) -> TriangleId {
        TriangleId(node)
    }

    #[inline]
    fn node(&self, triangle: TriangleId) -> u32 {
        triangle.0
    }

    fn place(&self, node: u32) -> u64 {
        let frame = self.kept.frame.get_or_init(|| Frame::of_triangles(self.mesh.positions(), self.mesh.triangles()));
        frame.key(self.position(node), node)
    }
}
