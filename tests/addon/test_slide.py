"""Vertices of an edge path moved onto a line: where they come to lie, what they carry, and which must stay."""

import itertools
from types import SimpleNamespace

import numpy as np
import pytest

import bpy

import bmesh

from attributed_mesh import COLUMNS, add_attributed_grid, read_everything
from blender_scenes import add_grid

WIDTH = COLUMNS + 1
UPPER, LOWER = np.array([[0.1, 0.02], [-0.05, 0.1]]), np.array([[0.07, -0.03], [0.01, 0.12]])


def test_alignment_is_the_cheapest_that_keeps_the_order(seams):
    random = np.random.default_rng(5)
    for _ in range(30):
        count, segments = int(random.integers(2, 6)), int(random.integers(1, 6))
        points = random.random((segments + 1, 3))
        places = random.random((count, 3))
        found, along = seams.align.align_path(places, points, False)
        assert (np.diff(found + along) >= 0).all()
        np.testing.assert_array_equal([found[0], along[0], found[-1], along[-1]], [0, 0, segments - 1, 1])
        if count > 3:
            continue
        # Against every choice of segments for the vertices between.
        _, costs = seams.align.measure_segments(places, points[:-1], points[1:])
        best = min(
            sum(costs[k + 1, s] for k, s in enumerate(choice))
            for choice in itertools.combinations_with_replacement(range(segments), count - 2)
        )
        if len(set(found[1:-1].tolist())) == count - 2:  # nothing was moved for the order within a segment
            assert sum(costs[k + 1, s] for k, s in enumerate(found[1:-1])) == pytest.approx(best)


def test_a_closed_path_goes_once_round(seams):
    angle = np.linspace(0, 2 * np.pi, 24, endpoint=False)
    points = np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
    around = np.linspace(0.9, 0.9 + 2 * np.pi, 10, endpoint=False)
    places = 1.2 * np.column_stack([np.cos(around), np.sin(around), 0 * around])
    segments, along = seams.align.align_path(places, points, True)
    following = np.roll(points, -1, axis=0)
    found = points[segments] + along[:, None] * (following - points)[segments]
    assert np.linalg.norm(found * 1.2 - places, axis=1).max() < 0.03
    assert len(np.unique(np.round(found, 9), axis=0)) == 10


def add_two_charts():
    """The attributed grid, flat, with UV maps that are linear in place, one rule above row 2 and one below."""
    grid = add_attributed_grid()
    mesh = grid.data
    grid.shape_key_clear()
    flat = np.array([(v.co.x, v.co.y, 0) for v in mesh.vertices], dtype=np.float32)
    mesh.attributes["position"].data.foreach_set("vector", flat.ravel())
    for layer in mesh.uv_layers:
        for polygon in mesh.polygons:
            for loop in polygon.loop_indices:
                place = flat[mesh.loops[loop].vertex_index, :2].astype(np.float64)
                layer.data[loop].uv = choose_rule(polygon) @ place
    grid.shape_key_add(name="Basis")
    key = grid.shape_key_add(name="Bent")
    key.data.foreach_set("co", np.column_stack([*flat[:, :2].T, bend(flat[:, 0])]).astype(np.float32).ravel())
    return grid


def bend(x):
    return 0.2 * np.abs(x - 2.5)


def choose_rule(polygon):
    return UPPER if polygon.center.y > 2 else LOWER


def make_line(seams, grid, start, end):
    """A straight line of the library between two places of the flat grid."""
    opened = seams.surface.open_surface(bpy.context, grid)
    near = opened.library_mesh.closest_points(np.array([start, end], dtype=np.float64))
    return opened, opened.library_mesh.polyline(near.surface_points, filter="geodesic")


def slide_row(seams, grid, line, opened, numbers):
    targets = seams.put.aim(line, SimpleNamespace(vertices=np.array(numbers)), opened.arrays)
    with seams.edit.open_bmesh(grid) as edited:
        edited.verts.ensure_lookup_table()
        return seams.slide.slide_vertices(edited, targets)


ROW = [2 * WIDTH + c for c in range(WIDTH)]


def test_the_row_lies_on_the_line_and_carries_what_was_there(scene, seams):
    grid = add_two_charts()
    before = read_everything(grid)
    opened, line = make_line(seams, grid, (0.0, 1.7, 0), (5.0, 2.4, 0))
    moved, not_moved = slide_row(seams, grid, line, opened, ROW)
    assert (moved, not_moved) == (ROW, [])
    after = read_everything(grid)
    assert set(before) <= set(after)
    mesh = grid.data
    for number in ROW:
        x, y, z = mesh.vertices[number].co
        assert abs(y - (1.7 + 0.14 * x)) < 1e-6
        assert z == 0
        # The other shape moves on its own surface.
        assert abs(mesh.shape_keys.key_blocks[1].data[number].co.z - bend(x)) < 0.2 * 0.5 + 1e-6
    others = np.setdiff1d(np.arange(len(mesh.vertices)), ROW)
    for name, (domain, values) in before.items():
        if domain == "POINT":
            np.testing.assert_array_equal(after[name][1][others], values[others], err_msg=name)
        elif domain != "CORNER":
            np.testing.assert_array_equal(after[name][1], values, err_msg=name)
    for polygon in mesh.polygons:
        assert polygon.normal.z > 0.99
        for loop in polygon.loop_indices:
            place = np.array(mesh.vertices[mesh.loops[loop].vertex_index].co[:2])
            for layer in mesh.uv_layers:
                if layer.name.startswith("UV"):
                    np.testing.assert_allclose(layer.data[loop].uv, choose_rule(polygon) @ place, atol=2e-6)


