//! The `cubic` filter (the paper, section 5): towards the cubic through two neighbours on each side.
//!
//! It keeps the global shape and removes small detail; it leaves points on a cubic with uniform parameters alone. It has
//! no useful limit (a closed line's only fixed point is a point): what one sees is where the threshold stopped it. The
//! `fair` filter is the one with a limit.
//!
//! Ends: a vertex next to an end, with a single neighbour on that side, takes three of the other side, at parameters
//! -1, 1, 2, 3, so that a cubic is left alone up to its ends. On lines too short for that it takes the polynomial through
//! the neighbours that there are: a parabola, or the straight line.

use glam::DVec3;

use super::{Edge, SlidingFilter};
use crate::options::Knots;

/// See the module.
#[derive(Clone, Copy, Debug, Default)]
pub struct Cubic {
    /// Parameters at which the neighbours are interpolated.
    pub knots: Knots,
}

/// The nearest point of the curve is sought between the two inner neighbours: first at this many steps, so that no
/// nearer stretch is missed (the squared distance to a line is of degree 6: at most three valleys), then by Newton.
const STEPS: u32 = 8;

/// Newton steps on the curve's parameter; convergence is quadratic, bisection guards it.
const NEWTON_STEPS: u32 = 30;

/// Newton ends when the parameter moves by less than this, on a range of 2: the step after it would be its square.
const PARAMETER_STEP: f64 = 1e-9;

impl SlidingFilter for Cubic {
    fn reach(&self) -> usize {
        2
    }

    fn target(&self, edge: &Edge, before: &[DVec3], after: &[DVec3], t: f64) -> f64 {
        if before.is_empty() || after.is_empty() {
            return t;
        }
        let points: arrayvec::ArrayVec<DVec3, 4> = before.iter().rev().chain(after).copied().take(4).collect();
        let inner = before.len() - 1;
        let knots = self.place_knots(&points, inner);
        let curve = Curve::through(&knots, &points, edge.low);
        nearest_on_edge(&curve, edge.high - edge.low, knots[inner], knots[inner + 1]).unwrap_or(t)
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
    /// Parameters of the neighbours: -1 and 1 for the inner ones, which are at `inner` and `inner + 1`.
    fn place_knots(&self, points: &[DVec3], inner: usize) -> arrayvec::ArrayVec<f64, 4> {
        let mut knots = arrayvec::ArrayVec::new();
        let power = match self.knots {
            Knots::Uniform => {
                // The vertex itself has parameter 0, which is left out.
                knots.extend(
                    (0..points.len())
                        .map(|i| if i <= inner { i as f64 - inner as f64 - 1.0 } else { (i - inner) as f64 }),
                );
                return knots;
            }
            Knots::Centripetal => 0.5,
            Knots::Chordal => 1.0,
        };
        let mut knot = 0.0;
        for (i, &point) in points.iter().enumerate() {
            if i > 0 {
                knot += points[i - 1].distance(point).powf(power);
            }
            knots.push(knot);
        }
        // The gap between the inner neighbours becomes -1..1, as in the uniform form.
        let (a, b) = (knots[inner], knots[inner + 1]);
        let (middle, half) = (0.5 * (a + b), 0.5 * (b - a));
        knots.iter_mut().for_each(|k| *k = if half > 0.0 { (*k - middle) / half } else { 0.0 });
        knots
    }
}

/// A polynomial of degree at most 3 in space.
struct Curve {
    coefficients: [DVec3; 4],
}

impl Curve {
    /// Newton's divided differences through `points - origin`, then expanded to powers.
    fn through(knots: &[f64], points: &[DVec3], origin: DVec3) -> Self {
        let count = points.len();
        let mut table = [DVec3::ZERO; 4];
        for (entry, &point) in table.iter_mut().zip(points) {
            *entry = point - origin;
        }
        for level in 1..count {
            for i in (level..count).rev() {
                let width = knots[i] - knots[i - level];
                table[i] = if width > 0.0 { (table[i] - table[i - 1]) / width } else { DVec3::ZERO };
            }
        }
        let mut coefficients = [DVec3::ZERO; 4];
        for i in (0..count).rev() {
            // coefficients = coefficients * (u - knots[i]) + table[i]
            for k in (1..4).rev() {
                coefficients[k] = coefficients[k - 1] - coefficients[k] * knots[i];
            }
            coefficients[0] = table[i] - coefficients[0] * knots[i];
        }
        Self { coefficients }
    }
}

/// The squared distance between a point of a curve and a point of the edge from the origin to `e`, as polynomials of the
/// curve's parameter u: a few multiplications where vectors would take dozens. The filter asks millions of times.
struct Distance {
    /// |curve(u)|^2, degree 6.
    square: [f64; 7],
    /// curve(u) . e, degree 3.
    along: [f64; 4],
    /// |e|^2.
    edge: f64,
}

impl Distance {
    fn new(curve: &Curve, e: DVec3) -> Self {
        let c = &curve.coefficients;
        let mut square = [0.0; 7];
        for i in 0..4 {
            for j in 0..4 {
                square[i + j] += c[i].dot(c[j]);
            }
        }
        Self { square, along: c.map(|k| k.dot(e)), edge: e.length_squared() }
    }

