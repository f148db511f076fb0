//! The triangulation of one mesh triangle that lines are put into: its storage, and the changes that keep it valid.
//!
//! Points are barycentric rows of the mesh triangle; every decision is the sign of a determinant, taken exactly, so each
//! piece is always turned as the mesh triangle is. Knows no lines.

use robust::{Coord3D, orient3d};

/// In the table of neighbours: the side of the mesh triangle.
pub const NO_PIECE: u32 = u32::MAX;

/// Weights of the mesh triangle's three corners.
pub type Row = [f64; 3];

/// A piece and one of its sides: side `k` joins corners `k` and `k + 1 (mod 3)`.
pub type Side = (u32, usize);

/// See the module. Points 0 to 2 are the corners of the mesh triangle.
#[derive(Debug)]
pub struct Triangulation {
    points: Vec<Row>,
    pieces: Vec<[u32; 3]>,
    neighbours: Vec<[u32; 3]>,
    /// Some piece at each point.
    piece_at: Vec<u32>,
}

/// On which side of the directed line from `a` to `b` point `c` lies: positive on the left, in the turn of the mesh
/// triangle; exact (J. R. Shewchuk, Adaptive Precision Floating-Point Arithmetic, 1997).
pub fn turn(a: Row, b: Row, c: Row) -> f64 {
    // Rows with sum 1 lie in a plane: a turn in it is the volume that the rows span with the origin.
    let coord = |[x, y, z]: Row| Coord3D { x, y, z };
    orient3d(coord(a), coord(b), coord(c), Coord3D { x: 0.0, y: 0.0, z: 0.0 })
}

