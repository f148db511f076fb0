//! `SurfacePoint`: a place on the surface that can be picked.

use std::hash::{DefaultHasher, Hash, Hasher};

use pyo3::prelude::*;
use pyo3::types::PyTuple;
use smooth_polylines_core::ids::TriangleId;
use smooth_polylines_core::{Pick, SurfacePoint};

use crate::errors::{from_core, option_error, type_error};
use crate::line_options::{Integer, read_integer};
use crate::picks::read_barycentric;

/// A point of the surface: a triangle and the weights of its three corners.
///
/// Parameters
/// ----------
/// triangle : int
///     Row of the `triangles` that the mesh was made of.
/// barycentric : three floats
///     Weights of that triangle's corners, no part below -1e-9, their sum 1 to within 1e-6. Kept as given; clamped and
///     normalised when a line is made.
///
/// Immutable, hashable and equal by value. The mesh is not known here, so an id beyond its triangles is refused by
/// the line.
///
/// Raises
/// ------
/// OptionError
///     The weights are no point of a triangle, or the id is negative.
/// TypeError
///     Not an integer, or not three numbers.
///
/// Examples
/// --------
/// >>> import smooth_polylines as sp
/// >>> sp.SurfacePoint(7, (0.5, 0.5, 0.0))
/// SurfacePoint(7, (0.5, 0.5, 0.0))
/// >>> sp.SurfacePoint(7, (0.5, 0.6, 0.0))  # doctest: +ELLIPSIS
/// Traceback (most recent call last):
///     ...
/// smooth_polylines.OptionError: barycentric: ... expected three parts of at least 0 with sum 1: ...
#[pyclass(frozen, module = "smooth_polylines", name = "SurfacePoint")]
pub struct PySurfacePoint {
    triangle: u32,
    barycentric: [f64; 3],
}

impl PySurfacePoint {
    /// A point that the core found.
    pub fn from_core(point: &SurfacePoint) -> Self {
        Self { triangle: point.triangle.0, barycentric: point.barycentric }
    }

    /// What the core is asked for.
    pub fn to_pick(&self) -> Pick {
        Pick::Point { triangle: self.triangle.into(), barycentric: self.barycentric }
    }
}

#[pymethods]
impl PySurfacePoint {
    #[new]
    fn new(py: Python<'_>, triangle: &Bound<'_, PyAny>, barycentric: &Bound<'_, PyAny>) -> PyResult<Self> {
        let triangle = match read_integer(triangle)? {
            Integer::Fits(id) if (0..i128::from(u32::MAX)).contains(&id) => id as u32,
            Integer::Fits(_) | Integer::TooWide => {
                return Err(option_error(py, "triangle", "expected a triangle id, from 0 to 4294967294"));
            }
            Integer::No => {
                let found = triangle.get_type().name()?;
                return Err(type_error("triangle", format_args!("found {found}, expected an integer")));
            }
        };
        let Some(weights) = read_barycentric(barycentric) else {
            let found = barycentric.get_type().name()?;
            return Err(type_error("barycentric", format_args!("found {found}, expected three numbers")));
        };
        SurfacePoint::checked(TriangleId(triangle), weights, "barycentric")
            .map_err(|error| from_core(py, error.into()))?;
        // Adding 0 turns -0 into 0, so that equal points have equal hashes.
        Ok(Self { triangle, barycentric: weights.map(|weight| weight + 0.0) })
    }

    /// Row of the mesh's `triangles`: an int.
    #[getter]
    fn triangle(&self) -> u32 {
        self.triangle
    }

    /// Weights of the triangle's corners, as given: a tuple of three floats.
    #[getter]
    fn barycentric(&self) -> (f64, f64, f64) {
        let [b0, b1, b2] = self.barycentric;
        (b0, b1, b2)
    }

    fn __eq__(&self, other: &Bound<'_, PyAny>) -> bool {
        other
            .cast::<Self>()
            .is_ok_and(|other| self.triangle == other.get().triangle && self.barycentric == other.get().barycentric)
    }

    fn __hash__(&self) -> u64 {
        let mut hasher = DefaultHasher::new();
        self.triangle.hash(&mut hasher);
        self.barycentric.map(f64::to_bits).hash(&mut hasher);
        hasher.finish()
    }

    fn __repr__(&self) -> String {
        let [b0, b1, b2] = self.barycentric;
        format!("SurfacePoint({}, ({b0:?}, {b1:?}, {b2:?}))", self.triangle)
    }

    fn __getnewargs__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        (self.triangle, self.barycentric()).into_pyobject(py)
    }
}
