//! Results as numpy arrays that cannot be written to.

use glam::DVec3;
use numpy::ndarray::Array2;
use numpy::{Element, IntoPyArray, PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use smooth_polylines_core::ids::TriangleId;

/// A read-only array of one axis.
pub fn freeze_vector<T: Element>(py: Python<'_>, values: Vec<T>) -> PyResult<Py<PyArray1<T>>> {
    let array = values.into_pyarray(py);
    array.try_readwrite()?.make_nonwriteable();
    Ok(array.unbind())
}

/// A read-only `(n, 3)` array.
pub fn freeze_rows<T: Element + Clone>(py: Python<'_>, rows: &[[T; 3]]) -> PyResult<Py<PyArray2<T>>> {
    let array = rows_to_array(py, rows);
    array.try_readwrite()?.make_nonwriteable();
    Ok(array.unbind())
}

/// A read-only array of rows, without a copy.
pub fn freeze_owned<T: Element, const N: usize>(py: Python<'_>, rows: Vec<[T; N]>) -> PyResult<Py<PyArray2<T>>> {
    let shape = (rows.len(), N);
    let array = Array2::from_shape_vec(shape, rows.into_flattened()).expect("n rows of N values").into_pyarray(py);
    array.try_readwrite()?.make_nonwriteable();
    Ok(array.unbind())
}

/// Vertex, triangle or face ids as Blender stores them. They must be below 2^31.
pub fn id_rows<const N: usize>(ids: Vec<[u32; N]>) -> Vec<[i32; N]> {
    ids.into_iter().map(|row| row.map(|id| id as i32)).collect()
}

/// A fresh `(n, 3)` array that is the caller's own.
pub fn rows_to_array<'py, T: Element + Clone>(py: Python<'py>, rows: &[[T; 3]]) -> Bound<'py, PyArray2<T>> {
    Array2::from_shape_vec((rows.len(), 3), rows.as_flattened().to_vec())
        .expect("n rows of three flatten to 3 n values")
        .into_pyarray(py)
}

/// Points as rows.
pub fn point_rows(points: &[DVec3]) -> Vec<[f64; 3]> {
    points.iter().map(|point| point.to_array()).collect()
}

/// Ids as Blender stores them: a mesh has fewer than 2^31 triangles, since its 3 F sides are numbered in 32 bits.
pub fn triangle_rows(ids: &[TriangleId]) -> Vec<i32> {
    ids.iter().map(|id| i32::try_from(id.0).expect("the core refuses meshes of 2^31 triangles")).collect()
}
