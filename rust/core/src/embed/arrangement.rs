//! Segments of lines inside one mesh triangle, made into sides of a triangulation of it.
//!
//! Segments are put in one after another. Where one runs into a point it goes on from there; where it crosses another a
//! point is made and both go through it; then sides in its way are flipped. Every step keeps the triangulation valid
//! (exact signs), so what comes out is an arrangement that is right by construction, rounded points included: a rounded
//! crossing bends its segments by a rounding error, it never tears them. Segments that `spacing` has kept apart do not
//! cross any more; only their flips are left to do then. Knows no mesh.
//!
//! Source: S. W. Sloan, A fast algorithm for generating constrained Delaunay triangulations (1993), for the flips.

use std::collections::{HashMap, VecDeque};

use glam::DVec2;

use super::nodes::{distance, distance_from_segment};
use super::spacing::{lead_through, sorted};
use super::triangulation::{Row, Triangulation, turn};

/// The segments could not be put in.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Tangled;

/// What stands in the way of a segment, met first.
enum Obstacle {
    /// The side exists already.
    Nothing,
    /// A point on the segment, or too near it.
    Point(u32),
    /// A side of another line.
    Line(u32, u32),
    /// Sides of no line, which can be flipped.
    Sides(Vec<(u32, u32)>),
}

/// See the module.
#[derive(Debug)]
pub struct Arrangement {
    triangulation: Triangulation,
    /// For each segment its points, first to last.
    chains: Vec<Vec<u32>>,
    /// Segments that use a side, by its ends, lower first. Looked up, never walked through.
    owners: HashMap<[u32; 2], Vec<u32>>,
    /// Sides that segments use and that are not there yet.
    open: Vec<[u32; 2]>,
}

/// Segments go through points that are closer than this, which is rounding.
const TOLERANCE: f64 = 1e-15;

/// Cotangents that sum to less than minus this belong to angles that sum to more than a half turn, rounding apart.
const FLIP_GAIN: f64 = 1e-9;

impl Arrangement {
    /// A mesh triangle with points on its sides, `sides[k]` from corner `k` to corner `k + 1 (mod 3)` in that order, and
    /// `inside`. They get the numbers 3 and up, in this order.
    pub fn new(sides: [&[Row]; 3], inside: &[Row]) -> Self {
        let mut triangulation = Triangulation::of_corners();
        for (k, rows) in sides.into_iter().enumerate() {
            let end = (k as u32 + 1) % 3;
            let mut last = k as u32;
            for &row in rows {
                let side = triangulation.find_side(last, end).expect("the rest of a side is there");
                last = triangulation.split_side(side, row).expect("parameters on an edge differ and rise");
            }
        }
        for &row in inside {
            insert_point(&mut triangulation, row);
        }
        Self { triangulation, chains: Vec::new(), owners: HashMap::new(), open: Vec::new() }
    }

    /// Adds a segment between two different points; its number is how many there were.
    pub fn add_segment(&mut self, a: u32, b: u32) {
        let segment = self.chains.len() as u32;
        self.chains.push(vec![a, b]);
        self.own(a, b, segment);
    }

    /// Makes all segments chains of sides. `corners`: where the mesh triangle's corners are, in its own plane, to choose
    /// well-shaped pieces where segments leave the choice.
    ///
    /// # Errors
    /// More changes than any arrangement of straight segments needs: rounding played a trick. The triangulation is valid
    /// all the same.
    pub fn settle(&mut self, corners: [DVec2; 3]) -> Result<(), Tangled> {
        let count = self.chains.len();
        let points = self.triangulation.rows().len();
        let mut budget = 64 + 32 * count * (count + points);
        while let Some([a, b]) = self.open.pop() {
            if !self.owners.contains_key(&sorted(a, b)) {
                continue;
            }
            budget = budget.checked_sub(1).ok_or(Tangled)?;
            match self.look_along(a, b) {
                Obstacle::Nothing => {}
                Obstacle::Point(p) => self.pass_through(a, b, p),
                Obstacle::Line(c, d) => self.cross(a, b, c, d),
                Obstacle::Sides(sides) => self.flip_away(a, b, sides)?,
            }
        }
        self.improve(corners);
        Ok(())
    }

    /// The points; the first three are the corners.
    pub fn rows(&self) -> &[Row] {
        self.triangulation.rows()
    }

