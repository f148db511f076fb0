//! A strip's word as a linked list with the corners of the line on it, for changes that stay local.
//!
//! A corner is a mesh vertex that the line runs through, with its run: the letters that are crossed at that vertex. The
//! word is kept reduced: when letters are replaced, backtracks at both seams cancel, and corners whose run is eaten up
//! that way disappear. Holds no geometry.

use crate::ids::{HalfedgeId, TriangleId, VertexId};
use crate::mesh::SurfaceMesh;
use crate::strip::entered_triangle;
use crate::vertex_pass::Run;

/// The sentinels at both ends of a chain, as links and as corners alike.
pub const START: u32 = 0;
/// See [`START`].
pub const END: u32 = 1;

#[derive(Clone, Copy, Debug)]
struct Link {
    letter: HalfedgeId,
    previous: u32,
    next: u32,
}

#[derive(Clone, Copy, Debug)]
struct Corner {
    vertex: VertexId,
    first: u32,
    last: u32,
    previous: u32,
    next: u32,
    angle_in: f64,
    angle_out: f64,
    is_alive: bool,
    /// Whether a neighbour's change took letters off the run since its angles were measured.
    is_cut: bool,
}

/// See the module.
#[derive(Clone, Debug)]
pub struct Chain {
    links: Vec<Link>,
    corners: Vec<Corner>,
    /// Where a chain without letters lies.
    first: TriangleId,
}

/// No vertex: the sentinels'.
const NO_VERTEX: VertexId = VertexId(u32::MAX);

impl Chain {
    /// A chain without corners.
    pub fn new(first: TriangleId, word: &[HalfedgeId]) -> Self {
        // Room for a pass or two, which most lines have.
        let mut chain = Self { links: Vec::with_capacity(word.len() + 16), corners: Vec::with_capacity(8), first };
        chain.push_sentinels();
        let mut last = START;
        for &letter in word {
            last = chain.insert_after(last, letter);
        }
        chain
    }

    fn push_sentinels(&mut self) {
        for (previous, next) in [(START, END), (START, END)] {
            self.links.push(Link { letter: HalfedgeId(u32::MAX), previous, next });
            let here = self.corners.len() as u32;
            self.corners.push(Corner {
                vertex: NO_VERTEX,
                first: here,
                last: here,
                previous,
                next,
                angle_in: 0.0,
                angle_out: 0.0,
                is_alive: true,
                is_cut: false,
            });
        }
    }

    /// Links so far, of letters that are there and that were: a bound of the word's length.
    pub fn link_count(&self) -> usize {
        self.links.len()
    }

    /// Whether a corner is still there.
    pub fn is_alive(&self, corner: u32) -> bool {
        self.corners[corner as usize].is_alive
    }

    /// Whether letters were taken off the corner's run since an angle was set.
    pub fn is_cut(&self, corner: u32) -> bool {
        self.corners[corner as usize].is_cut
    }

    /// The corner's vertex.
    pub fn vertex(&self, corner: u32) -> VertexId {
        self.corners[corner as usize].vertex
    }

    /// The corner (or sentinel) after this one.
    pub fn next_corner(&self, corner: u32) -> u32 {
        self.corners[corner as usize].next
    }

    /// The corner (or sentinel) before this one.
    pub fn previous_corner(&self, corner: u32) -> u32 {
        self.corners[corner as usize].previous
    }

    /// The triangle that the chain starts in.
    pub fn first_triangle(&self) -> TriangleId {
        let first = self.links[START as usize].next;
        if first == END { self.first } else { self.links[first as usize].letter.triangle() }
    }

    /// The corner as a run.
    pub fn run(&self, corner: u32) -> Run {
        let c = &self.corners[corner as usize];
        let letter = |link: u32| self.links[link as usize].letter;
        Run {
            vertex: c.vertex,
            first: letter(c.first),
            last: letter(c.last),
            angle_in: c.angle_in,
            angle_out: c.angle_out,
        }
    }

