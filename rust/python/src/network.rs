//! `Network`: several lines over one set of picks, each with its own result or error.

use std::sync::atomic::AtomicBool;
use std::sync::{Arc, OnceLock};
use std::time::Duration;

use numpy::PyArray2;
use pyo3::exceptions::PyIndexError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use pyo3::{PyTraverseError, PyVisit};
use smooth_polylines_core::connections::Connections;
use smooth_polylines_core::diagonals::add_diagonals;
use smooth_polylines_core::embed::DEFAULT_TOLERANCE;
use smooth_polylines_core::embed::crossings::{Crossing, find_crossings};
use smooth_polylines_core::network::network;
use smooth_polylines_core::untangle::{drop_crossing, find_transversal, untangle};
use smooth_polylines_core::{
    Error as CoreError, Options, Pick, Polyline, Result as CoreResult, SurfaceMesh, SurfacePoint,
};

use crate::border::{LineWatch, Seconds, run_on_lines};
use crate::crossings::PyCrossings;
use crate::cut::PyCut;
use crate::cut_calls::cut;
use crate::errors::from_core;
use crate::frozen_arrays::{freeze_owned, id_rows};
use crate::line_options::read_tolerance;
use crate::patches::PyPatches;
use crate::polyline::PyPolyline;
use crate::report::seconds_dict;
use crate::surface_point::PySurfacePoint;

/// The lines of a net, one for each connection; made by `SurfaceMesh.network`.
///
/// `len(net)`, `net[i]` and iteration go over `net.lines`: a line that could not be made is None there, and
/// `net.errors` says why.
#[pyclass(frozen, module = "smooth_polylines", name = "Network")]
pub struct PyNetwork {
    mesh: Arc<SurfaceMesh>,
    picks: Vec<Pick>,
    connections: Vec<[u32; 2]>,
    lines: Py<PyList>,
    errors: Py<PyList>,
    of_core: Vec<Option<Py<PyPolyline>>>,
    seconds: Seconds,
    crossings: OnceLock<Vec<Crossing>>,
}

/// What the core makes of a net.
pub struct Net {
    pairs: Vec<[i128; 2]>,
    lines: Vec<(CoreResult<Polyline>, Seconds)>,
    /// Crossings that remain; `None` where nobody has looked.
    crossings: Option<Vec<Crossing>>,
}

impl Net {
    /// Chooses the connections, makes the lines and, where `avoid` says so, parts those that need not cross.
    pub fn make(
        mesh: &SurfaceMesh,
        picks: &[Pick],
        connections: &Connections,
        options: &Options,
        avoid: bool,
        stop: &AtomicBool,
    ) -> CoreResult<Self> {
        let mut watch = LineWatch::start(stop);
        let pairs = connections.pairs(mesh, picks, &mut watch)?;
        let made = network(mesh, picks, &pairs, options, |_| LineWatch::start(stop))?;
        let made = made.into_iter().map(|(line, watch)| (line, watch.seconds()));
        let mut net = Self { pairs, lines: made.collect(), crossings: None };
        if avoid {
            net.part(mesh, options, *connections == Connections::Automatic, &mut watch)?;
        }
        Ok(net)
    }

    fn part(
        &mut self,
        mesh: &SurfaceMesh,
        options: &Options,
        is_automatic: bool,
        watch: &mut LineWatch<'_>,
    ) -> CoreResult<()> {
        let mut lines: Vec<Option<Polyline>> = self.lines.iter().map(|(line, _)| line.clone().ok()).collect();
        let mut crossings = untangle(mesh, &mut lines, &self.pairs, options, !is_automatic, watch)?;
        if is_automatic {
            let stays = if crossings.is_empty() { vec![true; lines.len()] } else { drop_crossing(mesh, &mut lines)? };
            keep(&mut self.lines, &stays);
            keep(&mut self.pairs, &stays);
            keep(&mut lines, &stays);
            add_diagonals(mesh, &mut self.pairs, &mut lines, options, watch)?;
            crossings = find_transversal(mesh, &lines)?;
        }
        // What could not be made keeps its error; diagonals come last.
        let mut before = std::mem::take(&mut self.lines).into_iter();
        for line in lines {
            let (known, seconds) = before.next().unwrap_or((Err(CoreError::Interrupted), Seconds::default()));
            self.lines.push((line.map_or(known, Ok), seconds));
        }
        self.crossings = Some(crossings);
        Ok(())
    }
}

