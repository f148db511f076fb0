//! The fewest sides of triangles that part a patch into polygons.
//!
//! First a good answer: sides are dropped one by one, the longest first, as long as polygons remain. Then it is tried with fewer,
//! from one on, by a search that leaves nothing out: a vertex that fewer than two edges come to lies inside a polygon or at the
//! end of a dangling edge, so one of the sides at it has to be kept; where there is none such, some side of a part that is no
//! polygon has to be. Each side is tried kept, then not kept for all that follows. Knows no lengths but by the order of the sides.

use std::collections::BTreeMap;

use super::polygon_pieces::{Inner, PolygonPiece, group, outline_of};

/// Partitions that are tried for a patch before the first answer is taken, so that the work is bounded. Eight loose lines in a
/// row need fewer.
const MOST_TRIALS: usize = 20_000;

/// A search for a partition.
struct Search<'a> {
    triangles: &'a [[u32; 3]],
    sides: &'a [Inner],
    /// How many edges come to each vertex already, lines and outline, without kept sides.
    edges_at: BTreeMap<u32, i32>,
    is_kept: Vec<bool>,
    is_dropped: Vec<bool>,
    trials: usize,
}

/// Parts a patch of `triangles`, which is no polygon, by as few of its inner `sides` as there can be, preferring those that come
/// first. Where `MOST_TRIALS` are not enough to be sure, by as few as could be found.
pub fn find_fewest(triangles: &[[u32; 3]], sides: &[Inner]) -> Vec<PolygonPiece> {
    search(triangles, sides).0
}

/// The partition, and the trials that it took.
fn search(triangles: &[[u32; 3]], sides: &[Inner]) -> (Vec<PolygonPiece>, usize) {
    let (dropped, kept) = drop_edges(triangles, sides);
    let mut search = Search {
        triangles,
        sides,
        edges_at: count_edges(triangles, sides),
        is_kept: vec![false; sides.len()],
        is_dropped: vec![false; sides.len()],
        trials: MOST_TRIALS,
    };
    // With as many as are known to do as well, for the shorter ones.
    let found = (1..=kept).find_map(|count| search.part(count)).unwrap_or(dropped);
    (found, MOST_TRIALS - search.trials)
}

/// Edges that are no inner sides, at each vertex.
fn count_edges(triangles: &[[u32; 3]], sides: &[Inner]) -> BTreeMap<u32, i32> {
    let mut found: BTreeMap<u32, i32> = triangles.iter().flatten().map(|&v| (v, 0)).collect();
    let mut edges: Vec<[u32; 2]> =
        triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).map(|[a, b]| [a.min(b), a.max(b)]).collect();
    edges.sort_unstable();
    edges.dedup();
    let all = edges.iter().flatten().map(|&v| (v, 1));
    for (v, change) in all.chain(sides.iter().flat_map(|side| side.ends).map(|v| (v, -1))) {
        *found.entry(v).or_default() += change;
    }
    found
}

impl Search<'_> {
    /// The first partition with `left` more sides kept.
    fn part(&mut self, left: usize) -> Option<Vec<PolygonPiece>> {
        self.trials = self.trials.checked_sub(1)?;
        let mut edges_at = self.edges_at.clone();
        for (side, _) in self.sides.iter().zip(&self.is_kept).filter(|(_, is_kept)| **is_kept) {
            side.ends.iter().for_each(|v| *edges_at.entry(*v).or_default() += 1);
        }
        // A side more is one edge more at two vertices.
        let missing: i32 = edges_at.values().map(|&count| (2 - count).max(0)).sum();
        if missing as usize > 2 * left {
            return None;
        }
        let groups = group(self.triangles.len(), self.sides, |i| !self.is_kept[i]);
        let polygon = |members: &Vec<u32>| {
            Some(PolygonPiece { corners: outline_of(self.triangles, members)?, members: members.clone() })
        };
        let pieces: Vec<_> = groups.iter().map(polygon).collect();
        let Some(bad) = pieces.iter().position(Option::is_none) else {
            return Some(pieces.into_iter().flatten().collect());
        };
        if left == 0 {
            return None;
        }
        let candidates = self.candidates(&edges_at, &groups[bad]);
        let mut found = None;
        for &side in &candidates {
            self.is_kept[side] = true;
            found = self.part(left - 1);
            self.is_kept[side] = false;
            if found.is_some() {
                break;
            }
            self.is_dropped[side] = true;
        }
        candidates.iter().for_each(|&side| self.is_dropped[side] = false);
        found
    }

    /// Sides of which one has to be kept, so that `bad` becomes polygons and every vertex gets its two edges.
    fn candidates(&self, edges_at: &BTreeMap<u32, i32>, bad: &[u32]) -> Vec<usize> {
        let free: Vec<usize> = (0..self.sides.len()).filter(|&i| !self.is_kept[i] && !self.is_dropped[i]).collect();
        let at = |v: u32| free.iter().copied().filter(|&i| self.sides[i].ends.contains(&v)).collect::<Vec<_>>();
        let lacking = edges_at.iter().filter(|(_, count)| **count < 2).map(|(&v, _)| at(v));
        lacking.min_by_key(Vec::len).unwrap_or_else(|| {
            let is_inside = |i: &usize| self.sides[*i].between.iter().all(|t| bad.binary_search(t).is_ok());
            free.iter().copied().filter(is_inside).collect()
        })
    }
}

