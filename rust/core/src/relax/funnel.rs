//! The shortest line through an unfolded strip, exactly, in one walk.
//!
//! Source: D. T. Lee, F. P. Preparata 1984, *Euclidean Shortest Paths in the Presence of Rectilinear Barriers*, with the
//! funnel as a deque; each portal end is pushed once and popped at most once, so the cost is O(letters).
//!
//! ```text
//!       left chain                The funnel holds the shortest lines from the apex to both ends of
//!      .-'   '-.                  the current portal. A new end pops what its line does not touch;
//!  apex          > portal         when it pops past the apex, the apex moves on: a corner is certain.
//!      '-.___.-'
//!       right chain
//! ```

use glam::{DVec2, DVec3};

use crate::ids::HalfedgeId;
use crate::mesh::SurfaceMesh;
use crate::unfold::Unfolding;

/// In a path: the start point instead of a portal end.
const START: u32 = u32::MAX;

/// Two directions are taken for parallel when the sine between them is below this: 64 roundings of the coordinates.
/// A corner that the line grazes is kept, so that step D looks at it.
const GRAZE: f64 = 64.0 * f64::EPSILON;

/// A portal end, or the start, on the funnel.
#[derive(Clone, Copy, Debug)]
struct Held {
    at: DVec2,
    /// Place in [`Unfolding::ends`], or [`START`].
    end: u32,
}

/// Work space of the funnel; kept between uses for its memory.
#[derive(Clone, Debug, Default)]
pub struct Funnel {
    /// Places that are not on the funnel hold anything.
    deque: Vec<Held>,
    /// Of ends that were on the funnel; else anything.
    parents: Vec<u32>,
    /// Ends this near to each other are in one place: what rounding alone can part them by. It goes with the largest
    /// coordinate of the ends so far.
    near: f64,
    /// Portal ends at which the shortest line turns or grazes, first to last, as places in [`Unfolding::ends`].
    pub corners: Vec<u32>,
}

impl Funnel {
    /// Finds the corners of the shortest line from the start to the end of `unfolding`.
    pub fn run(&mut self, unfolding: &Unfolding) {
        self.corners.clear();
        let count = unfolding.ends.len();
        if unfolding.portals.is_empty() {
            return;
        }
        let start = Held { at: unfolding.start, end: START };
        if self.parents.len() < count {
            self.parents.resize(count, START);
            self.deque.resize(2 * count + 3, start);
        }
        // `low` is the left end of the funnel, `high` the right one, `apex` between them.
        let mut funnel = Span { low: count + 1, apex: count + 1, high: count + 1 };
        self.deque[funnel.apex] = start;
        let mut last = [START, START];
        let mut reach = unfolding.start.abs().max_element();
        for &portal in &unfolding.portals {
            for side in [0, 1] {
                let end = portal[side];
                if end == last[side] {
                    continue;
                }
                last[side] = end;
                let at = unfolding.ends[end as usize].at;
                reach = reach.max(at.abs().max_element());
                self.near = GRAZE * reach;
                self.parents[end as usize] = self.shrink(&mut funnel, side, at);
                if side == 0 {
                    funnel.low -= 1;
                    self.deque[funnel.low] = Held { at, end };
                } else {
                    funnel.high += 1;
                    self.deque[funnel.high] = Held { at, end };
                }
            }
        }
        let mut corner = self.shrink(&mut funnel, 0, unfolding.end);
        while corner != START {
            self.corners.push(corner);
            corner = self.parents[corner as usize];
        }
        self.corners.reverse();
    }

