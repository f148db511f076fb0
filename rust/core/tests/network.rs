//! Networks: the same lines and the same reports from any number of threads, also where landmarks are chosen on the way.

mod support;

use rayon::ThreadPoolBuilder;
use smooth_polylines_core::network::network;
use smooth_polylines_core::{Filter, NoObserver, Options, Polyline};
use support::random::Random;
use support::{faces, shapes};

#[test]
fn reports_do_not_tell_how_many_threads_there_were() {
    // Large enough for landmarks, which are due after 32 searches of the whole mesh.
    let shape = shapes::icosphere(6);
    let mut random = Random::new(5);
    let picks: Vec<usize> = (0..24).map(|_| random.below(shape.triangles.len())).collect();
    let pairs: Vec<[i128; 2]> = (0..24).flat_map(|i| (0..i).map(move |j| [i, j])).collect();
    let options = Options { filter: Filter::None, ..Options::default() };
    let by_threads = |count: usize| -> Vec<Polyline> {
        let mesh = shape.mesh();
        let pool = ThreadPoolBuilder::new().num_threads(count).build().expect("threads");
        let made = pool.install(|| network(&mesh, &faces(&picks), &pairs, &options, |_| NoObserver)).expect("lines");
        made.into_iter().map(|(line, _)| line.expect("a line")).collect()
    };
    let lines = by_threads(1);
    assert_eq!(lines.len(), 276);
    for count in [2, 5] {
        assert!(by_threads(count) == lines, "{count} threads make other lines or reports");
    }
    let pops = |lines: &[Polyline]| lines.iter().map(|line| line.report.pops).sum::<u64>() / lines.len() as u64;
    let (first, last) = (pops(&lines[..16]), pops(&lines[lines.len() - 16..]));
    assert!(4 * last < first, "landmarks were chosen on the way: {first} pops a line, then {last}");
}
