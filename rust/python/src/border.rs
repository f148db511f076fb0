//! Crossing from Python to the core: the interpreter released, panics caught, steps timed, signals heeded.
//!
//! Holds the only clock of the library. Only owned values and plain slices may cross.

use std::ops::ControlFlow;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::time::{Duration, Instant};

use pyo3::prelude::*;
use smooth_polylines_core::{Error, Observer, Polyline, Step};

use crate::errors;
use crate::limits::{Limit, Limits};
use crate::threads::pool;

/// Longest time between two looks at Python's signals: Ctrl-C has to stop a run within 0.2 s.
const SIGNAL_INTERVAL: Duration = Duration::from_millis(20);
/// The same.
const SIGNAL_INTERVAL_NANOS: u64 = SIGNAL_INTERVAL.as_nanos() as u64;

/// Points of lines from which on work on them may take a tenth of a second.
const LONG_POINTS: usize = 50_000;

/// What `work` returns, computed while other Python threads run; a panic becomes InternalError.
pub fn run_detached<T: Send>(py: Python<'_>, work: impl FnOnce() -> T + Send) -> PyResult<T> {
    // Unwind safety: what a panic leaves half done is dropped with the closure; meshes and lines are immutable.
    py.detach(|| catch_unwind(AssertUnwindSafe(work))).map_err(|panic| errors::internal_error(py, &*panic))
}

/// What `work` returns, computed on the threads of the pool while other Python threads run; a panic becomes InternalError.
/// Signals are not looked at: for work of some milliseconds.
pub fn run_on_threads<T: Send>(py: Python<'_>, work: impl FnOnce() -> T + Send) -> PyResult<T> {
    let pool = pool(py)?;
    run_detached(py, || pool.install(work))
}

/// As [`run_on_threads`], and this thread, which may be the one that Python's signals come to, waits and looks at them.
/// When a handler raises, `watch` keeps the exception and the flag that `work` was given is set.
pub fn run_watched<T: Send>(
    py: Python<'_>,
    watch: &mut Watch,
    work: impl FnOnce(&AtomicBool) -> T + Send,
) -> PyResult<T> {
    let pool = pool(py)?;
    let stop = AtomicBool::new(false);
    let mut outcome = None;
    py.detach(|| {
        // Nothing is ever sent: the sender's end, also by a panic, is the message.
        let (sender, is_done) = mpsc::channel::<()>();
        pool.in_place_scope(|scope| {
            let (outcome, stop) = (&mut outcome, &stop);
            scope.spawn(move |_| {
                *outcome = Some(catch_unwind(AssertUnwindSafe(|| work(stop))));
                drop(sender);
            });
            while is_done.recv_timeout(watch.look_after()) == Err(RecvTimeoutError::Timeout) {
                if watch.look() == ControlFlow::Break(()) {
                    stop.store(true, Ordering::Relaxed);
                    break;
                }
            }
        });
    });
    outcome.expect("the scope waits for its task").map_err(|panic| errors::internal_error(py, &*panic))
}

/// What `work`, which cannot be broken off, returns, computed on a thread of the pool. When a signal's handler raises or a
/// limit is reached, the call returns at once; the work goes on to its end unseen and is dropped there.
pub fn run_apart<T: Send + 'static>(
    py: Python<'_>,
    watch: &mut Watch,
    work: impl FnOnce() -> T + Send + 'static,
) -> PyResult<T> {
    let (sender, receiver) = mpsc::channel();
    pool(py)?.spawn(move || {
        // Nobody may listen any more.
        let _ = sender.send(catch_unwind(AssertUnwindSafe(work)));
    });
    let watching = &mut *watch;
    let outcome = py.detach(move || {
        loop {
            match receiver.recv_timeout(watching.look_after()) {
                Ok(outcome) => break Some(outcome),
                Err(RecvTimeoutError::Disconnected) => break None,
                Err(RecvTimeoutError::Timeout) if watching.look() == ControlFlow::Break(()) => break None,
                Err(RecvTimeoutError::Timeout) => {}
            }
        }
    });
    match outcome {
        Some(outcome) => outcome.map_err(|panic| errors::internal_error(py, &*panic)),
        None => Err(watch.raise(py, Error::Interrupted)),
    }
}

