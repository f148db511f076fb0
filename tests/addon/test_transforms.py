"""Scaled, rotated and sheared objects: smoothing happens in the world, the result is stored in the object's space."""

import importlib
from types import SimpleNamespace

import numpy as np
import pytest

import bpy

import smooth_polylines as sp
from blender_scenes import (
    SUZANNE_PICKS,
    add_grid,
    count_data,
    enter_edit_mode,
    get_curves,
    get_spline_points,
    get_world_points,
    measure_distances,
    pick_faces,
    read_mesh_slowly,
)


def shear_by_parent(mesh_object):
    """Parent the rotated object to one with three scales: its world matrix is sheared."""
    parent = bpy.data.objects.new("Parent", None)
    bpy.context.scene.collection.objects.link(parent)
    parent.scale, parent.location = (3.0, 0.5, 1.0), (1, 2, 3)
    mesh_object.parent = parent
    mesh_object.rotation_euler = (0.4, 0.7, 0.6)


TRANSFORMS = {
    "scaled": lambda o: setattr(o, "scale", (4.0, 0.5, 1.5)),
    "rotated": lambda o: setattr(o, "rotation_euler", (0.4, 1.7, 2.6)),
    "mirrored": lambda o: setattr(o, "scale", (-1.0, 2.0, 1.0)),
    "tiny": lambda o: setattr(o, "scale", (1e-4, 1e-4, 1e-4)),
    "sheared": shear_by_parent,
}


@pytest.mark.parametrize("name", TRANSFORMS)
def test_curve_is_the_world_line_in_the_objects_space(suzanne, name):
    TRANSFORMS[name](suzanne)
    pick_faces(suzanne, SUZANNE_PICKS)
    bpy.ops.mesh.smooth_polyline_add(filter="LINEAR")
    (curve_object,) = get_curves()
    bpy.context.view_layer.update()

    local, triangles, faces = read_mesh_slowly(suzanne.data)
    matrix = np.array(suzanne.matrix_world, dtype=np.float64)
    world = local @ matrix[:3, :3].T + matrix[:3, 3]
    line = sp.SurfaceMesh(world, triangles, faces).polyline(SUZANNE_PICKS, filter="linear")
    size = np.linalg.norm(np.ptp(world, axis=0))
    np.testing.assert_allclose(get_world_points(curve_object), line.points, atol=1e-6 * size)
    assert measure_distances(get_spline_points(curve_object), local, triangles).max() < 1e-5


def test_uneven_scale_does_not_bend_the_straight_line(scene):
    grid = add_grid(9, 7)
    shear_by_parent(grid)
    enter_edit_mode(grid)
    pick_faces(grid, [0, 62])
    bpy.ops.mesh.smooth_polyline_add(filter="LINEAR")
    bpy.context.view_layer.update()
    points = get_world_points(get_curves()[0])
    start, end = points[0], points[-1]
    along = (end - start) / np.linalg.norm(end - start)
    across = points - start - np.outer((points - start) @ along, along)
    assert len(points) > 10
    assert np.linalg.norm(across, axis=1).max() < 1e-5


def test_a_move_one_line_ago_is_taken_into_account(suzanne):
    pick_faces(suzanne, SUZANNE_PICKS)
    suzanne.scale = (5.0, 0.2, 1.0)
    bpy.ops.mesh.smooth_polyline_add(filter="LINEAR")
    suzanne.scale = (1.0, 1.0, 1.0)
    bpy.ops.mesh.smooth_polyline_add(filter="LINEAR")
    scaled, plain = (get_spline_points(o) for o in get_curves())
    assert scaled.shape != plain.shape or np.abs(scaled - plain).max() > 1e-3


def test_curve_moves_with_its_mesh(suzanne):
    pick_faces(suzanne, SUZANNE_PICKS)
    bpy.ops.mesh.smooth_polyline_add()
    (curve_object,) = get_curves()
    before = get_world_points(curve_object)
    suzanne.location.x += 2.5
    bpy.context.view_layer.update()
    np.testing.assert_allclose(get_world_points(curve_object) - before, [[2.5, 0, 0]] * len(before), atol=1e-6)


