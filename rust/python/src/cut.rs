//! `Cut`: a mesh with lines put into it, as arrays.

use std::sync::{Arc, OnceLock};

use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::PyList;
use smooth_polylines_core::SurfaceMesh;
use smooth_polylines_core::embed::Embedding;
use smooth_polylines_core::embed::crossings::Crossing;

use crate::border::run_detached;
use crate::frozen_arrays::{freeze_owned, freeze_vector, id_rows};

/// A mesh after lines were put into it; made by `Polyline.cut` and `SurfaceMesh.cut`.
///
/// Old vertices keep their numbers, new ones come after them. Row i of the triangles is triangle i of the mesh, or the
/// first piece of it; further pieces come after all of them, and the same holds for polygons, in the order of their face
/// ids. So every row that no line touched is as it was. All arrays are read-only, made when first asked for and then kept.
#[pyclass(frozen, module = "smooth_polylines", name = "Cut")]
pub struct PyCut {
    mesh: Arc<SurfaceMesh>,
    embedding: Embedding,
    crossings: OnceLock<Vec<Crossing>>,
    arrays: Arrays,
}

type TriangleArrays = (Py<PyArray2<i32>>, Py<PyArray1<i32>>);

/// What was asked for already.
struct Arrays {
    positions: PyOnceLock<Py<PyArray2<f64>>>,
    triangles: PyOnceLock<TriangleArrays>,
    polygons: PyOnceLock<PolygonArrays>,
}

struct PolygonArrays {
    corners: Py<PyArray1<i32>>,
    offsets: Py<PyArray1<i32>>,
    parents: Py<PyArray1<i32>>,
    of_triangles: Py<PyArray1<i32>>,
    changed: Py<PyArray1<i32>>,
}

impl Arrays {
    fn none_yet() -> Self {
        Self { positions: PyOnceLock::new(), triangles: PyOnceLock::new(), polygons: PyOnceLock::new() }
    }
}

impl PyCut {
    /// Wraps what the core made of lines of `mesh`.
    pub fn new(mesh: Arc<SurfaceMesh>, embedding: Embedding) -> Self {
        Self { mesh, embedding, crossings: OnceLock::new(), arrays: Arrays::none_yet() }
    }

    /// The mesh that was cut, and how.
    pub fn parts(&self) -> (&SurfaceMesh, &Embedding) {
        (&self.mesh, &self.embedding)
    }

    fn polygon_arrays(&self, py: Python<'_>) -> PyResult<&PolygonArrays> {
        self.arrays.polygons.get_or_try_init(py, || {
            let made = run_detached(py, || {
                let made = self.embedding.polygons(&self.mesh);
                [made.corners, made.offsets, made.parents, made.of_triangles, made.changed].map(ids)
            })?;
            let [corners, offsets, parents, of_triangles, changed] = made.map(|part| freeze_vector(py, part));
            Ok(PolygonArrays {
                corners: corners?,
                offsets: offsets?,
                parents: parents?,
                of_triangles: of_triangles?,
                changed: changed?,
            })
        })
    }

    fn crossings_of(&self, py: Python<'_>) -> PyResult<&[Crossing]> {
        let find = || {
            let mut found = self.embedding.crossings(&self.mesh);
            found.retain(|crossing| crossing.is_transversal);
            found
        };
        run_detached(py, || self.crossings.get_or_init(find).as_slice())
    }

    fn triangle_arrays(&self, py: Python<'_>) -> PyResult<&TriangleArrays> {
        self.arrays.triangles.get_or_try_init(py, || {
            let (rows, parents) = run_detached(py, || {
                let made = self.embedding.triangles(&self.mesh);
                (id_rows(made.triangles), ids(made.parents))
            })?;
            Ok((freeze_owned(py, rows)?, freeze_vector(py, parents)?))
        })
    }
}

fn ids(ids: Vec<u32>) -> Vec<i32> {
    id_rows(ids.into_iter().map(|id| [id]).collect()).into_flattened()
}

#[pymethods]
impl PyCut {
    /// Places of all vertices: (V', 3) float64, the mesh's own first, to the bit.
    #[getter]
    fn positions(&self, py: Python<'_>) -> PyResult<Py<PyArray2<f64>>> {
        let make = || {
            let place = || self.embedding.positions(&self.mesh).into_iter().map(|p| p.to_array()).collect();
            freeze_owned(py, run_detached(py, place)?)
        };
        Ok(self.arrays.positions.get_or_try_init(py, make)?.clone_ref(py))
    }

    /// For each new vertex a triangle of the mesh that holds it: (n,) int32. New vertex i has number V + i.
    #[getter]
    fn vertex_triangles(&self, py: Python<'_>) -> PyResult<Py<PyArray1<i32>>> {
        freeze_vector(py, ids(self.embedding.new.iter().map(|vertex| vertex.point.triangle.0).collect()))
    }

    /// Weights of that triangle's corners: (n, 3) float64; one exact zero on an edge.
    #[getter]
    fn vertex_barycentric(&self, py: Python<'_>) -> PyResult<Py<PyArray2<f64>>> {
        freeze_owned(py, self.embedding.new.iter().map(|vertex| vertex.point.barycentric).collect())
    }

    /// For each new vertex the old edge that it lies on, lower end first: (n, 2) int32; -1, -1 inside a polygon.
    #[getter]
    fn vertex_edges(&self, py: Python<'_>) -> PyResult<Py<PyArray2<i32>>> {
        let edge = |i| self.embedding.polygon_edge(&self.mesh, i).map_or([-1; 2], |(ends, _)| ends.map(|v| v as i32));
        freeze_owned(py, (0..self.embedding.new.len()).map(edge).collect())
    }

