"""Curves that remember: they follow the mesh, are made again by their settings, and survive what files go through."""

import json

import numpy as np
import pytest

import bpy

import bmesh

from blender_scenes import (
    SUZANNE_PICKS,
    add_grid,
    enter_edit_mode,
    get_curves,
    get_spline_points,
    measure_distances,
    pick_faces,
)


@pytest.fixture
def session(extension):
    from bl_ext.user_default.smooth_polylines import session

    return session


@pytest.fixture
def head(suzanne):
    bpy.ops.object.mode_set(mode="OBJECT")
    return suzanne


def add_curve(session, mesh_object, picks=SUZANNE_PICKS, **options):
    options = {"filter": "fair", "pinned": "all", **options}
    return session.add_polyline(bpy.context, mesh_object, picks, **options).curve_object


def measure_distance_to_surface(curve_object, mesh_object):
    """Largest distance of the curve's points to the evaluated mesh, in the object's space."""
    bpy.context.view_layer.update()
    evaluated = mesh_object.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    evaluated.calc_loop_triangles()
    positions = np.array([v.co for v in evaluated.vertices], dtype=np.float64)
    triangles = np.array([t.vertices for t in evaluated.loop_triangles])
    return measure_distances(get_spline_points(curve_object), positions, triangles).max()


def add_armature(mesh_object):
    """Bends the upper half of the mesh by a bone that turns over frames 1 to 20."""
    armature = bpy.data.objects.new("Armature", bpy.data.armatures.new("Armature"))
    bpy.context.scene.collection.objects.link(armature)
    bpy.context.view_layer.objects.active = armature
    bpy.ops.object.mode_set(mode="EDIT")
    bone = armature.data.edit_bones.new("Bone")
    bone.head, bone.tail = (0, 0, 0), (0, 0, 1)
    bpy.ops.object.mode_set(mode="OBJECT")
    group = mesh_object.vertex_groups.new(name="Bone")
    for vertex in mesh_object.data.vertices:
        group.add([vertex.index], max(0.0, min(1.0, vertex.co.z + 0.5)), "REPLACE")
    mesh_object.modifiers.new("Armature", "ARMATURE").object = armature
    pose = armature.pose.bones["Bone"]
    pose.rotation_mode = "XYZ"
    for frame, angle in ((1, 0.0), (20, 1.2)):
        pose.rotation_euler = (angle, 0.3 * angle, 0.0)
        pose.keyframe_insert("rotation_euler", frame=frame)
    return armature


@pytest.mark.parametrize("options", [{}, {"resample": 0.05}, {"filter": "geodesic", "closed": True}])
def test_points_stay_on_a_posed_mesh_over_twenty_frames(head, session, options):
    curve_object = add_curve(session, head, **options)
    add_armature(head)
    seen = []
    for frame in range(1, 21):
        bpy.context.scene.frame_set(frame)
        assert measure_distance_to_surface(curve_object, head) < 1e-5
        seen.append(get_spline_points(curve_object))
    assert np.abs(seen[-1] - seen[0]).max() > 0.2, "the pose hardly moved the curve: the test shows nothing"
    bpy.context.scene.frame_set(1)
    np.testing.assert_array_equal(get_spline_points(curve_object), seen[0])


def test_a_line_made_on_a_posed_mesh_lies_on_the_pose(head, session):
    add_armature(head)
    bpy.context.scene.frame_set(20)
    curve_object = add_curve(session, head)
    assert measure_distance_to_surface(curve_object, head) < 1e-5
    curve_object.data.smooth_polyline.filter = "GEODESIC"
    assert measure_distance_to_surface(curve_object, head) < 1e-5
    posed = get_spline_points(curve_object)
    bpy.context.scene.frame_set(1)
    assert np.abs(get_spline_points(curve_object) - posed).max() > 0.2


def test_shape_keys_and_edits_of_vertices_are_followed(head, session):
    curve_object = add_curve(session, head)
    head.shape_key_add(name="Basis")
    key = head.shape_key_add(name="Wide")
    for point in key.data:
        point.co.x *= 1.5
    before = get_spline_points(curve_object)
    key.value = 1.0
    bpy.context.view_layer.update()
    np.testing.assert_allclose(get_spline_points(curve_object), before * [1.5, 1, 1], rtol=0, atol=1e-6)
    assert measure_distance_to_surface(curve_object, head) < 1e-6


