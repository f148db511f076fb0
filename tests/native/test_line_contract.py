"""Every promise about a line, checked on every mesh, filter, kind of pins, open and closed."""

import numpy as np
import pytest

import smooth_polylines as sp
from native.invariants import barycentre_pins, same_line
from native.straightness import StraightnessJudge
from native.surfaces import ALL_SHARED, MADE, SOUND, open_surface

FILTERS = ("none", "linear", "cubic", "geodesic", "fair")
SURFACES = (*MADE, *ALL_SHARED)


def make_line(surface, picks, **options):
    """The line, or None where it is a closed one that shrank to a point with too few pins to hold it."""
    try:
        return surface.mesh.polyline(picks, **options)
    except sp.CollapsedError:
        assert options.get("closed")
        assert options.get("pinned") != "all"
        # Where the route runs to and fro along one strip, cancelling its backtracks leaves nothing.
        return None


def without_own_ways_back(filter_name, step_b):
    """Step B's line to compare repeated triangles with; none for `fair`, which goes to a pick and back as asked."""
    return None if filter_name == "fair" else step_b


def choose_pins(picks, pinned, seed):
    """What to pass as `pinned`, and the picks of an open line that it pins."""
    if pinned == "all":
        return pinned, picks
    if pinned == "ends":
        return pinned, [picks[0], picks[-1]]
    flags = np.random.default_rng(seed).random(len(picks)) < 0.5
    flags[[0, -1]] = True
    return flags, [pick for pick, flag in zip(picks, flags, strict=True) if flag]


@pytest.mark.parametrize("filter_name", FILTERS)
@pytest.mark.parametrize("name", SURFACES)
def test_open_lines_keep_every_promise(name, filter_name):
    surface = open_surface(name)
    for seed, (count, pinned) in enumerate([(2, "ends"), (3, "ends"), (4, "all"), (6, "some")]):
        picks = surface.random_picks(count, seed)
        flags, held = choose_pins(picks, pinned, seed)
        step_b = surface.mesh.polyline(picks, filter="none", pinned=flags)
        line = surface.mesh.polyline(picks, filter=filter_name, pinned=flags)
        surface.checker.check(line, pins=barycentre_pins(held), step_b=without_own_ways_back(filter_name, step_b))
        # The paper's filters start at step B's strip; those that straighten first choose a strip that is nearer.
        if filter_name not in ("linear", "geodesic", "fair"):
            assert line.report.strip_triangles == len(step_b.strip)
        assert line.report.stop_reason in ("converged", "converged_at_vertices", "cycle", "max_iterations")


@pytest.mark.parametrize("filter_name", FILTERS)
@pytest.mark.parametrize("name", SURFACES)
def test_closed_lines_keep_every_promise(name, filter_name):
    surface = open_surface(name)
    for seed, (count, pinned) in enumerate([(4, "ends"), (5, "all")]):
        picks = surface.random_picks(count, 100 + seed)
        if len(picks) < 3:
            continue  # fan3.obj: each of its triangles is a part of its own
        step_b = make_line(surface, picks, closed=True, filter="none", pinned=pinned)
        line = make_line(surface, picks, closed=True, filter=filter_name, pinned=pinned)
        if line is not None:
            pins = barycentre_pins(picks) if pinned == "all" else []
            surface.checker.check(line, pins=pins, step_b=without_own_ways_back(filter_name, step_b))


@pytest.mark.parametrize("closed", [False, True])
@pytest.mark.parametrize("name", [*MADE, "cow.off", "suzanne.obj", "openscad_crash.obj"])
def test_picks_on_edges_and_vertices_keep_every_promise(name, closed):
    surface = open_surface(name)
    kinds = ((1, 0, 0), (0, 0, 1), (0.5, 0.5, 0), (0, 0.25, 0.75), (0.2, 0.3, 0.5))
    rng = np.random.default_rng(7)
    for seed in range(6):
        triangles = surface.random_picks(4, 200 + seed)
        picks = [(t, kinds[rng.integers(len(kinds))]) for t in triangles]
        for filter_name in FILTERS:
            line = make_line(surface, picks, closed=closed, filter=filter_name, pinned="all")
            surface.checker.check(line, pins=picks)


@pytest.mark.parametrize("name", [*MADE, *SOUND])
def test_step_b_alone_runs_through_midpoints_and_picks(name):
    surface = open_surface(name)
    picks = surface.random_picks(2, 11)
    line = surface.mesh.polyline(picks, filter="none")
    assert len(line.points) == len(line.strip) + 1
    assert np.sort(line.barycentric[1:-1], axis=1).tolist() == [[0.0, 0.5, 0.5]] * (len(line.points) - 2)
    assert line.segment_triangles.tolist() == line.strip.tolist()
    report = line.report
    assert (report.stop_reason, report.iterations, report.moves, report.vertex_passes) == ("converged", 0, 0, 0)
    assert report.start_length == pytest.approx(line.length, rel=1e-12)
    # Unpinned inner picks add no points; pinned ones do.
    more = surface.random_picks(4, 12)
    free, held = (surface.mesh.polyline(more, filter="none", pinned=word) for word in ("ends", "all"))
    inside = [int((row > 0).all()) for row in free.barycentric]
    assert sum(inside) == 2
    assert sum(int((row > 0).all()) for row in held.barycentric) == 4


@pytest.mark.parametrize("pinned", ["ends", "all"])
@pytest.mark.parametrize("name", [*MADE, *ALL_SHARED])
def test_geodesics_are_straight_to_rounding_and_shorter_than_their_start(name, pinned):
    surface = open_surface(name)
    judge = StraightnessJudge(surface.checker)
    for seed in range(4):
        picks = surface.random_picks(3, 300 + seed)
        line = surface.mesh.polyline(picks, filter="geodesic", pinned=pinned)
        assert line.report.stop_reason in ("converged", "converged_at_vertices")
        assert line.length <= line.report.start_length * (1 + 1e-12)
        if name == "openscad_crash.obj":
            continue  # coincident vertices: angles mean nothing there
        held = surface.mesh.polyline(picks, filter="none", pinned=pinned)
        pins = [p for p, row in zip(held.points, held.barycentric, strict=True) if (row > 0).all()]
        bad = [bend for bend in judge.bends(line, pins) if bend[2] > bend[3]]
        assert not bad, f"seed {seed}: {bad[:3]}"


@pytest.mark.parametrize("name", ["spot.obj", "fandisk.obj", "camel.off", "terrain"])
@pytest.mark.parametrize("solver", ["auto", "heap"])
def test_a_line_keeps_its_promises_wherever_it_is_stopped(name, solver):
    surface = open_surface(name)
    picks = surface.random_picks(4, 21)
    for filter_name in ("linear", "cubic"):
        for rounds in (1, 2, 5):
            line = surface.mesh.polyline(picks, filter=filter_name, solver=solver, max_iterations=rounds)
            surface.checker.check(line)
            assert line.report.iterations <= rounds
    with_stages = surface.mesh.polyline(picks, filter="linear", solver=solver, stages=True)
    stages = with_stages.report.stages
    assert len(stages) == with_stages.report.iterations + 1
    assert stages[0].tobytes() == surface.mesh.polyline(picks, filter="none").points.tobytes()
    assert all(stage.dtype == np.float64 and stage.ndim == 2 and stage.shape[1] == 3 for stage in stages)
    without = surface.mesh.polyline(picks, filter="linear", solver=solver)
    assert without.report.stages == []
    assert same_line(with_stages, without)
