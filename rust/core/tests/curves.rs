//! What `fair` is made of, each by itself: walks straight ahead, turns at edges and vertices, cones, samples of a line,
//! self-crossings.

mod support;

use std::f64::consts::{PI, TAU};

use glam::DVec3;
use smooth_polylines_core::cone::Cones;
use smooth_polylines_core::ids::{TriangleId, VertexId};
use smooth_polylines_core::pauses::Pauses;
use smooth_polylines_core::samples::{InputSize, Samples};
use smooth_polylines_core::self_crossings::count_self_crossings;
use smooth_polylines_core::spot::Spot;
use smooth_polylines_core::strip::triangles_of;
use smooth_polylines_core::trace::trace;
use smooth_polylines_core::turn::{Heading, turn_at};
use smooth_polylines_core::{NoObserver, Step, SurfaceMesh, SurfacePoint};
use support::random::Random;
use support::shapes::{self, Shape};
use support::{all_pinned, closed, faces, geodesic, line};

/// More edges than any walk here crosses.
const MOST: usize = 1000;

fn middle(shape: &Shape, place: DVec3) -> SurfacePoint {
    SurfacePoint::barycentre(TriangleId(shape.nearest(place) as u32))
}

#[test]
fn a_walk_in_the_plane_ends_where_the_vector_leads() {
    let mut random = Random::new(5);
    for shape in [shapes::grid(15), shapes::irregular_grid(15, 2), shapes::irregular_grid(15, 2).flipped(&mut random)] {
        let mesh = shape.mesh();
        for _ in 0..100 {
            let start = middle(&shape, DVec3::new(random.between(0.3, 0.7), random.between(0.3, 0.7), 0.0));
            let way = DVec3::new(random.between(-0.2, 0.2), random.between(-0.2, 0.2), 0.0);
            let mut word = Vec::new();
            let end = trace(&mesh, &start, way, MOST, &mut word).expect("an end");
            let expected = mesh.position_of(&start) + way;
            // A walk that ends next to an edge is moved inside by a ten-millionth of it.
            assert!(mesh.position_of(&end).distance(expected) < 1e-7);
            assert!(end.barycentric.iter().all(|&b| b > 0.0));
            assert_eq!(triangles_of(&mesh, start.triangle, &word).last(), Some(&end.triangle));
        }
    }
}

#[test]
fn a_walk_round_a_cylinder_comes_back_and_one_over_its_rim_stops() {
    let shape = shapes::cylinder(1.0, 2.0, 24, 10);
    let mesh = shape.mesh();
    let girth = 2.0 * 24.0 * (PI / 24.0).sin();
    let start = middle(&shape, DVec3::new(1.0, 0.0, 0.1));
    let [a, b, c] = mesh.corners(start.triangle).map(|v| mesh.position(v));
    let level =
        [b - a, c - b, a - c].into_iter().find(|side| side.z == 0.0).expect("one side of each triangle is level");
    let mut word = Vec::new();
    let end = trace(&mesh, &start, level.normalize() * girth, MOST, &mut word).expect("an end");
    assert!(mesh.position_of(&end).distance(mesh.position_of(&start)) < 1e-6);
    assert_eq!(word.len(), 48, "two triangles a side of the prism");
    let mut word = Vec::new();
    let end = trace(&mesh, &start, DVec3::Z * 10.0, MOST, &mut word).expect("an end");
    assert!((mesh.position_of(&end).z - 1.0).abs() < 1e-6, "it stops at the rim");
    assert!(end.barycentric.iter().all(|&b| b > 0.0), "and stays inside");
}