@pytest.mark.parametrize("scale", [(1, 0, 1), (0, 0, 0), (1, 1, 1e-9)])
def test_flattened_object_is_refused(suzanne, scale):
    suzanne.scale = scale
    pick_faces(suzanne, SUZANNE_PICKS)
    before = count_data()
    with pytest.raises(RuntimeError, match=r"Suzanne is flattened in the world.*scale other than 0"):
        bpy.ops.mesh.smooth_polyline_add()
    assert count_data() == before


def test_a_thin_but_real_scale_is_taken(suzanne):
    suzanne.scale = (1, 1e-5, 1)
    pick_faces(suzanne, SUZANNE_PICKS)
    assert bpy.ops.mesh.smooth_polyline_add() == {"FINISHED"}


@pytest.mark.parametrize("offset", [0.05, -0.02])
def test_offset_lifts_along_the_normal_by_that_much(scene, offset):
    grid = add_grid(6, 5)
    grid.rotation_euler = (0.3, 1.0, 0.2)
    enter_edit_mode(grid)
    pick_faces(grid, [0, 29])
    bpy.ops.mesh.smooth_polyline_add()
    bpy.ops.mesh.smooth_polyline_add(offset=offset)
    on_surface, lifted = (get_spline_points(o) for o in get_curves())
    np.testing.assert_allclose(lifted - on_surface, [[0, 0, offset]] * len(lifted), atol=1e-6)


def test_offset_is_along_the_normal_that_is_seen_when_the_object_is_sheared(suzanne):
    shear_by_parent(suzanne)
    pick_faces(suzanne, SUZANNE_PICKS)
    bpy.ops.mesh.smooth_polyline_add(filter="NONE")
    bpy.ops.mesh.smooth_polyline_add(filter="NONE", offset=0.01)
    bpy.context.view_layer.update()
    on_surface, lifted = get_curves()
    np.testing.assert_allclose(
        np.linalg.norm(get_spline_points(lifted) - get_spline_points(on_surface), axis=1), 0.01, rtol=1e-3
    )
    # Blender's own normals of the mesh with the transform applied, weighted the same way, point the same way.
    local, triangles, faces = read_mesh_slowly(suzanne.data)
    matrix = np.array(suzanne.matrix_world, dtype=np.float64)[:3, :3]
    world = local @ matrix.T
    line = sp.SurfaceMesh(world, triangles, faces).polyline(SUZANNE_PICKS, filter="none")
    normals = np.array([tuple(v.vector) for v in suzanne.data.vertex_normals]) @ np.linalg.inv(matrix)
    expected = np.einsum("nc,nci->ni", line.barycentric, normals[triangles[line.triangles]])
    found = get_world_points(lifted) - get_world_points(on_surface)
    cosines = np.einsum("ni,ni->n", expected, found) / (
        np.linalg.norm(expected, axis=1) * np.linalg.norm(found, axis=1)
    )
    assert cosines.min() > 0.9999


def test_detail_size_is_a_length_of_the_object(suzanne, monkeypatch):
    session = importlib.import_module("bl_ext.user_default.smooth_polylines.session")
    asked = {}

    class Recorder:
        """Stands for the library's mesh: remembers what is asked of it."""

        def __init__(self, *_arrays):
            pass

        def polyline(self, _picks, **options):
            asked.update(options)

    monkeypatch.setattr(session.native, "load_library", lambda: SimpleNamespace(SurfaceMesh=Recorder))
    suzanne.scale = (2, 2, 2)
    session.compute_polyline(bpy.context, suzanne, SUZANNE_PICKS, filter="fair", detail_size=0.3)
    assert asked == {"filter": "fair", "detail_size": pytest.approx(0.6)}
