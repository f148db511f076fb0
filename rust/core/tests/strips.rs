//! Words of strips: the compact form there and back, reduction, turns round a vertex, closed words, loops
//! that are the route's own.

mod support;

use glam::DVec3;
use smooth_polylines_core::check::{CheckError, check_polyline};
use smooth_polylines_core::filter::geodesic::unwind;
use smooth_polylines_core::ids::{HalfedgeId, TriangleId, VertexId};
use smooth_polylines_core::strip::{
    decode_word, encode_word, entered_triangle, push_reduced, reduce_seam, triangles_of, turn_word,
};
use smooth_polylines_core::{Filter, Options, Polyline, SurfaceMesh};
use support::random::Random;
use support::shapes::{self, Shape};
use support::{all_pinned, closed, cubic, faces, filters, line, step_b, try_line};

fn shapes_to_walk() -> Vec<Shape> {
    let mut random = Random::new(2);
    vec![
        shapes::irregular_grid(8, 1),
        shapes::icosphere(2),
        shapes::torus(1.0, 0.3, 14, 8).relabelled(&mut random).0,
        shapes::moebius(20, 3).flipped(&mut random),
        shapes::finned_grid(8, 0.5),
        shapes::fan(7, 0.3),
    ]
}

/// A reduced random walk of at most `steps` letters; shorter where it runs into a dead end.
fn walk(mesh: &SurfaceMesh, first: TriangleId, steps: usize, random: &mut Random) -> Vec<HalfedgeId> {
    let mut word: Vec<HalfedgeId> = Vec::new();
    let mut triangle = first;
    while word.len() < steps {
        let back = word.last().and_then(|&h| mesh.twin(h));
        let exits: Vec<HalfedgeId> =
            triangle.halfedges().into_iter().filter(|&h| Some(h) != back && mesh.twin(h).is_some()).collect();
        if exits.is_empty() {
            break;
        }
        word.push(exits[random.below(exits.len())]);
        triangle = entered_triangle(mesh, word[word.len() - 1]);
    }
    word
}

/// The word backwards, from its last triangle to its first.
fn reversed(mesh: &SurfaceMesh, word: &[HalfedgeId]) -> Vec<HalfedgeId> {
    word.iter().rev().map(|&h| mesh.twin(h).expect("a letter has a twin")).collect()
}

fn reduced(mesh: &SurfaceMesh, letters: impl IntoIterator<Item = HalfedgeId>) -> Vec<HalfedgeId> {
    let mut word = Vec::new();
    letters.into_iter().for_each(|letter| push_reduced(mesh, &mut word, letter));
    word
}

#[test]
fn random_walks_come_back_from_their_compact_form() {
    let mut random = Random::new(10);
    for shape in shapes_to_walk() {
        let mesh = shape.mesh();
        for _ in 0..100 {
            let first = TriangleId(random.below(shape.triangles.len()) as u32);
            let steps = random.below(120);
            let word = walk(&mesh, first, steps, &mut random);
            let bits = encode_word(&mesh, &word);
            // Two bits for the first letter, one for each other.
            assert_eq!(bits.len(), if word.is_empty() { 0 } else { word.len() + 1 });
            assert_eq!(decode_word(&mesh, first, &bits), Some(word));
        }
    }
}

#[test]
fn bits_that_are_no_strip_are_refused() {
    let mesh = shapes::grid(3).mesh();
    let first = TriangleId(8);
    assert_eq!(decode_word(&mesh, first, &[]), Some(Vec::new()));
    assert_eq!(decode_word(&mesh, first, &[true]), None, "half a first letter");
    assert_eq!(decode_word(&mesh, first, &[true, true]), None, "there is no side 3");
    let straight_on: Vec<bool> = (0..60).map(|i| i % 2 == 1).collect();
    assert_eq!(decode_word(&mesh, first, &straight_on), None, "over the boundary");
}

