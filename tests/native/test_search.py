"""Step B: its cost is Dijkstra's on the dual graph (SciPy as oracle), and near picks do not visit the whole mesh."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.sparse.csgraph import dijkstra

from native.made_meshes import barycentres
from native.surfaces import ALL_SHARED, MADE, SOUND, open_surface


def strip_cost(surface, strip):
    centres = barycentres(surface.positions, surface.triangles[strip])
    return np.linalg.norm(np.diff(centres, axis=0), axis=1).sum()


@pytest.mark.parametrize("name", [*MADE, *ALL_SHARED])
def test_the_cost_of_a_strip_is_dijkstras(name):
    surface = open_surface(name)
    sources = surface.random_picks(3 if len(surface.triangles) > 50_000 else 6, 31)
    costs = dijkstra(surface.dual_graph, directed=False, indices=sources)
    rng = np.random.default_rng(32)
    for source, row in zip(sources, costs, strict=True):
        for goal in rng.choice(surface.largest_part, 15).tolist():
            strip = surface.mesh.polyline([source, goal], filter="none").strip
            assert (strip[0], strip[-1]) == (source, goal)
            # Sums of the same distances in another order.
            assert strip_cost(surface, strip) == pytest.approx(row[goal], rel=1e-12, abs=1e-300)


@pytest.mark.parametrize("name", [*MADE, *SOUND])
def test_the_strip_of_many_picks_costs_the_sum_of_its_legs(name):
    surface = open_surface(name)
    picks = surface.random_picks(5, 33)
    line = surface.mesh.polyline(picks, filter="none", pinned="all")
    legs = [surface.mesh.polyline(pair, filter="none") for pair in pairwise(picks)]
    joined = [legs[0].strip[0], *(t for leg in legs for t in leg.strip[1:])]
    assert line.strip.tolist() == joined
    closed = surface.mesh.polyline(picks, filter="none", pinned="all", closed=True)
    back = surface.mesh.polyline([picks[-1], picks[0]], filter="none").strip
    assert closed.strip.tolist() == [*joined, *back[1:-1]]


@pytest.mark.parametrize("name", ["fandisk.obj", "bunny00.off", "igea.ply"])
def test_near_picks_visit_a_small_part_of_the_mesh(name):
    surface = open_surface(name)
    (start,) = surface.random_picks(1, 34)
    costs = dijkstra(surface.dual_graph, directed=False, indices=start)
    # Dijkstra's search would take exactly the 200 nearest triangles from its queue; a search with a bound fewer.
    goal = int(np.argsort(costs, kind="stable")[200])
    report = surface.mesh.polyline([start, goal], filter="none").report
    assert 0 < report.pops <= 201
    far = surface.mesh.polyline(surface.random_picks(2, 35), filter="none").report
    assert far.pops <= len(surface.triangles)
