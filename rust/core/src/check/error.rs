//! The promises that a line can break, as typed errors that name the elements.
//!
//! Holds no check: those are in `check`.

use glam::DVec3;
use thiserror::Error;

use crate::ids::TriangleId;
use crate::surface_point::SurfacePoint;

/// A promise that a line breaks. Points, segments, places in the strip, pins and legs are counted from 0.
#[derive(Error, Clone, PartialEq, Debug)]
pub enum CheckError {
    /// An array does not have as many entries as the points ask for.
    #[error("{array} has {found} entries, expected {expected}")]
    Size {
        /// Name of the field.
        array: &'static str,
        /// Entries found.
        found: usize,
        /// Entries that the contract asks for (at least that many for `points` and `strip`).
        expected: usize,
    },
    /// An id that is no triangle of the mesh.
    #[error("{array}[{place}] is triangle {triangle}, but the mesh has {triangles}")]
    TriangleOutOfRange {
        /// Name of the field.
        array: &'static str,
        /// Entry.
        place: usize,
        /// The id found there.
        triangle: u32,
        /// Triangles of the mesh.
        triangles: usize,
    },
    /// Parts that are negative, not finite, or do not sum to 1.
    #[error("point {point} has barycentric {barycentric:?}: no point of a triangle")]
    NotBarycentric {
        /// Point.
        point: usize,
        /// Its parts.
        barycentric: [f64; 3],
    },
    /// `points` is not exactly what the barycentric parts give.
    #[error("point {point} is {found}, but its barycentric parts give {expected}")]
    PointOff {
        /// Point.
        point: usize,
        /// `points[point]`.
        found: DVec3,
        /// `(b0 p0 + b1 p1) + b2 p2`.
        expected: DVec3,
    },
    /// A point inside a triangle that is no pin.
    #[error("point {point} lies inside triangle {} and is no pin", triangle.0)]
    InsideWithoutPin {
        /// Point.
        point: usize,
        /// Its triangle.
        triangle: TriangleId,
    },
    /// An end of a segment is not in the segment's triangle.
    #[error("segment {segment} is said to lie in triangle {}, which does not hold point {point}", triangle.0)]
    SegmentOutside {
        /// Segment.
        segment: usize,
        /// The end that is outside.
        point: usize,
        /// `segment_triangles[segment]`.
        triangle: TriangleId,
    },
    /// The triangle changes at a point that lies on nothing that both triangles share and a line may cross.
    #[error("the line goes from triangle {} to triangle {} at point {point}, which joins them by no crossable edge and no vertex", from.0, to.0)]
    SegmentsApart {
        /// Point.
        point: usize,
        /// Triangle of the segment before it.
        from: TriangleId,
        /// Triangle of the segment after it.
        to: TriangleId,
    },
    /// Two points in a row at the same place of the mesh.
    #[error("points {first} and {second} are the same place of the mesh")]
    PlaceTwice {
        /// Point.
        first: usize,
        /// The next point.
        second: usize,
    },
    /// Two points in a row with equal coordinates where no mesh vertices coincide.
    #[error("points {first} and {second} are both {position}, though no mesh vertices coincide there")]
    PointsEqual {
        /// Point.
        first: usize,
        /// The next point.
        second: usize,
        /// Where both are.
        position: DVec3,
    },
    /// Neighbours in the strip that share no crossable edge.
    #[error("strip[{place}] is triangle {} and the next one {}: no crossable edge joins them", from.0, to.0)]
    StripBroken {
        /// Place in the strip.
        place: usize,
        /// Triangle there.
        from: TriangleId,
        /// The next one.
        to: TriangleId,
    },
    /// The strip enters a triangle and leaves it by the same edge, and no pin asks for it.
    #[error("the strip turns back in triangle {} (strip[{place}]), which holds no pin", triangle.0)]
    Backtrack {
        /// Place in the strip of the triangle that it turns back in.
        place: usize,
        /// The triangle.
        triangle: TriangleId,
    },
    /// The strip crosses an edge where the line does not, or turns more than once round a vertex that the line runs through.
    #[error("the strip leaves triangle {} (strip[{place}]) by an edge that does not hold point {point}", triangle.0)]
    StripOffLine {
        /// Place in the strip.
        place: usize,
        /// Triangle there.
        triangle: TriangleId,
        /// The point at which the line changes triangles next.
        point: usize,
    },
    /// The strip ends before the line does.
    #[error("segment {segment} lies in triangle {}, which the rest of the strip does not hold", triangle.0)]
    StripTooShort {
        /// Segment.
        segment: usize,
        /// Its triangle.
        triangle: TriangleId,
    },
    /// A pin that the line does not pass through, or not in its order.
    #[error("pin {pin} (triangle {}, barycentric {:?}) is not on the line, or out of order", at.triangle.0, at.barycentric)]
    PinMissing {
        /// Pin.
        pin: usize,
        /// Where it is.
        at: SurfacePoint,
    },
    /// Pins and legs do not go together.
    #[error("{legs} legs for {pins} pins, closed: {closed}")]
    LegCount {
        /// Legs of the route.
        legs: usize,
        /// Pins of the route.
        pins: usize,
        /// Whether the route is closed.
        closed: bool,
    },
    /// A letter that does not follow from the one before it, crosses a boundary or a wall, or crosses back.
    #[error("letter {letter} of leg {leg} does not go on from the triangle before it, or goes back")]
    WordBroken {
        /// Leg.
        leg: usize,
        /// Letter.
        letter: usize,
    },
    /// A parameter that is no place on its edge.
    #[error("parameter {letter} of leg {leg} is {parameter}, expected 0 to 1")]
    ParameterOff {
        /// Leg.
        leg: usize,
        /// Letter.
        letter: usize,
        /// The value.
        parameter: f64,
    },
    /// Writing the line to bytes and reading it back gives another line, or none.
    #[error("the line that comes back from bytes differs in {field}")]
    BytesDiffer {
        /// The first field that differs.
        field: &'static str,
    },
}
