//! The mesh with lines put into it, as a map for routes: the shortest way between two vertices that steps over as few lines
//! as there is need to, or over none.
//!
//! Whether a crossing is forced is decided here, and where a way round is. Smooths nothing.
//!
//! Source: E. W. Dijkstra (1959), on the triangles of the cut mesh; the cost is first the lines stepped over, then the length.

use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap};
use std::ops::ControlFlow;

use glam::DVec3;

use crate::adjacency::Adjacency;
use crate::embed::Embedding;
use crate::error::{Error, Result};
use crate::ids::TriangleId;
use crate::mesh::SurfaceMesh;
use crate::polyline::{Polyline, length_of};
use crate::regions::Regions;
use crate::report::{Observer, Step};
use crate::spot::in_triangle;
use crate::surface_point::SurfacePoint;

/// Triangles taken from the queue between two calls of the observer; about a millisecond.
const POPS_PER_OBSERVATION: u32 = 4096;

/// A route keeps off lines: next to one, a step counts as much longer as this part of the way between the ends is to the
/// distance from the line.
const CLEARANCE: f64 = 0.1;

/// Barycentric: how far apart lines are kept. Little, for the lines are to stay where they are; but enough for a way between.
const TOLERANCE: f64 = 1e-6;

/// See the module.
#[derive(Debug)]
pub struct Opened {
    /// Triangles of the cut mesh.
    pub triangles: Vec<[u32; 3]>,
    /// The triangle of the mesh that each is a piece of.
    parents: Vec<u32>,
    adjacency: Adjacency,
    centres: Vec<DVec3>,
    /// The lines along each edge, lower end first. Looked up, never walked through.
    lines: HashMap<[u32; 2], Vec<u32>>,
    is_on_line: Vec<bool>,
    /// The triangles at each vertex on a line. Only sums over all of it hang on no order.
    fans: HashMap<u32, Vec<u32>>,
}

/// A way from vertex to vertex of the cut mesh.
#[derive(Clone, Debug)]
pub struct Way {
    /// Lines that it steps over, each as often as it does.
    pub crossings: u32,
    /// Length over the middles of the sides that it steps over.
    pub length: f64,
    /// From the first vertex over those middles to the last.
    pub points: Vec<SurfacePoint>,
}

/// What a way may do.
#[derive(Clone, Copy)]
pub struct Limits<'a> {
    /// A line that counts for nothing.
    pub ignored: Option<u32>,
    /// Patches of the cut mesh's triangles, and the one to stay in, stepping over no line.
    pub patch: Option<(&'a [u32], u32)>,
    /// Whether to keep off lines where there is room.
    pub keeps_off: bool,
}

impl Opened {
    /// The cut mesh. Cost: O(triangles).
    pub fn new(mesh: &SurfaceMesh, embedding: &Embedding) -> Self {
        let cut = embedding.triangles(mesh);
        let positions = embedding.positions(mesh);
        let mut lines: HashMap<[u32; 2], Vec<u32>> = HashMap::new();
        let mut is_on_line = vec![false; positions.len()];
        for line in 0..embedding.chains.len() {
            for [a, b] in embedding.edges_of(line) {
                let owners = lines.entry([a.min(b), a.max(b)]).or_default();
                if owners.last() != Some(&(line as u32)) {
                    owners.push(line as u32);
                }
                (is_on_line[a as usize], is_on_line[b as usize]) = (true, true);
            }
            embedding.chains[line].iter().for_each(|point| is_on_line[point.vertex as usize] = true);
        }
        let mut fans: HashMap<u32, Vec<u32>> = HashMap::new();
        for (t, corners) in (0..).zip(&cut.triangles) {
            for &v in corners.iter().filter(|&&v| is_on_line[v as usize]) {
                fans.entry(v).or_default().push(t);
            }
        }
        let centre = |corners: &[u32; 3]| corners.iter().map(|&v| positions[v as usize]).sum::<DVec3>() / 3.0;
        Self {
            centres: cut.triangles.iter().map(centre).collect(),
            adjacency: Adjacency::new(&cut.triangles, positions.len()),
            triangles: cut.triangles,
            parents: cut.parents,
            lines,
            is_on_line,
            fans,
        }
    }

