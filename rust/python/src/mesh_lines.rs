//! The methods of `SurfaceMesh` that make lines.
//!
//! Holds their arguments and their documentation; what they have in common with all calls is in `border`.

use std::sync::Arc;
use std::time::Duration;

use pyo3::prelude::*;
use smooth_polylines_core::options::{DEFAULT_SUPPORT, DEFAULT_THRESHOLD};
use smooth_polylines_core::{Filter, Knots, Options, Pinned, Solver, smooth, stroke};

use crate::border::{Watch, run_detached};
use crate::limits::{Limits, read_stop, read_time_limit};
use crate::line_options::{
    read_closed, read_detail_size, read_filter, read_knots, read_max_iterations, read_pinned, read_solver, read_stages,
    read_support, read_threshold,
};
use crate::mesh::PySurfaceMesh;
use crate::picks::read_picks;
use crate::polyline::PyPolyline;
use crate::stroke_points::read_stroke_points;

#[pymethods]
impl PySurfaceMesh {
    /// A smooth line through the picks: a Polyline.
    ///
    /// Parameters
    /// ----------
    /// picks : sequence
    ///     Face ids, (triangle id, barycentric) pairs, SurfacePoint, mixed; in order, not necessarily neighbours. A
    ///     face stands for its middle.
    /// closed : bool
    ///     Join the last pick to the first; three distinct picks at least.
    /// filter : "linear", "cubic", "geodesic", "fair" or "none"
    ///     What the line is smoothed to: straight by the paper's line through the neighbours; the paper's cubic, which
    ///     keeps the shape; locally shortest; the smoothest line near the input; or not at all (step B's strip through
    ///     the midpoints).
    /// pinned : "ends", "all" or a sequence of bool, one for each pick
    ///     Picks that the line passes through exactly. The ends of an open line always are.
    /// solver : "auto" or "heap"
    ///     "heap" is the paper's one-vertex-at-a-time relaxation, for "linear" and "cubic".
    /// threshold : float
    ///     Barycentric units; step C ends when no vertex is further than this from its target.
    /// max_iterations : int, optional
    ///     Most rounds of relaxation and vertex passes. None: 100 for the paper's filters, what convergence takes for
    ///     "geodesic" and "fair".
    /// detail_size : float, optional
    ///     "fair" only, in the units of the positions: wiggles much shorter than it go; `inf`: as smooth as the pins allow.
    ///     None: `inf` if all inner picks are pinned, else a quarter of the mean distance between picks.
    /// knots : "centripetal", "uniform" or "chordal"
    ///     "cubic" only: steps of the neighbours' parameters: roots of their distances, all alike (the paper's), distances.
    /// support : int
    ///     "cubic" only: neighbours a side that the cubic is made from, 2 to 16. 2, the paper's: through them; more: the
    ///     nearest to them by least squares, which takes out larger detail. Cost: in proportion to its square.
    /// stages : bool
    ///     Keep the points after each round in `report.stages`.
    /// time_limit : float, optional
    ///     Seconds after which the call is ended. How far it comes in that time hangs on the machine, so no line is
    ///     returned; `max_iterations` is the limit that gives a line, the same on every machine.
    /// stop : threading.Event or any object with `is_set()`, optional
    ///     Ends the call soon after another thread has set it: it is looked at fifty times a second.
    ///
    /// The interpreter is released meanwhile; Ctrl-C stops the work. Cost: a search between the picks, then linear in
    /// the strip for each step.
    ///
    /// Raises
    /// ------
    /// OptionError
    ///     An argument out of its range.
    /// NoPathError
    ///     Consecutive picks lie on parts that are not connected.
    /// CollapsedError
    ///     A closed line shrank to a point.
    /// LimitError
    ///     Ended by `time_limit` or `stop`.
    /// TypeError
    ///     A pick or an argument of a wrong type.
    ///
    /// Source: G.-P. Bonneau, S. Hahmann, Smooth Polylines on Polygon Meshes (2003), sections 3 to 6.
    #[pyo3(
        signature = (picks, closed=false, filter=Filter::Linear, pinned=Pinned::Ends, solver=Solver::Auto,
                     threshold=DEFAULT_THRESHOLD, max_iterations=None, detail_size=None, *, knots=Knots::Centripetal,
                     support=DEFAULT_SUPPORT, stages=false, time_limit=None, stop=None),
        text_signature = "($self, picks, closed=False, filter='linear', pinned='ends', solver='auto', \
                          threshold=0.0001, max_iterations=None, detail_size=None, *, knots='centripetal', \
                          support=2, stages=False, time_limit=None, stop=None)"
    )]
    #[expect(clippy::too_many_arguments, reason = "the keyword arguments of the public interface")]
    fn polyline(
        &self,
        py: Python<'_>,
        picks: &Bound<'_, PyAny>,
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
        #[pyo3(from_py_with = read_time_limit)] time_limit: Option<Duration>,
        #[pyo3(from_py_with = read_stop)] stop: Option<Py<PyAny>>,
    ) -> PyResult<PyPolyline> {
        let mut watch = Watch::start_within(Limits { time: time_limit, stop });
        let options =
            Options { closed, filter, pinned, solver, threshold, max_iterations, detail_size, knots, support, stages };
        let picks = read_picks("picks", picks)?;
        let made = run_detached(py, || smooth::polyline_kept(&self.mesh, &picks, &options, &mut watch))?
            .map_err(|error| watch.raise(py, error))?;
        PyPolyline::new_kept(py, Arc::clone(&self.mesh), made, watch.stop())
    }

    /// A smooth line along a stroke: a Polyline.
    ///
    /// Parameters
    /// ----------
    /// points : (N, 3) float32 or float64, or a sequence of picks
    ///     Places near the surface, in the order in which they were drawn, in the space of the mesh's positions; each is
    ///     moved to the nearest point of the surface. Or face ids, SurfacePoint or (triangle, barycentric) pairs as in
    ///     `polyline`, gaps allowed.
    ///
    /// Neighbouring points are joined by a straight walk over the surface; where it would go more than twice the
    /// distance through space, or does not arrive, is a break that step B joins (`report.stroke_breaks`). What is drawn
    /// there and back cancels. The line starts at the stroke's own crossings, so `filter="none"` gives the stroke on
    /// the surface. The other arguments are those of `polyline`, with a pick for each point: inner points shape the
    /// line and are not on it unless pinned.
    ///
    /// Where the stroke is nearer to another sheet of the surface (the back of an ear), its points lie there: compare
    /// `report.stroke_distance` with what is expected. Cost: some microseconds a point, after a first call that is
    /// linear in the mesh.
    ///
    /// Raises
    /// ------
    /// OptionError
    ///     A row that is not finite, an argument out of its range.
    /// NoPathError
    ///     Neighbouring points lie on parts that are not connected.
    /// CollapsedError
    ///     A closed line shrank to a point.
    /// LimitError
    ///     Ended by `time_limit` or `stop`.
    /// TypeError
    ///     A wrong dtype, rank or type.
    ///
    /// Source: G.-P. Bonneau, S. Hahmann, Smooth Polylines on Polygon Meshes (2003), section 4.
    ///
    /// Examples
    /// --------
    /// >>> import numpy as np, smooth_polylines as sp
    /// >>> square = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    /// >>> mesh = sp.SurfaceMesh(square, [[0, 1, 2], [0, 2, 3]])
    /// >>> mesh.stroke([[0.75, 0.25, 0.1], [0.25, 0.5, 0.1]], filter="none").points.round(3)
    /// array([[0.75 , 0.25 , 0.   ],
    ///        [0.417, 0.417, 0.   ],
    ///        [0.25 , 0.5  , 0.   ]])
    #[pyo3(
        signature = (points, closed=false, filter=Filter::Linear, pinned=Pinned::Ends, solver=Solver::Auto,
                     threshold=DEFAULT_THRESHOLD, max_iterations=None, detail_size=None, *, knots=Knots::Centripetal,
                     support=DEFAULT_SUPPORT, stages=false, time_limit=None, stop=None),
        text_signature = "($self, points, closed=False, filter='linear', pinned='ends', solver='auto', \
                          threshold=0.0001, max_iterations=None, detail_size=None, *, knots='centripetal', \
                          support=2, stages=False, time_limit=None, stop=None)"
    )]
    #[expect(clippy::too_many_arguments, reason = "the keyword arguments of the public interface")]
    fn stroke(
        &self,
        py: Python<'_>,
        points: &Bound<'_, PyAny>,
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
        #[pyo3(from_py_with = read_time_limit)] time_limit: Option<Duration>,
        #[pyo3(from_py_with = read_stop)] stop: Option<Py<PyAny>>,
    ) -> PyResult<PyPolyline> {
        let mut watch = Watch::start_within(Limits { time: time_limit, stop });
        let options =
            Options { closed, filter, pinned, solver, threshold, max_iterations, detail_size, knots, support, stages };
        let points = read_stroke_points(points)?;
        self.build_tree(py, &mut watch)?;
        let line = run_detached(py, || stroke::stroke(&self.mesh, &points, &options, &mut watch))?
            .map_err(|error| watch.raise(py, error))?;
        PyPolyline::new(py, Arc::clone(&self.mesh), line, watch.stop())
    }
}
