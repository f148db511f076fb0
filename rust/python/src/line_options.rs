//! The keyword arguments of a line, each read by a function of its own that names it when it is wrong.
//!
//! Ranges are judged by the core; here only words, types and numbers that the core's types cannot hold.

use pyo3::exceptions::{PyOverflowError, PyTypeError};
use pyo3::prelude::*;
use pyo3::types::PyString;
use smooth_polylines_core::connections::Connections;
use smooth_polylines_core::options::{DEFAULT_SUPPORT, MAX_SUPPORT};
use smooth_polylines_core::{Filter, Knots, Pinned, Solver};

use crate::choices::{choose, refuse_word};
use crate::errors::{option_error, type_error};
use crate::input_arrays::read_pairs;
use crate::picks::sequence_items;

const FILTERS: [(&str, Filter); 5] = [
    ("linear", Filter::Linear),
    ("cubic", Filter::Cubic),
    ("geodesic", Filter::Geodesic),
    ("fair", Filter::Fair),
    ("none", Filter::None),
];
const SOLVERS: [(&str, Solver); 2] = [("auto", Solver::Auto), ("heap", Solver::Heap)];
const KNOTS: [(&str, Knots); 3] =
    [("uniform", Knots::Uniform), ("centripetal", Knots::Centripetal), ("chordal", Knots::Chordal)];
const CONNECTIONS: [(&str, Connections); 4] = [
    ("all", Connections::All),
    ("chain", Connections::Chain),
    ("loop", Connections::Loop),
    ("automatic", Connections::Automatic),
];

/// `closed`: a bool.
pub fn read_closed(value: &Bound<'_, PyAny>) -> PyResult<bool> {
    read_flag("closed", value)
}

/// `stages`: a bool.
pub fn read_stages(value: &Bound<'_, PyAny>) -> PyResult<bool> {
    read_flag("stages", value)
}

/// `filter`: one of the filters' names.
pub fn read_filter(value: &Bound<'_, PyAny>) -> PyResult<Filter> {
    choose("filter", value, &FILTERS)
}

/// `solver`: one of the solvers' names.
pub fn read_solver(value: &Bound<'_, PyAny>) -> PyResult<Solver> {
    choose("solver", value, &SOLVERS)
}

/// `knots`: one of the parametrisations' names.
pub fn read_knots(value: &Bound<'_, PyAny>) -> PyResult<Knots> {
    choose("knots", value, &KNOTS)
}

/// `threshold`: a number.
pub fn read_threshold(value: &Bound<'_, PyAny>) -> PyResult<f64> {
    read_number("threshold", value, "a number")
}

/// `detail_size`: a number or None.
pub fn read_detail_size(value: &Bound<'_, PyAny>) -> PyResult<Option<f64>> {
    if value.is_none() { Ok(None) } else { read_number("detail_size", value, "a number or None").map(Some) }
}

/// `tolerance`: a number.
pub fn read_tolerance(value: &Bound<'_, PyAny>) -> PyResult<f64> {
    read_number("tolerance", value, "a number")
}

/// `avoid_crossings`: a bool or None.
pub fn read_avoid_crossings(value: &Bound<'_, PyAny>) -> PyResult<Option<bool>> {
    if value.is_none() { Ok(None) } else { read_flag("avoid_crossings", value).map(Some) }
}

/// `connections`: a word, or pairs.
pub fn read_connections(value: &Bound<'_, PyAny>) -> PyResult<Connections> {
    let Ok(word) = value.cast::<PyString>() else { return read_pairs("connections", value).map(Connections::Pairs) };
    let word = word.to_cow()?;
    let found = CONNECTIONS.iter().find(|(name, _)| *name == word).map(|(_, connections)| connections.clone());
    found.ok_or_else(|| {
        let names: Vec<&str> = CONNECTIONS.iter().map(|(name, _)| *name).collect();
        option_error(
            value.py(),
            "connections",
            refuse_word(&word, &names, ", or an (M, 2) array of positions in picks"),
        )
    })
}

/// `support`: an integer of at least 0; what does not fit is refused by the core as too many.
pub fn read_support(value: &Bound<'_, PyAny>) -> PyResult<usize> {
    match read_integer(value)? {
        Integer::Fits(number) if number >= 0 => Ok(usize::try_from(number).unwrap_or(usize::MAX)),
        Integer::Fits(number) => Err(refuse_support(value.py(), &number.to_string())),
        Integer::TooWide if value.lt(0)? => Err(refuse_support(value.py(), "an integer below -2^127")),
        Integer::TooWide => Ok(usize::MAX),
        Integer::No => Err(refuse_type("support", value, "an integer")),
    }
}

