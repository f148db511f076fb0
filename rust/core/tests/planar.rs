//! What is known exactly: straight lines and cubics in the plane, closed lines on cylinders and tori, one fold, cones.

mod support;

use std::f64::consts::{PI, TAU};

use glam::DVec3;
use smooth_polylines_core::{Error, Knots, Options, Pick, Polyline, StopReason};
use support::random::Random;
use support::shapes::{self, Shape};
use support::{all_pinned, at, closed, cubic, faces, geodesic, heap, line, try_line};

/// The largest distance of the line's points from the straight line between its ends.
fn distance_from_straight(line: &Polyline) -> f64 {
    let (first, last) = (line.points[0], line.points[line.points.len() - 1]);
    let along = (last - first).normalize();
    line.points.iter().map(|&p| (p - first).cross(along).length()).fold(0.0, f64::max)
}

/// Lines across a plane, corner to corner and at random.
fn straight_lines(shape: &Shape, options: &Options, tolerance: f64, passes_vertices: bool) {
    let mesh = shape.mesh();
    let mut random = Random::new(21);
    let count = shape.triangles.len();
    for i in if passes_vertices { 0 } else { 3 }..12 {
        let picks = match i {
            0 => faces(&[0, count - 1]),
            // Barycentres of a regular grid lie on lines through many of its vertices.
            1 => faces(&[1, count - 2]),
            2 => vec![at(0, [1.0, 0.0, 0.0]), at(count - 1, [0.0, 1.0, 0.0])],
            _ => [0; 2].map(|_| at(random.below(count), random.barycentric())).to_vec(),
        };
        let line = line(&mesh, &picks, options);
        let off = distance_from_straight(&line);
        assert!(off <= tolerance, "{options:?}: {off} off the straight line, picks {picks:?}");
        assert!(matches!(line.report.stop_reason, StopReason::Converged | StopReason::ConvergedAtVertices));
    }
}

#[test]
fn geodesics_in_the_plane_are_straight_to_rounding() {
    for shape in [shapes::grid(13), shapes::irregular_grid(13, 4), shapes::irregular_grid(40, 5)] {
        straight_lines(&shape, &geodesic(), 1e-14, true);
    }
}

#[test]
fn points_within_rounding_of_an_edge_are_left_straight_ahead() {
    let shape = shapes::grid(20);
    let mesh = shape.mesh();
    let mut random = Random::new(33);
    for tiny in [1e-12, 1.2e-15, 1.2e-16, 1e-17, 0.0] {
        for _ in 0..200 {
            let (first, second) = (random.below(shape.triangles.len()), random.below(shape.triangles.len()));
            let mut near_side = |triangle: usize| {
                let (t, off) = (random.between(0.05, 0.95), random.below(3));
                let mut parts = [0.0; 3];
                (parts[off], parts[(off + 1) % 3], parts[(off + 2) % 3]) = (tiny, t, 1.0 - t - tiny);
                at(triangle, parts)
            };
            let picks = [near_side(first), near_side(second)];
            let line = line(&mesh, &picks, &geodesic());
            let off = distance_from_straight(&line);
            assert!(off < 1e-12, "{off} off the straight line, {tiny} from an edge, picks {picks:?}");
            assert!(line.report.iterations < 60, "{} rounds", line.report.iterations);
        }
    }
}

#[test]
fn linear_lines_in_the_plane_are_straight() {
    for shape in [shapes::grid(13), shapes::irregular_grid(13, 4), shapes::irregular_grid(40, 5)] {
        straight_lines(&shape, &Options::default(), 1e-9, true);
    }
    // One vertex at a time, the approach to a line through a mesh vertex has no end: the nearer, the slower.
    for shape in [shapes::grid(8), shapes::irregular_grid(8, 4)] {
        straight_lines(&shape, &heap(1e-8), 1e-6, false);
    }
}

