//! `ClosestPoints`: where points in space come to lie on the surface.

use std::sync::Arc;

use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use pyo3::types::PyList;
use smooth_polylines_core::SurfaceMesh;
use smooth_polylines_core::closest_point::ClosestPoint;

use crate::border::run_attached;
use crate::frozen_arrays::{freeze_rows, freeze_vector, point_rows, triangle_rows};
use crate::surface_point::PySurfacePoint;

/// The points of a surface that are nearest to given points, row by row; made by `SurfaceMesh.closest_points`.
///
/// All arrays are read-only and fresh at each access.
#[pyclass(frozen, module = "smooth_polylines", name = "ClosestPoints")]
pub struct PyClosestPoints {
    mesh: Arc<SurfaceMesh>,
    found: Vec<ClosestPoint>,
}

impl PyClosestPoints {
    /// Wraps what the core found on `mesh`.
    pub fn new(mesh: Arc<SurfaceMesh>, found: Vec<ClosestPoint>) -> Self {
        Self { mesh, found }
    }
}

#[pymethods]
impl PyClosestPoints {
    /// Places on the surface: (n, 3) float64, in the space and units of the mesh's positions.
    #[getter]
    fn points(&self, py: Python<'_>) -> PyResult<Py<PyArray2<f64>>> {
        let place = |found: &ClosestPoint| self.mesh.position_of(&found.point);
        freeze_rows(py, &point_rows(&run_attached(py, || self.found.iter().map(place).collect::<Vec<_>>())?))
    }

    /// The triangle that holds each: (n,) int32; the lowest where several are equally near.
    #[getter]
    fn triangles(&self, py: Python<'_>) -> PyResult<Py<PyArray1<i32>>> {
        freeze_vector(py, triangle_rows(&self.found.iter().map(|found| found.point.triangle).collect::<Vec<_>>()))
    }

    /// The point inside its triangle: (n, 3) float64; one exact zero on an edge, two on a mesh vertex.
    #[getter]
    fn barycentric(&self, py: Python<'_>) -> PyResult<Py<PyArray2<f64>>> {
        freeze_rows(py, &self.found.iter().map(|found| found.point.barycentric).collect::<Vec<_>>())
    }

    /// How far each is from the point that was asked for: (n,) float64, in the units of the mesh's positions.
    #[getter]
    fn distances(&self, py: Python<'_>) -> PyResult<Py<PyArray1<f64>>> {
        freeze_vector(py, self.found.iter().map(|found| found.distance).collect())
    }

    /// The same as picks: a list of SurfacePoint.
    #[getter]
    fn surface_points<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        let picks: Vec<_> = self
            .found
            .iter()
            .map(|found| Py::new(py, PySurfacePoint::from_core(&found.point)))
            .collect::<PyResult<_>>()?;
        PyList::new(py, picks)
    }

    fn __len__(&self) -> usize {
        self.found.len()
    }

    fn __repr__(&self) -> String {
        let largest = self.found.iter().map(|found| found.distance).fold(0.0, f64::max);
        let plural = if self.found.len() == 1 { "" } else { "s" };
        format!("<ClosestPoints: {} point{plural}, at most {largest:.6} away>", self.found.len())
    }
}