    /// Parameter on the edge of the point nearest to curve(u), not clamped.
    #[inline]
    fn foot(&self, u: f64) -> f64 {
        let a = &self.along;
        (a[0] + u * (a[1] + u * (a[2] + u * a[3]))) / self.edge
    }

    #[inline]
    fn at(&self, u: f64) -> f64 {
        let t = self.foot(u).clamp(0.0, 1.0);
        let square = self.square.iter().rev().fold(0.0, |sum, &c| sum * u + c);
        square - t * self.edge * (2.0 * self.foot(u) - t)
    }

    /// First and second derivative by u, with the nearest point of the edge following.
    #[inline]
    fn derivatives(&self, u: f64) -> (f64, f64) {
        let s = &self.square;
        let first = s[1] + u * (2.0 * s[2] + u * (3.0 * s[3] + u * (4.0 * s[4] + u * (5.0 * s[5] + u * 6.0 * s[6]))));
        let second = 2.0 * s[2] + u * (6.0 * s[3] + u * (12.0 * s[4] + u * (20.0 * s[5] + u * 30.0 * s[6])));
        let a = &self.along;
        let (slope, bend) = (a[1] + u * (2.0 * a[2] + u * 3.0 * a[3]), 2.0 * a[2] + u * 6.0 * a[3]);
        let raw = self.foot(u);
        let t = raw.clamp(0.0, 1.0);
        let follows = if raw > 0.0 && raw < 1.0 { 2.0 * slope * slope / self.edge } else { 0.0 };
        (first - 2.0 * t * slope, second - 2.0 * t * bend - follows)
    }
}

/// Parameter on the edge from the origin to `e` of its point nearest to the curve between parameters `from` and `to`;
/// `None` for an edge of zero length.
fn nearest_on_edge(curve: &Curve, e: DVec3, from: f64, to: f64) -> Option<f64> {
    let distance = Distance::new(curve, e);
    if distance.edge == 0.0 {
        return None;
    }
    let step = (to - from) / f64::from(STEPS);
    let place = |k: u32| from + step * f64::from(k);
    // The first of equals, counted from the middle: a curve that lies on the edge leaves the vertex in the middle.
    let middle = STEPS / 2;
    let mut best = (middle, distance.at(place(middle)));
    for offset in 1..=middle {
        for k in [middle - offset, middle + offset] {
            let d = distance.at(place(k));
            if d < best.1 {
                best = (k, d);
            }
        }
    }
    let (mut low, mut high) = (place(best.0.saturating_sub(1)), place((best.0 + 1).min(STEPS)));
    let mut u = place(best.0);
    for _ in 0..NEWTON_STEPS {
        let (first, second) = distance.derivatives(u);
        if first > 0.0 {
            high = u
        } else {
            low = u
        }
        let newton = u - first / second;
        let next = if second > 0.0 && newton >= low && newton <= high { newton } else { 0.5 * (low + high) };
        let moved = (next - u).abs();
        u = next;
        if moved <= PARAMETER_STEP {
            break;
        }
    }
    Some(distance.foot(u).clamp(0.0, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

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
            let t = Cubic::default().target(&edge, &before, &after, 0.9);
            assert!((t - 0.3).abs() < 1e-12, "{t}");
        }
    }

    #[test]
    fn three_neighbours_give_a_parabola_and_two_a_line() {
        let parabola = |u: f64| DVec3::new(u, u * u, 0.0);
        let edge = Edge { low: DVec3::new(0.0, -1.0, 0.0), high: DVec3::new(0.0, 3.0, 0.0) };
        let cubic = Cubic::default();
        let t = cubic.target(&edge, &[parabola(-1.0)], &[parabola(1.0), parabola(2.0)], 0.9);
        assert!((t - 0.25).abs() < 1e-12, "{t}");
        let t = cubic.target(&edge, &[parabola(-1.0), parabola(-2.0)], &[parabola(1.0)], 0.9);
        assert!((t - 0.25).abs() < 1e-12, "{t}");
        let t = cubic.target(&edge, &[parabola(-1.0)], &[parabola(1.0)], 0.9);
        assert!((t - 0.5).abs() < 1e-12, "{t}");
    }

    #[test]
    fn chordal_knots_keep_a_straight_line_with_uneven_steps() {
        let edge = Edge { low: DVec3::new(0.0, -1.0, 0.0), high: DVec3::new(0.0, 1.0, 0.0) };
        let at = |x: f64| DVec3::new(x, 0.0, 0.0);
        for knots in [Knots::Uniform, Knots::Centripetal, Knots::Chordal] {
            let t = Cubic { knots }.target(&edge, &[at(-0.1), at(-3.0)], &[at(2.0), at(2.1)], 0.9);
            assert!((t - 0.5).abs() < 1e-9, "{knots:?} {t}");
        }
    }
}