#[test]
fn a_straight_line_goes_past_unpinned_picks() {
    let shape = shapes::irregular_grid(20, 6);
    let picks =
        faces(&[[0.1, 0.1], [0.2, 0.7], [0.8, 0.6], [0.9, 0.9]].map(|[x, y]| shape.nearest(DVec3::new(x, y, 0.0))));
    for options in [geodesic(), Options::default()] {
        assert!(distance_from_straight(&line(&shape.mesh(), &picks, &options)) <= 1e-9);
    }
}

#[test]
fn the_cubic_filter_leaves_uniform_cubics_alone() {
    let curve = |u: f64| DVec3::new(u + 0.01 * u * u, 0.02 * u * u - 0.0015 * u * u * u + 0.3 * u, 0.0);
    let crossings = 12;
    let mut shape = Shape { positions: Vec::new(), triangles: Vec::new() };
    // Vertices alternate above and below the curve; the edge from each to the next has its middle, where step B's line
    // crosses it, at curve(k).
    let mut vertex = curve(0.0) + DVec3::new(-0.5, 1.5, 0.0);
    shape.positions.push(vertex);
    for k in 0..=crossings {
        vertex = 2.0 * curve(k as f64) - vertex;
        shape.positions.push(vertex);
    }
    for k in 0..crossings as u32 {
        shape.triangles.push([k, k + 1, k + 2]);
    }
    let mesh = shape.mesh();
    // The edge of crossing k joins vertices k and k + 1; the ends of the line are the first and the last crossing.
    let last = shape.triangles.len() - 1;
    let picks = [at(0, [0.5, 0.5, 0.0]), at(last, [0.0, 0.5, 0.5])];
    let options = Options { threshold: 1e-9, knots: Knots::Uniform, ..cubic() };
    let line = line(&mesh, &picks, &options);
    assert_eq!(line.points.len(), crossings + 1);
    for (k, p) in line.points.iter().enumerate() {
        let off = p.distance(curve(k as f64));
        assert!(off < 1e-12, "crossing {k} is {off} off the cubic");
    }
    assert_eq!((line.report.moves, line.report.iterations), (0, 1), "nothing had to move");
}

#[test]
fn a_closed_line_in_the_plane_collapses_and_says_so() {
    for shape in [shapes::grid(10), shapes::irregular_grid(10, 8)] {
        let mesh = shape.mesh();
        let ids = [[0.2, 0.2], [0.8, 0.3], [0.5, 0.8]].map(|[x, y]| shape.nearest(DVec3::new(x, y, 0.0)));
        for options in [geodesic(), Options::default()] {
            let result = try_line(&mesh, &faces(&ids), &closed(options.clone()));
            assert!(matches!(result, Err(Error::Collapsed { .. })), "{options:?}: {result:?}");
            // Pinned, it is the triangle of the picks.
            let ring = line(&mesh, &faces(&ids), &closed(all_pinned(options)));
            let corners = ids.map(|t| mesh.dual_graph().barycentre(smooth_polylines_core::ids::TriangleId(t as u32)));
            let expected: f64 = (0..3).map(|i| corners[i].distance(corners[(i + 1) % 3])).sum();
            assert!((ring.length() - expected).abs() < 1e-9);
        }
    }
}

/// Picks once round the z axis, not at one height.
fn ring_picks(shape: &Shape, radius: f64, heights: [f64; 5]) -> Vec<Pick> {
    let ids = heights.iter().enumerate().map(|(i, &z)| {
        let u = TAU * i as f64 / 5.0;
        shape.nearest(DVec3::new(radius * u.cos(), radius * u.sin(), z))
    });
    faces(&ids.collect::<Vec<_>>())
}

#[test]
fn a_closed_geodesic_round_a_cylinder_has_the_length_of_its_girth() {
    let mut random = Random::new(30);
    for (around, rows) in [(12, 9), (30, 14)] {
        let shape = shapes::cylinder(1.0, 2.0, around, rows);
        // The mesh is a prism: the line lies in a plane across its axis.
        let girth = 2.0 * around as f64 * (PI / around as f64).sin();
        for shape in [shape.clone(), shape.relabelled(&mut random).0] {
            let picks = ring_picks(&shape, 1.0, [0.3, -0.2, 0.4, 0.0, -0.5]);
            let ring = line(&shape.mesh(), &picks, &closed(geodesic()));
            assert!((ring.length() - girth).abs() < 1e-12, "{} instead of {girth}", ring.length());
            let ring = line(&shape.mesh(), &picks, &closed(Options::default()));
            assert!((ring.length() - girth).abs() < 1e-8, "linear: {} instead of {girth}", ring.length());
        }
    }
}

