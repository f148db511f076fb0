//! The finished line: its points, where each lies on the mesh, the triangles between them, and its compact form.
//!
//! Made from a `Route` in one place, so that a fresh line and one read back from bytes are equal to the bit. Holds no
//! smoothing.

use glam::DVec3;

use crate::error::{OptionError, Result};
use crate::ids::{HalfedgeId, TriangleId};
use crate::leg::Leg;
use crate::mesh::SurfaceMesh;
use crate::pauses::Pauses;
use crate::report::Report;
use crate::route::Route;
use crate::spot::{Spot, crossing_point, crossing_spot, is_round, spot_of};
use crate::strip::{decode_word, encode_word, entered_triangle};
use crate::surface_point::SurfacePoint;

/// A smooth line on a mesh.
#[derive(Clone, PartialEq, Debug)]
pub struct Polyline {
    /// Whether a last segment leads from the last point to the first.
    pub closed: bool,
    /// The start, the crossings of edges, the pins, the end; consecutive ones differ.
    pub points: Vec<DVec3>,
    /// Where each point lies; `points[i]` is exactly its position.
    pub surface_points: Vec<SurfacePoint>,
    /// The triangle that holds segment `i` whole.
    pub segment_triangles: Vec<TriangleId>,
    /// The triangles of the strip in order; a closed line does not repeat the first.
    pub strip: Vec<TriangleId>,
    /// Pins, words and parameters that the line is made from.
    pub route: Route,
    /// How it was made; default for a line read from bytes.
    pub report: Report,
}

/// A stop of the line: where it is, and the triangle that the next segment lies in.
struct Stop {
    spot: Spot,
    surface_point: SurfacePoint,
    after: TriangleId,
    is_pin: bool,
}

impl Polyline {
    /// Puts the points of a route together; `None` when legs and pins do not fit.
    pub fn assemble(mesh: &SurfaceMesh, route: Route, report: Report) -> Option<Self> {
        Self::assemble_while(mesh, route, report, &mut || true)
    }

    /// As [`Polyline::assemble`].
    ///
    /// # Errors
    /// [`crate::Error::Interrupted`] at one of the `pauses`.
    pub fn assemble_with_pauses(
        mesh: &SurfaceMesh,
        route: Route,
        report: Report,
        pauses: &mut Pauses,
    ) -> Result<Option<Self>> {
        let line = while_unstopped(pauses, |goes_on| Self::assemble_while(mesh, route, report, goes_on))?;
        pauses.pause()?;
        Ok(line)
    }

    fn assemble_while(
        mesh: &SurfaceMesh,
        route: Route,
        report: Report,
        goes_on: &mut dyn FnMut() -> bool,
    ) -> Option<Self> {
        let (strip, stops) = walk(mesh, &route, goes_on)?;
        let surface_points: Vec<_> = stops.iter().map(|s| s.surface_point).collect();
        let points = positions_of(mesh, &stops, goes_on)?;
        let segments = if route.closed { stops.len() } else { stops.len().saturating_sub(1) };
        let segment_triangles = stops.iter().take(segments).map(|s| s.after).collect();
        Some(Self { closed: route.closed, points, surface_points, segment_triangles, strip, route, report })
    }

    /// The points that [`Polyline::assemble`] gives the line, and how many triangles its strip has.
    pub fn outline(mesh: &SurfaceMesh, route: &Route) -> Option<(Vec<DVec3>, usize)> {
        Self::outline_while(mesh, route, &mut || true)
    }

    /// As [`Polyline::outline`].
    ///
    /// # Errors
    /// [`crate::Error::Interrupted`] at one of the `pauses`.
    pub fn outline_with_pauses(
        mesh: &SurfaceMesh,
        route: &Route,
        pauses: &mut Pauses,
    ) -> Result<Option<(Vec<DVec3>, usize)>> {
        while_unstopped(pauses, |goes_on| Self::outline_while(mesh, route, goes_on))
    }

    fn outline_while(
        mesh: &SurfaceMesh,
        route: &Route,
        goes_on: &mut dyn FnMut() -> bool,
    ) -> Option<(Vec<DVec3>, usize)> {
        let (strip, stops) = walk(mesh, route, goes_on)?;
        Some((positions_of(mesh, &stops, goes_on)?, strip.len()))
    }

    /// The length, in the units of the positions.
    pub fn length(&self) -> f64 {
        length_of(&self.points, self.closed)
    }

    /// The strip's compact form: for each leg what [`encode_word`] gives. With the first triangle and the number of
    /// letters a leg it gives the strip back.
    pub fn strip_bits(&self, mesh: &SurfaceMesh) -> Vec<bool> {
        self.route.legs.iter().flat_map(|leg| encode_word(mesh, &leg.word)).collect()
    }