    /// Pops what a line to `point`, coming from side `side` (0 left, 1 right), does not touch; returns what it touches last.
    #[inline]
    fn shrink(&self, funnel: &mut Span, side: usize, point: DVec2) -> u32 {
        let deque = self.deque.as_slice();
        // For the left end: a chain turns left only, and the line to `point` must too. The right end is its mirror image.
        let turn =
            |sign: f64, last: DVec2, way_in: Option<DVec2>| way_in.is_some_and(|way| turns(sign, way, point - last));
        if side == 0 {
            while funnel.low < funnel.apex {
                let last = deque[funnel.low].at;
                if turn(1.0, last, self.way_in(last, deque[funnel.low + 1..=funnel.apex].iter())) {
                    break;
                }
                funnel.low += 1;
            }
            if funnel.low == funnel.apex {
                while funnel.apex < funnel.high
                    && self.passes(1.0, deque[funnel.apex].at, deque[funnel.apex + 1].at, point)
                {
                    funnel.apex += 1;
                }
                funnel.low = funnel.apex;
            }
            deque[funnel.low].end
        } else {
            while funnel.high > funnel.apex {
                let last = deque[funnel.high].at;
                if turn(-1.0, last, self.way_in(last, deque[funnel.apex..funnel.high].iter().rev())) {
                    break;
                }
                funnel.high -= 1;
            }
            if funnel.high == funnel.apex {
                while funnel.apex > funnel.low
                    && self.passes(-1.0, deque[funnel.apex].at, deque[funnel.apex - 1].at, point)
                {
                    funnel.apex -= 1;
                }
                funnel.high = funnel.apex;
            }
            deque[funnel.high].end
        }
    }

    /// The way to `here` along a chain, of which the ends before it come last first. Ends in one place say nothing of it: it
    /// comes from the last one elsewhere. `None` where there is none, not even the apex: then the chain adds nothing to it.
    #[inline]
    fn way_in<'a>(&self, here: DVec2, before: impl Iterator<Item = &'a Held>) -> Option<DVec2> {
        let mut ways = before.map(|held| here - held.at);
        ways.find(|&way| !self.is_rounding(way))
    }

    /// Whether the line from `apex` to `point`, a new left end (`sign` 1), runs on the far side of `corner`, the first of the
    /// right chain, or grazes it, as it does one in the apex's own place; the mirror image for `sign` -1. A point in the apex's
    /// own place is nowhere behind it.
    #[inline]
    fn passes(&self, sign: f64, apex: DVec2, corner: DVec2, point: DVec2) -> bool {
        let (to_corner, to_point) = (corner - apex, point - apex);
        !self.is_rounding(to_point) && (self.is_rounding(to_corner) || turns(-sign, to_corner, to_point))
    }

    /// Whether rounding alone parts two ends that are `way` apart: such ends are in one place.
    #[inline]
    fn is_rounding(&self, way: DVec2) -> bool {
        way.abs().max_element() <= self.near
    }
}

#[derive(Clone, Copy, Debug)]
struct Span {
    low: usize,
    apex: usize,
    high: usize,
}

/// Whether `v` turns to the left of `u` (`sign` 1; to the right for -1) or goes on as `u` does, to rounding. A way straight
/// back is neither: it is what both ends of a portal are for a point on it, which sees the whole of what lies ahead.
#[inline]
fn turns(sign: f64, u: DVec2, v: DVec2) -> bool {
    let turn = sign * u.perp_dot(v);
    // Lengths are no more than these sums, and nearly all turns are plain by them, without roots.
    let plain = GRAZE * (u.x.abs() + u.y.abs()) * (v.x.abs() + v.y.abs());
    if turn.abs() > plain {
        return turn > 0.0;
    }
    let graze = GRAZE * u.length() * v.length();
    turn > graze || (turn >= -graze && u.dot(v) >= 0.0)
}

/// Where the segment from `from` to `to` crosses the portal from `left` to `right`: 0 at the left end, 1 at the right.
#[inline]
pub fn cross_portal(from: DVec2, to: DVec2, left: DVec2, right: DVec2) -> f64 {
    let direction = to - from;
    let (l, r) = (direction.perp_dot(left - from), -direction.perp_dot(right - from));
    // l > 0: the left end is to the left; r > 0: the right end is to the right.
    if l <= 0.0 {
        0.0
    } else if r <= 0.0 {
        1.0
    } else {
        l / (l + r)
    }
}

