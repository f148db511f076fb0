//! What the integration tests share: made meshes, readers of mesh files, random numbers, and lines that are checked.
//!
//! Holds no tests. Every test binary uses a part of it.
#![allow(dead_code, reason = "each test binary uses a part")]

pub mod files;
pub mod random;
pub mod raw;
pub mod shapes;

use smooth_polylines_core::check::check_polyline;
use smooth_polylines_core::smooth::polyline;
use smooth_polylines_core::{Error, Filter, NoObserver, Options, Pick, Pinned, Polyline, Solver, SurfaceMesh};

/// Picks by triangle id.
pub fn faces(ids: &[usize]) -> Vec<Pick> {
    ids.iter().map(|&id| Pick::Face(id as i128)).collect()
}

/// A pick at barycentric parts of a triangle.
pub fn at(triangle: usize, barycentric: [f64; 3]) -> Pick {
    Pick::Point { triangle: triangle as i128, barycentric }
}

/// Every way to smooth a line, with names for messages. A new filter belongs in here.
pub fn filters() -> Vec<(&'static str, Options)> {
    let of = |filter| Options { filter, ..Options::default() };
    vec![
        ("none", of(Filter::None)),
        ("linear", of(Filter::Linear)),
        ("linear by heap", Options { solver: Solver::Heap, threshold: 1e-3, ..of(Filter::Linear) }),
        ("cubic", Options { threshold: 1e-2, ..of(Filter::Cubic) }),
        ("geodesic", of(Filter::Geodesic)),
        ("fair", of(Filter::Fair)),
    ]
}

/// The paper's `linear` filter by its heap.
pub fn heap(threshold: f64) -> Options {
    Options { filter: Filter::Linear, solver: Solver::Heap, threshold, ..Options::default() }
}

/// The `cubic` filter with the threshold that the counters are pinned for.
pub fn cubic() -> Options {
    Options { filter: Filter::Cubic, threshold: 1e-2, ..Options::default() }
}

/// The `geodesic` filter.
pub fn geodesic() -> Options {
    Options { filter: Filter::Geodesic, ..Options::default() }
}

/// The `fair` filter.
pub fn fair() -> Options {
    Options { filter: Filter::Fair, ..Options::default() }
}

/// The same options for a closed line.
pub fn closed(options: Options) -> Options {
    Options { closed: true, ..options }
}

/// The same options with every pick pinned.
pub fn all_pinned(options: Options) -> Options {
    Options { pinned: Pinned::All, ..options }
}

/// The same options for step B alone.
pub fn step_b(options: &Options) -> Options {
    Options { filter: Filter::None, solver: Solver::Auto, detail_size: None, ..options.clone() }
}

/// A line that must be made, and that keeps every promise.
pub fn line(mesh: &SurfaceMesh, picks: &[Pick], options: &Options) -> Polyline {
    try_line(mesh, picks, options).unwrap_or_else(|error| panic!("{picks:?} {options:?}: {error}"))
}

/// A line that keeps every promise, or why there is none.
pub fn try_line(mesh: &SurfaceMesh, picks: &[Pick], options: &Options) -> Result<Polyline, Error> {
    let line = polyline(mesh, picks, options, &mut NoObserver)?;
    if let Err(error) = check_polyline(mesh, &line) {
        panic!("{picks:?} {options:?}: {error}");
    }
    check_pins(mesh, picks, options, &line);
    Ok(line)
}

/// The line's pins are the caller's, as many as there are different pinned picks in a row.
fn check_pins(mesh: &SurfaceMesh, picks: &[Pick], options: &Options, line: &Polyline) {
    let points: Vec<_> = picks.iter().map(|pick| mesh.resolve_pick(0, pick).expect("a legal pick")).collect();
    let is_pinned = |i: usize| match &options.pinned {
        Pinned::All => true,
        Pinned::Ends => !options.closed && (i == 0 || i + 1 == points.len()),
        Pinned::Each(flags) => flags[i],
    };
    for (i, point) in points.iter().enumerate().filter(|&(i, _)| is_pinned(i)) {
        let position = mesh.position_of(point);
        let nearest = line.points.iter().map(|p| p.distance(position)).fold(f64::INFINITY, f64::min);
        assert_eq!(nearest, 0.0, "pick {i} is pinned and {nearest} off the line: {picks:?} {options:?}");
    }
}
