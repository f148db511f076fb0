//! The same mesh with vertices moved apart where triangles have no area, so that every angle means something.
//!
//! At an edge without length a direction is anything, and whether a line is better off on the other side of a vertex
//! there is no question of angles. Moved by a hundred-billionth of an edge the vertices lie in some order, and the two-angle
//! rule ends as it does elsewhere: what is locally shortest there is so, to that share, on the mesh itself.
//!
//! ```text
//!      \   sector of a  /           Vertices in one place, joined by edges without length, are a cluster. Each goes to
//!       \              /            the unit circle, in the middle of the sector that it has of the sound triangles
//!        \     a      /             round them all, and those without a sector of their own between their neighbours
//!         \  /   \   /              (W. T. Tutte 1963): in the plane nothing turns over, so that the cluster spread
//!          b ----- c                out is as flat as it was, and holds no line back. Moved by chance they would be a
//!         /         \               heap of folds that is as good as any obstacle.
//! ```
//!
//! Holds no lines.

use glam::DVec3;

use crate::ids::TriangleId;
use crate::mesh::SurfaceMesh;

/// How far a vertex is moved, as a share of its longest edge: far below a line's own tolerance of 1e-9 radians.
const SHARE: f64 = 1.0 / (1u64 << 36) as f64;

/// But no less than so many units in the last place of its coordinates, or moving it would be rounding alone.
const LEAST_PLACES: f64 = 1024.0;

/// A triangle without area: its height is below this share of its longest side.
const FLAT: f64 = 1e-9;

/// How much of a cluster's radius chance has a say in: enough that no three of its vertices are in one line for long.
const CHANCE: f64 = 1e-6;

/// Sweeps that put vertices between their neighbours. Few are needed: clusters are small.
const SWEEPS: usize = 40;

/// See the module.
#[derive(Debug)]
pub struct Shaken {
    /// The mesh; ids of triangles and half-edges are the same.
    pub mesh: SurfaceMesh,
    reach: Vec<f64>,
}

impl Shaken {
    /// How far a vertex may have been moved; 0 where it was not.
    pub fn reach(&self, vertex: usize) -> f64 {
        self.reach[vertex]
    }

    /// The mesh with the vertices of triangles without area moved apart.
    ///
    /// Cost: O(triangles).
    pub fn new(mesh: &SurfaceMesh) -> Self {
        let (mut reach, clusters) = (reach_of(mesh), Clusters::of(mesh));
        for v in 0..reach.len() {
            let root = clusters.roots[v] as usize;
            reach[root] = reach[root].max(reach[v]);
        }
        for v in 0..reach.len() {
            reach[v] = reach[clusters.roots[v] as usize];
        }
        let places = clusters.spread_out(mesh);
        let mut positions = mesh.positions().to_vec();
        for (v, position) in positions.iter_mut().enumerate().filter(|&(v, _)| reach[v] > 0.0) {
            let chance = direction_of(v as u64);
            *position += reach[v] * places.get(v).and_then(|place| *place).map_or(chance, |at| at + CHANCE * chance);
        }
        let mesh = SurfaceMesh::new(positions, mesh.triangles().to_vec(), None);
        Self { mesh: mesh.expect("vertices moved by a little are as legal"), reach }
    }
}

