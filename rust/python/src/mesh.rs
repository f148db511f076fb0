//! `SurfaceMesh`: arrays in, and what can be asked of a mesh. Its methods that make lines are in `mesh_lines`.

use std::borrow::Cow;
use std::sync::Arc;

use glam::DVec3;
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use pyo3::types::{PyByteArray, PyBytes};
use smooth_polylines_core::{MeshReport, Polyline, SurfaceMesh};

use crate::border::{Seconds, Watch, run_apart, run_attached, run_detached, run_on_threads};
use crate::closest_points::PyClosestPoints;
use crate::errors::{from_core, type_error};
use crate::frozen_arrays::{freeze_rows, freeze_vector, point_rows};
use crate::input_arrays::{read_positions, read_triangle_faces, read_triangles};
use crate::mesh_report::PyMeshReport;
use crate::polyline::PyPolyline;
use crate::ray_hits::PyRayHits;

/// Triangles from which on work over a whole mesh may take longer than Ctrl-C should have to wait: a million take a
/// tenth of a second to open.
const LONG_TRIANGLES: usize = 200_000;

/// A triangle mesh, opened for lines.
///
/// Parameters
/// ----------
/// positions : (V, 3) float32 or float64
///     Places of the vertices; any order, strides and byte order. Copied: later changes of the array are not seen.
/// triangles : (F, 3) of any integer type
///     Three rows of `positions` each, in any winding.
/// triangle_faces : (F,) of any integer type, optional
///     The polygon that each triangle belongs to (Blender's loop triangles). Face ids in picks are then polygon ids,
///     else triangle ids.
///
/// Edges of three or more triangles are walls that a line does not cross; `report` counts them. Immutable, so threads
/// may share one. Cost: linear in V + F; 84 bytes a triangle are kept, 40 on meshes of more than 4.2 million. The interpreter is
/// released meanwhile.
///
/// Raises
/// ------
/// TypeError
///     Wrong dtype or rank.
/// MeshError
///     An index out of range, a triangle that repeats a vertex, a vertex of a triangle that is not finite; the first
///     offender is named.
///
/// Source: G.-P. Bonneau, S. Hahmann, Smooth Polylines on Polygon Meshes (2003).
///
/// Examples
/// --------
/// >>> import numpy as np, smooth_polylines as sp
/// >>> square = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
/// >>> mesh = sp.SurfaceMesh(square, np.array([[0, 1, 2], [0, 2, 3]]))
/// >>> mesh
/// <SurfaceMesh: 4 vertices, 2 triangles, 1 part>
/// >>> mesh.polyline([0, 1]).points.round(3)
/// array([[0.667, 0.333, 0.   ],
///        [0.5  , 0.5  , 0.   ],
///        [0.333, 0.667, 0.   ]])
#[pyclass(frozen, module = "smooth_polylines", name = "SurfaceMesh")]
pub struct PySurfaceMesh {
    pub(crate) mesh: Arc<SurfaceMesh>,
}

impl PySurfaceMesh {
    fn is_long(&self) -> bool {
        self.mesh.triangles().len() >= LONG_TRIANGLES
    }

    /// Builds the boxes that searches in space need, where that takes long: it cannot be broken off.
    pub(crate) fn build_tree(&self, py: Python<'_>, watch: &mut Watch) -> PyResult<()> {
        if self.mesh.has_triangle_tree() || !self.is_long() {
            return Ok(());
        }
        let mesh = Arc::clone(&self.mesh);
        run_apart(py, watch, move || {
            mesh.triangle_tree();
        })
    }

    fn counts(&self, py: Python<'_>) -> PyResult<MeshReport> {
        if self.mesh.has_report() || !self.is_long() {
            return run_attached(py, || self.mesh.report());
        }
        let mesh = Arc::clone(&self.mesh);
        run_apart(py, &mut Watch::start(), move || mesh.report())
    }
}

