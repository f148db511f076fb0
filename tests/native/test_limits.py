"""Limits that a caller can set, and Ctrl-C: a named error, soon, on all that can take long; the mesh works on."""

import signal
import threading
import time

import numpy as np
import pytest

import smooth_polylines as sp
from native.made_meshes import make_grid, make_sphere

# A call ends within this of its limit or signal; a machine under load gets some grace.
STOP_SECONDS = 0.2
GRACE_SECONDS = 0.8


@pytest.fixture(scope="module")
def fine():
    """A mesh on which lines of many picks take long, and such picks."""
    mesh = sp.SurfaceMesh(*make_sphere(7))
    return mesh, list(range(0, 20 * 4**7, 20 * 4**7 // 60))


def long_calls(mesh, picks):
    """Calls that take far longer than a second, by name, each with room for limits."""
    points = np.random.default_rng(3).normal(size=(12000, 3))
    points /= np.linalg.norm(points, axis=1)[:, None]
    pairs = [(i, j) for i in range(60) for j in range(i)]
    slow = {"filter": "cubic", "threshold": 1e-14, "pinned": "all", "max_iterations": 10**6}
    return {
        "polyline": lambda **limits: mesh.polyline(picks, **slow, **limits),
        "heap": lambda **limits: mesh.polyline(picks, filter="linear", solver="heap", threshold=1e-15, **limits),
        "stroke": lambda **limits: mesh.stroke(points[:3000], filter="geodesic", pinned="all", **limits),
        # Ends while it is joined: with millions of samples a round of `fair` takes seconds, and nothing ends it.
        "fair stroke": lambda **limits: mesh.stroke(points, filter="fair", detail_size=1e-4, **limits),
        "fair": lambda **limits: mesh.polyline(picks * 20, filter="fair", pinned="ends", detail_size=1e-5, **limits),
        "network": lambda **limits: mesh.network(picks, pairs, **slow, **limits),
        "search": lambda **limits: mesh.network(
            picks * 60, np.arange(7200).reshape(-1, 2) % 3600, filter="none", **limits
        ),
    }


NAMES = ("polyline", "heap", "stroke", "fair stroke", "fair", "network", "search")


@pytest.mark.parametrize("name", NAMES)
def test_a_time_limit_ends_the_call_by_name_and_in_time(fine, name):
    mesh, picks = fine
    begun = time.perf_counter()
    with pytest.raises(sp.LimitError, match=r"^time_limit: not finished within 0.1 s, .* max_iterations"):
        long_calls(mesh, picks)[name](time_limit=0.1)
    assert 0.1 <= time.perf_counter() - begun < 0.1 + STOP_SECONDS + GRACE_SECONDS
    assert len(mesh.polyline([0, 5000]).points) > 2


@pytest.mark.parametrize("name", NAMES)
def test_stop_ends_the_call_from_another_thread(fine, name):
    mesh, picks = fine
    stop, set_at = threading.Event(), []

    def set_soon():
        time.sleep(0.15)
        set_at.append(time.perf_counter())
        stop.set()

    thread = threading.Thread(target=set_soon)
    thread.start()
    try:
        with pytest.raises(sp.LimitError, match=r"^stop: ended by the caller"):
            long_calls(mesh, picks)[name](stop=stop)
        ended = time.perf_counter()
    finally:
        thread.join()
    assert ended - set_at[0] < STOP_SECONDS + GRACE_SECONDS


def repeat(call):
    while True:
        call()


def interrupt(call, after=0.1):
    """Seconds from the signal to the exception of its handler."""

    class StopError(Exception):
        pass

    raised_at = []

    def handle(signum, frame):
        raised_at.append(time.perf_counter())
        raise StopError

    previous = signal.signal(signal.SIGALRM, handle)
    sent = time.perf_counter() + after
    try:
        signal.setitimer(signal.ITIMER_REAL, after)
        with pytest.raises(StopError):
            repeat(call)
        return time.perf_counter() - sent
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, previous)


@pytest.mark.parametrize("name", NAMES)
def test_a_signal_ends_the_call(fine, name):
    mesh, picks = fine
    assert interrupt(long_calls(mesh, picks)[name]) < STOP_SECONDS + GRACE_SECONDS


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
    assert interrupt(calls[what], after=0.3) < STOP_SECONDS + GRACE_SECONDS


def test_many_points_are_looked_up_within_a_limit_of_patience(fine):
    mesh, _ = fine
    points = np.random.default_rng(4).normal(size=(2_000_000, 3))
    assert interrupt(lambda: mesh.closest_points(points)) < STOP_SECONDS + GRACE_SECONDS


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
