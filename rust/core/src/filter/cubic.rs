//! The `cubic` filter (the paper, section 5): towards the cubic through two neighbours on each side.
//!
//! It keeps the global shape and removes small detail; it leaves points on a cubic alone. It has no useful limit (a closed
//! line's only fixed point is a point): what one sees is where the threshold stopped it. The `fair` filter is the one with
//! a limit.
//!
//! Larger support (the paper's future work): `support` neighbours on each side, and the cubic nearest to them all by least
//! squares, at the same parameters. The point is still sought between the two inner ones.
//!
//! Ends: a vertex near an end, with fewer neighbours on that side, takes as many more of the other side (the paper's: at
//! parameters -1, 1, 2, 3), so that a cubic is left alone up to its ends. On lines too short for that it takes the
//! neighbours that there are; of four or fewer the polynomial through them: a parabola, or the straight line.

use glam::DVec3;

use super::cubic_curve::{Basis, Curve, Row, is_as_near, nearest_on_edge};
use super::{Edge, FourNeighbours, MAX_REACH, SlidingFilter, Target};
use crate::options::{DEFAULT_SUPPORT, Knots};

/// See the module.
#[derive(Clone, Copy, Debug)]
pub struct Cubic {
    /// Parameters of the neighbours.
    pub knots: Knots,
    /// Neighbours on each side, 2 to [`crate::options::MAX_SUPPORT`].
    pub support: usize,
}

/// The most points that a cubic goes through; nearest to more.
const INTERPOLATED: usize = 4;

type Points = arrayvec::ArrayVec<DVec3, { MAX_REACH + 1 }>;

impl SlidingFilter for Cubic {
    fn reach(&self) -> usize {
        self.support
    }

    fn target(&self, edge: &Edge, before: &[DVec3], after: &[DVec3], t: f64, near: Option<f64>) -> Target {
        let unknown = Target { t, on_curve: None };
        if before.is_empty() || after.is_empty() {
            return unknown;
        }
        let points = self.choose_points(before, after);
        let mut knots: Row = points.iter().map(|_| -1.0).collect();
        self.seek(edge, &points, before.len() - 1, &mut knots, near).unwrap_or(unknown)
    }

    #[inline(always)]
    fn target_of_four(
        &self,
        edge: &Edge,
        points: &[DVec3; 4],
        inner: usize,
        t: f64,
        near: Option<f64>,
    ) -> Option<Target> {
        if self.support != DEFAULT_SUPPORT {
            return None;
        }
        // Away from the ends of the line it is always the second: loops that the compiler can unroll.
        let target = match inner {
            1 => self.seek(edge, points, 1, &mut [-1.0; 4], near),
            _ => self.seek(edge, points, inner, &mut [-1.0; 4], near),
        };
        Some(target.unwrap_or(Target { t, on_curve: None }))
    }

    fn target_with_slopes(
        &self,
        edge: &Edge,
        neighbours: &FourNeighbours,
        t: f64,
        near: Option<f64>,
    ) -> Option<(Target, [f64; 4])> {
        if self.support != DEFAULT_SUPPORT {
            return None;
        }
        // As above.
        Some(match neighbours.inner {
            1 => self.follow(edge, neighbours, 1, t, near),
            inner => self.follow(edge, neighbours, inner, t, near),
        })
    }

    fn is_as_near(&self, edge: &Edge, before: &[DVec3], after: &[DVec3], t: f64, target: Target) -> bool {
        let points = self.choose_points(before, after);
        let mut knots: Row = points.iter().map(|_| -1.0).collect();
        let Some(u) = target.on_curve.filter(|_| points.len() <= INTERPOLATED && !before.is_empty()) else {
            return false;
        };
        self.place_knots(&points, before.len() - 1, &mut knots)
            && is_as_near(&Curve::through(&knots, &points, edge.low), edge.high - edge.low, t, (u, target.t))
    }

    /// The bending energy of the polyline: squared turn of its direction over half the length of the two segments.
    fn measure(&self, points: &[DVec3]) -> f64 {
        let mut distinct: Vec<DVec3> = points.to_vec();
        distinct.dedup();
        let bend = |p: &[DVec3]| {
            let (u, v) = (p[1] - p[0], p[2] - p[1]);
            (v.normalize() - u.normalize()).length_squared() * 2.0 / (u.length() + v.length())
        };
        distinct.windows(3).map(bend).sum()
    }
}