#[test]
fn a_walk_and_its_way_back_cancel() {
    let mut random = Random::new(11);
    for shape in shapes_to_walk() {
        let mesh = shape.mesh();
        for _ in 0..50 {
            let first = TriangleId(random.below(shape.triangles.len()) as u32);
            let word = walk(&mesh, first, 40, &mut random);
            let there_and_back = word.iter().copied().chain(reversed(&mesh, &word));
            assert!(reduced(&mesh, there_and_back).is_empty());
            assert_eq!(reduced(&mesh, word.iter().copied()), word, "a reduced word stays");
            // A detour at a random place cancels as well.
            let place = random.below(word.len() + 1);
            let from = triangles_of(&mesh, first, &word)[place];
            let detour = walk(&mesh, from, 10, &mut random);
            let letters = word[..place].iter().copied();
            let letters = letters.chain(detour.iter().copied()).chain(reversed(&mesh, &detour));
            assert_eq!(reduced(&mesh, letters.chain(word[place..].iter().copied())), word);
        }
    }
}

#[test]
fn closed_words_are_reduced_across_their_seam() {
    let shape = shapes::torus(1.0, 0.3, 14, 8);
    let mesh = shape.mesh();
    let mut random = Random::new(12);
    // Once round the tube: a ring that cannot be reduced.
    let picks: Vec<usize> = (0..4).map(|i| 2 * (14 * 2 * i) % shape.triangles.len()).collect();
    let none = Options { filter: Filter::None, ..Options::default() };
    let ring = line(&mesh, &faces(&picks), &closed(none)).route.legs[0].word.clone();
    assert!(ring.len() > 6);
    for _ in 0..30 {
        let mut turned = ring.clone();
        turned.rotate_left(random.below(ring.len()));
        // A tail from elsewhere to the ring and back.
        let tail = walk(&mesh, turned[0].triangle(), 9, &mut random);
        let from_tail = reversed(&mesh, &tail).into_iter().chain(turned.iter().copied()).chain(tail.iter().copied());
        let mut word = reduced(&mesh, from_tail);
        reduce_seam(&mesh, &mut word);
        assert_eq!(word.len(), ring.len());
        let start = word.iter().position(|h| *h == ring[0]).expect("the ring's first letter");
        word.rotate_left(start);
        assert_eq!(word, ring);
    }
}

#[test]
fn a_turn_goes_the_shorter_way_round_a_vertex() {
    for valence in 3..10usize {
        let mesh = shapes::fan(valence, 0.0).mesh();
        let centre = VertexId(0);
        for (from, to) in (0..valence).flat_map(|from| (0..valence).map(move |to| (from, to))) {
            let [from_id, to_id] = [from, to].map(|t| TriangleId(t as u32));
            let word = turn_word(&mesh, centre, from_id, to_id).expect("one fan");
            let apart = from.abs_diff(to);
            assert_eq!(word.len(), apart.min(valence - apart));
            assert!(word.iter().all(|&h| mesh.touches(h, centre)));
            assert_eq!(triangles_of(&mesh, from_id, &word).last(), Some(&to_id));
            let back = turn_word(&mesh, centre, to_id, from_id).expect("one fan");
            assert_eq!(back.len(), word.len());
        }
    }
}

#[test]
fn a_turn_never_crosses_a_wall_or_a_boundary() {
    let shape = shapes::finned_grid(8, 0.5);
    let mesh = shape.mesh();
    let middle_row = |i: usize| VertexId((4 * 9 + i) as u32);
    // In the middle of the wall below and above are not connected round the vertex; at its end they are, the long way.
    let [inner, end] = [middle_row(2), middle_row(4)];
    let pairs = |v: VertexId| {
        let all: Vec<TriangleId> =
            (0..128u32).map(TriangleId).filter(|t| shape.triangles[t.index()].contains(&v.0)).collect();
        all.iter().flat_map(|&a| all.iter().map(move |&b| (a, b))).collect::<Vec<_>>()
    };
    let is_above = |t: TriangleId| mesh.dual_graph().barycentre(t).y > 0.5;
    for (a, b) in pairs(inner) {
        assert_eq!(turn_word(&mesh, inner, a, b).is_some(), is_above(a) == is_above(b));
    }
    for (a, b) in pairs(end) {
        assert!(turn_word(&mesh, end, a, b).is_some());
    }
    // At a corner of the square there is an open fan.
    let corner = VertexId(0);
    for (a, b) in pairs(corner) {
        assert!(turn_word(&mesh, corner, a, b).is_some());
    }
}

