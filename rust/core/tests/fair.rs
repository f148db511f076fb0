//! The `fair` filter against what is known of it: the damping law and natural cubic splines in the plane, curves that do
//! not depend on the triangulation, no corners at picks, and the rules of the detail size.

mod support;

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};
use smooth_polylines_core::pauses::Pauses;
use smooth_polylines_core::{Error, NoObserver, Options, Pick, Pinned, Polyline, Step};
use support::random::Random;
use support::shapes::{self, Shape};
use support::{all_pinned, at, closed, faces, fair, geodesic, line, try_line};

/// The pick on a shape over the unit square that lies above or below a place.
fn above(shape: &Shape, place: DVec2) -> Pick {
    let inside = |triangle: usize| {
        let [a, b, c] = shape.triangles[triangle].map(|v| shape.positions[v as usize].truncate());
        let area = (b - a).perp_dot(c - a);
        let parts = [(b - place).perp_dot(c - place), (c - place).perp_dot(a - place), (a - place).perp_dot(b - place)];
        parts.map(|part| part / area)
    };
    let least = |triangle: &usize| inside(*triangle).into_iter().fold(f64::INFINITY, f64::min);
    let best = (0..shape.triangles.len()).max_by(|a, b| least(a).total_cmp(&least(b))).expect("a shape has triangles");
    let parts = inside(best).map(|part| part.max(0.0));
    let sum: f64 = parts.iter().sum();
    at(best, parts.map(|part| part / sum))
}

fn picks_above(shape: &Shape, places: &[[f64; 2]]) -> Vec<Pick> {
    places.iter().map(|&place| above(shape, DVec2::from_array(place))).collect()
}

/// Points along a line, no further apart than `spacing`.
fn dense(line: &Polyline, spacing: f64) -> Vec<DVec3> {
    let count = line.points.len();
    let segments = if line.closed { count } else { count - 1 };
    let cut = |i: usize| {
        let (a, b) = (line.points[i], line.points[(i + 1) % count]);
        let pieces = (a.distance(b) / spacing).ceil().max(1.0) as usize;
        (0..pieces).map(move |k| a.lerp(b, k as f64 / pieces as f64))
    };
    (0..segments).flat_map(cut).chain(line.points.last().copied()).collect()
}

/// The largest distance of a point of one line from the other line.
fn distance_between(first: &Polyline, second: &Polyline, spacing: f64) -> f64 {
    let (first, second) = (dense(first, spacing), dense(second, spacing));
    let apart = |a: &[DVec3], b: &[DVec3]| {
        let nearest = |p: &DVec3| b.iter().map(|q| p.distance_squared(*q)).fold(f64::INFINITY, f64::min);
        a.iter().map(nearest).fold(0.0, f64::max).sqrt()
    };
    apart(&first, &second).max(apart(&second, &first))
}

/// Two triangulations each of two densities.
fn squares() -> [(usize, Shape); 4] {
    [20, 40]
        .map(|cells| [(cells, shapes::grid(cells)), (cells, shapes::irregular_grid(cells, 3))])
        .concat()
        .try_into()
        .expect("four")
}

/// How much of the height of a sine a line keeps: least squares over the middle half.
fn kept_height(line: &Polyline, height: f64, wavelength: f64) -> f64 {
    let middle = line.points.iter().filter(|p| (0.25..0.75).contains(&p.x));
    let (mut ss, mut sc, mut cc, mut sy, mut cy) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for p in middle {
        let (s, c) = (TAU * p.x / wavelength).sin_cos();
        (ss, sc, cc, sy, cy) = (ss + s * s, sc + s * c, cc + c * c, sy + s * (p.y - 0.5), cy + c * (p.y - 0.5));
    }
    let determinant = ss * cc - sc * sc;
    let (a, b) = ((cc * sy - sc * cy) / determinant, (ss * cy - sc * sy) / determinant);
    a.hypot(b) / height
}

#[test]
fn a_sine_is_damped_as_the_law_says_on_any_triangulation() {
    for (cells, shape) in squares() {
        let mesh = shape.mesh();
        let wavelength = 0.25;
        let height = 0.01;
        let places: Vec<[f64; 2]> = (0..=180)
            .map(|i| 0.05 + 0.9 * f64::from(i) / 180.0)
            .map(|x| [x, 0.5 + height * (TAU * x / wavelength).sin()])
            .collect();
        let picks = picks_above(&shape, &places);
        for share in [0.05, 0.1, 0.16, 0.25, 0.4] {
            let options = Options { detail_size: Some(share * wavelength), ..fair() };
            let made = line(&mesh, &picks, &options);
            let law = 1.0 / (1.0 + (TAU * share).powi(4));
            let kept = kept_height(&made, height, wavelength);
            assert!((kept - law).abs() < 0.05, "{cells} cells, detail {share} of the wave: keeps {kept}, law {law}");
            assert!(made.report.newton_steps <= 16, "{} steps", made.report.newton_steps);
        }
    }
}

