//! `Polyline.with_picks`: the same line through other picks, as when one is dragged.
//!
//! Holds its arguments and its documentation; the work is in the core's `remake`.

use std::sync::Arc;

use pyo3::prelude::*;
use smooth_polylines_core::Pinned;
use smooth_polylines_core::remake::with_picks;

use crate::border::{Watch, run_detached};
use crate::errors::option_error;
use crate::line_options::read_pinned;
use crate::picks::read_picks;
use crate::polyline::PyPolyline;

#[pymethods]
impl PyPolyline {
    /// This line with other picks, at the cost of what they change: a Polyline.
    ///
    /// For picks that are dragged, inserted or removed. Mesh and options are those of this line; call `with_picks` on the
    /// result for the next move, and `mesh.polyline` once the picks rest.
    ///
    /// Parameters
    /// ----------
    /// picks : sequence
    ///     All of them, as for `SurfaceMesh.polyline`, in order.
    /// pinned : "ends", "all" or a sequence of bool, one for each pick, optional
    ///     None: as for this line. A sequence is needed anew when there are more or fewer picks.
    ///
    /// Legs between pins that are the same in both lines are kept; those next to a change are made again. What comes out
    /// depends on this line and the picks alone, the same bytes each time:
    ///
    /// - "geodesic", "linear", "none": the bytes of a fresh line (`mesh.polyline` with these picks).
    /// - "cubic": kept legs stay where they are unless a crossing is further than the threshold from its place; new ones are a
    ///   draft, at rest to a threshold of 5e-3 where `threshold` is finer. Measured, a twentieth of an edge on average and
    ///   two thirds of an edge at most from a fresh line.
    /// - "fair": all picks pinned: legs are kept where the change has faded to a tenth of an edge; the others, and where
    ///   picks are not pinned the whole line, are a draft with half as many samples. Measured, mostly within an edge of a
    ///   fresh line; where the curve has more than one place of rest it may be in another one, edges away.
    ///
    /// Closed lines without pins are made afresh. The report counts what this call did; `report.kept_legs` were not touched.
    ///
    /// Raises
    /// ------
    /// OptionError
    ///     A line that was not made by `SurfaceMesh.polyline` or `with_picks` (but from a stroke, a network or bytes) does
    ///     not know its picks. Picks or flags out of range.
    /// NoPathError, CollapsedError, TypeError
    ///     As `SurfaceMesh.polyline`.
    ///
    /// Examples
    /// --------
    /// >>> import numpy as np, smooth_polylines as sp
    /// >>> square = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    /// >>> mesh = sp.SurfaceMesh(square, [[0, 1, 2], [0, 2, 3]])
    /// >>> line = mesh.polyline([0, 1], filter="geodesic")
    /// >>> moved = line.with_picks([(0, (0.25, 0.5, 0.25)), 1])
    /// >>> moved.points.round(3)
    /// array([[0.75 , 0.25 , 0.   ],
    ///        [0.5  , 0.5  , 0.   ],
    ///        [0.333, 0.667, 0.   ]])
    #[pyo3(signature = (picks, pinned=None), text_signature = "($self, picks, pinned=None)")]
    fn with_picks(
        &self,
        py: Python<'_>,
        picks: &Bound<'_, PyAny>,
        pinned: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let mut watch = Watch::start();
        let pinned: Option<Pinned> = pinned.map(read_pinned).transpose()?;
        let picks = read_picks("picks", picks)?;
        let Some(kept) = self.kept() else {
            return Err(option_error(
                py,
                "picks",
                "this line does not know its picks, as it comes from a stroke, a network or bytes; make it by \
                 SurfaceMesh.polyline first"
                    .to_owned(),
            ));
        };
        let made = run_detached(py, || with_picks(self.mesh(), self.line(), kept, &picks, pinned, &mut watch))?
            .map_err(|error| watch.raise(py, error))?;
        Self::new_kept(py, Arc::clone(self.mesh()), made, watch.stop())
    }
}
