//! Crossings of a net's lines that the picks do not force, taken out.
//!
//! Two lines that share an end pick and cross elsewhere, or that cross twice, enclose something between them that one of
//! them can be led round: it is sent along the other as far as the crossing, and smoothed from there. A line that crosses
//! itself loses the loop. Where lines still cross, the way between a line's picks that steps over the fewest others is looked
//! for on the whole surface (`opened`); if it steps over fewer than the line crosses, the line takes it. A change is kept
//! only where fewer crossings remain in all, so this ends. What then remains is forced, as the other lines lie: no way
//! between the picks of either line crosses fewer.

use std::collections::BTreeMap;

use crate::embed::crossings::{Crossing, find_crossings};
use crate::error::Result;
use crate::mesh::SurfaceMesh;
use crate::opened::{Limits, OpenedNet};
use crate::options::{Options, Pinned};
use crate::polyline::Polyline;
use crate::report::Observer;
use crate::surface_point::SurfacePoint;
use crate::way::{follow, lead};

/// Changes that are tried for each line of a net.
const ATTEMPTS_PER_LINE: usize = 4;

/// A stretch of a line that is to go along another one instead.
struct Detour {
    /// The line that is changed.
    line: usize,
    points: Vec<SurfacePoint>,
}

/// Takes crossings out of `lines`, `None` where a line could not be made; `pairs[i]` are the picks that line `i` joins.
/// Without `far`, lines go round others only where the two enclose something. Returns the crossings that remain, whose lines
/// are places in `lines`.
///
/// # Errors
/// [`crate::Error::Interrupted`], and what [`find_crossings`] may raise. A line that cannot be smoothed anew stays as it is.
pub fn untangle(
    mesh: &SurfaceMesh,
    lines: &mut [Option<Polyline>],
    pairs: &[[i128; 2]],
    options: &Options,
    far: bool,
    observer: &mut dyn Observer,
) -> Result<Vec<Crossing>> {
    let mut crossings = find_transversal(mesh, lines)?;
    loop {
        crossings = part_pairs(mesh, lines, pairs, options, crossings, observer)?;
        if !far || !lead_round(mesh, lines, options, &mut crossings, observer)? {
            return Ok(crossings);
        }
    }
}

/// Takes out crossings of lines that enclose something; returns those that remain.
fn part_pairs(
    mesh: &SurfaceMesh,
    lines: &mut [Option<Polyline>],
    pairs: &[[i128; 2]],
    options: &Options,
    mut crossings: Vec<Crossing>,
    observer: &mut dyn Observer,
) -> Result<Vec<Crossing>> {
    let mut left = ATTEMPTS_PER_LINE * lines.len();
    let mut tried: Vec<(usize, [u64; 2])> = Vec::new();
    while !crossings.is_empty() {
        let detours = propose(lines, pairs, &crossings);
        let mut is_better = false;
        for Detour { line, points } in detours {
            // What was tried once with these two lengths would fail again.
            let name = (line, [points.len() as u64, length_bits(mesh, &points)]);
            if left == 0 || tried.contains(&name) {
                continue;
            }
            tried.push(name);
            left -= 1;
            let Some(changed) = lead(mesh, &points, Pinned::Ends, options, observer)? else { continue };
            let before = lines[line].replace(changed);
            let remaining = find_transversal(mesh, lines)?;
            if remaining.len() < crossings.len() {
                crossings = remaining;
                is_better = true;
                break;
            }
            lines[line] = before;
        }
        if !is_better {
            break;
        }
    }
    Ok(crossings)
}

/// Leads one line after another the way that crosses the fewest others; whether any has changed.
fn lead_round(
    mesh: &SurfaceMesh,
    lines: &mut [Option<Polyline>],
    options: &Options,
    crossings: &mut Vec<Crossing>,
    observer: &mut dyn Observer,
) -> Result<bool> {
    let mut is_changed = false;
    let mut opened = None;
    // Those that have been looked at since the last change.
    let mut seen = vec![false; lines.len()];
    loop {
        let crossed = |line: usize| crossings.iter().filter(|c| c.is_between(line as u32)).count() as u32;
        let next = (0..lines.len()).filter(|&line| !seen[line]).map(|line| (crossed(line), line));
        // The one with most crossings first, the lower of equals.
        let Some((before, line)) = next.max_by_key(|&(count, line)| (count, std::cmp::Reverse(line))) else { break };
        if before == 0 {
            break;
        }
        seen[line] = true;
        let (net, regions) = match opened.take() {
            Some(known) => known,
            None => {
                let net = OpenedNet::new(mesh, lines)?;
                let regions = net.map.regions();
                (net, regions)
            }
        };
        let own = net.place_of(line);
        let ends = net.ends(own);
        let fewest = regions.fewest_between(net.map.fan(ends[0]), net.map.fan(ends[1]), own as u32);
        if fewest.is_some_and(|count| count < before) {
            let limits = Limits { ignored: Some(own as u32), patch: None, keeps_off: true };
            let ways = net.map.find_ways(mesh, &net.embedding, ends[0], &[ends[1]], limits, observer)?;
            let total = crossings.len();
            let is_better = |_: &[Option<Polyline>], left: &[Crossing]| left.len() < total;
            let remaining = match &ways[0] {
                Some(way) => follow(mesh, lines, line, way, options, is_better, observer)?,
                None => None,
            };
            if let Some(remaining) = remaining {
                *crossings = remaining;
                is_changed = true;
                seen.fill(false);
                continue;
            }
        }
        opened = Some((net, regions));
    }
    Ok(is_changed)
}

