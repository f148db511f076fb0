//! The cubic of the `cubic` filter: through points or nearest to them, and where on an edge it comes nearest.
//!
//! Holds the polynomials and the search on one edge; which points, and at which parameters, is told in `cubic`.

use glam::DVec3;

use super::{MAX_REACH, Target};

/// The nearest point of the curve is sought between the two inner neighbours: first at this many steps, so that no
/// nearer stretch is missed (the squared distance to a line is of degree 6: at most three valleys), then by Newton.
const STEPS: u32 = 8;

/// Newton steps on the curve's parameter; convergence is quadratic, bisection guards it.
const NEWTON_STEPS: u32 = 30;

/// Newton ends when the parameter moves by less than this, on a range of 2: the step after it would be about its square.
const PARAMETER_STEP: f64 = 1e-6;

/// And where it goes on from where the nearest point was before, which is asked for most often.
const NEAR_STEP: f64 = 1e-5;

/// How far, and in how many steps, Newton may go from where the nearest point was before.
const NEIGHBOURHOOD: f64 = 0.125;
/// See [`NEIGHBOURHOOD`].
const NEAR_STEPS: u32 = 6;

/// A power of the parameter is left out when, over the knots, it differs from the lower ones by less than this share of
/// its size (squared): knots that coincide cannot tell it.
const DEPENDENT: f64 = 1e-20;

/// A curve and an edge whose directions differ by less than this (squared sine) are taken for parallel: the nearest point
/// slides along at any speed.
const PARALLEL: f64 = 1e-4;

/// One number for each neighbour.
pub type Row = arrayvec::ArrayVec<f64, { MAX_REACH + 1 }>;

/// A polynomial of degree at most 3 in space.
pub struct Curve {
    coefficients: [DVec3; 4],
}

