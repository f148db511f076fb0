//! The step that lowers a curve of `fair`: Gauss-Newton, by one band solve.
//!
//! Holds the normal equations and what they take from the surface, its curvature along the curve; the energy is in `fair`.

use glam::{DMat2, DVec2};

use crate::cone::Cones;
use crate::error::Result;
use crate::filter::fair::FairCurve;
use crate::ids::{HalfedgeId, TriangleId};
use crate::large::LargeVec;
use crate::mesh::SurfaceMesh;
use crate::pauses::Pauses;
use crate::relax::banded::Banded;

/// Spans a side over which the surface's curvature is averaged for a step's model.
const CURVATURE_SPANS: isize = 8;

/// Where the samples of a curve should go.
#[derive(Clone, Debug)]
pub struct FairStep {
    /// For each sample, in its own frame.
    pub(super) ways: LargeVec<DVec2>,
    /// How far the model says that the energy falls; above 0.
    pub fall: f64,
    /// The longest way, relative to the distance of the samples there.
    pub size: f64,
}

/// The normal equations of a curve where it is now, without what holds it there.
#[derive(Debug)]
pub struct FairSystem {
    matrix: Banded,
    right: LargeVec<f64>,
}

impl FairCurve {
    /// The surface's Gauss curvature at each sample: angle defects over areas, of the vertices along the curve.
    fn curvatures(&self, mesh: &SurfaceMesh, cones: &mut Cones, pauses: &mut Pauses) -> Result<LargeVec<f64>> {
        let mut sums = LargeVec::with_capacity(self.spans.len());
        for span in self.spans.iter() {
            pauses.tick()?;
            let entered = span.leg.word.iter().filter_map(|&h| mesh.twin(h)).map(HalfedgeId::triangle);
            let spokes = std::iter::once(span.leg.first).chain(entered).flat_map(TriangleId::halfedges);
            let cones = spokes.map(|h| cones.get(mesh, h));
            sums.push(cones.fold(DVec2::ZERO, |sum, cone| sum + DVec2::new(cone.defect, cone.area)));
        }
        let count = sums.len() as isize;
        let at = |k: isize| {
            let k = if self.input.closed { k.rem_euclid(count) } else { k };
            (0..count).contains(&k).then(|| sums[k as usize])
        };
        let mut means = LargeVec::with_capacity(self.count());
        for i in 0..self.count() as isize {
            pauses.tick()?;
            let sum: DVec2 = (i - CURVATURE_SPANS..i + CURVATURE_SPANS).filter_map(at).sum();
            means.push(if sum.y > 0.0 { sum.x / sum.y * self.input.unit.powi(2) } else { 0.0 });
        }
        Ok(means)
    }

    /// Takes a vector at the sample after span `span` to the sample before it.
    fn transport(&self, span: usize) -> DMat2 {
        let (here, there) = (&self.frames[span], &self.frames[(span + 1) % self.count()]);
        let mirror = if here.flips { DMat2::from_diagonal(DVec2::new(1.0, -1.0)) } else { DMat2::IDENTITY };
        let rotation = |v: DVec2| DMat2::from_cols(v, v.perp());
        rotation(here.chord_out) * mirror * rotation(there.chord_in).transpose()
    }

    /// The normal equations, for steps of any reach.
    ///
    /// # Errors
    /// As [`FairCurve::new`].
    pub fn system(&self, mesh: &SurfaceMesh, cones: &mut Cones, pauses: &mut Pauses) -> Result<FairSystem> {
        let count = self.count();
        let curvatures = self.curvatures(mesh, cones, pauses)?;
        let mut system = FairSystem { matrix: Banded::zero(2 * count, 5), right: vec![0.0; 2 * count].into() };
        for (i, &curvature) in curvatures.iter().enumerate() {
            pauses.tick()?;
            self.add_bending(i, curvature, &mut system);
            if self.input.is_pinned[i] {
                (0..2).for_each(|c| system.matrix.add(2 * i + c, 0, 1.0));
                continue;
            }
            let pull = self.closeness * self.weight(i);
            let off = self.offset(mesh, i);
            for c in 0..2 {
                system.matrix.add(2 * i + c, 0, pull);
                system.right[2 * i + c] -= pull * off.dot(self.frames[i].axes[c]);
            }
        }
        Ok(system)
    }

    /// The Gauss-Newton step that leaves alone what is longer than `reach`, a length: it is
    /// held back by closeness to where the curve is, as if that were its input and `reach` its detail size. `None` when
    /// there is no such step.
    ///
    /// # Errors
    /// As [`FairCurve::new`].
    pub fn step(&self, system: &FairSystem, reach: f64, pauses: &mut Pauses) -> Result<Option<FairStep>> {
        let hold = reach.powi(-4);
        let mut matrix = system.matrix.copied(|| pauses.tick())?;
        for i in (0..self.count()).filter(|&i| !self.input.is_pinned[i]) {
            pauses.tick()?;
            (0..2).for_each(|c| matrix.add(2 * i + c, 0, hold * self.weight(i)));
        }
        let Some(solution) = matrix.into_solution(&system.right, self.input.closed, || pauses.tick())? else {
            return Ok(None);
        };
        let solution = LargeVec::from(solution);
        let mut ways = LargeVec::with_capacity(self.count());
        // The model is E - 2 right v + v A v with (A + hold) v = right.
        let (mut along, mut held, mut size) = (0.0, 0.0, 0.0f64);
        for (i, (v, right)) in solution.chunks_exact(2).zip(system.right.chunks_exact(2)).enumerate() {
            pauses.tick()?;
            let way = DVec2::from_slice(v);
            along += way.dot(DVec2::from_slice(right));
            held += hold * self.weight(i) * way.length_squared();
            size = size.max(way.length() / self.weight(i));
            ways.push(way);
        }
        Ok(Some(FairStep { ways, fall: along + held, size }))
    }

    /// Adds one second difference's part of the normal equations.
    fn add_bending(&self, i: usize, curvature: f64, system: &mut FairSystem) {
        let (count, weight) = (self.count(), self.weight(i));
        let (Some(acceleration), (Some(before), Some(after))) = (self.acceleration(i), self.neighbours(i)) else {
            return;
        };
        let (step_before, step_after) = (self.input.steps[before], self.input.steps[after]);
        let stretch = -1.0 / step_before - 1.0 / step_after;
        let speed = 0.5 * (self.speed(before) + self.speed(after));
        let own = DMat2::from_diagonal(DVec2::new(stretch, stretch + weight * speed * speed * curvature));
        let stencil = [
            (-1, (i + count - 1) % count, self.transport(before).transpose() * (1.0 / step_before)),
            (0, i, own),
            (1, (i + 1) % count, self.transport(after) * (1.0 / step_after)),
        ];
        for &(place, j, block) in stencil.iter().filter(|(_, j, _)| !self.input.is_pinned[*j]) {
            let rhs = block.transpose() * acceleration / weight;
            system.right[2 * j] -= rhs.x;
            system.right[2 * j + 1] -= rhs.y;
            for &(other, _, other_block) in stencil.iter().filter(|(_, k, _)| !self.input.is_pinned[*k]) {
                let product = block.transpose() * other_block * (1.0 / weight);
                for row in 0..2 {
                    for column in 0..2 {
                        let offset = 2 * (other - place) + column as isize - row as isize;
                        system.matrix.add(2 * j + row, offset, product.col(column)[row]);
                    }
                }
            }
        }
    }
}
