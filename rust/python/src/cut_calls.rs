//! The methods that put lines into a mesh, of `Polyline` and of `SurfaceMesh`.

use std::sync::Arc;

use pyo3::prelude::*;
use smooth_polylines_core::embed::{DEFAULT_TOLERANCE, Embedding};
use smooth_polylines_core::{MeshError, Polyline, SurfaceMesh};

use crate::border::run_on_lines;
use crate::cut::PyCut;
use crate::errors::{from_core, option_error, type_error};
use crate::line_options::read_tolerance;
use crate::mesh::PySurfaceMesh;
use crate::network::PyNetwork;
use crate::polyline::PyPolyline;

/// The lines in a sequence of Polyline, or of a Network, in order, each with its place there; `None` entries of a network
/// are left out.
pub fn read_lines(argument: &'static str, value: &Bound<'_, PyAny>) -> PyResult<Vec<(u32, Py<PyPolyline>)>> {
    let is_network = value.cast::<PyNetwork>().is_ok();
    let refuse = |found: &Bound<'_, PyAny>| -> PyResult<PyErr> {
        let name = found.get_type().name()?;
        Ok(type_error(argument, format_args!("found {name}, expected a sequence of Polyline, or a Network")))
    };
    if value.cast::<PyPolyline>().is_ok() {
        return Err(refuse(value)?);
    }
    let Ok(entries) = value.try_iter() else { return Err(refuse(value)?) };
    let mut lines = Vec::new();
    for (place, entry) in (0..).zip(entries) {
        let entry = entry?;
        match entry.cast_into::<PyPolyline>() {
            Ok(line) => lines.push((place, line.unbind())),
            Err(failed) => {
                let entry = failed.into_inner();
                if !(is_network && entry.is_none()) {
                    return Err(refuse(&entry)?);
                }
            }
        }
    }
    Ok(lines)
}

/// Refuses lines of other meshes.
pub fn check_lines(py: Python<'_>, mesh: &Arc<SurfaceMesh>, lines: &[(u32, Py<PyPolyline>)]) -> PyResult<()> {
    match lines.iter().find(|(_, line)| !Arc::ptr_eq(line.get().mesh(), mesh)) {
        None => Ok(()),
        Some((i, _)) => Err(option_error(
            py,
            "lines",
            format!(
                "line {i} was made on another mesh; make all lines on the SurfaceMesh that they are to be put into"
            ),
        )),
    }
}

/// Puts lines of a mesh into it.
pub fn cut(py: Python<'_>, mesh: &Arc<SurfaceMesh>, lines: &[Arc<Polyline>], tolerance: f64) -> PyResult<PyCut> {
    let on = Arc::clone(mesh);
    let embedding = run_on_lines(py, lines, move |lines| Embedding::new(&on, lines, tolerance))?
        .map_err(|error| from_core(py, error))?;
    let (found, limit) = (mesh.positions().len() + embedding.new.len(), i32::MAX as usize);
    if found > limit {
        return Err(from_core(py, MeshError::TooLarge { argument: "positions", found, limit }.into()));
    }
    Ok(PyCut::new(Arc::clone(mesh), embedding))
}

#[pymethods]
impl PyPolyline {
    /// The mesh with this line put into it: a Cut. The mesh itself does not change.
    ///
    /// Parameters
    /// ----------
    /// tolerance : float
    ///     As for `SurfaceMesh.cut`.
    ///
    /// Raises
    /// ------
    /// OptionError
    ///     `tolerance` is not from 0 to 0.25.
    /// CutError
    ///     Rounding does not let the line's own crossings be untangled.
    ///
    /// Examples
    /// --------
    /// >>> import numpy as np, smooth_polylines as sp
    /// >>> square = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    /// >>> line = sp.SurfaceMesh(square, [[0, 1, 2], [0, 2, 3]]).polyline([0, 1])
    /// >>> cut = line.cut()
    /// >>> cut
    /// <Cut: 1 line, 3 new vertices, 2 triangles cut>
    /// >>> (chain,) = cut.line_vertices
    /// >>> chain
    /// array([4, 5, 6], dtype=int32)
    #[pyo3(signature = (tolerance=DEFAULT_TOLERANCE), text_signature = "($self, tolerance=0.001)")]
    fn cut(&self, py: Python<'_>, #[pyo3(from_py_with = read_tolerance)] tolerance: f64) -> PyResult<PyCut> {
        cut(py, self.mesh(), &[self.shared_line()], tolerance)
    }
}

#[pymethods]
impl PySurfaceMesh {
    /// The mesh with lines put into it: a Cut. The mesh itself does not change.
    ///
    /// Parameters
    /// ----------
    /// lines : sequence of Polyline, or a Network
    ///     Lines of this mesh; they may cross each other and share points. What a network could not make is left out.
    /// tolerance : float
    ///     From 0 to 0.25. Points of a line that are nearer than this to a vertex or an edge are moved there, and points
    ///     that are nearer than this to each other become one: along an edge as a part of its length, inside a triangle as
    ///     a part of its heights. So no new edge is shorter than this part of an old one, crossings that lie on no mesh
    ///     edge apart, which only keep this distance from their neighbours on both lines.
    ///
    /// Cost: n log n in the points of the lines, and the square of the segments that share a triangle; the arrays of the
    /// whole mesh are made when they are asked for.
    ///
    /// Raises
    /// ------
    /// OptionError
    ///     A line of another mesh; `tolerance` out of its range.
    /// CutError
    ///     Rounding does not let crossings be untangled.
    /// TypeError
    ///     Not lines, or not a number.
    ///
    /// Examples
    /// --------
    /// >>> import numpy as np, smooth_polylines as sp
    /// >>> square = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    /// >>> mesh = sp.SurfaceMesh(square, [[0, 1, 2], [0, 2, 3]], [0, 0])
    /// >>> line = mesh.polyline([(0, [0.5, 0.5, 0]), (1, [0, 0.5, 0.5])])
    /// >>> cut = mesh.cut([line])
    /// >>> cut.polygon_corners.tolist(), cut.polygon_offsets.tolist()
    /// ([0, 4, 5, 6, 3, 1, 2, 6, 5, 4], [0, 5, 10])
    #[pyo3(signature = (lines, tolerance=DEFAULT_TOLERANCE), text_signature = "($self, lines, tolerance=0.001)")]
    fn cut(
        &self,
        py: Python<'_>,
        lines: &Bound<'_, PyAny>,
        #[pyo3(from_py_with = read_tolerance)] tolerance: f64,
    ) -> PyResult<PyCut> {
        let lines = read_lines("lines", lines)?;
        check_lines(py, &self.mesh, &lines)?;
        let lines: Vec<_> = lines.iter().map(|(_, line)| line.get().shared_line()).collect();
        cut(py, &self.mesh, &lines, tolerance)
    }
}
