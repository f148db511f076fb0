//! The work of a few lines, counted: it gates performance, on every machine alike.
//!
//! A change that lowers a number is welcome: pin the new one. One that raises a number says why in its commit. The meshes
//! are made of sums, products and square roots alone, which are the same to the bit everywhere.

mod support;

use std::fmt::Write;
use std::ops::ControlFlow;

use glam::DVec3;
use smooth_polylines_core::stroke::{StrokePoints, stroke};
use smooth_polylines_core::{Filter, Observer, Options, Pick, Report, Step, SurfaceMesh};
use support::shapes::{self, Shape};
use support::{all_pinned, closed, cubic, faces, fair, files, geodesic, heap, line};

/// Rounds, moves of single crossings (one to two targets each in sweeps, four by the heap), vertices passed, triangles taken
/// from the search queue, funnels run, steps of Newton.
type Counts = [u64; 6];

/// A way to smooth, and what it takes on one line.
type Expected<'a> = [(&'a str, Counts)];

fn counts_of(report: &Report) -> Counts {
    let Report { iterations, moves, vertex_passes, pops, funnels, newton_steps, .. } = *report;
    [u64::from(iterations), moves, vertex_passes, pops, funnels, newton_steps]
}

fn options_of(way: &str) -> Options {
    match way {
        "heap" => heap(1e-4),
        "linear" => Options::default(),
        "cubic" => cubic(),
        "geodesic" => geodesic(),
        "geodesic, pinned" => all_pinned(geodesic()),
        "fair" => fair(),
        "fair, pinned" => all_pinned(fair()),
        "fair, closed" => closed(fair()),
        "fair, closed and pinned" => closed(all_pinned(fair())),
        "cubic, closed" => closed(cubic()),
        "geodesic, closed" => closed(geodesic()),
        "geodesic, closed and pinned" => closed(all_pinned(geodesic())),
        other => panic!("no way to smooth is called {other}"),
    }
}

/// Compares all ways and tells all that differ, in the form of the tables below.
fn check(name: &str, mesh: &SurfaceMesh, picks: &[Pick], expected: &Expected) {
    let mut differences = String::new();
    for &(way, counts) in expected {
        let found = counts_of(&line(mesh, picks, &options_of(way)).report);
        if found != counts {
            writeln!(differences, "        (\"{way}\", {found:?}), // pinned: {counts:?}").expect("a string takes all");
        }
    }
    assert!(differences.is_empty(), "{name}:\n{differences}");
}

/// The irregular unit square, lifted to hills by a polynomial.
fn terrain(cells: usize) -> Shape {
    let mut shape = shapes::irregular_grid(cells, 71);
    for p in &mut shape.positions {
        let wave = |x: f64| 20.0 * x * (x - 0.35) * (x - 0.7) * (x - 1.0);
        p.z = 0.6 * wave(p.x) + 0.5 * wave(p.y) + 0.3 * p.x * p.y;
    }
    shape
}

#[test]
fn a_line_across_a_terrain() {
    let shape = terrain(60);
    let mesh = shape.mesh();
    let picks = faces(&[[0.05, 0.1], [0.4, 0.85], [0.95, 0.6]].map(|[x, y]| nearest_in_plan(&shape, x, y)));
    let ends = [picks[0], picks[2]];
    check(
        "terrain",
        &mesh,
        &ends,
        &[
            ("heap", [44, 342742, 81, 3104, 171, 0]),
            ("linear", [4, 4804, 67, 1443, 31, 23]),
            ("cubic", [1, 795, 0, 3104, 0, 0]),
            ("geodesic", [17, 0, 67, 1443, 20, 0]),
        ],
    );
    check(
        "terrain, three picks",
        &mesh,
        &picks,
        &[
            ("geodesic", [168, 0, 1318, 3156, 176, 0]),
            ("geodesic, pinned", [13, 0, 73, 720, 26, 0]),
            ("fair", [5, 0, 141, 720, 111, 13]),
            ("fair, pinned", [9, 0, 325, 720, 296, 16]),
        ],
    );
}

/// The triangle that lies nearest to a place, seen from above.
fn nearest_in_plan(shape: &Shape, x: f64, y: f64) -> usize {
    let flat = shape.positions.iter().map(|p| DVec3::new(p.x, p.y, 0.0)).collect();
    Shape { positions: flat, triangles: shape.triangles.clone() }.nearest(DVec3::new(x, y, 0.0))
}

#[test]
fn lines_on_a_ball() {
    let shape = shapes::icosphere(5);
    let around = [[1.0, 0.1, 0.2], [-0.3, 1.0, 0.3], [-1.0, -0.2, 0.0], [0.2, -1.0, 0.4], [0.6, -0.7, 0.1]];
    let picks = faces(&around.map(|p| shape.nearest(DVec3::from_array(p))));
    let mesh = shape.mesh();
    check(
        "ball",
        &mesh,
        &picks[..2],
        &[
            ("heap", [36, 113756, 53, 2571, 117, 0]),
            ("linear", [1, 400, 18, 691, 12, 4]),
            ("cubic", [1, 326, 0, 2571, 0, 0]),
            ("geodesic", [9, 0, 18, 691, 9, 0]),
        ],
    );
    check(
        "ball, a ring",
        &mesh,
        &picks,
        &[("cubic, closed", [1, 1331, 0, 6772, 0, 0]), ("geodesic, closed and pinned", [14, 0, 61, 1758, 34, 0])],
    );
}

