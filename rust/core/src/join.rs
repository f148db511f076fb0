//! Steps A and B: picks become pins, and strips between them become a route through midpoints.
//!
//! Holds the rules of the contract about picks (equal ones, closed lines, which are pinned). Does no smoothing.

use crate::error::{Error, OptionError, Result};
use crate::ids::{HalfedgeId, TriangleId};
use crate::kept::LegNote;
use crate::leg::Leg;
use crate::mesh::SurfaceMesh;
use crate::options::{Filter, Options, Pinned, Solver};
use crate::report::{Observer, Report};
use crate::route::Route;
use crate::search::SearchEnd;
use crate::spot::{Spot, join_at, spot_of, triangles_round};
use crate::surface_point::{Pick, SurfacePoint};
use crate::window_search::find_taut_strip;

/// A pick, or a point of a stroke, that was resolved and is different from the one before it.
#[derive(Clone, Copy, Debug)]
pub struct Station {
    /// Where it is.
    pub point: SurfacePoint,
    /// Whether the line passes through it exactly.
    pub is_pinned: bool,
    /// Position in the caller's `picks` or `points`, for messages.
    pub pick_index: usize,
}

/// What steps A and B make of picks or of a stroke.
#[derive(Clone, PartialEq, Debug)]
pub struct Input {
    /// The route through midpoints, or along the stroke.
    pub route: Route,
    /// Which of its pins are pinned: all, but for `fair`, for whose input all picks are pins of the route.
    pub is_pinned: Vec<bool>,
    /// Whether the route's own crossings are what `fair` is close to; else it is the straightest line through its pins.
    pub is_drawn: bool,
    /// What is known of each leg that was smoothed already.
    pub known: Vec<Option<LegNote>>,
}

impl Input {
    /// A route of which nothing was smoothed yet, all of whose pins are pinned.
    pub fn new(route: Route, is_drawn: bool) -> Self {
        Self { is_pinned: vec![true; route.pins.len()], is_drawn, known: vec![None; route.legs.len()], route }
    }
}

/// The picks as stations.
///
/// # Errors
/// Picks that are out of range or too few, `pinned` that does not fit.
pub fn place_picks(mesh: &SurfaceMesh, picks: &[Pick], options: &Options) -> Result<Vec<Station>> {
    let points = picks.iter().enumerate().map(|(i, pick)| mesh.resolve_pick(i, pick)).collect::<Result<Vec<_>, _>>()?;
    place_stations(mesh, &points, "picks", options)
}

/// Joins picks by step B into a route through midpoints, and notes pops in `report`.
///
/// # Errors
/// Picks that are not connected, and [`Error::Interrupted`].
pub fn join_picks(
    mesh: &SurfaceMesh,
    stations: &[Station],
    options: &Options,
    report: &mut Report,
    observer: &mut dyn Observer,
) -> Result<Input> {
    if options.filter != Filter::Fair {
        return Ok(Input::new(join_stretch(mesh, stations, options, report, observer)?, false));
    }
    let route = join_stretch(mesh, &all_pinned(stations), options, report, observer)?;
    Ok(Input { is_pinned: stations.iter().map(|s| s.is_pinned).collect(), ..Input::new(route, false) })
}

/// The stations with every one pinned: the input of `fair` goes through all picks.
pub fn all_pinned(stations: &[Station]) -> Vec<Station> {
    stations.iter().map(|&station| Station { is_pinned: true, ..station }).collect()
}

/// The route through the midpoints of the strips between stations, which may be a stretch of the line's.
///
/// # Errors
/// As [`join_picks`].
pub fn join_stretch(
    mesh: &SurfaceMesh,
    stations: &[Station],
    options: &Options,
    report: &mut Report,
    observer: &mut dyn Observer,
) -> Result<Route> {
    let is_taut = is_straightened(options);
    let midpoint = |_: &SurfacePoint, _: HalfedgeId| 0.5;
    join_stations(mesh, stations, options.closed, midpoint, |i, j, _| {
        let found = if is_taut && stations[i].is_pinned && stations[j].is_pinned {
            find_taut_strip(mesh, &stations[i].point, &stations[j].point, observer)?
        } else {
            let [from, to] = [i, j].map(|k| search_end(mesh, &stations[k].point));
            mesh.dual_graph().find_strip(&from, &to, observer)?
        };
        let found = found.ok_or_else(|| no_path(mesh, "picks", &stations[i], &stations[j]))?;
        report.pops += found.pops;
        Ok(Leg::through_midpoints(found.first, found.word))
    })
}

/// Whether the line will be straightened first, so that it may start from any strip. The paper's filters keep the paper's
/// dual path: what they end at depends on where they start.
fn is_straightened(options: &Options) -> bool {
    match options.filter {
        Filter::Geodesic | Filter::Fair => true,
        Filter::Linear => options.solver == Solver::Auto,
        Filter::Cubic | Filter::None => false,
    }
}

/// The refusal of two stations that are not connected.
pub fn no_path(mesh: &SurfaceMesh, argument: &'static str, first: &Station, second: &Station) -> Error {
    Error::NoPath { argument, first: first.pick_index, second: second.pick_index, parts: mesh.report().parts }
}

