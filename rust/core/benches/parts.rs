//! Times of the parts: opening a mesh, step B, the start of a geodesic, the funnel, Newton, and whole lines.
//!
//! Holds no comparison with other libraries (tests/bench has that) and no assertion on time. Runs on a made terrain and on
//! the shared scan where it is; a counter or a law that must hold belongs in `tests`.
#![allow(missing_docs, reason = "what criterion's macros write has no docs")]

use std::hint::black_box;
use std::time::Duration;

use criterion::{BatchSize, Criterion, criterion_group, criterion_main};
use glam::DVec3;
use smooth_polylines_core::adjacency::Adjacency;
use smooth_polylines_core::filter::workspace::Workspace;
use smooth_polylines_core::ids::TriangleId;
use smooth_polylines_core::join::{join_picks, place_picks, search_end};
use smooth_polylines_core::pauses::Pauses;
use smooth_polylines_core::relax::beads::Beads;
use smooth_polylines_core::relax::funnel::{Funnel, shortest_crossings};
use smooth_polylines_core::relax::newton::relax_by_newton;
use smooth_polylines_core::route::Route;
use smooth_polylines_core::smooth::polyline;
use smooth_polylines_core::smooth_geodesic::smooth_geodesic;
use smooth_polylines_core::stroke::{StrokePoints, stroke};
use smooth_polylines_core::unfold::Unfolding;
use smooth_polylines_core::window_search::find_taut_strip;
use smooth_polylines_core::{NoObserver, Options, Pick, Report, Step, SurfaceMesh};
use support::shapes::{self, Shape};
use support::{all_pinned, closed, cubic, faces, fair, files, geodesic};

#[path = "../tests/support/mod.rs"]
mod support;

/// Picks of a ring, and points of a stroke along it.
const RING_PICKS: usize = 30;
/// See [`RING_PICKS`].
const STROKE_POINTS: usize = 2000;

/// A mesh with the picks of each kind of line.
struct Scene {
    name: &'static str,
    shape: Shape,
    mesh: SurfaceMesh,
    near: [Pick; 2],
    across: [Pick; 2],
    ring: Vec<Pick>,
    drawn: Vec<DVec3>,
}

impl Scene {
    /// `around(share)` is a place beside the surface, for shares of a ring from 0 to 1.
    fn new(name: &'static str, shape: Shape, around: impl Fn(f64) -> DVec3) -> Self {
        let nearest = |share: f64| shape.nearest(around(share));
        let pair = |share: f64| -> [Pick; 2] { [0.0, share].map(|s| Pick::Face(nearest(s) as i128)) };
        let shares = |count: usize| (0..count).map(move |i| i as f64 / count as f64);
        let (near, across) = (pair(0.01), pair(0.5));
        let ring = faces(&shares(RING_PICKS).map(nearest).collect::<Vec<_>>());
        let drawn = shares(STROKE_POINTS).map(&around).collect();
        Self { name, mesh: shape.mesh(), shape, near, across, ring, drawn }
    }
}

/// The made mesh, of 80 000 triangles, and the scan, of 268 686.
fn scenes() -> Vec<Scene> {
    let circle = |share: f64| (std::f64::consts::TAU * share).sin_cos();
    let terrain = Scene::new("terrain", shapes::hills(200, 61), |share| {
        let (sin, cos) = circle(share);
        DVec3::new(0.5 + 0.4 * cos, 0.5 + 0.4 * sin, 0.0)
    });
    let scan = files::shared_mesh("igea.ply").map(|shape| {
        let low = shape.positions.iter().copied().fold(DVec3::INFINITY, DVec3::min);
        let high = shape.positions.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
        let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
        Scene::new("igea", shape, |share| {
            let (sin, cos) = circle(share);
            middle + half * DVec3::new(0.0, cos, sin)
        })
    });
    [Some(terrain), scan].into_iter().flatten().collect()
}

fn time_opening(criterion: &mut Criterion, scene: &Scene) {
    let (shape, name) = (&scene.shape, scene.name);
    criterion.bench_function(&format!("{name}/open/adjacency"), |bench| {
        bench.iter(|| Adjacency::new(black_box(&shape.triangles), shape.positions.len()));
    });
    criterion.bench_function(&format!("{name}/open/mesh"), |bench| {
        let arrays = || (shape.positions.clone(), shape.triangles.clone());
        bench.iter_batched(arrays, |(p, t)| SurfaceMesh::new(p, t, None), BatchSize::LargeInput);
    });
}

