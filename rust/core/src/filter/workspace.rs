//! Work space of lines that are straightened, kept for its memory, and what was unfolded last in it.
//!
//! Holds no geometry.

use glam::DVec3;

use crate::ids::HalfedgeId;
use crate::mesh::SurfaceMesh;
use crate::relax::funnel::Funnel;
use crate::unfold::Unfolding;

/// Work space for more letters than this is given back after a line: some 100 bytes each.
const KEPT_LETTERS: usize = 1 << 14;

/// See the module.
#[derive(Debug, Default)]
pub struct Workspace {
    /// The stretch that was straightened last, in the plane.
    pub unfolding: Unfolding,
    /// Its corners.
    pub funnel: Funnel,
    /// Its links in the chain.
    pub links: Vec<u32>,
    /// Its letters.
    pub letters: Vec<HalfedgeId>,
    /// The ends of the stretch, where [`Workspace::unfolding`] is of it.
    pub unfolded: Option<[DVec3; 2]>,
    /// Letters of another stretch.
    pub others: Vec<HalfedgeId>,
}

impl Workspace {
    /// The work space, emptied where a long line has filled it.
    pub fn trimmed(self) -> Self {
        if self.letters.capacity() > KEPT_LETTERS { Self::default() } else { self }
    }

    /// Unfolds the stretch of [`Workspace::others`] from `a` to `b`, unless that is what was unfolded last: most near lines
    /// turn at no vertex, and are unfolded when they are straightened already.
    pub fn unfold_others(&mut self, mesh: &SurfaceMesh, a: DVec3, b: DVec3) {
        if self.unfolded != Some([a, b]) || self.letters != self.others {
            std::mem::swap(&mut self.letters, &mut self.others);
            self.unfolding.unfold(mesh, a, &self.letters, b);
            self.unfolded = Some([a, b]);
        }
    }
}
