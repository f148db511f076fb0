"""Work on several threads: the same bytes from any number of them, also in forked processes; Ctrl-C; times."""

import functools
import hashlib
import os
import signal
import subprocess
import sys
import textwrap
import time

import numpy as np
import pytest

import smooth_polylines as sp
from native.invariants import same_line
from native.made_meshes import make_sphere
from native.surfaces import open_surface

SCRIPT = """
    import sys
    sys.path.insert(0, sys.argv[1])
    from native.test_threads import make_digest
    print(make_digest())
"""


@functools.cache
def make_digest():
    """Of a network by every filter on a mesh that is large enough for several threads to open."""
    positions, triangles = make_sphere(5)
    rng = np.random.default_rng(11)
    mesh = sp.SurfaceMesh(
        positions + 0.01 * rng.normal(size=positions.shape), triangles[rng.permutation(len(triangles))]
    )
    picks = rng.choice(len(triangles), 8, replace=False)
    connections = np.array([(i, j) for i in range(8) for j in range(i)])
    digest = hashlib.sha256()
    for options in (
        {"filter": "none"},
        {"filter": "geodesic"},
        {"filter": "linear"},
        {"filter": "cubic", "threshold": 1e-2},
    ):
        for line in mesh.network(picks, connections, **options):
            digest.update(line.to_bytes() + line.points.tobytes() + repr(line.report).split(", seconds=")[0].encode())
    return digest.hexdigest()


@pytest.mark.parametrize("threads", [1, 2, 7])
def test_the_same_bytes_from_any_number_of_threads(request, threads):
    tests = str(request.config.rootpath / "tests")
    environment = {**os.environ, "RAYON_NUM_THREADS": str(threads)}
    run = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(SCRIPT), tests],
        capture_output=True, text=True, timeout=100, check=True, env=environment,
    )  # fmt: skip
    assert run.stdout.split() == [make_digest()]


@pytest.mark.skipif(not hasattr(os, "fork"), reason="this system does not fork")
def test_a_forked_process_has_threads_of_its_own():
    surface = open_surface("sphere")
    picks = [3, 500, 1000]
    expected = surface.mesh.network(picks, [[0, 1], [1, 2]])
    child = os.fork()
    if child == 0:
        # Not by an exception: the child must not go on as a second pytest.
        try:
            mesh = sp.SurfaceMesh(surface.positions, surface.triangles)
            net = mesh.network(picks, [[0, 1], [1, 2]])
            os._exit(0 if all(same_line(a, b) for a, b in zip(net, expected, strict=True)) else 1)
        finally:
            os._exit(2)
    deadline = time.monotonic() + 60
    ended, status = 0, None
    while ended == 0 and time.monotonic() < deadline:
        ended, status = os.waitpid(child, os.WNOHANG)
        time.sleep(0.01)
    if ended == 0:
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)
    assert (ended, status) == (child, 0), "the child hung or made other lines"


def test_an_exception_of_a_signal_handler_stops_a_network():
    mesh = sp.SurfaceMesh(*make_sphere(6))
    count = len(mesh.triangles)
    picks = list(range(0, count, count // 40))
    connections = [(i, j) for i in range(40) for j in range(i)]

    class StopError(Exception):
        pass

    raised_at = []

    def handle(signum, frame):
        raised_at.append(time.perf_counter())
        raise StopError

    previous = signal.signal(signal.SIGALRM, handle)

    def make_networks():
        while True:
            mesh.network(picks, connections, filter="linear", solver="heap", threshold=1e-12)

    try:
        signal.setitimer(signal.ITIMER_REAL, 0.3)
        with pytest.raises(StopError):
            make_networks()
        elapsed = time.perf_counter() - raised_at[0]
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, previous)
    assert len(raised_at) == 1
    # 0.1 s after the handler; a machine under load gets some grace.
    assert elapsed < 0.1 + 0.8
    assert len(mesh.network(picks, [[0, 1]])[0].points) > 1


def test_each_line_of_a_network_has_its_own_time():
    surface = open_surface("cow.off")
    picks = surface.random_picks(6, 3)
    net = surface.mesh.network(picks, [[0, 1], [2, 3], [4, 4], [5, 0]], filter="geodesic")
    seconds = [line.report.seconds for line in net]
    assert len({times["total"] for times in seconds}) > 1
    for times in seconds:
        assert times["total"] >= sum(times[step] for step in ("search", "relax", "vertex_pass", "assemble")) - 1e-6
        assert times["total"] <= net.seconds["total"] + 1e-6
    for step in ("search", "relax", "vertex_pass", "assemble"):
        assert net.seconds[step] == pytest.approx(sum(times[step] for times in seconds), abs=1e-8)
