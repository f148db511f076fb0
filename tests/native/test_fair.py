"""The `fair` filter against SciPy's natural cubic splines, the damping law, and the same surface cut differently."""

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from scipy.spatial import cKDTree

import smooth_polylines as sp
from native.made_meshes import make_grid, make_irregular_square
from native.surfaces import SOUND, open_surface

PLANES = {
    "regular 25": make_grid(25),
    "regular 50": make_grid(50),
    "random 800": make_irregular_square(800, 4),
    "random 3200": make_irregular_square(3200, 5),
}
# The mean edge of n random points: about this over the square root of n.
EDGES = {"regular 25": 1 / 25, "regular 50": 1 / 50, "random 800": 1.1 / 800**0.5, "random 3200": 1.1 / 3200**0.5}
ZIGZAG = np.array([[0.1, 0.31], [0.3, 0.72], [0.52, 0.36], [0.7, 0.66], [0.91, 0.22]])


def open_plane(name):
    return sp.SurfaceMesh(*PLANES[name])


def above(name, places):
    """Picks of a plane at places."""
    positions, _ = PLANES[name]
    places = np.column_stack([places, np.zeros(len(places))])
    assert np.ptp(positions[:, 2]) == 0.0
    return open_plane(name).closest_points(places).surface_points


def dense(points, closed=False, pieces=20):
    """Points along a polyline."""
    points = np.vstack([points, points[:1]]) if closed else points
    shares = np.linspace(0.0, 1.0, pieces, endpoint=False)[:, None, None]
    return np.vstack([((1 - shares) * points[:-1] + shares * points[1:]).reshape(-1, 3), points[-1:]])


def distance_between(first, second):
    """The largest distance of a point of one set from the nearest of the other, both ways."""
    return max(cKDTree(second).query(first)[0].max(), cKDTree(first).query(second)[0].max())


@pytest.mark.parametrize("name", PLANES)
def test_through_pins_in_the_plane_it_is_scipys_natural_spline(name):
    line = open_plane(name).polyline(above(name, ZIGZAG), filter="fair", pinned="all")
    parameters = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(ZIGZAG, axis=0), axis=1))])
    spline = CubicSpline(parameters, ZIGZAG, bc_type="natural")(np.linspace(0.0, parameters[-1], 4000))
    off = cKDTree(spline).query(line.points[:, :2])[0].max()
    # A tenth of an edge: the polyline's own corners are rounder than that only on finer meshes.
    assert off < 0.1 * EDGES[name]
    assert line.report.detail_size == np.inf
    assert line.report.stop_reason in ("converged", "converged_at_vertices")


@pytest.mark.parametrize("name", PLANES)
@pytest.mark.parametrize("wavelength", [0.3, 0.45])
def test_a_sine_keeps_the_height_that_the_law_says(name, wavelength):
    x = np.linspace(0.05, 0.95, 150)
    height = 0.01
    picks = above(name, np.column_stack([x, 0.51 + height * np.sin(2 * np.pi * x / wavelength)]))
    for share in (0.06, 0.12, 0.16, 0.22, 0.35):
        points = open_plane(name).polyline(picks, filter="fair", detail_size=share * wavelength).points
        middle = points[(points[:, 0] > 0.25) & (points[:, 0] < 0.75)]
        angle = 2 * np.pi * middle[:, 0] / wavelength
        terms = np.column_stack([np.sin(angle), np.cos(angle), np.ones(len(angle)), middle[:, 0]])
        sine, cosine, *_ = np.linalg.lstsq(terms, middle[:, 1], rcond=None)[0]
        law = 1 / (1 + (2 * np.pi * share) ** 4)
        assert np.hypot(sine, cosine) / height == pytest.approx(law, abs=0.05)


def subdivided(positions, triangles):
    """The same surface, each triangle cut in four."""
    edges = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    unique, ids = np.unique(edges, axis=0, return_inverse=True)
    middle = ids.reshape(-1, 3) + len(positions)
    a, b, c = triangles.T
    ab, bc, ca = middle.T
    parts = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    finer = np.stack([np.column_stack(part) for part in parts], axis=1).reshape(-1, 3)
    return np.vstack([positions, positions[unique].mean(axis=1)]), finer


