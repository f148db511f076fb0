//! The path along existing edges that lies nearest to a line.
//!
//! Of all paths along polygon edges in the line's band (`band`) it is the one with the least integral of the distance
//! from the line, so it goes straight where edges do and changes rows only where the line does. Since the band is
//! unrolled, the path passes every obstacle on the line's side. The mesh is not changed.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use glam::DVec3;

use crate::band::{Band, is_polygon_edge};
use crate::error::{OptionError, Result};
use crate::ids::{TriangleId, VertexId};
use crate::mesh::SurfaceMesh;
use crate::polyline::Polyline;

/// A path along edges.
#[derive(Clone, PartialEq, Debug)]
pub struct EdgePath {
    /// Its vertices in order; a closed path does not repeat its first.
    pub vertices: Vec<VertexId>,
    /// Whether the last vertex is joined to the first.
    pub closed: bool,
    /// Largest distance from the line.
    pub max_distance: f64,
    /// Mean distance from the line, along the path.
    pub mean_distance: f64,
}

/// Segments of the line that are looked at on each side of where a triangle of the band is, at least.
const WINDOW: usize = 12;

/// A path may be longer by this part for each part that it is nearer, so that of two paths of the same distance the
/// shorter one is found; in mean edge lengths of the strip.
const PRICE_OF_LENGTH: f64 = 1e-3;

/// An edge between two vertices of the band.
#[derive(Clone, Copy)]
struct Link {
    to: u32,
    length: f64,
    mean: f64,
    max: f64,
}

/// The path along existing edges nearest to `line`: from the nearest vertex of the polygon that the line begins in to that
/// of the one it ends in; for a closed line a closed one.
///
/// # Errors
/// No such path: the edges round the line do not hang together there (walls, boundaries).
///
/// Cost: O(n log n) in the triangles of the band.
pub fn edge_path(mesh: &SurfaceMesh, line: &Polyline) -> Result<EdgePath> {
    let period = line.strip.len();
    let rounds = if line.closed { 3 } else { 1 };
    let strip: Vec<TriangleId> = std::iter::repeat_n(&line.strip, rounds).flatten().copied().collect();
    let band = Band::new(mesh, &strip);
    let links = find_links(mesh, line, &band, period);
    let found =
        if line.closed { find_closed(mesh, &band, &links, period) } else { find_open(mesh, line, &band, &links) };
    let Some(path) = found else {
        let message =
            "has no path along edges near it that keeps to its side of every obstacle; cut it into the mesh instead";
        return Err(OptionError::new("line", message).into());
    };
    let Trail { mut vertices, links } = shorten(mesh, &band, &links, &path);
    let length: f64 = links.iter().map(|link| link.length).sum();
    let mut integral: f64 = links.iter().map(|link| link.length * link.mean).sum();
    let mut max = links.iter().map(|link| link.max).fold(0.0, f64::max);
    if line.closed && vertices.len() > 1 {
        vertices.pop();
    }
    if length == 0.0 {
        let near = Window { points: &line.points, closed: line.closed };
        max = near.distance(0, mesh.position(vertices[0]));
        integral = max;
    }
    let mean_distance = if length == 0.0 { integral } else { integral / length };
    Ok(EdgePath { vertices, closed: line.closed, max_distance: max, mean_distance })
}

/// A path by its vertices on the mesh and the edges between them.
struct Trail {
    vertices: Vec<VertexId>,
    links: Vec<Link>,
}

/// A path of the band on the mesh, without edges that it goes along there and at once back again: where the line turns
/// sharply at a pick, the band lies over itself.
fn shorten(mesh: &SurfaceMesh, band: &Band, links: &[Vec<Link>], path: &[u32]) -> Trail {
    let mut trail = Trail { vertices: vec![band.over(mesh, path[0])], links: Vec::new() };
    for pair in path.windows(2) {
        let to = band.over(mesh, pair[1]);
        let Some(link) = links[pair[0] as usize].iter().find(|link| link.to == pair[1]) else { continue };
        let count = trail.vertices.len();
        if count > 1 && trail.vertices[count - 2] == to {
            trail.vertices.pop();
            trail.links.pop();
        } else {
            trail.vertices.push(to);
            trail.links.push(*link);
        }
    }
    trail
}