    /// The whole line as bytes, little-endian: head, pins, then for each leg its first triangle, one bit a step and one
    /// parameter (f64) a crossing. [`Polyline::from_bytes`] on the same mesh gives an equal line.
    pub fn to_bytes(&self, mesh: &SurfaceMesh) -> Vec<u8> {
        let mut bytes = MAGIC.to_vec();
        let mut put = |n: usize| bytes.extend((n as u32).to_le_bytes());
        put(mesh.triangles().len());
        put(usize::from(self.route.closed));
        put(self.route.pins.len());
        put(self.route.legs.len());
        for pin in &self.route.pins {
            bytes.extend(pin.triangle.0.to_le_bytes());
            bytes.extend(pin.barycentric.iter().flat_map(|b| b.to_le_bytes()));
        }
        for leg in &self.route.legs {
            bytes.extend(leg.first.0.to_le_bytes());
            bytes.extend((leg.word.len() as u32).to_le_bytes());
            let bits = encode_word(mesh, &leg.word);
            bytes.extend(bits.chunks(8).map(|byte| byte.iter().rev().fold(0u8, |sum, &b| sum << 1 | u8::from(b))));
            bytes.extend(leg.parameters.iter().flat_map(|t| t.to_le_bytes()));
        }
        bytes
    }

    /// The line that [`Polyline::to_bytes`] wrote for the same mesh.
    ///
    /// # Errors
    /// Bytes that are no line, or a line of another mesh.
    pub fn from_bytes(mesh: &SurfaceMesh, bytes: &[u8]) -> Result<Self, OptionError> {
        let refuse = |why: &str| {
            OptionError::new("data", format!("{why}; pass bytes that to_bytes() wrote for a line of this very mesh"))
        };
        let route =
            read_route(mesh, &mut Reader { bytes }).ok_or_else(|| refuse("the bytes are not a line of this mesh"))?;
        Self::assemble(mesh, route, Report::default()).ok_or_else(|| refuse("the legs of the line do not fit its pins"))
    }
}

/// Length of a chain of points.
pub fn length_of(points: &[DVec3], closed: bool) -> f64 {
    // Folded from 0, as the sum of nothing is -0 in Rust.
    let open = points.windows(2).fold(0.0, |sum, p| sum + p[0].distance(p[1]));
    match (closed, points.first(), points.last()) {
        (true, Some(first), Some(last)) => open + last.distance(*first),
        _ => open,
    }
}

/// What `work` makes, which asks now and then whether it shall go on.
fn while_unstopped<T>(
    pauses: &mut Pauses,
    work: impl FnOnce(&mut dyn FnMut() -> bool) -> Option<T>,
) -> Result<Option<T>> {
    let mut outcome = Ok(());
    let made = work(&mut || {
        outcome = pauses.tick();
        outcome.is_ok()
    });
    outcome.map(|()| made)
}

fn positions_of(mesh: &SurfaceMesh, stops: &[Stop], goes_on: &mut dyn FnMut() -> bool) -> Option<Vec<DVec3>> {
    let mut points = Vec::with_capacity(stops.len());
    for stop in stops {
        if !goes_on() {
            return None;
        }
        points.push(mesh.position_of(&stop.surface_point));
    }
    Some(points)
}

/// The strip and the stops of a route, equal neighbours merged; `None` also when a crossing finds that `goes_on` does not.
fn walk(mesh: &SurfaceMesh, route: &Route, goes_on: &mut dyn FnMut() -> bool) -> Option<(Vec<TriangleId>, Vec<Stop>)> {
    let letters: usize = route.legs.iter().map(|leg| leg.word.len()).sum();
    // A strip has some more where it turns round a pin.
    let mut strip = Vec::with_capacity(letters + 4 * route.pins.len() + 1);
    let mut stops: Vec<Stop> = Vec::with_capacity(letters + route.pins.len());
    let mut triangle = match (route.legs.first(), route.pins.first()) {
        (Some(leg), _) => leg.first,
        (None, Some(pin)) => pin.triangle,
        (None, None) => return None,
    };
    strip.push(triangle);
    for k in 0..route.pins.len().max(route.legs.len()) {
        if let Some(pin) = route.pins.get(k) {
            // The turn at the first pin of a closed line comes at the end of the walk.
            let join = if k == 0 { Vec::new() } else { route.join(mesh, k)? };
            for &h in &join {
                triangle = entered_triangle(mesh, h);
                strip.push(triangle);
            }
            push_stop(
                &mut stops,
                Stop { spot: spot_of(mesh, pin), surface_point: *pin, after: triangle, is_pin: true },
            );
        }
        // The triangle that the walk is in must hold the pin; the bytes of a line may say anything.
        if route.pins.get(k).is_some_and(|pin| !is_round(mesh, pin, triangle)) {
            return None;
        }
        let Some(leg) = route.legs.get(k) else { continue };
        if leg.first != triangle {
            return None;
        }
        for (&h, &t) in leg.word.iter().zip(&leg.parameters) {
            if !goes_on() {
                return None;
            }
            triangle = entered_triangle(mesh, h);
            strip.push(triangle);
            let surface_point = crossing_point(mesh, h, t);
            push_stop(
                &mut stops,
                Stop { spot: crossing_spot(mesh, h, t), surface_point, after: triangle, is_pin: false },
            );
        }
    }
    if route.closed {
        if !route.pins.is_empty() {
            for h in route.join(mesh, 0)? {
                triangle = entered_triangle(mesh, h);
                strip.push(triangle);
            }
        }
        if strip.len() > 1 && strip.last() == strip.first() {
            strip.pop();
        }
        while stops.len() > 1 && stops.first().zip(stops.last()).is_some_and(|(a, b)| a.is_same_place(b)) {
            stops.pop();
        }
    }
    Some((strip, stops))
}

