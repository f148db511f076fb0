"""Limits that a caller can set, and Ctrl-C: a named error, soon, on all that can take long; the mesh works on."""

import os
import threading
import time

import numpy as np
import pytest

import smooth_polylines as sp
from native.interrupting import STOP_SECONDS, Looks, interrupt
from native.made_meshes import make_grid, make_sphere


@pytest.fixture(scope="module")
def fine():
    """A mesh on which lines of many picks take long, and such picks."""
    mesh = sp.SurfaceMesh(*make_sphere(7))
    return mesh, list(range(0, 20 * 4**7, 20 * 4**7 // 60))


def long_calls(mesh, picks):
    """Calls that take far longer than a second, by name, each with room for limits."""
    points = np.random.default_rng(3).normal(size=(3000, 3))
    points /= np.linalg.norm(points, axis=1)[:, None]
    pairs = [(i, j) for i in range(60) for j in range(i)]
    slow = {"filter": "cubic", "threshold": 1e-14, "pinned": "all", "max_iterations": 10**6}
    return {
        "polyline": lambda **limits: mesh.polyline(picks * 20, **slow, **limits),
        "heap": lambda **limits: mesh.polyline(picks, filter="linear", solver="heap", threshold=1e-15, **limits),
        "stroke": lambda **limits: mesh.stroke(points, filter="geodesic", pinned="all", **limits),
        # A million crossings and millions of samples: a round takes seconds.
        "fair stroke": lambda **limits: mesh.stroke(points, filter="fair", detail_size=1e-4, **limits),
        "fair": lambda **limits: mesh.polyline(picks * 20, filter="fair", pinned="ends", detail_size=1e-5, **limits),
        "network": lambda **limits: mesh.network(picks, pairs, **slow, **limits),
        "search": lambda **limits: mesh.network(
            picks * 60, np.arange(7200).reshape(-1, 2) % 3600, filter="none", **limits
        ),
    }


WORKERS = os.cpu_count() or 1
NAMES = ("polyline", "heap", "stroke", "fair stroke", "fair", "network", "search")


@pytest.mark.parametrize("name", NAMES)
def test_a_time_limit_ends_the_call_by_name_and_in_time(fine, name):
    mesh, picks = fine
    call = long_calls(mesh, picks)[name]
    wall, work = time.perf_counter(), time.process_time()
    with pytest.raises(sp.LimitError, match=r"^time_limit: not finished within 0.1 s, .* max_iterations"):
        call(time_limit=0.1)
    assert time.perf_counter() - wall >= 0.1
    # Networks work on all processors.
    assert time.process_time() - work < (0.1 + STOP_SECONDS) * (WORKERS if name in ("network", "search") else 1)
    assert len(mesh.polyline([0, 5000]).points) > 2


@pytest.mark.parametrize("name", NAMES)
def test_stop_ends_the_call_from_another_thread(fine, name):
    mesh, picks = fine
    stop, set_at = threading.Event(), []

    def set_soon():
        time.sleep(0.15)
        set_at.append(time.process_time())
        stop.set()

    thread = threading.Thread(target=set_soon)
    thread.start()
    try:
        with pytest.raises(sp.LimitError, match=r"^stop: ended by the caller"):
            long_calls(mesh, picks)[name](stop=stop)
        ended = time.process_time()
    finally:
        thread.join()
    assert ended - set_at[0] < STOP_SECONDS * (WORKERS if name in ("network", "search") else 1)


@pytest.mark.parametrize("name", NAMES)
def test_a_call_never_works_long_without_a_look_at_its_limits(fine, name):
    mesh, picks = fine
    # Long enough for steps that come late: on the stroke, bands of millions of rows and samples that move.
    looks = Looks(6.0 if name == "fair stroke" else 0.6)
    with pytest.raises(sp.LimitError):
        long_calls(mesh, picks)[name](stop=looks)
    assert looks.longest < STOP_SECONDS * (WORKERS if name in ("network", "search") else 1)


@pytest.mark.parametrize("name", NAMES)
def test_a_signal_ends_the_call(fine, name):
    mesh, picks = fine
    assert interrupt(long_calls(mesh, picks)[name]) < STOP_SECONDS * (WORKERS if name in ("network", "search") else 1)


@pytest.mark.parametrize("what", ["open", "report", "closest_points", "ray_cast"])
def test_a_signal_ends_work_on_a_whole_mesh(what):
    """The first search in space builds boxes round all triangles, the report counts parts: a second on this mesh."""
    positions, triangles = make_grid(1000)
    calls = {
        "open": lambda: sp.SurfaceMesh(positions, triangles),
        "report": lambda: sp.SurfaceMesh(positions, triangles).report,
        "closest_points": lambda: sp.SurfaceMesh(positions, triangles).closest_points([[0.5, 0.5, 1.0]]),
        "ray_cast": lambda: sp.SurfaceMesh(positions, triangles).ray_cast([[0.5, 0.5, 1.0]], [[0.0, 0, -1]]),
    }
    assert interrupt(calls[what], after=0.3) < STOP_SECONDS


@pytest.mark.parametrize("what", ["cut", "edge_path", "self_crossings", "crossings of two"])
def test_a_signal_ends_work_on_long_lines(fine, what):
    mesh, _ = fine
    points = np.random.default_rng(3).normal(size=(800, 3))
    line = mesh.stroke(points / np.linalg.norm(points, axis=1)[:, None], filter="none")
    assert len(line.points) > 200_000
    calls = {
        "cut": line.cut,
        "edge_path": line.edge_path,
        "self_crossings": line.self_crossings,
        "crossings of two": lambda: sp.find_crossings([line, line]),
    }
    assert interrupt(calls[what]) < STOP_SECONDS * WORKERS


def test_many_points_are_looked_up_within_a_limit_of_patience(fine):
    mesh, _ = fine
    points = np.random.default_rng(4).normal(size=(500_000, 3))
    assert interrupt(lambda: mesh.closest_points(points)) < STOP_SECONDS


def test_a_call_that_is_done_in_time_is_the_same_with_limits():
    mesh = sp.SurfaceMesh(*make_grid(12))
    plain = mesh.polyline([0, 250], filter="fair")
    limited = mesh.polyline([0, 250], filter="fair", time_limit=1000, stop=threading.Event())
    assert limited.to_bytes() == plain.to_bytes()
    assert mesh.polyline([0, 250], time_limit=float("inf")).length > 0
    assert mesh.polyline([0, 250], time_limit=None, stop=None).length > 0


@pytest.mark.parametrize("seconds", [0, -1, -float("inf"), float("nan")])
def test_a_time_limit_that_is_none_is_refused(seconds):
    with pytest.raises(sp.OptionError, match=r"^time_limit: found .*, expected seconds above 0"):
        sp.SurfaceMesh(*make_grid(2)).polyline([0, 5], time_limit=seconds)


@pytest.mark.parametrize(("name", "value"), [("time_limit", "1"), ("time_limit", True), ("stop", 5), ("stop", "yes")])
def test_wrong_types_of_limits_are_type_errors(name, value):
    with pytest.raises(TypeError, match=rf"^{name}: found "):
        sp.SurfaceMesh(*make_grid(2)).polyline([0, 5], **{name: value})


def test_what_stop_raises_is_raised(fine):
    mesh, picks = fine

    class Broken:
        def is_set(self):
            raise RuntimeError("broken flag")

    with pytest.raises(RuntimeError, match="broken flag"):
        long_calls(mesh, picks)["polyline"](stop=Broken())
