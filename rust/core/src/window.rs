//! Windows: the part of a mesh edge that straight lines from one source reach through a strip, in the unfolded plane.
//!
//! ```text
//!              apex                 The triangle that is entered across the edge from A to B is laid in the plane with
//!             /    \                that edge on the x axis, A at 0, the apex above. The source, unfolded back along the
//!            /      \               strip, lies below at (x, -y). Lines from it pass the edge between `low` and `high`:
//!           /  |  |  \              what the strip's earlier edges leave of the view. Behind each of the two other sides
//!      A --/---[==]---\-- B         the view goes on as a window of that side; to a side that is out of view the line
//!              |  /                 bends at the end of the window that is nearer to it.
//!              | /
//!            source
//! ```
//!
//! Every point of a window is reached by a line on the surface of the length that the window tells, so a window never
//! promises too little. Source: J. Mitchell, D. Mount, C. Papadimitriou 1987, *The Discrete Geodesic Problem*; here a
//! view is never cut by another one, and a line may bend inside an edge, where theirs bends at vertices alone.

use glam::{DVec2, DVec3};

/// A window on a directed edge; all lengths in the units of the positions.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Window {
    /// Place of the source along the edge.
    pub x: f64,
    /// Distance of the source from the edge's line; never negative.
    pub y: f64,
    /// Length of the line up to the source.
    pub behind: f64,
    /// Where the view begins, along the edge.
    pub low: f64,
    /// Where it ends.
    pub high: f64,
}

/// A triangle in the plane, with the edge that is entered on the x axis from 0 on.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct FlatTriangle {
    /// Length of the edge that is entered.
    pub base: f64,
    /// The apex; never below the x axis.
    pub apex: DVec2,
    /// Length of the side from the edge's first end to the apex.
    pub first_side: f64,
    /// Length of the side from the edge's second end to the apex.
    pub second_side: f64,
}

impl FlatTriangle {
    /// The triangle with the edge from `a` to `b`, of length `base`, and the apex `c`.
    #[inline]
    pub fn new([a, b, c]: [DVec3; 3], base: f64) -> Self {
        let (edge, side) = (b - a, c - a);
        // An edge without length leaves the direction free: every line passes its point.
        let apex = if base == 0.0 {
            DVec2::new(0.0, side.length())
        } else {
            DVec2::new(side.dot(edge) / base, side.cross(edge).length() / base)
        };
        Self { base, apex, first_side: side.length(), second_side: c.distance(b) }
    }

    /// The same triangle with the ends of its edge swapped.
    #[inline]
    pub fn mirrored(&self) -> Self {
        Self {
            base: self.base,
            apex: DVec2::new(self.base - self.apex.x, self.apex.y),
            first_side: self.second_side,
            second_side: self.first_side,
        }
    }
}

impl Window {
    /// All of the edge from `a` to `b`, of length `length`, seen from `source`.
    pub fn whole(source: DVec3, a: DVec3, b: DVec3, length: f64) -> Self {
        let offset = source - a;
        if length == 0.0 {
            return Self { x: 0.0, y: offset.length(), behind: 0.0, low: 0.0, high: 0.0 };
        }
        let along = (b - a) / length;
        Self { x: offset.dot(along), y: offset.cross(along).length(), behind: 0.0, low: 0.0, high: length }
    }

    /// The same window on the edge of length `length` in the other direction.
    #[inline]
    pub fn reversed(&self, length: f64) -> Self {
        Self { x: length - self.x, low: length - self.high, high: length - self.low, ..*self }
    }

    /// The same window where `is_upward`, else reversed. Without a branch: of the edges of a mesh as many run one way as the
    /// other, so that it would be guessed wrong every other time. Nothing is rounded that [`Window::reversed`] does not round:
    /// 0 is added, and 1 or -1 multiplied.
    #[inline]
    pub fn upward(&self, length: f64, is_upward: bool) -> Self {
        let way = usize::from(is_upward);
        let (from, sign) = ([1.0, 0.0][way] * length, [-1.0, 1.0][way]);
        let [a, b] = [from + sign * self.low, from + sign * self.high];
        Self { x: from + sign * self.x, low: least(a, b), high: most(a, b), ..*self }
    }