impl Cubic {
    /// The neighbours in the order of the line.
    fn choose_points(&self, before: &[DVec3], after: &[DVec3]) -> Points {
        before.iter().rev().chain(after).copied().take(2 * self.support).collect()
    }

    /// The target of a vertex between four neighbours, the one at `inner` next to it, and how fast it follows each of them.
    #[inline(always)]
    fn follow(
        &self,
        edge: &Edge,
        neighbours: &FourNeighbours,
        inner: usize,
        t: f64,
        near: Option<f64>,
    ) -> (Target, [f64; 4]) {
        let &FourNeighbours { points, slides, .. } = neighbours;
        let unknown = (Target { t, on_curve: None }, [0.0; 4]);
        let e = edge.high - edge.low;
        let mut knots = [-1.0; 4];
        if !self.place_knots(&points, inner, &mut knots) {
            let foot = (points[inner] - edge.low).dot(e) / e.length_squared();
            let target = foot.is_finite().then(|| Target { t: foot.clamp(0.0, 1.0), on_curve: None });
            return target.map_or(unknown, |target| (target, [0.0; 4]));
        }
        let curve = Curve::through(&knots, &points, edge.low);
        let Some(target) = nearest_on_edge(&curve, e, -1.0, 1.0, near) else { return unknown };
        let is_held = target.t == 0.0 || target.t == 1.0;
        let Some(u) = target.on_curve.filter(|_| !is_held) else { return (target, [0.0; 4]) };
        let Some(weights) = curve.foot_weights(&knots, e, u, target.t) else { return (target, [0.0; 4]) };
        let mut slopes: [f64; 4] = std::array::from_fn(|m| weights[m].dot(slides[m]));
        // A knot that moves takes the curve along by its own speed there, backwards.
        let power = match self.knots {
            Knots::Uniform => return (target, slopes),
            Knots::Centripetal => 0.5,
            Knots::Chordal => 1.0,
        };
        // How fast the logarithm of each gap grows with the points at its two ends.
        let stretch: [DVec3; 3] = std::array::from_fn(|i| {
            let way = points[i + 1] - points[i];
            way * (1.0 / way.length_squared())
        });
        let log_speed = |gap: usize, m: usize| match m {
            _ if m == gap => -stretch[gap].dot(slides[m]),
            _ if m == gap + 1 => stretch[gap].dot(slides[m]),
            _ => 0.0,
        };
        for (outer, sign) in [(0, -1.0), (1, -1.0), (2, 1.0), (3, 1.0)] {
            if outer == inner || outer == inner + 1 || (sign < 0.0) != (outer < inner) {
                continue;
            }
            let drag = weights[outer].dot(curve.speed(knots[outer]));
            let gaps = if outer < inner { outer..inner } else { inner + 1..outer };
            for gap in gaps {
                let step = knots[gap + 1] - knots[gap];
                for (m, slope) in slopes.iter_mut().enumerate() {
                    *slope -= drag * sign * power * step * (log_speed(gap, m) - log_speed(inner, m));
                }
            }
        }
        (target, if slopes.iter().all(|s| s.is_finite()) { slopes } else { [0.0; 4] })
    }

    /// Where a vertex on `edge` belongs between `points`, of which `inner` and `inner + 1` are next to it; `None` when they
    /// do not tell. `knots` is space for one number a point, filled with -1.
    #[inline(always)]
    fn seek(
        &self,
        edge: &Edge,
        points: &[DVec3],
        inner: usize,
        knots: &mut [f64],
        near: Option<f64>,
    ) -> Option<Target> {
        let e = edge.high - edge.low;
        if !self.place_knots(points, inner, knots) {
            let foot = (points[inner] - edge.low).dot(e) / e.length_squared();
            return foot.is_finite().then(|| Target { t: foot.clamp(0.0, 1.0), on_curve: None });
        }
        let curve = if points.len() <= INTERPOLATED {
            Curve::through(knots, points, edge.low)
        } else {
            Curve::nearest_to(&Basis::over(knots), points, edge.low)
        };
        nearest_on_edge(&curve, e, -1.0, 1.0, near)
    }