impl Curve {
    /// Through at most four `points - origin`: Newton's divided differences, then expanded to powers.
    #[inline(always)]
    pub fn through(knots: &[f64], points: &[DVec3], origin: DVec3) -> Self {
        let count = points.len();
        let mut table = [DVec3::ZERO; 4];
        for (entry, &point) in table.iter_mut().zip(points) {
            *entry = point - origin;
        }
        for level in 1..count {
            for i in (level..count).rev() {
                let width = knots[i] - knots[i - level];
                table[i] = if width > 0.0 { (table[i] - table[i - 1]) * (1.0 / width) } else { DVec3::ZERO };
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

    /// How fast the curve goes at parameter `u`.
    #[inline]
    pub fn speed(&self, u: f64) -> DVec3 {
        let c = &self.coefficients;
        c[1] + u * (2.0 * c[2] + u * 3.0 * c[3])
    }

    /// How fast the point at `t` of the edge from the origin to `e` follows when each of four points moves while the knots stay: the
    /// speed is the product with the point's. The curve at `u` is nearest to it. `None` where the curve runs along the edge.
    ///
    /// Both stand still: (c - t e) . c' = 0 and (c - t e) . e = 0; the change of these two, solved for that of t.
    #[inline(always)]
    pub fn foot_weights(&self, knots: &[f64; 4], e: DVec3, u: f64, t: f64) -> Option<[DVec3; 4]> {
        let c = &self.coefficients;
        let off = c[0] + u * (c[1] + u * (c[2] + u * c[3])) - t * e;
        let speed = self.speed(u);
        let bend = 2.0 * c[2] + u * 6.0 * c[3];
        let edge = e.length_squared();
        // Held at an end of the stretch between the inner neighbours, the parameter does not follow.
        let is_held = u.abs() >= 1.0;
        let (along, across) = if is_held { (1.0, 0.0) } else { (speed.dot(speed) + off.dot(bend), speed.dot(e)) };
        let scale = along * edge - across * across;
        // Written so that what is not a number is refused.
        let is_across = scale > PARALLEL * edge * along.abs();
        if !is_across {
            return None;
        }
        let scale = 1.0 / scale;
        let to = [u - knots[0], u - knots[1], u - knots[2], u - knots[3]];
        let mut weights = [DVec3::ZERO; 4];
        for (m, weight) in weights.iter_mut().enumerate() {
            let [p, q, r] = [(m + 1) % 4, (m + 2) % 4, (m + 3) % 4];
            let size = 1.0 / ((knots[m] - knots[p]) * (knots[m] - knots[q]) * (knots[m] - knots[r]));
            let value = to[p] * to[q] * to[r] * size;
            let slope = (to[p] * to[q] + to[q] * to[r] + to[p] * to[r]) * size;
            *weight = (along * value * e - across * (value * speed + slope * off)) * scale;
        }
        Some(weights)
    }

    /// The cubic with the least sum of squared distances to `points - origin` at the knots.
    pub fn nearest_to(basis: &Basis, points: &[DVec3], origin: DVec3) -> Self {
        let mut coefficients = [DVec3::ZERO; 4];
        for (power, values) in basis.powers.iter().zip(&basis.values) {
            let sum: DVec3 = values.iter().zip(points).map(|(&v, &point)| v * (point - origin)).sum();
            coefficients.iter_mut().zip(power).for_each(|(c, &p)| *c += p * sum);
        }
        Self { coefficients }
    }
}

/// Polynomials of degree 0 to 3 that are orthogonal and of unit length over the knots (Forsythe 1957): with them least
/// squares, and interpolation of four points, are plain sums.
pub struct Basis {
    /// Coefficients of the powers of the parameter.
    powers: arrayvec::ArrayVec<[f64; 4], 4>,
    /// Values at the knots.
    values: arrayvec::ArrayVec<Row, 4>,
}

impl Basis {
    /// Of the knots; fewer than four polynomials where the knots are fewer or coincide.
    pub fn over(knots: &[f64]) -> Self {
        let mut basis = Self { powers: arrayvec::ArrayVec::new(), values: arrayvec::ArrayVec::new() };
        let mut power = [1.0, 0.0, 0.0, 0.0];
        let mut values: Row = knots.iter().map(|_| 1.0).collect();
        for _ in 0..knots.len().min(4) {
            // What is left across the lower ones, taken twice: the first leaves rounding behind.
            let size = square_sum(&values);
            for _ in 0..2 {
                for (lower_power, lower) in basis.powers.iter().zip(&basis.values) {
                    let share: f64 = values.iter().zip(lower).map(|(a, b)| a * b).sum();
                    values.iter_mut().zip(lower).for_each(|(v, l)| *v -= share * l);
                    power.iter_mut().zip(lower_power).for_each(|(p, l)| *p -= share * l);
                }
            }
            let rest = square_sum(&values);
            // Written so that a size that is not a number ends it.
            if !(rest > DEPENDENT * size && rest.is_finite()) {
                break;
            }
            let scale = 1.0 / rest.sqrt();
            values.iter_mut().for_each(|v| *v *= scale);
            power.iter_mut().for_each(|p| *p *= scale);
            basis.powers.push(power);
            basis.values.push(values.clone());
            values.iter_mut().zip(knots).for_each(|(v, &u)| *v *= u);
            power = [0.0, power[0], power[1], power[2]];
        }
        basis
    }
}

fn square_sum(values: &[f64]) -> f64 {
    values.iter().map(|v| v * v).sum()
}

/// The squared distance between a point of a curve and a point of the edge from the origin to `e`, as polynomials of the
/// curve's parameter u: a few multiplications where vectors would take dozens. The filter asks millions of times.
struct Distance {
    /// |curve(u)|^2, degree 6.
    square: [f64; 7],
    /// curve(u) . e, degree 3.
    along: [f64; 4],
    /// |e|^2, and one over it.
    edge: f64,
    /// See `edge`.
    per_edge: f64,
}

impl Distance {
    #[inline(always)]
    fn new(curve: &Curve, e: DVec3) -> Self {
        let c = &curve.coefficients;
        let mut square = [0.0; 7];
        for i in 0..4 {
            square[2 * i] += c[i].length_squared();
            for j in i + 1..4 {
                square[i + j] += 2.0 * c[i].dot(c[j]);
            }
        }
        let edge = e.length_squared();
        Self { square, along: c.map(|k| k.dot(e)), edge, per_edge: 1.0 / edge }
    }

    /// Parameter on the edge of the point nearest to curve(u), not clamped.
    #[inline]
    fn foot(&self, u: f64) -> f64 {
        let a = &self.along;
        ((a[0] + u * a[1]) + (u * u) * (a[2] + u * a[3])) * self.per_edge
    }

    #[inline]
    fn at(&self, u: f64) -> f64 {
        let t = self.foot(u).clamp(0.0, 1.0);
        let square = self.square.iter().rev().fold(0.0, |sum, &c| sum * u + c);
        square - t * self.edge * (2.0 * self.foot(u) - t)
    }

    /// The square of the distance between curve(u) and the point at `t` of the edge, wherever on it.
    fn between(&self, u: f64, t: f64) -> f64 {
        let square = self.square.iter().rev().fold(0.0, |sum, &c| sum * u + c);
        square + t * self.edge * (t - 2.0 * self.foot(u))
    }

    /// How steeply the squared distance to the curve rises along the edge from where curve(u) is nearest to it: the factor of the square
    /// of the way. 0 where the curve runs along the edge, and where either is held at an end.
    fn rise(&self, u: f64) -> f64 {
        let raw = self.foot(u);
        if !(raw > 0.0 && raw < 1.0 && u.abs() < 1.0) {
            return 0.0;
        }
        let a = &self.along;
        let slope = a[1] + u * (2.0 * a[2] + u * 3.0 * a[3]);
        let (_, second) = self.derivatives(u);
        let rise = self.edge * second / (second + 2.0 * slope * slope * self.per_edge);
        if second > 0.0 && rise > PARALLEL * self.edge { rise } else { 0.0 }
    }

    /// First and second derivative by u, with the nearest point of the edge following.
    #[inline]
    fn derivatives(&self, u: f64) -> (f64, f64) {
        let s = &self.square;
        let (square, fourth) = (u * u, (u * u) * (u * u));
        // Powers in pairs, so that no product waits for all others.
        let first = (s[1] + u * (2.0 * s[2]))
            + square * (3.0 * s[3] + u * (4.0 * s[4]))
            + fourth * (5.0 * s[5] + u * (6.0 * s[6]));
        let second =
            (2.0 * s[2] + u * (6.0 * s[3])) + square * (12.0 * s[4] + u * (20.0 * s[5])) + fourth * (30.0 * s[6]);
        let a = &self.along;
        let (slope, bend) = ((a[1] + u * (2.0 * a[2])) + square * (3.0 * a[3]), 2.0 * a[2] + u * (6.0 * a[3]));
        let raw = self.foot(u);
        let t = raw.clamp(0.0, 1.0);
        let follows = if raw > 0.0 && raw < 1.0 { 2.0 * slope * slope * self.per_edge } else { 0.0 };
        (first - 2.0 * t * slope, second - 2.0 * t * bend - follows)
    }

    /// What rounding may do to a squared distance here.
    fn slack(&self) -> f64 {
        ROUNDING * self.square.iter().fold(self.edge, |most, c| most.max(c.abs()))
    }

    /// Whether the point at `t` of the edge is further than the pair `nearest` by so much that nothing needs to be sought.
    fn is_far(&self, t: f64, nearest: (f64, f64)) -> bool {
        self.rise(nearest.0) * (t - nearest.1).powi(2) > FAR * self.slack()
    }

    /// Whether some point of the curve is as near to the point at `t` of the edge as the pair `nearest` are to each other.
    fn comes_as_near(&self, t: f64, nearest: (f64, f64)) -> bool {
        let most = self.between(nearest.0, nearest.1) + self.slack();
        // The parameter of the curve from which this point is nearest goes along the edge as the curve does.
        let place = |k: u32| -1.0 + 2.0 * f64::from(k) / f64::from(SEEKS);
        let mut best = (0..=SEEKS).map(place).fold((0.0, f64::INFINITY), |best, u| {
            let d = self.between(u, t);
            if d < best.1 { (u, d) } else { best }
        });
        let mut step = 1.0 / f64::from(SEEKS);
        while best.1 > most && step > FINEST_SEEK {
            for u in [best.0 - step, best.0 + step] {
                let u = u.clamp(-1.0, 1.0);
                let d = self.between(u, t);
                if d < best.1 {
                    best = (u, d);
                }
            }
            step *= 0.5;
        }
        best.1 <= most
    }

    /// The parameter of least distance.
    fn find_lowest(&self, from: f64, to: f64) -> f64 {
        let step = (to - from) / f64::from(STEPS);
        let place = |k: u32| from + step * f64::from(k);
        // The first of equals, counted from the middle: a curve that lies on the edge leaves the vertex in the middle.
        let middle = STEPS / 2;
        let mut best = (middle, self.at(place(middle)));
        for offset in 1..=middle {
            for k in [middle - offset, middle + offset] {
                let d = self.at(place(k));
                if d < best.1 {
                    best = (k, d);
                }
            }
        }
        let (mut low, mut high) = (place(best.0.saturating_sub(1)), place((best.0 + 1).min(STEPS)));
        let mut u = place(best.0);
        for _ in 0..NEWTON_STEPS {
            let (first, second) = self.derivatives(u);
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
        u
    }

    /// The bottom of the valley about `u`, by Newton alone; `None` where that leaves the neighbourhood or the range.
    fn descend_near(&self, u: f64, from: f64, to: f64) -> Option<f64> {
        let (low, high) = ((u - NEIGHBOURHOOD).max(from), (u + NEIGHBOURHOOD).min(to));
        let mut u = u;
        for _ in 0..NEAR_STEPS {
            let (first, second) = self.derivatives(u);
            let next = u - first / second;
            // Written so that what is not a number is refused.
            if !(second > 0.0 && next >= low && next <= high) {
                return None;
            }
            let moved = (next - u).abs();
            u = next;
            if moved <= NEAR_STEP {
                return Some(u);
            }
        }
        None
    }
}

/// The point of the edge from the origin to `e` that is nearest to the curve between parameters `from` and `to`; `None`
/// for an edge of zero length. With `near`, the nearest in the valley that this parameter lies in, if it has one.
#[inline(always)]
pub fn nearest_on_edge(curve: &Curve, e: DVec3, from: f64, to: f64, near: Option<f64>) -> Option<Target> {
    let distance = Distance::new(curve, e);
    if !distance.per_edge.is_finite() {
        return None;
    }
    let u = near.and_then(|u| distance.descend_near(u, from, to)).unwrap_or_else(|| distance.find_lowest(from, to));
    Some(Target { t: distance.foot(u).clamp(0.0, 1.0), on_curve: Some(u) })
}

/// What rounding may do to a squared distance, as a share of the squares of the coordinates that it is made from.
const ROUNDING: f64 = 64.0 * f64::EPSILON;

/// So many times what rounding may do, by the curvature of the valley that the nearest pair lies in, and nothing else is tried.
const FAR: f64 = 16.0;

/// Whether the point at `t` of the edge from the origin to `e` is as near to the curve, between parameters -1 and 1, as the pair
/// `nearest` of a parameter and a place on the edge, to rounding.
pub fn is_as_near(curve: &Curve, e: DVec3, t: f64, nearest: (f64, f64)) -> bool {
    let distance = Distance::new(curve, e);
    !distance.is_far(t, nearest) && distance.comes_as_near(t, nearest)
}

/// Steps in which the nearest parameter of the curve is first sought.
const SEEKS: u32 = 16;

/// And the finest step, which changes a distance by less than rounding does.
const FINEST_SEEK: f64 = 1e-8;

#[cfg(test)]
mod tests {
    use super::*;

    /// Curves from across an edge to along it, flat and not: what is told to be far without seeking is far.
    #[test]
    fn what_rises_too_steeply_comes_nowhere_as_near() {
        let e = DVec3::new(2.0, 0.0, 0.0);
        let mut told = 0;
        for i in 0..4000 {
            let wave = |k: f64| (0.37 * k * f64::from(i) + k).sin();
            let flat = 10f64.powi(-(i % 12));
            let at = |k: f64| DVec3::new(1.0 + 0.8 * wave(k), flat * wave(k + 4.0), flat * wave(k + 8.0));
            let curve = Curve::through(&[-2.0, -1.0, 1.0, 2.0], &[at(1.0), at(2.0), at(3.0), at(4.0)], DVec3::ZERO);
            let Some(found) = nearest_on_edge(&curve, e, -1.0, 1.0, None) else { panic!("an edge with a length") };
            let nearest = (found.on_curve.expect("a curve"), found.t);
            let distance = Distance::new(&curve, e);
            for t in [0.1, 0.5, found.t + 1e-3, found.t - 1e-5, 0.9] {
                let is_far = distance.is_far(t, nearest);
                told += u32::from(is_far);
                assert!(!(is_far && distance.comes_as_near(t, nearest)), "{i} at {t}: {found:?}");
            }
        }
        assert!(told > 2_000, "{told}");
    }
}
