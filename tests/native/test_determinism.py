"""Same input, same bytes: twice, in another process, in many threads, and through `to_bytes` and back."""

import hashlib
import os
import subprocess
import sys
import textwrap
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import smooth_polylines as sp
from native.invariants import same_line
from native.made_meshes import make_irregular_square, make_terrain
from native.surfaces import MADE, SOUND, open_surface

FILTERS = ("none", "linear", "cubic", "geodesic", "fair")
COUNTERS = (
    "iterations", "moves", "newton_steps", "funnels", "vertex_passes", "loops_removed", "pops", "strip_triangles",
    "start_length", "stop_reason", "detail_size",
)  # fmt: skip


def describe(line):
    """All that must be reproduced: the line and its counters."""
    report = tuple(getattr(line.report, name) for name in COUNTERS)
    return line.to_bytes(), line.points.tobytes(), line.strip.tobytes(), line.segment_triangles.tobytes(), report


def make_lines(surface, filter_name):
    for seed in range(3):
        yield surface.mesh.polyline(surface.random_picks(4, seed), filter=filter_name, pinned="all")


@pytest.mark.parametrize("filter_name", FILTERS)
@pytest.mark.parametrize("name", ["terrain", "torus", "spot.obj", "suzanne.obj"])
def test_the_same_input_gives_the_same_bytes_twice(name, filter_name):
    # Not the surface's own mesh: other tests may have asked it so often that it has landmarks, and takes fewer pops.
    surface = open_surface(name)
    once = sp.SurfaceMesh(surface.positions, surface.triangles)
    again = sp.SurfaceMesh(surface.positions.copy(), surface.triangles.astype(np.int64))
    for seed in range(3):
        picks = surface.random_picks(4, seed)
        first, second = (mesh.polyline(picks, filter=filter_name) for mesh in (once, again))
        assert describe(first) == describe(second)


SCRIPT = """
    import hashlib, sys
    import numpy as np
    import smooth_polylines as sp
    with np.load(sys.argv[1]) as arrays:
        mesh = sp.SurfaceMesh(arrays["positions"], arrays["triangles"])
    digest = hashlib.sha256()
    for filter_name in ("none", "linear", "cubic", "geodesic", "fair"):
        for picks in ([3, 900, 1500], [40, 7, 1200, 700]):
            for closed in (False, True):
                line = mesh.polyline(picks, filter=filter_name, pinned="all", closed=closed)
                digest.update(line.to_bytes() + line.points.tobytes() + line.strip.tobytes())
    print(digest.hexdigest())
"""


def test_two_processes_give_the_same_bytes(tmp_path):
    positions, triangles = make_terrain(900, 5)
    np.savez(tmp_path / "mesh.npz", positions=positions, triangles=triangles)
    found = set()
    for hash_seed in ("1", "2"):
        run = subprocess.run(
            [sys.executable, "-c", textwrap.dedent(SCRIPT), tmp_path / "mesh.npz"],
            env={**os.environ, "PYTHONHASHSEED": hash_seed},
            capture_output=True, text=True, timeout=60, check=True,
        )  # fmt: skip
        found.add(run.stdout.strip())
    assert len(found) == 1
    assert len(found.pop()) == len(hashlib.sha256().hexdigest())


@pytest.mark.parametrize("filter_name", FILTERS)
def test_many_threads_on_one_mesh_get_the_bytes_of_one(filter_name):
    surface = open_surface("terrain")
    jobs = [surface.random_picks(3, seed) for seed in range(48)]

    def work(picks):
        line = surface.mesh.polyline(picks, filter=filter_name)
        # The lazily made arrays are asked for by several threads too.
        return describe(line), line.points is line.points, surface.mesh.line_from_bytes(line.to_bytes()).length

    expected = [work(picks) for picks in jobs]
    with ThreadPoolExecutor(8) as pool:
        assert list(pool.map(work, jobs)) == expected


