//! Lines with other picks, made from the line before: equal to fresh ones where that is promised, near them elsewhere, at
//! the cost of what has changed.

mod support;

use glam::DVec3;
use smooth_polylines_core::check::check_polyline;
use smooth_polylines_core::remake::with_picks;
use smooth_polylines_core::smooth::polyline_kept;
use smooth_polylines_core::{Error, Filter, Made, NoObserver, Options, Pick, Pinned, Polyline, Report, SurfaceMesh};
use support::random::Random;
use support::shapes::{self, Shape};
use support::{all_pinned, closed, cubic, faces, fair, filters};

fn made(mesh: &SurfaceMesh, picks: &[Pick], options: &Options) -> Made {
    polyline_kept(mesh, picks, options, &mut NoObserver).unwrap_or_else(|error| panic!("{picks:?}: {error}"))
}

fn again(mesh: &SurfaceMesh, before: &Made, picks: &[Pick], pinned: Option<Pinned>) -> Made {
    let after = with_picks(mesh, &before.line, &before.kept, picks, pinned, &mut NoObserver)
        .unwrap_or_else(|error| panic!("{picks:?}: {error}"));
    check_polyline(mesh, &after.line).unwrap_or_else(|error| panic!("{picks:?}: {error}"));
    after
}

fn any_pick(random: &mut Random, mesh: &SurfaceMesh) -> Pick {
    let parts: [f64; 3] = std::array::from_fn(|_| random.between(0.01, 1.0));
    let sum: f64 = parts.iter().sum();
    support::at(random.below(mesh.triangles().len()), parts.map(|part| part / sum))
}

/// The irregular unit square, lifted to hills.
fn terrain(cells: usize) -> Shape {
    let mut shape = shapes::irregular_grid(cells, 5);
    for p in &mut shape.positions {
        p.z = 0.15 * (9.0 * p.x).sin() * (7.0 * p.y).cos();
    }
    shape
}

fn surfaces() -> Vec<(&'static str, SurfaceMesh)> {
    vec![("terrain", terrain(24).mesh()), ("ball", shapes::icosphere(4).mesh())]
}

/// A pick moved, inserted or removed.
fn edited(random: &mut Random, mesh: &SurfaceMesh, picks: &[Pick]) -> Vec<Pick> {
    let mut picks = picks.to_vec();
    let place = random.below(picks.len());
    match random.below(4) {
        0 => picks.insert(place, any_pick(random, mesh)),
        1 if picks.len() > 5 => {
            picks.remove(place);
        }
        _ => picks[place] = any_pick(random, mesh),
    }
    picks
}

/// What is told of a line apart from the work, which is less.
fn outcome(line: &Polyline) -> impl PartialEq + std::fmt::Debug {
    let Report { strip_triangles, stop_reason, .. } = line.report;
    (strip_triangles, stop_reason)
}

#[test]
fn legs_that_do_not_know_of_each_other_give_the_bytes_of_a_fresh_line() {
    for (name, mesh) in surfaces() {
        for (filter, options) in
            filters().into_iter().filter(|(_, o)| !matches!(o.filter, Filter::Cubic | Filter::Fair))
        {
            let mut random = Random::new(11);
            for options in [all_pinned(options.clone()), closed(all_pinned(options.clone())), options.clone()] {
                let mut picks: Vec<Pick> = (0..7).map(|_| any_pick(&mut random, &mesh)).collect();
                let mut line = made(&mesh, &picks, &options);
                for _ in 0..8 {
                    picks = edited(&mut random, &mesh, &picks);
                    let fresh = made(&mesh, &picks, &options);
                    line = again(&mesh, &line, &picks, None);
                    let (ours, theirs) = (&line.line, &fresh.line);
                    assert_eq!(ours.to_bytes(&mesh), theirs.to_bytes(&mesh), "{name} {filter} {picks:?}");
                    assert_eq!(ours.points, theirs.points, "{name} {filter}");
                    assert_eq!(outcome(ours), outcome(theirs), "{name} {filter}");
                    let (a, b) = (ours.report.start_length, theirs.report.start_length);
                    assert!((a - b).abs() < 1e-12 * b, "{name} {filter}: {a} {b}");
                    if options.pinned == Pinned::All {
                        let kept = ours.report.kept_legs;
                        assert!(kept + 2 >= ours.route.legs.len() && kept <= ours.route.legs.len(), "{kept} kept");
                    }
                }
            }
        }
    }
}

#[test]
fn pins_that_come_and_go_change_only_their_own_legs() {
    let mesh = terrain(24).mesh();
    let mut random = Random::new(3);
    let picks: Vec<Pick> = (0..9).map(|_| any_pick(&mut random, &mesh)).collect();
    let geodesic = all_pinned(support::geodesic());
    let mut line = made(&mesh, &picks, &geodesic);
    for free in 1..8 {
        let flags: Vec<bool> = (0..9).map(|i| i != free).collect();
        line = again(&mesh, &line, &picks, Some(Pinned::Each(flags.clone())));
        let fresh = made(&mesh, &picks, &Options { pinned: Pinned::Each(flags), ..geodesic.clone() });
        assert_eq!(line.line.to_bytes(&mesh), fresh.line.to_bytes(&mesh));
        assert!(line.line.report.kept_legs >= 4);
    }
    let wrong = with_picks(&mesh, &line.line, &line.kept, &picks[1..], None, &mut NoObserver);
    assert!(matches!(wrong, Err(Error::Option(_))), "eight picks, nine flags: {wrong:?}");
}

