"""Wrong inputs: the message says what and what to do, and the scene is as it was. Also quads, n-gons and walls."""

import numpy as np
import pytest

import bpy

import bmesh

import smooth_polylines as sp
from blender_scenes import (
    SUZANNE_PICKS,
    add_grid,
    add_mesh_object,
    count_data,
    enter_edit_mode,
    get_curves,
    get_spline_points,
    pick_faces,
    select_faces_without_order,
)


def assert_refused(match, **properties):
    before = count_data()
    mode, selected = bpy.context.mode, bpy.context.edit_object.data.total_face_sel
    with pytest.raises(RuntimeError, match=match):
        bpy.ops.mesh.smooth_polyline_add(**properties)
    assert count_data() == before
    assert (bpy.context.mode, bpy.context.edit_object.data.total_face_sel) == (mode, selected)


def test_nothing_selected(suzanne):
    assert_refused("No faces are selected on Suzanne.*Shift-click")


def test_one_face_only(suzanne):
    pick_faces(suzanne, [5])
    assert_refused("Only one face is selected.*at least two")


def test_box_selection_has_no_order(suzanne):
    select_faces_without_order(suzanne, [5, 6, 7])
    assert_refused("3 of the 3 selected faces have no order.*box.*Shift-click")


def test_partly_ordered_selection(suzanne):
    select_faces_without_order(suzanne, [40, 41])
    pick_faces(suzanne, SUZANNE_PICKS)
    assert_refused("2 of the 6 selected faces have no order")


def test_selected_vertices_are_not_picks(suzanne):
    bpy.ops.mesh.select_mode(type="VERT")
    edited = bmesh.from_edit_mesh(suzanne.data)
    edited.faces.ensure_lookup_table()
    for vertex in edited.faces[12].verts:
        vertex.select_set(True)
        edited.select_history.add(vertex)
    edited.select_flush_mode()
    bmesh.update_edit_mesh(suzanne.data)
    assert suzanne.data.total_face_sel == 1
    assert_refused("1 of the 1 selected faces have no order.*face select mode")


def test_picks_on_separate_parts(suzanne):
    pick_faces(suzanne, [115, 22])
    assert_refused("picks 0 and 1 lie on parts of the mesh that are not connected.*merge vertices by distance")


def test_two_picks_closed(suzanne):
    pick_faces(suzanne, SUZANNE_PICKS[:2])
    assert_refused("closed", closed=True)


def test_not_finite_vertex(suzanne):
    edited = bmesh.from_edit_mesh(suzanne.data)
    edited.verts.ensure_lookup_table()
    edited.verts[7].co.x = float("nan")
    bmesh.update_edit_mesh(suzanne.data)
    pick_faces(suzanne, SUZANNE_PICKS)
    assert_refused(r"positions\[7\].*must be finite")


def test_outside_edit_mode_poll_says_what_to_do(suzanne):
    bpy.ops.object.mode_set(mode="OBJECT")
    assert not bpy.ops.mesh.smooth_polyline_add.poll()
    with pytest.raises(RuntimeError, match="Enter Edit Mode on a mesh and pick faces"):
        bpy.ops.mesh.smooth_polyline_add()


def test_another_kind_of_object_in_edit_mode(scene):
    bpy.ops.curve.primitive_bezier_circle_add()
    bpy.ops.object.mode_set(mode="EDIT")
    assert not bpy.ops.mesh.smooth_polyline_add.poll()


