//! `Report`: what happened while a line was made.

use numpy::PyArray2;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use smooth_polylines_core::Report;

use crate::border::Seconds;
use crate::frozen_arrays::{freeze_rows, point_rows};

/// Counters, times and the stop reason of one line.
///
/// The same input gives the same numbers, `seconds` apart.
#[pyclass(frozen, module = "smooth_polylines", name = "Report")]
pub struct PyReport {
    report: Report,
    seconds: Seconds,
}

impl PyReport {
    /// Joins what the core counted and what the border timed.
    pub fn new(report: Report, seconds: Seconds) -> Self {
        Self { report, seconds }
    }

    /// The public name of the stop reason.
    pub fn stop_name(&self) -> &'static str {
        self.report.stop_reason.name()
    }
}

#[pymethods]
impl PyReport {
    /// Rounds of steps C and D: an int.
    #[getter]
    fn iterations(&self) -> u32 {
        self.report.iterations
    }

    /// Moves of single vertices, one by one: an int.
    #[getter]
    fn moves(&self) -> u64 {
        self.report.moves
    }

    /// Whole-strip steps of `linear` and `fair`: an int.
    #[getter]
    fn newton_steps(&self) -> u64 {
        self.report.newton_steps
    }

    /// Funnel runs: an int.
    #[getter]
    fn funnels(&self) -> u64 {
        self.report.funnels
    }

    /// Mesh vertices that the line was moved over in step D: an int.
    #[getter]
    fn vertex_passes(&self) -> u64 {
        self.report.vertex_passes
    }

    /// Loops cut out of the strip: an int.
    #[getter]
    fn loops_removed(&self) -> u64 {
        self.report.loops_removed
    }

    /// Triangles taken from the search queue in step B, slivers up to three times: an int. Fewer, for the same line, once a
    /// mesh of 4 000 triangles or more was asked often enough to choose landmarks.
    #[getter]
    fn pops(&self) -> u64 {
        self.report.pops
    }

    /// Legs between pins that `Polyline.with_picks` took over from the line before, and of which the other counters do not
    /// tell: an int, 0 for a fresh line. For `fair` legs of its input, the straightest line through all picks.
    #[getter]
    fn kept_legs(&self) -> usize {
        self.report.kept_legs
    }

    /// Pairs of neighbouring points of a stroke that step B joined, as no straight walk did: an int; 0 for picks.
    #[getter]
    fn stroke_breaks(&self) -> usize {
        self.report.stroke_breaks
    }

    /// Largest distance of a point of a stroke from the surface, in the units of the positions: a float; 0 for picks.
    #[getter]
    fn stroke_distance(&self) -> f64 {
        self.report.stroke_distance
    }

    /// Triangles in the strip that smoothing started from: an int.
    #[getter]
    fn strip_triangles(&self) -> usize {
        self.report.strip_triangles
    }

    /// Length of the polyline through the midpoints of that strip, in the units of the positions: a float.
    #[getter]
    fn start_length(&self) -> f64 {
        self.report.start_length
    }

    /// Why smoothing ended: "converged", "converged_at_vertices", "cycle" or "max_iterations".
    #[getter]
    fn stop_reason(&self) -> &'static str {
        self.stop_name()
    }

    /// The detail size that `fair` worked with, in the units of the positions; None for other filters.
    #[getter]
    fn detail_size(&self) -> Option<f64> {
        self.report.detail_size
    }

    /// What `fair` lowered: the energy of its finest curve at the start and after each round on it, in 1 / the unit of the
    /// positions; it never rises. A list of floats, empty for other filters.
    #[getter]
    fn energies(&self) -> Vec<f64> {
        self.report.energies.clone()
    }

    /// Self-crossings of a `fair` line that its input did not have: an int.
    #[getter]
    fn new_self_crossings(&self) -> usize {
        self.report.new_self_crossings
    }

    /// Wall time of each step: a dict of floats with keys search, relax, vertex_pass, assemble and total.
    ///
    /// A line of a network has its own times.
    #[getter]
    fn seconds<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        seconds_dict(py, &self.seconds)
    }

    /// Points after step B and after each round: a list of (n, 3) float64 arrays, empty unless `stages=True`.
    #[getter]
    fn stages(&self, py: Python<'_>) -> PyResult<Vec<Py<PyArray2<f64>>>> {
        self.report.stages.iter().map(|points| freeze_rows(py, &point_rows(points))).collect()
    }

    fn __repr__(&self) -> String {
        let Report { iterations, moves, newton_steps, funnels, vertex_passes, loops_removed, .. } = self.report;
        let Report { pops, kept_legs, stroke_breaks, stroke_distance, strip_triangles, start_length, .. } = self.report;
        let new_self_crossings = self.report.new_self_crossings;
        let detail_size = self.report.detail_size.map_or_else(|| "None".to_owned(), |size| format!("{size:?}"));
        format!(
            "Report(stop_reason='{}', iterations={iterations}, moves={moves}, newton_steps={newton_steps}, \
             funnels={funnels}, vertex_passes={vertex_passes}, loops_removed={loops_removed}, pops={pops}, \
             kept_legs={kept_legs}, stroke_breaks={stroke_breaks}, stroke_distance={stroke_distance:?}, strip_triangles={strip_triangles}, \
             start_length={start_length:?}, detail_size={detail_size}, new_self_crossings={new_self_crossings}, \
             stages={}, seconds={:.6})",
            self.stop_name(),
            self.report.stages.len(),
            self.seconds.total.as_secs_f64(),
        )
    }
}

/// Times as Python sees them.
pub fn seconds_dict<'py>(py: Python<'py>, seconds: &Seconds) -> PyResult<Bound<'py, PyDict>> {
    let Seconds { search, relax, vertex_pass, assemble, total } = *seconds;
    let dict = PyDict::new(py);
    for (key, time) in
        [("search", search), ("relax", relax), ("vertex_pass", vertex_pass), ("assemble", assemble), ("total", total)]
    {
        dict.set_item(key, time.as_secs_f64())?;
    }
    Ok(dict)
}
