"""The operator on Suzanne: what it makes is what the library makes from the same arrays, and lies on the mesh."""

from types import SimpleNamespace

import numpy as np
import pytest

import bpy

import smooth_polylines as sp
from blender_scenes import (
    SUZANNE_PICKS,
    get_curves,
    get_spline_points,
    measure_distances,
    pick_faces,
    read_mesh_slowly,
    select_faces_without_order,
)

# 32-bit coordinates of a mesh two units wide are rounded by 1e-7; the contract asks for 1e-5.
ON_MESH = 1e-5

REQUESTS = [
    {"filter": "NONE"},
    {"filter": "LINEAR"},
    {"filter": "LINEAR", "solver": "HEAP", "threshold": 1e-3},
    {"filter": "LINEAR", "closed": True, "pinned": "ALL"},
    {"filter": "CUBIC"},
    {"filter": "CUBIC", "pinned": "ALL", "threshold": 1e-2},
    {"filter": "CUBIC", "closed": True, "max_iterations": 3},
    {"filter": "CUBIC", "knots": "CHORDAL"},
    {"filter": "CUBIC", "support": 4},
]


def make_library_line(mesh, request):
    """The line straight from the library, for an object without a transform."""
    positions, triangles, faces = read_mesh_slowly(mesh)
    options = {k: v.lower() if isinstance(v, str) else v for k, v in request.items()}
    return sp.SurfaceMesh(positions, triangles, faces).polyline(SUZANNE_PICKS, **options)


@pytest.mark.parametrize("request_", REQUESTS, ids=lambda r: "-".join(str(v).lower() for v in r.values()))
def test_curve_is_the_librarys_line_and_lies_on_the_mesh(suzanne, request_):
    line = make_library_line(suzanne.data, request_)
    pick_faces(suzanne, SUZANNE_PICKS)
    assert bpy.ops.mesh.smooth_polyline_add(**request_) == {"FINISHED"}

    (curve_object,) = get_curves()
    points = get_spline_points(curve_object)
    np.testing.assert_array_equal(points, line.points.astype(np.float32))
    assert curve_object.data.splines[0].type == "POLY"
    assert curve_object.data.splines[0].use_cyclic_u == request_.get("closed", False)
    positions, triangles, _ = read_mesh_slowly(suzanne.data)
    assert measure_distances(points, positions, triangles).max() < ON_MESH


def test_curve_is_a_visible_child_in_the_same_space_and_collection(suzanne):
    collection = bpy.data.collections.new("Heads")
    bpy.context.scene.collection.children.link(collection)
    collection.objects.link(suzanne)
    bpy.context.scene.collection.objects.unlink(suzanne)
    pick_faces(suzanne, SUZANNE_PICKS)
    bpy.ops.mesh.smooth_polyline_add(name="Parting")

    (curve_object,) = get_curves()
    assert curve_object.name == "Parting"
    assert curve_object.parent == suzanne
    assert curve_object.matrix_local.is_identity
    assert curve_object.matrix_parent_inverse.is_identity
    assert list(curve_object.users_collection) == [collection]
    assert curve_object.data.bevel_depth > 0
    assert curve_object.visible_get()


def test_automatic_bevel_grows_with_the_mesh_and_a_given_one_is_kept(suzanne):
    pick_faces(suzanne, SUZANNE_PICKS)
    bpy.ops.mesh.smooth_polyline_add()
    diagonal = np.linalg.norm(np.ptp(read_mesh_slowly(suzanne.data)[0], axis=0))
    assert get_curves()[0].data.bevel_depth == pytest.approx(0.004 * diagonal)
    bpy.data.objects.remove(get_curves()[0])

    bpy.ops.mesh.smooth_polyline_add(bevel=0.125)
    assert get_curves()[0].data.bevel_depth == 0.125


def test_edit_mode_selection_and_order_stay(suzanne):
    pick_faces(suzanne, SUZANNE_PICKS)
    bpy.ops.mesh.smooth_polyline_add()
    assert bpy.context.mode == "EDIT_MESH"
    assert bpy.context.edit_object == suzanne
    first = get_spline_points(get_curves()[0])
    # The same picks are still there for a second line.
    bpy.ops.mesh.smooth_polyline_add()
    assert len(get_curves()) == 2
    np.testing.assert_array_equal(get_spline_points(get_curves()[1]), first)


def test_order_of_picking_counts_and_not_the_numbers_of_the_faces(suzanne):
    order = [SUZANNE_PICKS[i] for i in (2, 0, 3, 1)]
    pick_faces(suzanne, order)
    bpy.ops.mesh.smooth_polyline_add(filter="NONE", pinned="ALL")
    points = get_spline_points(get_curves()[0])
    positions, triangles, faces = read_mesh_slowly(suzanne.data)
    line = sp.SurfaceMesh(positions, triangles, faces).polyline(order, filter="none", pinned="all")
    np.testing.assert_array_equal(points, line.points.astype(np.float32))
    # Brow, ear, ear, brow: it starts on the right and ends on the left.
    assert points[0, 0] > 0 > points[-1, 0]


