//! The checker finds every broken promise: a good line is spoiled in one way at a time.

mod support;

use glam::DVec3;
use smooth_polylines_core::check::{CheckError, check_polyline, count_new_repeats};
use smooth_polylines_core::ids::{HalfedgeId, TriangleId, VertexId};
use smooth_polylines_core::leg::Leg;
use smooth_polylines_core::route::Route;
use smooth_polylines_core::{Filter, Options, Polyline, Report, SurfaceMesh, SurfacePoint};
use support::shapes::{book, grid, irregular_grid};
use support::{all_pinned, closed, faces, geodesic, line};

/// An open line with a pin in its middle, and its mesh.
fn good_line() -> (SurfaceMesh, Polyline) {
    let shape = irregular_grid(8, 3);
    let mesh = shape.mesh();
    let picks = [[0.1, 0.1], [0.6, 0.8], [0.9, 0.2]].map(|[x, y]| shape.nearest(DVec3::new(x, y, 0.0)));
    let line = line(&mesh, &faces(&picks), &all_pinned(geodesic()));
    assert!(line.points.len() > 12 && check_polyline(&mesh, &line).is_ok());
    (mesh, line)
}

/// A closed line without pins: step B's, so that nothing collapses.
fn good_ring() -> (SurfaceMesh, Polyline) {
    let shape = irregular_grid(8, 3);
    let mesh = shape.mesh();
    let picks = [[0.2, 0.2], [0.8, 0.2], [0.5, 0.8]].map(|[x, y]| shape.nearest(DVec3::new(x, y, 0.0)));
    let options = Options { filter: Filter::None, ..closed(geodesic()) };
    let line = line(&mesh, &faces(&picks), &options);
    (mesh, line)
}

/// The next number, for positive ones.
fn next_up(x: f64) -> f64 {
    f64::from_bits(x.to_bits() + 1)
}

/// What the checker says of a good line once `spoil` was at it.
fn fault_of<T>(spoil: impl FnOnce(&SurfaceMesh, &mut Polyline) -> T) -> CheckError {
    let (mesh, mut line) = good_line();
    spoil(&mesh, &mut line);
    check_polyline(&mesh, &line).expect_err("the line was spoiled")
}

/// The same for a closed line.
fn ring_fault_of<T>(spoil: impl FnOnce(&SurfaceMesh, &mut Polyline) -> T) -> CheckError {
    let (mesh, mut line) = good_ring();
    spoil(&mesh, &mut line);
    check_polyline(&mesh, &line).expect_err("the line was spoiled")
}

/// Puts a point elsewhere, coordinates and all.
fn place(mesh: &SurfaceMesh, line: &mut Polyline, point: usize, at: SurfacePoint) {
    line.surface_points[point] = at;
    line.points[point] = mesh.position_of(&at);
}

/// A triangle of the mesh that the strip does not hold.
fn elsewhere(mesh: &SurfaceMesh, line: &Polyline) -> TriangleId {
    let ids = (0..mesh.triangles().len() as u32).map(TriangleId);
    ids.rev().find(|t| !line.strip.contains(t)).expect("the strip is no flood")
}

#[test]
fn arrays_of_wrong_sizes_are_found() {
    let size = |array: &str, fault: CheckError| match fault {
        CheckError::Size { array: found, .. } => assert_eq!(found, array),
        other => panic!("{other}"),
    };
    size("segment_triangles", fault_of(|_, line| line.segment_triangles.pop()));
    size("segment_triangles", ring_fault_of(|_, line| line.segment_triangles.pop()));
    size("surface_points", fault_of(|_, line| line.surface_points.pop()));
    size("strip", fault_of(|_, line| line.strip.clear()));
    size("points", fault_of(|_, line| line.points.clear()));
    size("points", ring_fault_of(|_, line| line.points.truncate(1)));
    size("parameters of a leg", fault_of(|_, line| line.route.legs[1].parameters.pop()));
}

#[test]
fn ids_out_of_range_are_found_in_every_array() {
    let out = TriangleId(1_000_000);
    let array = |fault: CheckError| match fault {
        CheckError::TriangleOutOfRange { array, triangle: 1_000_000, triangles: 128, .. } => array,
        other => panic!("{other}"),
    };
    assert_eq!(array(fault_of(|_, line| line.segment_triangles[2] = out)), "segment_triangles");
    assert_eq!(array(fault_of(|_, line| line.surface_points[2].triangle = out)), "surface_points");
    assert_eq!(array(fault_of(|_, line| line.strip[2] = out)), "strip");
    assert_eq!(array(fault_of(|_, line| line.route.pins[1].triangle = out)), "route.pins");
}

