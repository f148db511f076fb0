//! `Polyline`: a line on a mesh, as arrays.

use std::sync::Arc;

use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyBytes, PyFloat};
use smooth_polylines_core::{Kept, Made, Polyline, SurfaceMesh};

use crate::border::{Seconds, run_attached};
use crate::errors::option_error;
use crate::frozen_arrays::{freeze_rows, freeze_vector, point_rows, rows_to_array, triangle_rows};
use crate::input_arrays::read_positions;
use crate::report::PyReport;

/// A line that lies exactly on the surface of its mesh; made by `SurfaceMesh.polyline`.
///
/// Its points are the start, the crossings of mesh edges, the points of pinned picks, and the end. All arrays are
/// read-only, made when first asked for and then kept: asking again gives the same array. Triangle ids are rows of the
/// mesh's `triangles`, as int32.
///
/// Source: G.-P. Bonneau, S. Hahmann, Smooth Polylines on Polygon Meshes (2003).
#[pyclass(frozen, module = "smooth_polylines", name = "Polyline")]
pub struct PyPolyline {
    mesh: Arc<SurfaceMesh>,
    line: Arc<Polyline>,
    /// For the line with other picks; none of a line that was not made from picks alone.
    kept: Option<Kept>,
    report: Py<PyReport>,
    points: PyOnceLock<Py<PyArray2<f64>>>,
    triangles: PyOnceLock<Py<PyArray1<i32>>>,
    barycentric: PyOnceLock<Py<PyArray2<f64>>>,
    segment_triangles: PyOnceLock<Py<PyArray1<i32>>>,
    strip: PyOnceLock<Py<PyArray1<i32>>>,
    strip_bits: PyOnceLock<Py<PyArray1<bool>>>,
}

impl PyPolyline {
    /// Takes over a finished line.
    pub fn new(py: Python<'_>, mesh: Arc<SurfaceMesh>, line: Polyline, seconds: Seconds) -> PyResult<Self> {
        Self::take_over(py, mesh, line, None, seconds)
    }

    /// Takes over a finished line and what it keeps.
    pub fn new_kept(py: Python<'_>, mesh: Arc<SurfaceMesh>, made: Made, seconds: Seconds) -> PyResult<Self> {
        Self::take_over(py, mesh, made.line, Some(made.kept), seconds)
    }

    fn take_over(
        py: Python<'_>,
        mesh: Arc<SurfaceMesh>,
        mut line: Polyline,
        kept: Option<Kept>,
        seconds: Seconds,
    ) -> PyResult<Self> {
        let report = Py::new(py, PyReport::new(std::mem::take(&mut line.report), seconds))?;
        Ok(Self {
            mesh,
            line: Arc::new(line),
            kept,
            report,
            points: PyOnceLock::new(),
            triangles: PyOnceLock::new(),
            barycentric: PyOnceLock::new(),
            segment_triangles: PyOnceLock::new(),
            strip: PyOnceLock::new(),
            strip_bits: PyOnceLock::new(),
        })
    }

    /// The mesh that the line was made on.
    pub fn mesh(&self) -> &Arc<SurfaceMesh> {
        &self.mesh
    }

    /// The line itself.
    pub fn line(&self) -> &Polyline {
        &self.line
    }

    /// The line, for work that may outlive the call.
    pub fn shared_line(&self) -> Arc<Polyline> {
        Arc::clone(&self.line)
    }

    /// What it keeps for the line with other picks.
    pub fn kept(&self) -> Option<&Kept> {
        self.kept.as_ref()
    }
}

#[pymethods]
impl PyPolyline {
    /// Places of the points, in order: (n, 3) float64, in the space and units of the mesh's positions.
    ///
    /// A closed line does not repeat its first point. Equal to the bit to `(b0*p0 + b1*p1) + b2*p2` in float64, with
    /// `triangles` and `barycentric`.
    #[getter]
    fn points(&self, py: Python<'_>) -> PyResult<Py<PyArray2<f64>>> {
        let make = || freeze_rows(py, &point_rows(&self.line.points));
        Ok(self.points.get_or_try_init(py, make)?.clone_ref(py))
    }

    /// A triangle that holds each point: (n,) int32.
    #[getter]
    fn triangles(&self, py: Python<'_>) -> PyResult<Py<PyArray1<i32>>> {
        let make = || {
            let ids: Vec<_> = self.line.surface_points.iter().map(|point| point.triangle).collect();
            freeze_vector(py, triangle_rows(&ids))
        };
        Ok(self.triangles.get_or_try_init(py, make)?.clone_ref(py))
    }

