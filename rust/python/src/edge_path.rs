//! `EdgePath`: a path along existing edges near a line, and the method that finds it.

use std::sync::Arc;

use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use smooth_polylines_core::edge_path::{self, EdgePath};

use crate::border::run_on_lines;
use crate::errors::from_core;
use crate::frozen_arrays::{freeze_owned, freeze_vector, id_rows};
use crate::polyline::PyPolyline;

/// A path along existing edges of the mesh; made by `Polyline.edge_path`. All arrays are read-only and fresh at each access.
#[pyclass(frozen, module = "smooth_polylines", name = "EdgePath")]
pub struct PyEdgePath {
    path: EdgePath,
}

#[pymethods]
impl PyEdgePath {
    /// Vertices of the mesh in order: (k,) int32; a closed path does not repeat its first.
    #[getter]
    fn vertices(&self, py: Python<'_>) -> PyResult<Py<PyArray1<i32>>> {
        let rows = id_rows(self.path.vertices.iter().map(|v| [v.0]).collect());
        freeze_vector(py, rows.into_flattened())
    }

    /// The edges in order, each in the path's direction: (k - 1, 2) int32, or (k, 2) when closed.
    #[getter]
    fn edges(&self, py: Python<'_>) -> PyResult<Py<PyArray2<i32>>> {
        let vertices = &self.path.vertices;
        let count = if self.path.closed { vertices.len() } else { vertices.len() - 1 };
        let edge = |i: usize| [vertices[i].0, vertices[(i + 1) % vertices.len()].0];
        freeze_owned(py, id_rows((0..count).map(edge).collect()))
    }

    /// Whether the last vertex is joined to the first: a bool.
    #[getter]
    fn closed(&self) -> bool {
        self.path.closed
    }

    /// How far the path is from the line: a dict of floats with keys max and mean, in the units of the positions.
    #[getter]
    fn distance<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        dict.set_item("max", self.path.max_distance)?;
        dict.set_item("mean", self.path.mean_distance)?;
        Ok(dict)
    }

    fn __len__(&self) -> usize {
        self.path.vertices.len()
    }

    fn __repr__(&self) -> String {
        let count = self.path.vertices.len();
        format!(
            "<EdgePath: {count} {}, {}, at most {:.6} from the line>",
            if count == 1 { "vertex" } else { "vertices" },
            if self.path.closed { "closed" } else { "open" },
            self.path.max_distance
        )
    }
}

#[pymethods]
impl PyPolyline {
    /// The path along existing edges that lies nearest to this line: an EdgePath.
    ///
    /// Of all paths in the line's strip and the ring of triangles round it, it has the least integral of the distance from
    /// the line, so there are no stairs where edges run straight along the line. It passes every obstacle on the line's
    /// side. Where the mesh has `triangle_faces`, only edges of polygons are used. It begins and ends at the nearest
    /// vertices of the polygons that the line begins and ends in. Cost: n log n in the triangles near the line.
    ///
    /// Raises
    /// ------
    /// OptionError
    ///     There is no such path: boundaries or walls part the edges near the line.
    ///
    /// Examples
    /// --------
    /// >>> import numpy as np, smooth_polylines as sp
    /// >>> square = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    /// >>> line = sp.SurfaceMesh(square, [[0, 1, 2], [0, 2, 3]]).polyline([(0, [0.8, 0.2, 0]), (1, [0, 0.9, 0.1])])
    /// >>> line.edge_path().vertices
    /// array([0, 2], dtype=int32)
    fn edge_path(&self, py: Python<'_>) -> PyResult<PyEdgePath> {
        let mesh = Arc::clone(self.mesh());
        let path = run_on_lines(py, &[self.shared_line()], move |lines| edge_path::edge_path(&mesh, lines[0]))?
            .map_err(|error| from_core(py, error))?;
        Ok(PyEdgePath { path })
    }
}