def test_automatic_iterations_and_left_over_values_of_other_filters_do_no_harm(suzanne):
    pick_faces(suzanne, SUZANNE_PICKS)
    bpy.ops.mesh.smooth_polyline_add(filter="LINEAR", detail_size=0.3, knots="CHORDAL", support=3, max_iterations=0)
    bpy.ops.mesh.smooth_polyline_add(filter="NONE", solver="HEAP", detail_size=0.3)
    assert len(get_curves()) == 2


@pytest.fixture
def two_meshes(suzanne):
    """Suzanne, the active one, and a cube beside her, both in Edit Mode with nothing selected."""
    bpy.ops.object.mode_set(mode="OBJECT")
    bpy.ops.mesh.primitive_cube_add(location=(5, 0, 0))
    cube = bpy.context.object
    suzanne.select_set(True)
    bpy.context.view_layer.objects.active = suzanne
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="DESELECT")
    return suzanne, cube


def test_each_mesh_in_edit_mode_with_picked_faces_gets_its_line(two_meshes):
    suzanne, cube = two_meshes
    with pytest.raises(RuntimeError, match="No faces are selected on Suzanne"):
        bpy.ops.mesh.smooth_polyline_add()
    pick_faces(cube, [0, 1])
    bpy.ops.mesh.smooth_polyline_add()
    assert [curve.parent for curve in get_curves()] == [cube]
    pick_faces(suzanne, SUZANNE_PICKS)
    bpy.ops.mesh.smooth_polyline_add()
    assert sorted(curve.parent.name for curve in get_curves()) == ["Cube", "Cube", "Suzanne"]
    for curve_object in get_curves():
        positions, triangles, _ = read_mesh_slowly(curve_object.parent.data)
        assert measure_distances(get_spline_points(curve_object), positions, triangles).max() < 1e-6


def test_what_one_of_several_meshes_refuses_leaves_nothing_and_names_it(two_meshes):
    suzanne, cube = two_meshes
    pick_faces(suzanne, SUZANNE_PICKS)
    select_faces_without_order(cube, [0, 1])
    with pytest.raises(RuntimeError, match="2 of the 2 selected faces have no order"):
        bpy.ops.mesh.smooth_polyline_add()
    pick_faces(cube, [0, 1])
    with pytest.raises(RuntimeError, match="Suzanne: .*at least 3|Cube: .*3 "):
        bpy.ops.mesh.smooth_polyline_add(closed=True)
    assert get_curves() == []


class RowRecorder:
    """Stands for a layout and its rows: remembers each property and whether it can be changed."""

    def __init__(self, drawn):
        self.drawn = drawn
        self.enabled = True

    def row(self):
        return RowRecorder(self.drawn)

    def separator(self):
        pass

    def prop(self, _operator, name):
        self.drawn[name] = self.enabled

    def prop_search(self, _operator, name, _where, _collection):
        self.drawn[name] = self.enabled


@pytest.mark.parametrize(
    ("filter_", "solver", "output", "greyed_out"),
    [
        ("LINEAR", "AUTO", "CURVE", {"detail_size", "knots", "support", "threshold"}),
        ("LINEAR", "HEAP", "CURVE", {"detail_size", "knots", "support"}),
        ("CUBIC", "AUTO", "CURVE", {"detail_size"}),
        ("CUBIC", "AUTO", "MESH", {"detail_size", "bevel"}),
        ("GEODESIC", "HEAP", "CURVE", {"detail_size", "knots", "support", "solver", "threshold"}),
        ("FAIR", "AUTO", "CURVE", {"knots", "support", "solver", "threshold"}),
        ("NONE", "AUTO", "CURVE", {"detail_size", "knots", "support", "solver", "threshold", "max_iterations"}),
    ],
)
def test_panel_shows_every_property_and_greys_out_what_is_not_used(extension, filter_, solver, output, greyed_out):
    drawn = {}
    operator_class = bpy.types.MESH_OT_smooth_polyline_add
    values = SimpleNamespace(layout=RowRecorder(drawn), filter=filter_, solver=solver, output=output)
    operator_class.draw(values, bpy.context)
    properties = set(bpy.ops.mesh.smooth_polyline_add.get_rna_type().properties.keys()) - {"rna_type"}
    assert set(drawn) == properties
    assert {name for name, enabled in drawn.items() if not enabled} == greyed_out