def test_an_offset_is_kept_while_following(head, session):
    curve_object = add_curve(session, head, offset=0.05)
    add_armature(head)
    bpy.context.scene.frame_set(20)
    assert 0.02 < measure_distance_to_surface(curve_object, head) < 0.051


def test_a_modifier_that_changes_the_topology_leaves_the_curve(head, session):
    curve_object = add_curve(session, head)
    before = get_spline_points(curve_object)
    head.modifiers.new("Subdivision", "SUBSURF")
    bpy.context.scene.frame_set(3)
    np.testing.assert_array_equal(get_spline_points(curve_object), before)
    assert curve_object.data.smooth_polyline.state == "CURRENT"


def test_on_the_surface_that_modifiers_make(head, session):
    modifier = head.modifiers.new("Subdivision", "SUBSURF")
    curve_object = add_curve(session, head, source="EVALUATED")
    assert measure_distance_to_surface(curve_object, head) < 1e-5
    before = get_spline_points(curve_object)
    # It follows what comes after the subdivision, too.
    add_armature(head)
    bpy.context.scene.frame_set(20)
    assert measure_distance_to_surface(curve_object, head) < 1e-5
    assert np.abs(get_spline_points(curve_object) - before).max() > 0.2
    known = curve_object.data.smooth_polyline
    assert (known.source, known.state) == ("EVALUATED", "CURRENT")
    # More levels rebuild the surface: the picks are found again by position, on the pose that they were made on.
    bpy.context.scene.frame_set(1)
    modifier.levels = 2
    bpy.context.view_layer.update()
    assert known.state == "FOUND_AGAIN", known.message
    assert measure_distance_to_surface(curve_object, head) < 1e-5
    known.source = "BASE"
    assert known.state == "FOUND_AGAIN", known.message
    modifier.show_viewport = False
    assert measure_distance_to_surface(curve_object, head) < 1e-5


def test_the_memory_holds_what_was_asked_for(head, session):
    curve_object = add_curve(session, head, filter="cubic", threshold=0.01, support=3, bevel=0.02, closed=True)
    known = curve_object.data.smooth_polyline
    assert (known.filter, known.pinned, known.support, known.closed) == ("CUBIC", "ALL", 3, True)
    assert known.threshold == pytest.approx(0.01)
    assert known.bevel == pytest.approx(0.02)
    assert known.surface == head
    assert [pick["face"] for pick in json.loads(known.stored)["picks"]] == SUZANNE_PICKS


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("filter", "GEODESIC"),
        ("closed", True),
        ("pinned", "ENDS"),
        ("detail_size", 0.5),
        ("offset", 0.1),
        ("resample", 0.1),
    ],
)
def test_a_changed_setting_makes_the_line_at_once_and_back_again(head, session, name, value):
    curve_object = add_curve(session, head)
    known = curve_object.data.smooth_polyline
    before, old = get_spline_points(curve_object), getattr(known, name)
    setattr(known, name, value)
    assert known.state == "CURRENT", known.message
    changed = get_spline_points(curve_object)
    assert not np.array_equal(changed, before)
    setattr(known, name, old)
    np.testing.assert_array_equal(get_spline_points(curve_object), before)


def test_resampled_points_are_evenly_spaced_and_on_the_surface(head, session):
    curve_object = add_curve(session, head, resample=0.05)
    points = get_spline_points(curve_object)
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    assert np.median(steps) == pytest.approx(0.05, rel=0.05)
    assert steps.max() < 0.0525  # chords of an even arc length: shorter at bends, never longer
    assert measure_distance_to_surface(curve_object, head) < 1e-6