impl Stop {
    fn is_same_place(&self, other: &Self) -> bool {
        let is_inside = matches!(self.spot, Spot::Inside(_));
        self.spot == other.spot && (!is_inside || self.surface_point.barycentric == other.surface_point.barycentric)
    }
}

/// Appends a stop, or merges it with the one before when both are at the same place of the mesh.
fn push_stop(stops: &mut Vec<Stop>, stop: Stop) {
    match stops.last_mut() {
        Some(last) if last.is_same_place(&stop) => {
            last.after = stop.after;
            // A pin keeps its own coordinates, which the caller gave.
            if stop.is_pin && !last.is_pin {
                last.surface_point = stop.surface_point;
                last.is_pin = true;
            }
        }
        _ => stops.push(stop),
    }
}

const MAGIC: &[u8] = b"SPL1";

struct Reader<'a> {
    bytes: &'a [u8],
}

impl<'a> Reader<'a> {
    fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let (head, tail) = self.bytes.split_at_checked(count)?;
        self.bytes = tail;
        Some(head)
    }

    fn read_u32(&mut self) -> Option<u32> {
        self.take(4)?.try_into().ok().map(u32::from_le_bytes)
    }

    fn read_f64(&mut self) -> Option<f64> {
        self.take(8)?.try_into().ok().map(f64::from_le_bytes)
    }

    fn read_triangle(&mut self, mesh: &SurfaceMesh) -> Option<TriangleId> {
        self.read_u32().filter(|&t| (t as usize) < mesh.triangles().len()).map(TriangleId)
    }
}

fn read_route(mesh: &SurfaceMesh, reader: &mut Reader) -> Option<Route> {
    if reader.take(MAGIC.len())? != MAGIC || reader.read_u32()? as usize != mesh.triangles().len() {
        return None;
    }
    let closed = match reader.read_u32()? {
        0 => false,
        1 => true,
        _ => return None,
    };
    let (pin_count, leg_count) = (reader.read_u32()? as usize, reader.read_u32()? as usize);
    let is_consistent = if closed { leg_count == pin_count.max(1) } else { leg_count + 1 == pin_count };
    if !is_consistent {
        return None;
    }
    let mut pins = Vec::new();
    for _ in 0..pin_count {
        let triangle = reader.read_triangle(mesh)?;
        let barycentric = [reader.read_f64()?, reader.read_f64()?, reader.read_f64()?];
        let pin = SurfacePoint::checked(triangle, barycentric, "data").ok()?;
        // A pin that the check would change was not written by `to_bytes`.
        pins.push(Some(pin).filter(|pin| pin.barycentric == barycentric)?);
    }
    let mut legs = Vec::new();
    for _ in 0..leg_count {
        let first = reader.read_triangle(mesh)?;
        let letters = reader.read_u32()? as usize;
        let bit_count = if letters == 0 { 0 } else { letters + 1 };
        let packed = reader.take(bit_count.div_ceil(8))?;
        let bits: Vec<bool> = (0..bit_count).map(|i| packed[i / 8] >> (i % 8) & 1 == 1).collect();
        let word: Vec<HalfedgeId> = decode_word(mesh, first, &bits)?;
        let mut parameters = Vec::new();
        for _ in 0..letters {
            parameters.push(reader.read_f64().filter(|t| (0.0..=1.0).contains(t))?);
        }
        legs.push(Leg { first, word, parameters });
    }
    let is_round = !closed || pin_count > 0 || legs[0].last_triangle(mesh) == legs[0].first;
    (reader.bytes.is_empty() && is_round).then_some(Route { closed, pins, legs })
}