/// The natural cubic spline through places, its parameter the length of the chords; many points of it.
fn natural_spline(places: &[[f64; 2]]) -> Vec<DVec3> {
    let points: Vec<DVec2> = places.iter().map(|&p| DVec2::from_array(p)).collect();
    let n = points.len();
    let steps: Vec<f64> = points.windows(2).map(|pair| pair[0].distance(pair[1])).collect();
    // Second derivatives: a tridiagonal system, none at the ends.
    let mut diagonal = vec![1.0; n];
    let mut right = vec![DVec2::ZERO; n];
    let mut upper = vec![0.0; n];
    for i in 1..n - 1 {
        let (h, k) = (steps[i - 1], steps[i]);
        let slope_change = (points[i + 1] - points[i]) / k - (points[i] - points[i - 1]) / h;
        let factor = if i > 1 { h / diagonal[i - 1] } else { 0.0 };
        diagonal[i] = 2.0 * (h + k) - factor * upper[i - 1];
        right[i] = 6.0 * slope_change - factor * right[i - 1];
        upper[i] = k;
    }
    let mut second = vec![DVec2::ZERO; n];
    for i in (1..n - 1).rev() {
        second[i] = (right[i] - upper[i] * second[i + 1]) / diagonal[i];
    }
    let piece = |i: usize| {
        let h = steps[i];
        let (a, b, ma, mb) = (points[i], points[i + 1], second[i], second[i + 1]);
        (0..=400).map(move |k| {
            let (u, v) = (h * (1.0 - f64::from(k) / 400.0), h * f64::from(k) / 400.0);
            let bent = (ma * u.powi(3) + mb * v.powi(3)) / (6.0 * h);
            (bent + (a / h - ma * h / 6.0) * u + (b / h - mb * h / 6.0) * v).extend(0.0)
        })
    };
    (0..n - 1).flat_map(piece).collect()
}

const ZIGZAG: [[f64; 2]; 5] = [[0.1, 0.3], [0.3, 0.7], [0.5, 0.35], [0.7, 0.65], [0.92, 0.2]];

#[test]
fn through_pins_in_the_plane_it_is_the_natural_cubic_spline() {
    let spline = natural_spline(&ZIGZAG);
    for (cells, shape) in squares() {
        let made = line(&shape.mesh(), &picks_above(&shape, &ZIGZAG), &all_pinned(fair()));
        assert_eq!(made.report.detail_size, Some(f64::INFINITY));
        let off = |p: &DVec3| spline.iter().map(|q| p.distance(*q)).fold(f64::INFINITY, f64::min);
        let furthest = made.points.iter().map(off).fold(0.0, f64::max) * cells as f64;
        assert!(furthest < 0.1, "{cells} cells: {furthest} edges off the natural spline");
        assert!(made.report.newton_steps <= 24, "{} steps", made.report.newton_steps);
    }
}

/// Hills over the unit square, the same for every triangulation.
fn lifted(mut shape: Shape) -> Shape {
    for p in &mut shape.positions {
        p.z = 0.08 * (5.0 * p.x).sin() * (4.0 * p.y).cos() + 0.03 * (9.0 * p.x + 3.0 * p.y).sin();
    }
    shape
}

const RING: [[f64; 2]; 6] = [[0.2, 0.5], [0.35, 0.8], [0.6, 0.75], [0.8, 0.5], [0.6, 0.2], [0.35, 0.25]];

#[test]
fn the_curve_does_not_depend_on_the_triangulation() {
    let ways: [(&[[f64; 2]], Options); 4] = [
        (&ZIGZAG, all_pinned(fair())),
        (&ZIGZAG, fair()),
        (&RING, closed(fair())),
        (&RING, closed(all_pinned(fair()))),
    ];
    for (places, options) in ways {
        let finest = lifted(shapes::irregular_grid(60, 8));
        let reference = line(&finest.mesh(), &picks_above(&finest, places), &options);
        for (cells, shape) in squares() {
            let shape = lifted(shape);
            let made = line(&shape.mesh(), &picks_above(&shape, places), &options);
            let apart = distance_between(&made, &reference, 0.004) * cells as f64;
            assert!(apart < 0.5, "{cells} cells: {apart} edges off the curve on a finer mesh, {options:?}");
        }
    }
}