#[test]
fn barycentric_parts_that_are_no_point_are_found() {
    for parts in [[-1e-12, 0.5, 0.5 + 1e-12], [0.5, 0.5, 1e-14], [f64::NAN, 0.5, 0.5], [f64::INFINITY, 0.0, 0.0]] {
        let fault = fault_of(|_, line| line.surface_points[3].barycentric = parts);
        assert!(matches!(fault, CheckError::NotBarycentric { point: 3, .. }), "{fault}");
    }
}

#[test]
fn points_that_are_off_by_one_bit_are_found() {
    let fault = fault_of(|_, line| line.points[3].y = next_up(line.points[3].y));
    assert!(matches!(fault, CheckError::PointOff { point: 3, .. }), "{fault}");
    let fault = fault_of(|_, line| line.points[4].z = f64::NAN);
    assert!(matches!(fault, CheckError::PointOff { point: 4, .. }), "{fault}");
    let fault = fault_of(|_, line| line.points[4].z = -0.0);
    assert!(matches!(fault, CheckError::PointOff { point: 4, .. }), "the sign of zero counts: {fault}");
}

#[test]
fn a_point_inside_a_triangle_that_is_no_pin_is_found() {
    let fault = fault_of(|mesh, line| {
        let triangle = line.segment_triangles[3];
        place(mesh, line, 3, SurfacePoint { triangle, barycentric: [0.25, 0.25, 0.5] });
    });
    assert!(matches!(fault, CheckError::InsideWithoutPin { point: 3, .. }), "{fault}");
}

#[test]
fn a_segment_that_leaves_its_triangle_is_found() {
    let fault = fault_of(|mesh, line| line.segment_triangles[3] = elsewhere(mesh, line));
    assert!(matches!(fault, CheckError::SegmentOutside { segment: 3, point: 3, .. }), "{fault}");
    let fault = fault_of(|_, line| line.segment_triangles[3] = line.segment_triangles[4]);
    assert!(matches!(fault, CheckError::SegmentOutside { segment: 3, point: 3, .. }), "{fault}");
    let fault = ring_fault_of(|_, line| line.segment_triangles.rotate_left(1));
    assert!(matches!(fault, CheckError::SegmentOutside { segment: 0, point: 0, .. }), "{fault}");
}

#[test]
fn a_line_over_a_wall_is_found() {
    // Pages 0 and 1 of a book of three, and the edge of the spine that both have.
    let mesh = book(3, 2).mesh();
    let on_spine = |t: &TriangleId| mesh.corners(*t).iter().filter(|v| v.0 <= 2).count() == 2;
    let pages: Vec<TriangleId> = (0..mesh.triangles().len() as u32).map(TriangleId).filter(on_spine).collect();
    let spine_edge = |t: TriangleId| mesh.corners(t).map(|v| v.0).into_iter().filter(|&v| v <= 2).sum::<u32>();
    let (from, to) = (pages[0], pages[2]);
    assert_eq!(spine_edge(from), spine_edge(to), "both on one edge of the spine");
    let parts = mesh.corners(from).map(|v| if v.0 <= 2 { 0.5 } else { 0.0 });
    let points = [SurfacePoint::barycentre(from), SurfacePoint { triangle: from, barycentric: parts }];
    let surface_points = vec![points[0], points[1], SurfacePoint::barycentre(to)];
    let pins = vec![surface_points[0], surface_points[2]];
    let leg = Leg { first: from, word: Vec::new(), parameters: Vec::new() };
    let line = Polyline {
        closed: false,
        points: surface_points.iter().map(|p| mesh.position_of(p)).collect(),
        surface_points,
        segment_triangles: vec![from, to],
        strip: vec![from, to],
        route: Route { closed: false, pins, legs: vec![leg] },
        report: Report::default(),
    };
    assert_eq!(check_polyline(&mesh, &line), Err(CheckError::SegmentsApart { point: 1, from, to }));
}

#[test]
fn the_same_place_twice_is_found() {
    let fault = fault_of(|_, line| {
        let (p, at, triangle) = (line.points[3], line.surface_points[3], line.segment_triangles[3]);
        line.points.insert(3, p);
        line.surface_points.insert(3, at);
        line.segment_triangles.insert(3, triangle);
    });
    assert_eq!(fault, CheckError::PlaceTwice { first: 3, second: 4 });
}

