//! Lines more for a net, so that its patches have three sides or four: the shortest diagonals of patches with more.
//!
//! A diagonal joins two corners of a patch that are picks and no neighbours on its outline, and runs inside the patch. Patches
//! that are no discs are left alone: a line more need not part them.

use std::collections::{BTreeSet, HashMap};

use crate::embed::crossings::Crossing;
use crate::error::Result;
use crate::mesh::SurfaceMesh;
use crate::opened::{Limits, OpenedNet};
use crate::options::Options;
use crate::patches::{Patches, find_patches};
use crate::polyline::Polyline;
use crate::report::Observer;
use crate::untangle::find_transversal;
use crate::way::follow;

/// Patches with more sides than this are parted.
const MOST_SIDES: u32 = 4;

/// A diagonal that could be.
struct Diagonal {
    picks: [i128; 2],
    ends: [u32; 2],
    /// Whether a line joins the same picks elsewhere: others are better.
    is_second: bool,
    length: f64,
}

/// Adds diagonals to a net whose lines do not cross. `pairs[i]` are the picks that line `i` joins.
///
/// # Errors
/// [`crate::Error::Interrupted`], and what [`find_transversal`] may raise.
///
/// Cost: for each diagonal a few times once through the cut mesh.
pub fn add_diagonals(
    mesh: &SurfaceMesh,
    pairs: &mut Vec<[i128; 2]>,
    lines: &mut Vec<Option<Polyline>>,
    options: &Options,
    observer: &mut dyn Observer,
) -> Result<()> {
    // Patches that no diagonal could be found for, by the picks at their corners.
    let mut hopeless: BTreeSet<Vec<i128>> = BTreeSet::new();
    loop {
        let net = OpenedNet::new(mesh, lines)?;
        let patches = find_patches(mesh, &net.embedding, &net.map.triangles);
        let picks = picks_at(&net, pairs);
        let name = |patch: usize| patches.corners[patch].iter().map(|v| picks.get(v).copied().unwrap_or(-1)).collect();
        let next = (0..patches.patches.len()).find(|&p| excess(&patches, p) > 0 && !hopeless.contains(&name(p)));
        let Some(patch) = next else { return Ok(()) };
        let mut found = find_diagonals(mesh, &net, &patches, patch, &picks, pairs, observer)?;
        found.sort_by(|a, b| a.is_second.cmp(&b.is_second).then(a.length.total_cmp(&b.length)));
        if !take_first(mesh, &net, &patches, patch, found, pairs, lines, options, observer)? {
            hopeless.insert(name(patch));
        }
    }
}

/// Sides that a patch has too many.
fn excess(patches: &Patches, patch: usize) -> u32 {
    let own = &patches.patches[patch];
    if (own.euler, own.loops) == (1, 1) { own.sides.saturating_sub(MOST_SIDES) } else { 0 }
}

/// The pick at each vertex in which lines end.
fn picks_at(net: &OpenedNet, pairs: &[[i128; 2]]) -> HashMap<u32, i128> {
    let ends = net.places().iter().enumerate().map(|(place, &line)| (net.ends(place), pairs[line]));
    ends.flat_map(|(vertices, picks)| vertices.into_iter().zip(picks)).collect()
}

/// All diagonals of a patch.
fn find_diagonals(
    mesh: &SurfaceMesh,
    net: &OpenedNet,
    patches: &Patches,
    patch: usize,
    picks: &HashMap<u32, i128>,
    pairs: &[[i128; 2]],
    observer: &mut dyn Observer,
) -> Result<Vec<Diagonal>> {
    let corners = &patches.corners[patch];
    let count = corners.len();
    let limits = Limits { ignored: None, patch: Some((&patches.of_triangles, patch as u32)), keeps_off: false };
    let mut found = Vec::new();
    for i in 0..count {
        let Some(&from) = picks.get(&corners[i]) else { continue };
        let others = (i + 2..count).filter(|j| (j + 1) % count != i).map(|j| corners[j]);
        let goals: Vec<u32> = others.filter(|v| picks.get(v).is_some_and(|&pick| pick != from)).collect();
        let ways = net.map.find_ways(mesh, &net.embedding, corners[i], &goals, limits, observer)?;
        for (goal, way) in goals.into_iter().zip(ways) {
            let Some(way) = way else { continue };
            let own = [from.min(picks[&goal]), from.max(picks[&goal])];
            let is_second = pairs.iter().any(|&[a, b]| [a.min(b), a.max(b)] == own);
            found.push(Diagonal {
                picks: [from, picks[&goal]],
                ends: [corners[i], goal],
                is_second,
                length: way.length,
            });
        }
    }
    Ok(found)
}

/// Adds the first diagonal that can be made without a crossing and parts the patch; whether there is one.
#[expect(clippy::too_many_arguments, reason = "the net in all its parts")]
fn take_first(
    mesh: &SurfaceMesh,
    net: &OpenedNet,
    patches: &Patches,
    patch: usize,
    diagonals: Vec<Diagonal>,
    pairs: &mut Vec<[i128; 2]>,
    lines: &mut Vec<Option<Polyline>>,
    options: &Options,
    observer: &mut dyn Observer,
) -> Result<bool> {
    let before = find_transversal(mesh, lines)?.len();
    let count_excess = |patches: &Patches| (0..patches.patches.len()).map(|p| excess(patches, p)).sum::<u32>();
    let too_many = count_excess(patches);
    let limits = Limits { ignored: None, patch: Some((&patches.of_triangles, patch as u32)), keeps_off: true };
    for diagonal in diagonals {
        let [from, to] = diagonal.ends;
        let ways = net.map.find_ways(mesh, &net.embedding, from, &[to], limits, observer)?;
        let Some(way) = &ways[0] else { continue };
        lines.push(None);
        let is_good = |lines: &[Option<Polyline>], crossings: &[Crossing]| {
            crossings.len() <= before
                && OpenedNet::new(mesh, lines).is_ok_and(|net| {
                    let after = find_patches(mesh, &net.embedding, &net.map.triangles);
                    after.patches.len() == patches.patches.len() + 1 && count_excess(&after) < too_many
                })
        };
        let last = lines.len() - 1;
        if follow(mesh, lines, last, way, options, is_good, observer)?.is_some() {
            pairs.push(diagonal.picks);
            return Ok(true);
        }
        lines.pop();
    }
    Ok(false)
}