    /// The pieces, all turned like the mesh triangle.
    pub fn pieces(&self) -> &[[u32; 3]] {
        self.triangulation.pieces()
    }

    /// The points of a segment, first to last.
    pub fn chain(&self, segment: usize) -> &[u32] {
        &self.chains[segment]
    }

    fn own(&mut self, a: u32, b: u32, segment: u32) {
        let owners = self.owners.entry(sorted(a, b)).or_default();
        if !owners.contains(&segment) {
            owners.push(segment);
        }
        self.open.push([a, b]);
    }

    fn is_line(&self, a: u32, b: u32) -> bool {
        self.owners.contains_key(&sorted(a, b))
    }

    /// The segments that use side `ab` go through `p` instead.
    fn pass_through(&mut self, a: u32, b: u32, p: u32) {
        let Some(owners) = self.owners.remove(&sorted(a, b)) else { return };
        for segment in owners {
            lead_through(&mut self.chains[segment as usize], [a, b], p);
            self.own(a, p, segment);
            self.own(p, b, segment);
        }
    }

    /// Segment `ab` meets side `cd` of a line.
    fn cross(&mut self, a: u32, b: u32, c: u32, d: u32) {
        let t = &self.triangulation;
        let (to_c, to_d) = (t.turn(a, b, c).abs(), t.turn(a, b, d).abs());
        let (wc, wd) = (to_d / (to_c + to_d), to_c / (to_c + to_d));
        let (rc, rd) = (t.row(c), t.row(d));
        let mixed: Row = std::array::from_fn(|i| wc * rc[i] + wd * rd[i]);
        let sum: f64 = mixed.iter().sum();
        let row = mixed.map(|x| x / sum);
        let is_near = |p: u32| distance(t.row(p), row) < TOLERANCE;
        if let Some(p) = [c, d].into_iter().find(|&p| is_near(p)) {
            return self.pass_through(a, b, p);
        }
        if let Some(p) = [a, b].into_iter().find(|&p| is_near(p)) {
            self.open.push([a, b]);
            return self.pass_through(c, d, p);
        }
        let side = t.find_side(c, d).expect("a line's side is there");
        match self.triangulation.split_side(side, row) {
            Some(p) => {
                self.pass_through(a, b, p);
                self.pass_through(c, d, p);
                self.draw_lines_to(p);
            }
            None => self.pass_through(a, b, if wc > wd { c } else { d }),
        }
    }

    /// Lines that a new point came too near to go through it.
    fn draw_lines_to(&mut self, p: u32) {
        let t = &self.triangulation;
        let around = t.pieces_round(p).into_iter().map(|(piece, k)| t.rotated(piece, k));
        let near = around.filter(|&[_, e, f]| self.is_line(e, f) && is_near(t.row(p), t.row(e), t.row(f)));
        for [_, e, f] in near.collect::<Vec<_>>() {
            self.pass_through(e, f, p);
        }
    }

    /// Flips the sides that `ab` crosses until it is a side itself.
    fn flip_away(&mut self, a: u32, b: u32, sides: Vec<(u32, u32)>) -> Result<(), Tangled> {
        let mut left = 64 + 8 * sides.len() * sides.len();
        let mut waiting: VecDeque<_> = sides.into();
        while let Some((c, d)) = waiting.pop_front() {
            left = left.checked_sub(1).ok_or(Tangled)?;
            let Some((piece, k)) = self.triangulation.find_side(c, d) else { return Err(Tangled) };
            if !self.triangulation.flip((piece, k)) {
                waiting.push_back((c, d));
                continue;
            }
            let [e, f, _] = self.triangulation.corners(piece);
            let is_clear = [e, f].iter().any(|&p| p == a || p == b);
            if !is_clear && (self.triangulation.turn(a, b, e) > 0.0) != (self.triangulation.turn(a, b, f) > 0.0) {
                waiting.push_back((e, f));
            }
        }
        Ok(())
    }

