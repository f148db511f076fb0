//! A span: the locally shortest line between two neighbouring samples of a curve, and how it leaves and arrives.
//!
//! A curve on the surface is held as samples joined by spans; spans know how long they are, in which direction they set
//! out and arrive, and what they bend at mesh vertices on their way (`cone`). Holds one span; the curve is in
//! `filter::fair`.

use glam::{DVec2, DVec3};

use crate::cone::{Cone, Cones};
use crate::error::Result;
use crate::filter::geodesic::GeodesicLeg;
use crate::filter::workspace::Workspace;
use crate::ids::{HalfedgeId, TriangleId};
use crate::leg::Leg;
use crate::mesh::SurfaceMesh;
use crate::pauses::Pauses;
use crate::relax::funnel::cross_portal;
use crate::report::Report;
use crate::spot::{Spot, crossing_position, crossing_spot, spot_of};
use crate::surface_point::SurfacePoint;
use crate::turn::{Heading, flips_winding, turn_at};
use crate::unfold::Unfolding;

/// Rounds of passes for one span; measured spans take a handful.
const MAX_ROUNDS: u32 = 1000;

/// A crossing nearer than this to an end of its portal, relative to the portal, is left to the exact solver.
const CLEARANCE: f64 = 1e-9;

/// See the module. Angles are in radians, positive to the left in the winding of the triangle that they are seen from.
#[derive(Clone, PartialEq, Debug)]
pub struct Span {
    /// The strip and its crossings.
    pub leg: Leg,
    /// In the units of the positions.
    pub length: f64,
    /// How it leaves the first sample; unit length, or zero when the span has no length.
    pub start: Heading,
    /// How it arrives at the second sample.
    pub end: Heading,
    /// What the span turns at mesh vertices on its way, as seen from its start: from the first direction to the chord's.
    pub bend_out: f64,
    /// The same as seen from its end: from the chord's direction to the last.
    pub bend_in: f64,
    /// Whether the triangle at the end has the other winding than the one at the start.
    pub flips: bool,
}

/// Work space of spans; kept for its memory.
#[derive(Debug, Default)]
pub struct SpanWork {
    unfolding: Unfolding,
    geodesic: Workspace,
    /// Mesh vertices near the spans so far.
    pub cones: Cones,
}

impl SpanWork {
    /// Work space that knows some cones.
    pub fn with_cones(cones: Cones) -> Self {
        Self { cones, ..Self::default() }
    }
}

impl Span {
    /// The locally shortest line from `from` to `to` in the strip `leg`, whose parameters play no part, and beyond it
    /// over every vertex that the two-angle rule allows.
    ///
    /// # Errors
    /// [`crate::Error::Interrupted`] at one of the `pauses`.
    pub fn relax(
        mesh: &SurfaceMesh,
        from: &SurfacePoint,
        to: &SurfacePoint,
        leg: Leg,
        work: &mut SpanWork,
        report: &mut Report,
        pauses: &mut Pauses,
    ) -> Result<Self> {
        pauses.tick()?;
        let is_plain = |p: &SurfacePoint| matches!(spot_of(mesh, p), Spot::Inside(_));
        let mut leg = leg;
        if is_plain(from) && is_plain(to) {
            match Self::straight(mesh, from, to, leg, work) {
                Ok(span) => return Ok(span),
                Err(bent) => leg = bent,
            }
            leg = Self::by_passes(mesh, from, to, &leg, work, report, pauses)?;
            match Self::straight(mesh, from, to, leg, work) {
                Ok(span) => return Ok(span),
                Err(bent) => leg = bent,
            }
        } else {
            leg = Self::by_passes(mesh, from, to, &leg, work, report, pauses)?;
        }
        Ok(Self::bent(mesh, from, to, leg))
    }