    /// Parameters of the neighbours: -1 and 1 for the inner ones, which are at `inner` and `inner + 1`; false where these
    /// two are in one place, next to which every other step is endless.
    ///
    /// Steps are taken from ratios of distances and by square roots alone: the same to the bit at every size, on every
    /// machine.
    #[inline(always)]
    fn place_knots(&self, points: &[DVec3], inner: usize, knots: &mut [f64]) -> bool {
        let inner_gap = points[inner].distance(points[inner + 1]);
        let step = |i: usize| self.step(points[i].distance(points[i + 1]), inner_gap);
        for i in (0..inner).rev() {
            knots[i] = knots[i + 1] - step(i);
        }
        knots[inner + 1] = 1.0;
        for i in inner + 1..points.len() - 1 {
            knots[i + 1] = knots[i] + step(i);
        }
        knots.iter().all(|k| k.is_finite())
    }

    /// From a neighbour to the next one, `gap` away, where the inner two are `inner_gap` apart.
    #[inline(always)]
    fn step(&self, gap: f64, inner_gap: f64) -> f64 {
        match self.knots {
            Knots::Uniform => 1.0,
            Knots::Centripetal => 2.0 * (gap / inner_gap).sqrt(),
            Knots::Chordal => 2.0 * (gap / inner_gap),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The paper's own form.
    const UNIFORM: Cubic = Cubic { knots: Knots::Uniform, support: DEFAULT_SUPPORT };

    fn on_cubic(u: f64) -> DVec3 {
        DVec3::new(u + 0.1 * u * u, 0.4 * u * u * u - u, 0.2 * u * u)
    }

    #[test]
    fn a_vertex_on_the_cubic_of_its_neighbours_stays() {
        let here = on_cubic(0.0);
        for direction in [DVec3::Z, DVec3::new(1.0, 2.0, 0.3), DVec3::new(-1.0, 0.5, 2.0)] {
            let edge = Edge { low: here - 0.3 * direction, high: here + 0.7 * direction };
            let before = [on_cubic(-1.0), on_cubic(-2.0)];
            let after = [on_cubic(1.0), on_cubic(2.0)];
            let t = UNIFORM.target(&edge, &before, &after, 0.9, None).t;
            assert!((t - 0.3).abs() < 1e-12, "{t}");
        }
    }

    /// Against differences, for all knots, in the middle and near both ends.
    #[test]
    fn slopes_tell_how_the_target_follows_the_neighbours() {
        let on = |u: f64| DVec3::new(u, 0.3 * u * u - 0.1 * u, 0.2 * (1.3 * u).sin());
        let slides = [DVec3::new(0.2, 0.9, 0.1), DVec3::new(-0.3, 1.1, 0.2), DVec3::new(0.1, 0.8, -0.3), DVec3::Y];
        let edge = Edge { low: DVec3::new(0.1, -0.7, 0.05), high: DVec3::new(-0.2, 0.9, 0.2) };
        for knots in [Knots::Uniform, Knots::Centripetal, Knots::Chordal] {
            for (inner, at) in [(1, [-2.3, -1.2, 0.8, 2.1]), (0, [-0.8, 0.9, 1.7, 3.0]), (2, [-2.9, -1.4, -0.6, 1.1])] {
                let cubic = Cubic { knots, ..UNIFORM };
                let points = at.map(on);
                let ask = |points: [DVec3; 4]| {
                    cubic
                        .target_with_slopes(&edge, &FourNeighbours { points, slides, inner }, 0.5, None)
                        .expect("support 2")
                };
                let (target, slopes) = ask(points);
                let before: Vec<DVec3> = points[..=inner].iter().rev().copied().collect();
                assert_eq!(target, cubic.target(&edge, &before, &points[inner + 1..], 0.5, None));
                assert!(target.t > 0.0 && target.t < 1.0, "{target:?}");
                for m in 0..4 {
                    let moved = |h: f64| {
                        let mut points = points;
                        points[m] += h * slides[m];
                        ask(points).0.t
                    };
                    let slope = (moved(1e-4) - moved(-1e-4)) / 2e-4;
                    assert!((slopes[m] - slope).abs() < 1e-5, "{knots:?} {inner} {m}: {} {slope}", slopes[m]);
                }
            }
        }
    }

    #[test]
    fn three_neighbours_give_a_parabola_and_two_a_line() {
        let parabola = |u: f64| DVec3::new(u, u * u, 0.0);
        let edge = Edge { low: DVec3::new(0.0, -1.0, 0.0), high: DVec3::new(0.0, 3.0, 0.0) };
        let cubic = UNIFORM;
        let t = cubic.target(&edge, &[parabola(-1.0)], &[parabola(1.0), parabola(2.0)], 0.9, None).t;
        assert!((t - 0.25).abs() < 1e-12, "{t}");
        let t = cubic.target(&edge, &[parabola(-1.0), parabola(-2.0)], &[parabola(1.0)], 0.9, None).t;
        assert!((t - 0.25).abs() < 1e-12, "{t}");
        let t = cubic.target(&edge, &[parabola(-1.0)], &[parabola(1.0)], 0.9, None).t;
        assert!((t - 0.5).abs() < 1e-12, "{t}");
    }

    #[test]
    fn only_on_a_curve_along_its_edge_other_places_are_as_near() {
        let edge = Edge { low: DVec3::ZERO, high: DVec3::new(4.0, 0.0, 0.0) };
        let ask = |height: f64, t: f64| {
            let at = |x: f64| DVec3::new(x, height * x * x, 0.0);
            let (before, after) = ([at(1.0), at(0.0)], [at(3.0), at(4.0)]);
            let target = UNIFORM.target(&edge, &before, &after, t, None);
            UNIFORM.is_as_near(&edge, &before, &after, t, target)
        };
        assert!(ask(0.0, 0.3) && ask(0.0, 0.7), "the curve goes from 1/4 to 3/4 of the edge, and lies on it");
        assert!(!ask(0.0, 0.1) && !ask(0.0, 0.9), "beyond");
        assert!(!ask(1e-3, 0.7), "it only comes near the edge");
    }

    #[test]
    fn chordal_knots_keep_a_straight_line_with_uneven_steps() {
        let edge = Edge { low: DVec3::new(0.0, -1.0, 0.0), high: DVec3::new(0.0, 1.0, 0.0) };
        let at = |x: f64| DVec3::new(x, 0.0, 0.0);
        for knots in [Knots::Uniform, Knots::Centripetal, Knots::Chordal] {
            let t = Cubic { knots, ..UNIFORM }.target(&edge, &[at(-0.1), at(-3.0)], &[at(2.0), at(2.1)], 0.9, None).t;
            assert!((t - 0.5).abs() < 1e-9, "{knots:?} {t}");
        }
    }

    #[test]
    fn a_vertex_on_the_cubic_of_more_neighbours_stays_also_near_an_end() {
        let here = on_cubic(0.0);
        let edge = Edge { low: here - DVec3::Z, high: here + 3.0 * DVec3::Z };
        for support in [3, 4, 16] {
            let cubic = Cubic { support, ..UNIFORM };
            for count in [1, 2, support] {
                let before: Vec<DVec3> = (1..=count).map(|i| on_cubic(-(i as f64))).collect();
                let after: Vec<DVec3> = (1..=2 * support - count).map(|i| on_cubic(i as f64)).collect();
                let t = cubic.target(&edge, &before, &after, 0.9, None).t;
                assert!((t - 0.25).abs() < 1e-9, "support {support}, {count} before: {t}");
            }
        }
    }

    #[test]
    fn the_least_squares_cubic_leaves_out_what_is_no_cubic() {
        // Heights that are orthogonal to all cubics over the six uniform knots -3 to 3: the fifth difference's weights
        // over knots with a gap in the middle, found by Lagrange's formula.
        let knots = [-3.0, -2.0, -1.0, 1.0, 2.0, 3.0f64];
        let weight = |i: usize| (0..6).filter(|&j| j != i).map(|j| 1.0 / (knots[i] - knots[j])).product::<f64>();
        let at = |i: usize| DVec3::new(knots[i], 10.0 * weight(i), 0.0);
        let edge = Edge { low: DVec3::new(0.0, -1.0, 0.0), high: DVec3::new(0.0, 1.0, 0.0) };
        let cubic = Cubic { support: 3, ..UNIFORM };
        let t = cubic.target(&edge, &[at(2), at(1), at(0)], &[at(3), at(4), at(5)], 0.9, None).t;
        assert!((t - 0.5).abs() < 1e-12, "{t}");
    }

    #[test]
    fn between_neighbours_in_one_place_a_vertex_belongs_next_to_it() {
        let edge = Edge { low: DVec3::new(0.0, -1.0, 0.0), high: DVec3::new(0.0, 3.0, 0.0) };
        let (far, place) = (DVec3::new(-5.0, 3.0, 0.0), DVec3::new(0.5, 0.0, 0.0));
        for knots in [Knots::Centripetal, Knots::Chordal] {
            let t = Cubic { knots, ..UNIFORM }.target(&edge, &[place, far], &[place, -far], 0.9, None).t;
            assert!((t - 0.25).abs() < 1e-12, "{knots:?}: {t}");
        }
    }
}