    /// Where on that edge, from its first end: (n,) float64, strictly between 0 and 1; NaN inside a polygon.
    #[getter]
    fn vertex_parameters(&self, py: Python<'_>) -> PyResult<Py<PyArray1<f64>>> {
        let parameter = |i| self.embedding.polygon_edge(&self.mesh, i).map_or(f64::NAN, |(_, t)| t);
        freeze_vector(py, (0..self.embedding.new.len()).map(parameter).collect())
    }

    /// Triangles after the cut: (F', 3) int32, turned as their parents are.
    #[getter]
    fn triangles(&self, py: Python<'_>) -> PyResult<Py<PyArray2<i32>>> {
        Ok(self.triangle_arrays(py)?.0.clone_ref(py))
    }

    /// The triangle of the mesh that each is a piece of, or is: (F',) int32.
    #[getter]
    fn triangle_parents(&self, py: Python<'_>) -> PyResult<Py<PyArray1<i32>>> {
        Ok(self.triangle_arrays(py)?.1.clone_ref(py))
    }

    /// The polygon after the cut that each triangle belongs to: (F',) int32.
    #[getter]
    fn triangle_polygons(&self, py: Python<'_>) -> PyResult<Py<PyArray1<i32>>> {
        Ok(self.polygon_arrays(py)?.of_triangles.clone_ref(py))
    }

    /// Corners of all polygons, one after another: (C,) int32.
    ///
    /// Polygon i has `polygon_corners[polygon_offsets[i]:polygon_offsets[i + 1]]`. Where the mesh has no `triangle_faces`
    /// they are the triangles.
    #[getter]
    fn polygon_corners(&self, py: Python<'_>) -> PyResult<Py<PyArray1<i32>>> {
        Ok(self.polygon_arrays(py)?.corners.clone_ref(py))
    }

    /// Where each polygon begins in `polygon_corners`, and at last their number: (P' + 1,) int32.
    #[getter]
    fn polygon_offsets(&self, py: Python<'_>) -> PyResult<Py<PyArray1<i32>>> {
        Ok(self.polygon_arrays(py)?.offsets.clone_ref(py))
    }

    /// The face id that each polygon is a piece of, or is: (P',) int32.
    #[getter]
    fn polygon_parents(&self, py: Python<'_>) -> PyResult<Py<PyArray1<i32>>> {
        Ok(self.polygon_arrays(py)?.parents.clone_ref(py))
    }

    /// Polygons that are not as they were, by rising number: (n,) int32. Pieces, and those with a new vertex on an edge.
    #[getter]
    fn changed_polygons(&self, py: Python<'_>) -> PyResult<Py<PyArray1<i32>>> {
        Ok(self.polygon_arrays(py)?.changed.clone_ref(py))
    }

    /// For each line the vertices along it, consecutive ones joined by an edge: a list of (k,) int32.
    ///
    /// A closed line does not repeat its first.
    #[getter]
    fn line_vertices<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        let chains = self.embedding.chains.iter();
        let arrays = chains.map(|chain| freeze_vector(py, ids(chain.iter().map(|p| p.vertex).collect())));
        PyList::new(py, arrays.collect::<PyResult<Vec<_>>>()?)
    }

    /// For each line where those vertices are on it: a list of (k,) float64: the number of the segment and how far along it.
    #[getter]
    fn line_parameters<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        let chains = self.embedding.chains.iter();
        let arrays = chains.map(|chain| freeze_vector(py, chain.iter().map(|p| p.parameter).collect()));
        PyList::new(py, arrays.collect::<PyResult<Vec<_>>>()?)
    }

    /// The edges of all lines, each once, lower end first, in order: (E, 2) int32.
    #[getter]
    fn line_edges(&self, py: Python<'_>) -> PyResult<Py<PyArray2<i32>>> {
        freeze_owned(py, id_rows(run_detached(py, || self.embedding.line_edges())?))
    }

    /// Vertices in which lines cross, each other or themselves: (n,) int32, one for each row of `crossing_lines`. Where more
    /// than two lines cross in a vertex it is told more than once.
    #[getter]
    fn crossings(&self, py: Python<'_>) -> PyResult<Py<PyArray1<i32>>> {
        freeze_vector(py, ids(self.crossings_of(py)?.iter().map(|crossing| crossing.vertex).collect()))
    }

    /// Which lines cross there: (n, 2) int32, places in `line_vertices`; twice the same where a line crosses itself.
    #[getter]
    fn crossing_lines(&self, py: Python<'_>) -> PyResult<Py<PyArray2<i32>>> {
        freeze_owned(py, id_rows(self.crossings_of(py)?.iter().map(|crossing| crossing.lines).collect()))
    }

    /// Points of the lines that were moved, to a vertex, an edge or another point: an int.
    #[getter]
    fn snapped(&self) -> usize {
        self.embedding.snapped
    }

    /// How far a vertex in `line_vertices` lies from its line at most, as a part of the sides of the triangle, were it
    /// equilateral: a float. Below `tolerance * sqrt(2) * (1 + n)`, where the line is led through n vertices inside the triangle.
    #[getter]
    fn largest_move(&self) -> f64 {
        self.embedding.largest_move
    }

    fn __repr__(&self) -> String {
        let (lines, new, cut) = (self.embedding.chains.len(), self.embedding.new.len(), self.embedding.cut.len());
        let plural = |count| if count == 1 { "" } else { "s" };
        format!(
            "<Cut: {lines} line{}, {new} new {}, {cut} triangle{} cut>",
            plural(lines),
            if new == 1 { "vertex" } else { "vertices" },
            plural(cut)
        )
    }
}
