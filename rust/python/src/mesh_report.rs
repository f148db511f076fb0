//! `MeshReport`: what was found when a mesh was opened.

use pyo3::prelude::*;
use smooth_polylines_core::MeshReport;

/// Counts of a mesh's elements and defects; integers all.
#[pyclass(frozen, module = "smooth_polylines", name = "MeshReport")]
pub struct PyMeshReport {
    counts: MeshReport,
}

impl From<MeshReport> for PyMeshReport {
    fn from(counts: MeshReport) -> Self {
        Self { counts }
    }
}

#[pymethods]
impl PyMeshReport {
    /// Rows of `positions`.
    #[getter]
    fn vertices(&self) -> usize {
        self.counts.vertices
    }

    /// Rows of `triangles`.
    #[getter]
    fn triangles(&self) -> usize {
        self.counts.triangles
    }

    /// Polygons; the triangles where no `triangle_faces` were given.
    #[getter]
    fn faces(&self) -> usize {
        self.counts.faces
    }

    /// Edges of triangles.
    #[getter]
    fn edges(&self) -> usize {
        self.counts.edges
    }

    /// Edges of one triangle.
    #[getter]
    fn boundary_edges(&self) -> usize {
        self.counts.boundary_edges
    }

    /// Edges of three or more triangles: no line crosses them.
    #[getter]
    fn wall_edges(&self) -> usize {
        self.counts.wall_edges
    }

    /// Vertices where more than one fan of triangles meets: no line passes over them.
    #[getter]
    fn pinched_vertices(&self) -> usize {
        self.counts.pinched_vertices
    }

    /// Parts, where a part is what can be reached across edges of two triangles.
    #[getter]
    fn parts(&self) -> usize {
        self.counts.parts
    }

    /// Rows of `positions` that no triangle uses.
    #[getter]
    fn unreferenced_vertices(&self) -> usize {
        self.counts.unreferenced_vertices
    }

    /// Triangles without area.
    #[getter]
    fn zero_area_triangles(&self) -> usize {
        self.counts.zero_area_triangles
    }

    fn __eq__(&self, other: &Bound<'_, PyAny>) -> bool {
        other.cast::<Self>().is_ok_and(|other| self.counts == other.get().counts)
    }

    fn __repr__(&self) -> String {
        let MeshReport {
            vertices,
            triangles,
            faces,
            edges,
            boundary_edges,
            wall_edges,
            pinched_vertices,
            parts,
            unreferenced_vertices,
            zero_area_triangles,
        } = self.counts;
        format!(
            "MeshReport(vertices={vertices}, triangles={triangles}, faces={faces}, edges={edges}, \
             boundary_edges={boundary_edges}, wall_edges={wall_edges}, pinched_vertices={pinched_vertices}, \
             parts={parts}, unreferenced_vertices={unreferenced_vertices}, zero_area_triangles={zero_area_triangles})"
        )
    }
}
