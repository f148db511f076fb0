//! Step B against a plain Dijkstra written here, and how much of the mesh it visits.

mod support;

use std::cmp::Reverse;
use std::collections::{BTreeSet, BinaryHeap};
use std::ops::ControlFlow;

use glam::DVec3;
use smooth_polylines_core::ids::TriangleId;
use smooth_polylines_core::search::SearchEnd;
use smooth_polylines_core::strip::triangles_of;
use smooth_polylines_core::stroke::{StrokePoints, stroke};
use smooth_polylines_core::{Error, Filter, NoObserver, Observer, Options, Pick, Polyline, Report, Step, SurfaceMesh};
use support::random::Random;
use support::shapes::{self, Shape};
use support::{at, closed, faces, files, line, try_line};

/// The dual graph from the triangles alone: neighbours across edges of exactly two triangles, and barycentres.
struct Dual {
    neighbours: Vec<BTreeSet<usize>>,
    barycentres: Vec<DVec3>,
}

impl Dual {
    fn new(shape: &Shape) -> Self {
        let mut sides: Vec<([u32; 2], usize)> = Vec::new();
        for (t, &[a, b, c]) in shape.triangles.iter().enumerate() {
            sides.extend([[a, b], [b, c], [c, a]].map(|[u, v]| ([u.min(v), u.max(v)], t)));
        }
        sides.sort_unstable();
        let mut neighbours = vec![BTreeSet::new(); shape.triangles.len()];
        for group in sides.chunk_by(|a, b| a.0 == b.0) {
            if let &[(_, a), (_, b)] = group {
                neighbours[a].insert(b);
                neighbours[b].insert(a);
            }
        }
        let barycentre = |t: &[u32; 3]| t.iter().map(|&v| shape.positions[v as usize]).sum::<DVec3>() / 3.0;
        Self { neighbours, barycentres: shape.triangles.iter().map(barycentre).collect() }
    }

    /// Costs from one triangle to all; infinite where there is no path.
    fn costs(&self, from: usize) -> Vec<f64> {
        let mut costs = vec![f64::INFINITY; self.barycentres.len()];
        costs[from] = 0.0;
        // Costs are not negative, so their bits are in their order.
        let mut queue = BinaryHeap::from([Reverse((0u64, from))]);
        while let Some(Reverse((bits, t))) = queue.pop() {
            let cost = f64::from_bits(bits);
            if cost > costs[t] {
                continue;
            }
            for &next in &self.neighbours[t] {
                let new_cost = cost + self.barycentres[t].distance(self.barycentres[next]);
                if new_cost < costs[next] {
                    costs[next] = new_cost;
                    queue.push(Reverse((new_cost.to_bits(), next)));
                }
            }
        }
        costs
    }

    fn cost_of(&self, strip: &[TriangleId]) -> f64 {
        let step = |pair: &[TriangleId]| {
            let [a, b] = [pair[0].index(), pair[1].index()];
            assert!(self.neighbours[a].contains(&b), "no edge from {a} to {b}");
            self.barycentres[a].distance(self.barycentres[b])
        };
        strip.windows(2).map(step).sum()
    }
}

fn end(mesh: &SurfaceMesh, triangle: usize) -> SearchEnd {
    let triangle = TriangleId(triangle as u32);
    SearchEnd { triangles: vec![triangle], anchor: mesh.dual_graph().barycentre(triangle) }
}

/// Every cost from a few triangles to many, against Dijkstra's.
fn compare(name: &str, shape: &Shape, sources: usize, goals: usize) {
    for mesh in [shape.mesh(), sparing(shape)] {
        compare_on(&mesh, name, shape, sources, goals);
    }
}

/// The mesh as it is kept when it is very large: without records for step B.
fn sparing(shape: &Shape) -> SurfaceMesh {
    let Shape { positions, triangles } = shape.clone();
    SurfaceMesh::with_memory(positions, triangles, None, true).expect("a sound mesh")
}

fn compare_on(mesh: &SurfaceMesh, name: &str, shape: &Shape, sources: usize, goals: usize) {
    let dual = Dual::new(shape);
    let mut random = Random::new(77);
    for _ in 0..sources {
        let from = random.below(shape.triangles.len());
        let costs = dual.costs(from);
        for _ in 0..goals {
            let to = random.below(shape.triangles.len());
            let found = mesh.dual_graph().find_strip(&end(mesh, from), &end(mesh, to), &mut NoObserver);
            match found.expect("nobody interrupts") {
                None => assert!(costs[to].is_infinite(), "{name}: {from} to {to} is connected"),
                Some(found) => {
                    let strip = triangles_of(mesh, found.first, &found.word);
                    assert_eq!((strip[0].index(), strip[strip.len() - 1].index()), (from, to));
                    // Both are sums of the same positive numbers up to their order.
                    let slack = 1e-12 * costs[to];
                    assert!((found.cost - costs[to]).abs() <= slack, "{name}: {from} to {to}");
                    assert!((dual.cost_of(&strip) - costs[to]).abs() <= slack, "{name}: {from} to {to}");
                    assert!(found.pops as usize <= shape.triangles.len(), "{name}: a triangle was taken up again");
                }
            }
        }
    }
}

