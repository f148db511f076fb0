//! Arrays from the caller: dtype, rank and range are checked here, and every message names the argument.
//!
//! Whatever the order, strides, alignment or byte order, values reach the core as plain vectors in row order. The
//! `numpy` crate hands out Fortran-ordered memory as a slice without a word, so `numpy.require` normalises first.
//! Holds no check of the mesh itself.

use glam::DVec3;
use numpy::{
    Element, PyArrayDescrMethods, PyArrayDyn, PyArrayMethods, PyReadonlyArray, PyUntypedArray, PyUntypedArrayMethods,
    ndarray::IxDyn,
};
use pyo3::exceptions::PyException;
use pyo3::prelude::*;
use pyo3::types::PyString;
use smooth_polylines_core::{Error, MeshError};

use crate::errors::{from_core, type_error};

/// Positions in the caller's own precision, in row order.
pub enum Rows<'py> {
    /// float32.
    Single(PyReadonlyArray<'py, f32, IxDyn>),
    /// float64.
    Double(PyReadonlyArray<'py, f64, IxDyn>),
}

impl Rows<'_> {
    /// All rows, widened to float64.
    pub fn to_points(&self) -> PyResult<Vec<DVec3>> {
        Ok(match self {
            Self::Single(array) => {
                plain_slice(array)?.chunks_exact(3).map(|p| DVec3::new(p[0].into(), p[1].into(), p[2].into())).collect()
            }
            Self::Double(array) => plain_slice(array)?.chunks_exact(3).map(DVec3::from_slice).collect(),
        })
    }

    /// The rows that `wanted` names, widened to float64. Every id must be a row.
    pub fn gather(&self, wanted: impl Iterator<Item = [u32; 3]>) -> PyResult<Vec<[DVec3; 3]>> {
        Ok(match self {
            Self::Single(array) => {
                let values = plain_slice(array)?;
                let row = |id: u32| {
                    let start = 3 * id as usize;
                    DVec3::new(values[start].into(), values[start + 1].into(), values[start + 2].into())
                };
                wanted.map(|corners| corners.map(row)).collect()
            }
            Self::Double(array) => {
                let values = plain_slice(array)?;
                wanted.map(|corners| corners.map(|id| DVec3::from_slice(&values[3 * id as usize..]))).collect()
            }
        })
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        match self {
            Self::Single(array) => array.shape()[0],
            Self::Double(array) => array.shape()[0],
        }
    }
}

/// A `(V, 3)` array of float32 or float64.
pub fn read_positions<'py>(argument: &'static str, value: &Bound<'py, PyAny>) -> PyResult<Rows<'py>> {
    let array = as_array(argument, value)?;
    check_shape(argument, &array, &[None, Some(3)], "(V, 3): a row of x, y, z for each vertex")?;
    match (array.dtype().kind(), array.dtype().itemsize()) {
        (b'f', 4) => Ok(Rows::Single(normalise(&array)?)),
        (b'f', 8) => Ok(Rows::Double(normalise(&array)?)),
        _ => Err(refuse_dtype(argument, &array, "float32 or float64")),
    }
}

/// An `(F, 3)` array of any integer type as vertex ids below `vertices`.
pub fn read_triangles(argument: &'static str, value: &Bound<'_, PyAny>, vertices: usize) -> PyResult<Vec<[u32; 3]>> {
    let array = as_array(argument, value)?;
    check_shape(argument, &array, &[None, Some(3)], "(F, 3): a row of three vertex indices for each triangle")?;
    let py = value.py();
    read_integers(argument, &array, |triangle, index| MeshError::IndexOutOfRange { triangle, index, vertices }, {
        // Ids are 32 bits wide; a mesh of more vertices is refused by the core as too large, with its own message.
        u32::try_from(vertices).unwrap_or(u32::MAX)
    })
    .map_err(|failure| failure.raise(py))
}

/// An `(F,)` array of any integer type as face ids, one for each of the `triangles`.
pub fn read_triangle_faces(argument: &'static str, value: &Bound<'_, PyAny>, triangles: usize) -> PyResult<Vec<u32>> {
    let array = as_array(argument, value)?;
    check_shape(argument, &array, &[None], "(F,): a face id for each triangle")?;
    let py = value.py();
    if array.len() != triangles {
        return Err(from_core(py, MeshError::FaceCount { found: array.len(), expected: triangles }.into()));
    }
    read_integers(argument, &array, |triangle, face| MeshError::FaceOutOfRange { triangle, face }, u32::MAX)
        .map(Vec::<[u32; 1]>::into_flattened)
        .map_err(|failure| failure.raise(py))
}

/// An `(M, 2)` array of any integer type; values are judged by the core.
pub fn read_pairs(argument: &'static str, value: &Bound<'_, PyAny>) -> PyResult<Vec<[i128; 2]>> {
    let array = as_array(argument, value)?;
    check_shape(argument, &array, &[None, Some(2)], "(M, 2): two positions in picks for each line")?;
    Ok(read_any_integers(argument, &array)?.chunks_exact(2).map(|c| [c[0], c[1]]).collect())
}

/// A one-axis integer array as wide integers.
pub fn read_ids(argument: &'static str, array: &Bound<'_, PyUntypedArray>) -> PyResult<Vec<i128>> {
    check_shape(argument, array, &[None], "(k,): a face id for each pick")?;
    read_any_integers(argument, array)
}

/// Why integers could not be read.
enum Failure {
    Core(MeshError),
    Python(PyErr),
}