/// Keeps the rows of a list that `stays` says.
fn keep<T>(list: &mut Vec<T>, stays: &[bool]) {
    let mut stays = stays.iter();
    list.retain(|_| *stays.next().unwrap_or(&true));
}

impl PyNetwork {
    /// Wraps what the core made of each connection.
    pub fn new(py: Python<'_>, mesh: Arc<SurfaceMesh>, picks: Vec<Pick>, net: Net, total: Duration) -> PyResult<Self> {
        let mut seconds = net.lines.iter().fold(Seconds::default(), |sum, (_, line)| sum.plus(line));
        seconds.total = total;
        let lines = PyList::empty(py);
        let errors = PyList::empty(py);
        let mut of_core = Vec::new();
        for (result, seconds) in net.lines {
            match result {
                Ok(line) => {
                    let line = Py::new(py, PyPolyline::new(py, Arc::clone(&mesh), line, seconds)?)?;
                    lines.append(&line)?;
                    errors.append(py.None())?;
                    of_core.push(Some(line));
                }
                Err(error) => {
                    lines.append(py.None())?;
                    errors.append(from_core(py, error).into_value(py))?;
                    of_core.push(None);
                }
            }
        }
        // What the core took as a pair was in range.
        let connections = net.pairs.iter().map(|pair| pair.map(|i| i as u32)).collect();
        let crossings = net.crossings.map_or_else(OnceLock::new, OnceLock::from);
        let (lines, errors) = (lines.unbind(), errors.unbind());
        Ok(Self { mesh, picks, connections, lines, errors, of_core, seconds, crossings })
    }

    /// The lines there are, each with its place in the net.
    fn made(&self) -> (Vec<u32>, Vec<Arc<Polyline>>) {
        let made = (0..).zip(&self.of_core).filter_map(|(i, line)| Some((i, line.as_ref()?.get().shared_line())));
        made.unzip()
    }

    fn crossings_of(&self, py: Python<'_>) -> PyResult<&[Crossing]> {
        if let Some(found) = self.crossings.get() {
            return Ok(found);
        }
        let (places, lines) = self.made();
        let mesh = Arc::clone(&self.mesh);
        let mut found = run_on_lines(py, &lines, move |lines| find_crossings(&mesh, lines))?
            .map_err(|error| from_core(py, error))?;
        found.retain(|crossing| crossing.is_transversal);
        for crossing in &mut found {
            crossing.lines = crossing.lines.map(|line| places[line as usize]);
        }
        Ok(self.crossings.get_or_init(|| found))
    }
}

#[pymethods]
impl PyNetwork {
    /// A Polyline for each connection, None where it failed: a list.
    #[getter]
    fn lines(&self, py: Python<'_>) -> Py<PyList> {
        self.lines.clone_ref(py)
    }

    /// An exception for each connection that failed, else None: a list. Nothing has been raised yet.
    #[getter]
    fn errors(&self, py: Python<'_>) -> Py<PyList> {
        self.errors.clone_ref(py)
    }

    /// The picks that each line joins, by their places: (m, 2) int32.
    #[getter]
    fn connections(&self, py: Python<'_>) -> PyResult<Py<PyArray2<i32>>> {
        freeze_owned(py, id_rows(self.connections.clone()))
    }

    /// Where lines cross each other or themselves: Crossings, all of them transversal; their `lines` are places in `lines`.
    #[getter]
    fn crossings(&self, py: Python<'_>) -> PyResult<PyCrossings> {
        Ok(PyCrossings::new(Some(Arc::clone(&self.mesh)), self.crossings_of(py)?.to_vec()))
    }