#[test]
fn a_curve_has_no_corner_at_a_pinned_pick() {
    let largest_turn = |line: &Polyline| {
        let ways: Vec<DVec3> = line.points.windows(2).map(|pair| pair[1] - pair[0]).collect();
        ways.windows(2).map(|pair| pair[0].angle_between(pair[1])).fold(0.0, f64::max)
    };
    let shape = shapes::irregular_grid(50, 12);
    let (mesh, picks) = (shape.mesh(), picks_above(&shape, &ZIGZAG));
    let round = largest_turn(&line(&mesh, &picks, &all_pinned(fair())));
    let sharp = largest_turn(&line(&mesh, &picks, &all_pinned(geodesic())));
    assert!(sharp > 1.8, "the picks are a zigzag of {sharp}");
    // The tightest bend has a radius of about two edges.
    assert!(round < 0.6, "turns by {round} at once");
}

#[test]
fn the_energy_never_rises() {
    let mut random = Random::new(77);
    for shape in [shapes::hills(30, 2), shapes::icosphere(3), shapes::torus(1.0, 0.4, 40, 16), shapes::moebius(60, 8)] {
        let mesh = shape.mesh();
        for round in 0..8 {
            let picks: Vec<usize> = (0..4).map(|_| random.below(shape.triangles.len())).collect();
            let mut options = fair();
            options.closed = round % 2 == 1;
            options.pinned = if round % 4 < 2 { Pinned::All } else { Pinned::Ends };
            let Ok(made) = try_line(&mesh, &faces(&picks), &options) else { continue };
            let energies = &made.report.energies;
            assert!(energies.windows(2).all(|pair| pair[1] < pair[0]), "{energies:?}");
            assert!(!energies.is_empty() && energies.iter().all(|e| e.is_finite()));
        }
    }
}

#[test]
fn round_a_sphere_and_a_cylinder_it_closes_smoothly() {
    // Through picks on a great circle the fairest curve is that circle.
    let sphere = shapes::icosphere(4);
    let places = (0..4).map(|i| PI * f64::from(i) / 2.0 + 0.3).map(|u| DVec3::new(u.cos(), u.sin(), 0.0));
    let picks = faces(&places.map(|p| sphere.nearest(p)).collect::<Vec<_>>());
    let ring = line(&sphere.mesh(), &picks, &closed(all_pinned(fair())));
    assert!(ring.points.iter().all(|p| p.z.abs() < 0.05), "the picks lie a third of an edge off the circle");
    assert!((ring.length() - TAU).abs() < 0.03, "{}", ring.length());
    let cylinder = shapes::cylinder(1.0, 2.0, 40, 20);
    let heights = [0.3, -0.2, 0.4, 0.0, -0.5];
    let ids = heights.iter().enumerate().map(|(i, &z)| {
        let u = TAU * i as f64 / 5.0;
        cylinder.nearest(DVec3::new(u.cos(), u.sin(), z))
    });
    let picks = faces(&ids.collect::<Vec<_>>());
    // Without closeness nothing but pins holds it; with a large detail size it is nearly level.
    let level = line(&cylinder.mesh(), &picks, &closed(Options { detail_size: Some(4.0), ..fair() }));
    let mean = level.points.iter().map(|p| p.z).sum::<f64>() / level.points.len() as f64;
    assert!(level.points.iter().all(|p| (p.z - mean).abs() < 0.05));
    assert!(mean.abs() < 0.1, "the mean of the picks is 0, the line's {mean}");
}