    /// The best ways from a vertex on a line to others, in their order; `None` where there is none.
    ///
    /// # Errors
    /// [`Error::Interrupted`].
    pub fn find_ways(
        &self,
        mesh: &SurfaceMesh,
        embedding: &Embedding,
        from: u32,
        goals: &[u32],
        limits: Limits<'_>,
        observer: &mut dyn Observer,
    ) -> Result<Vec<Option<Way>>> {
        let place = |v: u32| vertex_place(mesh, embedding, v);
        let span = goals.iter().map(|&goal| place(goal).distance(place(from))).fold(0.0, f64::max);
        let clearance = if limits.keeps_off { self.clearance(limits, observer)? } else { Vec::new() };
        let weight = |t: u32| clearance.get(t as usize).map_or(1.0, |distance| 1.0 + CLEARANCE * span / distance);
        let fan = |v: u32| self.fan(v).iter().copied();
        let mut wanted: HashMap<u32, u32> = HashMap::new();
        goals.iter().flat_map(|&goal| fan(goal)).for_each(|t| *wanted.entry(t).or_default() += 1);
        let mut best = vec![((u32::MAX, f64::INFINITY), 0); self.triangles.len()];
        let mut open = BinaryHeap::new();
        for t in fan(from).filter(|&t| limits.allows(t)) {
            let cost = (0, self.centres[t as usize].distance(place(from)) * weight(t));
            best[t as usize] = (cost, t);
            // Costs are not negative, so their bits are in their order.
            open.push(Reverse((cost.0, cost.1.to_bits(), t)));
        }
        let mut pops = 0u32;
        let mut left = wanted.len();
        while let Some(Reverse((crossings, bits, t))) = open.pop() {
            pops = pops.wrapping_add(1);
            if pops % POPS_PER_OBSERVATION == 0 && observer.step(Step::Search) == ControlFlow::Break(()) {
                return Err(Error::Interrupted);
            }
            let cost = (crossings, f64::from_bits(bits));
            if best[t as usize].0 != cost {
                continue;
            }
            if wanted.contains_key(&t) {
                left -= 1;
                if left == 0 {
                    break;
                }
            }
            for h in TriangleId(t).halfedges() {
                let Some(next) = self.adjacency.twin(h).map(|twin| twin.triangle().0).filter(|&n| limits.allows(n))
                else {
                    continue;
                };
                let over = self.count_over(t, h.side() as usize, limits.ignored);
                if over > 0 && limits.patch.is_some() {
                    continue;
                }
                let step = self.centres[next as usize].distance(self.centres[t as usize]);
                let reached = (crossings + over, cost.1 + step * (weight(t) + weight(next)) / 2.0);
                if reached < best[next as usize].0 {
                    best[next as usize] = (reached, t);
                    open.push(Reverse((reached.0, reached.1.to_bits(), next)));
                }
            }
        }
        let ends = goals.iter().map(|&goal| {
            let costs = fan(goal).map(|t| (best[t as usize].0, t)).filter(|(cost, _)| cost.0 < u32::MAX);
            let (_, last) = costs.min_by(|a, b| a.0.0.cmp(&b.0.0).then(a.0.1.total_cmp(&b.0.1)))?;
            Some(self.way(mesh, embedding, [from, goal], last, &best))
        });
        Ok(ends.collect())
    }

    /// Distance of triangles from lines, over the centres, from half a step on.
    fn clearance(&self, limits: Limits<'_>, observer: &mut dyn Observer) -> Result<Vec<f64>> {
        let mut found = vec![f64::INFINITY; self.triangles.len()];
        let mut open = BinaryHeap::new();
        let seeds = self.fans.values().flatten().copied().filter(|&t| limits.allows(t));
        for t in seeds {
            let size = TriangleId(t).halfedges().into_iter().filter_map(|h| self.adjacency.twin(h));
            let size = size.map(|h| self.centres[h.triangle().index()].distance(self.centres[t as usize]));
            let cost = size.fold(f64::INFINITY, f64::min) / 2.0;
            if cost < found[t as usize] {
                found[t as usize] = cost;
                open.push(Reverse((cost.to_bits(), t)));
            }
        }
        let mut pops = 0u32;
        while let Some(Reverse((bits, t))) = open.pop() {
            pops = pops.wrapping_add(1);
            if pops % POPS_PER_OBSERVATION == 0 && observer.step(Step::Search) == ControlFlow::Break(()) {
                return Err(Error::Interrupted);
            }
            if found[t as usize].to_bits() != bits {
                continue;
            }
            for twin in TriangleId(t).halfedges().into_iter().filter_map(|h| self.adjacency.twin(h)) {
                let next = twin.triangle().0;
                let cost = f64::from_bits(bits) + self.centres[next as usize].distance(self.centres[t as usize]);
                if limits.allows(next) && cost < found[next as usize] {
                    found[next as usize] = cost;
                    open.push(Reverse((cost.to_bits(), next)));
                }
            }
        }
        Ok(found)
    }

    /// The regions between the lines. Cost: O(triangles).
    pub fn regions(&self) -> Regions {
        Regions::new(&self.adjacency, self.triangles.len(), |t, side| self.lines_along(t, side))
    }