    /// The window on the side of `triangle` from the first end of its edge to the apex, in that direction.
    // In line, as it is called for two sides: else results go through memory: measured across camel, 7 % more instructions a search.
    #[inline(always)]
    pub fn behind_first_side(&self, triangle: &FlatTriangle) -> Self {
        let (DVec2 { x: cx, y: cy }, side) = (triangle.apex, triangle.first_side);
        if triangle.base == 0.0 || side == 0.0 {
            // All lines pass the one point of an edge without length; a side without length is a point as well.
            let at = if triangle.base == 0.0 { 0.0 } else { self.low };
            let behind = self.behind + (self.x - at).hypot(self.y);
            let rest = if triangle.base == 0.0 { 0.0 } else { at };
            return Self { x: 0.0, y: rest, behind, low: 0.0, high: side };
        }
        let bend_at = |at: f64| {
            let behind = self.behind + length(at - self.x, self.y);
            Self { x: at * cx / side, y: at * cy / side, behind, low: 0.0, high: side }
        };
        if self.y == 0.0 {
            return bend_at(least(most(self.x, self.low), self.high));
        }
        // Which side of the apex the line through the edge at `at` passes: positive, its first side is crossed.
        let past_apex = |at: f64| (self.x - at) * cy + (cx - at) * self.y;
        let from_low = past_apex(self.low);
        if from_low <= 0.0 {
            return bend_at(self.low);
        }
        let from_high = past_apex(self.high);
        // The share of the side at which the line through the edge at `at` crosses it.
        let share = |at: f64, past: f64| at * self.y / (past + at * self.y);
        let low = if self.low <= 0.0 { 0.0 } else { side * share(self.low, from_low) };
        let high = if from_high <= 0.0 { side } else { side * share(self.high, from_high) };
        Self {
            x: (self.x * cx - self.y * cy) / side,
            y: most((self.x * cy + self.y * cx) / side, 0.0),
            behind: self.behind,
            low,
            high: most(high, low),
        }
    }

    /// The shortest line through the window to a point that lies at `along` the edge and `off` its line, on the far side in
    /// the plane: its length up to the window, and from there on. No line through the window to a point at those distances
    /// in space is shorter.
    #[inline]
    pub fn lengths_to(&self, along: f64, off: f64) -> [f64; 2] {
        let total = self.y + off;
        let at = if total > 0.0 { self.x + (along - self.x) * (self.y / total) } else { along };
        let at = least(most(at, self.low), self.high);
        [self.behind + length(at - self.x, self.y), length(at - along, off)]
    }
}

#[inline]
fn length(x: f64, y: f64) -> f64 {
    (x * x + y * y).sqrt()
}

