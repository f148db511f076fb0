//! Strokes: what is known exactly in the plane, breaks, rings, noise, and closest points against asking every triangle.

mod support;

use std::f64::consts::TAU;
use std::ops::ControlFlow;

use glam::DVec3;
use smooth_polylines_core::check::check_polyline;
use smooth_polylines_core::stroke::{StrokePoints, stroke};
use smooth_polylines_core::{Error, Filter, NoObserver, Observer, Options, Pinned, Polyline, Step, SurfaceMesh};
use support::random::Random;
use support::shapes::{self, Shape};
use support::{closed, faces, files, filters, geodesic};

/// The stroke as drawn, without smoothing.
fn raw() -> Options {
    Options { filter: Filter::None, ..Options::default() }
}

fn space(points: &[DVec3]) -> StrokePoints {
    StrokePoints::Space(points.to_vec())
}

/// A stroke that must give a line, which keeps every promise.
fn drawn(mesh: &SurfaceMesh, points: &[DVec3], options: &Options) -> Polyline {
    let line =
        stroke(mesh, &space(points), options, &mut NoObserver).unwrap_or_else(|error| panic!("{options:?}: {error}"));
    check_polyline(mesh, &line).unwrap_or_else(|error| panic!("{options:?}: {error}"));
    line
}

/// `count` points from `from` to `to`, both included.
fn straight(from: DVec3, to: DVec3, count: usize) -> Vec<DVec3> {
    (0..count).map(|i| from.lerp(to, i as f64 / (count - 1) as f64)).collect()
}

/// Places all over a shape and round it.
fn places(shape: &Shape, random: &mut Random, count: usize) -> Vec<DVec3> {
    let spread = [1e-9, 0.01, 0.3].map(|share| share * shape.size());
    let mut place = |_| {
        let by = spread[random.below(3)];
        shape.positions[random.below(shape.positions.len())]
            + DVec3::from_array([0; 3].map(|_| random.between(-by, by)))
    };
    (0..count).map(&mut place).collect()
}

#[test]
fn in_the_plane_a_straight_stroke_is_its_segment_whatever_its_points_and_its_height() {
    let mesh = shapes::irregular_grid(20, 5).mesh();
    let (from, to) = (DVec3::new(0.0513, 0.1234, 0.0), DVec3::new(0.93, 0.79, 0.0));
    for count in [2, 3, 10, 2000] {
        let lifted: Vec<_> = straight(from, to, count).iter().map(|&p| p + 0.3 * DVec3::Z).collect();
        let line = drawn(&mesh, &lifted, &raw());
        assert!((line.length() - from.distance(to)).abs() < 1e-12, "{count} points: {}", line.length());
        assert_eq!((line.report.stroke_breaks, line.report.pops), (0, 0), "{count} points");
        assert!((line.report.stroke_distance - 0.3).abs() < 1e-15);
    }
}

#[test]
fn what_is_drawn_there_and_back_cancels() {
    let mesh = shapes::irregular_grid(20, 6).mesh();
    let at = |x: f64, y: f64| DVec3::new(x, y, 0.0);
    let there = straight(at(0.1, 0.2), at(0.7, 0.25), 80);
    let mut points = there.clone();
    points.extend(straight(at(0.7, 0.25), at(0.72, 0.9), 50));
    points.extend(straight(at(0.72, 0.9), at(0.7, 0.25), 50));
    points.extend(straight(at(0.7, 0.25), at(0.95, 0.3), 40));
    let mut direct = there;
    direct.extend(straight(at(0.7, 0.25), at(0.95, 0.3), 40));
    let (line, expected) = (drawn(&mesh, &points, &raw()), drawn(&mesh, &direct, &raw()));
    assert_eq!(line.strip, expected.strip);
    assert!((line.length() - expected.length()).abs() < 1e-12);
}

/// A grid with a square hole.
fn holed(cells: usize) -> Shape {
    let mut shape = shapes::grid(cells);
    let is_in_hole = |t: &[u32; 3]| {
        t.iter().all(|&v| {
            let p = shape.positions[v as usize];
            (0.39..0.61).contains(&p.x) && (0.39..0.61).contains(&p.y)
        })
    };
    shape.triangles = shape.triangles.iter().copied().filter(|t| !is_in_hole(t)).collect();
    shape
}

#[test]
fn a_gap_over_a_hole_is_a_break_that_step_b_joins() {
    let mesh = holed(20).mesh();
    let at = |x: f64| DVec3::new(x, 0.511, 0.0);
    let mut points = straight(at(0.1), at(0.38), 40);
    points.extend(straight(at(0.62), at(0.9), 40));
    for (name, options) in filters() {
        let line = drawn(&mesh, &points, &options);
        assert_eq!(line.report.stroke_breaks, 1, "{name}");
        assert!(line.report.pops > 0, "{name}");
        assert!(line.length() > 0.825, "{name} goes round the hole: {}", line.length());
    }
    // A second gap, in the middle of the surface, is walked straight.
    points.retain(|p| p.x < 0.2 || p.x > 0.3);
    assert_eq!(drawn(&mesh, &points, &raw()).report.stroke_breaks, 1);
}