    /// The net with its crossings as picks: a list of SurfacePoint, first the picks as they were, and connections (m, 2)
    /// int32 between neighbours on each line, for a next call of `network`. Connections that failed are left out.
    fn crossing_nodes<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyList>, Py<PyArray2<i32>>)> {
        let resolve = |(i, pick)| self.mesh.resolve_pick(i, pick);
        let points = self.picks.iter().enumerate().map(resolve).collect::<Result<Vec<_>, _>>();
        let points = points.map_err(|error| from_core(py, error.into()))?;
        let (nodes, pairs) = split_at(&points, &self.connections, &self.of_core, self.crossings_of(py)?);
        let nodes = nodes.iter().map(|point| Py::new(py, PySurfacePoint::from_core(point)));
        Ok((PyList::new(py, nodes.collect::<PyResult<Vec<_>>>()?)?, freeze_owned(py, id_rows(pairs))?))
    }

    /// The mesh with all lines put into it: a Cut. See `SurfaceMesh.cut`.
    #[pyo3(signature = (tolerance=DEFAULT_TOLERANCE), text_signature = "($self, tolerance=0.001)")]
    fn cut(&self, py: Python<'_>, #[pyo3(from_py_with = read_tolerance)] tolerance: f64) -> PyResult<PyCut> {
        cut(py, &self.mesh, &self.made().1, tolerance)
    }

    /// The patches that the lines part the mesh into: Patches.
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
    ///
    /// Examples
    /// --------
    /// >>> import numpy as np, smooth_polylines as sp
    /// >>> square = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    /// >>> mesh = sp.SurfaceMesh(square, [[0, 1, 2], [0, 2, 3]])
    /// >>> net = mesh.network([(0, [1, 0, 0]), (0, [0, 0, 1]), (0, [0, 1, 0]), (1, [0, 0, 1])], "all")
    /// >>> net.patches()
    /// <Patches: 4 patches, 4 of three sides, 0 of four>
    #[pyo3(signature = (tolerance=DEFAULT_TOLERANCE), text_signature = "($self, tolerance=0.001)")]
    fn patches(&self, py: Python<'_>, #[pyo3(from_py_with = read_tolerance)] tolerance: f64) -> PyResult<PyPatches> {
        let cut = Py::new(py, cut(py, &self.mesh, &self.made().1, tolerance)?)?;
        PyPatches::new(py, cut)
    }

    /// Time of the whole network: a dict as in `Report.seconds`.
    ///
    /// `total` is the wall time of the call; the steps are summed over the lines, which are made side by side.
    #[getter]
    fn seconds<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        seconds_dict(py, &self.seconds)
    }

    fn __len__(&self, py: Python<'_>) -> usize {
        self.lines.bind(py).len()
    }

    fn __getitem__<'py>(&self, py: Python<'py>, index: isize) -> PyResult<Bound<'py, PyAny>> {
        let lines = self.lines.bind(py);
        let length = lines.len();
        usize::try_from(index)
            .or_else(|_| usize::try_from(index + length as isize))
            .ok()
            .filter(|&i| i < length)
            .map_or_else(
                || Err(PyIndexError::new_err(format!("connection {index} of a network of {length}"))),
                |i| lines.get_item(i),
            )
    }

    fn __iter__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        Ok(self.lines.bind(py).try_iter()?.into_any())
    }

    fn __repr__(&self, py: Python<'_>) -> String {
        let (count, made) = (self.__len__(py), self.made().0.len());
        format!("<Network: {count} connections, {made} lines, {} errors>", count - made)
    }

    // An exception that was raised holds a traceback, whose frames may hold this network.
    fn __traverse__(&self, visit: PyVisit<'_>) -> Result<(), PyTraverseError> {
        visit.call(&self.lines)?;
        visit.call(&self.errors)?;
        self.of_core.iter().flatten().try_for_each(|line| visit.call(line))
    }
}

/// The picks and the crossings, and the pairs of them that follow each other on a line.
fn split_at(
    picks: &[SurfacePoint],
    connections: &[[u32; 2]],
    lines: &[Option<Py<PyPolyline>>],
    crossings: &[Crossing],
) -> (Vec<SurfacePoint>, Vec<[u32; 2]>) {
    let mut nodes = picks.to_vec();
    let mut on_lines: Vec<Vec<(f64, u32)>> = vec![Vec::new(); lines.len()];
    for crossing in crossings {
        // Where three lines cross in one point it is told three times.
        let known = nodes[picks.len()..].iter().position(|node| *node == crossing.point);
        let node = known.unwrap_or(nodes.len() - picks.len()) + picks.len();
        if known.is_none() {
            nodes.push(crossing.point);
        }
        for (line, parameter) in crossing.lines.into_iter().zip(crossing.parameters) {
            on_lines[line as usize].push((parameter, node as u32));
        }
    }
    let mut pairs = Vec::new();
    for ((line, mut stops), &[first, last]) in lines.iter().zip(on_lines).zip(connections) {
        if line.is_none() {
            continue;
        }
        stops.sort_by(|a, b| a.0.total_cmp(&b.0));
        let stops = std::iter::once(first).chain(stops.into_iter().map(|stop| stop.1)).chain([last]);
        let mut stops: Vec<u32> = stops.collect();
        stops.dedup();
        pairs.extend(stops.windows(2).map(|pair| [pair[0], pair[1]]));
    }
    (nodes, pairs)
}
