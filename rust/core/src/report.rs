//! What happened while a line was made: counters, the stop reason, and the observer of the steps.
//!
//! Holds no clock: callers that want seconds measure between the observer's calls.

use std::ops::ControlFlow;

use glam::DVec3;

/// Why smoothing ended; of a line whose legs ended in different ways, the last of these.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub enum StopReason {
    /// Nothing moves any more and the line is strictly inside its strip.
    Converged,
    /// Nothing moves any more; the line runs through mesh vertices (the paper's remark in section 3).
    ConvergedAtVertices,
    /// A strip that was seen before came again.
    Cycle,
    /// The limit of rounds, or of moves within one step C, was reached.
    MaxIterations,
}

impl StopReason {
    /// The public name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Converged => "converged",
            Self::ConvergedAtVertices => "converged_at_vertices",
            Self::Cycle => "cycle",
            Self::MaxIterations => "max_iterations",
        }
    }
}

/// Counters of one line; the same input gives the same numbers.
#[derive(Clone, PartialEq, Debug)]
pub struct Report {
    /// Rounds of steps C and D.
    pub iterations: u32,
    /// Moves of single vertices, one by one.
    pub moves: u64,
    /// Whole-strip steps: Newton steps of `linear`, Gauss-Newton steps of `fair`, also those that were taken back.
    pub newton_steps: u64,
    /// Funnel runs of `geodesic`, and of the starts of other filters.
    pub funnels: u64,
    /// Mesh vertices that the line was moved over in step D.
    pub vertex_passes: u64,
    /// Loops cut out of the strip.
    pub loops_removed: u64,
    /// Triangles taken from the search queue in step B; slivers up to three times. Fewer, for the same line, once a large
    /// mesh was asked often enough to choose landmarks.
    pub pops: u64,
    /// Legs between pins (for `fair` of its input: between picks) that were taken over from the line before, and of which
    /// the other counters do not tell.
    pub kept_legs: usize,
    /// Pairs of neighbouring points of a stroke that step B joined, as no straight walk over the surface did.
    pub stroke_breaks: usize,
    /// Largest distance of a point of a stroke from the surface, in the units of the positions.
    pub stroke_distance: f64,
    /// Triangles in the strip that smoothing starts from.
    pub strip_triangles: usize,
    /// Length of the polyline through the midpoints of that strip, in the units of the positions.
    pub start_length: f64,
    /// Why smoothing ended.
    pub stop_reason: StopReason,
    /// The detail size that `fair` worked with.
    pub detail_size: Option<f64>,
    /// What `fair` lowered: the energy of its finest curve at the start and after each round, in 1 / unit of the
    /// positions; it never rises.
    pub energies: Vec<f64>,
    /// Self-crossings of a `fair` line that its input did not have.
    pub new_self_crossings: usize,
    /// Points after step B and after each round, when asked for.
    pub stages: Vec<Vec<DVec3>>,
}

impl Default for Report {
    fn default() -> Self {
        Self {
            iterations: 0,
            moves: 0,
            newton_steps: 0,
            funnels: 0,
            vertex_passes: 0,
            loops_removed: 0,
            pops: 0,
            kept_legs: 0,
            stroke_breaks: 0,
            stroke_distance: 0.0,
            strip_triangles: 0,
            start_length: 0.0,
            stop_reason: StopReason::Converged,
            detail_size: None,
            energies: Vec::new(),
            new_self_crossings: 0,
            stages: Vec::new(),
        }
    }
}

/// The steps that an observer is told of, just before each begins.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Step {
    /// Step B: strips between the picks.
    Search,
    /// Step C: vertices slide on their edges.
    Relax,
    /// Step D: vertices of the mesh are passed.
    VertexPass,
    /// The finished line is put together.
    Assemble,
}

/// Watches the steps and may stop the work.
///
/// Called at least once in every few milliseconds of work, so a caller can look at a clock or at a signal.
pub trait Observer {
    /// `step` is about to begin, or still goes on.
    fn step(&mut self, step: Step) -> ControlFlow<()>;

    /// One line of a network has been made or refused.
    fn finish(&mut self) {}
}

/// Watches nothing and never stops.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoObserver;

impl Observer for NoObserver {
    fn step(&mut self, _: Step) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}
