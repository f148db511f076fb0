//! Polygons after the cut: pieces of triangles joined again to as few polygons as there can be.
//!
//! A polygon has no hole and no dangling edge. Where a line ends inside a polygon or lies in it whole, sides of the
//! pieces are kept as extra edges: the fewest that do (`fewest`). All of them lie inside the polygon's own triangles, so they
//! are right for concave polygons too. Knows no mesh.

use std::collections::HashMap;

use super::fewest::find_fewest;
use super::loops::outline;

/// A polygon and the pieces that it is made of.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct PolygonPiece {
    /// Its corners, turned as its triangles are.
    pub corners: Vec<u32>,
    /// Which of the triangles are in it.
    pub members: Vec<u32>,
}

/// A side between two triangles.
#[derive(Clone, Copy, Debug)]
pub struct Inner {
    /// The vertices that it joins.
    pub ends: [u32; 2],
    /// The triangles.
    pub between: [u32; 2],
}

/// Joins the `triangles` of one polygon across every side that is no line. `length` orders extra edges.
///
/// With the triangles of a polygon that no line meets, this is the polygon itself, or, if its triangles are no polygon
/// (a hole, a vertex inside), as few as they make.
pub fn join_pieces(
    triangles: &[[u32; 3]],
    is_line: impl Fn(u32, u32) -> bool,
    length: impl Fn(u32, u32) -> f64,
) -> Vec<PolygonPiece> {
    let mut inner = find_inner(triangles, is_line);
    inner.sort_by(|p, q| {
        length(p.ends[0], p.ends[1]).total_cmp(&length(q.ends[0], q.ends[1])).then(p.ends.cmp(&q.ends))
    });
    let mut found = Vec::new();
    for patch in group(triangles.len(), &inner, |_| true) {
        match outline_of(triangles, &patch) {
            Some(corners) => found.push(PolygonPiece { corners, members: patch }),
            None => found.extend(part(triangles, patch, &inner)),
        }
    }
    found
}

/// Sides that two triangles share, turned alike, and that are no line.
fn find_inner(triangles: &[[u32; 3]], is_line: impl Fn(u32, u32) -> bool) -> Vec<Inner> {
    let mut seen: HashMap<[u32; 2], Vec<(u32, bool)>> = HashMap::new();
    let mut order = Vec::new();
    for (t, corners) in triangles.iter().enumerate() {
        for k in 0..3 {
            let (a, b) = (corners[k], corners[(k + 1) % 3]);
            let ends = [a.min(b), a.max(b)];
            let entry = seen.entry(ends).or_default();
            if entry.is_empty() {
                order.push(ends);
            }
            entry.push((t as u32, a < b));
        }
    }
    let shared = order.into_iter().filter_map(|ends| match seen[&ends][..] {
        [(s, up), (t, other_up)] if up != other_up && s != t && !is_line(ends[0], ends[1]) => {
            Some(Inner { ends, between: [s, t] })
        }
        _ => None,
    });
    shared.collect()
}

/// Triangles that hang together by the sides that `is_open` (by number) tells, each group in rising order.
pub fn group(count: usize, inner: &[Inner], is_open: impl Fn(usize) -> bool) -> Vec<Vec<u32>> {
    let mut root: Vec<u32> = (0..count as u32).collect();
    fn find(root: &mut [u32], mut t: u32) -> u32 {
        while root[t as usize] != t {
            root[t as usize] = root[root[t as usize] as usize];
            t = root[t as usize];
        }
        t
    }
    for (i, side) in inner.iter().enumerate() {
        if is_open(i) {
            let (s, t) = (find(&mut root, side.between[0]), find(&mut root, side.between[1]));
            root[s.max(t) as usize] = s.min(t);
        }
    }
    let mut groups: Vec<Vec<u32>> = Vec::new();
    let mut place = vec![u32::MAX; count];
    for t in 0..count as u32 {
        let first = find(&mut root, t);
        if place[first as usize] == u32::MAX {
            place[first as usize] = groups.len() as u32;
            groups.push(Vec::new());
        }
        groups[place[first as usize] as usize].push(t);
    }
    groups
}

/// The outline of some of the triangles.
pub fn outline_of(triangles: &[[u32; 3]], members: &[u32]) -> Option<Vec<u32>> {
    outline(&members.iter().map(|&t| triangles[t as usize]).collect::<Vec<_>>())
}

/// Parts a patch that is no polygon by the fewest extra edges.
fn part(triangles: &[[u32; 3]], patch: Vec<u32>, inner: &[Inner]) -> Vec<PolygonPiece> {
    let own: Vec<[u32; 3]> = patch.iter().map(|&t| triangles[t as usize]).collect();
    let local = |t: u32| patch.binary_search(&t).ok().map(|i| i as u32);
    let sides: Vec<Inner> = inner
        .iter()
        .filter_map(|side| Some(Inner { between: [local(side.between[0])?, local(side.between[1])?], ..*side }))
        .collect();
    let found = find_fewest(&own, &sides);
    let back = |piece: PolygonPiece| PolygonPiece {
        members: piece.members.into_iter().map(|t| patch[t as usize]).collect(),
        ..piece
    };
    found.into_iter().map(back).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Triangles of the unit square with a hub 4 inside, round which a closed line could run.
    fn no_line(_: u32, _: u32) -> bool {
        false
    }

    fn unit(_: u32, _: u32) -> f64 {
        1.0
    }

    #[test]
    fn a_polygon_without_a_line_is_itself() {
        let pieces = join_pieces(&[[0, 1, 2], [0, 2, 3], [0, 3, 4]], no_line, unit);
        assert_eq!(pieces, [PolygonPiece { corners: vec![0, 1, 2, 3, 4], members: vec![0, 1, 2] }]);
    }

    #[test]
    fn a_line_that_ends_inside_takes_one_extra_edge() {
        // A square round vertex 4; the line runs from 0 to 4 and ends there.
        let fan = [[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]];
        let pieces = join_pieces(&fan, |a, b| [a, b] == [0, 4], unit);
        assert_eq!(pieces.len(), 2);
        assert!(pieces.iter().all(|piece| piece.corners.contains(&4) && piece.corners.contains(&0)));
    }

    #[test]
    fn a_closed_line_inside_takes_two_extra_edges() {
        // A triangle 0 1 2 with the closed line 3 4 5 in it.
        let ring = (0..3u32).flat_map(|i| {
            let j = (i + 1) % 3;
            [[i, j, i + 3], [j, j + 3, i + 3]]
        });
        let triangles: Vec<_> = ring.chain([[3, 4, 5]]).collect();
        let is_line = |a: u32, b: u32| a >= 3 && b >= 3;
        let pieces = join_pieces(&triangles, is_line, unit);
        assert_eq!(pieces.len(), 3);
        assert_eq!(pieces.iter().map(|piece| piece.members.len()).sum::<usize>(), 7);
    }

    #[test]
    fn four_ends_inside_take_the_fewest_by_dropping() {
        // A hub with eight spokes; lines on every other spoke would be four dangling ends, joined here in the hub.
        let fan: Vec<[u32; 3]> = (0..8).map(|i| [i, (i + 1) % 8, 8]).collect();
        let pieces = join_pieces(&fan, |a, b| b == 8 && a % 2 == 0, unit);
        assert_eq!(pieces.len(), 4);
        assert!(pieces.iter().all(|piece| piece.corners.len() == 4));
    }
}
