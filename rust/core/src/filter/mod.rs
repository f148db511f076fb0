//! The filters: what step C moves the line towards, one file each, behind one trait where the paper's step C is used.
//!
//! Source of the trait: the paper, section 5: a vertex slides on its own mesh edge towards the point nearest a curve that
//! its neighbours define.

pub mod closed_geodesic;
pub mod cubic;
pub mod cubic_curve;
pub mod fair;
mod fair_step;
pub mod geodesic;
pub mod linear;
pub mod workspace;

use glam::DVec3;

use crate::options::MAX_SUPPORT;

/// A mesh edge that a vertex of the line slides on: from `low` at parameter 0 to `high` at 1.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Edge {
    /// The end with the lower vertex id.
    pub low: DVec3,
    /// The other end.
    pub high: DVec3,
}

impl Edge {
    /// The point at parameter `t`.
    #[inline]
    pub fn at(&self, t: f64) -> DVec3 {
        (1.0 - t) * self.low + t * self.high
    }
}

/// Most neighbours a side that a filter looks at: the cubic's widest support, and one in place of each that the other side
/// lacks.
pub const MAX_REACH: usize = 2 * MAX_SUPPORT - 1;

/// Neighbours of a vertex on one side, nearest first.
pub type Side = arrayvec::ArrayVec<DVec3, MAX_REACH>;

/// Where a vertex belongs.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Target {
    /// Parameter on its edge, in 0..=1.
    pub t: f64,
    /// Parameter of the nearest point on the filter's curve; `None` for a filter that has no use for it.
    pub on_curve: Option<f64>,
}

/// Four neighbours of a vertex in the order of the line.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct FourNeighbours {
    /// Where they are.
    pub points: [DVec3; 4],
    /// How each moves when its parameter grows by one; zero where it is fixed.
    pub slides: [DVec3; 4],
    /// Which one is next to the vertex, before it.
    pub inner: usize,
}

/// A filter of the paper's kind.
pub trait SlidingFilter {
    /// Neighbours a side that the target depends on. Where one side has fewer, the other gives as many
    /// more.
    fn reach(&self) -> usize;

    /// Where on `edge` the vertex belongs, seen from its neighbours; `t` (where it is) when they do not tell. `near`: what
    /// `on_curve` was when the neighbours were a little elsewhere; the point may then be sought near that alone.
    fn target(&self, edge: &Edge, before: &[DVec3], after: &[DVec3], t: f64, near: Option<f64>) -> Target;

    /// As [`SlidingFilter::target`] for a vertex between four neighbours, of which the one at `inner` is next to it, before it; to the
    /// bit the same, in less time. `None` from a filter that looks at more or fewer.
    #[inline(always)]
    fn target_of_four(
        &self,
        _edge: &Edge,
        _points: &[DVec3; 4],
        _inner: usize,
        _t: f64,
        _near: Option<f64>,
    ) -> Option<Target> {
        None
    }

    /// As [`SlidingFilter::target`], with how fast the target follows each of four neighbours that move by their `slides`: in the
    /// order of the line; `None` from a filter that looks at more or fewer.
    fn target_with_slopes(
        &self,
        _edge: &Edge,
        _neighbours: &FourNeighbours,
        _t: f64,
        _near: Option<f64>,
    ) -> Option<(Target, [f64; 4])> {
        None
    }

    /// Whether the point at `t` of the edge is as near to the filter's curve as the target that was found from the same neighbours,
    /// to rounding: where the curve runs along the edge, all of a stretch is. False from a filter that does not ask.
    fn is_as_near(&self, _edge: &Edge, _before: &[DVec3], _after: &[DVec3], _t: f64, _target: Target) -> bool {
        false
    }

    /// How bad a stretch of line is; step D passes a vertex only if this falls. `points` hold the changed stretch and
    /// `reach` fixed points on each side where there are as many.
    fn measure(&self, points: &[DVec3]) -> f64;
}
