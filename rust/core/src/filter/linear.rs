//! The `linear` filter (the paper, section 5): towards the straight line through both neighbours.
//!
//! It straightens: in a plane its limit is the straight line. On a folded surface it is *not* the geodesic: on a
//! right-angled fold with distances 1 : 3 it crosses at 0.10 of the way instead of 0.25.

use glam::DVec3;

use super::{Edge, SlidingFilter};

/// See the module.
#[derive(Clone, Copy, Debug, Default)]
pub struct Linear;

impl SlidingFilter for Linear {
    fn reach(&self) -> usize {
        1
    }

    /// The point of the edge that is nearest to the infinite line through the neighbours, clamped to the edge.
    ///
    /// Both neighbours in one place: the point of the edge nearest to it. The line parallel to the edge, or an edge of
    /// zero length: `t`.
    fn target(&self, edge: &Edge, before: &[DVec3], after: &[DVec3], t: f64) -> f64 {
        let (Some(&p), Some(&q)) = (before.first(), after.first()) else { return t };
        let (e, d) = (edge.high - edge.low, q - p);
        // Components of the edge and of (p - low) across the line.
        let length = d.length_squared();
        let across = |v: DVec3| if length > 0.0 { v - d * (v.dot(d) / length) } else { v };
        let (e_across, offset) = (across(e), across(p - edge.low));
        let square = e_across.length_squared();
        if square <= PARALLEL * e.length_squared() {
            return t;
        }
        (offset.dot(e_across) / square).clamp(0.0, 1.0)
    }

    fn measure(&self, points: &[DVec3]) -> f64 {
        points.windows(2).map(|p| p[0].distance(p[1])).sum()
    }
}

/// Squared sine below which an edge counts as parallel to the line: the square of 1e-14, the rounding of a direction.
const PARALLEL: f64 = 1e-28;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn on_a_right_angled_fold_it_crosses_where_the_paper_says_and_not_at_the_geodesic() {
        // The fold is the x axis; one neighbour 1 away on one side, the other 3 away on the other, 1 along.
        let edge = Edge { low: DVec3::new(-1.0, 0.0, 0.0), high: DVec3::new(2.0, 0.0, 0.0) };
        let (p, q) = (DVec3::new(0.0, 1.0, 0.0), DVec3::new(1.0, 0.0, 3.0));
        let t = Linear.target(&edge, &[p], &[q], 0.5);
        assert!((edge.at(t).x - 0.1).abs() < 1e-12, "{}", edge.at(t).x);
    }

    #[test]
    fn degenerate_neighbours_are_defined() {
        let edge = Edge { low: DVec3::ZERO, high: DVec3::X };
        let p = DVec3::new(0.3, 1.0, 0.0);
        assert!((Linear.target(&edge, &[p], &[p], 0.9) - 0.3).abs() < 1e-15, "one place: the nearest point");
        assert_eq!(Linear.target(&edge, &[p], &[p + DVec3::X], 0.9), 0.9, "parallel: stay");
        assert_eq!(Linear.target(&Edge { low: p, high: p }, &[p], &[p], 0.4), 0.4, "no length: stay");
    }
}
