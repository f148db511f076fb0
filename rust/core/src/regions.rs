//! What lines part a mesh into, as a graph: regions, and the lines that lie between two of them.
//!
//! It tells how many lines a way between two vertices has to step over, without looking for the way. Holds no geometry.

use std::collections::{BTreeSet, VecDeque};

use crate::adjacency::Adjacency;
use crate::ids::TriangleId;

/// See the module.
#[derive(Debug)]
pub struct Regions {
    /// The region of each triangle.
    of_triangles: Vec<u32>,
    /// For each region those beside it, each with the lines along the edges between; one entry for each set of lines.
    beside: Vec<Vec<(u32, Vec<u32>)>>,
}

impl Regions {
    /// The regions of a mesh. `lines_over` tells the lines along a side of a triangle, none of them twice.
    /// Cost: O(triangles).
    pub fn new<'a>(adjacency: &Adjacency, count: usize, lines_over: impl Fn(u32, usize) -> &'a [u32]) -> Self {
        let mut of_triangles = vec![u32::MAX; count];
        let mut regions = 0;
        let mut borders: BTreeSet<(u32, u32)> = BTreeSet::new();
        let mut open = Vec::new();
        for first in 0..count as u32 {
            if of_triangles[first as usize] != u32::MAX {
                continue;
            }
            of_triangles[first as usize] = regions;
            open.push(first);
            while let Some(t) = open.pop() {
                for h in TriangleId(t).halfedges() {
                    let Some(next) = adjacency.twin(h).map(|twin| twin.triangle().0) else { continue };
                    if !lines_over(t, h.side() as usize).is_empty() {
                        borders.insert((t, h.side()));
                    } else if of_triangles[next as usize] == u32::MAX {
                        of_triangles[next as usize] = regions;
                        open.push(next);
                    }
                }
            }
            regions += 1;
        }
        let mut beside: Vec<BTreeSet<(u32, Vec<u32>)>> = vec![BTreeSet::new(); regions as usize];
        for (t, side) in borders {
            let Some(twin) = adjacency.twin(TriangleId(t).halfedge(side)) else { continue };
            let (here, there) = (of_triangles[t as usize], of_triangles[twin.triangle().index()]);
            if here != there {
                beside[here as usize].insert((there, lines_over(t, side as usize).to_vec()));
            }
        }
        Self { of_triangles, beside: beside.into_iter().map(|own| own.into_iter().collect()).collect() }
    }

    /// The fewest lines, less `ignored`, that a way from one of the triangles `from` to one of `to` steps over; `None` where
    /// there is no way.
    pub fn fewest_between(&self, from: &[u32], to: &[u32], ignored: u32) -> Option<u32> {
        let mut best = vec![u32::MAX; self.beside.len()];
        // Steps over no line go first, so that what is taken out is as good as it gets, or was taken out better before.
        let mut open = VecDeque::new();
        for &t in from {
            best[self.of_triangles[t as usize] as usize] = 0;
            open.push_back((0, self.of_triangles[t as usize]));
        }
        while let Some((cost, region)) = open.pop_front() {
            if best[region as usize] < cost {
                continue;
            }
            for (next, lines) in &self.beside[region as usize] {
                let reached = cost + lines.iter().filter(|&&line| line != ignored).count() as u32;
                if reached < best[*next as usize] {
                    best[*next as usize] = reached;
                    if reached == cost { open.push_front((reached, *next)) } else { open.push_back((reached, *next)) }
                }
            }
        }
        to.iter().map(|&t| best[self.of_triangles[t as usize] as usize]).min().filter(|&cost| cost < u32::MAX)
    }
}
