//! Segments of lines inside one mesh triangle, made into sides of a triangulation of it.
//!
//! Segments are put in one after another. Where one runs into a point it goes on from there; where it crosses another a
//! point is made and both go through it; then sides in its way are flipped. Every step keeps the triangulation valid
//! (exact signs), so what comes out is an arrangement that is right by construction, rounded points included: a rounded
//! crossing bends its segments by a rounding error, it never tears them. Knows no mesh.
//!
//! Source: S. W. Sloan, A fast algorithm for generating constrained Delaunay triangulations (1993), for the flips.

use std::collections::{HashMap, VecDeque};

use glam::DVec2;

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
    tolerance: f64,
    /// For each segment its points, first to last.
    chains: Vec<Vec<u32>>,
    /// Segments that use a side, by its ends, lower first. Looked up, never walked through.
    owners: HashMap<[u32; 2], Vec<u32>>,
    /// Sides that segments use and that are not there yet.
    open: Vec<[u32; 2]>,
    /// Changes of chains that are still allowed before points stop attracting segments, and in all.
    budget: usize,
}

/// Segments go through points that are closer than this, in barycentric parts, even where `tolerance` is less.
const LEAST_TOLERANCE: f64 = 1e-15;

/// Cotangents that sum to less than minus this belong to angles that sum to more than a half turn, rounding apart.
const FLIP_GAIN: f64 = 1e-9;

impl Arrangement {
    /// A mesh triangle with points on its sides, `sides[k]` from corner `k` to corner `k + 1 (mod 3)` in that order, and
    /// `inside`. They get the numbers 3 and up, in this order. `tolerance`: distance in barycentric parts (the largest
    /// difference of a part) within which a segment goes through a point.
    pub fn new(sides: [&[Row]; 3], inside: &[Row], tolerance: f64) -> Self {
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
        let tolerance = tolerance.max(LEAST_TOLERANCE);
        Self { triangulation, tolerance, chains: Vec::new(), owners: HashMap::new(), open: Vec::new(), budget: 0 }
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
        let limit = 64 + 16 * count * (count + points);
        self.budget = 2 * limit;
        while let Some([a, b]) = self.open.pop() {
            if !self.owners.contains_key(&sorted(a, b)) {
                continue;
            }
            self.budget = self.budget.checked_sub(1).ok_or(Tangled)?;
            if self.budget == limit {
                self.tolerance = LEAST_TOLERANCE;
            }
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
            let chain = &mut self.chains[segment as usize];
            let mut i = 0;
            while i + 1 < chain.len() {
                if sorted(chain[i], chain[i + 1]) == sorted(a, b) {
                    chain.insert(i + 1, p);
                    i += 1;
                }
                i += 1;
            }
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
        let is_near = |p: u32| distance(t.row(p), row) < self.tolerance;
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
            }
            None => self.pass_through(a, b, if wc > wd { c } else { d }),
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
        let is_near = |p: &u32| *p != a && *p != b && self.is_near(t.row(*p), ra, rb);
        let mut step = None;
        for (piece, k) in t.pieces_round(a) {
            let [_, right, left] = t.rotated(piece, k);
            if right == b || left == b {
                return Obstacle::Nothing;
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

    fn is_near(&self, p: Row, a: Row, b: Row) -> bool {
        let along: Row = std::array::from_fn(|i| b[i] - a[i]);
        let length = along.iter().map(|x| x * x).sum::<f64>();
        let s = (0..3).map(|i| along[i] * (p[i] - a[i])).sum::<f64>() / length;
        s > 0.0 && s < 1.0 && distance(p, std::array::from_fn(|i| a[i] + s * along[i])) < self.tolerance
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

fn sorted(a: u32, b: u32) -> [u32; 2] {
    if a < b { [a, b] } else { [b, a] }
}

/// The largest difference of a barycentric part.
pub fn distance(a: Row, b: Row) -> f64 {
    (0..3).map(|i| (a[i] - b[i]).abs()).fold(0.0, f64::max)
}

fn is_ahead(a: Row, b: Row, p: Row) -> bool {
    (0..3).map(|i| (b[i] - a[i]) * (p[i] - a[i])).sum::<f64>() > 0.0
}

/// Puts a point that lies strictly inside the mesh triangle into it.
fn insert_point(triangulation: &mut Triangulation, row: Row) -> u32 {
    for piece in 0..triangulation.pieces().len() as u32 {
        let turns: [f64; 3] = std::array::from_fn(|k| {
            let [a, b, _] = triangulation.rotated(piece, k).map(|p| triangulation.row(p));
            turn(a, b, row)
        });
        if turns.iter().all(|&t| t >= 0.0) {
            return match turns.iter().position(|&t| t == 0.0) {
                None => triangulation.split_piece(piece, row),
                Some(k) => triangulation.split_side((piece, k), row).expect("a point on a side parts it"),
            };
        }
    }
    unreachable!("the pieces fill the mesh triangle")
}