/// For each vertex how far it is to be moved; 0 where all of its triangles have area.
fn reach_of(mesh: &SurfaceMesh) -> Vec<f64> {
    let positions = mesh.positions();
    let mut longest = vec![0.0_f64; positions.len()];
    let mut is_moved = vec![false; positions.len()];
    for corners in mesh.triangles() {
        let [a, b, c] = corners.map(|v| positions[v as usize]);
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
    let reach = |v: usize| {
        let edge = if longest[v] > 0.0 { longest[v] } else { size };
        (SHARE * edge).max(LEAST_PLACES * f64::EPSILON * positions[v].abs().max_element())
    };
    (0..positions.len()).map(|v| if is_moved[v] { reach(v) } else { 0.0 }).collect()
}

/// Vertices in one place that edges without length join.
struct Clusters {
    /// One vertex of each one's cluster.
    roots: Vec<u32>,
    /// The edges without length, each from both sides.
    edges: Vec<[u32; 2]>,
}

impl Clusters {
    fn of(mesh: &SurfaceMesh) -> Self {
        let mut roots: Vec<u32> = (0..mesh.positions().len() as u32).collect();
        let mut edges = Vec::new();
        for corners in mesh.triangles() {
            for side in 0..3 {
                let (a, b) = (corners[side], corners[(side + 1) % 3]);
                if mesh.positions()[a as usize] == mesh.positions()[b as usize] {
                    edges.extend([[a, b], [b, a]]);
                    let (a, b) = (find_root(&mut roots, a), find_root(&mut roots, b));
                    roots[a.max(b) as usize] = a.min(b);
                }
            }
        }
        for v in 0..roots.len() as u32 {
            roots[v as usize] = find_root(&mut roots, v);
        }
        edges.sort_unstable();
        edges.dedup();
        Self { roots, edges }
    }

    /// Places on and in the unit circle of each cluster; `None` for vertices in none. Empty where there are no clusters.
    fn spread_out(&self, mesh: &SurfaceMesh) -> Vec<Option<DVec3>> {
        if self.edges.is_empty() {
            return Vec::new();
        }
        let (mut directions, ends) = self.sectors(mesh);
        let is_rim = rim_of(mesh);
        // All directions round a place are nothing in sum, so what lies outside the surface is what is missing.
        let (mut sums, mut rims) = (vec![DVec3::ZERO; directions.len()], vec![0u32; directions.len()]);
        for (v, &root) in self.roots.iter().enumerate() {
            sums[root as usize] += directions[v];
            rims[root as usize] += u32::from(is_rim[v]);
        }
        let mut places = vec![None; directions.len()];
        // One sector has two ends.
        let is_held = |v: usize| ends[v] == 2 || is_rim[v];
        for v in self.edges.iter().map(|edge| edge[0] as usize) {
            let root = self.roots[v] as usize;
            if is_rim[v] && places[v].is_none() {
                directions[v] -= sums[root] / f64::from(rims[root]);
            }
            places[v] = Some(if is_held(v) { directions[v].normalize_or_zero() } else { DVec3::ZERO });
        }
        for _ in 0..SWEEPS {
            for star in self.edges.chunk_by(|a, b| a[0] == b[0]) {
                let v = star[0][0] as usize;
                if !is_held(v) {
                    let sum: DVec3 = star.iter().filter_map(|&[_, w]| places[w as usize]).sum();
                    places[v] = Some(sum / star.len() as f64);
                }
            }
        }
        places
    }

    /// For each vertex the sum of the directions into its sectors, and how many ends they have: at an edge without length, or
    /// where the surface ends. A sector may be one edge between two triangles without area.
    fn sectors(&self, mesh: &SurfaceMesh) -> (Vec<DVec3>, Vec<u32>) {
        let mut directions = vec![DVec3::ZERO; self.roots.len()];
        let mut ends = vec![0; self.roots.len()];
        let is_apart = |v: u32, w: u32| self.roots[v as usize] != self.roots[w as usize];
        for (t, corners) in mesh.triangles().iter().enumerate() {
            for (k, &v) in corners.iter().enumerate() {
                let others = [corners[(k + 1) % 3], corners[(k + 2) % 3]];
                let is_sound = others.iter().all(|&w| is_apart(v, w));
                if is_sound {
                    let [one, other] = others
                        .map(|w| (mesh.positions()[w as usize] - mesh.positions()[v as usize]).normalize_or_zero());
                    // The integral of the directions from one to the other.
                    let sine = (0.5 * one.distance(other)).min(1.0);
                    directions[v as usize] += 2.0 * sine * (one + other).normalize_or_zero();
                }
                let spokes = TriangleId(t as u32).halfedges().map(|h| (h, mesh.ends(h)));
                for (spoke, spoke_ends) in spokes {
                    let is_long = is_apart(spoke_ends[0].0, spoke_ends[1].0) && spoke_ends.iter().any(|w| w.0 == v);
                    ends[v as usize] += u32::from(is_long && (!is_sound || mesh.twin(spoke).is_none()));
                }
            }
        }
        (directions, ends)
    }
}

/// Whether each vertex is on a boundary or at a wall.
fn rim_of(mesh: &SurfaceMesh) -> Vec<bool> {
    let mut is_rim = vec![false; mesh.positions().len()];
    let halfedges = (0..mesh.triangles().len() as u32).flat_map(|t| TriangleId(t).halfedges());
    for v in halfedges.filter(|&h| mesh.twin(h).is_none()).flat_map(|h| mesh.ends(h)) {
        is_rim[v.index()] = true;
    }
    is_rim
}

/// The root of a vertex's tree; halves the way there.
fn find_root(roots: &mut [u32], mut v: u32) -> u32 {
    while roots[v as usize] != v {
        roots[v as usize] = roots[roots[v as usize] as usize];
        v = roots[v as usize];
    }
    v
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
        let moved = Shaken::new(&mesh).mesh;
        assert_eq!((moved.positions()[0], moved.positions()[4]), (positions[0], positions[4]));
        let apart = moved.positions()[2].distance(moved.positions()[3]);
        assert!(apart > 1e-18 && apart < 1e-10, "{apart}");
        assert_eq!(moved.report().zero_area_triangles, 0);
    }

    /// A fan of six with its middle edge collapsed: two vertices in one place, spread out to the side where each has triangles.
    #[test]
    fn a_cluster_in_the_plane_is_spread_out_without_a_fold() {
        let at = |x: f64, y: f64| DVec3::new(x, y, 0.0);
        let rim = [at(2.0, 0.0), at(1.0, 1.0), at(-1.0, 1.0), at(-2.0, 0.0), at(-1.0, -1.0), at(1.0, -1.0)];
        let positions = [&rim[..], &[at(0.0, 0.0), at(0.0, 0.0)]].concat();
        // Vertex 6 has the left half of the rim, vertex 7 the right one.
        let triangles = vec![[7, 5, 0], [7, 0, 1], [7, 1, 6], [6, 1, 2], [6, 2, 3], [6, 3, 4], [6, 4, 5], [7, 6, 5]];
        let mesh = SurfaceMesh::new(positions, triangles.clone(), None).expect("a legal mesh");
        let moved = Shaken::new(&mesh).mesh;
        for corners in triangles {
            let [a, b, c] = corners.map(|v: u32| moved.positions()[v as usize]);
            assert!((b - a).cross(c - a).z > 0.0, "{corners:?} is turned over");
        }
    }
}
