//! The outline of a patch of triangles, where it is one simple polygon.

/// The corners round a patch of triangles in their own turn, from the first corner of the first triangle; `None` where the
/// patch is no polygon: it has a hole, a dangling edge, a vertex inside or twice on its outline, parts that hang together
/// by nothing, or triangles turned against each other. Cost: O(n log n).
pub fn outline(triangles: &[[u32; 3]]) -> Option<Vec<u32>> {
    if let [one] = triangles {
        return Some(one.to_vec());
    }
    if let [one, other] = triangles {
        return outline_of_two(*one, *other).map(|corners| corners.to_vec());
    }
    let mut sides: Vec<[u32; 2]> = triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).collect();
    sides.sort_unstable_by_key(|&[a, b]| (a.min(b), a.max(b)));
    let mut rim = Vec::with_capacity(triangles.len() + 2);
    for same in sides.chunk_by(|p, q| p[0].min(p[1]) == q[0].min(q[1]) && p[0].max(p[1]) == q[0].max(q[1])) {
        match *same {
            [side] => rim.push(side),
            [one, other] if one != other => {}
            _ => return None,
        }
    }
    // A disc of n triangles with all its vertices on the rim has n + 2 of them (Euler).
    if rim.len() != triangles.len() + 2 {
        return None;
    }
    rim.sort_unstable();
    let next = |v: u32| rim.binary_search_by_key(&v, |side| side[0]).ok().map(|i| rim[i][1]);
    if rim.windows(2).any(|pair| pair[0][0] == pair[1][0]) {
        return None;
    }
    let start = triangles[0][0];
    let mut found = vec![start];
    let mut here = next(start)?;
    while here != start {
        found.push(here);
        here = next(here)?;
    }
    (found.len() == rim.len()).then_some(found)
}

/// [`outline`] of two triangles, as nearly all polygons are.
pub fn outline_of_two(one: [u32; 3], other: [u32; 3]) -> Option<[u32; 4]> {
    for k in 0..3 {
        let [a, b, c] = [one[k], one[(k + 1) % 3], one[(k + 2) % 3]];
        for j in 0..3 {
            let apex = other[(j + 2) % 3];
            if [other[j], other[(j + 1) % 3]] == [b, a] && apex != c {
                // Between a and b comes the other's apex.
                return Some(match k {
                    0 => [a, apex, b, c],
                    1 => [c, a, apex, b],
                    _ => [b, c, a, apex],
                });
            }
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quad_begins_where_its_first_triangle_does() {
        assert_eq!(outline(&[[0, 1, 2], [0, 2, 3]]), Some(vec![0, 1, 2, 3]));
        assert_eq!(outline(&[[0, 1, 3], [1, 2, 3]]), Some(vec![0, 1, 2, 3]));
        assert_eq!(outline(&[[1, 3, 0], [1, 2, 3]]), Some(vec![1, 2, 3, 0]));
        assert_eq!(outline(&[[0, 1, 2], [0, 2, 3], [0, 3, 4]]), Some(vec![0, 1, 2, 3, 4]));
    }

    #[test]
    fn what_is_no_polygon_has_no_outline() {
        // A vertex inside, a shared corner alone, opposite turns, a hole, the same triangle from both sides.
        assert_eq!(outline(&[[0, 1, 3], [1, 2, 3], [2, 0, 3]]), None);
        assert_eq!(outline(&[[0, 1, 2], [0, 3, 4]]), None);
        assert_eq!(outline(&[[0, 1, 2], [0, 3, 2]]), None);
        assert_eq!(outline(&[[0, 1, 2], [2, 1, 0]]), None);
        let ring: Vec<[u32; 3]> =
            (0..3).flat_map(|i| [[i, (i + 1) % 3, i + 3], [(i + 1) % 3, (i + 1) % 3 + 3, i + 3]]).collect();
        assert_eq!(outline(&ring), None);
    }
}