def test_hidden_faces_are_not_walked_over(scene):
    grid = add_grid(5, 5)
    enter_edit_mode(grid)
    edited = bmesh.from_edit_mesh(grid.data)
    edited.faces.ensure_lookup_table()
    for row in range(4):  # a wall in the middle column with one gap at the top
        edited.faces[row * 5 + 2].hide_set(True)
    bmesh.update_edit_mesh(grid.data)
    pick_faces(grid, [0, 4])
    bpy.ops.mesh.smooth_polyline_add(filter="NONE")
    points = get_spline_points(get_curves()[0])
    in_the_wall = (points[:, 0] > 2.001) & (points[:, 0] < 2.999)
    assert in_the_wall.any()
    assert points[in_the_wall, 1].min() >= 4.0
    np.testing.assert_allclose(points[[0, -1], 0] // 1, [0, 4])

    edited = bmesh.from_edit_mesh(grid.data)
    edited.faces.ensure_lookup_table()
    edited.faces[22].hide_set(True)
    bmesh.update_edit_mesh(grid.data)
    assert_refused("picks 0 and 1 lie on parts of the mesh that are not connected")


def test_all_faces_hidden_but_the_picks_are_gone_too(suzanne):
    pick_faces(suzanne, SUZANNE_PICKS)
    bpy.ops.mesh.hide(unselected=False)
    assert_refused("No faces are selected on Suzanne")


def test_ngons_are_picked_as_polygons(scene):
    strip = [(x, y, 0.0) for x in range(6) for y in (0.0, 1.0)]
    # Two octagon-like n-gons (straight corners) joined by a quad.
    polygons = [(0, 2, 4, 5, 3, 1), (4, 6, 7, 5), (6, 8, 10, 11, 9, 7)]
    mesh_object = add_mesh_object("Ngons", strip, polygons)
    enter_edit_mode(mesh_object)
    pick_faces(mesh_object, [2, 0])
    bpy.ops.mesh.smooth_polyline_add(filter="LINEAR")
    points = get_spline_points(get_curves()[0])
    assert points[0, 0] > 3.0
    assert points[-1, 0] < 2.0
    assert np.all(np.diff(points[:, 0]) < 0)


def test_numbers_of_faces_are_right_after_a_script_removed_some(suzanne):
    edited = bmesh.from_edit_mesh(suzanne.data)
    edited.faces.ensure_lookup_table()
    kept = [edited.faces[i] for i in SUZANNE_PICKS]
    expected = [tuple(face.calc_center_median()) for face in kept]
    bmesh.ops.delete(edited, geom=[edited.faces[i] for i in range(20)], context="FACES_ONLY")
    for face in kept:
        face.select_set(True)
        edited.select_history.add(face)
    bmesh.update_edit_mesh(suzanne.data)
    bpy.ops.mesh.smooth_polyline_add()
    points = get_spline_points(get_curves()[0])
    # The ends are barycentres of triangles within the first and the last picked face.
    assert np.linalg.norm(points[0] - expected[0]) < 0.05
    assert np.linalg.norm(points[-1] - expected[-1]) < 0.05


def test_linked_mesh_is_refused_with_the_reason(suzanne, session, tmp_path):
    bpy.ops.object.mode_set(mode="OBJECT")
    library = tmp_path / "library.blend"
    bpy.data.libraries.write(str(library), {suzanne})
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    with bpy.data.libraries.load(str(library), link=True) as (_, wanted):
        wanted.objects = ["Suzanne"]
    (linked,) = wanted.objects
    bpy.context.scene.collection.objects.link(linked)
    before = count_data()
    with pytest.raises(session.ObjectError, match=r"Suzanne is linked from .*library.blend.*make it local"):
        session.add_polyline(bpy.context, linked, SUZANNE_PICKS)
    assert count_data() == before


def test_the_session_is_a_plain_function_for_scripts(suzanne, session):
    bpy.ops.object.mode_set(mode="OBJECT")
    added = session.add_polyline(
        bpy.context, suzanne, SUZANNE_PICKS, filter="cubic", closed=True, pinned=[True, False, True, False], name="Mine"
    )
    assert added.curve_object.name == "Mine"
    np.testing.assert_array_equal(get_spline_points(added.curve_object), added.line.points.astype(np.float32))
    before = count_data()
    with pytest.raises(sp.OptionError, match="picks"):
        session.add_polyline(bpy.context, suzanne, [0, 100000])
    with pytest.raises(session.ObjectError, match="a curve object"):
        session.add_polyline(bpy.context, added.curve_object, [0, 1])
    with pytest.raises(session.ObjectError, match="nothing"):
        session.add_polyline(bpy.context, None, [0, 1])
    assert count_data() == before


@pytest.fixture
def session(extension):
    from bl_ext.user_default.smooth_polylines import session

    return session
