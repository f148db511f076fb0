//! Ids of mesh elements as `u32` newtypes, and the arithmetic of half-edge ids.
//!
//! Holds no geometry and no mesh: only what an id alone can tell.

/// A row of the `positions` array.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub struct VertexId(pub u32);

/// A row of the `triangles` array.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub struct TriangleId(pub u32);

/// One side of a triangle: side `k` of triangle `f` has id `3 f + k` and joins its corners `k` and
/// `k + 1 (mod 3)`.
///
/// A half-edge names an edge *as seen from one triangle*. Crossing it leaves that triangle. Nothing
/// is assumed about winding: the twin may run either way.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub struct HalfedgeId(pub u32);

impl VertexId {
    /// The id as an array index.
    #[inline]
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

impl TriangleId {
    /// The id as an array index.
    #[inline]
    pub fn index(self) -> usize {
        self.0 as usize
    }

    /// The side that joins corners `side` and `side + 1 (mod 3)`; `side` in 0..3.
    #[inline]
    pub fn halfedge(self, side: u32) -> HalfedgeId {
        debug_assert!(side < 3);
        HalfedgeId(3 * self.0 + side)
    }

    /// The three sides, in order.
    #[inline]
    pub fn halfedges(self) -> [HalfedgeId; 3] {
        [self.halfedge(0), self.halfedge(1), self.halfedge(2)]
    }
}

impl HalfedgeId {
    /// The id as an array index.
    #[inline]
    pub fn index(self) -> usize {
        self.0 as usize
    }

    /// The triangle that this side belongs to.
    #[inline]
    pub fn triangle(self) -> TriangleId {
        TriangleId(self.0 / 3)
    }

    /// Which side of its triangle: 0, 1 or 2.
    #[inline]
    pub fn side(self) -> u32 {
        self.0 % 3
    }

    /// The next side of the same triangle.
    #[inline]
    pub fn next(self) -> HalfedgeId {
        if self.side() == 2 { HalfedgeId(self.0 - 2) } else { HalfedgeId(self.0 + 1) }
    }

    /// The previous side of the same triangle.
    #[inline]
    pub fn previous(self) -> HalfedgeId {
        if self.side() == 0 { HalfedgeId(self.0 + 2) } else { HalfedgeId(self.0 - 1) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sides_of_a_triangle_follow_each_other_in_a_ring() {
        let sides = TriangleId(7).halfedges();
        for k in 0..3 {
            assert_eq!(sides[k].triangle(), TriangleId(7));
            assert_eq!(sides[k].next(), sides[(k + 1) % 3]);
            assert_eq!(sides[(k + 1) % 3].previous(), sides[k]);
        }
    }
}
