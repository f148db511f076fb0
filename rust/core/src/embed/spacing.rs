//! Lines kept apart inside the triangles that they meet, so that no sliver comes from them.
//!
//! Lay a triangle onto an equilateral one with sides of length 1. When all is done, no two vertices in it are nearer to each
//! other than the tolerance t, and no vertex is nearer than t times the height to a side, or to a piece of a line, that it
//! does not lie on. What is nearer is led through the vertex; where two pieces cross, that is a vertex too: the nearest
//! that is there, if it is within t; else a new one, on a side if that is within t. A new one on a side may come too near
//! to lines on the other side of it, so those are looked at again.
//!
//! It comes to an end: an edge has room for 1/t vertices at most and a triangle for some 2/t^2, and whatever is led through a
//! vertex is parted into two pieces that are both shorter. Let `p` be at the distance h < t sqrt(3)/2 from the piece `ab`, its
//! foot parting that into x and y. As `p` is at least t from `b`, y^2 >= t^2 - h^2 > t^2/4, and so is x^2; so h^2 < 3 t^2/4 <
//! y (2 x + y), and |ap|^2 = x^2 + h^2 < (x + y)^2. Let `z` be the vertex nearest to the crossing X of `ab` with another
//! piece: |az| <= |aX| + |Xz| <= |aX| + |Xb| = |ab|.
//!
//! Each time the line goes on through points that are within sqrt(2) t of where it was. Source of the idea: J. D. Hobby,
//! Practical segment intersection with finite precision output (1999); D. Halperin and E. Packer, Iterated snap rounding
//! (2002), who round to a grid, while here only what is too near moves at all.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use crate::ids::TriangleId;
use crate::mesh::SurfaceMesh;
use crate::surface_point::SurfacePoint;

use super::nodes::{HEIGHT, NewVertex, Nodes, distance, distance_from_segment, foot};
use super::triangulation::{Row, turn};

/// The segments of lines in one triangle, each as the vertices that it goes through.
pub type Chains = Vec<Vec<u32>>;

/// Leads the lines in `works`, by triangle, through vertices until all are apart, as the module says.
///
/// Cost: for each triangle the square of how many pieces of lines are in it at last.
pub fn keep_apart(mesh: &SurfaceMesh, nodes: &mut Nodes, works: &mut BTreeMap<u32, Chains>, tolerance: f64) {
    let mut open: BTreeSet<u32> = works.keys().copied().collect();
    while let Some(t) = open.pop_first() {
        let Some(chains) = works.get_mut(&t) else { continue };
        let mut bundle = Bundle::new(mesh, nodes, TriangleId(t), tolerance);
        bundle.settle(chains);
        let ends = bundle.new_on_sides;
        if ends.is_empty() {
            continue;
        }
        // The triangles across, all of them at a wall.
        for (&other, _) in works.iter().filter(|&(&other, _)| other != t) {
            let corners = mesh.corners(TriangleId(other)).map(|v| v.0);
            if ends.iter().any(|pair| pair.iter().all(|end| corners.contains(end))) {
                open.insert(other);
            }
        }
    }
}

/// What is known of one triangle.
struct Bundle<'a> {
    nodes: &'a mut Nodes,
    corners: [u32; 3],
    triangle: TriangleId,
    tolerance: f64,
    /// Vertices in the triangle, its corners first.
    numbers: Vec<u32>,
    rows: Vec<Row>,
    /// Segments that use a piece, by its ends, lower first. Looked up, never walked through.
    owners: HashMap<[u32; 2], Vec<u32>>,
    /// Pieces that may be too near to something.
    open: Vec<[u32; 2]>,
    /// Pieces that are near to nothing so far.
    settled: Vec<[u32; 2]>,
    /// Mesh edges that got a new vertex.
    new_on_sides: Vec<[u32; 2]>,
}