#[test]
fn whole_turns_are_taken_out_of_a_run() {
    let mesh = shapes::fan(5, 0.0).mesh();
    let first = TriangleId(0).halfedges().into_iter().find(|&h| mesh.touches(h, VertexId(0))).expect("a spoke");
    let mut letters = vec![first];
    for k in 1..17 {
        let entered = mesh.twin(letters[k - 1]).expect("an inner edge");
        letters.push(mesh.other_spoke(entered, VertexId(0)));
    }
    for k in 1..17 {
        let rest = unwind(&mesh, &letters[..k]);
        assert_eq!(rest.map(|rest| rest.len()), (k >= 5).then_some(k % 5), "{k} of 5 spokes");
    }
}

#[test]
fn lines_come_back_from_their_bytes_and_spoiled_bytes_never_panic() {
    let mut random = Random::new(13);
    let shape = shapes::hills(14, 7);
    let mesh = shape.mesh();
    for (name, options) in filters() {
        let picks = faces(&[3, 150, 300, 90]);
        for options in
            [options.clone(), all_pinned(options.clone()), closed(options.clone()), closed(all_pinned(options))]
        {
            // The checker has compared the line that comes back.
            let Ok(line) = try_line(&mesh, &picks, &options) else { continue };
            let bytes = line.to_bytes(&mesh);
            for cut in [0, 3, 8, bytes.len() - 1] {
                assert!(Polyline::from_bytes(&mesh, &bytes[..cut]).is_err(), "{name}: {cut} bytes");
            }
            assert!(
                Polyline::from_bytes(&mesh, &[bytes.as_slice(), &[0]].concat()).is_err(),
                "{name}: a byte too many"
            );
            for _ in 0..200 {
                let mut spoiled = bytes.clone();
                let place = random.below(bytes.len());
                spoiled[place] ^= 1 << random.below(8);
                // Refused, or a line that keeps all promises but one: parameters that are one bit off may make equal points.
                if let Ok(other) = Polyline::from_bytes(&mesh, &spoiled) {
                    let fault = check_polyline(&mesh, &other).err();
                    assert!(matches!(fault, None | Some(CheckError::PointsEqual { .. })), "{name}: {fault:?}");
                }
            }
            let other_mesh = shapes::hills(13, 7).mesh();
            assert!(Polyline::from_bytes(&other_mesh, &bytes).is_err(), "{name}: another mesh");
        }
    }
}

#[test]
fn a_figure_eight_keeps_both_lobes_under_the_cubic() {
    for seed in 1..=6 {
        let shape = shapes::hills(60, seed);
        let mesh = shape.mesh();
        let picks: Vec<usize> = (0..12)
            .map(|i| {
                let (sin, cos) = (std::f64::consts::TAU * f64::from(i) / 12.0 + 0.1).sin_cos();
                shape.nearest(DVec3::new(0.5 + 0.35 * sin, 0.5 + 0.35 * sin * cos, 0.0))
            })
            .collect();
        for threshold in [1e-2, 1e-3, 1e-4] {
            let options = closed(Options { threshold, ..cubic() });
            let start = line(&mesh, &faces(&picks), &step_b(&options));
            let made = line(&mesh, &faces(&picks), &options);
            let share = made.length() / start.length();
            assert!(share > 0.8, "seed {seed}, {threshold}: {share} of step B's line is left");
        }
    }
}
