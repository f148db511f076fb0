//! The search for a strip to be straightened: what it promises, what it finds on every surface, how much it visits.

mod support;

use std::collections::HashSet;

use glam::DVec3;
use smooth_polylines_core::ids::TriangleId;
use smooth_polylines_core::search::FoundStrip;
use smooth_polylines_core::strip::triangles_of;
use smooth_polylines_core::window_search::find_taut_strip;
use smooth_polylines_core::{NoObserver, Pick, SurfaceMesh, SurfacePoint};
use support::random::Random;
use support::shapes::{self, Shape};
use support::{files, geodesic, line};

fn point(triangle: usize, barycentric: [f64; 3]) -> SurfacePoint {
    SurfacePoint { triangle: TriangleId(triangle as u32), barycentric }
}

fn find(mesh: &SurfaceMesh, from: &SurfacePoint, to: &SurfacePoint) -> Option<FoundStrip> {
    find_taut_strip(mesh, from, to, &mut NoObserver).expect("nobody interrupts")
}

fn as_pick(point: &SurfacePoint) -> Pick {
    Pick::Point { triangle: i128::from(point.triangle.0), barycentric: point.barycentric }
}

/// A point inside a triangle, on an edge, or on a vertex.
fn random_point(random: &mut Random, shape: &Shape) -> SurfacePoint {
    let kinds = [[1.0 / 3.0; 3], [0.2, 0.5, 0.3], [0.0, 0.25, 0.75], [0.5, 0.5, 0.0], [0.0, 1.0, 0.0]];
    point(random.below(shape.triangles.len()), kinds[random.below(kinds.len())])
}

/// Searches between random points: strips fit, repeat nothing, and promise a length that the finished line keeps, which is
/// at most the given share shorter on average.
fn check(name: &str, shape: &Shape, pairs: usize, most_excess: f64) {
    let mesh = shape.mesh();
    let mut random = Random::new(9);
    let (mut excess, mut found_pairs) = (0.0, 0);
    for _ in 0..pairs {
        let [from, to] = [0; 2].map(|_| random_point(&mut random, shape));
        let Some(found) = find(&mesh, &from, &to) else {
            assert!(mesh.report().parts > 1, "{name}: {from:?} to {to:?} is connected");
            continue;
        };
        assert_eq!(find(&mesh, &from, &to).as_ref(), Some(&found), "{name}: a used work space changes nothing");
        let strip = triangles_of(&mesh, found.first, &found.word);
        let different: HashSet<TriangleId> = strip.iter().copied().collect();
        assert_eq!(different.len(), strip.len(), "{name}: the strip repeats a triangle");
        assert!(found.pops as usize <= 3 * shape.triangles.len(), "{name}");
        let line = line(&mesh, &[as_pick(&from), as_pick(&to)], &geodesic());
        let slack = 1e-9 * shape.size();
        assert!(line.length() <= found.cost + slack, "{name}: {} was promised, {}", found.cost, line.length());
        assert!(found.cost + slack >= mesh.position_of(&from).distance(mesh.position_of(&to)), "{name}");
        if line.length() > slack {
            excess += found.cost / line.length() - 1.0;
            found_pairs += 1;
        }
    }
    assert!(found_pairs > 0, "{name}: no pair was connected");
    let mean = excess / f64::from(found_pairs);
    assert!(mean <= most_excess, "{name}: promised lengths are {mean} longer on average");
}

#[test]
fn strips_promise_a_length_that_is_kept_and_is_near_the_line() {
    let mut random = Random::new(6);
    // Measured: up to 0.25 % in the plane, 1 % on the others.
    check("plane", &shapes::grid(12), 60, 0.005);
    check("irregular plane", &shapes::irregular_grid(20, 1), 60, 0.005);
    check("hills", &shapes::hills(20, 1).relabelled(&mut random).0.flipped(&mut random), 60, 0.015);
    check("ball", &shapes::icosphere(3), 60, 0.015);
    check("torus", &shapes::torus(1.0, 0.4, 30, 14), 60, 0.015);
    check("Moebius strip", &shapes::moebius(30, 5).flipped(&mut random), 60, 0.015);
    check("book with a wall", &shapes::book(3, 5), 60, 0.015);
    check("plane with a wall", &shapes::finned_grid(12, 0.5), 60, 0.015);
}

