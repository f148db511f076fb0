"""Lines with other picks: equal to fresh ones or near them, at a fraction of the work, and refusals."""

import numpy as np
import pytest

import smooth_polylines as sp
from native.invariants import barycentre_pins
from native.surfaces import open_surface

KEEPS_BYTES = ("geodesic", "linear", "none")
SURFACES = ("terrain", "sphere", "cow.off", "fandisk.obj", "thingi_79741.off")


def edited(rng, picks, count):
    """One pick moved, inserted or removed."""
    picks, place = list(picks), int(rng.integers(len(picks)))
    kind = rng.integers(4)
    if kind == 0:
        picks.insert(place, int(rng.integers(count)))
    elif kind == 1 and len(picks) > 5:
        del picks[place]
    else:
        picks[place] = int(rng.integers(count))
    return picks


def pick_in_largest_part(surface, rng, count):
    """Triangles that are connected with each other."""
    start = int(rng.integers(len(surface.triangles)))
    chosen = [start]
    while len(chosen) < count:
        triangle = int(rng.integers(len(surface.triangles)))
        try:
            surface.mesh.polyline([start, triangle], filter="none")
        except sp.NoPathError:
            continue
        chosen.append(triangle)
    return chosen


@pytest.mark.parametrize("closed", [False, True])
@pytest.mark.parametrize("filter", KEEPS_BYTES)
@pytest.mark.parametrize("name", SURFACES)
def test_the_bytes_are_those_of_a_fresh_line(name, filter, closed):
    surface, rng = open_surface(name), np.random.default_rng(5)
    options = {"filter": filter, "closed": closed, "pinned": "all"}
    pool = pick_in_largest_part(surface, rng, 12)
    picks = pool[:7]
    line = surface.mesh.polyline(picks, **options)
    for _ in range(4):
        picks = [pool[i] for i in edited(rng, [pool.index(p) for p in picks], len(pool))]
        line, fresh = line.with_picks(picks), surface.mesh.polyline(picks, **options)
        assert line.to_bytes() == fresh.to_bytes()
        assert line.points.tobytes() == fresh.points.tobytes()
        assert line.report.stop_reason == fresh.report.stop_reason
        assert line.report.strip_triangles == fresh.report.strip_triangles
        assert line.report.kept_legs >= len(picks) - 3


def distance_from(points, line):
    """Of each of the points from the line, the largest."""
    ends = np.roll(line.points, -1, axis=0) if line.closed else line.points[1:]
    starts = line.points if line.closed else line.points[:-1]
    way = ends - starts
    share = np.einsum("pij,ij->pi", points[:, None] - starts, way) / np.einsum("ij,ij->i", way, way)
    feet = starts + np.clip(share, 0, 1)[..., None] * way
    return float(np.linalg.norm(points[:, None] - feet, axis=2).min(axis=1).max())


def drag(surface, options, stride, steps=8):
    """A pick of ten on a scan through triangles next to each other: distances in edges, and both kinds of reports."""
    rng = np.random.default_rng(1)
    middles = surface.positions[surface.triangles].mean(axis=1)
    around = np.argsort(np.linalg.norm(middles - middles[1234], axis=1))[:20000]
    picks = [int(t) for t in around[np.linspace(200, 19000, 10).astype(int)]]
    corners = surface.positions[surface.triangles[around]]
    edge = np.linalg.norm(corners[:, 0] - corners[:, 1], axis=1).mean()
    way = np.argsort(np.linalg.norm(middles - middles[picks[5]], axis=1))[: stride * steps : stride]
    line = surface.mesh.polyline(picks, pinned="all", **options)
    distances, ours, theirs = [], [], []
    for place in way[1:]:
        picks[5] = (int(place), rng.dirichlet([3, 3, 3]).tolist())
        line, again, fresh = (
            line.with_picks(picks),
            line.with_picks(picks),
            surface.mesh.polyline(picks, pinned="all", **options),
        )
        assert line.to_bytes() == again.to_bytes(), "the same line and picks give the same bytes"
        assert line.report.kept_legs == 7
        pins = [*barycentre_pins(picks[:5]), picks[5], *barycentre_pins(picks[6:])]
        surface.checker.check(line, pins=pins)
        distances.append(max(distance_from(line.points, fresh), distance_from(fresh.points, line)) / edge)
        ours.append(line.report)
        theirs.append(fresh.report)
    return np.array(distances), ours, theirs


def total(reports, counter):
    return sum(getattr(report, counter) for report in reports)


