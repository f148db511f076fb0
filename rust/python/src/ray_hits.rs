//! `RayHits`: where rays first meet the surface.

use std::sync::Arc;

use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use pyo3::types::PyList;
use smooth_polylines_core::SurfaceMesh;
use smooth_polylines_core::ray_cast::RayHit;

use crate::border::run_attached;
use crate::frozen_arrays::{freeze_rows, freeze_vector};
use crate::surface_point::PySurfacePoint;

/// The points where rays first meet a surface, row by row; made by `SurfaceMesh.ray_cast`.
///
/// All arrays are read-only and fresh at each access.
#[pyclass(frozen, module = "smooth_polylines", name = "RayHits")]
pub struct PyRayHits {
    mesh: Arc<SurfaceMesh>,
    hits: Vec<Option<RayHit>>,
}

impl PyRayHits {
    /// Wraps what the core found on `mesh`.
    pub fn new(mesh: Arc<SurfaceMesh>, hits: Vec<Option<RayHit>>) -> Self {
        Self { mesh, hits }
    }
}

#[pymethods]
impl PyRayHits {
    /// Places on the surface: (n, 3) float64, in the space and units of the mesh's positions; NaN where nothing is met.
    #[getter]
    fn points(&self, py: Python<'_>) -> PyResult<Py<PyArray2<f64>>> {
        let place = |hit: &Option<RayHit>| hit.map_or([f64::NAN; 3], |h| self.mesh.position_of(&h.point).to_array());
        freeze_rows(py, &run_attached(py, || self.hits.iter().map(place).collect::<Vec<_>>())?)
    }

    /// The triangle that each ray meets: (n,) int32; -1 where nothing is met.
    #[getter]
    fn triangles(&self, py: Python<'_>) -> PyResult<Py<PyArray1<i32>>> {
        let id = |hit: RayHit| i32::try_from(hit.point.triangle.0).expect("the core refuses meshes of 2^31 triangles");
        freeze_vector(py, self.hits.iter().map(|hit| hit.map_or(-1, id)).collect())
    }

    /// The point inside its triangle: (n, 3) float64; 0 where nothing is met.
    #[getter]
    fn barycentric(&self, py: Python<'_>) -> PyResult<Py<PyArray2<f64>>> {
        let weights = |hit: &Option<RayHit>| hit.map_or([0.0; 3], |h| h.point.barycentric);
        freeze_rows(py, &self.hits.iter().map(weights).collect::<Vec<_>>())
    }

    /// How far each is from the ray's origin: (n,) float64, in the units of the mesh's positions; infinite where nothing
    /// is met.
    #[getter]
    fn distances(&self, py: Python<'_>) -> PyResult<Py<PyArray1<f64>>> {
        freeze_vector(py, self.hits.iter().map(|hit| hit.map_or(f64::INFINITY, |h| h.distance)).collect())
    }

    /// The same as picks: a list of SurfacePoint, None where nothing is met.
    #[getter]
    fn surface_points<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        let pick = |hit: &Option<RayHit>| hit.map(|h| Py::new(py, PySurfacePoint::from_core(&h.point))).transpose();
        PyList::new(py, self.hits.iter().map(pick).collect::<PyResult<Vec<_>>>()?)
    }

    fn __len__(&self) -> usize {
        self.hits.len()
    }

    fn __repr__(&self) -> String {
        let met = self.hits.iter().flatten().count();
        let plural = if self.hits.len() == 1 { "" } else { "s" };
        format!("<RayHits: {} ray{plural}, {met} met the surface>", self.hits.len())
    }
}