/// Points of a line as stations: equal neighbours merged, pins noted, counts checked. `argument` is what messages call
/// the points.
pub fn place_stations(
    mesh: &SurfaceMesh,
    points: &[SurfacePoint],
    argument: &'static str,
    options: &Options,
) -> Result<Vec<Station>> {
    if points.is_empty() {
        let message = match argument {
            "picks" => "found none, expected at least one; pass face ids or surface points",
            _ => "found none, expected at least one; pass points near the surface",
        };
        return Err(OptionError::new(argument, message).into());
    }
    let flags = pin_flags(points.len(), argument, options)?;
    let mut stations: Vec<Station> = Vec::with_capacity(points.len());
    for (pick_index, (&point, &is_pinned)) in points.iter().zip(&flags).enumerate() {
        match stations.last_mut() {
            Some(last) if is_same_place(mesh, &last.point, &point) => last.is_pinned |= is_pinned,
            _ => stations.push(Station { point, is_pinned, pick_index }),
        }
    }
    if options.closed {
        if stations.len() > 1 && is_same_place(mesh, &stations[0].point, &stations[stations.len() - 1].point) {
            let last = stations.pop();
            stations[0].is_pinned |= last.is_some_and(|s| s.is_pinned);
        }
        let is_new = |i: usize| !stations[..i].iter().any(|s| is_same_place(mesh, &s.point, &stations[i].point));
        let distinct = (0..stations.len()).filter(|&i| is_new(i)).take(3).count();
        if distinct < 3 {
            return Err(OptionError::new(
                argument,
                format!(
                    "a closed line needs at least 3 different {argument}, found {distinct}; add {argument} or use closed=False"
                ),
            )
            .into());
        }
    }
    Ok(stations)
}

fn is_same_place(mesh: &SurfaceMesh, a: &SurfacePoint, b: &SurfacePoint) -> bool {
    match (spot_of(mesh, a), spot_of(mesh, b)) {
        (Spot::Inside(_), Spot::Inside(_)) => a == b,
        (x, y) => x == y,
    }
}

/// One flag a pick; the ends of an open line are always pinned.
fn pin_flags(count: usize, argument: &str, options: &Options) -> Result<Vec<bool>, OptionError> {
    let is_end = |i: usize| !options.closed && (i == 0 || i + 1 == count);
    match &options.pinned {
        Pinned::Ends => Ok((0..count).map(is_end).collect()),
        Pinned::All => Ok(vec![true; count]),
        Pinned::Each(flags) if flags.len() != count => Err(OptionError::new(
            "pinned",
            format!("found {} flags for {count} {argument}, expected one each, or \"ends\" or \"all\"", flags.len()),
        )),
        Pinned::Each(flags) => match flags.iter().enumerate().find(|&(i, &flag)| is_end(i) && !flag) {
            Some((i, _)) => Err(OptionError::new(
                "pinned",
                format!(
                    "flag {i} is False, but the ends of an open line are always pinned; pass True there or closed=True"
                ),
            )),
            None => Ok(flags.clone()),
        },
    }
}

/// Where a search from or to a point may start or end.
pub fn search_end(mesh: &SurfaceMesh, point: &SurfacePoint) -> SearchEnd {
    let triangles = triangles_round(mesh, point);
    let anchor =
        if triangles.len() == 1 { mesh.dual_graph().barycentre(triangles[0]) } else { mesh.position_of(point) };
    SearchEnd { triangles, anchor }
}

/// The route through stations. `join(i, j, triangle)` gives the stretch from station `i` to `j`, which may start in any
/// triangle that holds `i`, best in the one that the line is in; `turn_parameter` where a letter is crossed that only
/// leads round a station.
pub fn join_stations(
    mesh: &SurfaceMesh,
    stations: &[Station],
    closed: bool,
    turn_parameter: impl Fn(&SurfacePoint, HalfedgeId) -> f64,
    mut join: impl FnMut(usize, usize, Option<TriangleId>) -> Result<Leg>,
) -> Result<Route> {
    let count = stations.len();
    // Start at a pin, so that every leg runs from pin to pin; a closed line without pins starts at its first station.
    let start = stations.iter().position(|s| s.is_pinned).unwrap_or(0);
    let pins: Vec<SurfacePoint> =
        (0..count).map(|i| &stations[(start + i) % count]).filter(|s| s.is_pinned).map(|s| s.point).collect();
    let turn = |leg: &mut Leg, point: &SurfacePoint, to: TriangleId| {
        for letter in join_at(mesh, point, leg.last_triangle(mesh), to).unwrap_or_default() {
            leg.push(mesh, letter, turn_parameter(point, letter));
        }
    };
    let mut legs: Vec<Leg> = Vec::new();
    let steps = if closed { count } else { count - 1 };
    for step in 0..steps {
        let (i, j) = ((start + step) % count, (start + step + 1) % count);
        let triangle = legs.last().map(|leg| leg.last_triangle(mesh));
        let next = join(i, j, triangle)?;
        match legs.last_mut() {
            Some(leg) if !stations[i].is_pinned => {
                turn(leg, &stations[i].point, next.first);
                for (&letter, &parameter) in next.word.iter().zip(&next.parameters) {
                    leg.push(mesh, letter, parameter);
                }
            }
            _ => legs.push(next),
        }
    }
    if let (true, true, Some(leg)) = (closed, pins.is_empty(), legs.first_mut()) {
        let first = leg.first;
        turn(leg, &stations[start].point, first);
        leg.reduce_seam(mesh);
        if leg.word.is_empty() {
            return Err(Error::Collapsed { iterations: 0 });
        }
        debug_assert_eq!(Some(leg.last_triangle(mesh)), leg.word.first().map(|h| h.triangle()));
    }
    for leg in &mut legs {
        if let Some(&letter) = leg.word.first() {
            leg.first = letter.triangle();
        }
    }
    Ok(Route { closed, pins, legs })
}
