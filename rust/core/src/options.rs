//! What a caller can ask of a line, and the checks of single values.
//!
//! Holds no algorithm. Checks that need the picks (number of pins, closed lines) are in `smooth`.

use crate::error::OptionError;

/// What step C slides the vertices of the line towards.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Filter {
    /// The straight line through the two neighbours (the paper, section 5).
    #[default]
    Linear,
    /// The cubic through two neighbours on each side (the paper, section 5).
    Cubic,
    /// The exact crossing in the unfolded strip: a locally shortest line.
    Geodesic,
    /// The smoothest line near the input, pins exact.
    Fair,
    /// Step B only: the strip through the midpoints of its inner edges.
    None,
}

/// How step C is solved.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Solver {
    /// The fastest that reaches the filter's own fixed point.
    #[default]
    Auto,
    /// The paper's: one vertex at a time, most wrong first.
    Heap,
}

/// Which picks the line passes through exactly.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub enum Pinned {
    /// The two ends of an open line; nothing on a closed line.
    #[default]
    Ends,
    /// Every pick.
    All,
    /// One flag a pick.
    Each(Vec<bool>),
}

/// Parameters at which the cubic filter interpolates the neighbours.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Knots {
    /// -2, -1, 1, 2 whatever the spacing (the paper).
    Uniform,
    /// Steps of the square root of the distance: the shortest lines that turn least (measured, see docs/filters.md).
    #[default]
    Centripetal,
    /// Steps of the distance.
    Chordal,
}

/// Neighbours a side that the paper's cubic goes through.
pub const DEFAULT_SUPPORT: usize = 2;

/// Most neighbours a side: ours, so that a vertex's neighbourhood is of bounded size. Detail of so many crossings is large.
pub const MAX_SUPPORT: usize = 16;

/// Rounds of steps C and D that the paper's filters get by default (the paper, section 6).
pub const PAPER_MAX_ITERATIONS: u32 = 100;

/// The paper's threshold for the largest error of a vertex, in barycentric units.
pub const DEFAULT_THRESHOLD: f64 = 1e-4;

/// What is asked of a line. `Options::default()` is an open `linear` line with pinned ends.
#[derive(Clone, PartialEq, Debug)]
pub struct Options {
    /// Join the last pick to the first.
    pub closed: bool,
    /// What step C slides towards.
    pub filter: Filter,
    /// Picks that are interpolated exactly.
    pub pinned: Pinned,
    /// How step C is solved.
    pub solver: Solver,
    /// Barycentric units; step C ends when no vertex is further than this from its target.
    pub threshold: f64,
    /// Most rounds of C and D; `None`: [`PAPER_MAX_ITERATIONS`] for `linear` and `cubic`, a bound by the size
    /// of the strip for `geodesic` and `fair`.
    pub max_iterations: Option<u32>,
    /// `fair` only: a length in the units of the positions.
    pub detail_size: Option<f64>,
    /// `cubic` only.
    pub knots: Knots,
    /// `cubic` only: neighbours on each side, 2 to [`MAX_SUPPORT`]; more than 2: the least-squares cubic.
    pub support: usize,
    /// Keep the points after each round in the report.
    pub stages: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            closed: false,
            filter: Filter::default(),
            pinned: Pinned::default(),
            solver: Solver::default(),
            threshold: DEFAULT_THRESHOLD,
            max_iterations: None,
            detail_size: None,
            knots: Knots::default(),
            support: DEFAULT_SUPPORT,
            stages: false,
        }
    }
}

impl Options {
    /// Checks every value that can be judged without the picks.
    pub fn check(&self) -> Result<(), OptionError> {
        if !(self.threshold.is_finite() && self.threshold > 0.0) {
            return Err(OptionError::new(
                "threshold",
                format!(
                    "found {}, expected a finite number above 0 (barycentric units; the default is 1e-4)",
                    self.threshold
                ),
            ));
        }
        if self.max_iterations == Some(0) {
            return Err(OptionError::new(
                "max_iterations",
                "found 0, expected at least 1, or None for the filter's own limit",
            ));
        }
        if let Some(size) = self.detail_size {
            if self.filter != Filter::Fair {
                return Err(OptionError::new(
                    "detail_size",
                    "only filter=\"fair\" has a detail size; leave it out or choose that filter",
                ));
            }
            if size.is_nan() || size <= 0.0 {
                return Err(OptionError::new(
                    "detail_size",
                    format!("found {size}, expected a length above 0 in the units of the positions, or infinity"),
                ));
            }
        }
        if !(DEFAULT_SUPPORT..=MAX_SUPPORT).contains(&self.support) {
            return Err(OptionError::new(
                "support",
                format!(
                    "found {}, expected {DEFAULT_SUPPORT} to {MAX_SUPPORT} neighbours a side ({DEFAULT_SUPPORT} is the \
                     paper's)",
                    self.support
                ),
            ));
        }
        if self.support != DEFAULT_SUPPORT && self.filter != Filter::Cubic {
            return Err(OptionError::new(
                "support",
                format!(
                    "found {}, but only filter=\"cubic\" has a support; leave it out or choose that filter",
                    self.support
                ),
            ));
        }
        if self.solver == Solver::Heap && !matches!(self.filter, Filter::Linear | Filter::Cubic) {
            return Err(OptionError::new(
                "solver",
                "\"heap\" is the paper's step C and exists for filter=\"linear\" and \"cubic\"; use \"auto\" here",
            ));
        }
        Ok(())
    }
}