/// `max_iterations`: an integer of at least 0 or None; what does not fit into 32 bits is no limit in practice.
pub fn read_max_iterations(value: &Bound<'_, PyAny>) -> PyResult<Option<u32>> {
    const EXPECTED: &str = "an integer or None";
    if value.is_none() {
        return Ok(None);
    }
    match read_integer(value)? {
        Integer::Fits(number) if number < 0 => Err(refuse_negative(value.py(), &number.to_string())),
        Integer::Fits(number) => Ok(Some(u32::try_from(number).unwrap_or(u32::MAX))),
        Integer::TooWide if value.lt(0)? => Err(refuse_negative(value.py(), "an integer below -2^127")),
        Integer::TooWide => Ok(Some(u32::MAX)),
        Integer::No => Err(refuse_type("max_iterations", value, EXPECTED)),
    }
}

/// `pinned`: "ends", "all", or a sequence of bool.
pub fn read_pinned(value: &Bound<'_, PyAny>) -> PyResult<Pinned> {
    if let Ok(word) = value.cast::<PyString>() {
        return match word.to_cow()?.as_ref() {
            "ends" => Ok(Pinned::Ends),
            "all" => Ok(Pinned::All),
            other => {
                let also = " or a sequence of bool, one for each pick";
                Err(option_error(value.py(), "pinned", refuse_word(other, &["ends", "all"], also)))
            }
        };
    }
    let items = sequence_items("pinned", value, "\"ends\", \"all\" or a sequence of bool, one for each pick")?;
    let mut flags = Vec::with_capacity(items.len());
    for (place, item) in items.iter().enumerate() {
        // pyo3's bool takes Python's and numpy's, and no number.
        let Ok(flag) = item.extract::<bool>() else {
            let found = item.get_type().name()?;
            return Err(type_error("pinned", format_args!("entry {place} is of type {found}, expected a bool")));
        };
        flags.push(flag);
    }
    Ok(Pinned::Each(flags))
}

/// What there is where an integer was expected.
pub enum Integer {
    /// One of at most 127 bits.
    Fits(i128),
    /// A longer one.
    TooWide,
    /// Something else; a bool is no integer here.
    No,
}

/// Python's and numpy's integers, and whatever else can be an index.
pub fn read_integer(value: &Bound<'_, PyAny>) -> PyResult<Integer> {
    // Older numpy lets its bool pass for an index.
    if value.extract::<bool>().is_ok() {
        return Ok(Integer::No);
    }
    let py = value.py();
    match value.extract::<i64>() {
        Ok(number) => Ok(Integer::Fits(number.into())),
        Err(error) if error.is_instance_of::<PyTypeError>(py) => Ok(Integer::No),
        Err(error) if error.is_instance_of::<PyOverflowError>(py) => {
            // Only Python's own integers can be taken apart beyond 64 bits; numpy's uint64 is one of the others.
            match value.call_method0("__index__")?.extract::<i128>() {
                Ok(number) => Ok(Integer::Fits(number)),
                Err(error) if error.is_instance_of::<PyOverflowError>(py) => Ok(Integer::TooWide),
                Err(error) => Err(error),
            }
        }
        Err(error) => Err(error),
    }
}

fn refuse_type(argument: &str, value: &Bound<'_, PyAny>, expected: &str) -> PyErr {
    match value.get_type().name() {
        Ok(found) => type_error(argument, format_args!("found {found}, expected {expected}")),
        Err(error) => error,
    }
}

fn refuse_negative(py: Python<'_>, found: &str) -> PyErr {
    option_error(
        py,
        "max_iterations",
        format!("found {found}, expected at least 1, or None for the filter's own limit"),
    )
}

fn refuse_support(py: Python<'_>, found: &str) -> PyErr {
    let message = format!("found {found}, expected {DEFAULT_SUPPORT} to {MAX_SUPPORT} neighbours a side");
    option_error(py, "support", message)
}

pub fn read_flag(argument: &str, value: &Bound<'_, PyAny>) -> PyResult<bool> {
    value.extract().map_err(|_| refuse_type(argument, value, "a bool"))
}

/// A number; a bool is none.
pub fn read_number(argument: &str, value: &Bound<'_, PyAny>, expected: &str) -> PyResult<f64> {
    if value.extract::<bool>().is_ok() {
        return Err(refuse_type(argument, value, expected));
    }
    value.extract().map_err(|_| refuse_type(argument, value, expected))
}
