"""Picks for a line that was made without any: the line through them is nearly that line, whatever its filter."""

import itertools

import numpy as np
import pytest

import bpy

FILTERS = ("fair", "cubic", "linear", "geodesic")


@pytest.fixture
def opened(scene):
    from bl_ext.user_default.smooth_polylines import surface

    bpy.ops.mesh.primitive_torus_add(major_segments=96, minor_segments=48, major_radius=1, minor_radius=0.25)
    return surface.open_surface(bpy.context, bpy.context.object)


def make_drawn(is_closed):
    """A wavy stroke round the ring, a little off it."""
    turn = np.linspace(0, 2 * np.pi if is_closed else 4.5, 160, endpoint=not is_closed)
    wave = 0.6 * np.sin(6 * turn)
    radius = 1 + 0.26 * np.cos(wave)
    return np.stack([radius * np.cos(turn), radius * np.sin(turn), 0.26 * np.sin(wave)], axis=1)


def measure_gap(places, chain):
    """Largest distance of a place from a chain of straight pieces."""
    starts, pieces = chain[:-1], np.diff(chain, axis=0)
    offsets = places[:, None] - starts
    squares = np.maximum((pieces**2).sum(axis=1), 1e-30)
    parts = np.clip((offsets * pieces).sum(axis=2) / squares, 0, 1)
    return np.linalg.norm(offsets - parts[..., None] * pieces, axis=2).min(axis=1).max()


@pytest.mark.parametrize(("kind", "is_closed"), list(itertools.product(FILTERS, (False, True))))
def test_the_line_through_the_picks_keeps_to_the_drawn_line(opened, kind, is_closed):
    from bl_ext.user_default.smooth_polylines import line_picks

    line = opened.library_mesh.stroke(make_drawn(is_closed), closed=is_closed, filter=kind)
    picks = line_picks.choose_picks(opened, line, filter=kind)
    again = opened.library_mesh.polyline(picks, closed=is_closed, pinned="all", filter=kind)
    diagonal = np.linalg.norm(np.ptp(opened.arrays.world_positions, axis=0))
    chain = np.concatenate([again.points, again.points[:1]]) if is_closed else again.points
    assert measure_gap(line.points, chain) < 2e-3 * diagonal
    # A cubic through pins near each other is led by few neighbours, and less like the drawn one than the others are.
    assert len(picks) < min(90 if kind == "cubic" else 60, len(line.points) / 3)


def test_a_point_a_short_line_and_a_long_one(opened):
    from bl_ext.user_default.smooth_polylines import line_picks

    mesh = opened.library_mesh
    for picks in ([5], [5, 5], [0, 1]):
        line = mesh.polyline(picks, filter="geodesic")
        chosen = line_picks.choose_picks(opened, line, filter="geodesic")
        np.testing.assert_array_equal(mesh.polyline(chosen, filter="geodesic").points, line.points)
    far = mesh.polyline([0, 48 * 48] * 12, filter="geodesic", pinned="all")
    assert len(far.points) > line_picks.MOST_SAMPLES
    assert len(line_picks.choose_samples(far)) <= line_picks.MOST_SAMPLES