#[pymethods]
impl PySurfaceMesh {
    #[new]
    #[pyo3(signature = (positions, triangles, triangle_faces=None))]
    fn new(
        py: Python<'_>,
        positions: &Bound<'_, PyAny>,
        triangles: &Bound<'_, PyAny>,
        triangle_faces: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let positions: Vec<DVec3> = read_positions("positions", positions)?.to_points()?;
        let triangles = read_triangles("triangles", triangles, positions.len())?;
        let faces =
            triangle_faces.map(|faces| read_triangle_faces("triangle_faces", faces, triangles.len())).transpose()?;
        let is_long = triangles.len() >= LONG_TRIANGLES;
        let open = || SurfaceMesh::new(positions, triangles, faces);
        let mesh = if is_long { run_apart(py, &mut Watch::start(), open)? } else { run_on_threads(py, open)? };
        let mesh = mesh.map_err(|error| from_core(py, error.into()))?;
        Ok(Self { mesh: Arc::new(mesh) })
    }

    /// The points of the surface nearest to points in space: ClosestPoints, one for each row.
    ///
    /// Parameters
    /// ----------
    /// points : (N, 3) float32 or float64
    ///     In the space of the mesh's positions.
    ///
    /// Of equally near triangles the lowest id is told. Cost: some microseconds a point, after a first call that is
    /// linear in the mesh. Source: C. Ericson, Real-Time Collision Detection (2005), section 5.1.5.
    ///
    /// Raises
    /// ------
    /// OptionError
    ///     A row that is not finite, or a mesh without triangles.
    /// TypeError
    ///     Wrong dtype or rank.
    ///
    /// Examples
    /// --------
    /// >>> import numpy as np, smooth_polylines as sp
    /// >>> square = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    /// >>> found = sp.SurfaceMesh(square, [[0, 1, 2], [0, 2, 3]]).closest_points([[0.75, 0.25, 2.0]])
    /// >>> found.surface_points, found.distances
    /// ([SurfacePoint(0, (0.25, 0.5, 0.25))], array([2.]))
    fn closest_points(&self, py: Python<'_>, points: &Bound<'_, PyAny>) -> PyResult<PyClosestPoints> {
        let mut watch = Watch::start();
        let points = read_positions("points", points)?.to_points()?;
        self.build_tree(py, &mut watch)?;
        let found = run_detached(py, || self.mesh.closest_points(&points, "points", &mut watch))?
            .map_err(|error| watch.raise(py, error))?;
        Ok(PyClosestPoints::new(Arc::clone(&self.mesh), found))
    }

    /// Where rays first meet the surface, from either side: RayHits, one for each row.
    ///
    /// Parameters
    /// ----------
    /// origins : (N, 3) float32 or float64
    ///     Where the rays begin, in the space of the mesh's positions.
    /// directions : (N, 3) float32 or float64
    ///     Where they go; any length but 0.
    ///
    /// No ray slips through an edge or a vertex; triangles without area are never met. Cost: some microseconds a ray,
    /// after a first call that is linear in the mesh. Source: S. Woop, C. Benthin, I. Wald, Watertight Ray/Triangle
    /// Intersection (2013).
    ///
    /// Raises
    /// ------
    /// OptionError
    ///     A row that is not finite, a direction of length 0, unequal counts.
    /// TypeError
    ///     Wrong dtype or rank.
    ///
    /// Examples
    /// --------
    /// >>> import numpy as np, smooth_polylines as sp
    /// >>> square = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    /// >>> mesh = sp.SurfaceMesh(square, [[0, 1, 2], [0, 2, 3]])
    /// >>> hits = mesh.ray_cast([[0.75, 0.25, 2.0], [7, 7, 7]], [[0, 0, -1], [0, 0, 1.0]])
    /// >>> hits.surface_points, hits.distances
    /// ([SurfacePoint(0, (0.25, 0.5, 0.25)), None], array([ 2., inf]))
    fn ray_cast(
        &self,
        py: Python<'_>,
        origins: &Bound<'_, PyAny>,
        directions: &Bound<'_, PyAny>,
    ) -> PyResult<PyRayHits> {
        let mut watch = Watch::start();
        let origins = read_positions("origins", origins)?.to_points()?;
        let directions = read_positions("directions", directions)?.to_points()?;
        self.build_tree(py, &mut watch)?;
        let hits = run_detached(py, || self.mesh.ray_cast(&origins, &directions, &mut watch))?
            .map_err(|error| watch.raise(py, error))?;
        Ok(PyRayHits::new(Arc::clone(&self.mesh), hits))
    }