def test_points_carry_the_weighed_values_of_their_triangle(scene, seams):
    grid = add_two_charts()
    before = read_everything(grid)
    opened, line = make_line(seams, grid, (0.0, 1.7, 0), (5.0, 2.4, 0))
    targets = seams.put.aim(line, SimpleNamespace(vertices=np.array(ROW)), opened.arrays)
    slide_row(seams, grid, line, opened, ROW)
    after = read_everything(grid)
    for target in targets:
        for name in (
            "POINT FLOAT",
            "POINT FLOAT_VECTOR",
            "POINT FLOAT_COLOR",
            "key Basis",
            "key Bent",
            "group Group 0",
        ):
            expected = target.weights @ before[name][1][target.triangle].astype(np.float64)
            np.testing.assert_allclose(after[name][1][target.vertex], expected, atol=3e-6, err_msg=name)


def test_a_line_through_the_vertices_themselves_leaves_all_as_it_was(scene, seams):
    grid = add_two_charts()
    before = read_everything(grid)
    opened, line = make_line(seams, grid, (0.0, 2.0, 0), (5.0, 2.0, 0))
    targets = seams.put.aim(line, SimpleNamespace(vertices=np.array(ROW)), opened.arrays)
    assert max(np.sort(target.weights)[-2] for target in targets) < 1e-9
    moved, not_moved = slide_row(seams, grid, line, opened, ROW)
    assert (moved, not_moved) == (ROW, [])
    after = read_everything(grid)
    for name, (_, values) in before.items():
        np.testing.assert_allclose(after[name][1], values, atol=1e-6, err_msg=name)


def test_what_would_turn_a_face_over_stays_and_is_told(scene, seams):
    grid = add_grid(5, 4)
    opened = seams.surface.open_surface(bpy.context, grid)
    triangles = opened.arrays.triangles
    before = read_everything(grid)["positions"][1]

    def aim_at(vertex, place):
        near = opened.library_mesh.closest_points(np.array([place], dtype=np.float64))
        return seams.slide.Target(vertex, triangles[near.triangles[0]], near.barycentric[0])

    inner = 2 * 6 + 2  # at (2, 2)
    for place, is_possible in (((2.4, 2.3, 0), True), ((2.99, 2.999, 0), False), ((3.5, 2.2, 0), False)):
        with seams.edit.open_bmesh(grid) as edited:
            edited.verts.ensure_lookup_table()
            moved, stuck = seams.slide.slide_vertices(edited, [aim_at(inner, place)])
        assert (moved, stuck) == (([inner], []) if is_possible else ([], [inner]))
        for polygon in grid.data.polygons:
            assert polygon.normal.z > 0.99
        grid.data.vertices[inner].co = before[inner]
        grid.data.update()


def test_a_shape_key_that_would_turn_a_face_over_holds_it_too(scene, seams):
    grid = add_grid(5, 4)
    grid.shape_key_add(name="Basis")
    key = grid.shape_key_add(name="Squeezed")
    inner = 2 * 6 + 2
    # In this shape the corner at (2, 3) lies far down: the goal, on the triangle of it, would be beyond the others.
    key.data[inner + 6].co.y = 0.2
    opened = seams.surface.open_surface(bpy.context, grid)
    near = opened.library_mesh.closest_points(np.array([(2.05, 2.6, 0)]))
    target = seams.slide.Target(inner, opened.arrays.triangles[near.triangles[0]], near.barycentric[0])
    with seams.edit.open_bmesh(grid) as edited:
        edited.verts.ensure_lookup_table()
        assert seams.slide.slide_vertices(edited, [target]) == ([], [inner])
    assert tuple(grid.data.vertices[inner].co) == (2.0, 2.0, 0.0)


def test_in_edit_mode_the_same_vertices_move(scene, seams):
    grid = add_two_charts()
    opened, line = make_line(seams, grid, (0.0, 1.7, 0), (5.0, 2.4, 0))
    grid.select_set(True)
    bpy.context.view_layer.objects.active = grid
    grid.active_shape_key_index = 0
    bpy.ops.object.mode_set(mode="EDIT")
    moved, _ = slide_row(seams, grid, line, opened, ROW)
    assert moved == ROW
    edited = bmesh.from_edit_mesh(grid.data)
    edited.verts.ensure_lookup_table()
    for number in ROW:
        x, y, _ = edited.verts[number].co
        assert abs(y - (1.7 + 0.14 * x)) < 1e-6
    bpy.ops.object.mode_set(mode="OBJECT")
    assert len(grid.data.vertices) == WIDTH * 5
