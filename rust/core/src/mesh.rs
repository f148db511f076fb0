//! The mesh that lines are drawn on: positions, triangles, adjacency, polygons and the dual graph, checked once.
//!
//! Holds what every line on the mesh shares. Never changes after it was made, so it can be used by many threads.

use std::sync::OnceLock;

use glam::DVec3;

use crate::adjacency::{Adjacency, VertexKind, other_spoke};
use crate::cone::Cones;
use crate::dual_nodes::{KeptNodes, OnDemand, Records};
use crate::error::{MeshError, OptionError};
use crate::filter::workspace::Workspace;
use crate::ids::{HalfedgeId, TriangleId, VertexId};
use crate::mesh_arrays::{check_sizes, check_triangles};
use crate::morton::CurveOrder;
use crate::polygons::{Polygons, middle_triangle};
use crate::pool::Pool;
use crate::search::{DualGraph, KeptGraph};
use crate::shaken::Shaken;
use crate::surface_point::{Pick, SurfacePoint};
use crate::triangle_tree::TriangleTree;
use crate::window_search::WindowGraph;

/// Meshes of more triangles are kept without records for step B and without work space from search to search: less than twice
/// the memory of positions and triangles, instead of nearly four times. Below it speed counts for more.
pub const MOST_RECORDS: usize = 1 << 22;

/// What was found on a mesh when it was opened.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct MeshReport {
    /// Rows of `positions`.
    pub vertices: usize,
    /// Rows of `triangles`.
    pub triangles: usize,
    /// Different ids in `triangle_faces`; the triangles where it was not given.
    pub faces: usize,
    /// Edges, each counted once.
    pub edges: usize,
    /// Edges of one triangle.
    pub boundary_edges: usize,
    /// Edges of three or more triangles: walls that a line does not cross.
    pub wall_edges: usize,
    /// Vertices whose triangles form more than one fan: never passed over.
    pub pinched_vertices: usize,
    /// Parts that are not connected across crossable edges.
    pub parts: usize,
    /// Vertices that no triangle uses.
    pub unreferenced_vertices: usize,
    /// Triangles whose area is 0 in floating point.
    pub zero_area_triangles: usize,
}

/// A triangle mesh, ready to draw lines on.
#[derive(Debug)]
pub struct SurfaceMesh {
    positions: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    adjacency: Adjacency,
    polygons: Option<Polygons>,
    kept_graph: KeptGraph,
    /// See [`MOST_RECORDS`].
    spares_memory: bool,
    window_graph: WindowGraph,
    report: OnceLock<MeshReport>,
    triangle_tree: OnceLock<TriangleTree>,
    cones: Pool<Cones>,
    shaken: OnceLock<Box<Shaken>>,
    workspaces: Pool<Workspace>,
}

impl SurfaceMesh {
    /// A mesh of `positions` (any unit) and `triangles` (rows of `positions`, any winding).
    ///
    /// `triangle_faces`: the polygon of each triangle, for picks by face; without it a face is a triangle.
    ///
    /// # Errors
    /// The first index out of range, repeated vertex, or referenced position that is not finite; wrong sizes.
    ///
    /// Cost: O(triangles), on as many threads as there are; 84 bytes a triangle are kept where there are half as many
    /// vertices, and 16 more after the first search across the mesh, and 32 more once a large mesh was asked often (landmarks).
    /// On a mesh of more than [`MOST_RECORDS`] triangles it is 40 bytes, and searches leave nothing. The boxes that strokes and rays
    /// look through take 14 bytes more, 18 there.
    pub fn new(
        positions: Vec<DVec3>,
        triangles: Vec<[u32; 3]>,
        triangle_faces: Option<Vec<u32>>,
    ) -> Result<Self, MeshError> {
        let spares_memory = triangles.len() > MOST_RECORDS;
        Self::with_memory(positions, triangles, triangle_faces, spares_memory)
    }

    /// As [`SurfaceMesh::new`], but it is the caller who says whether to spare memory, as is done on very large meshes: lines cost
    /// the same number of steps then, but a step of step B costs more.
    ///
    /// # Errors
    /// Those of [`SurfaceMesh::new`].
    pub fn with_memory(
        positions: Vec<DVec3>,
        triangles: Vec<[u32; 3]>,
        triangle_faces: Option<Vec<u32>>,
        spares_memory: bool,
    ) -> Result<Self, MeshError> {
        check_sizes(&positions, &triangles, triangle_faces.as_deref())?;
        check_triangles(&positions, &triangles)?;
        // The three do not need each other; two threads have about the same to do.
        let (adjacency, (placed, window_graph)) = rayon::join(
            || Adjacency::new(&triangles, positions.len()),
            || {
                rayon::join(
                    || (!spares_memory).then(|| CurveOrder::new(&positions, &triangles)),
                    || WindowGraph::new(&positions, &triangles),
                )
            },
        );
        let nodes = match placed {
            Some(placed) => KeptNodes::Records(Records::new(&placed, &adjacency)),
            None => KeptNodes::OnDemand(OnDemand::default()),
        };
        let polygons = triangle_faces.map(Polygons::new);
        let (report, triangle_tree, cones) = (OnceLock::new(), OnceLock::new(), Pool::default());
        let shaken = OnceLock::new();
        Ok(Self {
            positions,
            triangles,
            adjacency,
            polygons,
            kept_graph: KeptGraph::new(nodes),
            spares_memory,
            window_graph,
            report,
            triangle_tree,
            cones,
            shaken,
            workspaces: Pool::default(),
        })
    }