#[test]
fn costs_are_those_of_a_plain_dijkstra() {
    let mut random = Random::new(5);
    compare("plane", &shapes::grid(12), 6, 40);
    compare("irregular plane", &shapes::irregular_grid(16, 1), 6, 40);
    compare("hills", &shapes::hills(20, 1).relabelled(&mut random).0, 6, 40);
    compare("torus", &shapes::torus(1.0, 0.4, 30, 14), 6, 40);
    compare("Moebius strip", &shapes::moebius(30, 5).flipped(&mut random), 6, 40);
    compare("book with a wall", &shapes::book(3, 5), 6, 40);
    compare("plane with a wall", &shapes::finned_grid(12, 0.5), 6, 40);
    for name in ["cow.off", "truck_nm.obj", "thingi_79741.off"] {
        if let Some(shape) = files::shared_mesh(name) {
            compare(name, &shape, 3, 20);
        }
    }
}

#[test]
fn near_picks_visit_few_triangles_of_a_large_mesh() {
    let shape = shapes::irregular_grid(200, 6);
    let mesh = shape.mesh();
    let mut random = Random::new(3);
    for _ in 0..50 {
        let from = random.below(shape.triangles.len());
        let near = shape.positions[shape.triangles[from][0] as usize] + DVec3::new(0.02, -0.015, 0.0);
        let picks = faces(&[from, shape.nearest(near)]);
        let report = line(&mesh, &picks, &Options { filter: Filter::None, ..Options::default() }).report;
        // The line is some ten triangles long; A* looks at its neighbourhood.
        assert!(report.pops <= 80, "{} of {} triangles", report.pops, shape.triangles.len());
    }
}

#[test]
fn a_search_visits_no_more_than_the_ellipse_that_its_cost_allows() {
    // A triangle is taken from the queue only while its cost and the straight rest are at most the path's cost.
    let shape = shapes::icosphere(4);
    let (mesh, dual) = (shape.mesh(), Dual::new(&shape));
    let mut random = Random::new(4);
    for _ in 0..20 {
        let [from, to] = [0; 2].map(|_| random.below(shape.triangles.len()));
        let found = mesh.dual_graph().find_strip(&end(&mesh, from), &end(&mesh, to), &mut NoObserver);
        let found = found.expect("nobody interrupts").expect("a sphere is connected");
        let rest = |t: usize| dual.barycentres[t].distance(dual.barycentres[to]);
        let costs = dual.costs(from);
        let allowed = (0..costs.len()).filter(|&t| costs[t] + rest(t) <= found.cost * (1.0 + 1e-12)).count();
        assert!(found.pops as usize <= allowed, "{} pops, {allowed} allowed", found.pops);
    }
}

/// The line of step B and its pops; the report is left out, as its pops are what landmarks change.
fn strip_line(mesh: &SurfaceMesh, picks: &[Pick]) -> (Polyline, u64) {
    let found = line(mesh, picks, &Options { filter: Filter::None, ..Options::default() });
    let pops = found.report.pops;
    (Polyline { report: Report::default(), ..found }, pops)
}

/// Lines with and without landmarks, between faces, points on edges and vertices; pops without and with.
fn compare_landmarks(name: &str, shape: &Shape, pairs: usize) -> [u64; 2] {
    let (plain, marked) = (shape.mesh(), shape.mesh());
    marked.dual_graph().choose_landmarks(TriangleId(0), &mut NoObserver).expect("nobody interrupts");
    let mut random = Random::new(15);
    let kinds = [[1.0 / 3.0; 3], [0.0, 0.25, 0.75], [0.5, 0.5, 0.0], [0.0, 1.0, 0.0]];
    let mut pops = [0; 2];
    for _ in 0..pairs {
        let picks = [0; 2].map(|_| at(random.below(shape.triangles.len()), kinds[random.below(kinds.len())]));
        if try_line(&plain, &picks, &Options { filter: Filter::None, ..Options::default() }).is_ok() {
            let [(line, few), (same, fewer)] = [&plain, &marked].map(|mesh| strip_line(mesh, &picks));
            assert!(line == same, "{name}: {picks:?}");
            pops = [pops[0] + few, pops[1] + fewer];
        }
    }
    pops
}

