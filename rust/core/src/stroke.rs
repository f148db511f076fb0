//! A stroke: many points near the surface, in the order in which they were drawn, instead of a few picks.
//!
//! Each point is moved to the nearest point of the surface. Neighbouring points are joined by a straight walk over it,
//! and where there is none (a break) by step B (the paper, section 4 and figure 5). What is crossed there and back
//! cancels. The result is a route like that of picks, but through the stroke's own crossings of the edges.

use std::ops::ControlFlow;

use glam::DVec3;

use crate::error::{Error, Result};
use crate::ids::{HalfedgeId, TriangleId};
use crate::join::{Input, Station, join_stations, no_path, place_stations, search_end};
use crate::leg::Leg;
use crate::mesh::SurfaceMesh;
use crate::options::Options;
use crate::polyline::Polyline;
use crate::report::{Observer, Report, Step};
use crate::route::Route;
use crate::search::SearchEnd;
use crate::section::{WalkEnd, walk_straight};
use crate::smooth::{go_on, smooth_input};
use crate::spot::{Spot, parameter_at, spot_of};
use crate::surface_point::{Pick, SurfacePoint};

/// What messages call the points of a stroke.
const ARGUMENT: &str = "points";

/// Points that are joined between two calls of the observer: about a millisecond.
const POINTS_PER_OBSERVATION: usize = 512;

/// The points of a stroke, in order.
#[derive(Clone, PartialEq, Debug)]
pub enum StrokePoints {
    /// Points in space, near the surface.
    Space(Vec<DVec3>),
    /// Triangles (or faces) that the stroke ran over, gaps allowed, or points of the surface.
    Surface(Vec<Pick>),
}

/// A smooth line along a stroke.
///
/// # Errors
/// Options or points out of range, points on parts that are not connected, a closed line that collapses, or
/// [`Error::Interrupted`] when the observer says so.
pub fn stroke(
    mesh: &SurfaceMesh,
    points: &StrokePoints,
    options: &Options,
    observer: &mut dyn Observer,
) -> Result<Polyline> {
    options.check()?;
    let mut report = Report::default();
    let route = join_stroke(mesh, points, options, &mut report, observer)?;
    Ok(smooth_input(mesh, Input::new(route, true), None, options, report, observer)?.0)
}

/// The route along a stroke, before any smoothing; notes breaks, the largest distance and pops in `report`.
///
/// # Errors
/// As [`stroke`].
pub fn join_stroke(
    mesh: &SurfaceMesh,
    points: &StrokePoints,
    options: &Options,
    report: &mut Report,
    observer: &mut dyn Observer,
) -> Result<Route> {
    go_on(observer, Step::Search)?;
    let points = project(mesh, points, report, observer)?;
    let stations = place_stations(mesh, &points, ARGUMENT, options)?;
    let ends: Vec<SearchEnd> = stations.iter().map(|s| search_end(mesh, &s.point)).collect();
    let on_station = |point: &SurfacePoint, letter: HalfedgeId| match spot_of(mesh, point) {
        Spot::Vertex(v) => parameter_at(mesh, letter, v),
        Spot::Edge(_, t) => t,
        Spot::Inside(_) => 0.5,
    };
    let mut joined = 0usize;
    join_stations(mesh, &stations, options.closed, on_station, |i, j, triangle| {
        joined += 1;
        if joined % POINTS_PER_OBSERVATION == 0 && observer.step(Step::Search) == ControlFlow::Break(()) {
            return Err(Error::Interrupted);
        }
        join_points(mesh, [&stations[i], &stations[j]], [&ends[i], &ends[j]], triangle, report, observer)
    })
}

/// The stroke on the surface.
fn project(
    mesh: &SurfaceMesh,
    points: &StrokePoints,
    report: &mut Report,
    observer: &mut dyn Observer,
) -> Result<Vec<SurfacePoint>> {
    match points {
        StrokePoints::Space(points) => {
            let found = mesh.closest_points(points, ARGUMENT, observer)?;
            report.stroke_distance = found.iter().map(|f| f.distance).fold(0.0, f64::max);
            Ok(found.into_iter().map(|f| f.point).collect())
        }
        StrokePoints::Surface(picks) => {
            let resolve = |(i, pick)| mesh.resolve_pick(i, pick).map_err(|e| e.about_points().into());
            picks.iter().enumerate().map(resolve).collect()
        }
    }
}

/// The stretch between two neighbouring points, from `triangle` where that holds the first.
fn join_points(
    mesh: &SurfaceMesh,
    stations: [&Station; 2],
    ends: [&SearchEnd; 2],
    triangle: Option<TriangleId>,
    report: &mut Report,
    observer: &mut dyn Observer,
) -> Result<Leg> {
    let [from, to] = [0, 1].map(|i| WalkEnd { point: &stations[i].point, triangles: &ends[i].triangles });
    let is_shared = |t: &TriangleId| from.triangles.contains(t) && to.triangles.contains(t);
    let shared = triangle.filter(is_shared).or_else(|| from.triangles.iter().copied().find(|t| is_shared(t)));
    if let Some(first) = shared {
        return Ok(Leg { first, word: Vec::new(), parameters: Vec::new() });
    }
    if let Some(leg) = walk_straight(mesh, from, to) {
        return Ok(leg);
    }
    let found = mesh.dual_graph().find_strip(ends[0], ends[1], observer)?;
    let found = found.ok_or_else(|| no_path(mesh, ARGUMENT, stations[0], stations[1]))?;
    report.pops += found.pops;
    report.stroke_breaks += 1;
    Ok(Leg::through_midpoints(found.first, found.word))
}
