//! What a line keeps of how it was made, so that it can be made again where picks have changed, and taken over elsewhere.
//!
//! Holds no smoothing: `remake` takes it up.

use std::sync::Arc;

use glam::DVec3;

use crate::ids::TriangleId;
use crate::join::Station;
use crate::leg::Leg;
use crate::mesh::SurfaceMesh;
use crate::options::Options;
use crate::polyline::Polyline;
use crate::report::StopReason;
use crate::route::Route;
use crate::surface_point::SurfacePoint;

/// A line and what it keeps.
#[derive(Clone, Debug)]
pub struct Made {
    /// The line.
    pub line: Polyline,
    /// For the line with other picks.
    pub kept: Kept,
}

/// See the module.
#[derive(Clone, Debug)]
pub struct Kept {
    /// What was asked for.
    pub options: Options,
    /// The picks, equal neighbours merged.
    pub stations: Vec<Station>,
    /// What was known of each leg: of the route, for `fair` of its input.
    pub notes: Vec<LegNote>,
    /// `fair` alone.
    pub fair: KeptFair,
}

/// See [`Kept::fair`].
#[derive(Clone, Debug, Default)]
pub struct KeptFair {
    /// The legs of the input, the straightest line through all picks.
    pub input: Vec<Leg>,
    /// For each leg of the line when it was made. Empty: all with the pins that the line has.
    pub made_at: Vec<MadeAt>,
}

/// When a leg of a `fair` line was made, for which all picks count.
#[derive(Clone, Debug)]
pub struct MadeAt {
    /// Where all pins of the line were; there are as many as now.
    pub pins: Arc<[DVec3]>,
    /// How far the leg may have come off before, as picks came or went, in the units of the positions.
    pub off: f64,
}

/// What is known of a leg besides its word.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct LegNote {
    /// What it was before any smoothing.
    pub start: LegStart,
    /// How its smoothing ended.
    pub stop_reason: StopReason,
}

/// A leg as step B made it.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct LegStart {
    /// The triangle that it starts in.
    pub first: TriangleId,
    /// The triangle that it ends in.
    pub last: TriangleId,
    /// How many letters it has.
    pub letters: usize,
    /// Its length through the midpoints, in the units of the positions; 0 of `none`, which stays as it was made.
    pub length: f64,
}

impl LegStart {
    /// Of leg `i` of a route; without a length where nothing pins it.
    pub fn of_leg(mesh: &SurfaceMesh, route: &Route, i: usize) -> Self {
        let ends: Option<[&SurfacePoint; 2]> = route.start_pin(i).zip(route.end_pin(i)).map(Into::into);
        let length = ends.map_or(0.0, |[a, b]| route.legs[i].length(mesh, a, b));
        Self { length, ..Self::without_length(mesh, &route.legs[i]) }
    }

    /// Of a leg that stays as it was made.
    pub fn without_length(mesh: &SurfaceMesh, leg: &Leg) -> Self {
        Self { first: leg.first, last: leg.last_triangle(mesh), letters: leg.word.len(), length: 0.0 }
    }
}
