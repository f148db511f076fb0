//! A line as strips and parameters: the working form that filters change and from which points are made.
//!
//! Holds the pins and the legs between them. Points and segments of the finished line are made in `polyline`.

use crate::ids::HalfedgeId;
use crate::leg::Leg;
use crate::mesh::SurfaceMesh;
use crate::spot::join_at;
use crate::surface_point::SurfacePoint;

/// Walks along a leg that part equal points: nearly always the first finds none, and within triangles without area a few
/// do where many edges lie on each other.
const MOST_PARTINGS: u32 = 16;

/// A whole line: pins and the legs between them.
///
/// Open: one leg fewer than pins. Closed: as many legs as pins, the last one back to the first pin; or no pin and one
/// leg whose last letter enters the triangle that its first letter leaves.
#[derive(Clone, PartialEq, Debug)]
pub struct Route {
    /// Whether the line is closed.
    pub closed: bool,
    /// Points that the line passes through exactly, in order.
    pub pins: Vec<SurfacePoint>,
    /// The stretches between them.
    pub legs: Vec<Leg>,
}

impl Route {
    /// Snaps crossings that cannot be told from a mesh vertex in floating point to that vertex, so that it appears
    /// once on the line instead of as a cluster of equal points; and parts those that cannot be told from a pin.
    pub fn snap_to_vertices(&mut self, mesh: &SurfaceMesh) {
        self.part_from_pins(mesh, Leg::snap_to_vertices);
        // Crossings of a full turn may have come to lie on its vertex just now. A ring that is one is left: it has
        // collapsed, which is not told here.
        let mut is_cut = false;
        for leg in &mut self.legs {
            let mut cut = leg.without_full_turns(mesh);
            if self.pins.is_empty() {
                cut.iter_mut().for_each(|ring| ring.reduce_seam(mesh));
                cut = cut.filter(|ring| !ring.word.is_empty());
            }
            if let Some(cut) = cut {
                (*leg, is_cut) = (cut, true);
            }
        }
        if is_cut {
            self.part_from_pins(mesh, Leg::snap_to_vertices);
        }
    }

    /// Parts crossings that have the same point as each other or as a pin, for a line that is not smoothed and so not
    /// snapped.
    pub fn part_equal_points(&mut self, mesh: &SurfaceMesh) {
        self.part_from_pins(mesh, Leg::part_equal_points);
    }

    /// Changes every leg by `part`, which takes the mesh and whether the leg is a closed line without pins, and parts
    /// the leg's first and last crossing from the pins.
    fn part_from_pins(&mut self, mesh: &SurfaceMesh, part: impl Fn(&mut Leg, &SurfaceMesh, bool) -> bool) {
        let is_ring = self.pins.is_empty();
        let pins = &self.pins;
        let pin_at = |i: usize| if is_ring { None } else { Some(mesh.position_of(&pins[i % pins.len()])) };
        for (i, leg) in self.legs.iter_mut().enumerate() {
            let last = leg.word.len().saturating_sub(1);
            let [start, end] = [i, i + 1].map(pin_at);
            for _ in 0..MOST_PARTINGS {
                let at_start = leg.part_from(mesh, start, 0);
                let between = part(leg, mesh, is_ring);
                // A parted point can be equal to its other neighbour.
                if !(leg.part_from(mesh, end, last) | at_start | between) {
                    break;
                }
            }
        }
    }

    /// Whether the line runs through a mesh vertex between its pins.
    pub fn touches_vertex(&self) -> bool {
        self.legs.iter().flat_map(|leg| &leg.parameters).any(|&t| t == 0.0 || t == 1.0)
    }

    /// The pin that a leg starts at, if any.
    pub fn start_pin(&self, leg: usize) -> Option<&SurfacePoint> {
        self.pins.get(leg)
    }

    /// The pin that a leg ends at, if any.
    pub fn end_pin(&self, leg: usize) -> Option<&SurfacePoint> {
        if self.pins.is_empty() { None } else { self.pins.get((leg + 1) % self.pins.len()) }
    }

    /// The letters that lead, round pin `pin`, from the end of the leg before it to the start of the leg after it; empty
    /// at the ends of an open line. `None` when the two do not fit.
    pub fn join(&self, mesh: &SurfaceMesh, pin: usize) -> Option<Vec<HalfedgeId>> {
        let before = match pin.checked_sub(1) {
            Some(leg) => &self.legs[leg],
            None if self.closed => self.legs.last()?,
            None => return Some(Vec::new()),
        };
        let Some(after) = self.legs.get(pin) else { return Some(Vec::new()) };
        join_at(mesh, &self.pins[pin], before.last_triangle(mesh), after.first)
    }
}