#[test]
fn a_ring_drawn_round_a_tube_winds_round_it_once() {
    let mesh = shapes::waist(48, 30).mesh();
    let mut random = Random::new(8);
    for count in [7, 100, 1500] {
        let ring: Vec<_> = (0..count)
            .map(|i| {
                let u = TAU * (i as f64 + 0.3) / count as f64;
                0.55 * DVec3::new(u.cos(), u.sin(), 0.3 * (3.0 * u).sin()) + 0.01 * random.between(-1.0, 1.0) * DVec3::Z
            })
            .collect();
        for (name, options) in filters() {
            let line = drawn(&mesh, &ring, &closed(options));
            let winding: f64 = (0..line.points.len())
                .map(|i| {
                    let (a, b) = (line.points[i], line.points[(i + 1) % line.points.len()]);
                    (a.x * b.y - a.y * b.x).atan2(a.x * b.x + a.y * b.y)
                })
                .sum();
            assert!((winding - TAU).abs() < 1e-9, "{name}, {count} points: {winding}");
        }
    }
}

#[test]
fn noisy_strokes_on_every_surface_by_every_filter() {
    let named = [
        ("hills", shapes::hills(20, 1)),
        ("ball", shapes::icosphere(3)),
        ("torus", shapes::torus(1.0, 0.4, 30, 14)),
        ("Moebius strip", shapes::moebius(36, 6)),
        ("book", shapes::book(3, 6)),
        ("fins", shapes::finned_grid(10, 0.5)),
    ];
    let mut random = Random::new(21);
    let mut made = 0;
    for (name, shape) in named {
        let mesh = shape.mesh();
        for round in 0..6 {
            let corners = places(&shape, &mut random, 4);
            let noise = [0.0, 0.003, 0.03][round % 3] * shape.size();
            let mut points: Vec<_> = corners.windows(2).flat_map(|pair| straight(pair[0], pair[1], 40)).collect();
            points.iter_mut().for_each(|p| *p += DVec3::from_array([0; 3].map(|_| random.between(-noise, noise))));
            for (way, options) in filters() {
                for options in [options.clone(), closed(options)] {
                    match stroke(&mesh, &space(&points), &options, &mut NoObserver) {
                        Ok(line) => {
                            check_polyline(&mesh, &line)
                                .unwrap_or_else(|error| panic!("{name}, {way}, {round}: {error}"));
                            made += 1;
                        }
                        Err(Error::Collapsed { .. } | Error::NoPath { .. }) => {}
                        Err(error) => panic!("{name}, {way}, {round}: {error}"),
                    }
                }
            }
        }
    }
    // Closed ones may shrink to a point, and the walls of two surfaces part them.
    assert!(made > 190, "{made} of 360 lines");
}

#[test]
fn a_stroke_of_triangles_with_gaps_is_one_of_their_barycentres() {
    let shape = shapes::hills(20, 3);
    let mesh = shape.mesh();
    let ids: Vec<usize> =
        straight(DVec3::new(0.1, 0.1, 0.0), DVec3::new(0.8, 0.9, 0.0), 12).iter().map(|&p| shape.nearest(p)).collect();
    let centres: Vec<_> =
        faces(&ids).iter().map(|pick| mesh.position_of(&mesh.resolve_pick(0, pick).expect("a face"))).collect();
    let by_faces = stroke(&mesh, &StrokePoints::Surface(faces(&ids)), &geodesic(), &mut NoObserver).expect("a line");
    let by_places = drawn(&mesh, &centres, &geodesic());
    assert!((by_faces.length() - by_places.length()).abs() < 1e-9);
    assert_eq!(by_faces.report.stroke_distance, 0.0);
}

#[test]
fn pinned_points_of_a_stroke_are_on_the_line() {
    let mesh = shapes::icosphere(4).mesh();
    let points: Vec<_> =
        (0..50).map(|i| 1.1 * DVec3::new((0.05 * f64::from(i)).cos(), (0.05 * f64::from(i)).sin(), 0.2)).collect();
    for (name, options) in filters() {
        let mut flags = vec![false; 50];
        [0, 20, 49].into_iter().for_each(|i| flags[i] = true);
        let line = drawn(&mesh, &points, &Options { pinned: Pinned::Each(flags), ..options });
        for i in [0, 20, 49] {
            let on = mesh.closest_points(&points[i..=i], "points", &mut NoObserver).expect("finite")[0];
            assert!(line.points.contains(&mesh.position_of(&on.point)), "{name}, point {i}");
        }
    }
}

