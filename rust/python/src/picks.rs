//! Picks as Python gives them: face ids, (triangle, barycentric) pairs and surface points, mixed.
//!
//! Types are judged here, ids and weights by the core.

use numpy::{PyArrayDescrMethods, PyUntypedArray, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyByteArray, PyBytes, PyList, PySequence, PyString, PyTuple};
use smooth_polylines_core::Pick;

use crate::errors::{option_error, type_error};
use crate::input_arrays::read_ids;
use crate::line_options::{Integer, read_integer};
use crate::surface_point::PySurfacePoint;

const EXPECTED: &str =
    "a sequence of face ids, of (triangle id, (b0, b1, b2)) pairs, of smooth_polylines.SurfacePoint, or of these mixed";

/// All picks, in order; messages call them `argument`.
pub fn read_picks(argument: &'static str, value: &Bound<'_, PyAny>) -> PyResult<Vec<Pick>> {
    if let Ok(list) = value.cast_exact::<PyList>() {
        return list.iter().enumerate().map(|(place, item)| read_pick(argument, place, &item)).collect();
    }
    // An array of objects may hold picks of every kind, so it is read item by item.
    if let Ok(array) = value.cast::<PyUntypedArray>() {
        if array.dtype().kind() != b'O' {
            return Ok(read_ids(argument, array)?.into_iter().map(Pick::Face).collect());
        }
    }
    let items = sequence_items(argument, value, EXPECTED)?;
    items.iter().enumerate().map(|(place, item)| read_pick(argument, place, item)).collect()
}

fn read_pick(argument: &'static str, place: usize, item: &Bound<'_, PyAny>) -> PyResult<Pick> {
    if let Ok(point) = item.cast::<PySurfacePoint>() {
        return Ok(point.get().to_pick());
    }
    let refuse = |found: &str| type_error(argument, format_args!("entry {place} is {found}, expected {EXPECTED}"));
    match read_integer(item)? {
        Integer::Fits(face) => return Ok(Pick::Face(face)),
        Integer::TooWide => return Err(refuse_wide(item.py(), argument, place)),
        Integer::No => {}
    }
    if item.is_instance_of::<PyTuple>() || item.is_instance_of::<PyList>() {
        if item.len()? != 2 {
            return Err(refuse(&format!("a sequence of {} values", item.len()?)));
        }
        let id = item.get_item(0)?;
        let triangle = match read_integer(&id)? {
            Integer::Fits(triangle) => triangle,
            Integer::TooWide => return Err(refuse_wide(item.py(), argument, place)),
            Integer::No => {
                return Err(refuse(&format!("a pair whose triangle id is of type {}", id.get_type().name()?)));
            }
        };
        let barycentric = read_barycentric(&item.get_item(1)?)
            .ok_or_else(|| refuse("a pair whose second value is not three numbers"))?;
        return Ok(Pick::Point { triangle, barycentric });
    }
    Err(refuse(&format!("of type {}", item.get_type().name()?)))
}

fn refuse_wide(py: Python<'_>, argument: &'static str, place: usize) -> PyErr {
    let noun = if argument == "picks" { "pick" } else { "point" };
    option_error(
        py,
        argument,
        format!("{noun} {place} is an integer of more than 127 bits, expected an id of the mesh"),
    )
}

/// Three numbers out of a list, a tuple or an array.
pub fn read_barycentric(value: &Bound<'_, PyAny>) -> Option<[f64; 3]> {
    if value.cast::<PyString>().is_ok() || value.len().ok()? != 3 {
        return None;
    }
    let mut weights = [0.0; 3];
    for (k, weight) in weights.iter_mut().enumerate() {
        *weight = value.get_item(k).ok()?.extract().ok()?;
    }
    Some(weights)
}

/// The items of a list, a tuple, an array or another sequence. Text, sets and iterators are none: they have no order
/// that can be told, or could be read only once.
pub fn sequence_items<'py>(
    argument: &str,
    value: &Bound<'py, PyAny>,
    expected: &str,
) -> PyResult<Vec<Bound<'py, PyAny>>> {
    let is_text =
        value.cast::<PyString>().is_ok() || value.cast::<PyBytes>().is_ok() || value.cast::<PyByteArray>().is_ok();
    let is_sequence = match value.cast::<PyUntypedArray>() {
        Ok(array) => array.ndim() == 1,
        Err(_) => value.cast::<PySequence>().is_ok(),
    };
    if is_text || !is_sequence {
        return Err(type_error(argument, format_args!("found {}, expected {expected}", value.get_type().name()?)));
    }
    value.try_iter()?.collect()
}
