"""Closed lines: what holds them open, what shrinks, where they begin."""

import numpy as np
import pytest

import smooth_polylines as sp
from native.made_meshes import make_cylinder, nearest_triangle
from native.surfaces import open_surface

FILTERS = ("linear", "cubic", "geodesic", "fair")


def make_waist(around=24, along=16):
    """A cylinder that is narrow in the middle, and three picks round it, off the middle."""
    positions, triangles = make_cylinder(around, along)
    positions[:, :2] *= (0.5 + 0.25 * (positions[:, 2:3] - 2) ** 2) / 1.5
    picks = [nearest_triangle(positions, triangles, [0.6 * np.cos(a), 0.6 * np.sin(a), 1.2]) for a in (0.1, 2.2, 4.3)]
    return positions, triangles, picks


@pytest.mark.parametrize("filter_name", ["linear", "geodesic"])
def test_a_closed_line_finds_the_waist(filter_name):
    positions, triangles, picks = make_waist()
    mesh = sp.SurfaceMesh(positions, triangles)
    line = mesh.polyline(picks, closed=True, filter=filter_name, threshold=1e-12)
    # The waist is the ring of vertices at height 2, a 24-gon.
    radius = 0.5 / 1.5
    assert np.abs(line.points[:, 2] - 2).max() < 1e-3
    assert line.length == pytest.approx(24 * 2 * radius * np.sin(np.pi / 24), rel=1e-6)


@pytest.mark.parametrize("filter_name", FILTERS)
def test_pins_hold_a_closed_line(filter_name):
    surface = open_surface("grid")
    corners = [[0.2, 0.2, 0], [0.8, 0.3, 0], [0.5, 0.8, 0]]
    picks = [nearest_triangle(surface.positions, surface.triangles, corner) for corner in corners]
    line = surface.mesh.polyline(picks, closed=True, filter=filter_name, pinned="all")
    surface.checker.check(line, pins=[(t, [1 / 3] * 3) for t in picks])
    places = surface.positions[surface.triangles[picks]].mean(axis=1)
    straight = np.linalg.norm(places - np.roll(places, 1, axis=0), axis=1).sum()
    assert line.length >= straight * (1 - 1e-12)
    if filter_name == "geodesic":
        assert line.length == pytest.approx(straight, rel=1e-12)


@pytest.mark.parametrize("filter_name", FILTERS)
def test_one_pin_of_three_keeps_its_point(filter_name):
    surface = open_surface("torus")
    picks = [
        nearest_triangle(surface.positions, surface.triangles, [1.4 * np.cos(a), 1.4 * np.sin(a), 0]) for a in (0, 2, 4)
    ]
    line = surface.mesh.polyline(picks, closed=True, filter=filter_name, pinned=[False, True, False])
    surface.checker.check(line, pins=[(picks[1], [1 / 3] * 3)])
    assert sum(int((row > 0).all()) for row in line.barycentric) == 1


@pytest.mark.parametrize("filter_name", FILTERS)
def test_a_closed_line_round_the_torus_does_not_break_or_collapse(filter_name):
    surface = open_surface("torus")
    picks = [
        nearest_triangle(surface.positions, surface.triangles, [1.4 * np.cos(a), 1.4 * np.sin(a), 0]) for a in (0, 2, 4)
    ]
    line = surface.mesh.polyline(picks, closed=True, filter=filter_name)
    surface.checker.check(line, pins=[])
    # It still goes once round the hole.
    angle = np.unwrap(np.arctan2(line.points[:, 1], line.points[:, 0]))
    assert abs(angle[-1] - angle[0]) > 2 * np.pi * 0.8


@pytest.mark.parametrize("start", [1, 2, 3])
def test_a_closed_geodesic_does_not_depend_on_where_it_begins(start):
    surface = open_surface("torus")
    picks = surface.random_picks(4, 71)
    lengths = [
        surface.mesh.polyline(order, closed=True, filter="geodesic", pinned="all").length
        for order in (picks, picks[start:] + picks[:start])
    ]
    assert lengths[0] == pytest.approx(lengths[1], rel=1e-12)


@pytest.mark.parametrize("name", ["spot.obj", "igea.ply"])
def test_the_papers_ring_of_thirty_picks_keeps_its_shape(name):
    """The paper, figures 14 and 15: a closed cubic line through 30 picks.

    The picks lie on a plane cut of the mesh, in angular order.
    """
    surface = open_surface(name)
    centres = surface.positions[surface.triangles].mean(axis=1)
    middle = (surface.positions.max(axis=0) + surface.positions.min(axis=0)) / 2
    offset = centres - middle
    # The longest axis of the box is cut across.
    axis = int(np.ptp(surface.positions, axis=0).argmax())
    u, v = (k for k in range(3) if k != axis)
    near = np.flatnonzero(np.abs(offset[:, axis]) < 0.02 * surface.diagonal)
    angle = np.arctan2(offset[near, v], offset[near, u])
    radius = np.hypot(offset[near, u], offset[near, v])
    picks = []
    for a in np.linspace(-np.pi, np.pi, 30, endpoint=False):
        turn = np.abs((angle - a + np.pi) % (2 * np.pi) - np.pi)
        sector = np.flatnonzero(turn < 0.1)
        picks.append(int(near[sector[radius[sector].argmax()]]))
    # Of finer thresholds the filter makes more than a smooth ring: it has no limit.
    line = surface.mesh.polyline(picks, closed=True, filter="cubic", threshold=1e-2)
    surface.checker.check(line, pins=[])
    assert line.report.stop_reason in ("converged", "converged_at_vertices")
    ring = surface.positions[surface.triangles[picks]].mean(axis=1)
    chords = np.linalg.norm(ring - np.roll(ring, 1, axis=0), axis=1).sum()
    # It takes out the strip's stairs and little more.
    assert 0.9 * chords < line.length <= line.report.start_length
    # Every pick is still near the line: the shape stays.
    nearest = np.linalg.norm(ring[:, None] - line.points[None], axis=2).min(axis=1)
    assert nearest.max() < 0.05 * surface.diagonal