#[test]
fn a_closed_geodesic_at_a_waist_is_the_waist() {
    for (around, rows) in [(16, 12), (25, 18)] {
        let shape = shapes::waist(around, rows);
        let girth = around as f64 * (PI / around as f64).sin();
        for heights in [[0.3, -0.2, 0.4, 0.0, -0.5], [0.5, 0.5, 0.5, 0.5, 0.5], [-0.6, -0.4, -0.5, -0.3, -0.4]] {
            let picks = ring_picks(&shape, 0.6, heights);
            let ring = line(&shape.mesh(), &picks, &closed(geodesic()));
            assert!((ring.length() - girth).abs() < 1e-10, "{} instead of {girth}", ring.length());
            assert!(ring.points.iter().all(|p| p.z.abs() < 1e-6));
        }
    }
}

#[test]
fn a_closed_geodesic_in_a_torus_is_its_inner_equator() {
    let (around, across) = (40, 16);
    let shape = shapes::torus(1.0, 0.4, around, across);
    let girth = 2.0 * 0.6 * around as f64 * (PI / around as f64).sin();
    let picks = ring_picks(&shape, 0.7, [0.1, -0.2, 0.3, 0.2, -0.1]);
    let ring = line(&shape.mesh(), &picks, &closed(geodesic()));
    assert!((ring.length() - girth).abs() < 1e-10, "{} instead of {girth}", ring.length());
}

#[test]
fn on_a_fold_the_geodesic_unfolds_and_the_linear_filter_does_not() {
    // A sheet folded by a right angle at x = 0, distances 1 : 3, as in the paper's own limits of the linear filter.
    let positions = [[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 3.0]].map(DVec3::from_array);
    let shape = Shape { positions: positions.to_vec(), triangles: vec![[0, 1, 2], [0, 3, 1]] };
    let picks = [at(0, [0.0, 0.0, 1.0]), at(1, [0.0, 1.0, 0.0])];
    let crossing = |options: &Options| line(&shape.mesh(), &picks, options).points[1].y;
    assert!((crossing(&geodesic()) - 0.25).abs() < 1e-14);
    for options in [Options::default(), heap(1e-12)] {
        assert!((crossing(&options) - 0.1).abs() < 1e-12);
    }
}

#[test]
fn lines_over_a_cone_take_the_open_side_or_the_tip() {
    for valence in [5, 6, 9] {
        let shape = shapes::cone(valence, 0.8);
        let mesh = shape.mesh();
        // Unrolled: the angle between two rim points, the shorter way round, with slant sides to the tip.
        let slant = (1.0f64 + 0.64).sqrt();
        let chord = 2.0 * (PI / valence as f64).sin();
        let corner = 2.0 * (0.5 * chord / slant).asin();
        for apart in 1..valence / 2 {
            let picks = [at(0, [0.0, 1.0, 0.0]), at(apart, [0.0, 1.0, 0.0])];
            let angle = corner * apart as f64;
            assert!(angle < PI, "a cone is open on one side");
            let expected = 2.0 * slant * (0.5 * angle).sin();
            let line = line(&mesh, &picks, &geodesic());
            assert!((line.length() - expected).abs() < 1e-13, "{valence} {apart}: {} {expected}", line.length());
        }
    }
    // Over a saddle, from rim to opposite rim, both sides are closed: straight through the middle.
    let shape = shapes::fan(8, 0.6);
    let picks = [at(0, [0.0, 1.0, 0.0]), at(4, [0.0, 1.0, 0.0])];
    let made = line(&shape.mesh(), &picks, &geodesic());
    assert_eq!(made.report.stop_reason, StopReason::ConvergedAtVertices);
    assert!((made.length() - 2.0 * (1.0f64 + 0.36).sqrt()).abs() < 1e-14);
}