    /// What was found on the mesh. The first call counts parts and looks round every vertex, at O(triangles).
    pub fn report(&self) -> MeshReport {
        *self.report.get_or_init(|| {
            let (edges, vertices) = (self.adjacency.edge_counts(), self.adjacency.count_vertices(&self.triangles));
            let is_flat = |t: &&[u32; 3]| {
                let [a, b, c] = t.map(|v| self.positions[v as usize]);
                (b - a).cross(c - a).length_squared() == 0.0
            };
            MeshReport {
                vertices: self.positions.len(),
                triangles: self.triangles.len(),
                faces: self.polygons.as_ref().map_or(self.triangles.len(), Polygons::count),
                edges: edges.edges,
                boundary_edges: edges.boundary_edges,
                wall_edges: edges.wall_edges,
                pinched_vertices: vertices.pinched,
                parts: self.adjacency.count_parts(),
                unreferenced_vertices: vertices.unreferenced,
                zero_area_triangles: self.triangles.iter().filter(is_flat).count(),
            }
        })
    }

    /// Where the vertices are.
    pub fn positions(&self) -> &[DVec3] {
        &self.positions
    }

    /// Corners of every triangle.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// Triangles by polygon, where polygons were given.
    pub fn polygons(&self) -> Option<&Polygons> {
        self.polygons.as_ref()
    }

    /// The polygon of every triangle, where it was given.
    pub fn triangle_faces(&self) -> Option<&[u32]> {
        self.polygons.as_ref().map(Polygons::faces)
    }

    /// Twins and fans.
    pub fn adjacency(&self) -> &Adjacency {
        &self.adjacency
    }