#[test]
fn strips_on_real_meshes_keep_their_promise_too() {
    for name in ["cow.off", "tray_cad.off", "truck_nm.obj", "openscad_crash.obj", "thingi_79741.off"] {
        if let Some(shape) = files::shared_mesh(name) {
            // Measured: up to 2.9 %.
            check(name, &shape, 40, 0.05);
        }
    }
}

#[test]
fn one_triangle_or_neighbours_need_no_search() {
    let mesh = shapes::grid(4).mesh();
    let inside = point(5, [0.2, 0.3, 0.5]);
    let found = find(&mesh, &inside, &point(5, [0.6, 0.3, 0.1])).expect("one triangle");
    assert_eq!((found.first, found.word.len(), found.pops), (TriangleId(5), 0, 0));
    // A vertex belongs to all triangles round it.
    let corner = mesh.triangles()[5][1];
    let other = mesh.triangles().iter().rposition(|t| t.contains(&corner)).expect("it is in triangle 5");
    let found = find(&mesh, &point(5, [0.0, 1.0, 0.0]), &point(other, [1.0 / 3.0; 3])).expect("one triangle");
    assert_eq!((found.first, found.word.len()), (TriangleId(other as u32), 0));
}

#[test]
fn parts_that_are_not_connected_are_told_from_parts_that_are() {
    let one = shapes::grid(3);
    let count = one.positions.len() as u32;
    let away = one.positions.iter().map(|p| *p + DVec3::new(5.0, 0.0, 0.0));
    let positions = one.positions.iter().copied().chain(away).collect();
    let triangles = one.triangles.iter().copied().chain(one.triangles.iter().map(|t| t.map(|v| v + count))).collect();
    let (mesh, last) = (Shape { positions, triangles }.mesh(), 2 * one.triangles.len() - 1);
    let middle = |t| point(t, [1.0 / 3.0; 3]);
    assert_eq!(find(&mesh, &middle(0), &middle(last)), None);
    assert!(find(&mesh, &middle(0), &middle(one.triangles.len() - 1)).is_some());
}

#[test]
fn a_line_goes_round_the_foot_of_a_hill_and_not_over_it() {
    // A high pyramid in the middle of a plane: the dual path's staircase goes over its foot as gladly as round it.
    let mut shape = shapes::irregular_grid(30, 4);
    for p in &mut shape.positions {
        let rise = 1.0 - 4.0 * (p.x - 0.5).abs().max((p.y - 0.5).abs());
        p.z = 4.0 * rise.max(0.0);
    }
    let mesh = shape.mesh();
    let [from, to] =
        [[0.02, 0.45], [0.98, 0.47]].map(|[x, y]| point(shape.nearest(DVec3::new(x, y, 0.0)), [1.0 / 3.0; 3]));
    let found = find(&mesh, &from, &to).expect("a plane is connected");
    let highest = triangles_of(&mesh, found.first, &found.word)
        .iter()
        .flat_map(|t| mesh.corners(*t))
        .map(|v| mesh.position(v).z)
        .fold(0.0, f64::max);
    assert!(highest < 1.0, "the strip climbs to {highest} of 4");
}

#[test]
fn near_points_visit_few_triangles_of_a_large_mesh() {
    let shape = shapes::irregular_grid(200, 6);
    let mesh = shape.mesh();
    let mut random = Random::new(3);
    for _ in 0..50 {
        let from = random.below(shape.triangles.len());
        let near = shape.positions[shape.triangles[from][0] as usize] + DVec3::new(0.02, -0.015, 0.0);
        let to = shape.nearest(near);
        let found = find(&mesh, &point(from, [1.0 / 3.0; 3]), &point(to, [1.0 / 3.0; 3])).expect("connected");
        assert!(found.pops <= 30, "{} of {} triangles", found.pops, shape.triangles.len());
    }
}