#[test]
fn a_walk_that_winds_on_and_on_is_given_up() {
    let shape = shapes::cylinder(1.0, 2.0, 24, 10);
    let mesh = shape.mesh();
    let start = middle(&shape, DVec3::new(1.0, 0.0, 0.1));
    let [a, b, c] = mesh.corners(start.triangle).map(|v| mesh.position(v));
    let level = [b - a, c - b, a - c].into_iter().find(|side| side.z == 0.0).expect("a level side");
    let three_times = 3.0 * 2.0 * 24.0 * (PI / 24.0).sin() * level.normalize();
    assert!(trace(&mesh, &start, three_times, 144, &mut Vec::new()).is_some(), "48 edges a time round");
    assert!(trace(&mesh, &start, three_times, 143, &mut Vec::new()).is_none());
}

/// Directions from a point, one a triangle of the shape that holds it, counter-clockwise from the x axis.
fn heading(mesh: &SurfaceMesh, at: DVec3, angle: f64) -> Heading {
    let direction = DVec3::new(angle.cos(), angle.sin(), 0.0);
    let probe = at + 1e-4 * direction;
    let holds = |t: &usize| {
        let [a, b, c] = mesh.corners(TriangleId(*t as u32)).map(|v| mesh.position(v).truncate());
        let side = |p: glam::DVec2, q: glam::DVec2| (q - p).perp_dot(probe.truncate() - p);
        let sides = [side(a, b), side(b, c), side(c, a)];
        sides.iter().all(|&s| s > 0.0) || sides.iter().all(|&s| s < 0.0)
    };
    let triangle = (0..mesh.triangles().len()).find(holds).expect("the probe lies in a triangle");
    Heading { triangle: TriangleId(triangle as u32), direction }
}

#[test]
fn turns_in_the_plane_are_the_angles_between_the_ways() {
    let mut random = Random::new(9);
    for shape in [shapes::irregular_grid(6, 3), shapes::irregular_grid(6, 3).flipped(&mut random)] {
        let mesh = shape.mesh();
        let flips = |t: TriangleId| mesh.normal(t).z < 0.0;
        let inner = (0..shape.positions.len()).filter(|&v| {
            let p = shape.positions[v];
            p.x > 0.0 && p.x < 1.0 && p.y > 0.0 && p.y < 1.0
        });
        let mut tried = 0;
        for v in inner {
            let at = shape.positions[v];
            for _ in 0..6 {
                let (back, out) = (random.between(0.0, TAU), random.between(0.0, TAU));
                let (before, after) = (heading(&mesh, at, back), heading(&mesh, at, out));
                let came = Heading { direction: -before.direction, ..before };
                let turn = turn_at(&mesh, Spot::Vertex(VertexId(v as u32)), came, after);
                let expected = (out - back - PI + 2.0 * TAU + PI).rem_euclid(TAU) - PI;
                // A way straight back may be a turn to either side.
                if PI - expected.abs() < 1e-3 {
                    continue;
                }
                let signed = if flips(before.triangle) { -expected } else { expected };
                assert!((turn.angle - signed).abs() < 1e-9, "{} instead of {signed}", turn.angle);
                assert_eq!(turn.flips, flips(before.triangle) != flips(after.triangle));
                tried += 1;
            }
        }
        assert!(tried > 100, "only {tried} turns");
    }
}

#[test]
fn a_cone_has_its_defect_and_turns_what_passes_it() {
    for (valence, height) in [(3, 1.0), (6, 0.5), (9, 0.2)] {
        let mesh = shapes::cone(valence, height).mesh();
        let spoke = TriangleId(0).halfedges().into_iter().find(|&h| mesh.ends(h)[0] == VertexId(0)).expect("a spoke");
        let cone = Cones::default().get(&mesh, spoke);
        let slant = (1.0 + height * height).sqrt();
        let corner = 2.0 * ((PI / valence as f64).sin() / slant).asin();
        assert!((cone.defect - (TAU - valence as f64 * corner)).abs() < 1e-12);
        // Both sides go over into each other at the tip: half the defect from either.
        assert!((cone.turn(1e-12) - 0.5 * cone.defect).abs() < 1e-9);
        assert!((cone.turn(-1e-12) + 0.5 * cone.defect).abs() < 1e-9);
        assert_eq!(cone.turn(1.0001 * cone.radius), 0.0);
        assert!((cone.turn(0.5 * cone.radius) - 0.25 * cone.defect).abs() < 1e-12);
    }
    // No line passes over a boundary vertex.
    let mesh = shapes::grid(3).mesh();
    let rim = TriangleId(0).halfedges().into_iter().find(|&h| mesh.ends(h)[0] == VertexId(0)).expect("a corner");
    assert_eq!(Cones::default().get(&mesh, rim).defect, 0.0);
}

