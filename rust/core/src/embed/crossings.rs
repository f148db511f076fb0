//! Where lines meet each other or themselves, and whether they cross there or only touch.
//!
//! Lines are put into the mesh first: then they meet in vertices, and the order of edges round a vertex tells on which
//! side each comes and goes. Where two run along together, the sides at both ends of the common stretch are compared.

use std::collections::{BTreeMap, HashMap, HashSet};

use super::rings::{Ring, find_rings};
use super::{ChainPoint, Embedding};
use crate::error::Result;
use crate::ids::TriangleId;
use crate::mesh::SurfaceMesh;
use crate::polyline::Polyline;
use crate::surface_point::SurfacePoint;

/// A meeting of two lines, or of one with itself.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Crossing {
    /// The vertex of the cut mesh; of a common stretch, its first along the first line.
    pub vertex: u32,
    /// Where it is.
    pub point: SurfacePoint,
    /// Which lines; twice the same where one meets itself.
    pub lines: [u32; 2],
    /// Where on each: the number of the segment and how far along it.
    pub parameters: [f64; 2],
    /// Whether each goes from one side of the other to the other side; else they touch, or one ends on the other.
    pub is_transversal: bool,
}

impl Crossing {
    /// Whether a line and another one meet here.
    pub fn is_between(&self, line: u32) -> bool {
        self.lines.contains(&line) && self.lines[0] != self.lines[1]
    }
}

/// All meetings of `lines` with each other and with themselves, but for ends that two lines share; by lines, then along the
/// first.
///
/// # Errors
/// See [`Embedding::new`].
pub fn find_crossings(mesh: &SurfaceMesh, lines: &[&Polyline]) -> Result<Vec<Crossing>> {
    Ok(Embedding::new(mesh, lines, 0.0)?.crossings(mesh))
}

/// A place on a chain.
#[derive(Clone, Copy)]
struct Place<'a> {
    chain: &'a [ChainPoint],
    closed: bool,
    index: usize,
}

impl Place<'_> {
    fn vertex(&self) -> u32 {
        self.chain[self.index].vertex
    }

    /// The place one further, or one back.
    fn step(&self, forward: bool) -> Option<Self> {
        let count = self.chain.len();
        let index = match (forward, self.closed) {
            (true, true) => Some((self.index + 1) % count),
            (false, true) => Some((self.index + count - 1) % count),
            (true, false) => Some(self.index + 1).filter(|&i| i < count),
            (false, false) => self.index.checked_sub(1),
        };
        index.filter(|_| count > 1).map(|index| Self { index, ..*self })
    }

    fn neighbour(&self, forward: bool) -> Option<u32> {
        self.step(forward).map(|place| place.vertex())
    }

    fn is_end(&self) -> bool {
        self.neighbour(true).is_none() || self.neighbour(false).is_none()
    }
}

impl Embedding {
    /// Meetings of the lines, as [`find_crossings`] tells them.
    pub fn crossings(&self, mesh: &SurfaceMesh) -> Vec<Crossing> {
        let mut visits: BTreeMap<u32, Vec<(u32, usize)>> = BTreeMap::new();
        for (line, chain) in self.chains.iter().enumerate() {
            for (i, point) in chain.iter().enumerate() {
                visits.entry(point.vertex).or_default().push((line as u32, i));
            }
        }
        visits.retain(|_, visits| visits.len() > 1);
        let wanted: HashSet<u32> = visits.keys().copied().collect();
        let (rings, homes) = find_rings(mesh, self, &wanted);
        let mut found = Vec::new();
        for (&vertex, visits) in &visits {
            for (n, &second) in visits.iter().enumerate() {
                for &first in &visits[..n] {
                    let [a, b] = [first, second].map(|(line, index)| Place {
                        chain: &self.chains[line as usize],
                        closed: self.closed[line as usize],
                        index,
                    });
                    if let Some(is_transversal) = judge(&rings, a, b) {
                        found.push(Crossing {
                            vertex,
                            point: self.point_of(mesh, vertex, &homes),
                            lines: [first.0, second.0],
                            parameters: [a.chain[a.index].parameter, b.chain[b.index].parameter],
                            is_transversal,
                        });
                    }
                }
            }
        }
        found.sort_by(|p, q| p.lines.cmp(&q.lines).then(p.parameters[0].total_cmp(&q.parameters[0])));
        found
    }

    fn point_of(&self, mesh: &SurfaceMesh, vertex: u32, homes: &HashMap<u32, TriangleId>) -> SurfacePoint {
        if let Some(new) = (vertex as usize).checked_sub(mesh.positions().len()) {
            return self.new[new].point;
        }
        let triangle = homes.get(&vertex).copied().unwrap_or(TriangleId(0));
        SurfacePoint { triangle, barycentric: mesh.corners(triangle).map(|v| f64::from(u8::from(v.0 == vertex))) }
    }
}

/// Whether two lines cross at places of theirs that are one vertex; `None` where there is nothing to tell: both end there,
/// or they have run along together before.
fn judge(rings: &HashMap<u32, Ring>, a: Place, b: Place) -> Option<bool> {
    let next = a.neighbour(true);
    let back = a.neighbour(false);
    let shares = |one: Option<u32>, forward: bool| one.is_some() && one == b.neighbour(forward);
    for forward in [true, false] {
        if shares(next, forward) {
            // The stretch begins here, unless they have come here together.
            return if shares(back, !forward) {
                None
            } else {
                Some(judge_stretch(rings, a, b, forward).unwrap_or(false))
            };
        }
    }
    if shares(back, true) || shares(back, false) || (a.is_end() && b.is_end()) {
        return None;
    }
    let branches = |place: Place| Some([place.neighbour(false)?, place.neighbour(true)?]);
    let is_crossing =
        branches(a).zip(branches(b)).and_then(|(a_ways, b_ways)| rings.get(&a.vertex())?.parts(a_ways, b_ways));
    Some(is_crossing.unwrap_or(false))
}

/// Whether two lines that run along together from here, `b` onwards or backwards, part to the other side than they met.
fn judge_stretch(rings: &HashMap<u32, Ring>, a: Place, b: Place, forward: bool) -> Option<bool> {
    let (a_back, b_back) = (a.neighbour(false)?, b.neighbour(!forward)?);
    let ring = rings.get(&a.vertex())?;
    let mut next = a.neighbour(true)?;
    let mut piece = ring.piece_at(next)?;
    let is_b_first = ring.first_of(next, piece, &[a_back, b_back])?.0 == b_back;
    let (mut a, mut b) = (a, b);
    let mut left = a.chain.len() + b.chain.len();
    loop {
        let from = a.vertex();
        (a, b) = (a.step(true)?, b.step(forward)?);
        let (a_next, b_next) = (a.neighbour(true)?, b.neighbour(forward)?);
        let ring = rings.get(&a.vertex())?;
        if a_next != b_next {
            let is_still_first = ring.first_of(from, piece, &[a_next, b_next])?.0 == b_next;
            return Some(is_still_first != is_b_first);
        }
        next = a_next;
        piece = ring.first_of(from, piece, &[next])?.1;
        left = left.checked_sub(1)?;
    }
}
