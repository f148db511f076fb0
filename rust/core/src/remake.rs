//! A line with other picks, made from the line before: what the change does not touch is taken over.
//!
//! ```text
//!     o-----o-----o-----o-----o       The legs between pins that are the same on both lines are kept; those at the
//!                  \   /              pick that moved, were removed or came new are made again. `none`, `linear`,
//!                   \ /               `geodesic`: the line is that of `smooth::polyline`, to the bit.
//!                    o
//! ```
//!
//! - `cubic`: a leg does know of the next ones, two crossings at a time. New legs begin at the midpoints of their strips,
//!   kept ones where they are; a crossing moves where it is further than the threshold from its place. A draft: the threshold
//!   is no finer than `sliding_stages` says.
//! - `fair`: legs of its input are kept; the curve is made again near the change, as a draft: with half of the samples and
//!   larger tolerances (`fair_again`).
//!
//! The result depends on the line before and the picks alone. Holds which legs are kept; the rest is in `smooth`.

use crate::error::Result;
use crate::fair_again::FairBefore;
use crate::ids::TriangleId;
use crate::join::{Input, Station, all_pinned, join_stretch, place_picks};
use crate::kept::{Kept, LegNote, Made};
use crate::leg::Leg;
use crate::mesh::SurfaceMesh;
use crate::options::{Filter, Options, Pinned};
use crate::polyline::Polyline;
use crate::report::{Observer, Report, Step};
use crate::route::Route;
use crate::smooth::{go_on, polyline_kept, smooth_input};
use crate::surface_point::{Pick, SurfacePoint};

/// The line `line`, of which `before` was kept, with `picks` instead of its own; `pinned` where the flags change too. See
/// the module.
///
/// # Errors
/// As `smooth::polyline`.
pub fn with_picks(
    mesh: &SurfaceMesh,
    line: &Polyline,
    before: &Kept,
    picks: &[Pick],
    pinned: Option<Pinned>,
    observer: &mut dyn Observer,
) -> Result<Made> {
    let options = Options { pinned: pinned.unwrap_or_else(|| before.options.pinned.clone()), ..before.options.clone() };
    options.check()?;
    go_on(observer, Step::Search)?;
    let stations = place_picks(mesh, picks, &options)?;
    let (Some(old), Some(new)) = (Legs::of(before, &before.stations), Legs::of(before, &stations)) else {
        return polyline_kept(mesh, picks, &options, observer);
    };
    let old_legs = if options.filter == Filter::Fair { &before.fair.input } else { &line.route.legs };
    let mut report = Report::default();
    let mut route = Route { closed: options.closed, pins: new.pins(), legs: Vec::new() };
    let find = |i: usize| old.find(&new, i).filter(|&k| k < old_legs.len());
    let same: Vec<Option<usize>> = (0..new.count()).map(find).collect();
    let known: Vec<Option<LegNote>> = same.iter().map(|k| k.map(|k| before.notes[k])).collect();
    for (i, k) in same.iter().enumerate() {
        route.legs.push(match *k {
            Some(k) => old_legs[k].clone(),
            None => make_leg(mesh, &new.stretch(i), &options, &mut report, observer)?,
        });
    }
    let mut is_pinned = vec![true; route.pins.len()];
    if options.filter == Filter::Fair {
        is_pinned = stations.iter().map(|s| s.is_pinned).collect();
    }
    let input = Input { route, is_pinned, is_drawn: false, known };
    let fair_before = FairBefore {
        route: &line.route,
        kept: &before.fair,
        shift: shift_between(mesh, &before.stations, &stations),
        same: &same,
    };
    let (line, notes, fair) = smooth_input(mesh, input, Some(&fair_before), &options, report, observer)?;
    Ok(Made { line, kept: Kept { options, stations, notes, fair } })
}

/// How far the furthest pick has moved, where all are there still; in the units of the positions.
fn shift_between(mesh: &SurfaceMesh, old: &[Station], new: &[Station]) -> Option<f64> {
    let distance = |(a, b): (&Station, &Station)| mesh.position_of(&a.point).distance(mesh.position_of(&b.point));
    (old.len() == new.len()).then(|| old.iter().zip(new).map(distance).fold(0.0, f64::max))
}

/// The leg through a stretch of stations, of which the first and the last alone are pinned.
fn make_leg(
    mesh: &SurfaceMesh,
    stretch: &[Station],
    options: &Options,
    report: &mut Report,
    observer: &mut dyn Observer,
) -> Result<Leg> {
    let open = Options { closed: false, ..options.clone() };
    let mut route = join_stretch(mesh, stretch, &open, report, observer)?;
    // A closed line through one pin and picks that are none has its one leg from the pin to itself.
    Ok(route.legs.pop().unwrap_or_else(|| Leg::empty(stretch.first().map_or(TriangleId(0), |s| s.point.triangle))))
}

/// The stations of a line, and where its legs begin.
struct Legs {
    closed: bool,
    stations: Vec<Station>,
    /// Places of the pinned ones.
    pins: Vec<usize>,
}

impl Legs {
    /// `None` for a closed line without pins, which is one leg and nothing to keep.
    fn of(kept: &Kept, stations: &[Station]) -> Option<Self> {
        let is_fair = kept.options.filter == Filter::Fair;
        let stations = if is_fair { all_pinned(stations) } else { stations.to_vec() };
        let pins: Vec<usize> = (0..stations.len()).filter(|&i| stations[i].is_pinned).collect();
        (!pins.is_empty()).then_some(Self { closed: kept.options.closed, stations, pins })
    }

    fn count(&self) -> usize {
        if self.closed { self.pins.len() } else { self.pins.len() - 1 }
    }

    fn pins(&self) -> Vec<SurfacePoint> {
        self.pins.iter().map(|&i| self.stations[i].point).collect()
    }

    /// The stations of leg `i`, both pins included.
    fn stretch(&self, i: usize) -> Vec<Station> {
        let count = self.stations.len();
        let (start, end) = (self.pins[i], self.pins[(i + 1) % self.pins.len()]);
        let end = if end > start { end } else { end + count };
        (start..=end).map(|k| self.stations[k % count]).collect()
    }

    /// Which leg of this line goes through the same points as leg `i` of `other`: the one at the same place if it does.
    fn find(&self, other: &Self, i: usize) -> Option<usize> {
        let sought = other.stretch(i);
        let is_same = |&k: &usize| {
            let stretch = self.stretch(k);
            let points = stretch.iter().zip(&sought);
            stretch.len() == sought.len() && points.into_iter().all(|(a, b)| a.point == b.point)
        };
        let from_start = self.pins.len() as isize - other.pins.len() as isize;
        let likely = [Some(i), i.checked_add_signed(from_start)].into_iter().flatten().filter(|&k| k < self.count());
        likely.chain(0..self.count()).find(is_same)
    }
}
