//! Steps A and B: picks become pins, and strips between them become a route through midpoints.
//!
//! Holds the rules of the contract about picks (equal ones, closed lines, which are pinned). Does no smoothing.

use crate::error::{Error, OptionError, Result};
use crate::mesh::SurfaceMesh;
use crate::options::{Options, Pinned};
use crate::report::{Observer, Report};
use crate::route::{Leg, Route, Spot, join_at, spot_of, triangles_round};
use crate::search::SearchEnd;
use crate::strip::{entered_triangle, push_reduced, reduce_seam};
use crate::surface_point::{Pick, SurfacePoint};

/// A pick that was resolved and is different from the one before it.
#[derive(Clone, Copy, Debug)]
struct Station {
    point: SurfacePoint,
    is_pinned: bool,
    /// Position in the caller's `picks`, for messages.
    pick_index: usize,
}

/// Joins picks by step B into a route through midpoints, and notes pops in `report`.
///
/// # Errors
/// Picks that are out of range or too few, `pinned` that does not fit, picks that are not connected, and
/// [`Error::Interrupted`].
pub fn join_picks(
    mesh: &SurfaceMesh,
    picks: &[Pick],
    options: &Options,
    report: &mut Report,
    observer: &mut dyn Observer,
) -> Result<Route> {
    let stations = resolve_stations(mesh, picks, options)?;
    join_stations(mesh, &stations, options.closed, report, observer)
}

fn resolve_stations(mesh: &SurfaceMesh, picks: &[Pick], options: &Options) -> Result<Vec<Station>> {
    if picks.is_empty() {
        return Err(
            OptionError::new("picks", "found none, expected at least one; pass face ids or surface points").into()
        );
    }
    let flags = pin_flags(picks.len(), options)?;
    let mut stations: Vec<Station> = Vec::with_capacity(picks.len());
    for (pick_index, (pick, &is_pinned)) in picks.iter().zip(&flags).enumerate() {
        let point = mesh.resolve_pick(pick_index, pick)?;
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
                "picks",
                format!(
                    "a closed line needs at least 3 different picks, found {distinct}; add picks or use closed=False"
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
fn pin_flags(count: usize, options: &Options) -> Result<Vec<bool>, OptionError> {
    let is_end = |i: usize| !options.closed && (i == 0 || i + 1 == count);
    match &options.pinned {
        Pinned::Ends => Ok((0..count).map(is_end).collect()),
        Pinned::All => Ok(vec![true; count]),
        Pinned::Each(flags) if flags.len() != count => Err(OptionError::new(
            "pinned",
            format!("found {} flags for {count} picks, expected one a pick, or \"ends\" or \"all\"", flags.len()),
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

fn search_end(mesh: &SurfaceMesh, point: &SurfacePoint) -> SearchEnd {
    let triangles = triangles_round(mesh, point);
    let anchor =
        if triangles.len() == 1 { mesh.dual_graph().barycentre(triangles[0]) } else { mesh.position_of(point) };
    SearchEnd { triangles, anchor }
}

fn join_stations(
    mesh: &SurfaceMesh,
    stations: &[Station],
    closed: bool,
    report: &mut Report,
    observer: &mut dyn Observer,
) -> Result<Route> {
    let count = stations.len();
    let ends: Vec<SearchEnd> = stations.iter().map(|s| search_end(mesh, &s.point)).collect();
    // Start at a pin, so that every leg runs from pin to pin; a closed line without pins starts at its first pick.
    let start = stations.iter().position(|s| s.is_pinned).unwrap_or(0);
    let pins: Vec<SurfacePoint> =
        (0..count).map(|i| &stations[(start + i) % count]).filter(|s| s.is_pinned).map(|s| s.point).collect();
    let mut legs: Vec<Leg> = Vec::new();
    let steps = if closed { count } else { count - 1 };
    for step in 0..steps {
        let (i, j) = ((start + step) % count, (start + step + 1) % count);
        let found = mesh.dual_graph().find_strip(&ends[i], &ends[j], observer)?.ok_or_else(|| Error::NoPath {
            first: stations[i].pick_index,
            second: stations[j].pick_index,
            parts: mesh.report().parts,
        })?;
        report.pops += found.pops;
        if step == 0 || stations[i].is_pinned {
            legs.push(Leg::through_midpoints(found.first, found.word));
        } else if let Some(leg) = legs.last_mut() {
            let turn = join_at(mesh, &stations[i].point, leg.last_triangle(mesh), found.first).unwrap_or_default();
            for letter in turn.into_iter().chain(found.word) {
                push_reduced(mesh, &mut leg.word, letter);
            }
        }
    }
    if closed && pins.is_empty() {
        close_leg(mesh, &mut legs[0], &stations[start].point)?;
    }
    for leg in &mut legs {
        leg.parameters = vec![0.5; leg.word.len()];
        if let Some(&letter) = leg.word.first() {
            leg.first = letter.triangle();
        }
    }
    Ok(Route { closed, pins, legs })
}

/// Joins the end of a closed leg without pins to its start and cancels what goes back and forth there.
fn close_leg(mesh: &SurfaceMesh, leg: &mut Leg, seam: &SurfacePoint) -> Result<()> {
    let turn = join_at(mesh, seam, leg.last_triangle(mesh), leg.first).unwrap_or_default();
    for letter in turn {
        push_reduced(mesh, &mut leg.word, letter);
    }
    reduce_seam(mesh, &mut leg.word);
    match leg.word.first() {
        None => Err(Error::Collapsed { iterations: 0 }),
        Some(&letter) => {
            debug_assert_eq!(leg.word.last().map(|&h| entered_triangle(mesh, h)), Some(letter.triangle()));
            Ok(())
        }
    }
}
