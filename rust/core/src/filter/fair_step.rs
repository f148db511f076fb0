//! The step that lowers a curve of `fair`: Gauss-Newton, by one band solve.
//!
//! Holds the normal equations and what they take from the surface, its curvature along the curve; the energy is in `fair`.

use glam::{DMat2, DVec2};

use crate::cone::Cones;
use crate::error::Result;
use crate::filter::fair::FairCurve;
use crate::ids::{HalfedgeId, TriangleId};
use crate::mesh::SurfaceMesh;
use crate::pauses::Pauses;
use crate::relax::banded::Banded;
use crate::span::Span;

/// Spans a side over which the surface's curvature is averaged for a step's model.
const CURVATURE_SPANS: isize = 8;

/// Where the samples of a curve should go.
#[derive(Clone, Debug)]
pub struct FairStep {
    /// For each sample, in its own frame.
    pub(super) ways: Vec<DVec2>,
    /// How far the model says that the energy falls; above 0.
    pub fall: f64,
}

impl FairCurve {
    /// The surface's Gauss curvature at each sample: angle defects over areas, of the vertices along the curve.
    fn curvatures(&self, mesh: &SurfaceMesh, cones: &mut Cones, pauses: &mut Pauses) -> Result<Vec<f64>> {
        let mut of_span = |span: &Span| {
            pauses.tick()?;
            let entered = span.leg.word.iter().filter_map(|&h| mesh.twin(h)).map(HalfedgeId::triangle);
            let spokes = std::iter::once(span.leg.first).chain(entered).flat_map(TriangleId::halfedges);
            let cones = spokes.map(|h| cones.get(mesh, h));
            Ok(cones.fold(DVec2::ZERO, |sum, cone| sum + DVec2::new(cone.defect, cone.area)))
        };
        let sums: Vec<DVec2> = self.spans.iter().map(&mut of_span).collect::<Result<_>>()?;
        let count = sums.len() as isize;
        let at = |k: isize| {
            let k = if self.input.closed { k.rem_euclid(count) } else { k };
            (0..count).contains(&k).then(|| sums[k as usize])
        };
        let mean = |i: isize| {
            pauses.tick()?;
            let sum: DVec2 = (i - CURVATURE_SPANS..i + CURVATURE_SPANS).filter_map(at).sum();
            Ok(if sum.y > 0.0 { sum.x / sum.y * self.input.unit.powi(2) } else { 0.0 })
        };
        (0..self.count() as isize).map(mean).collect()
    }

    /// Takes a vector at the sample after span `span` to the sample before it.
    fn transport(&self, span: usize) -> DMat2 {
        let (here, there) = (&self.frames[span], &self.frames[(span + 1) % self.count()]);
        let mirror = if here.flips { DMat2::from_diagonal(DVec2::new(1.0, -1.0)) } else { DMat2::IDENTITY };
        let rotation = |v: DVec2| DMat2::from_cols(v, v.perp());
        rotation(here.chord_out) * mirror * rotation(there.chord_in).transpose()
    }

    /// The Gauss-Newton step that leaves alone what is longer than `reach`, a length: it is
    /// held back by closeness to where the curve is, as if that were its input and `reach` its detail size. `None` when
    /// there is no such step.
    ///
    /// # Errors
    /// As [`FairCurve::new`].
    pub fn step(
        &self,
        mesh: &SurfaceMesh,
        reach: f64,
        cones: &mut Cones,
        pauses: &mut Pauses,
    ) -> Result<Option<FairStep>> {
        let count = self.count();
        let hold = reach.powi(-4);
        let curvatures = self.curvatures(mesh, cones, pauses)?;
        let mut matrix = Banded::zero(2 * count, 5);
        let mut right = vec![0.0; 2 * count];
        for (i, &curvature) in curvatures.iter().enumerate() {
            pauses.tick()?;
            self.add_bending(i, curvature, &mut matrix, &mut right);
            if self.input.is_pinned[i] {
                (0..2).for_each(|c| matrix.add(2 * i + c, 0, 1.0));
                continue;
            }
            let weight = self.weight(i);
            let off = self.offset(mesh, i);
            for c in 0..2 {
                matrix.add(2 * i + c, 0, (self.closeness + hold) * weight);
                right[2 * i + c] -= self.closeness * weight * off.dot(self.frames[i].axes[c]);
            }
        }
        let Some(solution) = matrix.into_solution(&right, self.input.closed, || pauses.tick())? else {
            return Ok(None);
        };
        let ways: Vec<DVec2> = solution.chunks(2).map(DVec2::from_slice).collect();
        // The model is E - 2 right v + v A v with (A + hold) v = right.
        let held = |(i, way): (usize, &DVec2)| hold * self.weight(i) * way.length_squared();
        let fall = right.iter().zip(&solution).map(|(r, v)| r * v).sum::<f64>()
            + ways.iter().enumerate().map(held).sum::<f64>();
        Ok(Some(FairStep { ways, fall }))
    }

    /// Adds one second difference's part of the normal equations.
    fn add_bending(&self, i: usize, curvature: f64, matrix: &mut Banded, right: &mut [f64]) {
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
            right[2 * j] -= rhs.x;
            right[2 * j + 1] -= rhs.y;
            for &(other, _, other_block) in stencil.iter().filter(|(_, k, _)| !self.input.is_pinned[*k]) {
                let product = block.transpose() * other_block * (1.0 / weight);
                for row in 0..2 {
                    for column in 0..2 {
                        let offset = 2 * (other - place) + column as isize - row as isize;
                        matrix.add(2 * j + row, offset, product.col(column)[row]);
                    }
                }
            }
        }
    }

    /// The longest way in a step, relative to the distance of the samples there.
    pub fn relative_size(&self, step: &FairStep) -> f64 {
        step.ways.iter().enumerate().map(|(i, way)| way.length() / self.weight(i)).fold(0.0, f64::max)
    }
}