fn time_step_b(criterion: &mut Criterion, scene: &Scene) {
    let (mesh, name) = (&scene.mesh, scene.name);
    let count = scene.ring.len();
    let round: Vec<[Pick; 2]> = (0..count).map(|i| [scene.ring[i], scene.ring[(i + 1) % count]]).collect();
    // Else far searches would choose landmarks somewhere in the middle of the samples.
    mesh.dual_graph().choose_landmarks(TriangleId(0), &mut NoObserver).expect("nobody stops it");
    for (distance, pairs) in [("near", vec![scene.near]), ("ring", round), ("across", vec![scene.across])] {
        let points = pairs.iter().map(|pair| pair.map(|pick| mesh.resolve_pick(0, &pick).expect("legal")));
        let points: Vec<_> = points.collect();
        criterion.bench_function(&format!("{name}/step_b/{distance}"), |bench| {
            bench.iter(|| {
                for [from, to] in &points {
                    let ends = [from, to].map(|point| search_end(mesh, point));
                    let found = mesh.dual_graph().find_strip(&ends[0], &ends[1], &mut NoObserver);
                    black_box(found).expect("nobody stops the search");
                }
            });
        });
        criterion.bench_function(&format!("{name}/taut_start/{distance}"), |bench| {
            bench.iter(|| {
                for [from, to] in &points {
                    let found = find_taut_strip(mesh, from, to, &mut NoObserver);
                    black_box(found).expect("nobody stops the search");
                }
            });
        });
    }
}

/// The route across the mesh, from step B, with its report.
fn start_route(scene: &Scene, options: &Options) -> (Route, Report) {
    let mut report = Report::default();
    let stations = place_picks(&scene.mesh, &scene.across, options).expect("legal picks");
    let input = join_picks(&scene.mesh, &stations, options, &mut report, &mut NoObserver);
    (input.expect("connected picks").route, report)
}

fn time_whole_strips(criterion: &mut Criterion, scene: &Scene) {
    let (mesh, name) = (&scene.mesh, scene.name);
    let (route, report) = start_route(scene, &geodesic());
    let [start, end] = [0, 1].map(|i| mesh.position_of(&route.pins[i]));
    let (mut unfolding, mut funnel, mut parameters) = (Unfolding::default(), Funnel::default(), Vec::new());
    criterion.bench_function(&format!("{name}/funnel/across"), |bench| {
        bench.iter(|| {
            parameters.clear();
            let word = &route.legs[0].word;
            shortest_crossings(mesh, start, word, end, &mut unfolding, &mut funnel, &mut parameters);
            black_box(&parameters);
        });
    });
    let mut straight = route.clone();
    smooth_geodesic(mesh, &mut straight, &geodesic(), &mut Workspace::default(), &mut report.clone(), &mut NoObserver)
        .expect("an open line");
    let beads = Beads::of_route(mesh, &straight);
    criterion.bench_function(&format!("{name}/newton/across"), |bench| {
        let relax = |beads: &mut Beads| relax_by_newton(beads, &mut Pauses::new(&mut NoObserver, Step::Relax));
        bench.iter_batched_ref(|| beads.clone(), relax, BatchSize::SmallInput);
    });
}

fn time_lines(criterion: &mut Criterion, scene: &Scene) {
    let (mesh, name) = (&scene.mesh, scene.name);
    let linear = Options::default();
    let lines: [(&str, &[Pick], Options); 8] = [
        ("geodesic/near", &scene.near, geodesic()),
        ("geodesic/across", &scene.across, geodesic()),
        ("geodesic/ring", &scene.ring, all_pinned(geodesic())),
        ("linear/across", &scene.across, linear),
        ("cubic/across", &scene.across, cubic()),
        ("cubic/closed_ring", &scene.ring, closed(cubic())),
        ("fair/closed_ring", &scene.ring, closed(fair())),
        ("fair/closed_ring_pinned", &scene.ring, closed(all_pinned(fair()))),
    ];
    for (line, picks, options) in lines {
        criterion.bench_function(&format!("{name}/{line}"), |bench| {
            bench.iter(|| black_box(polyline(mesh, picks, &options, &mut NoObserver)).expect("the ring holds it open"));
        });
    }
    let drawn = StrokePoints::Space(scene.drawn.clone());
    criterion.bench_function(&format!("{name}/stroke/2000"), |bench| {
        bench.iter(|| black_box(stroke(mesh, &drawn, &cubic(), &mut NoObserver)).expect("the surface is one piece"));
    });
}

fn time_parts(criterion: &mut Criterion) {
    for scene in scenes() {
        time_opening(criterion, &scene);
        time_step_b(criterion, &scene);
        time_whole_strips(criterion, &scene);
        time_lines(criterion, &scene);
    }
}

criterion_group! {
    name = parts;
    // The slowest lines take a tenth of a second: ten samples, and the whole run stays within three minutes.
    config = Criterion::default()
        .sample_size(10)
        .warm_up_time(Duration::from_millis(300))
        .measurement_time(Duration::from_secs(1));
    targets = time_parts
}
criterion_main!(parts);
