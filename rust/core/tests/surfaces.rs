//! Every filter on every made surface and on the shared meshes: a line that keeps all promises, or a named error.

mod support;

use glam::DVec3;
use smooth_polylines_core::check::count_new_repeats;
use smooth_polylines_core::{Error, Filter, Options, Pick, Pinned, StopReason, SurfaceMesh};
use support::random::Random;
use support::shapes::{self, Shape};
use support::{all_pinned, at, closed, faces, files, filters, geodesic, line, step_b, try_line};

/// Picks at random: barycentres, points inside, on edges and at vertices, some of them twice.
fn random_picks(shape: &Shape, random: &mut Random, count: usize) -> Vec<Pick> {
    let mut picks: Vec<Pick> = Vec::new();
    for _ in 0..count {
        let triangle = random.below(shape.triangles.len());
        let k = random.below(3);
        picks.push(match random.below(6) {
            0..=2 => Pick::Face(triangle as i128),
            3 => at(triangle, random.barycentric()),
            4 => {
                let t = random.between(0.05, 0.95);
                let mut parts = [0.0; 3];
                (parts[k], parts[(k + 1) % 3]) = (1.0 - t, t);
                at(triangle, parts)
            }
            _ => {
                let mut parts = [0.0; 3];
                parts[k] = 1.0;
                at(triangle, parts)
            }
        });
        if random.one_in(8) {
            picks.extend(picks.last().copied());
        }
    }
    picks
}

/// The same options with all ways to pin and close.
fn variants(options: &Options, picks: usize, random: &mut Random) -> Vec<Options> {
    let mut flags: Vec<bool> = (0..picks).map(|_| random.one_in(2)).collect();
    let some = |flags: &[bool]| Options { pinned: Pinned::Each(flags.to_vec()), ..options.clone() };
    let ring = closed(some(&flags));
    (flags[0], flags[picks - 1]) = (true, true);
    vec![options.clone(), some(&flags), all_pinned(options.clone()), closed(options.clone()), ring]
}

/// All filters and variants on random picks; returns how many lines and how many errors there were.
fn sweep(name: &str, shape: &Shape, rounds: usize, seed: u64) -> (usize, usize) {
    let mesh = shape.mesh();
    let mut random = Random::new(seed);
    let is_simple = is_simply_connected(&mesh);
    let (mut lines, mut errors) = (0, 0);
    for _ in 0..rounds {
        let count = 2 + random.below(4);
        let picks = random_picks(shape, &mut random, count);
        for (filter, options) in filters() {
            for options in variants(&options, picks.len(), &mut random) {
                match try_line(&mesh, &picks, &options) {
                    Ok(made) => {
                        lines += 1;
                        check_report(&made.report, &options);
                        let has_inner_pins = made.route.pins.len() > if options.closed { 0 } else { 2 };
                        // A curve that keeps the shape of its picks comes back to where they do.
                        if is_simple && !has_inner_pins && options.filter != Filter::Fair {
                            let before = try_line(&mesh, &picks, &step_b(&options));
                            let repeats = before.map_or(0, |before| count_new_repeats(&before, &made));
                            // Where its own route doubles back, passing a vertex may take the cubic into one triangle more.
                            let most = usize::from(options.filter == Filter::Cubic);
                            assert!(repeats <= most, "{name}, {filter}: new loops, {picks:?} {options:?}");
                        }
                    }
                    Err(Error::NoPath { .. } | Error::Collapsed { .. }) => errors += 1,
                    // Random picks may be fewer than three different ones.
                    Err(Error::Option(error)) if options.closed && error.argument == "picks" => errors += 1,
                    // As smooth as the pins allow: a closed line needs three of them.
                    Err(Error::Option(error)) if options.closed && error.argument == "detail_size" => errors += 1,
                    Err(other) => panic!("{name}, {filter}: {other}, {picks:?} {options:?}"),
                }
            }
        }
    }
    (lines, errors)
}

/// Whether every loop bounds a disc, so that no new one may stay: a sphere or a disc, in one part and without walls.
fn is_simply_connected(mesh: &SurfaceMesh) -> bool {
    let report = mesh.report();
    let rim = usize::from(report.boundary_edges > 0);
    let euler = (report.vertices + report.triangles) as i64 - report.edges as i64;
    report.parts == 1 && report.wall_edges == 0 && report.pinched_vertices == 0 && euler == 2 - rim as i64
}

fn check_report(report: &smooth_polylines_core::Report, options: &Options) {
    let is_step_b = options.filter == Filter::None;
    assert!(!is_step_b || (report.iterations == 0 && report.stop_reason == StopReason::Converged));
    assert!(report.start_length.is_finite());
    assert!(report.stages.is_empty(), "nobody asked for stages");
}