#[test]
fn refusals_name_the_points() {
    let one = shapes::grid(3);
    let count = one.positions.len() as u32;
    let mut shape = one.clone();
    shape.positions.extend(one.positions.iter().map(|&p| p + 5.0 * DVec3::X));
    shape.triangles.extend(one.triangles.iter().map(|t| t.map(|v| v + count)));
    let mesh = shape.mesh();
    let told = |points: &[DVec3], options: &Options| {
        stroke(&mesh, &space(points), options, &mut NoObserver).expect_err("refused").to_string()
    };
    let apart = [DVec3::new(0.5, 0.4, 0.0), DVec3::new(0.6, 0.4, 0.0), DVec3::new(5.5, 0.4, 0.0)];
    assert!(
        told(&apart, &raw()).starts_with("points 1 and 2 lie on parts of the mesh that are not connected (2 parts)")
    );
    assert!(told(&[], &raw()).starts_with("points: found none"));
    assert!(
        told(&apart[..2], &closed(raw()))
            .starts_with("points: a closed line needs at least 3 different points, found 2")
    );
    assert!(told(&[DVec3::NAN], &raw()).starts_with("points: row 0 is [NaN"));
    let wrong = StrokePoints::Surface(faces(&[0, 99]));
    let error = stroke(&mesh, &wrong, &raw(), &mut NoObserver).expect_err("refused").to_string();
    assert!(error.starts_with("points: point 1 is triangle 99, but the mesh has 36"), "{error}");
}

#[test]
fn an_observer_stops_projection_and_joining() {
    struct After(u32);
    impl Observer for After {
        fn step(&mut self, _: Step) -> ControlFlow<()> {
            self.0 = self.0.saturating_sub(1);
            if self.0 == 0 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        }
    }
    let mesh = shapes::grid(40).mesh();
    let points = straight(DVec3::new(0.05, 0.1, 0.0), DVec3::new(0.9, 0.8, 0.0), 3000);
    // One call before the projection, six within, five while joining.
    for calls in 1..=12 {
        assert_eq!(stroke(&mesh, &space(&points), &raw(), &mut After(calls)), Err(Error::Interrupted), "{calls}");
    }
    assert!(stroke(&mesh, &space(&points), &raw(), &mut After(20)).is_ok());
}

#[test]
fn closest_points_are_those_of_asking_every_triangle() {
    let mut shapes = vec![
        ("hills", shapes::hills(12, 1)),
        ("fan", shapes::cone(40, 3.0)),
        ("book", shapes::book(4, 4)),
        ("one", Shape { positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y], triangles: vec![[0, 1, 2]] }),
        // Slivers, a needle without area, and one triangle far larger than the others.
        (
            "bad",
            Shape {
                positions: [
                    [0.0, 0.0, 0.0],
                    [1.0, 0.0, 0.0],
                    [0.5, 1e-9, 0.0],
                    [2.0, 0.0, 0.0],
                    [1e3, 1e3, 7.0],
                    [0.5, 0.5, 1e-300],
                ]
                .map(DVec3::from_array)
                .to_vec(),
                triangles: vec![[0, 1, 2], [0, 1, 3], [2, 3, 4], [1, 4, 5]],
            },
        ),
    ];
    shapes.extend(files::shared_mesh("cow.off").map(|cow| ("cow", cow)));
    let mut random = Random::new(3);
    for (name, shape) in shapes {
        let mesh = shape.mesh();
        let points = places(&shape, &mut random, 200);
        let found = mesh.closest_points(&points, "points", &mut NoObserver).expect("finite");
        let mut backwards = points.clone();
        backwards.reverse();
        let mut again = mesh.closest_points(&backwards, "points", &mut NoObserver).expect("finite");
        again.reverse();
        assert_eq!(found, again, "{name}: the order of the points plays no part");
        for (point, closest) in points.iter().zip(&found) {
            let slack = 1e-14 * (point.length() + shape.size());
            let least = shape
                .triangles
                .iter()
                .map(|t| distance(*point, t.map(|v| shape.positions[v as usize])))
                .fold(f64::INFINITY, f64::min);
            assert!(
                (closest.distance - least).abs() <= 1e-12 * least + slack,
                "{name} {point}: {} {least}",
                closest.distance
            );
            let barycentric = closest.point.barycentric;
            assert!(barycentric.iter().all(|&b| b >= 0.0) && (barycentric.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        }
    }
}

/// Distance to a triangle by alternating projections of barycentric weights: slow, and of another make than the library's.
fn distance(p: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let on_segment = |a: DVec3, b: DVec3| {
        let along = b - a;
        let t = if along.length_squared() > 0.0 {
            ((p - a).dot(along) / along.length_squared()).clamp(0.0, 1.0)
        } else {
            0.0
        };
        p.distance(a + t * along)
    };
    let edges = on_segment(a, b).min(on_segment(b, c)).min(on_segment(c, a));
    // The plane counts where the foot is on the inner side of all three edges.
    let normal = (b - a).cross(c - a);
    let is_inner = |a: DVec3, b: DVec3| (b - a).cross(p - a).dot(normal) > 0.0;
    let is_over = normal.length_squared() > 0.0 && is_inner(a, b) && is_inner(b, c) && is_inner(c, a);
    if is_over { ((p - a).dot(normal) / normal.length()).abs() } else { edges }
}
