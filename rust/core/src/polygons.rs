//! Which triangles make up which polygon, and the triangle that stands for a polygon.
//!
//! Holds the answer to "where is face 12" alone; knows nothing of adjacency.

use glam::DVec3;

use crate::ids::TriangleId;

/// Two distances closer than this, relative to the polygon's size, are a tie. A planar quad has its centre on the
/// diagonal: which of its halves is nearer must not hang on rounding.
const TIE: f64 = 1e-9;

/// Triangles by polygon.
#[derive(Debug)]
pub struct Polygons {
    faces: Vec<u32>,
    /// Rows of `faces` in the order of their face ids; `None` when they are in order already (as Blender's are).
    order: Option<Vec<u32>>,
}

impl Polygons {
    /// `faces[t]` is the polygon of triangle `t`.
    pub fn new(faces: Vec<u32>) -> Self {
        let order = (!faces.is_sorted()).then(|| {
            let mut order: Vec<u32> = (0..faces.len() as u32).collect();
            order.sort_by_key(|&t| faces[t as usize]);
            order
        });
        Self { faces, order }
    }

    /// Triangles of a polygon, lowest first; empty when no triangle belongs to it.
    pub fn triangles_of(&self, face: u32) -> Vec<TriangleId> {
        let key = |i: usize| self.faces[self.order.as_ref().map_or(i, |order| order[i] as usize)];
        let count = self.faces.len();
        let first = partition_point(count, |i| key(i) < face);
        let end = partition_point(count, |i| key(i) <= face);
        (first..end).map(|i| TriangleId(self.order.as_ref().map_or(i as u32, |order| order[i]))).collect()
    }

    /// Calls `visit(face, triangles)` for every polygon with triangles, by rising face id. Cost: O(triangles).
    pub fn for_each(&self, mut visit: impl FnMut(u32, &[u32])) {
        let at = |i: usize| self.order.as_ref().map_or(i as u32, |order| order[i]);
        let mut own = Vec::new();
        for i in 0..self.faces.len() {
            let t = at(i);
            own.push(t);
            let face = self.faces[t as usize];
            if i + 1 == self.faces.len() || self.faces[at(i + 1) as usize] != face {
                visit(face, &own);
                own.clear();
            }
        }
    }

    /// The polygon of each triangle.
    pub fn faces(&self) -> &[u32] {
        &self.faces
    }

    /// Number of different polygons. Cost: O(triangles).
    pub fn count(&self) -> usize {
        let key = |i: usize| self.faces[self.order.as_ref().map_or(i, |order| order[i] as usize)];
        (0..self.faces.len()).filter(|&i| i == 0 || key(i) != key(i - 1)).count()
    }
}

fn partition_point(count: usize, is_before: impl Fn(usize) -> bool) -> usize {
    let (mut low, mut high) = (0, count);
    while low < high {
        let middle = (low + high) / 2;
        if is_before(middle) { low = middle + 1 } else { high = middle }
    }
    low
}

/// The triangle of a polygon that lies nearest its centre (the mean of its vertices, as in Blender); among equally
/// near ones the one whose barycentre is nearest, then the lowest.
pub fn middle_triangle(members: &[TriangleId], triangles: &[[u32; 3]], positions: &[DVec3]) -> Option<TriangleId> {
    if members.len() <= 1 {
        return members.first().copied();
    }
    let mut vertices: Vec<u32> = members.iter().flat_map(|t| triangles[t.index()]).collect();
    vertices.sort_unstable();
    vertices.dedup();
    let at = |v: u32| positions[v as usize];
    let centre = vertices.iter().map(|&v| at(v)).sum::<DVec3>() / vertices.len() as f64;
    let size = vertices.iter().map(|&v| at(v).distance(centre)).fold(0.0, f64::max);
    let key = |t: TriangleId| {
        let corners = triangles[t.index()].map(at);
        let barycentre = (corners[0] + corners[1] + corners[2]) / 3.0;
        let steps = |d: f64| if size > 0.0 { (d / (size * TIE)).round() } else { 0.0 };
        (steps(distance_to_triangle(centre, corners)), steps(barycentre.distance(centre)))
    };
    members.iter().copied().min_by(|&a, &b| {
        let (ka, kb) = (key(a), key(b));
        ka.0.total_cmp(&kb.0).then(ka.1.total_cmp(&kb.1)).then(a.cmp(&b))
    })
}

/// Distance of a point from a filled triangle, which may have no area.
fn distance_to_triangle(p: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let to_segment = |s: DVec3, e: DVec3| {
        let d = e - s;
        let t = if d.length_squared() > 0.0 { ((p - s).dot(d) / d.length_squared()).clamp(0.0, 1.0) } else { 0.0 };
        p.distance(s + t * d)
    };
    let normal = (b - a).cross(c - a);
    let is_above = normal.length_squared() > 0.0
        && [(a, b), (b, c), (c, a)].iter().all(|&(s, e)| (e - s).cross(p - s).dot(normal) >= 0.0);
    if is_above {
        return (p - a).dot(normal.normalize()).abs();
    }
    to_segment(a, b).min(to_segment(b, c)).min(to_segment(c, a))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faces_are_found_in_any_order_of_triangles() {
        for faces in [vec![3, 3, 7, 9, 9], vec![9, 3, 7, 3, 9]] {
            let polygons = Polygons::new(faces.clone());
            for face in 0..12 {
                let expected: Vec<_> = (0..5).filter(|&t| faces[t as usize] == face).map(TriangleId).collect();
                assert_eq!(polygons.triangles_of(face), expected, "face {face} of {faces:?}");
            }
            assert_eq!(polygons.count(), 3);
        }
    }

    #[test]
    fn an_l_shaped_polygon_is_stood_for_by_the_triangle_nearest_its_centre() {
        // A long thin arm and a block: the mean of the vertices lies in the block.
        let positions: Vec<DVec3> =
            [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0], [-20.0, 3.9]].map(|[x, y]| DVec3::new(x, y, 0.0)).to_vec();
        let triangles = [[0, 3, 4], [0, 1, 2], [0, 2, 3]];
        let members: Vec<_> = (0..3).map(TriangleId).collect();
        // centre = (-2.4, 2.38): nearest is the arm, which contains points at x = -2.4
        assert_eq!(middle_triangle(&members, &triangles, &positions), Some(TriangleId(0)));
        assert_eq!(middle_triangle(&members[1..], &triangles, &positions), Some(TriangleId(1)), "tie: the lowest");
    }
}
