"""What a line becomes: curve, mesh edges or hair Curves, its name, collection and material; all of them stay alive."""

import numpy as np
import pytest

import bpy

from blender_scenes import SUZANNE_PICKS, count_data, measure_distances, pick_faces

HAS_HAIR = "set_types" in bpy.types.Curves.bl_rna.functions
ONLY_WITH_HAIR = pytest.mark.skipif(not HAS_HAIR, reason="from Blender 4.5 on")
OUTPUTS = ["CURVE", "MESH", pytest.param("CURVES", marks=ONLY_WITH_HAIR)]


@pytest.fixture
def session(extension):
    from bl_ext.user_default.smooth_polylines import session

    return session


@pytest.fixture
def head(suzanne):
    bpy.ops.object.mode_set(mode="OBJECT")
    return suzanne


def read_points(line_object):
    """By plain Python loops, each kind in its own way: the oracle of what is written in bulk."""
    data = line_object.data
    if line_object.type == "CURVE":
        (spline,) = data.splines
        return np.array([point.co[:3] for point in spline.points]), spline.use_cyclic_u
    if line_object.type == "MESH":
        count = len(data.vertices)
        edges = {tuple(edge.vertices) for edge in data.edges}
        is_closed = (count - 1, 0) in edges
        assert edges == {(k, (k + 1) % count) for k in range(count if is_closed else count - 1)}
        assert len(data.polygons) == 0
        return np.array([vertex.co[:] for vertex in data.vertices]), is_closed
    (curve,) = data.curves
    assert data.attributes["curve_type"].data[0].value == 1  # straight pieces
    cyclic = bool(data.attributes["cyclic"].data[0].value)
    return np.array([point.position[:] for point in curve.points]), cyclic


def measure_off_surface(line_object, mesh_object):
    bpy.context.view_layer.update()
    evaluated = mesh_object.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    evaluated.calc_loop_triangles()
    positions = np.array([v.co for v in evaluated.vertices], dtype=np.float64)
    triangles = np.array([t.vertices for t in evaluated.loop_triangles])
    return measure_distances(read_points(line_object)[0], positions, triangles).max()


def add_line(session, head, **options):
    options = {"filter": "fair", "pinned": "all", **options}
    return session.add_polyline(bpy.context, head, SUZANNE_PICKS, **options).curve_object


@pytest.mark.parametrize("closed", [False, True])
@pytest.mark.parametrize("output", OUTPUTS)
def test_all_kinds_hold_the_same_line(head, session, output, closed):
    expected, _ = read_points(add_line(session, head, closed=closed))
    line_object = add_line(session, head, output=output, closed=closed, bevel=0.03)
    points, is_closed = read_points(line_object)
    assert line_object.type == output
    assert line_object.parent == head
    np.testing.assert_array_equal(points, expected)
    assert is_closed == closed
    if output == "CURVE":
        assert line_object.data.bevel_depth == pytest.approx(0.03)
    if output == "CURVES":
        assert {round(point.radius, 6) for point in line_object.data.points} == {0.03}