#[test]
fn surfaces_of_every_kind_carry_lines() {
    let made = [
        ("plane", shapes::grid(7)),
        ("irregular plane", shapes::irregular_grid(9, 1)),
        ("hills", shapes::hills(14, 2)),
        ("sphere", shapes::icosphere(3)),
        ("torus", shapes::torus(1.0, 0.4, 24, 12)),
        ("cylinder", shapes::cylinder(1.0, 2.0, 16, 12)),
        ("waist", shapes::waist(16, 12)),
        ("Moebius strip", shapes::moebius(28, 5)),
        ("tetrahedron-like cone", shapes::cone(3, 1.0)),
    ];
    for (i, (name, shape)) in made.iter().enumerate() {
        let (lines, _) = sweep(name, shape, 12, 100 + i as u64);
        assert!(lines > 60, "{name}: only {lines} lines");
    }
}

#[test]
fn fans_of_every_valence_carry_lines() {
    for valence in 3..12 {
        for wave in [0.0, 0.5] {
            let (lines, _) = sweep(&format!("fan of {valence}"), &shapes::fan(valence, wave), 6, valence as u64);
            assert!(lines > 20, "valence {valence}: only {lines} lines");
        }
    }
}

#[test]
fn relabelled_and_flipped_surfaces_carry_lines() {
    let mut random = Random::new(8);
    for shape in [shapes::hills(12, 5), shapes::torus(1.0, 0.4, 20, 10), shapes::moebius(24, 4)] {
        let (relabelled, _) = shape.relabelled(&mut random);
        sweep("a relabelled surface", &relabelled.flipped(&mut random), 8, 9);
    }
}

#[test]
fn pages_of_a_book_are_not_connected_and_two_pages_are_one_sheet() {
    let picks = |shape: &Shape| [[0.5, 0.5, 0.0], [0.0, 0.5, 0.5]].map(|p| shape.nearest(DVec3::from_array(p)));
    for pages in [3, 4] {
        let shape = shapes::book(pages, 6);
        let ids = [shape.nearest(DVec3::new(0.5, 0.5, 0.0)), shape.triangles.len() - 10];
        for (name, options) in filters() {
            match try_line(&shape.mesh(), &faces(&ids), &options) {
                Err(Error::NoPath { argument: "picks", first: 0, second: 1, parts }) => assert_eq!(parts, pages),
                other => panic!("{name}: {other:?}"),
            }
        }
        sweep("a page of a book", &shape, 10, pages as u64);
    }
    let sheet = shapes::book(2, 6);
    for (_, options) in filters() {
        line(&sheet.mesh(), &faces(&picks(&sheet)), &options);
    }
}

#[test]
fn a_line_goes_round_the_end_of_a_wall() {
    let shape = shapes::finned_grid(10, 0.6);
    let mesh = shape.mesh();
    assert_eq!(mesh.report().wall_edges, 6);
    let picks = faces(&[[0.2, 0.3], [0.2, 0.7]].map(|[x, y]| shape.nearest(DVec3::new(x, y, 0.0))));
    for (name, options) in filters() {
        let made = line(&mesh, &picks, &options);
        let round = made.points.iter().filter(|p| (p.y - 0.5).abs() < 1e-12).all(|p| p.x >= 0.6 - 1e-12);
        assert!(round, "{name} jumps over the wall");
    }
    // The shortest way touches the end of the wall, which is a pinched vertex, and stays there.
    let made = line(&mesh, &picks, &geodesic());
    let ends = [made.points[0], made.points[made.points.len() - 1]];
    let corner = DVec3::new(0.6, 0.5, 0.0);
    let expected = ends[0].distance(corner) + corner.distance(ends[1]);
    assert!((made.length() - expected).abs() < 1e-12, "{} instead of {expected}", made.length());
    assert_eq!(made.report.stop_reason, StopReason::ConvergedAtVertices);
    sweep("a plane with a wall", &shape, 12, 4);
}

#[test]
fn picks_in_one_triangle_and_in_neighbours_make_lines() {
    let shape = shapes::irregular_grid(6, 12);
    let mesh = shape.mesh();
    let inside = [at(20, [0.8, 0.1, 0.1]), at(20, [0.1, 0.8, 0.1]), at(20, [0.1, 0.1, 0.8])];
    for (name, options) in filters() {
        assert_eq!(line(&mesh, &inside[..1], &options).length(), 0.0, "{name}: one pick");
        assert_eq!(line(&mesh, &inside[..2], &options).points.len(), 2, "{name}: two in one triangle");
        let ring = line(&mesh, &inside, &closed(all_pinned(options.clone())));
        assert_eq!((ring.points.len(), ring.strip.len()), (3, 1), "{name}: a ring in one triangle");
        line(&mesh, &faces(&[20, 21]), &options);
        assert!(try_line(&mesh, &inside, &closed(options)).is_err(), "{name}: nothing holds it open");
    }
}

#[test]
fn shared_meshes_carry_lines_or_say_why_not() {
    let small = [
        "moebius.obj",
        "hourglass_ico.obj",
        "fan3.obj",
        "triple_vierbein.obj",
        "truck_nm.obj",
        "openscad_crash.obj",
        "suzanne.obj",
        "tray_cad.off",
        "thingi_79741.off",
    ];
    for (i, name) in small.iter().enumerate() {
        if let Some(shape) = files::shared_mesh(name) {
            sweep(name, &shape, 4, 500 + i as u64);
        }
    }
}