/// Starts with every triangle by itself and drops sides, the longest first, where a polygon remains; also how many are kept.
fn drop_edges(triangles: &[[u32; 3]], sides: &[Inner]) -> (Vec<PolygonPiece>, usize) {
    let mut pieces: Vec<Option<PolygonPiece>> = triangles
        .iter()
        .enumerate()
        .map(|(t, corners)| Some(PolygonPiece { corners: corners.to_vec(), members: vec![t as u32] }))
        .collect();
    let mut place: Vec<usize> = (0..triangles.len()).collect();
    for side in sides.iter().rev() {
        let (p, q) = (place[side.between[0] as usize], place[side.between[1] as usize]);
        if p == q {
            continue;
        }
        let members_of = |i: usize| pieces[i].as_ref().map_or(&[][..], |piece| &piece.members);
        let mut members = [members_of(p), members_of(q)].concat();
        members.sort_unstable();
        if let Some(corners) = outline_of(triangles, &members) {
            for &t in &members {
                place[t as usize] = p;
            }
            pieces[p] = Some(PolygonPiece { corners, members });
            pieces[q] = None;
        }
    }
    let kept = sides.iter().filter(|side| place[side.between[0] as usize] != place[side.between[1] as usize]).count();
    (pieces.into_iter().flatten().collect(), kept)
}

#[cfg(test)]
mod tests {
    use super::super::polygon_pieces::join_pieces;
    use super::*;

    /// Squares of a grid, each cut in two, some along the other diagonal.
    fn grid(columns: u32, rows: u32, turned: u64) -> Vec<[u32; 3]> {
        let corner = |i: u32, j: u32| j * (columns + 1) + i;
        let cells = (0..rows).flat_map(|j| (0..columns).map(move |i| (i, j)));
        cells
            .flat_map(|(i, j)| {
                let [a, b, c, d] = [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)];
                if turned >> (j * columns + i) & 1 == 0 { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] }
            })
            .collect()
    }

    /// Numbers that look random (Knuth's multiplier).
    fn next(state: &mut u64) -> u64 {
        *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        *state >> 33
    }

    fn inner_edges(triangles: &[[u32; 3]]) -> Vec<Inner> {
        let mut found: Vec<Inner> = Vec::new();
        for (s, one) in (0..).zip(triangles) {
            for (t, other) in (0..s).zip(triangles) {
                let ends: Vec<u32> = one.iter().copied().filter(|v| other.contains(v)).collect();
                if let [a, b] = ends[..] {
                    found.push(Inner { ends: [a.min(b), a.max(b)], between: [t, s] });
                }
            }
        }
        found
    }

    /// Whether some set of `left` more of the sides from `first` on parts the triangles into polygons; tries all.
    fn can_be_parted(
        triangles: &[[u32; 3]],
        sides: &[Inner],
        kept: &mut Vec<usize>,
        first: usize,
        left: usize,
    ) -> bool {
        if left == 0 {
            let groups = group(triangles.len(), sides, |i| !kept.contains(&i));
            return groups.iter().all(|members| outline_of(triangles, members).is_some());
        }
        (first..sides.len()).any(|side| {
            kept.push(side);
            let is_parted = can_be_parted(triangles, sides, kept, side + 1, left - 1);
            kept.pop();
            is_parted
        })
    }

    #[test]
    fn no_fewer_edges_part_a_patch_into_polygons() {
        let mut state = 5;
        let mut by_edges = [0; 12];
        for round in 0..70 {
            let triangles = grid(4, 3, next(&mut state));
            let part = [3, 4, 6][round % 3];
            let (lines, sides): (Vec<Inner>, Vec<Inner>) =
                inner_edges(&triangles).into_iter().partition(|_| next(&mut state) % part == 0);
            let is_line = |a: u32, b: u32| lines.iter().any(|line| line.ends == [a, b]);
            let found = join_pieces(&triangles, is_line, |a, b| f64::from(a * 7 % 5 + b * 3 % 7));
            let piece = |t: u32| found.iter().position(|piece| piece.members.contains(&t));
            let count = sides.iter().filter(|side| piece(side.between[0]) != piece(side.between[1])).count();
            by_edges[count] += 1;
            // Every set of fewer is tried; sets of five and more are too many.
            for fewer in 0..count.min(5) {
                assert!(
                    !can_be_parted(&triangles, &sides, &mut Vec::new(), 0, fewer),
                    "round {round}: {fewer} would do"
                );
            }
        }
        assert!(by_edges[3..=5].iter().sum::<u32>() > 20, "extra edges in these rounds: {by_edges:?}");
    }

    #[test]
    fn loose_lines_in_a_row_are_joined_to_two_polygons_within_the_trials() {
        // Outline, gap, line, gap, ... line, gap, outline along the middle of a grid: as many edges as there are gaps.
        for count in 1..=8u32 {
            let columns = 2 * count + 1;
            let triangles = grid(columns, 2, 0x5a5a_5a5a_5a5a);
            let middle = columns + 1;
            let is_line = |a: u32, b: u32| b == a + 1 && a > middle && b <= middle + 2 * count && (a - middle) % 2 == 1;
            let mut sides = inner_edges(&triangles);
            sides.retain(|side| !is_line(side.ends[0], side.ends[1]));
            let (pieces, trials) = search(&triangles, &sides);
            assert_eq!(pieces.len(), 2, "{count} lines");
            assert!(trials < MOST_TRIALS, "{count} lines took {trials} trials");
        }
    }
}
