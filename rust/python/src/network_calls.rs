//! The method of `SurfaceMesh` that makes a net of lines.
//!
//! Holds its arguments and its documentation; what it has in common with all calls is in `border`.

use std::sync::Arc;
use std::time::Duration;

use pyo3::prelude::*;
use smooth_polylines_core::connections::Connections;
use smooth_polylines_core::options::{DEFAULT_SUPPORT, DEFAULT_THRESHOLD};
use smooth_polylines_core::{Filter, Knots, Options, Pinned, Solver};

use crate::border::{Watch, run_watched};
use crate::limits::{Limits, read_stop, read_time_limit};
use crate::line_options::{
    read_avoid_crossings, read_closed, read_connections, read_detail_size, read_filter, read_knots,
    read_max_iterations, read_pinned, read_solver, read_stages, read_support, read_threshold,
};
use crate::mesh::PySurfaceMesh;
use crate::network::{Net, PyNetwork};
use crate::picks::read_picks;

#[pymethods]
impl PySurfaceMesh {
    /// Several lines in one call, each with its own result or error: a Network.
    ///
    /// Parameters
    /// ----------
    /// picks : sequence
    ///     As for `polyline`.
    /// connections : (M, 2) of any integer type, or "all", "chain", "loop" or "automatic"
    ///     Positions in `picks`: line i goes from the first to the second. Or each pick with each, each with the next, the
    ///     same and the last with the first. Or those that are neighbours on the surface (the Delaunay graph of the picks,
    ///     by a search from all of them at once), which divide it into patches around them: on a closed surface without
    ///     handles, picks that are well spread give patches of three sides. A line of "automatic" that all the
    ///     same crosses a shorter one is left out; patches of five sides and more are divided by their shortest diagonals,
    ///     whose connections come last.
    /// avoid_crossings : bool, optional
    ///     Whether lines are led round each other. None: True for a word, False for an array, whose lines are those of
    ///     `polyline` to the bit. What still crosses then, told in `Network.crossings`, is forced: as the other lines lie,
    ///     no way on the surface between the picks of either line steps over fewer of them.
    ///
    /// The other arguments are those of `polyline` and hold for every line.
    ///
    /// Raises
    /// ------
    /// LimitError
    ///     Ended by `time_limit` (of the whole call) or `stop`.
    /// OptionError
    ///     An argument out of its range, a connection to a pick that does not exist. What goes wrong with one line is
    ///     in `Network.errors` instead.
    /// TypeError
    ///     A pick or an argument of a wrong type.
    ///
    /// Examples
    /// --------
    /// >>> import numpy as np, smooth_polylines as sp
    /// >>> square = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    /// >>> mesh = sp.SurfaceMesh(square, [[0, 1, 2], [0, 2, 3]])
    /// >>> mesh.network([0, 1], [[0, 1], [1, 0]])
    /// <Network: 2 connections, 2 lines, 0 errors>
    #[pyo3(
        signature = (picks, connections, closed=false, filter=Filter::Linear, pinned=Pinned::Ends, solver=Solver::Auto,
                     threshold=DEFAULT_THRESHOLD, max_iterations=None, detail_size=None, *, knots=Knots::Centripetal,
                     support=DEFAULT_SUPPORT, stages=false, avoid_crossings=None, time_limit=None, stop=None),
        text_signature = "($self, picks, connections, closed=False, filter='linear', pinned='ends', solver='auto', \
                          threshold=0.0001, max_iterations=None, detail_size=None, *, knots='centripetal', \
                          support=2, stages=False, avoid_crossings=None, time_limit=None, \
                          stop=None)"
    )]
    #[expect(clippy::too_many_arguments, reason = "the keyword arguments of the public interface")]
    fn network(
        &self,
        py: Python<'_>,
        picks: &Bound<'_, PyAny>,
        #[pyo3(from_py_with = read_connections)] connections: Connections,
        #[pyo3(from_py_with = read_closed)] closed: bool,
        #[pyo3(from_py_with = read_filter)] filter: Filter,
        #[pyo3(from_py_with = read_pinned)] pinned: Pinned,
        #[pyo3(from_py_with = read_solver)] solver: Solver,
        #[pyo3(from_py_with = read_threshold)] threshold: f64,
        #[pyo3(from_py_with = read_max_iterations)] max_iterations: Option<u32>,
        #[pyo3(from_py_with = read_detail_size)] detail_size: Option<f64>,
        #[pyo3(from_py_with = read_knots)] knots: Knots,
        #[pyo3(from_py_with = read_support)] support: usize,
        #[pyo3(from_py_with = read_stages)] stages: bool,
        #[pyo3(from_py_with = read_avoid_crossings)] avoid_crossings: Option<bool>,
        #[pyo3(from_py_with = read_time_limit)] time_limit: Option<Duration>,
        #[pyo3(from_py_with = read_stop)] stop: Option<Py<PyAny>>,
    ) -> PyResult<PyNetwork> {
        let mut watch = Watch::start_within(Limits { time: time_limit, stop });
        let options =
            Options { closed, filter, pinned, solver, threshold, max_iterations, detail_size, knots, support, stages };
        let picks = read_picks("picks", picks)?;
        let avoid = avoid_crossings.unwrap_or(!matches!(connections, Connections::Pairs(_)));
        let net =
            run_watched(py, &mut watch, |stop| Net::make(&self.mesh, &picks, &connections, &options, avoid, stop))?
                .map_err(|error| watch.raise(py, error))?;
        PyNetwork::new(py, Arc::clone(&self.mesh), picks, net, watch.stop().total)
    }
}