#[test]
fn a_mesh_vertex_seen_from_two_triangles_is_the_same_place() {
    let mesh = grid(2).mesh();
    let centre = VertexId(4);
    let seen_from = |t: u32| SurfacePoint {
        triangle: TriangleId(t),
        barycentric: mesh.corners(TriangleId(t)).map(|v| if v == centre { 1.0 } else { 0.0 }),
    };
    let round: Vec<u32> = (0..8).filter(|&t| mesh.corners(TriangleId(t)).contains(&centre)).collect();
    let surface_points = vec![seen_from(round[0]), seen_from(round[1])];
    let line = Polyline {
        closed: false,
        points: vec![mesh.position(centre); 2],
        segment_triangles: vec![TriangleId(round[0])],
        strip: vec![TriangleId(round[0])],
        route: Route { closed: false, pins: surface_points.clone(), legs: Vec::new() },
        surface_points,
        report: Report::default(),
    };
    assert_eq!(check_polyline(&mesh, &line), Err(CheckError::PlaceTwice { first: 0, second: 1 }));
}

#[test]
fn equal_points_are_found_unless_mesh_vertices_coincide() {
    // A triangle without area: its third vertex lies on the middle of the opposite edge. Then with that vertex on the first;
    // then with pins at both places, neither of which can move.
    for (x, pin_count, is_legal) in [(0.5, 1, false), (0.0, 1, true), (0.5, 2, true)] {
        let positions = [0.0, 1.0, x].map(|x| DVec3::new(x, 0.0, 0.0)).to_vec();
        let mesh = SurfaceMesh::new(positions, vec![[0, 1, 2]], None).expect("a legal mesh");
        let triangle = TriangleId(0);
        let start = if x == 0.0 { [1.0, 0.0, 0.0] } else { [0.5, 0.5, 0.0] };
        let surface_points = [start, [0.0, 0.0, 1.0]].map(|b| SurfacePoint { triangle, barycentric: b }).to_vec();
        let line = Polyline {
            closed: false,
            points: surface_points.iter().map(|p| mesh.position_of(p)).collect(),
            segment_triangles: vec![triangle],
            strip: vec![triangle],
            route: Route {
                closed: false,
                pins: surface_points.clone(),
                legs: vec![Leg { first: triangle, word: Vec::new(), parameters: Vec::new() }],
            },
            surface_points,
            report: Report::default(),
        };
        let mut line = line;
        line.route.pins.truncate(pin_count);
        let position = line.points[0];
        let fault = CheckError::PointsEqual { first: 0, second: 1, position };
        assert_eq!(check_polyline(&mesh, &line) != Err(fault), is_legal);
    }
}

#[test]
fn a_broken_strip_is_found() {
    let fault = fault_of(|_, line| line.strip.remove(4));
    assert!(matches!(fault, CheckError::StripBroken { place: 3, .. }), "{fault}");
    let fault = ring_fault_of(|_, line| line.strip.pop());
    assert!(matches!(fault, CheckError::StripBroken { .. }), "{fault}");
}

#[test]
fn a_backtrack_is_found_unless_a_pin_lies_in_it() {
    let fault = fault_of(|_, line| {
        let back = [line.strip[5], line.strip[4]];
        line.strip.splice(5..5, back);
    });
    assert!(matches!(fault, CheckError::Backtrack { place: 5, .. }), "{fault}");
    // A dead end: there and back again, pinned. The checker has accepted it.
    let (mesh, good) = good_line();
    let ends = [good.strip[0], good.strip[6], good.strip[0]].map(TriangleId::index);
    let there_and_back = line(&mesh, &faces(&ends), &all_pinned(geodesic()));
    assert!(there_and_back.strip.len() > 10);
}

#[test]
fn a_strip_that_does_not_go_with_the_line_is_found() {
    let fault = fault_of(|_, line| line.strip.reverse());
    assert!(matches!(fault, CheckError::StripOffLine { place: 0, point: 0, .. }), "{fault}");
    let fault = fault_of(|mesh, line| {
        // One triangle more at the end, without turning back.
        let [.., before, last] = line.strip[..] else { panic!("a short strip") };
        let next = last.halfedges().into_iter().filter_map(|h| mesh.twin(h)).map(HalfedgeId::triangle);
        line.strip.extend(next.filter(|&t| t != before).take(1));
    });
    assert!(matches!(fault, CheckError::StripOffLine { .. }), "{fault}");
    let fault = fault_of(|_, line| line.strip.pop());
    assert!(matches!(fault, CheckError::StripTooShort { .. }), "{fault}");
    let fault = ring_fault_of(|_, line| line.strip.reverse());
    assert!(matches!(fault, CheckError::StripOffLine { .. } | CheckError::StripTooShort { .. }), "{fault}");
    let fault = ring_fault_of(|_, line| line.strip = [line.strip.clone(), line.strip.clone()].concat());
    assert!(matches!(fault, CheckError::StripOffLine { .. } | CheckError::StripTooShort { .. }), "{fault}");
}