    /// Walks from `a` to `b`.
    fn look_along(&self, a: u32, b: u32) -> Obstacle {
        let t = &self.triangulation;
        let (ra, rb) = (t.row(a), t.row(b));
        let mut sides = Vec::new();
        let is_near = |p: &u32| *p != a && *p != b && is_near(t.row(*p), ra, rb);
        let mut step = None;
        for (piece, k) in t.pieces_round(a) {
            let [_, right, left] = t.rotated(piece, k);
            if right == b || left == b {
                let apexes = t.find_side(a, b).into_iter().flat_map(|side| [Some(side), t.across(side)]).flatten();
                let near = apexes.map(|(piece, k)| t.corners(piece)[(k + 2) % 3]).find(is_near);
                return near.map_or(Obstacle::Nothing, Obstacle::Point);
            }
            let (to_right, to_left) = (turn(ra, rb, t.row(right)), turn(ra, rb, t.row(left)));
            for (p, side) in [(right, to_right), (left, to_left)] {
                if side == 0.0 && is_ahead(ra, rb, t.row(p)) {
                    return Obstacle::Point(p);
                }
            }
            if to_right < 0.0 && to_left > 0.0 {
                step = Some((piece, (k + 1) % 3));
            }
        }
        let Some(mut side) = step else {
            // Cannot be: the pieces at a point fill the wedge of the mesh triangle there.
            return Obstacle::Sides(vec![(a, b)]);
        };
        loop {
            let [right, left, _] = t.rotated(side.0, side.1);
            if let Some(p) = [right, left].into_iter().find(is_near) {
                return Obstacle::Point(p);
            }
            if self.is_line(right, left) {
                return Obstacle::Line(right, left);
            }
            sides.push((right, left));
            let Some((piece, k)) = t.across(side) else { return Obstacle::Sides(vec![(a, b)]) };
            let apex = t.corners(piece)[(k + 2) % 3];
            if apex == b {
                return Obstacle::Sides(sides);
            }
            let to_apex = turn(ra, rb, t.row(apex));
            if to_apex == 0.0 {
                return Obstacle::Point(apex);
            }
            // Seen from here the side runs from left to right.
            side = (piece, if to_apex > 0.0 { (k + 1) % 3 } else { (k + 2) % 3 });
        }
    }

    /// Flips sides of no line where that makes the smallest angles larger.
    fn improve(&mut self, corners: [DVec2; 3]) {
        let place = |r: Row| r[0] * corners[0] + r[1] * corners[1] + r[2] * corners[2];
        let places: Vec<DVec2> = self.triangulation.rows().iter().map(|&row| place(row)).collect();
        // The angle at `apex` over the side, as its cotangent; not a number where there is no area, and then nothing is flipped.
        let cotangent = |apex: u32, a: u32, b: u32| {
            let (to_a, to_b) = (places[a as usize] - places[apex as usize], places[b as usize] - places[apex as usize]);
            to_a.dot(to_b) / to_a.perp_dot(to_b).abs()
        };
        for _ in 0..8 {
            let mut is_changed = false;
            for piece in 0..self.triangulation.pieces().len() as u32 {
                for k in 0..3 {
                    let [a, b, c] = self.triangulation.rotated(piece, k);
                    let Some((other, j)) = self.triangulation.across((piece, k)) else { continue };
                    let d = self.triangulation.corners(other)[(j + 2) % 3];
                    if a < b && !self.is_line(a, b) && cotangent(c, a, b) + cotangent(d, a, b) < -FLIP_GAIN {
                        is_changed |= self.triangulation.flip((piece, k));
                    }
                }
            }
            if !is_changed {
                return;
            }
        }
    }
}

/// Whether segment `ab` has to go through `p`: not to be told from a point on it, nor too near an end. Then both parts are
/// shorter than the whole, so that going through one point after another comes to an end.
fn is_near(p: Row, a: Row, b: Row) -> bool {
    let is_between = distance(p, a) >= TOLERANCE && distance(p, b) >= TOLERANCE;
    is_between && distance_from_segment(p, a, b) < TOLERANCE / 2.0
}

fn is_ahead(a: Row, b: Row, p: Row) -> bool {
    (0..3).map(|i| (b[i] - a[i]) * (p[i] - a[i])).sum::<f64>() > 0.0
}