    /// Letters of the corner's run.
    pub fn run_letters(&self, corner: u32) -> Vec<HalfedgeId> {
        let c = &self.corners[corner as usize];
        let mut letters = Vec::with_capacity(8);
        letters.push(self.links[c.first as usize].letter);
        let mut link = c.first;
        while link != c.last {
            link = self.links[link as usize].next;
            letters.push(self.links[link as usize].letter);
        }
        letters
    }

    /// Whether the corner's run leads back into the triangle that it begins in: a full turn.
    pub fn is_winding(&self, mesh: &SurfaceMesh, corner: u32) -> bool {
        let c = &self.corners[corner as usize];
        let mut link = c.first;
        let before = self.links[link as usize].letter.triangle();
        while link != c.last {
            // A single letter leads elsewhere.
            link = self.links[link as usize].next;
            if entered_triangle(mesh, self.links[link as usize].letter) == before {
                return true;
            }
        }
        false
    }

    /// Sets the angle between the last spoke of a corner and the way out.
    pub fn set_angle_out(&mut self, corner: u32, angle: f64) {
        self.corners[corner as usize].angle_out = angle;
        self.corners[corner as usize].is_cut = false;
    }

    /// Sets the angle between the way in and the first spoke of a corner.
    pub fn set_angle_in(&mut self, corner: u32, angle: f64) {
        self.corners[corner as usize].angle_in = angle;
        self.corners[corner as usize].is_cut = false;
    }

    /// Writes the links strictly between two neighbouring corners to `links` and their letters to `letters`.
    pub fn stretch(&self, from: u32, to: u32, links: &mut Vec<u32>, letters: &mut Vec<HalfedgeId>) {
        links.clear();
        letters.clear();
        links.reserve(self.links.len());
        letters.reserve(self.links.len());
        let end = self.corners[to as usize].first;
        let mut link = self.links[self.corners[from as usize].last as usize].next;
        while link != end {
            links.push(link);
            letters.push(self.links[link as usize].letter);
            link = self.links[link as usize].next;
        }
    }

    /// Takes the first letter after a corner into its run.
    pub fn absorb_next(&mut self, corner: u32) {
        let last = self.corners[corner as usize].last;
        self.corners[corner as usize].last = self.links[last as usize].next;
    }

    /// Takes the last letter before a corner into its run.
    pub fn absorb_previous(&mut self, corner: u32) {
        let first = self.corners[corner as usize].first;
        self.corners[corner as usize].first = self.links[first as usize].previous;
    }

    /// Drops the first letter and returns it: the line starts in the next triangle.
    pub fn drop_first(&mut self, mesh: &SurfaceMesh) -> HalfedgeId {
        let link = self.links[START as usize].next;
        let letter = self.links[link as usize].letter;
        self.first = entered_triangle(mesh, letter);
        self.unlink(link);
        letter
    }

    /// Drops the last letter and returns it: the line ends in the triangle before.
    pub fn drop_last(&mut self) -> HalfedgeId {
        let link = self.links[END as usize].previous;
        let letter = self.links[link as usize].letter;
        self.first = letter.triangle();
        self.unlink(link);
        letter
    }

    /// Makes a corner at `vertex` of the links `first` to `last`, which must be consecutive and in no run, after
    /// corner `after`.
    pub fn insert_corner(&mut self, after: u32, vertex: VertexId, first: u32, last: u32) -> u32 {
        let id = self.corners.len() as u32;
        let next = self.corners[after as usize].next;
        self.corners.push(Corner {
            vertex,
            first,
            last,
            previous: after,
            next,
            angle_in: 0.0,
            angle_out: 0.0,
            is_alive: true,
            is_cut: false,
        });
        self.corners[after as usize].next = id;
        self.corners[next as usize].previous = id;
        id
    }

    /// Removes a corner; its letters stay.
    pub fn remove_corner(&mut self, corner: u32) {
        let Corner { previous, next, .. } = self.corners[corner as usize];
        self.corners[corner as usize].is_alive = false;
        self.corners[previous as usize].next = next;
        self.corners[next as usize].previous = previous;
    }

