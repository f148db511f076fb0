//! Made meshes: planes, closed and open surfaces, one-sided ones, fans, and meshes with walls.

use std::collections::HashMap;
use std::f64::consts::{PI, TAU};

use glam::{DAffine3, DVec3};
use smooth_polylines_core::SurfaceMesh;

use super::random::Random;

/// Positions and triangles, before they become a mesh.
#[derive(Clone, Debug)]
pub struct Shape {
    pub positions: Vec<DVec3>,
    pub triangles: Vec<[u32; 3]>,
}

impl Shape {
    /// The mesh; shapes are legal.
    pub fn mesh(&self) -> SurfaceMesh {
        SurfaceMesh::new(self.positions.clone(), self.triangles.clone(), None).expect("a legal mesh")
    }

    /// The triangle whose barycentre is nearest to a point, the lowest on a tie.
    pub fn nearest(&self, point: DVec3) -> usize {
        let distance = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|v| self.positions[v as usize]);
            ((a + b + c) / 3.0).distance(point)
        };
        (0..self.triangles.len())
            .min_by(|&i, &j| distance(&self.triangles[i]).total_cmp(&distance(&self.triangles[j])))
            .expect("a shape has triangles")
    }

    /// The diagonal of the bounding box.
    pub fn size(&self) -> f64 {
        let low = self.positions.iter().copied().fold(DVec3::INFINITY, DVec3::min);
        let high = self.positions.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
        low.distance(high)
    }

    /// Every position moved.
    pub fn moved(&self, by: &DAffine3) -> Self {
        let positions = self.positions.iter().map(|&p| by.transform_point3(p)).collect();
        Self { positions, triangles: self.triangles.clone() }
    }

    /// Vertices and triangles under other numbers; also returns the new number of each triangle.
    pub fn relabelled(&self, random: &mut Random) -> (Self, Vec<usize>) {
        let new_vertex = random.order(self.positions.len());
        let new_triangle = random.order(self.triangles.len());
        let mut positions = vec![DVec3::ZERO; self.positions.len()];
        for (v, &p) in self.positions.iter().enumerate() {
            positions[new_vertex[v]] = p;
        }
        let mut triangles = vec![[0; 3]; self.triangles.len()];
        for (t, corners) in self.triangles.iter().enumerate() {
            let mut corners = corners.map(|v| new_vertex[v as usize] as u32);
            corners.rotate_left(random.below(3));
            triangles[new_triangle[t]] = corners;
        }
        (Self { positions, triangles }, new_triangle)
    }

    /// Every other triangle, by chance, with its winding flipped.
    pub fn flipped(&self, random: &mut Random) -> Self {
        let mut triangles = self.triangles.clone();
        for corners in triangles.iter_mut() {
            if random.one_in(2) {
                corners.swap(1, 2);
            }
        }
        Self { positions: self.positions.clone(), triangles }
    }
}

/// Rows and columns of vertices joined to triangles, two a cell; `wraps`: the last column is joined to the first, the last
/// row to the first. `is_flipped` says which diagonal a cell has.
fn lattice(
    columns: usize,
    rows: usize,
    wraps: [bool; 2],
    place: impl Fn(usize, usize) -> DVec3,
    mut is_flipped: impl FnMut() -> bool,
) -> Shape {
    let vertex_columns = columns + usize::from(!wraps[0]);
    let vertex_rows = rows + usize::from(!wraps[1]);
    let positions = (0..vertex_rows).flat_map(|j| (0..vertex_columns).map(move |i| (i, j)));
    let positions = positions.map(|(i, j)| place(i, j)).collect();
    let vertex = |i: usize, j: usize| ((j % vertex_rows) * vertex_columns + i % vertex_columns) as u32;
    let mut triangles = Vec::with_capacity(2 * columns * rows);
    for j in 0..rows {
        for i in 0..columns {
            let [a, b, c, d] = [vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)];
            triangles.extend(if is_flipped() { [[a, b, d], [b, c, d]] } else { [[a, b, c], [a, c, d]] });
        }
    }
    Shape { positions, triangles }
}