    /// The point inside its triangle: (n, 3) float64; one exact zero on an edge, two on a mesh vertex.
    #[getter]
    fn barycentric(&self, py: Python<'_>) -> PyResult<Py<PyArray2<f64>>> {
        let make = || {
            let rows: Vec<_> = self.line.surface_points.iter().map(|point| point.barycentric).collect();
            freeze_rows(py, &rows)
        };
        Ok(self.barycentric.get_or_try_init(py, make)?.clone_ref(py))
    }

    /// The triangle that holds segment i whole: (n-1,) int32, or (n,) when closed.
    #[getter]
    fn segment_triangles(&self, py: Python<'_>) -> PyResult<Py<PyArray1<i32>>> {
        let make = || freeze_vector(py, triangle_rows(&self.line.segment_triangles));
        Ok(self.segment_triangles.get_or_try_init(py, make)?.clone_ref(py))
    }

    /// The strip, from the first pick's triangle to the last pick's: (s,) int32.
    ///
    /// Step B's strip for `filter="none"`, else the final one.
    #[getter]
    fn strip(&self, py: Python<'_>) -> PyResult<Py<PyArray1<i32>>> {
        let make = || freeze_vector(py, triangle_rows(&self.line.strip));
        Ok(self.strip.get_or_try_init(py, make)?.clone_ref(py))
    }

    /// The strip's compact form: one bool a step; with the first triangle it gives the strip again.
    #[getter]
    fn strip_bits(&self, py: Python<'_>) -> PyResult<Py<PyArray1<bool>>> {
        let make = || freeze_vector(py, run_attached(py, || self.line.strip_bits(&self.mesh))?);
        Ok(self.strip_bits.get_or_try_init(py, make)?.clone_ref(py))
    }

    /// Length along the line, the closing segment included: a float in the units of the positions.
    #[getter]
    fn length(&self, py: Python<'_>) -> PyResult<f64> {
        run_attached(py, || self.line.length())
    }

    /// Whether the last point joins the first: a bool.
    #[getter]
    fn closed(&self) -> bool {
        self.line.closed
    }

    /// What happened while the line was made: a Report.
    #[getter]
    fn report(&self, py: Python<'_>) -> Py<PyReport> {
        self.report.clone_ref(py)
    }

    /// The whole line as bytes; `mesh.line_from_bytes` gives it back to the bit.
    ///
    /// First triangle, one bit a step, one parameter a crossing. The mesh is not contained.
    fn to_bytes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        Ok(PyBytes::new(py, &run_attached(py, || self.line.to_bytes(&self.mesh))?))
    }

    /// The same line on moved vertices: a fresh (n, 3) float64 array.
    ///
    /// Parameters
    /// ----------
    /// new_positions : (V, 3) float32 or float64
    ///     Where the vertices are now; as many rows as the mesh was made of. Values are not checked: a corner that is
    ///     not finite gives points that are not.
    ///
    /// With the mesh's own positions the result has the same bytes as `points`. Cost: in the points of the line,
    /// whatever the size of the mesh.
    ///
    /// Raises
    /// ------
    /// TypeError
    ///     Wrong dtype or rank.
    /// OptionError
    ///     Wrong number of rows.
    ///
    /// Examples
    /// --------
    /// >>> import numpy as np, smooth_polylines as sp
    /// >>> square = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    /// >>> line = sp.SurfaceMesh(square, [[0, 1, 2], [0, 2, 3]]).polyline([0, 1])
    /// >>> bool((line.on(2 * square) == 2 * line.points).all())
    /// True
    fn on<'py>(&self, py: Python<'py>, new_positions: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let rows = read_positions("new_positions", new_positions)?;
        let expected = self.mesh.positions().len();
        if rows.len() != expected {
            return Err(option_error(
                py,
                "new_positions",
                format!("has {} rows, expected {expected}: one for each vertex that the mesh was made of", rows.len()),
            ));
        }
        let triangles = self.mesh.triangles();
        let points = &self.line.surface_points;
        let corners = rows.gather(points.iter().map(|point| triangles[point.triangle.index()]))?;
        let moved: Vec<_> = points.iter().zip(corners).map(|(point, at)| point.position(at).to_array()).collect();
        Ok(rows_to_array(py, &moved))
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let count = self.line.points.len();
        // Python's own format: short, also for lengths that are very small or very large.
        let length = PyFloat::new(py, self.length(py)?).call_method1("__format__", (".6g",))?;
        Ok(format!(
            "<Polyline: {count} point{}, {}, length {length}, {}>",
            if count == 1 { "" } else { "s" },
            if self.line.closed { "closed" } else { "open" },
            self.report.get().stop_name()
        ))
    }
}
