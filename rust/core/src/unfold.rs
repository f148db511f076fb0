//! Unfolding a strip of triangles into the plane, without stretching any of them.
//!
//! ```text
//!          apex                 The portal (left, right) is the edge that is crossed, as seen by someone who
//!         /    \                walks along the strip. The next triangle's apex is placed ahead of it; then
//!     left ---- right           the apex replaces one end of the portal: the end that the strip turns away from.
//!         \    /
//!          start
//! ```
//!
//! Which side is left follows from walking, not from winding: a mesh with inconsistent winding unfolds as well. Holds
//! no optimisation.

use std::convert::Infallible;

use glam::{DVec2, DVec3};

use crate::ids::{HalfedgeId, VertexId};
use crate::mesh::SurfaceMesh;

/// One end of a portal: where it lies in the plane, and over which letters of the word it stays an end.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct PortalEnd {
    /// Place in the plane.
    pub at: DVec2,
    /// The mesh vertex.
    pub vertex: VertexId,
    /// First letter that it is an end of.
    pub first: u32,
    /// Last letter that it is an end of.
    pub last: u32,
}

/// Letters that are unfolded in less than a millisecond.
const LETTERS_PER_LOOK: u32 = 1 << 13;

/// A strip in the plane. Kept between uses for its memory.
#[derive(Clone, Debug, Default)]
pub struct Unfolding {
    /// Portal ends in the order in which they appear.
    pub ends: Vec<PortalEnd>,
    /// For each letter the places of its left and right end in `ends`.
    pub portals: Vec<[u32; 2]>,
    /// The start point in the plane.
    pub start: DVec2,
    /// The end point in the plane.
    pub end: DVec2,
}

impl Unfolding {
    /// Unfolds the strip of `word` with `start` in its first triangle and `end` in its last.
    ///
    /// Lengths inside each triangle are kept to rounding; the frame is arbitrary (the first portal lies on the x axis
    /// and the walk goes up). At an edge of zero length the direction is free, since every line must pass that point.
    pub fn unfold(&mut self, mesh: &SurfaceMesh, start: DVec3, word: &[HalfedgeId], end: DVec3) {
        self.unfold_while(mesh, start, word, end, || Ok::<_, Infallible>(())).unwrap_or_else(|never| match never {});
    }

    /// As [`Unfolding::unfold`]; `look` is called once in so many letters, and may end the work with an error.
    ///
    /// # Errors
    /// Those of `look`.
    pub fn unfold_while<E>(
        &mut self,
        mesh: &SurfaceMesh,
        start: DVec3,
        word: &[HalfedgeId],
        end: DVec3,
        mut look: impl FnMut() -> Result<(), E>,
    ) -> Result<(), E> {
        self.ends.clear();
        self.portals.clear();
        self.ends.reserve(word.len() + 1);
        self.portals.reserve(word.len());
        let Some(&first) = word.first() else {
            (self.start, self.end) = (DVec2::ZERO, DVec2::new(start.distance(end), 0.0));
            return Ok(());
        };
        let [a, b] = mesh.ends(first);
        let (pa, pb) = (mesh.position(a), mesh.position(b));
        // Both ends of the portal: in space, in the plane, and which they are.
        let mut places = [pa, pb];
        let mut at = [DVec2::ZERO, DVec2::new(pa.distance(pb), 0.0)];
        let mut vertices = [a, b];
        for (at, vertex) in at.into_iter().zip(vertices) {
            self.ends.push(PortalEnd { at, vertex, first: 0, last: 0 });
        }
        let below = ahead_of(pa, pb, at[0], at[1], start);
        self.start = DVec2::new(below.x, -below.y);
        let mut portal = [0u32, 1u32];
        self.portals.push(portal);
        let mut before = first;
        for (letter, &next) in (1..).zip(&word[1..]) {
            if letter % LETTERS_PER_LOOK == 0 {
                look()?;
            }
            let entered = mesh.twin(std::mem::replace(&mut before, next)).expect("a letter of a word has a twin");
            let apex = mesh.apex(entered);
            let place = mesh.position(apex);
            let new = ahead_of(places[0], places[1], at[0], at[1], place);
            let side = usize::from(mesh.touches(next, vertices[0]));
            // The end that the strip turns away from.
            self.ends[portal[side] as usize].last = letter - 1;
            (places[side], at[side], vertices[side]) = (place, new, apex);
            portal[side] = self.ends.len() as u32;
            self.ends.push(PortalEnd { at: new, vertex: apex, first: letter, last: letter });
            self.portals.push(portal);
        }
        for end in portal {
            self.ends[end as usize].last = word.len() as u32 - 1;
        }
        self.end = ahead_of(places[0], places[1], at[0], at[1], end);
        Ok(())
    }

    /// Where `point`, ahead of a portal, comes to lie.
    pub fn ahead(&self, mesh: &SurfaceMesh, [left, right]: [u32; 2], point: DVec3) -> DVec2 {
        let (l, r) = (&self.ends[left as usize], &self.ends[right as usize]);
        ahead_of(mesh.position(l.vertex), mesh.position(r.vertex), l.at, r.at, point)
    }

    /// The end of letter `letter`'s portal that is not `end`.
    pub fn other_end(&self, letter: u32, end: u32) -> u32 {
        let [left, right] = self.portals[letter as usize];
        if left == end { right } else { left }
    }
}

/// Where `point`, in a triangle on the edge from `left` to `right`, comes to lie ahead of that edge when the edge lies
/// at `left_at`, `right_at`.
#[inline]
pub fn ahead_of(left: DVec3, right: DVec3, left_at: DVec2, right_at: DVec2, point: DVec3) -> DVec2 {
    let edge = right - left;
    let length = edge.length();
    let offset = point - left;
    let along_at = (right_at - left_at).normalize_or(DVec2::X);
    if length == 0.0 {
        return left_at + offset.length() * along_at.perp();
    }
    let along = edge / length;
    let x = offset.dot(along);
    let y = offset.cross(along).length();
    left_at + x * along_at + y * along_at.perp()
}