/// The line as segments, of which those near a place are looked at.
struct Window<'a> {
    points: &'a [DVec3],
    closed: bool,
}

impl Window<'_> {
    fn count(&self) -> usize {
        if self.closed { self.points.len() } else { (self.points.len() - 1).max(1) }
    }

    fn to_segment(&self, segment: usize, p: DVec3) -> f64 {
        let (a, b) = (self.points[segment], self.points[(segment + 1) % self.points.len()]);
        let along = b - a;
        let square = along.length_squared();
        let t = if square > 0.0 { ((p - a).dot(along) / square).clamp(0.0, 1.0) } else { 0.0 };
        p.distance(a + t * along)
    }

    /// Distance from the stretch of the line about a segment: as far as the window, and on while it comes nearer.
    fn distance(&self, segment: usize, p: DVec3) -> f64 {
        let count = self.count();
        let step = |s: usize, forward: bool| match (forward, self.closed) {
            (true, true) => Some((s + 1) % count),
            (false, true) => Some((s + count - 1) % count),
            (true, false) => Some(s + 1).filter(|&s| s < count),
            (false, false) => s.checked_sub(1),
        };
        let mut best = self.to_segment(segment, p);
        for forward in [true, false] {
            let mut here = segment;
            for walked in 0..count {
                let Some(next) = step(here, forward) else { break };
                here = next;
                let there = self.to_segment(here, p);
                if walked >= WINDOW && there >= best {
                    break;
                }
                best = best.min(there);
            }
        }
        best
    }
}

/// For each vertex of the band its polygon edges, with their distances from the line.
fn find_links(mesh: &SurfaceMesh, line: &Polyline, band: &Band, period: usize) -> Vec<Vec<Link>> {
    let near = Window { points: &line.points, closed: line.closed };
    let segments = segments_of_strip(line);
    let mut links: Vec<Vec<Link>> = vec![Vec::new(); band.vertex_bound()];
    for (id, at) in band.triangles().iter().enumerate() {
        for h in at.triangle.halfedges().into_iter().filter(|&h| is_polygon_edge(mesh, h)) {
            let k = h.side() as usize;
            let (a, b) = (band.vertex(id as u32, k), band.vertex(id as u32, (k + 1) % 3));
            if links[a as usize].iter().any(|link| link.to == b) {
                continue;
            }
            let [p, q] = mesh.ends(h).map(|v| mesh.position(v));
            let segment = segments[at.place % period];
            let d: [f64; 5] = std::array::from_fn(|i| near.distance(segment, p.lerp(q, i as f64 / 4.0)));
            // Simpson's rule on both halves.
            let mean = (d[0] + 4.0 * d[1] + 2.0 * d[2] + 4.0 * d[3] + d[4]) / 12.0;
            let max = d.into_iter().fold(0.0, f64::max);
            let link = Link { to: b, length: p.distance(q), mean, max };
            links[a as usize].push(link);
            links[b as usize].push(Link { to: a, ..link });
        }
    }
    links
}

/// For each triangle of the strip a segment of the line in it, or the last one before it.
fn segments_of_strip(line: &Polyline) -> Vec<usize> {
    let mut segments = Vec::with_capacity(line.strip.len());
    let mut next = 0;
    for triangle in &line.strip {
        while line.segment_triangles.get(next) == Some(triangle)
            && line.segment_triangles.get(next + 1) == Some(triangle)
        {
            next += 1;
        }
        segments.push(next.min(line.segment_triangles.len().saturating_sub(1)));
        if line.segment_triangles.get(next) == Some(triangle) {
            next += 1;
        }
    }
    segments
}

