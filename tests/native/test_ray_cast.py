"""Rays: against every triangle, through edges and vertices, from inside and out, and what is refused."""

import numpy as np
import pytest

import smooth_polylines as sp

from .made_meshes import make_grid, make_sphere
from .surfaces import open_surface


def first_distances(origins, directions, corners):
    """Distance to the first triangle that each ray clearly meets, by Cramer's rule on all; inf where none is met."""
    a, b, c = (corners[None, :, k] for k in range(3))
    d = directions[:, None] / np.linalg.norm(directions, axis=1)[:, None, None]
    u, v, w = b - a, c - a, origins[:, None] - a
    normal = np.cross(d, v)
    with np.errstate(all="ignore"):
        scale = 1.0 / (u * normal).sum(-1)
        second = (w * normal).sum(-1) * scale
        third = (d * np.cross(w, u)).sum(-1) * scale
        distance = (v * np.cross(w, u)).sum(-1) * scale
        is_met = (second >= 0) & (third >= 0) & (second + third <= 1) & (distance >= 0)
    return np.where(is_met, distance, np.inf).min(axis=1)


@pytest.mark.parametrize("name", ["terrain", "torus", "cow.off", "tray_cad.off", "thingi_79741.off"])
def test_against_every_triangle(name):
    surface = open_surface(name)
    rng = np.random.default_rng(5)
    targets = surface.positions[rng.integers(0, len(surface.positions), 40)]
    origins = targets + surface.diagonal * rng.choice([0.1, 1.0, 20.0], (40, 1)) * rng.normal(size=(40, 3))
    directions = targets + 0.03 * surface.diagonal * rng.normal(size=(40, 3)) - origins
    hits = surface.mesh.ray_cast(origins, directions)
    corners = surface.positions[surface.triangles]
    expected = first_distances(origins, directions, corners)
    assert np.isfinite(expected).sum() > 10, "hardly any ray meets the mesh: the test shows nothing"
    np.testing.assert_allclose(hits.distances, expected, rtol=1e-9, atol=1e-9 * surface.diagonal)
    is_met = hits.triangles >= 0
    assert (is_met == np.isfinite(hits.distances)).all()
    assert [point is not None for point in hits.surface_points] == is_met.tolist()
    assert np.isnan(hits.points[~is_met]).all()
    assert (hits.barycentric[~is_met] == 0).all()
    along = origins + hits.distances[:, None] * directions / np.linalg.norm(directions, axis=1)[:, None]
    np.testing.assert_allclose(hits.points[is_met], along[is_met], rtol=0, atol=1e-9 * surface.diagonal)
    assert (hits.barycentric[is_met] >= 0).all()
    np.testing.assert_allclose(hits.barycentric[is_met].sum(axis=1), 1.0, rtol=0, atol=1e-15)


def test_no_ray_slips_out_of_a_closed_surface():
    # Through each vertex and each edge's midpoint, and through places beside an edge by one rounding.
    positions, triangles = make_sphere(4)
    mesh = sp.SurfaceMesh(positions, triangles)
    first, second = triangles[:, [0, 1]].T
    part = np.random.default_rng(6).random((len(triangles), 1))
    targets = np.concatenate([positions, positions[first] * part + positions[second] * (1 - part)])
    for origin in ([0.0, 0.0, 0.0], [0.1, -0.2, 0.3]):
        hits = mesh.ray_cast(np.broadcast_to(origin, targets.shape), targets - origin)
        assert (hits.triangles >= 0).all()


@pytest.mark.parametrize("dtype", [np.float32, np.float64, ">f8"])
def test_any_layout_and_length_of_direction(dtype):
    mesh = sp.SurfaceMesh(*make_grid(4))
    origins = np.array([[0.25, 0.5, 1.0], [0.5, 0.125, -2.0], [9.0, 9.0, 1.0]])
    for length in (1e-30, 1.0, 1e30):
        directions = np.array([[0, 0, -length], [0, 0, length], [0, 0, -length]])
        hits = mesh.ray_cast(np.asfortranarray(origins.astype(dtype)), directions.astype(dtype))
        assert hits.distances.tolist() == [1.0, 2.0, np.inf]
    assert len(mesh.ray_cast(np.zeros((0, 3)), np.zeros((0, 3)))) == 0
    assert repr(hits) == "<RayHits: 3 rays, 2 met the surface>"


def test_a_hit_is_a_pick():
    mesh = sp.SurfaceMesh(*make_sphere(3))
    hits = mesh.ray_cast([[3.0, 0.1, 0.2], [0.1, 3.0, 0.2]], [[-1.0, 0, 0], [0, -1.0, 0]])
    line = mesh.polyline(hits.surface_points, filter="geodesic")
    np.testing.assert_allclose(line.points[[0, -1]], hits.points, rtol=0, atol=1e-15)


@pytest.mark.parametrize(
    ("origins", "directions", "message"),
    [
        ([[0.0, 0, 0]], [[0.0, 0, 0]], "directions: row 0 has no length"),
        ([[0.0, 0, 0]], [[0.0, 0, 1], [0, 0, 1]], "directions: found 2 rows for 1 rows of origins"),
        ([[0.0, np.nan, 0]], [[0.0, 0, 1]], "origins: row 0 is"),
        ([[0.0, 0, 0]], [[0.0, 0, np.inf]], "directions: row 0 is"),
    ],
)
def test_wrong_rays_are_refused(origins, directions, message):
    with pytest.raises(sp.OptionError, match=message):
        sp.SurfaceMesh(*make_grid(2)).ray_cast(origins, directions)