    /// The line that `Polyline.to_bytes` wrote, to the bit: a Polyline.
    ///
    /// Its report holds no counters. The mesh must be the one that the line was made on.
    ///
    /// Raises
    /// ------
    /// OptionError
    ///     The bytes are no line of this mesh.
    /// TypeError
    ///     Not bytes.
    ///
    /// Examples
    /// --------
    /// >>> import numpy as np, smooth_polylines as sp
    /// >>> square = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    /// >>> mesh = sp.SurfaceMesh(square, [[0, 1, 2], [0, 2, 3]])
    /// >>> line = mesh.polyline([0, 1])
    /// >>> bool((mesh.line_from_bytes(line.to_bytes()).points == line.points).all())
    /// True
    fn line_from_bytes(&self, py: Python<'_>, data: &Bound<'_, PyAny>) -> PyResult<PyPolyline> {
        let bytes: Cow<'_, [u8]> = if let Ok(bytes) = data.cast::<PyBytes>() {
            bytes.as_bytes().into()
        } else if let Ok(bytes) = data.cast::<PyByteArray>() {
            bytes.to_vec().into()
        } else {
            return Err(type_error("data", format_args!("found {}, expected bytes", data.get_type().name()?)));
        };
        let line = run_attached(py, || Polyline::from_bytes(&self.mesh, &bytes))?
            .map_err(|error| from_core(py, error.into()))?;
        PyPolyline::new(py, Arc::clone(&self.mesh), line, Seconds::default())
    }

    /// Counts of elements and defects: a MeshReport.
    #[getter]
    fn report(&self, py: Python<'_>) -> PyResult<PyMeshReport> {
        Ok(self.counts(py)?.into())
    }

    /// The part of each triangle, (F,) int32: numbered from 0 by their first triangles, one for each of `report.parts`.
    ///
    /// No line joins two parts. A fresh array at each call; cost: linear in the triangles, the interpreter released.
    ///
    /// Examples
    /// --------
    /// >>> import numpy as np, smooth_polylines as sp
    /// >>> square = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    /// >>> two = sp.SurfaceMesh(np.concatenate([square, square + 5]), [[0, 1, 2], [4, 5, 6], [0, 2, 3]])
    /// >>> two.triangle_parts()
    /// array([0, 1, 0], dtype=int32)
    fn triangle_parts(&self, py: Python<'_>) -> PyResult<Py<PyArray1<i32>>> {
        let labels = run_detached(py, || self.mesh.adjacency().label_parts())?;
        let as_numpy = |label| i32::try_from(label).expect("the core refuses meshes of 2^31 triangles");
        freeze_vector(py, labels.into_iter().map(as_numpy).collect())
    }

    /// Places of the vertices: a fresh, read-only (V, 3) float64 array at each access.
    #[getter]
    fn positions(&self, py: Python<'_>) -> PyResult<Py<PyArray2<f64>>> {
        freeze_rows(py, &point_rows(run_attached(py, || self.mesh.positions())?))
    }

    /// Corners of the triangles: a fresh, read-only (F, 3) uint32 array at each access.
    #[getter]
    fn triangles(&self, py: Python<'_>) -> PyResult<Py<PyArray2<u32>>> {
        freeze_rows(py, run_attached(py, || self.mesh.triangles())?)
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let counts = self.counts(py)?;
        let plural = |count: usize, noun: &str| match noun.strip_suffix("ex") {
            _ if count == 1 => format!("1 {noun}"),
            Some(stem) => format!("{count} {stem}ices"),
            None => format!("{count} {noun}s"),
        };
        Ok(format!(
            "<SurfaceMesh: {}, {}, {}>",
            plural(counts.vertices, "vertex"),
            plural(counts.triangles, "triangle"),
            plural(counts.parts, "part")
        ))
    }
}