/// Appends the parameters at which the shortest line from `start` to `end` crosses the letters of a word.
pub fn shortest_crossings(
    mesh: &SurfaceMesh,
    start: DVec3,
    word: &[HalfedgeId],
    end: DVec3,
    unfolding: &mut Unfolding,
    funnel: &mut Funnel,
    parameters: &mut Vec<f64>,
) {
    unfolding.unfold(mesh, start, word, end);
    funnel.run(unfolding);
    let mut corners = funnel.corners.iter().map(|&c| unfolding.ends[c as usize]).peekable();
    let mut from = unfolding.start;
    for (i, (&letter, &[left, right])) in word.iter().zip(&unfolding.portals).enumerate() {
        while let Some(corner) = corners.next_if(|c| (c.last as usize) < i) {
            from = corner.at;
        }
        let (left, right) = (&unfolding.ends[left as usize], &unfolding.ends[right as usize]);
        let at_corner = corners.peek().filter(|c| c.first as usize <= i);
        let from_left = match at_corner {
            Some(corner) => f64::from(u8::from(corner.vertex != left.vertex)),
            None => cross_portal(from, corners.peek().map_or(unfolding.end, |c| c.at), left.at, right.at),
        };
        let is_left_low = mesh.sorted_ends(letter)[0] == left.vertex;
        parameters.push(if is_left_low { from_left } else { 1.0 - from_left });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ids::VertexId;
    use crate::unfold::PortalEnd;

    #[test]
    fn a_corner_is_found_behind_ends_that_go_there_and_back_in_one_line() {
        // A fan without area: its rim lies in one line, the strip crosses it there and back and then narrows.
        let rim = [1.5, 2.5, 3.5, 2.5, 1.5, 0.5];
        let end = |i: usize, y: f64| PortalEnd {
            at: DVec2::new(0.0, y),
            vertex: VertexId(i as u32),
            first: i.saturating_sub(1) as u32,
            last: if i == 0 { rim.len() as u32 - 1 } else { i as u32 - 1 },
        };
        let ends: Vec<_> = std::iter::once(0.0).chain(rim).enumerate().map(|(i, y)| end(i, y)).collect();
        for mirror in [false, true] {
            let portals = (1..ends.len() as u32).map(|i| if mirror { [i, 0] } else { [0, i] }).collect();
            let x = if mirror { -2.0 } else { 2.0 };
            let (start, end) = (DVec2::new(x, 0.0), DVec2::new(-x, 4.0));
            let unfolding = Unfolding { ends: ends.clone(), portals, start, end };
            let mut funnel = Funnel::default();
            funnel.run(&unfolding);
            assert_eq!(funnel.corners, [6], "mirrored {mirror}");
        }
    }

    #[test]
    fn an_end_in_the_start_s_own_place_blocks_nothing() {
        // Rounding puts the first right end anywhere round the start; the line turns right at the second one.
        for off in [DVec2::ZERO, DVec2::new(0.0, 1.4e-17), DVec2::new(-1.1e-16, 0.0), DVec2::new(5e-17, -5e-17)] {
            let start = DVec2::new(0.4520341722089845, 0.0);
            let places = [DVec2::ZERO, start + off, DVec2::new(0.7, 0.3), DVec2::new(1.0, 0.4)];
            let end =
                |i: usize, first: u32, last: u32| PortalEnd { at: places[i], vertex: VertexId(i as u32), first, last };
            let ends = vec![end(0, 0, 0), end(1, 0, 1), end(2, 1, 2), end(3, 2, 2)];
            let unfolding = Unfolding { ends, portals: vec![[0, 1], [2, 1], [2, 3]], start, end: DVec2::new(3.0, 0.2) };
            let mut funnel = Funnel::default();
            funnel.run(&unfolding);
            let vertices: Vec<_> = funnel.corners.iter().filter(|&&c| c != 1).collect();
            assert_eq!(vertices, [&3], "{off}");
        }
    }

    #[test]
    fn a_portal_is_crossed_where_the_segment_says() {
        let (left, right) = (DVec2::new(-1.0, 0.0), DVec2::new(3.0, 0.0));
        assert_eq!(cross_portal(DVec2::new(0.0, -1.0), DVec2::new(0.0, 1.0), left, right), 0.25);
        assert_eq!(cross_portal(DVec2::new(-5.0, -1.0), DVec2::new(-5.0, 1.0), left, right), 0.0);
        assert_eq!(cross_portal(DVec2::new(5.0, -1.0), DVec2::new(5.0, 1.0), left, right), 1.0);
    }
}