    /// The span when it is one straight line in its unfolded strip; else the leg back.
    fn straight(
        mesh: &SurfaceMesh,
        from: &SurfacePoint,
        to: &SurfacePoint,
        leg: Leg,
        work: &mut SpanWork,
    ) -> Result<Self, Leg> {
        let (a, b) = (mesh.position_of(from), mesh.position_of(to));
        if leg.word.is_empty() {
            return Ok(Self::within_triangle(mesh, a, b, leg, &mut work.cones));
        }
        let unfolding = &mut work.unfolding;
        unfolding.unfold(mesh, a, &leg.word, b);
        let parameters = straight_crossings(mesh, unfolding, &leg.word);
        let (first, entered) = (leg.word[0], mesh.twin(leg.word[leg.word.len() - 1]));
        let way = unfolding.end - unfolding.start;
        let (Some(parameters), Some(entered), Some(unit)) = (parameters, entered, way.try_normalize()) else {
            return Err(leg);
        };
        let out = in_space(mesh, unfolding, 0, first, -1.0, unit);
        let into = in_space(mesh, unfolding, leg.word.len() - 1, entered, 1.0, unit);
        let (Some(out), Some(into)) = (out, into) else { return Err(leg) };
        let mut span = Self {
            start: Heading { triangle: leg.first, direction: out },
            end: Heading { triangle: entered.triangle(), direction: into },
            flips: flips_along(mesh, &leg.word),
            leg: Leg { parameters, ..leg },
            length: way.length(),
            bend_out: 0.0,
            bend_in: 0.0,
        };
        span.pass_cones(mesh, unit, unfolding, &mut work.cones);
        Ok(span)
    }

    /// A span between two points of one triangle.
    fn within_triangle(mesh: &SurfaceMesh, a: DVec3, b: DVec3, leg: Leg, cones: &mut Cones) -> Self {
        let heading = Heading { triangle: leg.first, direction: (b - a).normalize_or_zero() };
        let leg = Leg { parameters: Vec::new(), ..leg };
        let length = a.distance(b);
        let mut span = Self { leg, length, start: heading, end: heading, bend_out: 0.0, bend_in: 0.0, flips: false };
        let left = mesh.normal(heading.triangle).cross(heading.direction);
        for spoke in heading.triangle.halfedges() {
            let offset = mesh.position(mesh.ends(spoke)[0]) - a;
            let offset = DVec2::new(offset.dot(heading.direction), offset.dot(left));
            span.pass_cone(offset, 1.0, || cones.get(mesh, spoke));
        }
        span
    }

    /// Adds what the vertices of its strip turn a straight span, `unit` being its direction in the plane.
    fn pass_cones(&mut self, mesh: &SurfaceMesh, unit: DVec2, unfolding: &Unfolding, cones: &mut Cones) {
        let last = unfolding.portals.len() - 1;
        let near = mesh.apex(self.leg.word[0]);
        let behind = unfolding.ahead(mesh, unfolding.portals[0], mesh.position(near));
        let far = mesh.apex(mesh.twin(self.leg.word[last]).unwrap_or(self.leg.word[last]));
        let ahead = unfolding.ahead(mesh, unfolding.portals[last], mesh.position(far));
        let own = [(self.leg.first, near, DVec2::new(behind.x, -behind.y)), (self.end.triangle, far, ahead)];
        for i in 0..unfolding.ends.len() + 2 {
            let (triangle, vertex, at) = match unfolding.ends.get(i) {
                Some(end) => (self.leg.word[end.first as usize].triangle(), end.vertex, end.at),
                None => own[i - unfolding.ends.len()],
            };
            let offset = at - unfolding.start;
            let offset = DVec2::new(offset.dot(unit), offset.dot(unit.perp()));
            // The plane shows the first triangle from its back: left there is right in its winding.
            if let Some(spoke) = triangle.halfedges().into_iter().find(|&h| mesh.ends(h)[0] == vertex) {
                self.pass_cone(offset, -1.0, || cones.get(mesh, spoke));
            }
        }
    }

    /// Adds what one vertex near the span turns it. `offset`: along the span, and to the left of it; `sign`: 1 where
    /// that is left in the winding of the span's first triangle.
    fn pass_cone(&mut self, offset: DVec2, sign: f64, cone: impl FnOnce() -> Cone) {
        // What lies behind or ahead belongs to the neighbouring spans.
        if !(0.0..self.length).contains(&offset.x) {
            return;
        }
        let turn = sign * cone().turn(offset.y);
        let share = offset.x / self.length;
        self.bend_out += (1.0 - share) * turn;
        self.bend_in += share * if self.flips { -turn } else { turn };
    }

    /// The leg by funnels and passes.
    fn by_passes(
        mesh: &SurfaceMesh,
        from: &SurfacePoint,
        to: &SurfacePoint,
        leg: &Leg,
        work: &mut SpanWork,
        report: &mut Report,
        pauses: &mut Pauses,
    ) -> Result<Leg> {
        let mut solver = GeodesicLeg::new(mesh, leg, from, to, &mut work.geodesic, report, pauses)?;
        for _ in 0..MAX_ROUNDS {
            if !solver.is_active() {
                break;
            }
            solver.advance(mesh, &mut work.geodesic, report, pauses)?;
        }
        Ok(solver.to_leg(mesh, &mut work.geodesic))
    }