def test_threads_share_the_arrays_of_one_line():
    line = open_surface("torus").mesh.polyline([5, 700], filter="none")
    with ThreadPoolExecutor(8) as pool:
        found = list(pool.map(lambda _: (line.points, line.strip, line.report), range(200)))
    assert len({tuple(map(id, row)) for row in found}) == 1


@pytest.mark.parametrize("filter_name", FILTERS)
@pytest.mark.parametrize("name", [*MADE, *SOUND[:8], "suzanne.obj", "truck_nm.obj"])
def test_bytes_give_the_line_back(name, filter_name):
    surface = open_surface(name)
    for line in make_lines(surface, filter_name):
        data = line.to_bytes()
        again = surface.mesh.line_from_bytes(data)
        assert same_line(again, line)
        assert again.to_bytes() == data
        assert again.length == line.length
        assert again.report.iterations == 0
        # One parameter a crossing is the bulk: first triangles, pins and bits are small beside it.
        assert len(data) <= 9 * len(line.strip) + 200
    closed = surface.mesh.polyline(surface.random_picks(3, 8), filter=filter_name, pinned="all", closed=True)
    assert same_line(surface.mesh.line_from_bytes(bytearray(closed.to_bytes())), closed)


def test_a_line_of_one_point_goes_through_bytes():
    mesh = open_surface("grid").mesh
    for pick in (7, (7, (0.2, 0.3, 0.5)), (7, (1, 0, 0)), (7, (0.5, 0.5, 0))):
        line = mesh.polyline([pick])
        assert same_line(mesh.line_from_bytes(line.to_bytes()), line)


@pytest.mark.parametrize("value", [None, "SPL1", 5, [1, 2], np.zeros(4)])
def test_what_is_no_bytes_is_a_type_error(value):
    with pytest.raises(TypeError, match=r"^data: found .*expected bytes"):
        open_surface("grid").mesh.line_from_bytes(value)


def test_spoilt_bytes_are_an_option_error_or_another_line():
    """Every truncation is refused; a changed byte may make another legal line, and never worse than an OptionError."""
    surface = open_surface("terrain")
    data = surface.mesh.polyline([3, 900, 1500], filter="none", pinned="all").to_bytes()
    for length in range(len(data)):
        with pytest.raises(sp.OptionError, match=r"^data: "):
            surface.mesh.line_from_bytes(data[:length])
    with pytest.raises(sp.OptionError, match=r"^data: "):
        surface.mesh.line_from_bytes(data + b"\0")
    rng = np.random.default_rng(9)
    legal = 0
    for place in range(len(data)):
        spoilt = bytearray(data)
        spoilt[place] ^= int(rng.integers(1, 256))
        try:
            line = surface.mesh.line_from_bytes(spoilt)
        except sp.OptionError:
            continue
        legal += 1
        assert np.isfinite(line.points).all()
        assert line.on(surface.positions).tobytes() == line.points.tobytes()
    assert legal < len(data)


def test_bytes_of_another_mesh_are_refused():
    data = open_surface("terrain").mesh.polyline([3, 900], filter="none").to_bytes()
    other = sp.SurfaceMesh(*make_irregular_square(50, 1))
    with pytest.raises(sp.OptionError, match=r"^data: .*this very mesh"):
        other.line_from_bytes(data)


@pytest.mark.parametrize("name", ["terrain", "spot.obj"])
def test_a_line_follows_moved_vertices(name):
    surface = open_surface(name)
    line = surface.mesh.polyline(surface.random_picks(3, 5), filter="linear")
    assert line.on(surface.positions).tobytes() == line.points.tobytes()
    turn, _ = np.linalg.qr(np.random.default_rng(6).standard_normal((3, 3)))
    moved = surface.positions @ turn * 3 + [1, 2, 3]
    # An affine map of the vertices maps every point of the line alike.
    assert np.allclose(line.on(moved), line.points @ turn * 3 + [1, 2, 3], rtol=0, atol=1e-12)
    single = line.on(surface.positions.astype(np.float32))
    assert single.dtype == np.float64
    assert np.allclose(single, line.points, rtol=0, atol=1e-6 * surface.diagonal)