#[test]
fn a_ring_may_begin_anywhere() {
    let (mesh, line) = good_ring();
    let mut turned = line.clone();
    turned.strip.rotate_left(5);
    // The strip goes with the line; only the bytes, which fix where it begins, tell the difference.
    assert_eq!(check_polyline(&mesh, &turned), Err(CheckError::BytesDiffer { field: "strip" }));
}

#[test]
fn a_missed_pin_is_found() {
    // By one bit, and in the wrong order.
    let fault = fault_of(|_, line| {
        let inside = &mut line.route.pins[1].barycentric;
        inside[0] = next_up(inside[0]);
    });
    assert!(matches!(fault, CheckError::InsideWithoutPin { .. }), "{fault}");
    let fault = fault_of(|_, line| line.route.pins.swap(1, 2));
    assert!(matches!(fault, CheckError::PinMissing { pin: 2, .. }), "{fault}");
    let fault = fault_of(|_, line| {
        let end = line.route.pins[2];
        line.route.pins.push(SurfacePoint { barycentric: [0.2, 0.3, 0.5], ..end });
    });
    assert!(matches!(fault, CheckError::PinMissing { pin: 3, .. }), "{fault}");
    let (mesh, mut ring) = good_ring();
    ring.route.pins = vec![ring.surface_points[2]];
    assert!(matches!(check_polyline(&mesh, &ring), Err(CheckError::PinMissing { pin: 0, .. })), "it begins elsewhere");
}

#[test]
fn words_and_parameters_that_are_none_are_found() {
    let fault = fault_of(|_, line| line.route.legs.pop());
    assert_eq!(fault, CheckError::LegCount { legs: 1, pins: 3, closed: false });
    let fault = ring_fault_of(|_, line| line.route.closed = false);
    assert_eq!(fault, CheckError::LegCount { legs: 1, pins: 0, closed: true });
    let fault = fault_of(|_, line| line.route.legs[1].word.remove(2));
    assert_eq!(fault, CheckError::WordBroken { leg: 1, letter: 2 });
    let fault = fault_of(|_, line| line.route.legs[0].word[1] = HalfedgeId(1_000_000));
    assert_eq!(fault, CheckError::WordBroken { leg: 0, letter: 1 });
    let fault = fault_of(|mesh, line| {
        let leg = &mut line.route.legs[0];
        let twin = mesh.twin(leg.word[2]).expect("a letter has a twin");
        leg.word.splice(3..3, [twin, leg.word[2]]);
        leg.parameters.splice(3..3, [0.5, 0.5]);
    });
    assert_eq!(fault, CheckError::WordBroken { leg: 0, letter: 3 }, "a backtrack");
    let fault = ring_fault_of(|_, line| {
        line.route.legs[0].word.pop();
        line.route.legs[0].parameters.pop();
    });
    assert!(matches!(fault, CheckError::WordBroken { leg: 0, .. }), "the ring does not close: {fault}");
    for parameter in [-1e-300, 1.0 + f64::EPSILON, f64::NAN] {
        let fault = fault_of(|_, line| line.route.legs[1].parameters[2] = parameter);
        assert!(matches!(fault, CheckError::ParameterOff { leg: 1, letter: 2, .. }), "{fault}");
    }
}

#[test]
fn a_line_that_its_bytes_do_not_tell_is_found() {
    let fault = fault_of(|_, line| {
        let t = &mut line.route.legs[0].parameters[1];
        *t = next_up(*t);
    });
    assert_eq!(fault, CheckError::BytesDiffer { field: "surface_points" });
}

#[test]
fn new_repeats_are_counted_and_the_users_own_are_not() {
    let (_, line) = good_line();
    assert_eq!(count_new_repeats(&line, &line), 0);
    let mut looped = line.clone();
    let again = line.strip[2..5].to_vec();
    looped.strip.extend(again);
    assert_eq!(count_new_repeats(&line, &looped), 3);
    assert_eq!(count_new_repeats(&looped, &looped), 0, "step B's strip repeats them as well");
    assert_eq!(count_new_repeats(&looped, &line), 0);
}
