"""What is read of a mesh against slow Python loops: in and out of Edit Mode, n-gons, hidden faces, shape keys."""

import numpy as np
import pytest

import bpy

import bmesh

from blender_scenes import add_grid, add_mesh_object, count_data, enter_edit_mode, read_mesh_slowly


@pytest.fixture
def mesh_read(extension):
    from bl_ext.user_default.smooth_polylines import mesh_read

    return mesh_read


def assert_same_as_slow_loops(arrays, mesh):
    positions, triangles, faces = read_mesh_slowly(mesh)
    np.testing.assert_array_equal(arrays.local_positions, positions)
    np.testing.assert_array_equal(arrays.triangles, triangles)
    np.testing.assert_array_equal(arrays.triangle_faces, faces)
    assert arrays.triangles.dtype == arrays.triangle_faces.dtype == np.int32
    assert arrays.world_positions.dtype == np.float64


def test_object_mode_equals_slow_loops(suzanne, mesh_read):
    bpy.ops.object.mode_set(mode="OBJECT")
    arrays = mesh_read.read_mesh(suzanne)
    assert_same_as_slow_loops(arrays, suzanne.data)
    np.testing.assert_array_equal(arrays.world_positions, arrays.local_positions)
    assert len(arrays.triangles) == 968


def test_edit_mode_reads_what_was_just_changed_and_leaves_no_data_behind(suzanne, mesh_read):
    before = count_data()
    edited = bmesh.from_edit_mesh(suzanne.data)
    edited.faces.ensure_lookup_table()
    bmesh.ops.delete(edited, geom=[edited.faces[3], edited.faces[100]], context="FACES")
    for vertex in edited.verts:
        vertex.co.x += 0.25
    bmesh.update_edit_mesh(suzanne.data)
    arrays = mesh_read.read_mesh(suzanne)
    assert count_data() == before
    bpy.ops.object.mode_set(mode="OBJECT")
    assert_same_as_slow_loops(arrays, suzanne.data)
    assert arrays.triangle_faces.max() == 497


def test_hidden_faces_are_left_out_and_polygon_ids_stay(suzanne, mesh_read):
    edited = bmesh.from_edit_mesh(suzanne.data)
    edited.faces.ensure_lookup_table()
    for face in edited.faces[10:60]:
        face.hide_set(True)
    bmesh.update_edit_mesh(suzanne.data)
    arrays = mesh_read.read_mesh(suzanne)
    assert not set(range(10, 60)) & set(arrays.triangle_faces.tolist())
    assert {9, 60, 499} <= set(arrays.triangle_faces.tolist())
    bpy.ops.object.mode_set(mode="OBJECT")
    assert_same_as_slow_loops(arrays, suzanne.data)


def test_concave_ngon_has_blenders_own_triangles(scene, mesh_read):
    corners = [(0, 0, 0), (4, 0, 0), (4, 3, 0), (2, 1, 0), (0, 3, 0), (0, 1.5, 0)]
    mesh_object = add_mesh_object("L", [*corners, (4, 0, 1), (0, 0, 1)], [(0, 1, 2, 3, 4, 5), (1, 0, 7, 6)])
    enter_edit_mode(mesh_object)
    arrays = mesh_read.read_mesh(mesh_object)
    bpy.ops.object.mode_set(mode="OBJECT")
    assert_same_as_slow_loops(arrays, mesh_object.data)
    assert arrays.triangle_faces.tolist() == [0, 0, 0, 0, 1, 1]


def test_edit_mode_reads_the_active_shape_key_that_is_seen(scene, mesh_read):
    mesh_object = add_grid(3, 2)
    mesh_object.shape_key_add(name="Basis")
    raised = mesh_object.shape_key_add(name="Raised")
    for row in raised.data:
        row.co.z = 1.5
    mesh_object.active_shape_key_index = 1
    enter_edit_mode(mesh_object)
    before = count_data()
    assert {v.co.z for v in bmesh.from_edit_mesh(mesh_object.data).verts} == {1.5}
    np.testing.assert_array_equal(mesh_read.read_mesh(mesh_object).local_positions[:, 2], 1.5)
    assert count_data() == before

    bpy.ops.object.mode_set(mode="OBJECT")
    mesh_object.active_shape_key_index = 0
    enter_edit_mode(mesh_object)
    np.testing.assert_array_equal(mesh_read.read_mesh(mesh_object).local_positions[:, 2], 0.0)


def test_world_positions_are_those_of_the_object_in_the_world(suzanne, mesh_read):
    suzanne.location, suzanne.rotation_euler, suzanne.scale = (3, -2, 1), (0.3, 0.2, 2), (0.5, -2, 3)
    bpy.context.view_layer.update()
    arrays = mesh_read.read_mesh(suzanne)
    expected = [tuple(suzanne.matrix_world @ v.co) for v in suzanne.data.vertices]
    np.testing.assert_allclose(arrays.world_positions, expected, atol=2e-6)  # Blender's own product has 32 bits
    assert mesh_read.measure_mean_scale(arrays.world_matrix) == pytest.approx(3 ** (1 / 3), rel=1e-6)


def test_normals_are_blenders_vertex_normals(suzanne, mesh_read):
    arrays = mesh_read.read_mesh(suzanne, with_normals=True)
    bpy.ops.object.mode_set(mode="OBJECT")
    expected = [tuple(v.vector) for v in suzanne.data.vertex_normals]
    np.testing.assert_array_equal(arrays.local_normals, np.array(expected))
    assert mesh_read.read_mesh(suzanne).local_normals is None


@pytest.mark.parametrize("quad_method", ["BEAUTY", "FIXED"])
def test_a_mesh_of_triangles_alone_is_read_without_asking_for_each(suzanne, mesh_read, quad_method):
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.mesh.quads_convert_to_tris(quad_method=quad_method)
    bpy.ops.object.mode_set(mode="OBJECT")
    suzanne.data.polygons[7].hide = True
    arrays = mesh_read.read_mesh(suzanne)
    positions, triangles, faces = read_mesh_slowly(suzanne.data)
    np.testing.assert_array_equal(arrays.local_positions, positions)
    np.testing.assert_array_equal(arrays.triangles, triangles)
    np.testing.assert_array_equal(arrays.triangle_faces, faces)
