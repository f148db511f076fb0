//! `Crossings`: where lines meet, and the calls that find them.

use std::sync::Arc;

use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use pyo3::types::PyList;
use smooth_polylines_core::SurfaceMesh;
use smooth_polylines_core::embed::crossings::{Crossing, find_crossings as find};

use crate::border::run_on_lines;
use crate::cut_calls::{check_lines, read_lines};
use crate::errors::from_core;
use crate::frozen_arrays::{freeze_owned, freeze_vector, id_rows};
use crate::polyline::PyPolyline;
use crate::surface_point::PySurfacePoint;

/// Meetings of lines, row by row; made by `find_crossings` and `Polyline.self_crossings`.
///
/// All arrays are read-only and fresh at each access.
#[pyclass(frozen, module = "smooth_polylines", name = "Crossings")]
pub struct PyCrossings {
    /// `None` where there were no lines.
    mesh: Option<Arc<SurfaceMesh>>,
    found: Vec<Crossing>,
}

impl PyCrossings {
    /// Wraps what the core found on a mesh.
    pub fn new(mesh: Option<Arc<SurfaceMesh>>, found: Vec<Crossing>) -> Self {
        Self { mesh, found }
    }
}

#[pymethods]
impl PyCrossings {
    /// Places: (n, 3) float64, in the space and units of the mesh's positions. Of a stretch that two lines have in common,
    /// its begin along the first.
    #[getter]
    fn points(&self, py: Python<'_>) -> PyResult<Py<PyArray2<f64>>> {
        let place = |mesh: &Arc<SurfaceMesh>| {
            self.found.iter().map(|crossing| mesh.position_of(&crossing.point).to_array()).collect()
        };
        freeze_owned(py, self.mesh.as_ref().map(place).unwrap_or_default())
    }

    /// A triangle that holds each: (n,) int32.
    #[getter]
    fn triangles(&self, py: Python<'_>) -> PyResult<Py<PyArray1<i32>>> {
        freeze_vector(py, self.found.iter().map(|crossing| crossing.point.triangle.0 as i32).collect())
    }

    /// The place in its triangle: (n, 3) float64.
    #[getter]
    fn barycentric(&self, py: Python<'_>) -> PyResult<Py<PyArray2<f64>>> {
        freeze_owned(py, self.found.iter().map(|crossing| crossing.point.barycentric).collect())
    }

    /// Which lines meet, by their places in the argument: (n, 2) int32; twice the same where a line meets itself.
    #[getter]
    fn lines(&self, py: Python<'_>) -> PyResult<Py<PyArray2<i32>>> {
        freeze_owned(py, id_rows(self.found.iter().map(|crossing| crossing.lines).collect()))
    }

    /// Where on each: (n, 2) float64: the number of the segment, and after the point how far along it.
    #[getter]
    fn parameters(&self, py: Python<'_>) -> PyResult<Py<PyArray2<f64>>> {
        freeze_owned(py, self.found.iter().map(|crossing| crossing.parameters).collect())
    }

    /// Whether each line goes from one side of the other to the other side: (n,) bool. Else they touch, run along together,
    /// or one ends on the other.
    #[getter]
    fn is_transversal(&self, py: Python<'_>) -> PyResult<Py<PyArray1<bool>>> {
        freeze_vector(py, self.found.iter().map(|crossing| crossing.is_transversal).collect())
    }

    /// The same as picks: a list of SurfacePoint.
    #[getter]
    fn surface_points<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        let pick = |crossing: &Crossing| Py::new(py, PySurfacePoint::from_core(&crossing.point));
        PyList::new(py, self.found.iter().map(pick).collect::<PyResult<Vec<_>>>()?)
    }

    fn __len__(&self) -> usize {
        self.found.len()
    }

    fn __repr__(&self) -> String {
        let transversal = self.found.iter().filter(|crossing| crossing.is_transversal).count();
        let plural = if self.found.len() == 1 { "" } else { "s" };
        format!("<Crossings: {} meeting{plural}, {transversal} transversal>", self.found.len())
    }
}

/// Where lines of one mesh meet each other and themselves: Crossings.
///
/// Parameters
/// ----------
/// lines : sequence of Polyline, or a Network
///     All of one mesh. What a network could not make is left out.
///
/// The test looks at the surface, not at space, and is exact: lines that touch are told from lines that cross. Ends that
/// two lines share are no meetings. Cost: n log n in the points of the lines, and the square of the segments that share a
/// triangle.
///
/// Raises
/// ------
/// OptionError
///     Lines of different meshes.
/// TypeError
///     Not lines.
///
/// Examples
/// --------
/// >>> import numpy as np, smooth_polylines as sp
/// >>> square = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
/// >>> mesh = sp.SurfaceMesh(square, [[0, 1, 2], [0, 2, 3]])
/// >>> net = mesh.network([(0, [1, 0, 0]), (0, [0, 0, 1]), (0, [0, 1, 0]), (1, [0, 0, 1])], [[0, 1], [2, 3]])
/// >>> sp.find_crossings(net)
/// <Crossings: 1 meeting, 1 transversal>
#[pyfunction]
pub fn find_crossings(py: Python<'_>, lines: &Bound<'_, PyAny>) -> PyResult<PyCrossings> {
    let lines = read_lines("lines", lines)?;
    let Some(mesh) = lines.first().map(|(_, line)| Arc::clone(line.get().mesh())) else {
        return Ok(PyCrossings::new(None, Vec::new()));
    };
    check_lines(py, &mesh, &lines)?;
    let of_core: Vec<_> = lines.iter().map(|(_, line)| line.get().shared_line()).collect();
    let on = Arc::clone(&mesh);
    let mut found = run_on_lines(py, &of_core, move |lines| find(&on, lines))?.map_err(|error| from_core(py, error))?;
    for crossing in &mut found {
        crossing.lines = crossing.lines.map(|line| lines[line as usize].0);
    }
    Ok(PyCrossings::new(Some(mesh), found))
}

#[pymethods]
impl PyPolyline {
    /// Where this line meets itself: Crossings. See `find_crossings`.
    fn self_crossings(&self, py: Python<'_>) -> PyResult<PyCrossings> {
        let mesh = Arc::clone(self.mesh());
        let found = run_on_lines(py, &[self.shared_line()], move |lines| find(&mesh, lines))?
            .map_err(|error| from_core(py, error))?;
        Ok(PyCrossings::new(Some(Arc::clone(self.mesh())), found))
    }
}