@pytest.mark.parametrize("name", ["torus", "sphere", "spot.obj", "bunny00.off"])
def test_the_same_surface_cut_finer_has_the_same_curve(name):
    surface = open_surface(name)
    finer = sp.SurfaceMesh(*subdivided(surface.positions, surface.triangles))
    rng = np.random.default_rng(3)
    edge = np.linalg.norm(np.diff(surface.positions[surface.triangles[:, :2]], axis=1), axis=2).mean()
    tried = 0
    for closed, pinned in [(False, "all"), (True, "all"), (False, "ends"), (True, "ends")]:
        # A few picks in one region, as an artist makes them.
        centres = surface.positions[surface.triangles].mean(axis=1)
        seed_pick = rng.choice(surface.largest_part)
        near = np.argsort(np.linalg.norm(centres - centres[seed_pick], axis=1))[: len(centres) // 12]
        picks = rng.choice(near, 4, replace=False).tolist()
        places = centres[picks]
        line = surface.mesh.polyline(picks, filter="fair", closed=closed, pinned=pinned)
        found = finer.closest_points(places)
        assert found.distances.max() < 1e-6 * edge
        other = finer.polyline(found.surface_points, filter="fair", closed=closed, pinned=pinned)
        apart = distance_between(dense(line.points, closed), dense(other.points, closed))
        assert apart < edge, f"{apart / edge} edges apart, closed {closed}, pinned {pinned}, picks {picks}"
        tried += 1
    assert tried == 4


@pytest.mark.parametrize("name", SOUND)
def test_the_energy_falls_and_the_curve_has_no_corner_at_its_pins(name):
    surface = open_surface(name)
    rounder = 0
    for seed, closed in enumerate([False, True, False, True]):
        picks = surface.random_picks(5, 300 + seed)
        line = surface.mesh.polyline(picks, filter="fair", closed=closed, pinned="all")
        energies = np.array(line.report.energies)
        assert np.isfinite(energies).all()
        assert (np.diff(energies) < 0.0).all()
        assert line.report.iterations >= len(energies) - 1
        straight = surface.mesh.polyline(picks, filter="geodesic", closed=closed, pinned="all")
        assert line.length >= 0.999 * straight.length, "a curve through the picks is no shorter than the straight one"
        rounder += largest_turn_at(line, picks) < largest_turn_at(straight, picks)
    # In triangles as large as a cow's the folds of the surface are the sharpest corners.
    assert rounder >= (2 if name == "cow.off" else 3)


def largest_turn_at(line, picks):
    """The sharpest corner of a line at its inner picks, in radians, as seen in space."""
    pinned = [
        i
        for i in range(1, len(line.points) - 1)
        if (line.barycentric[i] > 0.0).all() and int(line.triangles[i]) in picks
    ]
    ways = np.diff(line.points, axis=0)
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    return max(float(np.arccos(np.clip(ways[i - 1] @ ways[i], -1.0, 1.0))) for i in pinned)


def test_a_longer_detail_size_makes_a_straighter_line():
    surface = open_surface("terrain")
    picks = surface.random_picks(12, 5)
    lines = [surface.mesh.polyline(picks, filter="fair", detail_size=size) for size in (0.001, 0.01, 0.05, 0.2, np.inf)]
    lengths = [line.length for line in lines]
    assert lengths == sorted(lengths, reverse=True)
    through = surface.mesh.polyline(picks, filter="geodesic", pinned="all")
    # Only the way to a pick and back within one triangle is lost.
    assert 0.8 * through.length < lengths[0] < through.length


def test_details_far_beyond_any_mesh_are_taken():
    surface = open_surface("grid")
    picks = surface.random_picks(5, 6)
    for size in (1e-300, 1e-30, 1e30, 1e300):
        surface.checker.check(surface.mesh.polyline(picks, filter="fair", detail_size=size))
    for scale in (2.0**-200, 2.0**-100, 2.0**100, 2.0**200):
        mesh = sp.SurfaceMesh(surface.positions * scale, surface.triangles)
        line = mesh.polyline(picks, filter="fair")
        here = surface.mesh.polyline(picks, filter="fair")
        assert line.length / scale == pytest.approx(here.length, rel=1e-9)


def test_the_report_tells_of_the_curve():
    surface = open_surface("terrain")
    picks = surface.random_picks(4, 7)
    line = surface.mesh.polyline(picks, filter="fair", stages=True)
    report = line.report
    assert report.newton_steps >= report.iterations >= 1
    assert len(report.stages) == 1 + report.iterations
    assert isinstance(report.energies, list)
    assert report.new_self_crossings == 0
    stopped = surface.mesh.polyline(picks, filter="fair", max_iterations=1)
    assert (stopped.report.stop_reason, stopped.report.iterations) == ("max_iterations", 1)
    surface.checker.check(stopped)
    assert surface.mesh.polyline(picks, filter="geodesic").report.energies == []
