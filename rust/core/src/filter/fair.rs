//! The `fair` filter: the smoothest line near its input, one Gauss-Newton step at a time on one strip.
//!
//! Energy: integral of squared geodesic curvature, plus `detail_size^-4` times the integral of the squared distance to the
//! input. Arc lengths are those of the line at the start of a step and are held fixed within it, so a minimum exists. In
//! the plane and for small slopes a wiggle of wavelength L keeps `1 / (1 + (2 pi detail_size / L)^4)` of its height,
//! whatever the triangulation, and without closeness the line through its pins is the natural cubic spline.
//!
//! Discretisation: the turn at each vertex of the line, measured in the unfolded triangles, squared, over half the length
//! of both segments. That is a cubic spline with lumped mass (C. H. Reinsch 1967, *Smoothing by Spline Functions*).
//!
//! The geometry of turns is in `turns`, the rounds with vertex passes in `smooth_fair`.

use glam::DVec3;

use crate::ids::VertexId;
use crate::mesh::SurfaceMesh;
use crate::relax::banded::Banded;
use crate::route::Route;
use crate::turns::{LineTurns, Node};

/// Segments shorter than this share of the mean count as that long in weights, so that a crowd of crossings at a mesh
/// vertex does not swamp the rest of the system.
const SHORTEST_SHARE: f64 = 1e-3;

/// Crossings stay this far from the ends of their edges, in barycentric units: no two ever coincide, so turns are always
/// defined. Step D moves the line over a vertex that it presses against.
pub const END_GAP: f64 = 1e-4;

/// Shares of a step that are tried: 1, 1/2, 1/4, ...
const MAX_HALVINGS: i32 = 8;

/// Times that crossings which must stay at the end of their edge are held there and the others solved for again.
const MAX_HOLDS: u32 = 8;

/// Added to the diagonal, relative to it, so that a crossing that nothing depends on stays where it is.
const STIFFENING: f64 = 1e-9;

/// What the result stays near.
#[derive(Clone, Debug)]
pub struct Input {
    /// Points of the input line.
    pub points: Vec<DVec3>,
    /// Whether it is closed.
    pub closed: bool,
    /// Length in the units of the positions; infinite: no closeness.
    pub detail_size: f64,
}

/// What one step did.
#[derive(Clone, PartialEq, Debug)]
pub struct FairStep {
    /// Energy before, with the arc lengths of the step.
    pub before: f64,
    /// Energy after, with the same arc lengths: never above `before`.
    pub after: f64,
    /// Largest move of a vertex, relative to the mean segment.
    pub largest_move: f64,
    /// Leg and letter of the crossings that press against an end of their edge: the line would go on beyond it.
    pub pressing: Vec<(usize, usize)>,
}