/// What `work` on lines returns: as [`run_apart`] where they have so many points that Ctrl-C should not wait for it, else as
/// [`run_detached`].
pub fn run_on_lines<T: Send + 'static>(
    py: Python<'_>,
    lines: &[Arc<Polyline>],
    work: impl FnOnce(&[&Polyline]) -> T + Send + 'static,
) -> PyResult<T> {
    let points: usize = lines.iter().map(|line| line.points.len()).sum();
    if points < LONG_POINTS {
        let lines: Vec<&Polyline> = lines.iter().map(|line| &**line).collect();
        return run_detached(py, || work(&lines));
    }
    let lines = lines.to_vec();
    run_apart(py, &mut Watch::start(), move || {
        let lines: Vec<&Polyline> = lines.iter().map(|line| &**line).collect();
        work(&lines)
    })
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

impl Seconds {
    /// Both, step by step.
    pub fn plus(self, other: &Self) -> Self {
        Self {
            search: self.search + other.search,
            relax: self.relax + other.relax,
            vertex_pass: self.vertex_pass + other.vertex_pass,
            assemble: self.assemble + other.assemble,
            total: self.total + other.total,
        }
    }
}

/// Keeps the time of each step. Near lines take a few microseconds and ten steps: so one reading of the clock a step, and
/// nanoseconds in one number.
struct StepClock {
    begun: Instant,
    /// The current step, and when it began, in nanoseconds after `begun`.
    current: Option<(Step, u64)>,
    seconds: Seconds,
}

impl StepClock {
    fn start() -> Self {
        Self { begun: Instant::now(), current: None, seconds: Seconds::default() }
    }

    /// Nanoseconds since the start.
    fn now(&self) -> u64 {
        self.begun.elapsed().as_nanos() as u64
    }

    fn begin(&mut self, step: Step, now: u64) {
        // A step that goes on is not closed.
        if self.current.is_none_or(|(current, _)| current != step) {
            self.close_step(now);
            self.current = Some((step, now));
        }
    }

    fn close_step(&mut self, now: u64) {
        if let Some((step, since)) = self.current.take() {
            let elapsed = Duration::from_nanos(now - since);
            match step {
                Step::Search => self.seconds.search += elapsed,
                Step::Relax => self.seconds.relax += elapsed,
                Step::VertexPass => self.seconds.vertex_pass += elapsed,
                Step::Assemble => self.seconds.assemble += elapsed,
            }
        }
    }

    fn stop(&mut self) -> Seconds {
        let now = self.now();
        self.close_step(now);
        self.seconds.total = Duration::from_nanos(now);
        self.seconds
    }
}

/// Why a watch broke a call off.
enum Ended {
    /// A signal's handler, or the caller's `stop`, raised.
    Raised(PyErr),
    /// A limit was reached.
    Limit(Limit),
}

/// Watches one call of the core: keeps time, asks Python for signals, and looks at the caller's limits.
pub struct Watch {
    clock: StepClock,
    limits: Limits,
    /// When it looked at signals last, by its clock.
    looked: u64,
    ended: Option<Ended>,
}

impl Watch {
    /// A watch that starts now and has no limits.
    pub fn start() -> Self {
        Self::start_within(Limits::default())
    }

    /// A watch that starts now.
    pub fn start_within(limits: Limits) -> Self {
        Self { clock: StepClock::start(), limits, looked: 0, ended: None }
    }

    /// The times of a call that has ended.
    pub fn stop(&mut self) -> Seconds {
        self.clock.stop()
    }

    /// The exception for `error`; what a signal handler raised has precedence over the core's `Interrupted`.
    pub fn raise(&mut self, py: Python<'_>, error: Error) -> PyErr {
        match (error, self.ended.take()) {
            (Error::Interrupted, Some(Ended::Raised(raised))) => raised,
            (Error::Interrupted, Some(Ended::Limit(limit))) => self.limits.raise(py, limit),
            (error, _) => errors::from_core(py, error),
        }
    }

    /// How long to wait before the next look.
    fn look_after(&self) -> Duration {
        let left = self.limits.time.map(|time| time.saturating_sub(self.clock.begun.elapsed()));
        left.map_or(SIGNAL_INTERVAL, |left| left.clamp(Duration::from_millis(1), SIGNAL_INTERVAL))
    }

    /// Lets Python's signal handlers run and looks at the limits; a break when the work shall end.
    fn look(&mut self) -> ControlFlow<()> {
        if self.is_time_up(self.clock.now()) {
            return self.end(Ended::Limit(Limit::Time));
        }
        let is_stopped = Python::try_attach(|py| {
            py.check_signals()?;
            self.limits.is_stopped(py)
        });
        match is_stopped {
            Some(Ok(false)) => ControlFlow::Continue(()),
            Some(Ok(true)) => self.end(Ended::Limit(Limit::Stop)),
            Some(Err(raised)) => self.end(Ended::Raised(raised)),
            // The interpreter is shutting down, nobody waits for the line any more.
            None => ControlFlow::Break(()),
        }
    }

    fn is_time_up(&self, now: u64) -> bool {
        self.limits.time.is_some_and(|time| u128::from(now) >= time.as_nanos())
    }

    fn end(&mut self, why: Ended) -> ControlFlow<()> {
        self.ended = Some(why);
        ControlFlow::Break(())
    }
}

impl Observer for Watch {
    fn step(&mut self, step: Step) -> ControlFlow<()> {
        let now = self.clock.now();
        self.clock.begin(step, now);
        if now - self.looked >= SIGNAL_INTERVAL_NANOS || self.is_time_up(now) {
            self.looked = now;
            return self.look();
        }
        ControlFlow::Continue(())
    }
}

/// Watches one line among several that are made side by side: keeps its time, and stops when all shall.
pub struct LineWatch<'a> {
    clock: StepClock,
    stop: &'a AtomicBool,
}

impl<'a> LineWatch<'a> {
    /// A watch that starts now and breaks off once `stop` is set.
    pub fn start(stop: &'a AtomicBool) -> Self {
        Self { clock: StepClock::start(), stop }
    }

    /// The times of a line that has ended.
    pub fn seconds(&self) -> Seconds {
        self.clock.seconds
    }
}

impl Observer for LineWatch<'_> {
    fn step(&mut self, step: Step) -> ControlFlow<()> {
        let now = self.clock.now();
        self.clock.begin(step, now);
        if self.stop.load(Ordering::Relaxed) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    fn finish(&mut self) {
        self.clock.stop();
    }
}
