//! `Network`: several lines over one set of picks, each with its own result or error.

use std::sync::Arc;
use std::time::Duration;

use pyo3::exceptions::PyIndexError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use pyo3::{PyTraverseError, PyVisit};
use smooth_polylines_core::{Polyline, Result as CoreResult, SurfaceMesh};

use crate::border::{LineWatch, Seconds};
use crate::errors::from_core;
use crate::polyline::PyPolyline;
use crate::report::seconds_dict;

/// The lines of a net, one for each connection; made by `SurfaceMesh.network`.
///
/// `len(net)`, `net[i]` and iteration go over `net.lines`: a line that could not be made is None there, and
/// `net.errors` says why.
#[pyclass(frozen, module = "smooth_polylines", name = "Network")]
pub struct PyNetwork {
    lines: Py<PyList>,
    errors: Py<PyList>,
    made: usize,
    seconds: Seconds,
}

/// Each line with its own times.
pub fn with_seconds(lines: Vec<(CoreResult<Polyline>, LineWatch<'_>)>) -> Vec<(CoreResult<Polyline>, Seconds)> {
    lines.into_iter().map(|(line, watch)| (line, watch.seconds())).collect()
}

impl PyNetwork {
    /// Wraps what the core made of each connection.
    pub fn new(
        py: Python<'_>,
        mesh: &Arc<SurfaceMesh>,
        results: Vec<(CoreResult<Polyline>, Seconds)>,
        total: Duration,
    ) -> PyResult<Self> {
        let mut seconds = results.iter().fold(Seconds::default(), |sum, (_, line)| sum.plus(line));
        seconds.total = total;
        let lines = PyList::empty(py);
        let errors = PyList::empty(py);
        let mut made = 0;
        for (result, seconds) in results {
            match result {
                Ok(line) => {
                    lines.append(Py::new(py, PyPolyline::new(py, Arc::clone(mesh), line, seconds)?)?)?;
                    errors.append(py.None())?;
                    made += 1;
                }
                Err(error) => {
                    lines.append(py.None())?;
                    errors.append(from_core(py, error).into_value(py))?;
                }
            }
        }
        Ok(Self { lines: lines.unbind(), errors: errors.unbind(), made, seconds })
    }
}

#[pymethods]
impl PyNetwork {
    /// A Polyline for each connection, None where it failed: a list.
    #[getter]
    fn lines(&self, py: Python<'_>) -> Py<PyList> {
        self.lines.clone_ref(py)
    }

    /// An exception for each connection that failed, else None: a list. Nothing has been raised yet.
    #[getter]
    fn errors(&self, py: Python<'_>) -> Py<PyList> {
        self.errors.clone_ref(py)
    }

    /// Time of the whole network: a dict as in `Report.seconds`.
    ///
    /// `total` is the wall time of the call; the steps are summed over the lines, which are made side by side.
    #[getter]
    fn seconds<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        seconds_dict(py, &self.seconds)
    }

    fn __len__(&self, py: Python<'_>) -> usize {
        self.lines.bind(py).len()
    }

    fn __getitem__<'py>(&self, py: Python<'py>, index: isize) -> PyResult<Bound<'py, PyAny>> {
        let lines = self.lines.bind(py);
        let length = lines.len();
        usize::try_from(index)
            .or_else(|_| usize::try_from(index + length as isize))
            .ok()
            .filter(|&i| i < length)
            .map_or_else(
                || Err(PyIndexError::new_err(format!("connection {index} of a network of {length}"))),
                |i| lines.get_item(i),
            )
    }

    fn __iter__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        Ok(self.lines.bind(py).try_iter()?.into_any())
    }

    fn __repr__(&self, py: Python<'_>) -> String {
        let count = self.__len__(py);
        format!("<Network: {count} connections, {} lines, {} errors>", self.made, count - self.made)
    }

    // An exception that was raised holds a traceback, whose frames may hold this network.
    fn __traverse__(&self, visit: PyVisit<'_>) -> Result<(), PyTraverseError> {
        visit.call(&self.lines)?;
        visit.call(&self.errors)
    }
}
