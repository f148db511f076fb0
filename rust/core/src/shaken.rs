//! The same mesh with vertices moved apart where triangles have no area, so that every angle means something.
//!
//! At an edge without length a direction is anything, and whether a line is better off on the other side of a vertex
//! there is no question of angles. Moved by a hundred-billionth of an edge, each vertex by its own hash, the vertices lie in
//! some order, and the two-angle rule ends as it does elsewhere: what is locally shortest there is so, to that
//! share, on the mesh itself. Holds no lines.

use glam::DVec3;

use crate::mesh::SurfaceMesh;

/// How far a vertex is moved, as a share of its longest edge: far below a line's own tolerance of 1e-9 radians.
const SHARE: f64 = 1.0 / (1u64 << 36) as f64;

/// But no less than so many units in the last place of its coordinates, or moving it would be rounding alone.
const LEAST_PLACES: f64 = 1024.0;

/// A triangle without area: its height is below this share of its longest side.
const FLAT: f64 = 1e-9;

/// The mesh with the vertices of triangles without area moved apart. Ids of triangles and half-edges are the same.
///
/// Cost: O(triangles).
pub fn shaken(mesh: &SurfaceMesh) -> SurfaceMesh {
    let mut positions = mesh.positions().to_vec();
    let mut longest = vec![0.0_f64; positions.len()];
    let mut is_moved = vec![false; positions.len()];
    for corners in mesh.triangles() {
        let [a, b, c] = corners.map(|v| mesh.positions()[v as usize]);
        let side = a.distance(b).max(b.distance(c)).max(c.distance(a));
        // Scaled first: squares of small lengths vanish.
        let unit = if side > 0.0 { side } else { 1.0 };
        let is_flat = ((b - a) / unit).cross((c - a) / unit).length() <= FLAT;
        for v in corners.map(|v| v as usize) {
            longest[v] = longest[v].max(side);
            is_moved[v] |= is_flat;
        }
    }
    let size = longest.iter().copied().fold(0.0, f64::max);
    // All in one place: any length will do.
    let size = if size > 0.0 { size } else { 1.0 };
    for (v, position) in positions.iter_mut().enumerate().filter(|(v, _)| is_moved[*v]) {
        let edge = if longest[v] > 0.0 { longest[v] } else { size };
        let reach = (SHARE * edge).max(LEAST_PLACES * f64::EPSILON * position.abs().max_element());
        *position += reach * direction_of(v as u64);
    }
    SurfaceMesh::new(positions, mesh.triangles().to_vec(), None).expect("vertices moved by a little are as legal")
}

/// Three numbers from -1 to 1 that are a vertex's own.
fn direction_of(vertex: u64) -> DVec3 {
    let part = |axis: u64| {
        // The finaliser of SplitMix64 (G. Steele, D. Lea, C. Flood 2014).
        let mut z = (3 * vertex + axis + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (z ^ (z >> 31)) as i64 as f64 / i64::MAX as f64
    };
    DVec3::new(part(0), part(1), part(2))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vertices_in_one_place_are_moved_apart_and_others_stay() {
        let positions =
            [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [1.0, 1.0], [0.0, 1.0]].map(|[x, y]| DVec3::new(x, y, 0.0));
        let mesh = SurfaceMesh::new(positions.to_vec(), vec![[0, 1, 4], [1, 2, 3]], None).expect("a legal mesh");
        let moved = shaken(&mesh);
        assert_eq!((moved.positions()[0], moved.positions()[4]), (positions[0], positions[4]));
        let apart = moved.positions()[2].distance(moved.positions()[3]);
        assert!(apart > 1e-12 && apart < 1e-10, "{apart}");
        assert_eq!(moved.report().zero_area_triangles, 0);
    }
}