/// One Gauss-Newton step on the strip of `route`; where no share of it lowers the energy, nothing moves and
/// `largest_move` is 0. `None` for a line of a single point.
///
/// Crossings that come to the end of their edge on the way stop there and are `pressing`. Those that press against a
/// vertex that `is_blocked` names are held, and the others solved for again. Cost: O(crossings).
pub fn step_fair(
    mesh: &SurfaceMesh,
    route: &mut Route,
    input: &Input,
    is_blocked: impl Fn(VertexId) -> bool,
) -> Option<FairStep> {
    let line = LineTurns::of_route(mesh, route)?;
    let weights = Weights::new(&line, input);
    let before = weights.energy(&line);
    let end_of = |node: &Node, change: f64| {
        let (leg, letter) = node.crossing?;
        let [low, high] = mesh.sorted_ends(route.legs[leg].word[letter]);
        Some(if change < 0.0 { low } else { high })
    };
    let (step, is_held) = solve_held(&line, &weights, |node, change| end_of(node, change).is_some_and(&is_blocked))?;
    // How much of the step each crossing can take before it comes to the end of its edge.
    let room: Vec<f64> = line.nodes.iter().zip(&step).map(|(node, &change)| room_for(node, change)).collect();
    let pressing_within = |share: f64| {
        let presses = |i: &usize| line.nodes[*i].crossing.is_some() && !is_held[*i] && room[*i] <= share;
        (0..line.nodes.len()).filter(presses).filter_map(|i| line.nodes[i].crossing).collect::<Vec<_>>()
    };
    // The largest share that lowers the energy; a crossing that stops on the way makes a kink, which may cost more than the
    // rest gains. Up to where the first one stops there is none.
    let first_stop = room.iter().copied().filter(|&r| r > 0.0).fold(1.0, f64::min);
    let halves = (0..MAX_HALVINGS).map(|k| 0.5f64.powi(k)).take_while(|&share| share > first_stop);
    let start = route.clone();
    for share in halves.chain([first_stop, 0.5 * first_stop, 0.1 * first_stop]) {
        let mut largest_move: f64 = 0.0;
        for (node, change) in line.nodes.iter().zip(&step) {
            if let Some((leg, letter)) = node.crossing {
                let t = (node.parameter + share * change).clamp(END_GAP, 1.0 - END_GAP);
                route.legs[leg].parameters[letter] = t;
                largest_move = largest_move.max(node.slide.length() * (t - node.parameter).abs());
            }
        }
        let after = weights.energy(&LineTurns::of_route(mesh, route)?);
        if after < before {
            let pressing = pressing_within(share);
            return Some(FairStep { before, after, largest_move: largest_move / weights.mean, pressing });
        }
    }
    *route = start;
    Some(FairStep { before, after: before, largest_move: 0.0, pressing: pressing_within(0.0) })
}

/// The share of a change that a crossing can take; above 1 where it does not come to the end of its edge.
fn room_for(node: &Node, change: f64) -> f64 {
    let limit = if change < 0.0 { END_GAP } else { 1.0 - END_GAP };
    if change == 0.0 || node.crossing.is_none() { f64::INFINITY } else { ((limit - node.parameter) / change).max(0.0) }
}

/// The unconstrained step, with those crossings held that are at the end of their edge and `must_stay` there. Tells which
/// are held.
fn solve_held(
    line: &LineTurns,
    weights: &Weights,
    must_stay: impl Fn(&Node, f64) -> bool,
) -> Option<(Vec<f64>, Vec<bool>)> {
    let (matrix, right) = weights.assemble(line);
    let mut held: Vec<Option<f64>> = vec![None; line.nodes.len()];
    let mut step = matrix.solve(&right, line.closed)?;
    for _ in 0..MAX_HOLDS {
        let mut is_changed = false;
        for (i, node) in line.nodes.iter().enumerate() {
            let presses = held[i].is_none() && room_for(node, step[i]) <= 0.0;
            if presses && must_stay(node, step[i]) {
                held[i] = Some(0.0);
                is_changed = true;
            }
        }
        if !is_changed {
            break;
        }
        step = solve_given(&matrix, &right, &held, line.closed)?;
    }
    Some((step, held.iter().map(Option::is_some).collect()))
}

/// Solves a symmetric system with some unknowns given.
fn solve_given(matrix: &Banded, right: &[f64], given: &[Option<f64>], is_ring: bool) -> Option<Vec<f64>> {
    let mut reduced = matrix.clone();
    let values: Vec<f64> = given.iter().map(|g| g.unwrap_or(0.0)).collect();
    let moved = matrix.multiply(&values, is_ring);
    let mut rest: Vec<f64> = right.iter().zip(&moved).map(|(r, m)| r - m).collect();
    for (i, value) in given.iter().enumerate() {
        if let Some(value) = value {
            reduced.fix(i);
            reduced.clear_column(i);
            rest[i] = *value;
        }
    }
    reduced.solve(&rest, is_ring)
}

/// Arc lengths and nearest points of the input, held fixed within a step.
struct Weights {
    /// Half the length of both segments at a node.
    halves: Vec<f64>,
    /// Nearest points of the input; empty without closeness.
    nearest: Vec<DVec3>,
    closeness: f64,
    mean: f64,
}

