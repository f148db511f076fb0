//! Crossing from Python to the core: the interpreter released, panics caught, steps timed, signals heeded.
//!
//! Holds the only clock of the library. Only owned values and plain slices may cross.

use std::ops::ControlFlow;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::{Duration, Instant};

use pyo3::prelude::*;
use smooth_polylines_core::{Error, Observer, Step};

use crate::errors;

/// Longest time between two looks at Python's signals: Ctrl-C has to stop a run within 0.2 s.
const SIGNAL_INTERVAL: Duration = Duration::from_millis(50);

/// What `work` returns, computed while other Python threads run; a panic becomes InternalError.
pub fn run_detached<T: Send>(py: Python<'_>, work: impl FnOnce() -> T + Send) -> PyResult<T> {
    // Unwind safety: what a panic leaves half done is dropped with the closure; meshes and lines are immutable.
    py.detach(|| catch_unwind(AssertUnwindSafe(work))).map_err(|panic| errors::internal_error(py, &*panic))
}

/// What `work` returns, for calls too short to release the interpreter; a panic becomes InternalError.
pub fn run_attached<T>(py: Python<'_>, work: impl FnOnce() -> T) -> PyResult<T> {
    catch_unwind(AssertUnwindSafe(work)).map_err(|panic| errors::internal_error(py, &*panic))
}

/// Wall time of each step of one call.
#[derive(Clone, Copy, Default, Debug)]
pub struct Seconds {
    /// Step B.
    pub search: Duration,
    /// Step C.
    pub relax: Duration,
    /// Step D.
    pub vertex_pass: Duration,
    /// Putting the finished line together.
    pub assemble: Duration,
    /// The whole call, checks included.
    pub total: Duration,
}

/// Watches one call of the core: keeps time and asks Python for signals.
pub struct Watch {
    begun: Instant,
    current: Option<(Step, Instant)>,
    signals_seen: Instant,
    seconds: Seconds,
    raised: Option<PyErr>,
}

impl Watch {
    /// A watch that starts now.
    pub fn start() -> Self {
        let now = Instant::now();
        Self { begun: now, current: None, signals_seen: now, seconds: Seconds::default(), raised: None }
    }

    fn close_step(&mut self, now: Instant) {
        if let Some((step, since)) = self.current.take() {
            let elapsed = now - since;
            match step {
                Step::Search => self.seconds.search += elapsed,
                Step::Relax => self.seconds.relax += elapsed,
                Step::VertexPass => self.seconds.vertex_pass += elapsed,
                Step::Assemble => self.seconds.assemble += elapsed,
            }
        }
    }

    /// The times of a call that has ended.
    pub fn stop(&mut self) -> Seconds {
        let now = Instant::now();
        self.close_step(now);
        self.seconds.total = now - self.begun;
        self.seconds
    }

    /// The exception for `error`; what a signal handler raised has precedence over the core's `Interrupted`.
    pub fn raise(&mut self, py: Python<'_>, error: Error) -> PyErr {
        match (error, self.raised.take()) {
            (Error::Interrupted, Some(raised)) => raised,
            (error, _) => errors::from_core(py, error),
        }
    }
}

impl Observer for Watch {
    fn step(&mut self, step: Step) -> ControlFlow<()> {
        let now = Instant::now();
        self.close_step(now);
        self.current = Some((step, now));
        if now - self.signals_seen >= SIGNAL_INTERVAL {
            self.signals_seen = now;
            // None: the interpreter is shutting down, nobody waits for the line any more.
            match Python::try_attach(|py| py.check_signals()) {
                Some(Ok(())) => {}
                Some(Err(raised)) => {
                    self.raised = Some(raised);
                    return ControlFlow::Break(());
                }
                None => return ControlFlow::Break(()),
            }
        }
        ControlFlow::Continue(())
    }
}