def test_save_load_and_make_again_gives_equal_bytes(head, session, tmp_path):
    curve_object = add_curve(session, head)
    name, before = curve_object.name, get_spline_points(curve_object)
    path = str(tmp_path / "file.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.open_mainfile(filepath=path)
    curve_object = bpy.data.objects[name]
    np.testing.assert_array_equal(get_spline_points(curve_object), before)
    session.update_curve(bpy.context, curve_object.data)
    np.testing.assert_array_equal(get_spline_points(curve_object), before)
    assert curve_object.data.smooth_polyline.state == "CURRENT"


def test_appending_brings_the_mesh_along(head, session, tmp_path):
    name = add_curve(session, head).name
    path = str(tmp_path / "file.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    with bpy.data.libraries.load(path) as (_source, target):
        target.objects = [name]
    curve_object = target.objects[0]
    known = curve_object.data.smooth_polyline
    for appended in (known.surface, curve_object):
        bpy.context.scene.collection.objects.link(appended)
    before = get_spline_points(curve_object)
    session.update_curve(bpy.context, curve_object.data)
    np.testing.assert_array_equal(get_spline_points(curve_object), before)


def test_copies_and_renamed_objects_go_on(head, session):
    curve_object = add_curve(session, head)
    copy = curve_object.copy()
    copy.data = curve_object.data.copy()
    linked = curve_object.copy()
    for new in (copy, linked):
        bpy.context.scene.collection.objects.link(new)
    head.name = "Renamed"
    copy.data.smooth_polyline.filter = "LINEAR"
    assert not np.array_equal(get_spline_points(copy), get_spline_points(curve_object))
    np.testing.assert_array_equal(get_spline_points(linked), get_spline_points(curve_object))
    assert copy.data.smooth_polyline.state == "CURRENT"


def subdivide_upper_half(mesh_object):
    edited = bmesh.new()
    edited.from_mesh(mesh_object.data)
    edges = [e for e in edited.edges if e.verts[0].co.z > 0]
    bmesh.ops.subdivide_edges(edited, edges=edges, cuts=1, use_grid_fill=True)
    edited.to_mesh(mesh_object.data)
    edited.free()
    mesh_object.data.update()
    bpy.context.view_layer.update()


def test_picks_are_found_again_on_a_rebuilt_mesh(head, session):
    curve_object = add_curve(session, head)
    subdivide_upper_half(head)
    known = curve_object.data.smooth_polyline
    assert known.state == "FOUND_AGAIN"
    assert "found again" in known.message
    assert measure_distance_to_surface(curve_object, head) < 1e-6
    # From then on it is a line of the new mesh.
    session.update_curve(bpy.context, curve_object.data)
    assert known.state == "CURRENT"


def test_what_cannot_be_found_again_is_stale_and_as_it_was(scene, session):
    grid = add_grid(6, 6)
    curve_object = add_curve(session, grid, [0, 14, 35])
    before, stored = get_spline_points(curve_object), curve_object.data.smooth_polyline.stored
    edited = bmesh.new()
    edited.from_mesh(grid.data)
    bmesh.ops.delete(edited, geom=[f for f in edited.faces if f.calc_center_median().x > 3], context="FACES")
    edited.to_mesh(grid.data)
    edited.free()
    grid.data.update()
    bpy.context.view_layer.update()
    known = curve_object.data.smooth_polyline
    assert known.state == "STALE"
    assert "away from the mesh" in known.message
    assert known.stored == stored
    np.testing.assert_array_equal(get_spline_points(curve_object), before)


@pytest.mark.parametrize("is_by_operator", [False, True])
def test_a_deleted_mesh_leaves_a_plain_curve(head, session, is_by_operator):
    curve_object = add_curve(session, head)
    before = get_spline_points(curve_object)
    if is_by_operator:
        bpy.ops.object.select_all(action="DESELECT")
        head.select_set(True)
        bpy.ops.object.delete()
    else:
        bpy.data.objects.remove(head)
    bpy.context.scene.frame_set(5)
    np.testing.assert_array_equal(get_spline_points(curve_object), before)
    known = curve_object.data.smooth_polyline
    known.filter = "LINEAR"
    assert known.state == "STALE"
    assert "is gone" in known.message
    np.testing.assert_array_equal(get_spline_points(curve_object), before)
    bpy.context.view_layer.objects.active = curve_object
    with pytest.raises(RuntimeError, match="is gone"):
        bpy.ops.curve.smooth_polyline_update()


def test_undo_of_a_changed_setting(head, session):
    curve_object = add_curve(session, head)
    name, before = curve_object.name, get_spline_points(curve_object)
    bpy.ops.ed.undo_push(message="Line")
    curve_object.data.smooth_polyline.filter = "LINEAR"
    bpy.ops.ed.undo_push(message="Filter")
    after = get_spline_points(curve_object)
    bpy.ops.ed.undo()
    np.testing.assert_array_equal(get_spline_points(bpy.data.objects[name]), before)
    assert bpy.data.objects[name].data.smooth_polyline.filter == "FAIR"
    bpy.ops.ed.redo()
    np.testing.assert_array_equal(get_spline_points(bpy.data.objects[name]), after)


def test_the_operators_curve_remembers_too(suzanne):
    pick_faces(suzanne, SUZANNE_PICKS)
    bpy.ops.mesh.smooth_polyline_add(filter="FAIR", pinned="ALL")
    (curve_object,) = get_curves()
    before = get_spline_points(curve_object)
    curve_object.data.smooth_polyline.filter = "GEODESIC"
    assert curve_object.data.smooth_polyline.state == "CURRENT"
    bpy.ops.object.mode_set(mode="OBJECT")
    assert len(get_spline_points(curve_object)) != len(before)
    assert measure_distance_to_surface(curve_object, suzanne) < 1e-6


def test_a_plain_curve_is_left_alone(scene, extension):
    bpy.ops.curve.primitive_bezier_curve_add()
    assert not bpy.ops.curve.smooth_polyline_update.poll()
    bpy.context.object.data.smooth_polyline.filter = "CUBIC"
    assert bpy.context.object.data.smooth_polyline.state == "CURRENT"
    bpy.context.scene.frame_set(4)


def test_a_mesh_in_edit_mode_is_followed_when_the_edit_is_over(head, session):
    curve_object = add_curve(session, head)
    before = get_spline_points(curve_object)
    enter_edit_mode(head)
    edited = bmesh.from_edit_mesh(head.data)
    for vertex in edited.verts:
        vertex.co.z += 1.0
    bmesh.update_edit_mesh(head.data)
    bpy.ops.object.mode_set(mode="OBJECT")
    bpy.context.view_layer.update()
    np.testing.assert_allclose(get_spline_points(curve_object), before + np.array([0, 0, 1]), rtol=0, atol=1e-6)


def test_a_linked_curve_is_left_alone_and_says_why(head, session, tmp_path):
    name = add_curve(session, head).name
    path = str(tmp_path / "library.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    with bpy.data.libraries.load(path, link=True) as (_source, target):
        target.objects = [name]
    (linked,) = target.objects
    for brought in (linked, linked.data.smooth_polyline.surface):
        bpy.context.scene.collection.objects.link(brought)
    before = get_spline_points(linked)
    bpy.context.scene.frame_set(4)
    np.testing.assert_array_equal(get_spline_points(linked), before)
    assert linked.data.smooth_polyline.state == "CURRENT"
    bpy.context.view_layer.objects.active = linked
    for refused in (bpy.ops.curve.smooth_polyline_update, bpy.ops.object.smooth_polyline_change_output):
        with pytest.raises(RuntimeError, match=r"linked from .*library\.blend.*make it local"):
            refused()
    np.testing.assert_array_equal(get_spline_points(linked), before)


def test_linked_duplicates_share_their_line_through_undo(head, session):
    curve_object = add_curve(session, head)
    twin = curve_object.copy()
    bpy.context.scene.collection.objects.link(twin)
    names = curve_object.name, twin.name
    before = get_spline_points(curve_object)
    bpy.ops.ed.undo_push(message="Twins")
    twin.data.smooth_polyline.filter = "GEODESIC"
    bpy.ops.ed.undo_push(message="Filter")
    np.testing.assert_array_equal(get_spline_points(curve_object), get_spline_points(twin))
    assert not np.array_equal(get_spline_points(curve_object), before)
    bpy.ops.ed.undo()
    for name in names:
        np.testing.assert_array_equal(get_spline_points(bpy.data.objects[name]), before)
    assert bpy.data.objects[names[0]].data == bpy.data.objects[names[1]].data