@pytest.mark.parametrize("output", OUTPUTS)
def test_all_kinds_follow_the_mesh_and_their_settings(head, session, output, tmp_path):
    line_object = add_line(session, head, output=output)
    before, _ = read_points(line_object)
    head.shape_key_add(name="Basis")
    key = head.shape_key_add(name="Wide")
    for point in key.data:
        point.co.x *= 1.5
    key.value = 1.0
    bpy.context.view_layer.update()
    np.testing.assert_allclose(read_points(line_object)[0], before * [1.5, 1, 1], rtol=0, atol=1e-6)
    key.value = 0.0
    bpy.context.view_layer.update()
    known = line_object.data.smooth_polyline
    for name, value in (("closed", True), ("filter", "GEODESIC"), ("resample", 0.05), ("bevel", 0.05)):
        setattr(known, name, value)
        assert known.state == "CURRENT", known.message
        assert measure_off_surface(line_object, head) < 1e-6
    points, is_closed = read_points(line_object)
    assert is_closed
    assert len(points) != len(before)
    # Saved, loaded, made again: the same bytes.
    name, path = line_object.name, str(tmp_path / "file.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.open_mainfile(filepath=path)
    again = bpy.data.objects[name]
    np.testing.assert_array_equal(read_points(again)[0], points)
    session.update_curve(bpy.context, again.data)
    np.testing.assert_array_equal(read_points(again)[0], points)


@pytest.mark.parametrize("output", OUTPUTS)
def test_all_kinds_find_their_picks_again_on_a_rebuilt_mesh_and_outlive_it(head, session, output):
    line_object = add_line(session, head, output=output)
    known = line_object.data.smooth_polyline
    modifier = head.modifiers.new("Subdivision", "SUBSURF")
    modifier.subdivision_type = "SIMPLE"
    bpy.context.view_layer.objects.active = head
    bpy.ops.object.modifier_apply(modifier=modifier.name)
    bpy.context.view_layer.update()
    assert known.state == "FOUND_AGAIN", known.message
    assert measure_off_surface(line_object, head) < 1e-6
    before, _ = read_points(line_object)
    bpy.data.objects.remove(head)
    bpy.context.scene.frame_set(3)
    known.filter = "LINEAR"
    assert known.state == "STALE"
    np.testing.assert_array_equal(read_points(line_object)[0], before)


@pytest.mark.parametrize("output", OUTPUTS)
def test_a_line_that_is_being_edited_is_left_alone(head, session, output):
    line_object = add_line(session, head, output=output)
    bpy.context.view_layer.objects.active = line_object
    bpy.ops.object.mode_set(mode="EDIT")
    for vertex in head.data.vertices:
        vertex.co.z += 0.5
    head.data.update()
    bpy.context.view_layer.update()
    bpy.ops.object.mode_set(mode="OBJECT")
    bpy.context.view_layer.update()
    bpy.context.scene.frame_set(2)
    assert measure_off_surface(line_object, head) < 1e-6


@pytest.mark.parametrize("output", OUTPUTS)
def test_the_output_can_be_changed_later_and_nothing_is_lost(head, session, output):
    material = bpy.data.materials.new("Red")
    collection = bpy.data.collections.new("Lines")
    bpy.context.scene.collection.children.link(collection)
    start = "MESH" if output == "CURVE" else "CURVE"
    line_object = add_line(session, head, output=start, name="Parting", collection="Lines", material="Red", closed=True)
    before, _ = read_points(line_object)
    stored = line_object.data.smooth_polyline.stored
    counts = count_data()
    bpy.ops.object.select_all(action="DESELECT")
    line_object.select_set(True)
    bpy.context.view_layer.objects.active = line_object
    bpy.ops.object.smooth_polyline_change_output(output=output)
    line_object = bpy.context.object
    assert (line_object.type, line_object.name, line_object.parent) == (output, "Parting", head)
    assert line_object.select_get()
    assert [c.name for c in line_object.users_collection] == ["Lines"]
    assert list(line_object.data.materials) == [material]
    assert read_points(line_object)[1]
    np.testing.assert_array_equal(read_points(line_object)[0], before)
    known = line_object.data.smooth_polyline
    assert (known.stored, known.filter, known.surface) == (stored, "FAIR", head)
    known.filter = "GEODESIC"
    assert known.state == "CURRENT", known.message
    assert measure_off_surface(line_object, head) < 1e-6
    assert counts["objects"] == len(bpy.data.objects)
    bpy.ops.object.smooth_polyline_change_output(output=start)
    assert {name: count for name, count in count_data().items() if count != counts[name]} == {}


def test_name_collection_and_material_as_settings(suzanne):
    bpy.data.materials.new("Red")
    collection = bpy.data.collections.new("Lines")
    bpy.context.scene.collection.children.link(collection)
    pick_faces(suzanne, SUZANNE_PICKS)
    bpy.ops.mesh.smooth_polyline_add(name="Parting", collection="Lines", material="Red", output="MESH")
    line_object = bpy.data.objects["Parting"]
    assert list(collection.objects) == [line_object]
    assert line_object.data.materials[0].name == "Red"
    # The same in its panel, which shows what is there, whoever put it there.
    assert (line_object.smooth_polyline_collection, line_object.smooth_polyline_material) == ("Lines", "Red")
    other = bpy.data.collections.new("Other")
    bpy.context.scene.collection.children.link(other)
    line_object.smooth_polyline_collection = "Other"
    assert [c.name for c in line_object.users_collection] == ["Other"]
    line_object.smooth_polyline_collection = "nowhere"
    assert [c.name for c in line_object.users_collection] == ["Other"]
    line_object.smooth_polyline_material = ""
    assert len(line_object.data.materials) == 0
    assert line_object.smooth_polyline_material == ""


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"collection": "nowhere"}, "no collection 'nowhere'"),
        ({"material": "none such"}, "no material 'none such'"),
    ],
)
def test_what_is_not_there_is_refused_and_nothing_made(suzanne, options, message):
    pick_faces(suzanne, SUZANNE_PICKS)
    before = count_data()
    with pytest.raises(RuntimeError, match=message):
        bpy.ops.mesh.smooth_polyline_add(**options)
    assert count_data() == before


@pytest.mark.skipif(HAS_HAIR, reason="this Blender has hair Curves")
def test_hair_curves_are_refused_where_there_are_none(suzanne):
    pick_faces(suzanne, SUZANNE_PICKS)
    before = count_data()
    with pytest.raises(RuntimeError, match=r"came with 4\.5"):
        bpy.ops.mesh.smooth_polyline_add(output="CURVES")
    assert count_data() == before


def test_looking_for_lines_gives_no_mesh_a_memory(head, session):
    add_line(session, head)
    bpy.context.scene.frame_set(2)
    bpy.context.view_layer.objects.active = head
    assert not bpy.ops.curve.smooth_polyline_update.poll()
    assert not head.data.is_property_set("smooth_polyline")
