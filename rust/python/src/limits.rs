//! What may end a call before it is finished: a time limit, and the caller's own wish.
//!
//! An ended call raises LimitError and returns no line: how far it would have come hangs on the machine, and the same
//! input shall give the same bytes. `max_iterations` is the limit that gives a line. Holds no clock.

use std::time::Duration;

use pyo3::prelude::*;

use crate::errors::{limit_error, option_error, type_error};
use crate::line_options::read_number;

/// See the module; `Limits::default()` has none.
#[derive(Default)]
pub struct Limits {
    /// From the call's begin.
    pub time: Option<Duration>,
    /// Something with `is_set()`, such as a `threading.Event`.
    pub stop: Option<Py<PyAny>>,
}

/// Which limit ended a call.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Limit {
    /// `time_limit`.
    Time,
    /// `stop`.
    Stop,
}

impl Limits {
    /// Whether the caller wishes to end the call.
    pub fn is_stopped(&self, py: Python<'_>) -> PyResult<bool> {
        self.stop.as_ref().map_or(Ok(false), |stop| stop.call_method0(py, "is_set")?.is_truthy(py))
    }

    /// The exception of a call that a limit has ended.
    pub fn raise(&self, py: Python<'_>, limit: Limit) -> PyErr {
        let message = match limit {
            Limit::Time => format!(
                "time_limit: not finished within {} s, and nothing half finished is returned; allow more time, or ask for \
                 less (fewer picks, a larger threshold, or max_iterations, which ends with a line)",
                self.time.unwrap_or_default().as_secs_f64()
            ),
            Limit::Stop => {
                "stop: ended by the caller before it was finished; nothing half finished is returned".to_owned()
            }
        };
        limit_error(py, message)
    }
}

/// `time_limit`: seconds above 0, or None.
pub fn read_time_limit(value: &Bound<'_, PyAny>) -> PyResult<Option<Duration>> {
    if value.is_none() {
        return Ok(None);
    }
    let seconds = read_number("time_limit", value, "a number of seconds or None")?;
    if seconds.is_nan() || seconds <= 0.0 {
        let message = format!("found {seconds}, expected seconds above 0, or None for no limit");
        return Err(option_error(value.py(), "time_limit", message));
    }
    // Infinite, or longer than a Duration can hold: no limit.
    Ok(Duration::try_from_secs_f64(seconds).ok())
}

/// `stop`: an object with a method `is_set`, or None.
pub fn read_stop(value: &Bound<'_, PyAny>) -> PyResult<Option<Py<PyAny>>> {
    if value.is_none() {
        return Ok(None);
    }
    if !value.getattr_opt("is_set")?.is_some_and(|method| method.is_callable()) {
        let found = value.get_type().name()?;
        let expected = "an object with is_set(), such as a threading.Event, or None";
        return Err(type_error("stop", format_args!("found {found}, expected {expected}")));
    }
    Ok(Some(value.clone().unbind()))
}