def test_a_dragged_cubic_stays_near_a_fresh_one_and_moves_little():
    distances, ours, theirs = drag(open_surface("igea.ply"), {"filter": "cubic", "threshold": 1e-2}, 20)
    assert distances.max() < 0.2, distances
    assert total(ours, "moves") < 0.5 * total(theirs, "moves")
    assert total(ours, "pops") < 0.6 * total(theirs, "pops")


def test_a_dragged_cubic_draft_is_near_the_finished_line():
    distances, ours, theirs = drag(open_surface("igea.ply"), {"filter": "cubic"}, 20)
    assert distances.max() < 1, distances
    assert np.median(distances) < 0.7, distances
    assert total(ours, "moves") < 0.1 * total(theirs, "moves")


def test_a_dragged_fair_line_is_mostly_near_a_fresh_one_at_a_fraction_of_the_work():
    distances, ours, theirs = drag(open_surface("igea.ply"), {"filter": "fair"}, 3)
    # Where the curve has two places of rest the two may choose differently.
    assert np.median(distances) < 1, distances
    # Short legs, so most of them are near the change. On a million triangles it is an eighth of the time.
    assert total(ours, "funnels") < 0.8 * total(theirs, "funnels")
    # A draft goes on to finer samples as soon as a step has done what it promised.
    assert total(ours, "newton_steps") < 0.3 * total(theirs, "newton_steps")


def test_a_pick_that_goes_to_and_fro_costs_the_same_each_time():
    """A pick that comes back takes back its share in how far other legs have come off."""
    mesh = open_surface("igea.ply").mesh
    picks = [25_000 * i + 500 for i in range(10)]
    there = [*picks[:5], picks[5] + 3, *picks[6:]]
    line = mesh.polyline(picks, filter="fair", pinned="all")
    work = []
    for _ in range(3):
        for places in (there, picks):
            line = line.with_picks(places)
            work.append(line.report.funnels)
    assert work == work[:2] * 3


def test_a_chain_of_drags_does_not_add_up_its_errors():
    """To and fro many times: at the end as near to a fresh line as at the start."""
    surface = open_surface("igea.ply")
    at = [100_000, 101_000, 104_000, 108_000, 112_000]
    picks = [[*at[:2], middle, *at[3:]] for middle in (104_000, 104_040)]
    line = fresh = surface.mesh.polyline(picks[0], filter="fair", pinned="all")
    edge = fresh.length / len(fresh.points)
    first = None
    for _ in range(10):
        line = line.with_picks(picks[1]).with_picks(picks[0])
        off = distance_from(line.points, fresh) / edge
        first = off if first is None else first
    assert off < 2 * first + 0.5, f"{off} edges after ten drags, {first} after one"


def test_lines_that_do_not_know_their_picks_say_so():
    mesh = open_surface("grid").mesh
    line = mesh.polyline([0, 100, 200])
    strangers = [
        mesh.line_from_bytes(line.to_bytes()),
        mesh.stroke([0, 100, 200]),
        mesh.network([0, 200], [[0, 1]]).lines[0],
    ]
    for stranger in strangers:
        with pytest.raises(sp.OptionError, match="does not know its picks"):
            stranger.with_picks([0, 200])


def test_wrong_arguments_are_refused():
    mesh = open_surface("grid").mesh
    line = mesh.polyline([0, 100, 200], pinned=[True, False, True])
    with pytest.raises(sp.OptionError, match="pinned.*3 flags for 4 picks"):
        line.with_picks([0, 50, 100, 200])
    assert line.with_picks([0, 50, 100, 200], pinned="all").report.stop_reason.startswith("converged")
    with pytest.raises(sp.OptionError, match="pick 1 is triangle 99999"):
        line.with_picks([0, 99999, 200])
    with pytest.raises(TypeError):
        line.with_picks("picks")
    with pytest.raises(TypeError):
        line.with_picks([0, 1, 2], pinned=7)
    ring = mesh.polyline([0, 100, 250], closed=True, pinned="all")
    with pytest.raises(sp.OptionError, match="at least 3 different picks"):
        ring.with_picks([0, 100])


def test_a_line_can_be_taken_up_by_many_threads():
    from concurrent.futures import ThreadPoolExecutor

    mesh = open_surface("terrain").mesh
    line = mesh.polyline([3, 200, 400, 600, 800], filter="fair", pinned="all")
    ways = [[3, 200, 400 + i, 600, 800] for i in range(16)]
    alone = [line.with_picks(picks).to_bytes() for picks in ways]
    with ThreadPoolExecutor(8) as pool:
        assert list(pool.map(lambda picks: line.with_picks(picks).to_bytes(), ways)) == alone