    /// Replaces the run of `corner` by `word`, cancels backtracks at both seams, and removes the corner and every other
    /// one whose run was cancelled. Returns the corners on both sides.
    pub fn replace_run(&mut self, mesh: &SurfaceMesh, corner: u32, word: &[HalfedgeId]) -> (u32, u32) {
        let Corner { first, last, mut previous, mut next, .. } = self.corners[corner as usize];
        // Should all letters cancel, the line lies in the triangle that is left when the last pair goes.
        self.first = self.links[first as usize].letter.triangle();
        self.remove_corner(corner);
        let mut low = self.links[first as usize].previous;
        let mut high = self.links[last as usize].next;
        self.links[low as usize].next = high;
        self.links[high as usize].previous = low;
        let mut rest = word;
        loop {
            let low_letter = (low != START).then(|| self.links[low as usize].letter);
            let high_letter = (high != END).then(|| self.links[high as usize].letter);
            let cancels =
                |a: Option<HalfedgeId>, b: Option<HalfedgeId>| a.zip(b).is_some_and(|(a, b)| mesh.twin(a) == Some(b));
            if !rest.is_empty() && cancels(low_letter, rest.first().copied()) {
                rest = &rest[1..];
                self.first = self.links[low as usize].letter.triangle();
                low = self.cancel_low(low, &mut previous);
            } else if !rest.is_empty() && cancels(rest.last().copied(), high_letter) {
                rest = &rest[..rest.len() - 1];
                high = self.cancel_high(high, &mut next);
            } else if rest.is_empty() && cancels(low_letter, high_letter) {
                self.first = self.links[low as usize].letter.triangle();
                low = self.cancel_low(low, &mut previous);
                high = self.cancel_high(high, &mut next);
            } else {
                break;
            }
        }
        let mut after = low;
        for &letter in rest {
            after = self.insert_after(after, letter);
        }
        (previous, next)
    }

    /// The word of the chain.
    pub fn word(&self) -> Vec<HalfedgeId> {
        let mut word = Vec::new();
        let mut link = self.links[START as usize].next;
        while link != END {
            word.push(self.links[link as usize].letter);
            link = self.links[link as usize].next;
        }
        word
    }

    /// Takes out a link whose letter was cancelled, below the change; a corner that loses its last letter goes.
    fn cancel_low(&mut self, link: u32, previous: &mut u32) -> u32 {
        let Corner { first, last, previous: before, .. } = self.corners[*previous as usize];
        if *previous != START && last == link {
            if first == link {
                self.remove_corner(*previous);
                *previous = before;
            } else {
                self.corners[*previous as usize].last = self.links[link as usize].previous;
                self.corners[*previous as usize].is_cut = true;
            }
        }
        self.unlink(link).0
    }

    /// The mirror image of [`Chain::cancel_low`].
    fn cancel_high(&mut self, link: u32, next: &mut u32) -> u32 {
        let Corner { first, last, next: after, .. } = self.corners[*next as usize];
        if *next != END && first == link {
            if last == link {
                self.remove_corner(*next);
                *next = after;
            } else {
                self.corners[*next as usize].first = self.links[link as usize].next;
                self.corners[*next as usize].is_cut = true;
            }
        }
        self.unlink(link).1
    }

    /// Takes a link out; returns its neighbours.
    fn unlink(&mut self, link: u32) -> (u32, u32) {
        let Link { previous, next, .. } = self.links[link as usize];
        self.links[previous as usize].next = next;
        self.links[next as usize].previous = previous;
        (previous, next)
    }

    fn insert_after(&mut self, link: u32, letter: HalfedgeId) -> u32 {
        let id = self.links.len() as u32;
        let next = self.links[link as usize].next;
        self.links.push(Link { letter, previous: link, next });
        self.links[link as usize].next = id;
        self.links[next as usize].previous = id;
        id
    }
}