/// Takes out lines until none cross any more: those stay that cross no shorter one that stays. For nets whose connections
/// nobody asked for by name. Returns for each line whether it stays.
///
/// # Errors
/// See [`find_crossings`].
pub fn drop_crossing(mesh: &SurfaceMesh, lines: &mut [Option<Polyline>]) -> Result<Vec<bool>> {
    let crossings = find_transversal(mesh, lines)?;
    let mut order: Vec<(usize, f64)> =
        lines.iter().enumerate().filter_map(|(i, line)| Some((i, line.as_ref()?.length()))).collect();
    order.sort_by(|a, b| a.1.total_cmp(&b.1));
    let mut stays = vec![true; lines.len()];
    let mut is_placed = vec![false; lines.len()];
    for (line, _) in order {
        let others =
            crossings.iter().map(|crossing| crossing.lines.map(|l| l as usize)).filter_map(|[a, b]| match line {
                _ if a == b => None,
                _ if a == line => Some(b),
                _ if b == line => Some(a),
                _ => None,
            });
        stays[line] = !others.into_iter().any(|other| is_placed[other]);
        is_placed[line] = stays[line];
        if !stays[line] {
            lines[line] = None;
        }
    }
    Ok(stays)
}

/// Crossings, less where lines only touch; lines are named by their places.
pub fn find_transversal(mesh: &SurfaceMesh, lines: &[Option<Polyline>]) -> Result<Vec<Crossing>> {
    let (places, made): (Vec<usize>, Vec<&Polyline>) =
        lines.iter().enumerate().filter_map(|(i, line)| Some((i, line.as_ref()?))).unzip();
    let mut found = find_crossings(mesh, &made)?;
    found.retain(|crossing| crossing.is_transversal);
    for crossing in &mut found {
        crossing.lines = crossing.lines.map(|line| places[line as usize] as u32);
    }
    Ok(found)
}

fn length_bits(mesh: &SurfaceMesh, points: &[SurfacePoint]) -> u64 {
    let places: Vec<_> = points.iter().map(|point| mesh.position_of(point)).collect();
    crate::polyline::length_of(&places, false).to_bits()
}

/// What could be changed, for every two lines that have something between them, and every line with a loop.
fn propose(lines: &[Option<Polyline>], pairs: &[[i128; 2]], crossings: &[Crossing]) -> Vec<Detour> {
    let mut by_lines: BTreeMap<[u32; 2], Vec<&Crossing>> = BTreeMap::new();
    for crossing in crossings {
        by_lines.entry(crossing.lines).or_default().push(crossing);
    }
    let mut detours = Vec::new();
    for ([a, b], met) in by_lines {
        let (a, b) = (a as usize, b as usize);
        let (Some(one), Some(other)) = (&lines[a], &lines[b]) else { continue };
        if a == b {
            let [p, q] = met[0].parameters;
            let (p, q) = (p.min(q), p.max(q));
            let around = [stretch(one, 0.0, p), vec![met[0].point], stretch(one, q, end_of(one))];
            detours.push(Detour { line: a, points: around.concat() });
            continue;
        }
        // Places that both lines share: ends at one pick, and crossings; between two of them something is enclosed.
        let mut shared: Vec<([f64; 2], Option<SurfacePoint>)> =
            met.iter().map(|crossing| (crossing.parameters, Some(crossing.point))).collect();
        for (i, pick) in pairs[a].iter().enumerate() {
            for (j, other_pick) in pairs[b].iter().enumerate() {
                if pick == other_pick {
                    let at = |line: &Polyline, end: usize| if end == 0 { 0.0 } else { end_of(line) };
                    shared.push(([at(one, i), at(other, j)], None));
                }
            }
        }
        shared.sort_by(|p, q| p.0[0].total_cmp(&q.0[0]));
        for pair in shared.windows(2) {
            let ([p, q], [s, t]) = (pair[0].0, pair[1].0);
            // The first along the second's way, and the second along the first's.
            detours.push(Detour { line: a, points: exchange(one, [p, s], other, [q, t], [pair[0].1, pair[1].1]) });
            let is_same_way = q < t;
            let (from, to) = if is_same_way { (0, 1) } else { (1, 0) };
            let (own, theirs) = ([[q, t][from], [q, t][to]], [[p, s][from], [p, s][to]]);
            let joints = [pair[from].1, pair[to].1];
            detours.push(Detour { line: b, points: exchange(other, own, one, theirs, joints) });
        }
    }
    detours
}

fn end_of(line: &Polyline) -> f64 {
    (line.points.len() - 1) as f64
}

/// `line` with its stretch between two parameters replaced by another line's.
fn exchange(
    line: &Polyline,
    own: [f64; 2],
    other: &Polyline,
    theirs: [f64; 2],
    joints: [Option<SurfacePoint>; 2],
) -> Vec<SurfacePoint> {
    let mut points = stretch(line, 0.0, own[0]);
    points.extend(joints[0]);
    points.extend(stretch(other, theirs[0], theirs[1]));
    points.extend(joints[1]);
    points.extend(stretch(line, own[1], end_of(line)));
    points
}

/// Points of a line from one parameter to another, backwards where the second is less.
fn stretch(line: &Polyline, from: f64, to: f64) -> Vec<SurfacePoint> {
    let (low, high) = (from.min(to).ceil() as usize, from.max(to).floor() as usize);
    let mut points = if low <= high { line.surface_points[low..=high].to_vec() } else { Vec::new() };
    if from > to {
        points.reverse();
    }
    points
}