#[test]
fn nothing_is_done_when_nothing_changes() {
    for (name, mesh) in surfaces() {
        let mut random = Random::new(7);
        let picks: Vec<Pick> = (0..8).map(|_| any_pick(&mut random, &mesh)).collect();
        for (filter, options) in filters() {
            let line = made(&mesh, &picks, &all_pinned(options));
            let same = again(&mesh, &line, &picks, None).line;
            assert_eq!(same.points, line.line.points, "{name} {filter}");
            assert_eq!(outcome(&same), outcome(&line.line), "{name} {filter}");
            let Report { pops, moves, funnels, newton_steps, vertex_passes, kept_legs, .. } = same.report;
            assert_eq!((pops, moves, funnels, newton_steps, vertex_passes, kept_legs), (0, 0, 0, 0, 0, 7), "{filter}");
        }
    }
}

/// The largest distance of points of one line from the other line, both ways.
fn distance_between(a: &Polyline, b: &Polyline) -> f64 {
    let off = |p: &DVec3, line: &Polyline| {
        let count = line.points.len();
        let segments = if line.closed { count } else { count - 1 };
        let to = |i: usize| {
            let (start, end) = (line.points[i], line.points[(i + 1) % count]);
            let way = end - start;
            let t = ((*p - start).dot(way) / way.length_squared()).clamp(0.0, 1.0);
            (start + t * way).distance(*p)
        };
        (0..segments).map(to).fold(f64::INFINITY, f64::min)
    };
    let one_way = |a: &Polyline, b: &Polyline| a.points.iter().map(|p| off(p, b)).fold(0.0, f64::max);
    one_way(a, b).max(one_way(b, a))
}

/// Drags one pick of many through places a little apart; the distances from fresh lines in edges, and the share of the
/// work of these that it took, by `work`.
fn drag(
    mesh: &SurfaceMesh,
    picks: &[Pick],
    options: &Options,
    way: &[Pick],
    work: fn(&Report) -> u64,
) -> (Vec<f64>, f64) {
    let edge = mesh.edge_length(smooth_polylines_core::ids::TriangleId(0).halfedge(0));
    let mut line = made(mesh, picks, options);
    let (mut distances, mut spent) = (Vec::new(), [0, 0]);
    let mut picks = picks.to_vec();
    let middle = picks.len() / 2;
    for &place in way {
        picks[middle] = place;
        let fresh = made(mesh, &picks, options);
        let next = again(mesh, &line, &picks, None);
        let once_more = again(mesh, &line, &picks, None);
        assert_eq!(next.line.to_bytes(mesh), once_more.line.to_bytes(mesh), "the same again");
        assert!(next.line.report.kept_legs + 2 >= next.line.route.legs.len());
        distances.push(distance_between(&next.line, &fresh.line) / edge);
        spent = [spent[0] + work(&next.line.report), spent[1] + work(&fresh.line.report)];
        line = next;
    }
    (distances, spent[0] as f64 / spent[1] as f64)
}

/// Picks round a wavy ball, and where the middle one is dragged to: so that drags take it over several edges.
fn ring_of_picks() -> (SurfaceMesh, Vec<Pick>, Vec<Pick>) {
    let mut shape = shapes::icosphere(5);
    for p in &mut shape.positions {
        *p *= 1.0 + 0.1 * (3.0 * p.x).sin() * (4.0 * p.y + p.z).cos();
    }
    let place = |turn: f64, height: f64| {
        let angle = std::f64::consts::TAU * turn;
        shape.nearest(DVec3::new(angle.cos(), angle.sin(), height))
    };
    let ring: Vec<usize> = (0..24).map(|k| place(f64::from(k) / 25.0, 0.2 * (f64::from(k) * 1.3).sin())).collect();
    let way: Vec<usize> = (0..12).map(|k| place(12.0 / 25.0 + 0.002 * f64::from(k), 0.02 * f64::from(k))).collect();
    let (ring, way) = (faces(&ring), faces(&way));
    (shape.mesh(), ring, way)
}

#[test]
fn a_dragged_cubic_is_a_fresh_one_to_a_tenth_of_an_edge() {
    let (mesh, picks, way) = ring_of_picks();
    for options in [all_pinned(cubic()), closed(all_pinned(cubic()))] {
        let (distances, share) = drag(&mesh, &picks, &options, &way, |report| report.moves);
        assert!(distances.iter().all(|&d| d < 0.1), "{distances:?}");
        assert!(share < 0.15, "{share} of the moves");
    }
}

#[test]
fn a_dragged_fair_line_is_near_a_fresh_one() {
    let (mesh, picks, way) = ring_of_picks();
    for options in [all_pinned(fair()), closed(all_pinned(fair()))] {
        let (distances, share) = drag(&mesh, &picks, &options, &way, |report| report.funnels);
        assert!(distances.iter().all(|&d| d < 0.3), "{distances:?}");
        assert!(share < 0.4, "{share} of the funnels");
    }
    // Unpinned picks: a draft of the whole line.
    let (distances, _) = drag(&mesh, &picks, &fair(), &way, |report| report.funnels);
    assert!(distances.iter().all(|&d| d < 0.3), "{distances:?}");
}
