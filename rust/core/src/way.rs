//! A line of a net that is led along a way: smoothed as freely as its neighbours allow.
//!
//! Smoothing knows no other lines and may slide back over them, or up to their ends. Then more and more places of the way are
//! held, until the line keeps clear; the way itself does. Looks for no ways.

use glam::DVec3;

use crate::embed::crossings::Crossing;
use crate::error::{Error, Result};
use crate::join::Input;
use crate::mesh::SurfaceMesh;
use crate::opened::Way;
use crate::options::{Filter, Options, Pinned};
use crate::polyline::Polyline;
use crate::report::{Observer, Report};
use crate::smooth::smooth_input;
use crate::stroke::{StrokePoints, join_stroke};
use crate::surface_point::{Pick, SurfacePoint};
use crate::untangle::find_transversal;

/// Places of a way that are held at first, and so on.
const HELD: [usize; 6] = [0, 1, 3, 7, 15, 31];

/// A line keeps this part of the distance that its way has from the ends of other lines, where it can.
const KEPT: f64 = 0.4;

/// Makes line `line` follow a way, if `is_good` finds the net and its crossings good then. Returns these, or `None` with nothing
/// changed.
///
/// # Errors
/// [`Error::Interrupted`], and what [`find_transversal`] may raise.
pub fn follow(
    mesh: &SurfaceMesh,
    lines: &mut [Option<Polyline>],
    line: usize,
    way: &Way,
    options: &Options,
    is_good: impl Fn(&[Option<Polyline>], &[Crossing]) -> bool,
    observer: &mut dyn Observer,
) -> Result<Option<Vec<Crossing>>> {
    let ends = ends_of_others(
        lines,
        line,
        mesh.position_of(&way.points[0]),
        mesh.position_of(&way.points[way.points.len() - 1]),
    );
    let places: Vec<DVec3> = way.points.iter().map(|point| mesh.position_of(point)).collect();
    let wanted: Vec<f64> = ends.iter().map(|&end| KEPT * distance_from(&places, end)).collect();
    let mut close = None;
    let exact = Options { filter: Filter::Geodesic, detail_size: None, ..options.clone() };
    let held = HELD.iter().map(|&count| (hold(mesh, &way.points, count), options));
    for (pinned, options) in held.chain([(Pinned::All, &exact)]) {
        let Some(made) = lead(mesh, &way.points, pinned, options, observer)? else { continue };
        let is_clear = ends.iter().zip(&wanted).all(|(&end, &wanted)| distance_from(&made.points, end) >= wanted);
        if !is_clear && close.is_some() {
            continue;
        }
        let before = lines[line].replace(made);
        let crossings = find_transversal(mesh, lines)?;
        let is_good = is_good(lines, &crossings);
        if is_good && is_clear {
            return Ok(Some(crossings));
        }
        let made = std::mem::replace(&mut lines[line], before);
        if is_good {
            close = Some((made, crossings));
        }
    }
    Ok(close.map(|(made, crossings)| {
        lines[line] = made;
        crossings
    }))
}

/// The ends of the other lines, less those that are this one's too.
fn ends_of_others(lines: &[Option<Polyline>], line: usize, first: DVec3, last: DVec3) -> Vec<DVec3> {
    let others = lines.iter().enumerate().filter(|&(i, _)| i != line).filter_map(|(_, other)| other.as_ref());
    let ends = others.flat_map(|other| [other.points[0], other.points[other.points.len() - 1]]);
    ends.filter(|&end| end != first && end != last).collect()
}

/// Distance of a place from a chain of points, in space.
fn distance_from(points: &[DVec3], place: DVec3) -> f64 {
    let of_segment = |pair: &[DVec3]| {
        let along = pair[1] - pair[0];
        let square = along.length_squared();
        let t = if square > 0.0 { ((place - pair[0]).dot(along) / square).clamp(0.0, 1.0) } else { 0.0 };
        place.distance(pair[0] + t * along)
    };
    points.windows(2).map(of_segment).fold(f64::INFINITY, f64::min)
}

/// Pins at both ends and at `count` places between, evenly along the way.
fn hold(mesh: &SurfaceMesh, points: &[SurfacePoint], count: usize) -> Pinned {
    let places: Vec<_> = points.iter().map(|point| mesh.position_of(point)).collect();
    let steps = places.windows(2).map(|pair| pair[0].distance(pair[1]));
    let along: Vec<f64> = std::iter::once(0.0)
        .chain(steps.scan(0.0, |sum, step| {
            *sum += step;
            Some(*sum)
        }))
        .collect();
    let (last, whole) = (points.len() - 1, along[along.len() - 1]);
    let mut pins = vec![false; points.len()];
    (pins[0], pins[last]) = (true, true);
    for i in 1..=count {
        let wanted = whole * i as f64 / (count + 1) as f64;
        pins[along.partition_point(|&s| s < wanted).min(last)] = true;
    }
    Pinned::Each(pins)
}

/// The smoothed line along `points`; `None` where it cannot be made.
///
/// # Errors
/// [`Error::Interrupted`].
pub fn lead(
    mesh: &SurfaceMesh,
    points: &[SurfacePoint],
    pinned: Pinned,
    options: &Options,
    observer: &mut dyn Observer,
) -> Result<Option<Polyline>> {
    let pick = |point: &SurfacePoint| Pick::Point { triangle: point.triangle.0.into(), barycentric: point.barycentric };
    let picks = StrokePoints::Surface(points.iter().map(pick).collect());
    let options = Options { pinned, ..options.clone() };
    let mut report = Report::default();
    let made = join_stroke(mesh, &picks, &options, &mut report, observer)
        .and_then(|route| smooth_input(mesh, Input::new(route, false), None, &options, report, observer));
    match made {
        Ok((line, ..)) => Ok(Some(line)),
        Err(Error::Interrupted) => Err(Error::Interrupted),
        Err(_) => Ok(None),
    }
}
