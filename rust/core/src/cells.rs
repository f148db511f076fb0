//! Which pick each triangle is nearest to, and which picks are neighbours by that.
//!
//! The cells of picks are a Voronoi diagram on the surface, its distances those of step B's dual graph; picks whose cells
//! share a border are joined, which is the Delaunay graph of the picks: where all cells are discs and no four meet in a
//! point, it parts a closed surface into triangles. Makes no lines.

use std::cmp::Reverse;
use std::collections::{BTreeSet, BinaryHeap};
use std::ops::ControlFlow;

use crate::error::{Error, Result};
use crate::ids::TriangleId;
use crate::mesh::SurfaceMesh;
use crate::report::{Observer, Step};
use crate::spot::triangles_round;
use crate::surface_point::SurfacePoint;

/// No pick.
const NONE: u32 = u32::MAX;

/// Triangles taken from the queue between two calls of the observer; about a millisecond.
const POPS_PER_OBSERVATION: u32 = 4096;

/// Pairs of picks whose cells share a border, lower first, in order; picks at one place count once, by the first.
///
/// # Errors
/// [`Error::Interrupted`].
///
/// Cost: O(n log n) in the triangles of the parts with picks.
pub fn find_neighbours(
    mesh: &SurfaceMesh,
    points: &[SurfacePoint],
    observer: &mut dyn Observer,
) -> Result<Vec<[u32; 2]>> {
    let cells = find_cells(mesh, points, observer)?;
    let mut borders: BTreeSet<[u32; 2]> = BTreeSet::new();
    for (t, &cell) in cells.iter().enumerate().filter(|(_, cell)| **cell != NONE) {
        for h in TriangleId(t as u32).halfedges() {
            let other = mesh.twin(h).map_or(NONE, |twin| cells[twin.triangle().index()]);
            if other != NONE && cell < other {
                borders.insert([cell, other]);
            }
        }
    }
    Ok(borders.into_iter().collect())
}

/// The nearest pick of each triangle (multi-source Dijkstra 1959; ties go to the lower pick); `u32::MAX` where none can be
/// reached.
fn find_cells(mesh: &SurfaceMesh, points: &[SurfacePoint], observer: &mut dyn Observer) -> Result<Vec<u32>> {
    let count = mesh.triangles().len();
    let mut cells = vec![NONE; count];
    let mut costs = vec![f64::INFINITY; count];
    let mut open = BinaryHeap::new();
    let graph = mesh.dual_graph();
    for (pick, point) in (0..).zip(points) {
        let place = mesh.position_of(point);
        for t in triangles_round(mesh, point) {
            let cost = graph.barycentre(t).distance(place);
            if cost < costs[t.index()] {
                (costs[t.index()], cells[t.index()]) = (cost, pick);
                // Costs are not negative, so their bits are in their order.
                open.push(Reverse((cost.to_bits(), pick, t.0)));
            }
        }
    }
    let mut pops = 0u32;
    while let Some(Reverse((bits, pick, t))) = open.pop() {
        pops = pops.wrapping_add(1);
        if pops % POPS_PER_OBSERVATION == 0 && observer.step(Step::Search) == ControlFlow::Break(()) {
            return Err(Error::Interrupted);
        }
        if costs[t as usize].to_bits() != bits || cells[t as usize] != pick {
            continue;
        }
        let here = graph.barycentre(TriangleId(t));
        for twin in TriangleId(t).halfedges().into_iter().filter_map(|h| mesh.twin(h)) {
            let next = twin.triangle();
            let cost = costs[t as usize] + graph.barycentre(next).distance(here);
            if cost < costs[next.index()] {
                (costs[next.index()], cells[next.index()]) = (cost, pick);
                open.push(Reverse((cost.to_bits(), pick, next.0)));
            }
        }
    }
    Ok(cells)
}