    /// The triangles round a vertex on a line.
    pub fn fan(&self, v: u32) -> &[u32] {
        self.fans.get(&v).map_or(&[][..], Vec::as_slice)
    }

    fn lines_along(&self, t: u32, side: usize) -> &[u32] {
        let corners = self.triangles[t as usize];
        let [a, b] = [corners[side], corners[(side + 1) % 3]];
        if !self.is_on_line[a as usize] || !self.is_on_line[b as usize] {
            return &[];
        }
        self.lines.get(&[a.min(b), a.max(b)]).map_or(&[][..], Vec::as_slice)
    }

    /// How many lines lie along a side, less the one that counts for nothing.
    fn count_over(&self, t: u32, side: usize, ignored: Option<u32>) -> u32 {
        self.lines_along(t, side).iter().filter(|&&line| Some(line) != ignored).count() as u32
    }

    fn way(
        &self,
        mesh: &SurfaceMesh,
        embedding: &Embedding,
        ends: [u32; 2],
        last: u32,
        best: &[((u32, f64), u32)],
    ) -> Way {
        let mut steps = vec![last];
        let mut here = last;
        while best[here as usize].1 != here {
            here = best[here as usize].1;
            steps.push(here);
        }
        steps.reverse();
        let at = |v: u32, t: u32| vertex_row(mesh, embedding, v, TriangleId(self.parents[t as usize]));
        let point =
            |t: u32, row: [f64; 3]| SurfacePoint { triangle: TriangleId(self.parents[t as usize]), barycentric: row };
        let mut points = vec![point(steps[0], at(ends[0], steps[0]))];
        for pair in steps.windows(2) {
            let shared = |v: &&u32| self.triangles[pair[1] as usize].contains(v);
            let rows: Vec<_> =
                self.triangles[pair[0] as usize].iter().filter(shared).map(|&v| at(v, pair[0])).collect();
            points.push(point(pair[0], std::array::from_fn(|k| (rows[0][k] + rows[1][k]) / 2.0)));
        }
        points.push(point(last, at(ends[1], last)));
        let places: Vec<DVec3> = points.iter().map(|point| mesh.position_of(point)).collect();
        let length = length_of(&places, false);
        Way { crossings: best[last as usize].0.0, length, points }
    }
}

/// A net's lines put into the mesh, and the map of that.
#[derive(Debug)]
pub struct OpenedNet {
    /// The lines that there are, put into the mesh.
    pub embedding: Embedding,
    /// See [`Opened`].
    pub map: Opened,
    /// Which line of the net each is.
    places: Vec<usize>,
}

impl OpenedNet {
    /// Puts the lines of a net into the mesh.
    ///
    /// # Errors
    /// See [`Embedding::new`].
    pub fn new(mesh: &SurfaceMesh, lines: &[Option<Polyline>]) -> Result<Self> {
        let (places, made): (Vec<usize>, Vec<&Polyline>) =
            lines.iter().enumerate().filter_map(|(i, line)| Some((i, line.as_ref()?))).unzip();
        let embedding = Embedding::new(mesh, &made, TOLERANCE)?;
        let map = Opened::new(mesh, &embedding);
        Ok(Self { embedding, map, places })
    }

    /// The place among the lines that there are of one of the net.
    pub fn place_of(&self, line: usize) -> usize {
        self.places.binary_search(&line).expect("the line has been made")
    }

    /// The lines of the net that there are.
    pub fn places(&self) -> &[usize] {
        &self.places
    }

    /// The vertices at both ends of a line, by its place among those that there are.
    pub fn ends(&self, place: usize) -> [u32; 2] {
        let chain = &self.embedding.chains[place];
        [chain[0].vertex, chain[chain.len() - 1].vertex]
    }
}

impl Limits<'_> {
    fn allows(&self, triangle: u32) -> bool {
        self.patch.is_none_or(|(patches, patch)| patches[triangle as usize] == patch)
    }
}

fn vertex_place(mesh: &SurfaceMesh, embedding: &Embedding, v: u32) -> DVec3 {
    match (v as usize).checked_sub(mesh.positions().len()) {
        None => mesh.positions()[v as usize],
        Some(new) => mesh.position_of(&embedding.new[new].point),
    }
}

/// Barycentric parts of a vertex of the cut mesh in a triangle of the mesh that holds it.
fn vertex_row(mesh: &SurfaceMesh, embedding: &Embedding, v: u32, triangle: TriangleId) -> [f64; 3] {
    match (v as usize).checked_sub(mesh.positions().len()) {
        None => mesh.corners(triangle).map(|corner| f64::from(u8::from(corner.0 == v))),
        Some(new) => in_triangle(mesh, &embedding.new[new].point, triangle),
    }
}