/// The unit square in the plane z = 0, `cells` a side, all diagonals alike.
pub fn grid(cells: usize) -> Shape {
    let side = cells as f64;
    lattice(cells, cells, [false; 2], |i, j| DVec3::new(i as f64, j as f64, 0.0) / side, || false)
}

/// The unit square with its inner vertices moved by up to a fifth of a cell, and diagonals by chance.
pub fn irregular_grid(cells: usize, seed: u64) -> Shape {
    let mut random = Random::new(seed);
    let mut shape = lattice(
        cells,
        cells,
        [false; 2],
        |i, j| DVec3::new(i as f64, j as f64, 0.0) / cells as f64,
        || random.one_in(2),
    );
    for p in &mut shape.positions {
        if [p.x, p.y].iter().all(|&x| x > 0.0 && x < 1.0) {
            let step = 0.2 / cells as f64;
            *p += DVec3::new(random.between(-step, step), random.between(-step, step), 0.0);
        }
    }
    shape
}

/// An irregular grid lifted to hills and valleys.
pub fn hills(cells: usize, seed: u64) -> Shape {
    let mut shape = irregular_grid(cells, seed);
    for p in &mut shape.positions {
        p.z = 0.12 * (7.0 * p.x).sin() * (6.0 * p.y + 1.0).cos() + 0.05 * (15.0 * (p.x + p.y)).sin();
    }
    shape
}

