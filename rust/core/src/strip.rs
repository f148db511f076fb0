//! A strip of triangles as the word of the edges it crosses, and what can be done to a word without geometry.
//!
//! Each letter is a half-edge seen from the triangle that is left; the next letter belongs to the triangle that its
//! twin belongs to:
//!
//! ```text
//!       ______________
//!      /\      /\    /        first triangle, then h0, h1, h2, ...:
//!     /  \ h1 /  \  /         h0 leaves the first triangle, twin(h0) is in the second,
//!    / h0 \  / h2 \/          and h1 is one of the second's two other sides
//!   /______\/_____/
//! ```
//!
//! Holds words alone: no positions, no parameters.

use crate::ids::{HalfedgeId, TriangleId, VertexId};
use crate::mesh::SurfaceMesh;

/// The triangle that is entered by crossing `halfedge`.
///
/// # Panics
/// When there is no triangle there: letters of a word always have a twin.
#[inline]
pub fn entered_triangle(mesh: &SurfaceMesh, halfedge: HalfedgeId) -> TriangleId {
    mesh.twin(halfedge).expect("a letter of a word has a twin").triangle()
}

/// All triangles of a strip, first to last.
pub fn triangles_of(mesh: &SurfaceMesh, first: TriangleId, word: &[HalfedgeId]) -> Vec<TriangleId> {
    std::iter::once(first).chain(word.iter().map(|&h| entered_triangle(mesh, h))).collect()
}

/// Appends a letter, or takes the last one back when the new letter crosses the same edge again (`e e`).
pub fn push_reduced(mesh: &SurfaceMesh, word: &mut Vec<HalfedgeId>, letter: HalfedgeId) {
    if word.last().is_some_and(|&last| mesh.twin(last) == Some(letter)) {
        word.pop();
    } else {
        word.push(letter);
    }
}

/// Cancels backtracks `e e` across the seam of a closed word, whose inside must be reduced.
pub fn reduce_seam(mesh: &SurfaceMesh, word: &mut Vec<HalfedgeId>) {
    let mut cut = 0;
    while word.len() >= 2 * (cut + 1) && mesh.twin(word[word.len() - 1 - cut]) == Some(word[cut]) {
        cut += 1;
    }
    word.truncate(word.len() - cut);
    word.drain(..cut);
}

/// The word that turns round `vertex` from triangle `from` to triangle `to`, both of its fan: the side with fewer
/// letters, on a tie the one that leaves `from` by its lower side. `None` when they are not in one fan.
pub fn turn_word(mesh: &SurfaceMesh, vertex: VertexId, from: TriangleId, to: TriangleId) -> Option<Vec<HalfedgeId>> {
    let mut spokes = from.halfedges().into_iter().filter(|&h| mesh.touches(h, vertex));
    let (first, second) = (spokes.next()?, spokes.next()?);
    let mut words = [Vec::new(), Vec::new()];
    let mut exits = [Some(first), Some(second)];
    if from == to {
        return Some(Vec::new());
    }
    while exits.iter().any(Option::is_some) {
        for (word, exit) in words.iter_mut().zip(&mut exits) {
            let Some(h) = *exit else { continue };
            let Some(twin) = mesh.twin(h) else {
                *exit = None;
                continue;
            };
            word.push(h);
            if twin.triangle() == to {
                return Some(std::mem::take(word));
            }
            // Once round a ring and `to` was not there.
            *exit = (twin.triangle() != from).then(|| mesh.other_spoke(twin, vertex));
        }
    }
    None
}

/// The compact form of a strip: which side of the first triangle is left (two bits, high bit first), then one bit a
/// letter: whether the strip turns to the side *before* the one it came in by (else the one after it).
///
/// The word must be reduced. Source: the paper, section 4, *compact encoding*; with inconsistent winding the bit is
/// relative to the triangle's own order of corners.
pub fn encode_word(mesh: &SurfaceMesh, word: &[HalfedgeId]) -> Vec<bool> {
    let Some(first) = word.first() else { return Vec::new() };
    let mut bits = vec![first.side() & 2 != 0, first.side() & 1 != 0];
    for pair in word.windows(2) {
        let twin = mesh.twin(pair[0]).expect("a letter of a word has a twin");
        debug_assert_ne!(twin, pair[1], "a backtrack has no compact form");
        bits.push(pair[1] == twin.previous());
    }
    bits
}

/// The inverse of [`encode_word`]; `None` when the bits walk over a boundary or are no code.
pub fn decode_word(mesh: &SurfaceMesh, first: TriangleId, bits: &[bool]) -> Option<Vec<HalfedgeId>> {
    if bits.is_empty() {
        return Some(Vec::new());
    }
    let side = u32::from(*bits.first()?) * 2 + u32::from(*bits.get(1)?);
    if side > 2 {
        return None;
    }
    let mut letter = first.halfedge(side);
    let mut word = vec![letter];
    for &is_previous in &bits[2..] {
        let twin = mesh.twin(letter)?;
        letter = if is_previous { twin.previous() } else { twin.next() };
        word.push(letter);
    }
    mesh.twin(letter)?;
    Some(word)
}