impl<'a> Bundle<'a> {
    fn new(mesh: &SurfaceMesh, nodes: &'a mut Nodes, triangle: TriangleId, tolerance: f64) -> Self {
        let corners = mesh.corners(triangle).map(|v| v.0);
        let mut numbers = corners.to_vec();
        let mut rows: Vec<Row> = vec![[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        for k in 0..3 {
            for (t, vertex) in nodes.along(corners[k], corners[(k + 1) % 3]) {
                let mut row = [0.0; 3];
                (row[k], row[(k + 1) % 3]) = (1.0 - t, t);
                rows.push(row);
                numbers.push(vertex);
            }
        }
        for &vertex in nodes.inside.get(&triangle.0).map_or(&[][..], Vec::as_slice) {
            rows.push(nodes.row(mesh, triangle, vertex));
            numbers.push(vertex);
        }
        Self {
            nodes,
            corners,
            triangle,
            tolerance,
            numbers,
            rows,
            owners: HashMap::new(),
            open: Vec::new(),
            settled: Vec::new(),
            new_on_sides: Vec::new(),
        }
    }

    /// Leads the chains through vertices until nothing is too near to anything.
    fn settle(&mut self, chains: &mut Chains) {
        let place: HashMap<u32, u32> = self.numbers.iter().zip(0..).map(|(&number, i)| (number, i)).collect();
        let mut local: Chains = chains.iter().map(|chain| chain.iter().map(|vertex| place[vertex]).collect()).collect();
        for (segment, chain) in (0..).zip(&local) {
            for pair in chain.windows(2) {
                self.own(pair[0], pair[1], segment);
            }
        }
        // The last comes first.
        self.open.reverse();
        // Rounding alone could keep this going, which has not been seen; what is left then is cut as it is.
        let mut left = 1000 + 1000 * (self.open.len() + self.rows.len()) * (self.open.len() + self.rows.len());
        while let Some([a, b]) = self.open.pop() {
            if left == 0 {
                break;
            }
            left -= 1;
            if !self.owners.contains_key(&sorted(a, b)) || self.is_along_side(a, b) {
                continue;
            }
            if let Some(p) = self.find_too_near(a, b) {
                self.lead(&mut local, [a, b], p);
                continue;
            }
            let Some(([c, d], row)) = self.find_crossing(a, b) else {
                self.settled.push([a, b]);
                continue;
            };
            let p = self.vertex_at(row);
            self.open.push([a, b]);
            for piece in [[c, d], [a, b]] {
                if !piece.contains(&p) {
                    self.lead(&mut local, piece, p);
                }
            }
        }
        for (chain, local) in chains.iter_mut().zip(local) {
            *chain = local.into_iter().map(|i| self.numbers[i as usize]).collect();
            remove_spurs(chain);
        }
    }

    fn own(&mut self, a: u32, b: u32, segment: u32) {
        let owners = self.owners.entry(sorted(a, b)).or_default();
        if !owners.contains(&segment) {
            owners.push(segment);
        }
        self.open.push([a, b]);
    }

    /// The segments that use the piece go through `p` instead.
    fn lead(&mut self, chains: &mut Chains, [a, b]: [u32; 2], p: u32) {
        let Some(owners) = self.owners.remove(&sorted(a, b)) else { return };
        self.settled.retain(|piece| sorted(piece[0], piece[1]) != sorted(a, b));
        for segment in owners {
            lead_through(&mut chains[segment as usize], [a, b], p);
            self.own(a, p, segment);
            self.own(p, b, segment);
        }
    }

    fn is_along_side(&self, a: u32, b: u32) -> bool {
        let (a, b) = (self.rows[a as usize], self.rows[b as usize]);
        (0..3).any(|k| a[k] == 0.0 && b[k] == 0.0)
    }

    /// The vertex that is nearest to a piece, if it is too near.
    fn find_too_near(&self, a: u32, b: u32) -> Option<u32> {
        let (from, to) = (self.rows[a as usize], self.rows[b as usize]);
        let mut least = self.tolerance * HEIGHT;
        let reach = 2.0 * self.tolerance;
        let mut found = None;
        for (p, &row) in (0..).zip(&self.rows) {
            let is_far = (0..2).any(|i| row[i] < from[i].min(to[i]) - reach || row[i] > from[i].max(to[i]) + reach);
            if is_far || p == a || p == b {
                continue;
            }
            let distance = distance_from_segment(row, from, to);
            if distance < least {
                (least, found) = (distance, Some(p));
            }
        }
        found
    }

    /// A settled piece that `ab` crosses, and where.
    fn find_crossing(&self, a: u32, b: u32) -> Option<([u32; 2], Row)> {
        let (from, to) = (self.rows[a as usize], self.rows[b as usize]);
        let (low, high): (Row, Row) =
            (std::array::from_fn(|i| from[i].min(to[i])), std::array::from_fn(|i| from[i].max(to[i])));
        self.settled.iter().find_map(|&[c, d]| {
            let (p, q) = (self.rows[c as usize], self.rows[d as usize]);
            if (0..3).any(|i| p[i].max(q[i]) < low[i] || p[i].min(q[i]) > high[i])
                || [c, d].iter().any(|&e| e == a || e == b)
            {
                return None;
            }
            Some(([c, d], cross([from, to], [p, q])?))
        })
    }

    /// The vertex that a crossing becomes.
    fn vertex_at(&mut self, row: Row) -> u32 {
        let away = self.rows.iter().map(|&other| distance(row, other));
        let (nearest, least) = (0..).zip(away).min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((0, 0.0));
        if least < self.tolerance {
            return nearest;
        }
        let k = (0..3).min_by(|&i, &j| row[i].total_cmp(&row[j])).unwrap_or(0);
        if row[k] * HEIGHT >= self.tolerance {
            let point = SurfacePoint { triangle: self.triangle, barycentric: row };
            return self.add(NewVertex { point, edge: None });
        }
        let t = foot(row, k);
        let on_side = self.rows.iter().filter(|other| other[k] == 0.0);
        if on_side.map(|other| (other[(k + 2) % 3] - t).abs()).any(|gap| gap < self.tolerance) {
            return nearest;
        }
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        let mut barycentric = [0.0; 3];
        (barycentric[i], barycentric[j]) = (1.0 - t, t);
        let (low, high) = if self.corners[i] < self.corners[j] { (i, j) } else { (j, i) };
        let ends = [self.corners[low], self.corners[high]];
        self.new_on_sides.push(ends);
        let point = SurfacePoint { triangle: self.triangle, barycentric };
        self.add(NewVertex { point, edge: Some((ends, barycentric[high])) })
    }

    /// Adds a vertex; pieces that it is too near to are looked at again.
    fn add(&mut self, vertex: NewVertex) -> u32 {
        let row = vertex.point.barycentric;
        self.numbers.push(self.nodes.add(vertex));
        self.rows.push(row);
        let (rows, least) = (&self.rows, self.tolerance * HEIGHT);
        let is_near = |&[a, b]: &[u32; 2]| distance_from_segment(row, rows[a as usize], rows[b as usize]) < least;
        let (near, far) = std::mem::take(&mut self.settled).into_iter().partition::<Vec<_>, _>(is_near);
        self.open.extend(near);
        self.settled = far;
        self.rows.len() as u32 - 1
    }
}

/// Puts `p` into a chain wherever that goes from one of two points to the other.
pub fn lead_through(chain: &mut Vec<u32>, [a, b]: [u32; 2], p: u32) {
    let mut i = 0;
    while i + 1 < chain.len() {
        if sorted(chain[i], chain[i + 1]) == sorted(a, b) {
            chain.insert(i + 1, p);
            i += 1;
        }
        i += 1;
    }
}

/// Takes out what goes to a vertex and straight back, and what stands still.
fn remove_spurs(chain: &mut Vec<u32>) {
    let mut kept: Vec<u32> = Vec::with_capacity(chain.len());
    for &vertex in chain.iter() {
        if kept.len() >= 2 && kept[kept.len() - 2] == vertex {
            kept.pop();
        } else if kept.last() != Some(&vertex) {
            kept.push(vertex);
        }
    }
    *chain = kept;
}

/// The lower of two first.
pub fn sorted(a: u32, b: u32) -> [u32; 2] {
    if a < b { [a, b] } else { [b, a] }
}

/// Where two segments cross strictly inside both.
fn cross([a, b]: [Row; 2], [c, d]: [Row; 2]) -> Option<Row> {
    let (to_c, to_d) = (turn(a, b, c), turn(a, b, d));
    if to_c * to_d >= 0.0 {
        return None;
    }
    let (to_a, to_b) = (turn(c, d, a), turn(c, d, b));
    if to_a * to_b >= 0.0 {
        return None;
    }
    let s = to_a / (to_a - to_b);
    let mixed: Row = std::array::from_fn(|i| ((1.0 - s) * a[i] + s * b[i]).max(0.0));
    let sum: f64 = mixed.iter().sum();
    Some(mixed.map(|x| x / sum))
}