impl Triangulation {
    /// The mesh triangle alone.
    pub fn of_corners() -> Self {
        Self {
            points: vec![[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            pieces: vec![[0, 1, 2]],
            neighbours: vec![[NO_PIECE; 3]],
            piece_at: vec![0; 3],
        }
    }

    /// Where a point is.
    pub fn row(&self, point: u32) -> Row {
        self.points[point as usize]
    }

    /// All points.
    pub fn rows(&self) -> &[Row] {
        &self.points
    }

    /// Corners of every piece.
    pub fn pieces(&self) -> &[[u32; 3]] {
        &self.pieces
    }

    /// Corners of a piece.
    pub fn corners(&self, piece: u32) -> [u32; 3] {
        self.pieces[piece as usize]
    }

    /// The piece across a side, and its own side there.
    pub fn across(&self, (piece, side): Side) -> Option<Side> {
        let other = self.neighbours[piece as usize][side];
        (other != NO_PIECE).then(|| (other, self.side_towards(other, piece)))
    }

    /// The turn of three points.
    pub fn turn(&self, a: u32, b: u32, c: u32) -> f64 {
        turn(self.row(a), self.row(b), self.row(c))
    }

    /// The pieces at a point, each with the place of the point in it.
    pub fn pieces_round(&self, point: u32) -> Vec<(u32, usize)> {
        let first = self.piece_at[point as usize];
        let place = |piece: u32| self.pieces[piece as usize].iter().position(|&p| p == point).unwrap_or(0);
        let mut found = Vec::new();
        let mut piece = first;
        // Leaving by the side before the point, until round or at the rim; then the other way from the start.
        loop {
            let k = place(piece);
            found.push((piece, k));
            piece = self.neighbours[piece as usize][(k + 2) % 3];
            if piece == first {
                return found;
            }
            if piece == NO_PIECE {
                break;
            }
        }
        piece = self.neighbours[first as usize][place(first)];
        while piece != NO_PIECE {
            let k = place(piece);
            found.push((piece, k));
            piece = self.neighbours[piece as usize][k];
        }
        found
    }

    /// The side that joins two points, as seen from one of its pieces.
    pub fn find_side(&self, a: u32, b: u32) -> Option<Side> {
        self.pieces_round(a).into_iter().find_map(|(piece, k)| {
            let corners = self.pieces[piece as usize];
            if corners[(k + 1) % 3] == b {
                Some((piece, k))
            } else if corners[(k + 2) % 3] == b {
                Some((piece, (k + 2) % 3))
            } else {
                None
            }
        })
    }

    /// Puts a point on a side: two pieces become four, or one becomes two at the rim. `None`, with nothing changed, where
    /// a new piece would be turned over or have no area.
    pub fn split_side(&mut self, (piece, side): Side, row: Row) -> Option<u32> {
        let is_sound = |(piece, k): Side| {
            let [a, b, c] = self.rotated(piece, k).map(|p| self.row(p));
            turn(a, row, c) > 0.0 && turn(row, b, c) > 0.0
        };
        let twin = self.across((piece, side));
        if !is_sound((piece, side)) || !twin.is_none_or(is_sound) {
            return None;
        }
        let point = self.push_point(row, piece);
        let near = self.halve(piece, side, point);
        if let Some((other, other_side)) = twin {
            let far = self.halve(other, other_side, point);
            // `piece` kept its first half, which is the twin's second.
            self.link(piece, side, far, 0);
            self.link(near, 0, other, other_side);
        }
        Some(point)
    }

    /// Puts a point inside a piece: one becomes three.
    pub fn split_piece(&mut self, piece: u32, row: Row) -> u32 {
        let [a, b, c] = self.corners(piece);
        let [_, bc, ca] = self.neighbours[piece as usize];
        let point = self.push_point(row, piece);
        let (second, third) = (self.pieces.len() as u32, self.pieces.len() as u32 + 1);
        self.pieces[piece as usize] = [a, b, point];
        self.pieces.extend([[b, c, point], [c, a, point]]);
        self.neighbours[piece as usize][1..].copy_from_slice(&[second, third]);
        self.neighbours.extend([[bc, third, piece], [ca, piece, second]]);
        self.relink(bc, piece, second);
        self.relink(ca, piece, third);
        (self.piece_at[b as usize], self.piece_at[c as usize]) = (second, third);
        self.piece_at[a as usize] = piece;
        point
    }

    /// Replaces the side by the other diagonal of its two pieces, where their four corners are strictly convex.
    pub fn flip(&mut self, (piece, side): Side) -> bool {
        let Some((other, other_side)) = self.across((piece, side)) else { return false };
        let [a, b, c] = self.rotated(piece, side);
        let d = self.corners(other)[(other_side + 2) % 3];
        if self.turn(c, d, b) <= 0.0 || self.turn(d, c, a) <= 0.0 {
            return false;
        }
        let around = |t: &Self, p: u32, k: usize| t.neighbours[p as usize][k % 3];
        let (bc, ca) = (around(self, piece, side + 1), around(self, piece, side + 2));
        let (ad, db) = (around(self, other, other_side + 1), around(self, other, other_side + 2));
        self.pieces[piece as usize] = [c, d, b];
        self.pieces[other as usize] = [d, c, a];
        self.neighbours[piece as usize] = [other, db, bc];
        self.neighbours[other as usize] = [piece, ca, ad];
        self.relink(db, other, piece);
        self.relink(ca, piece, other);
        for (point, at) in [(a, other), (b, piece), (c, piece), (d, other)] {
            self.piece_at[point as usize] = at;
        }
        true
    }

    /// Corners of a piece with those of side `k` first.
    pub fn rotated(&self, piece: u32, k: usize) -> [u32; 3] {
        let corners = self.corners(piece);
        [corners[k], corners[(k + 1) % 3], corners[(k + 2) % 3]]
    }

    fn push_point(&mut self, row: Row, piece: u32) -> u32 {
        self.points.push(row);
        self.piece_at.push(piece);
        self.points.len() as u32 - 1
    }

    /// Cuts a piece from a point on its side to the corner opposite; keeps the first half, returns the second, whose
    /// side 0 is the rest of the side.
    fn halve(&mut self, piece: u32, side: usize, point: u32) -> u32 {
        let [_, b, c] = self.rotated(piece, side);
        let next = self.neighbours[piece as usize][(side + 1) % 3];
        let half = self.pieces.len() as u32;
        self.pieces[piece as usize][(side + 1) % 3] = point;
        self.neighbours[piece as usize][(side + 1) % 3] = half;
        self.pieces.push([point, b, c]);
        self.neighbours.push([NO_PIECE, next, piece]);
        self.relink(next, piece, half);
        (self.piece_at[b as usize], self.piece_at[c as usize]) = (half, half);
        half
    }

    fn link(&mut self, a: u32, a_side: usize, b: u32, b_side: usize) {
        self.neighbours[a as usize][a_side] = b;
        self.neighbours[b as usize][b_side] = a;
    }

    fn relink(&mut self, piece: u32, before: u32, after: u32) {
        if piece != NO_PIECE {
            let side = self.side_towards(piece, before);
            self.neighbours[piece as usize][side] = after;
        }
    }

    fn side_towards(&self, piece: u32, other: u32) -> usize {
        let towards = self.neighbours[piece as usize].iter().position(|&n| n == other);
        towards.expect("neighbours know each other")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Neighbours agree, pieces are turned like the mesh triangle and fill it.
    fn check(t: &Triangulation) {
        let mut area = 0.0;
        for (piece, &[a, b, c]) in t.pieces().iter().enumerate() {
            assert!(t.turn(a, b, c) > 0.0, "piece {piece} is turned over");
            area += t.turn(a, b, c);
            for side in 0..3 {
                if let Some((other, other_side)) = t.across((piece as u32, side)) {
                    let [p, q, _] = t.rotated(piece as u32, side);
                    assert_eq!(t.rotated(other, other_side)[..2], [q, p]);
                }
            }
        }
        assert!((area - 1.0).abs() < 1e-12, "{area}");
        for point in 0..t.rows().len() as u32 {
            let count = t.pieces().iter().filter(|corners| corners.contains(&point)).count();
            assert_eq!(t.pieces_round(point).len(), count);
        }
    }

    #[test]
    fn splits_and_flips_keep_it_whole() {
        let mut t = Triangulation::of_corners();
        let inside = t.split_piece(0, [0.25, 0.25, 0.5]);
        check(&t);
        let side = t.find_side(0, inside).expect("a side");
        let middle = t.split_side(side, [0.5, 0.2, 0.3]).expect("a sound split");
        check(&t);
        let rim = t.find_side(0, 1).expect("a side");
        t.split_side(rim, [0.5, 0.5, 0.0]).expect("a split of the rim");
        check(&t);
        let before = t.pieces().len();
        let flips = (0..before as u32).flat_map(|p| (0..3).map(move |k| (p, k))).filter(|&s| t.flip(s)).count();
        assert!(flips > 0);
        check(&t);
        assert!(t.find_side(middle, 0).is_some() || t.find_side(middle, inside).is_some());
    }

    #[test]
    fn a_split_that_turns_a_piece_over_changes_nothing() {
        let mut t = Triangulation::of_corners();
        let side = t.find_side(0, 1).expect("a side");
        assert_eq!(t.split_side(side, [1.1, -0.2, 0.1]), None);
        assert_eq!(t.pieces().len(), 1);
    }
}