    /// The span of a finished leg that may run through mesh vertices, or begins or ends at one.
    fn bent(mesh: &SurfaceMesh, from: &SurfacePoint, to: &SurfacePoint, leg: Leg) -> Self {
        let length = leg.length(mesh, from, to);
        let none = Heading { triangle: leg.first, direction: DVec3::ZERO };
        let mut span = Self { length, start: none, end: none, bend_out: 0.0, bend_in: 0.0, flips: false, leg };
        let mut walk = Walk { position: mesh.position_of(from), triangle: span.leg.first, done: 0.0, at_vertex: None };
        for i in 0..span.leg.word.len() {
            let (letter, t) = (span.leg.word[i], span.leg.parameters[i]);
            span.advance(mesh, &mut walk, crossing_position(mesh, letter, t), Some(crossing_spot(mesh, letter, t)));
            let entered = mesh.twin(letter).expect("a letter of a word has a twin");
            span.flips ^= flips_winding(mesh, letter, entered);
            walk.triangle = entered.triangle();
        }
        span.advance(mesh, &mut walk, mesh.position_of(to), None);
        if span.flips {
            span.bend_in = -span.bend_in;
        }
        span
    }

    /// One segment further: notes headings, and what the line turns at the vertex that it comes from.
    fn advance(&mut self, mesh: &SurfaceMesh, walk: &mut Walk, position: DVec3, spot: Option<Spot>) {
        let step = position - walk.position;
        if step == DVec3::ZERO {
            return;
        }
        let heading = Heading { triangle: walk.triangle, direction: step.normalize_or_zero() };
        if self.start.direction == DVec3::ZERO {
            self.start = heading;
        }
        if let Some((vertex, came, had_flipped)) = walk.at_vertex.take() {
            let turn = turn_at(mesh, vertex, came, heading).angle * if had_flipped { -1.0 } else { 1.0 };
            let share = walk.done / self.length;
            self.bend_out += (1.0 - share) * turn;
            self.bend_in += share * turn;
        }
        self.end = heading;
        walk.done += step.length();
        walk.position = position;
        if let Some(vertex @ Spot::Vertex(_)) = spot {
            walk.at_vertex = Some((vertex, heading, self.flips));
        }
    }
}

/// Where a walk along a span is.
struct Walk {
    position: DVec3,
    triangle: TriangleId,
    /// Length so far.
    done: f64,
    /// The vertex that the walk is at, how it came there, and whether the winding had turned over by then.
    at_vertex: Option<(Spot, Heading, bool)>,
}

/// Where the straight line from start to end crosses the letters of a word; `None` where it does not cross all of them
/// between their ends.
fn straight_crossings(mesh: &SurfaceMesh, unfolding: &Unfolding, word: &[HalfedgeId]) -> Option<Vec<f64>> {
    let mut parameters = Vec::with_capacity(word.len());
    for (&letter, &[left, right]) in word.iter().zip(&unfolding.portals) {
        let (left, right) = (&unfolding.ends[left as usize], &unfolding.ends[right as usize]);
        let t = cross_portal(unfolding.start, unfolding.end, left.at, right.at);
        if !(CLEARANCE..=1.0 - CLEARANCE).contains(&t) {
            return None;
        }
        parameters.push(if mesh.sorted_ends(letter)[0] == left.vertex { t } else { 1.0 - t });
    }
    Some(parameters)
}

/// Whether the winding turns over along a word.
fn flips_along(mesh: &SurfaceMesh, word: &[HalfedgeId]) -> bool {
    word.iter().fold(false, |flips, &h| flips ^ mesh.twin(h).is_some_and(|twin| flips_winding(mesh, h, twin)))
}

/// A planar direction at portal `letter` as a direction in the triangle of `side`, which lies `ahead` (1) of the portal
/// or before it (-1). `None` where the triangle has no height.
fn in_space(
    mesh: &SurfaceMesh,
    unfolding: &Unfolding,
    letter: usize,
    side: HalfedgeId,
    ahead: f64,
    direction: DVec2,
) -> Option<DVec3> {
    let [left, right] = unfolding.portals[letter].map(|end| &unfolding.ends[end as usize]);
    let along_plane = (right.at - left.at).try_normalize()?;
    let (l, r) = (mesh.position(left.vertex), mesh.position(right.vertex));
    let along = (r - l).try_normalize()?;
    let offset = mesh.position(mesh.apex(side)) - l;
    let inwards = (offset - offset.dot(along) * along).try_normalize()?;
    Some(direction.dot(along_plane) * along + ahead * direction.dot(along_plane.perp()) * inwards)
}
