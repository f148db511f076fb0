//! The points of a stroke as Python gives them: an array of places in space, or picks.
//!
//! Types are judged here, values by the core.

use numpy::{PyUntypedArray, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyList, PyTuple};
use smooth_polylines_core::stroke::StrokePoints;

use crate::input_arrays::read_positions;
use crate::picks::{read_picks, sequence_items};
use crate::surface_point::PySurfacePoint;

const EXPECTED: &str = "an (N, 3) array of places, or a sequence of picks";

/// Places where the argument is an array of two axes or a sequence of triples, else picks.
pub fn read_stroke_points(value: &Bound<'_, PyAny>) -> PyResult<StrokePoints> {
    let is_space = match value.cast::<PyUntypedArray>() {
        Ok(array) => array.ndim() != 1,
        Err(_) => match sequence_items("points", value, EXPECTED)?.first() {
            Some(first) => !is_pick(first)?,
            None => false,
        },
    };
    if is_space {
        return Ok(StrokePoints::Space(read_positions("points", value)?.to_points()?));
    }
    Ok(StrokePoints::Surface(read_picks("points", value)?))
}

/// Whether an entry can only be a pick: it has no length, or it is a pair.
fn is_pick(entry: &Bound<'_, PyAny>) -> PyResult<bool> {
    if entry.cast::<PySurfacePoint>().is_ok() {
        return Ok(true);
    }
    let is_pair = (entry.is_instance_of::<PyTuple>() || entry.is_instance_of::<PyList>()) && entry.len()? == 2;
    Ok(is_pair || entry.len().is_err())
}
