//! The `linear` filter (the paper, section 5): towards the straight line through both neighbours.
//!
//! It straightens: in a plane its limit is the straight line. On a folded surface it is *not* the geodesic: on a
//! right-angled fold with distances 1 : 3 it crosses at 0.10 of the way instead of 0.25.

use glam::DVec3;

use super::{Edge, SlidingFilter, Target};

/// See the module.
#[derive(Clone, Copy, Debug, Default)]
pub struct Linear;

impl SlidingFilter for Linear {
    fn reach(&self) -> usize {
        1
    }

    /// See [`target_with_slopes`]; clamped to the edge.
    fn target(&self, edge: &Edge, before: &[DVec3], after: &[DVec3], t: f64, _near: Option<f64>) -> Target {
        let target = match (before.first(), after.first()) {
            (Some(&p), Some(&q)) => {
                target_with_slopes(edge, (p, DVec3::ZERO), (q, DVec3::ZERO), t).target.clamp(0.0, 1.0)
            }
            _ => t,
        };
        Target { t: target, on_curve: None }
    }

    fn measure(&self, points: &[DVec3]) -> f64 {
        points.windows(2).map(|p| p[0].distance(p[1])).sum()
    }
}

/// Where a vertex belongs, and how that changes with its neighbours.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct TargetSlopes {
    /// Parameter on the edge, not clamped.
    pub target: f64,
    /// Change of the target when the neighbour before, after moves along its own edge, for each unit of its parameter.
    pub slopes: [f64; 2],
}

/// The point of the edge's line that is nearest to the infinite line through the neighbours `p` and `q`, each given with
/// the vector that it slides along.
///
/// Both neighbours in one place: the point nearest to it. The line parallel to the edge, or an edge of zero length: `t`.
pub fn target_with_slopes(
    edge: &Edge,
    (p, p_slide): (DVec3, DVec3),
    (q, q_slide): (DVec3, DVec3),
    t: f64,
) -> TargetSlopes {
    let (e, a, d) = (edge.high - edge.low, p - edge.low, q - p);
    let square = d.length_squared();
    // target = (a across . e) / (e across . e), where "across" leaves out what is along d.
    let (ad, ed) = if square > 0.0 { (a.dot(d) / square, e.dot(d) / square) } else { (0.0, 0.0) };
    let e_across = e - d * ed;
    let below = e_across.length_squared();
    if below <= PARALLEL * e.length_squared() {
        return TargetSlopes { target: t, slopes: [0.0; 2] };
    }
    let target = (a - d * ad).dot(e_across) / below;
    if square == 0.0 {
        return TargetSlopes { target, slopes: [0.0; 2] };
    }
    let slope = |da: DVec3, dd: DVec3| {
        let along = 2.0 * d.dot(dd);
        let above = da.dot(e) - (da.dot(d) + a.dot(dd)) * ed - ad * e.dot(dd) + ad * ed * along;
        above - target * (ed * ed * along - 2.0 * ed * e.dot(dd))
    };
    TargetSlopes { target, slopes: [slope(p_slide, -p_slide) / below, slope(DVec3::ZERO, q_slide) / below] }
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
        let t = Linear.target(&edge, &[p], &[q], 0.5, None).t;
        assert!((edge.at(t).x - 0.1).abs() < 1e-12, "{}", edge.at(t).x);
    }

    #[test]
    fn slopes_are_the_derivatives_of_the_target() {
        let edge = Edge { low: DVec3::new(0.1, -1.0, 0.2), high: DVec3::new(0.3, 2.0, -0.5) };
        let (p, q) = (DVec3::new(-1.0, 0.2, 0.1), DVec3::new(1.5, 0.4, 0.6));
        let (u, v) = (DVec3::new(0.2, 0.9, 0.4), DVec3::new(-0.3, 1.1, 0.2));
        let at = |s: f64, r: f64| target_with_slopes(&edge, (p + s * u, u), (q + r * v, v), 0.0);
        let h = 1e-6;
        let by_p = (at(h, 0.0).target - at(-h, 0.0).target) / (2.0 * h);
        let by_q = (at(0.0, h).target - at(0.0, -h).target) / (2.0 * h);
        let slopes = at(0.0, 0.0).slopes;
        assert!((slopes[0] - by_p).abs() < 1e-8 && (slopes[1] - by_q).abs() < 1e-8, "{slopes:?} {by_p} {by_q}");
    }

    #[test]
    fn degenerate_neighbours_are_defined() {
        let edge = Edge { low: DVec3::ZERO, high: DVec3::X };
        let p = DVec3::new(0.3, 1.0, 0.0);
        assert!((Linear.target(&edge, &[p], &[p], 0.9, None).t - 0.3).abs() < 1e-15, "one place: the nearest point");
        assert_eq!(Linear.target(&edge, &[p], &[p + DVec3::X], 0.9, None).t, 0.9, "parallel: stay");
        assert_eq!(Linear.target(&Edge { low: p, high: p }, &[p], &[p], 0.4, None).t, 0.4, "no length: stay");
    }
}
