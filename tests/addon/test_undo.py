"""One Undo takes the curve back, Redo brings it again; a refusal leaves no step behind."""

import numpy as np
import pytest

import bpy

import bmesh

from blender_scenes import SUZANNE_PICKS, add_grid, enter_edit_mode, get_curves, get_spline_points, pick_faces


def call_as_the_interface_does(**properties):
    return bpy.ops.mesh.smooth_polyline_add("EXEC_DEFAULT", True, **properties)


def get_history():
    return [f.index for f in list(bmesh.from_edit_mesh(bpy.context.edit_object.data).select_history)]


def test_one_undo_takes_it_back_and_redo_brings_it(suzanne):
    pick_faces(suzanne, SUZANNE_PICKS)
    bpy.ops.ed.undo_push(message="Pick")
    assert call_as_the_interface_does() == {"FINISHED"}
    points = get_spline_points(get_curves()[0])

    bpy.ops.ed.undo()
    assert get_curves() == []
    assert [o.name for o in bpy.data.objects] == ["Suzanne"]
    assert len(bpy.data.curves) == 0
    assert get_history() == SUZANNE_PICKS
    assert bpy.context.mode == "EDIT_MESH"

    bpy.ops.ed.redo()
    np.testing.assert_array_equal(get_spline_points(get_curves()[0]), points)
    assert get_curves()[0].parent.name == "Suzanne"


def test_other_settings_after_undo_as_in_the_redo_panel(suzanne):
    pick_faces(suzanne, SUZANNE_PICKS)
    bpy.ops.ed.undo_push(message="Pick")
    call_as_the_interface_does(filter="NONE")
    rough = get_spline_points(get_curves()[0])
    bpy.ops.ed.undo()
    call_as_the_interface_does(filter="LINEAR")
    (curve_object,) = get_curves()
    smooth = get_spline_points(curve_object)
    assert measure_length(smooth) < 0.97 * measure_length(rough)


def test_undo_after_an_edit_and_a_line_takes_back_the_line_only(scene):
    grid = add_grid(6, 5)
    enter_edit_mode(grid)
    bpy.ops.ed.undo_push(message="Grid")
    edited = bmesh.from_edit_mesh(grid.data)
    for vertex in edited.verts:
        vertex.co.z = 0.5
    bmesh.update_edit_mesh(grid.data)
    bpy.ops.ed.undo_push(message="Raise")
    pick_faces(grid, [0, 29])
    bpy.ops.ed.undo_push(message="Pick")
    call_as_the_interface_does()
    assert (get_spline_points(get_curves()[0])[:, 2] == 0.5).all()
    bpy.ops.ed.undo()
    assert get_curves() == []
    assert {v.co.z for v in bmesh.from_edit_mesh(bpy.context.edit_object.data).verts} == {0.5}
    assert get_history() == [0, 29]


def test_refusal_pushes_no_undo_step(suzanne):
    pick_faces(suzanne, SUZANNE_PICKS)
    bpy.ops.ed.undo_push(message="Pick")
    bpy.ops.mesh.select_all(action="DESELECT")
    bpy.ops.ed.undo_push(message="Deselect")
    with pytest.raises(RuntimeError, match="No faces are selected"):
        call_as_the_interface_does()
    bpy.ops.ed.undo()
    assert get_history() == SUZANNE_PICKS


def measure_length(points):
    return np.linalg.norm(np.diff(points, axis=0), axis=1).sum()