impl Failure {
    fn raise(self, py: Python<'_>) -> PyErr {
        match self {
            Self::Core(error) => from_core(py, Error::Mesh(error)),
            Self::Python(error) => error,
        }
    }
}

impl From<PyErr> for Failure {
    fn from(error: PyErr) -> Self {
        Self::Python(error)
    }
}

/// All rows of `N` values; the first value outside `0..limit` becomes `refuse(row, value)`.
fn read_integers<const N: usize>(
    argument: &str,
    array: &Bound<'_, PyUntypedArray>,
    refuse: impl Fn(usize, i128) -> MeshError,
    limit: u32,
) -> Result<Vec<[u32; N]>, Failure> {
    fn convert<const N: usize, T: Element + Copy + TryInto<u32> + Into<i128>>(
        array: &Bound<'_, PyUntypedArray>,
        refuse: impl Fn(usize, i128) -> MeshError,
        limit: u32,
    ) -> Result<Vec<[u32; N]>, Failure> {
        let array = normalise::<T>(array)?;
        let values = plain_slice(&array)?;
        let mut rows = Vec::with_capacity(values.len() / N);
        for (row, values) in values.chunks_exact(N).enumerate() {
            let mut ids = [0; N];
            for (id, &value) in ids.iter_mut().zip(values) {
                *id = match value.try_into() {
                    Ok(id) if id < limit => id,
                    _ => return Err(Failure::Core(refuse(row, value.into()))),
                };
            }
            rows.push(ids);
        }
        Ok(rows)
    }
    match (array.dtype().kind(), array.dtype().itemsize()) {
        (b'i', 1 | 2 | 4) | (b'u', 1 | 2) => convert::<N, i32>(array, refuse, limit),
        (b'u', 4) => convert::<N, u32>(array, refuse, limit),
        (b'i', 8) => convert::<N, i64>(array, refuse, limit),
        (b'u', 8) => convert::<N, u64>(array, refuse, limit),
        _ => Err(refuse_dtype(argument, array, "an integer type").into()),
    }
}

fn read_any_integers(argument: &str, array: &Bound<'_, PyUntypedArray>) -> PyResult<Vec<i128>> {
    match (array.dtype().kind(), array.dtype().itemsize()) {
        (b'u', 8) => Ok(plain_slice(&normalise::<u64>(array)?)?.iter().map(|&id| id.into()).collect()),
        (b'i' | b'u', 1 | 2 | 4 | 8) => {
            Ok(plain_slice(&normalise::<i64>(array)?)?.iter().map(|&id| id.into()).collect())
        }
        _ => Err(refuse_dtype(argument, array, "an integer type")),
    }
}

/// `value` as an array: itself, or what numpy makes of a nested sequence.
fn as_array<'py>(argument: &str, value: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyUntypedArray>> {
    if let Ok(array) = value.cast::<PyUntypedArray>() {
        return Ok(array.clone());
    }
    let py = value.py();
    if value.is_none() || value.cast::<PyString>().is_ok() {
        return Err(type_error(argument, format_args!("found {}, expected an array", value.get_type().name()?)));
    }
    let made = py.import("numpy")?.call_method1("asarray", (value,)).map_err(|cause| {
        // KeyboardInterrupt and its like are not about the argument.
        if !cause.is_instance_of::<PyException>(py) {
            return cause;
        }
        let error = type_error(argument, format_args!("cannot be read as an array ({})", cause.value(py)));
        error.set_cause(py, Some(cause));
        error
    })?;
    Ok(made.cast_into::<PyUntypedArray>()?)
}

/// `None` in `expected` stands for any length.
fn check_shape(
    argument: &str,
    array: &Bound<'_, PyUntypedArray>,
    expected: &[Option<usize>],
    told: &str,
) -> PyResult<()> {
    let shape = array.shape();
    let fits = shape.len() == expected.len()
        && shape.iter().zip(expected).all(|(found, wanted)| wanted.is_none_or(|wanted| wanted == *found));
    if fits {
        return Ok(());
    }
    let listed: Vec<String> = shape.iter().map(ToString::to_string).collect();
    let comma = if shape.len() == 1 { "," } else { "" };
    Err(type_error(argument, format_args!("has shape ({}{comma}), expected {told}", listed.join(", "))))
}

fn refuse_dtype(argument: &str, array: &Bound<'_, PyUntypedArray>, expected: &str) -> PyErr {
    type_error(argument, format_args!("has dtype {}, expected {expected}; convert it with .astype", array.dtype()))
}

/// The array as `T`, native, aligned, in row order: itself where it is so already, else a copy.
fn normalise<'py, T: Element>(array: &Bound<'py, PyUntypedArray>) -> PyResult<PyReadonlyArray<'py, T, IxDyn>> {
    let py = array.py();
    let wanted = (array, numpy::dtype::<T>(py), ("C_CONTIGUOUS", "ALIGNED", "ENSUREARRAY"));
    let made = py.import("numpy")?.call_method1("require", wanted)?;
    Ok(made.cast_into::<PyArrayDyn<T>>()?.try_readonly()?)
}

/// The values in row order.
fn plain_slice<'a, T: Element>(array: &'a PyReadonlyArray<'_, T, IxDyn>) -> PyResult<&'a [T]> {
    // `as_slice` takes Fortran order too, and then the rows are wrong.
    if !array.is_c_contiguous() {
        return Err(type_error("array", "numpy.require did not give row order"));
    }
    Ok(array.as_slice()?)
}