/// The greater of two numbers, in one instruction, where `f64::max` also looks for what is not a number.
#[inline]
fn most(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// The lesser of two numbers.
#[inline]
fn least(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

#[cfg(test)]
mod tests {
    use super::*;

    const A: DVec3 = DVec3::ZERO;
    const B: DVec3 = DVec3::X;
    const C: DVec3 = DVec3::new(0.5, 1.0, 0.0);

    fn flat(a: DVec3, b: DVec3, c: DVec3) -> FlatTriangle {
        FlatTriangle::new([a, b, c], a.distance(b))
    }

    fn length_to(window: &Window, along: f64, off: f64) -> f64 {
        window.lengths_to(along, off).iter().sum()
    }

    fn is_near(a: f64, b: f64) -> bool {
        (a - b).abs() < 1e-14
    }

    #[test]
    fn a_source_sees_both_sides_up_to_the_apex() {
        let triangle = flat(A, B, C);
        let window = Window::whole(DVec3::new(0.5, -1.0, 0.0), A, B, 1.0);
        for (triangle, window) in [(triangle, window), (triangle.mirrored(), window.reversed(1.0))] {
            let side = window.behind_first_side(&triangle);
            assert!(is_near(side.low, 0.0) && is_near(side.high, triangle.first_side) && side.behind == 0.0);
            // Distances are kept: from the source to the edge's end and to the apex.
            assert!(is_near(side.x.hypot(side.y), 1.25_f64.sqrt()));
            assert!(is_near((side.x - triangle.first_side).hypot(side.y), 2.0));
        }
    }

    #[test]
    fn a_window_that_is_turned_without_a_branch_is_the_reversed_one_to_the_bit() {
        let bits = |w: Window| [w.x, w.y, w.behind, w.low, w.high].map(f64::to_bits);
        // Also a view that ends beyond its edge by rounding, so that the reversed one begins before it.
        for length in [1.0, 0.1, 1.0 / 3.0, 7e-160, 3e150] {
            for (low, high) in [(0.0, 1.0), (0.0, 0.7), (0.3, 1.0 + 2e-16), (0.6, 0.6)] {
                let [low, high] = [low, high].map(|share| share * length);
                let window = Window { x: -0.37 * length, y: 0.2 * length, behind: 5.0, low, high };
                assert_eq!(bits(window.upward(length, true)), bits(window), "{length} {low} {high}");
                assert_eq!(bits(window.upward(length, false)), bits(window.reversed(length)), "{length} {low} {high}");
            }
        }
    }

    #[test]
    fn a_narrow_view_hits_one_side_and_bends_to_the_other() {
        let triangle = flat(A, B, C);
        let window = Window { x: 0.2, y: 1.0, behind: 3.0, low: 0.1, high: 0.2 };
        // The ray through 0.2 is upright and crosses the first side, y = 2x, at (0.2, 0.4).
        let seen = window.behind_first_side(&triangle);
        assert!(is_near(seen.high, 0.2_f64.hypot(0.4)) && seen.low < seen.high && seen.behind == 3.0);
        // The second side is out of view: from the window's end at 0.2 on.
        let bent = window.reversed(1.0).behind_first_side(&triangle.mirrored());
        assert!(is_near(bent.behind, 4.0) && bent.low == 0.0 && is_near(bent.high, triangle.second_side));
        assert!(is_near(bent.x.hypot(bent.y), 0.8), "the bend is 0.8 from the second end");
    }

    #[test]
    fn lengths_through_a_window_are_those_of_the_plane_and_of_the_bend_at_its_ends() {
        let window = Window { x: 0.0, y: 3.0, behind: 1.0, low: -1.0, high: 2.0 };
        assert!(is_near(length_to(&window, 8.0, 1.0), 1.0 + 13_f64.sqrt() + 37_f64.sqrt()), "bent at 2");
        assert!(is_near(length_to(&window, 0.0, 1.0), 5.0), "straight");
        assert!(
            is_near(length_to(&Window { y: 0.0, ..window }, 0.5, 2.0), 1.0 + 4.25_f64.sqrt()),
            "on the edge's own line"
        );
    }

    #[test]
    fn triangles_without_area_or_edges_without_length_give_numbers() {
        let window = Window { x: 0.3, y: 1.0, behind: 0.0, low: 0.0, high: 1.0 };
        let needle = flat(A, B, DVec3::new(0.25, 0.0, 0.0));
        let point_edge = flat(A, A, C);
        let point_side = flat(A, B, A);
        for triangle in
            [needle, needle.mirrored(), point_edge, point_edge.mirrored(), point_side, point_side.mirrored()]
        {
            for source in [window, Window { y: 0.0, ..window }, Window { x: 0.0, y: 0.0, ..window }] {
                let side = source.behind_first_side(&triangle);
                assert!([side.x, side.y, side.behind, side.low, side.high].into_iter().all(f64::is_finite), "{side:?}");
                assert!(0.0 <= side.low && side.low <= side.high && side.high <= triangle.first_side * (1.0 + 1e-15));
            }
        }
    }
}