#[test]
fn a_mesh_that_spares_memory_gives_the_same_lines() {
    let mut random = Random::new(8);
    let shape = shapes::hills(30, 4);
    let (mesh, spare) = (shape.mesh(), sparing(&shape));
    let filters = [Filter::None, Filter::Linear, Filter::Cubic, Filter::Geodesic, Filter::Fair];
    for round in 0..10 {
        let picks = faces(&[0; 4].map(|_| random.below(shape.triangles.len())));
        for filter in filters {
            let options = Options { filter, ..Options::default() };
            let options = if round % 2 == 0 { options } else { closed(options) };
            let [one, other] = [&mesh, &spare].map(|mesh| try_line(mesh, &picks, &options));
            assert!(one == other, "{filter:?} {picks:?}");
        }
    }
    // With landmarks too, and as a stroke through the air: the boxes stand in the same order.
    spare.dual_graph().choose_landmarks(TriangleId(0), &mut NoObserver).expect("nobody interrupts");
    let picks = faces(&[3, shape.triangles.len() - 5]);
    assert_eq!(strip_line(&mesh, &picks).0, strip_line(&spare, &picks).0);
    let points = (0..60).map(|i| DVec3::new(f64::from(i) / 60.0, 0.4, 0.7)).collect();
    let points = StrokePoints::Space(points);
    let options = Options { filter: Filter::Fair, ..Options::default() };
    let [one, other] = [&mesh, &spare].map(|mesh| stroke(mesh, &points, &options, &mut NoObserver));
    assert!(one.is_ok() && one == other);
}

#[test]
fn landmarks_change_no_bit_of_a_strip() {
    let mut random = Random::new(5);
    // Regular surfaces have the most strips of one cost.
    for (name, shape) in [
        ("plane", shapes::grid(20)),
        ("irregular plane", shapes::irregular_grid(20, 1)),
        ("hills", shapes::hills(20, 1).relabelled(&mut random).0),
        ("ball", shapes::icosphere(3)),
        ("torus", shapes::torus(1.0, 0.4, 30, 14)),
        ("Moebius strip", shapes::moebius(30, 5).flipped(&mut random)),
        ("book with a wall", shapes::book(3, 5)),
    ] {
        compare_landmarks(name, &shape, 200);
    }
    for name in ["cow.off", "truck_nm.obj", "openscad_crash.obj", "thingi_79741.off"] {
        if let Some(shape) = files::shared_mesh(name) {
            compare_landmarks(name, &shape, 60);
        }
    }
}

#[test]
fn landmarks_spare_most_of_the_pops_on_a_bulging_surface() {
    let [without, with] = compare_landmarks("ball", &shapes::icosphere(5), 60);
    // Measured: 0.21.
    assert!(3 * with < without, "{without} pops without landmarks, {with} with them");
}

#[test]
fn a_large_mesh_that_is_asked_often_chooses_landmarks_by_itself() {
    let shape = shapes::torus(1.0, 0.6, 200, 110);
    let (mesh, count) = (shape.mesh(), shape.triangles.len());
    let picks = faces(&[5, count / 2 + 31]);
    let (first, pops) = strip_line(&mesh, &picks);
    for _ in 0..=32 * count as u64 / pops {
        assert_eq!(strip_line(&mesh, &picks).0, first);
    }
    let (last, fewer) = strip_line(&mesh, &picks);
    assert_eq!(last, first);
    assert!(2 * fewer < pops, "{pops} pops at first, {fewer} after many searches");
}

#[test]
fn choosing_landmarks_can_be_interrupted_and_taken_up_again() {
    struct Impatient;
    impl Observer for Impatient {
        fn step(&mut self, _: Step) -> ControlFlow<()> {
            ControlFlow::Break(())
        }
    }
    let (one, other) = (shapes::icosphere(5).mesh(), shapes::icosphere(5).mesh());
    let interrupted = one.dual_graph().choose_landmarks(TriangleId(0), &mut Impatient);
    assert_eq!(interrupted, Err(Error::Interrupted));
    let picks = faces(&[3, 15_000]);
    let (line, pops) = strip_line(&one, &picks);
    assert_eq!((&line, pops), (&strip_line(&other, &picks).0, strip_line(&other, &picks).1), "as if never begun");
    one.dual_graph().choose_landmarks(TriangleId(0), &mut NoObserver).expect("nobody interrupts");
    let (same, fewer) = strip_line(&one, &picks);
    assert!(same == line && fewer < pops);
}

#[test]
fn a_ring_of_picks_is_joined_pair_by_pair() {
    let shape = shapes::hills(24, 3);
    let (mesh, dual) = (shape.mesh(), Dual::new(&shape));
    let ids = [[0.2, 0.2], [0.8, 0.25], [0.75, 0.8], [0.3, 0.7]].map(|[x, y]| shape.nearest(DVec3::new(x, y, 0.0)));
    let ring = line(&mesh, &faces(&ids), &closed(Options { filter: Filter::None, ..Options::default() }));
    let pairs = (0..4).map(|i| dual.costs(ids[i])[ids[(i + 1) % 4]]).sum::<f64>();
    let strip: Vec<TriangleId> = ring.strip.iter().chain(&ring.strip[..1]).copied().collect();
    // Where the strip turns back at a pick that is not pinned, that is cut off.
    assert!(dual.cost_of(&strip) <= pairs * (1.0 + 1e-12));
    assert!(dual.cost_of(&strip) > 0.9 * pairs);
}
