"""Work is counted, and the counts are pinned: what makes a line slower or faster shows here, on any machine.

Meshes come from files, or have whole numbers as coordinates, so that no version of numpy changes them.
A change that alters a number on purpose alters it here as well, and says why.
"""

import pytest

import smooth_polylines as sp
from native.surfaces import open_surface

COUNTERS = ("pops", "iterations", "moves", "newton_steps", "vertex_passes", "funnels")
OPTIONS = {
    "heap": {"filter": "linear", "solver": "heap"},
    "linear": {"filter": "linear"},
    "cubic": {"filter": "cubic", "threshold": 1e-2},
    "geodesic": {"filter": "geodesic"},
}
# Mesh, picks, options, and the counters in the order of COUNTERS.
COUNTED = [
    ("grid", (5, 230), "heap", (62, 10, 4015, 0, 6, 15)),
    ("grid", (5, 230), "linear", (17, 1, 0, 0, 2, 2)),
    ("grid", (5, 230), "cubic", (62, 1, 97, 0, 0, 0)),
    ("grid", (5, 230), "geodesic", (17, 2, 0, 0, 2, 2)),
    ("spot.obj", (100, 4000), "heap", (910, 13, 40673, 0, 37, 55)),
    ("spot.obj", (100, 4000), "linear", (208, 1, 0, 7, 15, 7)),
    ("spot.obj", (100, 4000), "cubic", (910, 1, 476, 0, 0, 0)),
    ("spot.obj", (100, 4000), "geodesic", (208, 6, 0, 0, 15, 7)),
    ("cow.off", (4861, 1518), "heap", (4381, 11, 43397, 0, 23, 47)),
    ("cow.off", (4861, 1518), "linear", (1529, 6, 23390, 191, 48, 55)),
    ("cow.off", (4861, 1518), "cubic", (4381, 1, 908, 39, 0, 3)),
    ("cow.off", (4861, 1518), "geodesic", (1529, 10, 0, 0, 41, 17)),
]


@pytest.mark.parametrize(("name", "picks", "options", "expected"), COUNTED)
def test_a_line_takes_the_counted_work(name, picks, options, expected):
    surface = open_surface(name)
    # A mesh of its own: one that was asked often has chosen landmarks, and searches less.
    mesh = sp.SurfaceMesh(surface.positions, surface.triangles)
    report = mesh.polyline(list(picks), **OPTIONS[options]).report
    assert {c: getattr(report, c) for c in COUNTERS} == dict(zip(COUNTERS, expected, strict=True))


def test_near_picks_do_not_make_the_search_visit_the_mesh():
    surface = open_surface("igea.ply")
    near = surface.mesh.polyline([1000, 1005], filter="none")
    assert near.report.pops < 40 * len(near.strip), "a search between near picks has gone far"


def test_a_dragged_cubic_is_a_draft_unless_the_papers_heap_was_asked_for():
    mesh = open_surface("igea.ply").mesh
    picks = [25_000 * i + 500 for i in range(8)]
    moved = [*picks[:4], picks[4] + 40, *picks[5:]]

    def drag(**options):
        line = mesh.polyline(picks, filter="cubic", pinned="all", **options).with_picks(moved)
        assert line.report.kept_legs == 5
        return line.report

    draft, fresh = drag(threshold=1e-4), mesh.polyline(moved, filter="cubic", pinned="all").report
    assert draft.moves < 0.05 * fresh.moves, (draft, fresh)
    assert drag(threshold=1e-2).moves < draft.moves < 0.2 * drag(threshold=1e-4, solver="heap").moves


def test_on_a_long_line_steps_of_all_crossings_spare_most_moves_of_cubic():
    """Open picks round a scan; the heap alone is the paper's, and what is compared with."""
    mesh = open_surface("igea.ply").mesh
    picks = [25_000 * i + 500 for i in range(4)]
    at_once, by_heap = (mesh.polyline(picks, filter="cubic", solver=solver).report for solver in ("auto", "heap"))
    crossings = by_heap.strip_triangles
    assert crossings > 600
    assert at_once.moves < 0.5 * by_heap.moves, (at_once.moves, by_heap.moves)
    assert at_once.newton_steps < 2 * crossings
    assert by_heap.newton_steps == 0