fn find_open(mesh: &SurfaceMesh, line: &Polyline, band: &Band, links: &[Vec<Link>]) -> Option<Vec<u32>> {
    let nearest = |triangle: u32, p: DVec3| {
        let corners = band.polygon_of(mesh, triangle).into_iter().flat_map(|t| (0..3).map(move |k| (t, k)));
        let vertices = corners.map(|(t, k)| band.vertex(t, k));
        vertices.min_by(|&a, &b| {
            let off = |v: u32| mesh.position(band.over(mesh, v)).distance(p);
            off(a).total_cmp(&off(b)).then(a.cmp(&b))
        })
    };
    let start = nearest(0, *line.points.first()?)?;
    let goal = nearest(line.strip.len() as u32 - 1, *line.points.last()?)?;
    search(links, start, goal, &[], f64::INFINITY).map(|(path, _)| path)
}

/// Of the paths once round, from a vertex at one triangle of the strip to the same one a period later, the nearest.
fn find_closed(mesh: &SurfaceMesh, band: &Band, links: &[Vec<Link>], period: usize) -> Option<Vec<u32>> {
    let (here, there) = (period as u32, 2 * period as u32);
    let mut starts: Vec<[u32; 2]> = (0..3).map(|k| [band.vertex(here, k), band.vertex(there, k)]).collect();
    for side in 0..3 {
        if let (Some(a), Some(b)) = (band.across(here)[side], band.across(there)[side]) {
            starts.extend((0..3).map(|k| [band.vertex(a, k), band.vertex(b, k)]));
        }
    }
    starts.sort_unstable();
    starts.dedup();
    // A vertex that the line goes round is on every triangle of its strip: no path may shrink to it.
    let ring = |triangle: u32| (0..3).map(move |k| band.vertex(triangle, k));
    let hubs: Vec<u32> = ring(0).filter(|&v| ring(3 * period as u32 - 1).any(|w| w == v)).collect();
    let mut best: Option<(Vec<u32>, f64)> = None;
    for [start, goal] in starts {
        let is_over = band.over(mesh, start) == band.over(mesh, goal);
        if start == goal || !is_over || hubs.contains(&start) {
            continue;
        }
        let limit = best.as_ref().map_or(f64::INFINITY, |(_, cost)| *cost);
        best = search(links, start, goal, &hubs, limit).or(best);
    }
    best.map(|(path, _)| path)
}

/// Cheapest path (Dijkstra 1959) below `limit`; ties go to the lower vertex.
fn search(links: &[Vec<Link>], start: u32, goal: u32, banned: &[u32], limit: f64) -> Option<(Vec<u32>, f64)> {
    let lengths = links.iter().flatten().map(|link| link.length);
    let count = links.iter().map(Vec::len).sum::<usize>().max(1);
    let price = PRICE_OF_LENGTH * lengths.sum::<f64>() / count as f64;
    let mut cost = vec![f64::INFINITY; links.len()];
    let mut before = vec![u32::MAX; links.len()];
    let mut open = BinaryHeap::new();
    cost[start as usize] = 0.0;
    // Costs are not negative, so their bits are in their order.
    open.push(Reverse((0.0f64.to_bits(), start)));
    while let Some(Reverse((bits, here))) = open.pop() {
        if here == goal {
            let mut path = vec![goal];
            while path[path.len() - 1] != start {
                path.push(before[path[path.len() - 1] as usize]);
            }
            path.reverse();
            return Some((path, cost[goal as usize]));
        }
        if bits > cost[here as usize].to_bits() {
            continue;
        }
        for link in &links[here as usize] {
            let there = cost[here as usize] + link.length * (link.mean + price);
            if there < cost[link.to as usize] && there < limit && !banned.contains(&link.to) {
                cost[link.to as usize] = there;
                before[link.to as usize] = here;
                open.push(Reverse((there.to_bits(), link.to)));
            }
        }
    }
    None
}