/// Puts a point that lies strictly inside the mesh triangle into it.
fn insert_point(triangulation: &mut Triangulation, row: Row) -> u32 {
    let turns_of = |t: &Triangulation, piece: u32| -> [f64; 3] {
        std::array::from_fn(|k| {
            let [a, b, _] = t.rotated(piece, k).map(|p| t.row(p));
            turn(a, b, row)
        })
    };
    let count = triangulation.pieces().len() as u32;
    // Towards the point from the newest piece; a walk may go round in circles, then all are tried.
    let mut piece = count - 1;
    let walk = (0..count).map(|step| {
        let turns = turns_of(triangulation, piece);
        let here = (piece, turns);
        let out = (0..3).map(|k| (k + step as usize) % 3).find(|&k| turns[k] < 0.0);
        if let Some((next, _)) = out.and_then(|k| triangulation.across((piece, k))) {
            piece = next;
        }
        here
    });
    let holds = |turns: &[f64; 3]| turns.iter().all(|&t| t >= 0.0);
    let found: Option<(u32, [f64; 3])> = walk.into_iter().find(|(_, turns)| holds(turns));
    let all = || (0..count).map(|piece| (piece, turns_of(triangulation, piece))).find(|(_, turns)| holds(turns));
    let (piece, turns) = found.or_else(all).expect("the pieces fill the mesh triangle");
    match turns.iter().position(|&t| t == 0.0) {
        None => triangulation.split_piece(piece, row),
        Some(k) => triangulation.split_side((piece, k), row).expect("a point on a side parts it"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CORNERS: [DVec2; 3] = [DVec2::ZERO, DVec2::new(1.0, 0.0), DVec2::new(0.3, 0.8)];

    /// Numbers in 0..1 that look random (Knuth's multiplier).
    struct Numbers(u64);

    impl Numbers {
        fn next(&mut self) -> f64 {
            self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (self.0 >> 11) as f64 / (1u64 << 53) as f64
        }
    }

    /// Pieces are turned alike and fill the triangle; every chain is one of sides, from end to end.
    fn check(made: &Arrangement, ends: &[[u32; 2]]) {
        let mut sides = std::collections::HashMap::<[u32; 2], u32>::new();
        let mut area = 0.0;
        for &[a, b, c] in made.pieces() {
            let own = made.triangulation.turn(a, b, c);
            assert!(own > 0.0, "a piece is turned over or has no area");
            area += own;
            for (p, q) in [(a, b), (b, c), (c, a)] {
                assert!(sides.insert([p, q], 1).is_none(), "side {p} {q} has two pieces on its left");
            }
        }
        assert!((area - 1.0).abs() < 1e-9, "{area}");
        for (segment, &[a, b]) in ends.iter().enumerate() {
            let chain = made.chain(segment);
            assert_eq!((chain[0], chain[chain.len() - 1]), (a, b));
            for pair in chain.windows(2) {
                let is_side = sides.contains_key(&[pair[0], pair[1]]) || sides.contains_key(&[pair[1], pair[0]]);
                assert!(is_side, "{pair:?} of segment {segment} is no side");
            }
        }
        // As many sides as a triangulated disc has: no piece lies over another.
        let rim = sides.keys().filter(|side| !sides.contains_key(&[side[1], side[0]])).count();
        let edges = (sides.len() + rim) / 2;
        assert_eq!(made.rows().len() as i64 - edges as i64 + made.pieces().len() as i64, 1);
    }

    fn settle(sides: [Vec<f64>; 3], inside: &[Row], ends: &[[u32; 2]]) -> Arrangement {
        let row = |k: usize, t: f64| {
            let mut row = [0.0; 3];
            (row[k], row[(k + 1) % 3]) = (1.0 - t, t);
            row
        };
        let [a, b, c]: [Vec<Row>; 3] = std::array::from_fn(|k| sides[k].iter().map(|&t| row(k, t)).collect());
        let mut made = Arrangement::new([&a, &b, &c], inside);
        ends.iter().for_each(|&[a, b]| made.add_segment(a, b));
        made.settle(CORNERS).expect("an arrangement");
        check(&made, ends);
        made
    }

    #[test]
    fn two_chords_that_interleave_cross_once_and_two_that_do_not_never() {
        // Points 3, 4 on the first side, 5, 6 on the second.
        let sides = || [vec![0.25, 0.75], vec![0.25, 0.75], vec![]];
        let crossed = settle(sides(), &[], &[[3, 5], [4, 6]]);
        assert_eq!(crossed.rows().len(), 8);
        assert_eq!((crossed.chain(0).len(), crossed.chain(1).len()), (3, 3));
        let nested = settle(sides(), &[], &[[3, 6], [4, 5]]);
        assert_eq!(nested.rows().len(), 7);
    }

    #[test]
    fn a_segment_through_a_point_goes_on_from_there() {
        let made = settle([vec![0.5], vec![], vec![]], &[[0.25, 0.25, 0.5]], &[[3, 2]]);
        assert_eq!(made.chain(0), [3, 4, 2]);
        let along_a_side = settle([vec![0.2, 0.5], vec![], vec![]], &[], &[[0, 1]]);
        assert_eq!(along_a_side.chain(0), [0, 3, 4, 1]);
    }

    #[test]
    fn three_chords_through_nearly_one_point_are_a_valid_arrangement() {
        for shift in [0.0, 1e-17, -3e-17, 1e-16, 1e-13, 1e-9] {
            let sides = [vec![0.5], vec![0.5 + shift], vec![0.5]];
            settle(sides, &[], &[[0, 4], [1, 5], [2, 3]]);
        }
    }

    #[test]
    fn many_random_segments_are_arranged() {
        let mut numbers = Numbers(7);
        for _ in 0..60 {
            let mut sides: [Vec<f64>; 3] = Default::default();
            for side in &mut sides {
                let count = (numbers.next() * 8.0) as usize;
                side.extend((0..count).map(|i| (i as f64 + 0.2 + 0.6 * numbers.next()) / count as f64));
            }
            let inside: Vec<Row> = (0..(numbers.next() * 5.0) as usize)
                .map(|_| {
                    let (a, b) = (0.05 + 0.4 * numbers.next(), 0.05 + 0.4 * numbers.next());
                    [a, b, 1.0 - a - b]
                })
                .collect();
            let count = 3 + sides.iter().map(Vec::len).sum::<usize>() + inside.len();
            let mut pick = || (numbers.next() * count as f64) as u32;
            let ends: Vec<[u32; 2]> = (0..12).map(|_| [pick(), pick()]).filter(|[a, b]| a != b).collect();
            settle(sides, &inside, &ends);
        }
    }

    #[test]
    fn crowded_segments_are_arranged() {
        let mut numbers = Numbers(11);
        for _ in 0..80 {
            let inside: Vec<Row> = (0..40)
                .map(|_| {
                    let (a, b) = (numbers.next(), numbers.next());
                    let (a, b) = if a + b > 1.0 { (1.0 - a, 1.0 - b) } else { (a, b) };
                    [0.05 + 0.85 * a, 0.05 + 0.85 * b, 0.05 + 0.85 * (1.0 - a - b)]
                })
                .collect();
            let ends: Vec<[u32; 2]> = (0..20).map(|i| [3 + 2 * i, 4 + 2 * i]).collect();
            settle(Default::default(), &inside, &ends);
        }
    }

    #[test]
    fn a_comb_of_parallel_and_crossing_chords_has_every_crossing() {
        let count = 30;
        let even: Vec<f64> = (0..count).map(|i| (f64::from(i) + 0.5) / f64::from(count)).collect();
        // From side 0 to side 1 and from side 2 to side 0: chord i of the first kind crosses those of the second whose
        // ends interleave with its own.
        let ends: Vec<[u32; 2]> = (0..count as u32)
            .map(|i| [3 + i, 3 + 60 - 1 - i])
            .chain((0..count as u32).map(|i| [3 + 60 + i, 3 + (i * 7) % 30]))
            .collect();
        let made = settle([even.clone(), even.clone(), even], &[], &ends);
        // Corners in order round the triangle, to count crossings by interleaving alone.
        let round = |p: u32| p - 3;
        let interleave = |[a, b]: [u32; 2], [c, d]: [u32; 2]| {
            let (low, high) = (round(a).min(round(b)), round(a).max(round(b)));
            let is_between = |p: u32| round(p) > low && round(p) < high;
            let is_apart = [c, d].iter().all(|p| *p != a && *p != b);
            is_apart && is_between(c) != is_between(d)
        };
        let expected = ends.iter().enumerate().flat_map(|(i, a)| ends[..i].iter().map(move |b| (*a, *b)));
        let expected = expected.filter(|&(a, b)| interleave(a, b)).count();
        // Where three meet in a point they share one vertex; with these numbers none do to the last bit.
        assert!(made.rows().len() - 93 <= expected);
        assert!(made.rows().len() - 93 >= expected * 9 / 10, "{} of {expected}", made.rows().len() - 93);
    }
}