/// The unit sphere: an icosahedron whose triangles are cut in four, `levels` times.
pub fn icosphere(levels: usize) -> Shape {
    let g = (1.0 + 5f64.sqrt()) / 2.0;
    let mut positions: Vec<DVec3> = [
        [-1.0, g, 0.0],
        [1.0, g, 0.0],
        [-1.0, -g, 0.0],
        [1.0, -g, 0.0],
        [0.0, -1.0, g],
        [0.0, 1.0, g],
        [0.0, -1.0, -g],
        [0.0, 1.0, -g],
        [g, 0.0, -1.0],
        [g, 0.0, 1.0],
        [-g, 0.0, -1.0],
        [-g, 0.0, 1.0],
    ]
    .map(|p| DVec3::from_array(p).normalize())
    .to_vec();
    let rows = "0 11 5 0 5 1 0 1 7 0 7 10 0 10 11 1 5 9 5 11 4 11 10 2 10 7 6 7 1 8 \
                3 9 4 3 4 2 3 2 6 3 6 8 3 8 9 4 9 5 2 4 11 6 2 10 8 6 7 9 8 1";
    let ids: Vec<u32> = rows.split_whitespace().map(|id| id.parse().expect("a number")).collect();
    let mut triangles: Vec<[u32; 3]> = ids.chunks(3).map(|t| [t[0], t[1], t[2]]).collect();
    for _ in 0..levels {
        let mut middles: HashMap<(u32, u32), u32> = HashMap::new();
        let mut finer = Vec::with_capacity(4 * triangles.len());
        for [a, b, c] in triangles {
            let mut middle = |u: u32, v: u32| {
                *middles.entry((u.min(v), u.max(v))).or_insert_with(|| {
                    positions.push((positions[u as usize] + positions[v as usize]).normalize());
                    positions.len() as u32 - 1
                })
            };
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            finer.extend([[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]);
        }
        triangles = finer;
    }
    Shape { positions, triangles }
}

/// A torus round the z axis: `large` from the axis to the tube's middle, `small` the tube's radius.
pub fn torus(large: f64, small: f64, around: usize, across: usize) -> Shape {
    let place = |i: usize, j: usize| {
        let (u, v) = (TAU * i as f64 / around as f64, TAU * j as f64 / across as f64);
        let r = large + small * v.cos();
        DVec3::new(r * u.cos(), r * u.sin(), small * v.sin())
    };
    lattice(around, across, [true, true], place, || false)
}

/// A cylinder round the z axis without its ends.
pub fn cylinder(radius: f64, height: f64, around: usize, rows: usize) -> Shape {
    let place = |i: usize, j: usize| {
        let u = TAU * i as f64 / around as f64;
        DVec3::new(radius * u.cos(), radius * u.sin(), height * (j as f64 / rows as f64 - 0.5))
    };
    lattice(around, rows, [true, false], place, || false)
}

/// A tube round the z axis, thinnest at z = 0 (an hourglass, of negative curvature there).
pub fn waist(around: usize, rows: usize) -> Shape {
    let mut shape = cylinder(1.0, 2.0, around, rows);
    for p in &mut shape.positions {
        let r = 0.5 + 0.5 * p.z * p.z;
        (p.x, p.y) = (p.x * r, p.y * r);
    }
    shape
}

/// A Moebius strip round the z axis: one-sided, so its windings cannot agree.
pub fn moebius(around: usize, across: usize) -> Shape {
    let place = |i: usize, j: usize| {
        let u = TAU * i as f64 / around as f64;
        let v = 0.6 * (j as f64 / across as f64 - 0.5);
        let r = 1.0 + v * (u / 2.0).cos();
        DVec3::new(r * u.cos(), r * u.sin(), v * (u / 2.0).sin())
    };
    let mut shape = lattice(around, across, [false, false], place, || false);
    // The last column is the first, upside down.
    let columns = around + 1;
    for corner in shape.triangles.iter_mut().flatten() {
        let (i, j) = (*corner as usize % columns, *corner as usize / columns);
        if i == around {
            *corner = ((across - j) * columns) as u32;
        }
    }
    shape
}

/// Triangles round vertex 0: a rim of `valence` vertices at distance 1, raised and lowered in turn by `wave`.
///
/// Wave 0 is flat; an even valence with a wave is a saddle (the angle round vertex 0 is above a full turn).
pub fn fan(valence: usize, wave: f64) -> Shape {
    let rim = |i: usize| {
        let u = TAU * i as f64 / valence as f64;
        DVec3::new(u.cos(), u.sin(), if i % 2 == 0 { wave } else { -wave })
    };
    let positions = std::iter::once(DVec3::ZERO).chain((0..valence).map(rim)).collect();
    let triangles = (0..valence).map(|i| [0, 1 + i as u32, 1 + ((i + 1) % valence) as u32]).collect();
    Shape { positions, triangles }
}

/// A pointed cone: a fan whose middle is raised by `height`.
pub fn cone(valence: usize, height: f64) -> Shape {
    let mut shape = fan(valence, 0.0);
    shape.positions[0].z = height;
    shape
}

/// Sheets that share one edge line, like the pages of a book: with three or more, its spine is a wall.
pub fn book(pages: usize, cells: usize) -> Shape {
    let spine: Vec<DVec3> = (0..=cells).map(|j| DVec3::new(0.0, j as f64, 0.0) / cells as f64).collect();
    let mut shape = Shape { positions: spine, triangles: Vec::new() };
    for page in 0..pages {
        let angle = PI * page as f64 / pages as f64;
        let sheet = grid(cells);
        let first_own = shape.positions.len();
        let mut id = vec![0u32; sheet.positions.len()];
        for (v, p) in sheet.positions.iter().enumerate() {
            let (i, j) = (v % (cells + 1), v / (cells + 1));
            id[v] = if i == 0 { j as u32 } else { (first_own + j * cells + i - 1) as u32 };
            if i > 0 {
                shape.positions.push(DVec3::new(p.x * angle.cos(), p.y, p.x * angle.sin()));
            }
        }
        shape.triangles.extend(sheet.triangles.iter().map(|t| t.map(|v| id[v as usize])));
    }
    shape
}

/// A flat grid with a fin that stands on the middle row's edges from x = 0 to `length`: those edges are walls, so a line
/// from below to above goes round the fin's end. `cells` must be even.
pub fn finned_grid(cells: usize, length: f64) -> Shape {
    let mut shape = grid(cells);
    let vertex = |i: usize| ((cells / 2) * (cells + 1) + i) as u32;
    let wall_cells = (length * cells as f64).round() as usize;
    for i in 0..wall_cells {
        let tip = shape.positions.len() as u32;
        let middle = 0.5 * (shape.positions[vertex(i) as usize] + shape.positions[vertex(i + 1) as usize]);
        shape.positions.push(middle + DVec3::new(0.0, 0.0, 0.5));
        shape.triangles.push([vertex(i), vertex(i + 1), tip]);
    }
    shape
}