#[test]
fn samples_lie_evenly_on_the_line_and_survive_thinning() {
    let shape = shapes::hills(24, 3);
    let mesh = shape.mesh();
    let picks = faces(&[3, shape.triangles.len() / 2, shape.triangles.len() - 5]);
    for options in [all_pinned(geodesic()), closed(all_pinned(geodesic()))] {
        let route = line(&mesh, &picks, &options).route;
        let mut observer = NoObserver;
        let mut pauses = Pauses::new(&mut observer, Step::Relax);
        let length = InputSize::of(&mesh, &route, &mut pauses).expect("nobody stops it").length;
        let spacing = length / 100.0;
        for is_pinned in
            [vec![true; route.pins.len()], [vec![true], vec![false; route.pins.len() - 2], vec![true]].concat()]
        {
            let samples = Samples::of_route(&mesh, &route, &is_pinned, spacing, &mut pauses).expect("nobody stops it");
            assert!((samples.steps.iter().sum::<f64>() * spacing - length).abs() < 1e-9 * length);
            assert!(samples.steps.iter().all(|&step| step <= 1.0 + 1e-12));
            let count = samples.points.len();
            for (i, leg) in samples.legs.iter().enumerate() {
                let next = &samples.points[(i + 1) % count];
                let (a, b) = (mesh.position_of(&samples.points[i]), mesh.position_of(next));
                // Straight through, or round a bend of the line: never longer than the piece.
                assert!(a.distance(b) <= samples.steps[i] * spacing * (1.0 + 1e-6));
                assert_eq!(leg.last_triangle(&mesh), next.triangle, "the strip ends where the next sample lies");
            }
            for stride in [2, 4, 16] {
                let kept = samples.kept_at(stride, &mut pauses).expect("nobody stops it");
                let thin = samples.thinned(&mesh, &kept, &mut pauses).expect("nobody stops it");
                assert!((thin.steps.iter().sum::<f64>() - samples.steps.iter().sum::<f64>()).abs() < 1e-9);
                assert_eq!(thin.points.len(), kept.len());
                assert!(samples.is_pinned.iter().enumerate().all(|(i, &p)| !p || kept.binary_search(&i).is_ok()));
                for (i, leg) in thin.legs.iter().enumerate() {
                    assert_eq!(leg.last_triangle(&mesh), thin.points[(i + 1) % thin.points.len()].triangle);
                }
            }
        }
    }
}

#[test]
fn a_figure_eight_crosses_itself_once_and_a_ring_does_not() {
    let shape = shapes::irregular_grid(30, 6);
    let mesh = shape.mesh();
    let ring = |places: [[f64; 2]; 4]| {
        let picks = faces(&places.map(|[x, y]| shape.nearest(DVec3::new(x, y, 0.0))));
        let route = line(&mesh, &picks, &closed(all_pinned(geodesic()))).route;
        let mut observer = NoObserver;
        count_self_crossings(&mesh, &route, &mut Pauses::new(&mut observer, Step::Relax)).expect("nobody stops it")
    };
    assert_eq!(ring([[0.2, 0.3], [0.8, 0.7], [0.8, 0.3], [0.2, 0.7]]), 1);
    assert_eq!(ring([[0.2, 0.3], [0.8, 0.3], [0.8, 0.7], [0.2, 0.7]]), 0);
}