    /// The graph that step B searches.
    pub fn dual_graph(&self) -> DualGraph<'_> {
        DualGraph::new(self, &self.kept_graph)
    }

    /// Whether work space of searches, which grows with the mesh, is kept for the next one.
    pub(crate) fn keeps_work_space(&self) -> bool {
        !self.spares_memory
    }

    /// Whether the boxes round the triangles have been built.
    pub fn has_triangle_tree(&self) -> bool {
        self.triangle_tree.get().is_some()
    }

    /// Whether [`SurfaceMesh::report`] has been made.
    pub fn has_report(&self) -> bool {
        self.report.get().is_some()
    }

    /// The boxes round the triangles. The first call builds them, at O(triangles).
    pub fn triangle_tree(&self) -> &TriangleTree {
        self.triangle_tree.get_or_init(|| TriangleTree::new(self))
    }

    /// Cones that finished lines have measured: the next one need not measure them again. Empty for the first.
    pub fn take_cones(&self) -> Cones {
        self.cones.take()
    }

    /// Gives back what [`SurfaceMesh::take_cones`] gave, for the next line.
    pub fn put_back_cones(&self, cones: Cones) {
        self.cones.put_back(cones);
    }

    /// The mesh with vertices moved apart where triangles have no area. The first call makes it, at O(triangles); it is for
    /// lines that would turn for ever there.
    pub fn shaken(&self) -> &Shaken {
        self.shaken.get_or_init(|| Box::new(Shaken::new(self)))
    }

    /// What `window_search` knows of the mesh.
    pub fn window_graph(&self) -> &WindowGraph {
        &self.window_graph
    }

    /// Where a vertex is.
    #[inline]
    pub fn position(&self, vertex: VertexId) -> DVec3 {
        self.positions[vertex.index()]
    }

    /// Vertices of a triangle.
    #[inline]
    pub fn corners(&self, triangle: TriangleId) -> [VertexId; 3] {
        self.triangles[triangle.index()].map(VertexId)
    }

    /// The two ends of a half-edge, in the order of its triangle.
    #[inline]
    pub fn ends(&self, halfedge: HalfedgeId) -> [VertexId; 2] {
        let corners = &self.triangles[halfedge.triangle().index()];
        let side = halfedge.side() as usize;
        [VertexId(corners[side]), VertexId(corners[(side + 1) % 3])]
    }

    /// The end of a half-edge that is not `vertex`, which must be the other one.
    #[inline]
    pub fn other_end(&self, halfedge: HalfedgeId, vertex: VertexId) -> VertexId {
        let [a, b] = self.ends(halfedge);
        if a == vertex { b } else { a }
    }

    /// The two ends of an edge, lower id first: the direction of crossing parameters, the same from both sides.
    #[inline]
    pub fn sorted_ends(&self, halfedge: HalfedgeId) -> [VertexId; 2] {
        let [a, b] = self.ends(halfedge);
        if a < b { [a, b] } else { [b, a] }
    }

    /// The corner of a half-edge's triangle that is not on it.
    #[inline]
    pub fn apex(&self, halfedge: HalfedgeId) -> VertexId {
        VertexId(self.triangles[halfedge.triangle().index()][((halfedge.side() + 2) % 3) as usize])
    }

    /// Length of an edge.
    #[inline]
    pub fn edge_length(&self, halfedge: HalfedgeId) -> f64 {
        let [a, b] = self.ends(halfedge);
        self.position(a).distance(self.position(b))
    }

    /// Unit normal of a triangle in its own winding; zero where it has no area.
    #[inline]
    pub fn normal(&self, triangle: TriangleId) -> DVec3 {
        let [a, b, c] = self.corners(triangle).map(|v| self.position(v));
        (b - a).cross(c - a).normalize_or_zero()
    }

    /// See [`Adjacency::twin`].
    #[inline]
    pub fn twin(&self, halfedge: HalfedgeId) -> Option<HalfedgeId> {
        self.adjacency.twin(halfedge)
    }

    /// Work space of lines that were straightened on this mesh.
    pub(crate) fn workspaces(&self) -> &Pool<Workspace> {
        &self.workspaces
    }

    /// See [`other_spoke`].
    #[inline]
    pub fn other_spoke(&self, halfedge: HalfedgeId, vertex: VertexId) -> HalfedgeId {
        other_spoke(&self.triangles, halfedge, vertex)
    }

    /// Whether `vertex` is an end of `halfedge`.
    #[inline]
    pub fn touches(&self, halfedge: HalfedgeId, vertex: VertexId) -> bool {
        let [a, b] = self.ends(halfedge);
        a == vertex || b == vertex
    }

    /// Whether a line may be passed from one side of `vertex` to the other.
    #[inline]
    pub fn is_passable(&self, vertex: VertexId) -> bool {
        self.adjacency.kind(&self.triangles, vertex) == VertexKind::Inner
    }

    /// Where a surface point lies.
    #[inline]
    pub fn position_of(&self, point: &SurfacePoint) -> DVec3 {
        point.position(self.triangles[point.triangle.index()].map(|v| self.positions[v as usize]))
    }

    /// Where surface points lie when the vertices are at `positions`, which must have a row for each of the mesh's.
    pub fn positions_of(&self, points: &[SurfacePoint], positions: &[DVec3]) -> Result<Vec<DVec3>, OptionError> {
        if positions.len() != self.positions.len() {
            return Err(OptionError::new(
                "positions",
                format!(
                    "found {} rows, expected {}, one for each vertex of the mesh that the line was made on",
                    positions.len(),
                    self.positions.len()
                ),
            ));
        }
        let at = |p: &SurfacePoint| p.position(self.triangles[p.triangle.index()].map(|v| positions[v as usize]));
        Ok(points.iter().map(at).collect())
    }

    /// The surface point that pick number `pick_index` means, or what is wrong with it.
    pub fn resolve_pick(&self, pick_index: usize, pick: &Pick) -> Result<SurfacePoint, OptionError> {
        let triangle_in_range = |id: i128| {
            (0..self.triangles.len() as i128).contains(&id).then_some(TriangleId(id as u32)).ok_or_else(|| {
                OptionError::new(
                    "picks",
                    format!(
                        "pick {pick_index} is triangle {id}, but the mesh has {} triangles (0 to {}); pick one of them",
                        self.triangles.len(),
                        self.triangles.len() as i64 - 1
                    ),
                )
            })
        };
        match (*pick, &self.polygons) {
            (Pick::Point { triangle, barycentric }, _) => {
                SurfacePoint::checked(triangle_in_range(triangle)?, barycentric, "picks")
                    .map_err(|e| OptionError::new("picks", format!("pick {pick_index}: {}", e.message)))
            }
            (Pick::Face(id), None) => Ok(SurfacePoint::barycentre(triangle_in_range(id)?)),
            (Pick::Face(id), Some(polygons)) => {
                let members = u32::try_from(id).map(|face| polygons.triangles_of(face)).unwrap_or_default();
                let middle = middle_triangle(&members, &self.triangles, &self.positions);
                middle.map(SurfacePoint::barycentre).ok_or_else(|| {
                    OptionError::new(
                        "picks",
                        format!("pick {pick_index} is face {id}, which no entry of triangle_faces names; pick a face that has triangles"),
                    )
                })
            }
        }
    }
}