#[test]
fn near_picks_cost_little_on_a_large_mesh() {
    let shape = terrain(250);
    let picks = faces(&[nearest_in_plan(&shape, 0.5, 0.5), nearest_in_plan(&shape, 0.53, 0.52)]);
    check(
        "large terrain",
        &shape.mesh(),
        &picks,
        &[("heap", [4, 10329, 6, 97, 7, 0]), ("linear", [1, 0, 2, 23, 3, 3]), ("geodesic", [3, 0, 2, 23, 3, 0])],
    );
}

#[test]
fn a_line_along_the_cow() {
    let Some(shape) = files::shared_mesh("cow.off") else { return };
    let (mesh, picks) = (shape.mesh(), faces(&[100, 2500, 5000]));
    let ends = [picks[0], picks[2]];
    check(
        "cow.off",
        &mesh,
        &ends,
        &[
            ("heap", [17, 39397, 26, 686, 50, 0]),
            ("linear", [1, 1000, 2, 135, 3, 7]),
            ("cubic", [1, 287, 0, 686, 0, 0]),
            ("geodesic", [2, 0, 2, 135, 2, 0]),
        ],
    );
    check(
        "cow.off, three picks",
        &mesh,
        &picks,
        &[("geodesic", [6, 0, 22, 516, 8, 0]), ("geodesic, pinned", [3, 0, 4, 224, 5, 0])],
    );
}

#[test]
fn a_line_along_spot() {
    let Some(shape) = files::shared_mesh("spot.obj") else { return };
    let picks = faces(&[100, 5000]);
    check(
        "spot.obj",
        &shape.mesh(),
        &picks,
        &[
            ("heap", [10, 50770, 10, 984, 26, 0]),
            ("linear", [4, 5200, 12, 327, 11, 36]),
            ("cubic", [1, 370, 0, 984, 0, 0]),
            ("geodesic", [4, 0, 11, 327, 4, 0]),
        ],
    );
}

#[test]
fn lines_on_a_scan() {
    let Some(shape) = files::shared_mesh("igea.ply") else { return };
    let mesh = shape.mesh();
    check(
        "igea.ply",
        &mesh,
        &faces(&[1000, 200_000]),
        &[("linear", [4, 7788, 234, 11313, 53, 21]), ("geodesic", [33, 0, 234, 11313, 39, 0])],
    );
    let ring = faces(&ring_round(&shape, 30));
    check(
        "igea.ply, a ring",
        &mesh,
        &ring,
        &[
            ("cubic, closed", [1, 8287, 0, 24002, 1, 3]),
            ("geodesic, closed and pinned", [23, 0, 343, 6718, 192, 0]),
            ("fair, closed", [7, 0, 467, 6718, 400, 17]),
            ("fair, closed and pinned", [11, 0, 1381, 6718, 1149, 20]),
        ],
    );
}

/// Asks nothing and counts how often it is asked.
#[derive(Default)]
struct Looks(u64);

impl Observer for Looks {
    fn step(&mut self, _: Step) -> ControlFlow<()> {
        self.0 += 1;
        ControlFlow::Continue(())
    }
}

/// A loop over all crossings that forgets to look costs a hundred looks here, and a tenth of a second on a line of a million.
#[test]
fn long_strokes_are_made_with_so_many_looks_at_limits() {
    let shape = terrain(250);
    let mesh = shape.mesh();
    let place = |i: usize| [0.02 + 0.96 * f64::from(i as u32 % 2), 0.02 + 0.96 * i as f64 / 399.0];
    let drawn = StrokePoints::Space((0..400).map(place).map(|[x, y]| DVec3::new(x, y, 0.0)).collect());
    let mut differences = String::new();
    // A few less than there are now.
    for (way, least) in [("none", 1280), ("fair", 4050), ("geodesic", 300), ("linear", 1000), ("cubic", 350)] {
        let options = match way {
            "none" => Options { filter: Filter::None, ..Options::default() },
            _ => Options { max_iterations: Some(1), ..options_of(way) },
        };
        let mut looks = Looks::default();
        let line = stroke(&mesh, &drawn, &options, &mut looks).expect("the stroke lies on the surface");
        assert!(way == "linear" || way == "geodesic" || line.points.len() > 80_000, "{way}: {}", line.points.len());
        if looks.0 < least {
            writeln!(differences, "(\"{way}\", {}), // at least {least}", looks.0).expect("a string takes all");
        }
    }
    assert!(differences.is_empty(), "{differences}");
}

/// Triangles round the middle of a mesh, at even places of a square in the plane of its y and z axes.
fn ring_round(shape: &Shape, count: usize) -> Vec<usize> {
    let low = shape.positions.iter().copied().fold(DVec3::INFINITY, DVec3::min);
    let high = shape.positions.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
    let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
    let corner = |i: usize| [[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]][i % 4];
    let place = |i: usize| {
        let along = 4.0 * i as f64 / count as f64;
        let ([y0, z0], [y1, z1]) = (corner(along as usize), corner(along as usize + 1));
        let share = along.fract();
        middle + half * DVec3::new(0.0, y0 + share * (y1 - y0), z0 + share * (z1 - z0))
    };
    (0..count).map(|i| shape.nearest(place(i))).collect()
}