impl Weights {
    fn new(line: &LineTurns, input: &Input) -> Self {
        let count = line.nodes.len();
        let mean = line.lengths.iter().sum::<f64>() / count.max(1) as f64;
        let floor = (SHORTEST_SHARE * mean).max(f64::MIN_POSITIVE);
        let halves = (0..count)
            .map(|i| {
                let before = line.previous(i).map_or(0.0, |j| line.lengths[j].max(floor));
                let after = line.next(i).map_or(0.0, |_| line.lengths[i].max(floor));
                0.5 * (before + after)
            })
            .collect();
        let closeness = input.detail_size.powi(-4);
        let nearest = if closeness > 0.0 { nearest_points(line, input) } else { Vec::new() };
        Self { halves, nearest, closeness, mean }
    }

    fn energy(&self, line: &LineTurns) -> f64 {
        (0..line.nodes.len())
            .map(|i| {
                let half = self.halves[i];
                let bend = if half > 0.0 { line.turns[i].angle.powi(2) / half } else { 0.0 };
                bend + self.closeness * half * self.offset(line, i).powi(2)
            })
            .sum()
    }

    /// Distance of a node from the input, along the surface and across the line, to the left.
    fn offset(&self, line: &LineTurns, i: usize) -> f64 {
        let Some(&nearest) = self.nearest.get(i) else { return 0.0 };
        line.left[i].dot(line.nodes[i].position - nearest)
    }

    /// The normal equations of the linearised least-squares problem; pins do not move.
    fn assemble(&self, line: &LineTurns) -> (Banded, Vec<f64>) {
        let count = line.nodes.len();
        let mut matrix = Banded::zero(count, 2);
        let mut right = vec![0.0; count];
        let is_free = |i: usize| line.nodes[i].crossing.is_some();
        for i in 0..count {
            let half = self.halves[i];
            if half <= 0.0 {
                continue;
            }
            let turn = &line.turns[i];
            let around =
                [(line.previous(i), -1, turn.by_previous), (Some(i), 0, turn.by_self), (line.next(i), 1, turn.by_next)];
            for &(j, at_j, slope_j) in &around {
                let Some(j) = j.filter(|&j| is_free(j)) else { continue };
                right[j] -= slope_j * turn.angle / half;
                for &(k, at_k, slope_k) in &around {
                    if k.is_some_and(is_free) {
                        matrix.add(j, at_k - at_j, slope_j * slope_k / half);
                    }
                }
            }
            if is_free(i) && self.closeness > 0.0 {
                let slope = line.left[i].dot(line.nodes[i].slide);
                matrix.add(i, 0, self.closeness * half * slope * slope);
                right[i] -= self.closeness * half * slope * self.offset(line, i);
            }
        }
        for i in 0..count {
            if is_free(i) { matrix.stiffen(i, STIFFENING) } else { matrix.fix(i) }
        }
        (matrix, right)
    }
}

/// The nearest point of the input for every node, sought near where the node before it was nearest.
fn nearest_points(line: &LineTurns, input: &Input) -> Vec<DVec3> {
    /// Segments of the input looked at on each side of the expected one.
    const WINDOW: isize = 48;
    let count = input.points.len() as isize;
    let segments = if input.closed { count } else { count - 1 };
    let mut expected = 0;
    let mut nearest = Vec::with_capacity(line.nodes.len());
    for (i, node) in line.nodes.iter().enumerate() {
        // The first node of a closed line may be anywhere on the input.
        let window = if i == 0 && input.closed { segments } else { WINDOW };
        let mut best = (f64::INFINITY, input.points[0], expected);
        for k in expected - window..=expected + window {
            let k = if input.closed { k.rem_euclid(segments) } else { k };
            if !(0..segments).contains(&k) {
                continue;
            }
            let foot =
                foot_on_segment(node.position, input.points[k as usize], input.points[((k + 1) % count) as usize]);
            let distance = foot.distance_squared(node.position);
            if distance < best.0 {
                best = (distance, foot, k);
            }
        }
        expected = best.2;
        nearest.push(best.1);
    }
    nearest
}

/// The point of a segment that is nearest to `p`.
fn foot_on_segment(p: DVec3, from: DVec3, to: DVec3) -> DVec3 {
    let d = to - from;
    let square = d.length_squared();
    if square > 0.0 { from + ((p - from).dot(d) / square).clamp(0.0, 1.0) * d } else { from }
}