#[test]
fn the_detail_size_follows_its_rules() {
    let shape = shapes::irregular_grid(20, 5);
    let mesh = shape.mesh();
    let picks = picks_above(&shape, &ZIGZAG);
    let size = |options: &Options| line(&mesh, &picks, options).report.detail_size.expect("fair has a detail size");
    let straight = line(&mesh, &picks, &all_pinned(geodesic())).length();
    assert!((size(&fair()) - 0.25 * straight / 4.0).abs() < 1e-9 * straight);
    assert!(
        (size(&closed(fair())) - 0.25 * line(&mesh, &picks, &closed(all_pinned(geodesic()))).length() / 5.0).abs()
            < 1e-9
    );
    assert_eq!(size(&all_pinned(fair())), f64::INFINITY);
    assert_eq!(size(&Options { detail_size: Some(0.07), ..fair() }), 0.07);
    let some = Pinned::Each(vec![true, true, false, true, true]);
    assert!(size(&Options { pinned: some.clone(), ..fair() }).is_finite(), "one inner pick is not pinned");
    let held = closed(Options { pinned: some, detail_size: Some(f64::INFINITY), ..fair() });
    assert_eq!(size(&held), f64::INFINITY, "four pins hold a closed line");
    for pins in 0..3 {
        let pinned = Pinned::Each((0..5).map(|i| i < pins).collect());
        let options = closed(Options { pinned, detail_size: Some(f64::INFINITY), ..fair() });
        match try_line(&mesh, &picks, &options) {
            Err(Error::Option(error)) => {
                assert_eq!(error.argument, "detail_size");
                assert!(error.message.contains(&format!("found {pins}")), "{}", error.message);
            }
            other => panic!("{pins} pins: {other:?}"),
        }
    }
}

#[test]
fn pins_on_edges_and_vertices_are_passed_without_a_corner() {
    let shape = shapes::grid(12);
    let mesh = shape.mesh();
    // A straight row of picks: on a vertex, on an edge, inside, all on y = 0.5.
    let vertex = shape
        .triangles
        .iter()
        .position(|t| t.iter().any(|&v| shape.positions[v as usize] == DVec3::new(0.5, 0.5, 0.0)));
    let places = [[0.1, 0.5], [0.5, 0.5], [0.77, 0.5], [0.95, 0.5]];
    assert!(vertex.is_some(), "the middle of the square is a vertex");
    let made = line(&mesh, &picks_above(&shape, &places), &all_pinned(fair()));
    assert!(made.points.iter().all(|p| (p.y - 0.5).abs() < 1e-6));
    // On a cone's tip, half of what is left of a full turn is straight ahead.
    let cone = shapes::cone(6, 0.7);
    let picks = [at(0, [0.0, 1.0, 0.0]), at(0, [1.0, 0.0, 0.0]), at(3, [0.0, 1.0, 0.0])];
    let straight = line(&cone.mesh(), &picks, &all_pinned(fair()));
    assert_eq!(straight.points.len(), 3, "rim to tip to opposite rim has no turn to round off");
}

#[test]
fn self_crossings_that_the_input_did_not_have_are_told() {
    let shape = shapes::irregular_grid(40, 9);
    let mesh = shape.mesh();
    let eight = [[0.2, 0.3], [0.8, 0.7], [0.8, 0.3], [0.2, 0.7]];
    let made = line(&mesh, &picks_above(&shape, &eight), &closed(all_pinned(fair())));
    assert_eq!(made.report.new_self_crossings, 0, "a figure eight crosses itself once, as its picks do");
    let plain = line(&mesh, &picks_above(&shape, &RING), &closed(all_pinned(fair())));
    assert_eq!(plain.report.new_self_crossings, 0);
    // A hairpin and an arm that ends near it: the curve swings out of the hairpin and over the arm's end.
    let hairpin = [[0.5, 0.2], [0.5, 0.7], [0.55, 0.2], [0.9, 0.2], [0.9, 0.73], [0.54, 0.73]];
    let swung = line(&mesh, &picks_above(&shape, &hairpin), &all_pinned(fair()));
    let before = line(&mesh, &picks_above(&shape, &hairpin), &all_pinned(geodesic()));
    let crossings = |line: &Polyline| {
        smooth_polylines_core::self_crossings::count_self_crossings(
            &mesh,
            &line.route,
            &mut Pauses::new(&mut NoObserver, Step::Relax),
        )
        .expect("nobody stops it")
    };
    assert_eq!(swung.report.new_self_crossings, crossings(&swung).saturating_sub(crossings(&before)));
    assert!(swung.report.new_self_crossings > 0, "{} after, {} before", crossings(&swung), crossings(&before));
}

#[test]
fn a_fair_line_does_not_depend_on_the_lines_made_before_it() {
    let shape = shapes::hills(24, 3);
    let around = |mesh: &smooth_polylines_core::SurfaceMesh| line(mesh, &faces(&[100, 700, 900, 300]), &fair()).points;
    let fresh = around(&shape.mesh());
    let mesh = shape.mesh();
    for picks in [[50, 1000, 400], [320, 90, 710], [910, 105, 690]] {
        line(&mesh, &faces(&picks), &fair());
    }
    assert_eq!(around(&mesh), fresh);
}
