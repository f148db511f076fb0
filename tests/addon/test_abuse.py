"""Every operator of the add-on in states that it was not made for: a message, never a traceback; nothing is changed.

The operators are found by asking Blender for the add-on's own classes, so a new one is covered without being named.
"""

import itertools

import numpy as np
import pytest

import bpy

import addon_utils
import bmesh

from blender_scenes import add_grid, count_data

EXTENSION = "bl_ext.user_default.smooth_polylines"


def find_operators():
    """(idname, callable) of all operators that the add-on has registered."""
    found = []
    for name in dir(bpy.types):
        class_ = getattr(bpy.types, name)
        if (
            isinstance(class_, type)
            and issubclass(class_, bpy.types.Operator)
            and class_.__module__.startswith(EXTENSION)
        ):
            module, operator = class_.bl_idname.split(".")
            found.append((class_.bl_idname, getattr(getattr(bpy.ops, module), operator)))
    return sorted(found, key=lambda pair: pair[0])


def no_object():
    pass


def empty_object():
    bpy.ops.object.empty_add()


def camera():
    bpy.ops.object.camera_add()


def plain_curve():
    bpy.ops.curve.primitive_bezier_curve_add()


def text():
    bpy.ops.object.text_add()


def add_mesh(positions, edges, faces):
    mesh = bpy.data.meshes.new("Abused")
    mesh.from_pydata(positions, edges, faces)
    made = bpy.data.objects.new("Abused", mesh)
    bpy.context.scene.collection.objects.link(made)
    bpy.context.view_layer.objects.active = made
    made.select_set(True)
    return made


def grid():
    made = add_grid(4, 4)
    bpy.context.view_layer.objects.active = made
    made.select_set(True)
    return made


def empty_mesh():
    add_mesh([], [], [])


def vertices_alone():
    add_mesh(np.eye(3).tolist(), [], [])


def edges_alone():
    add_mesh(np.eye(3).tolist(), [(0, 1), (1, 2)], [])


def one_triangle():
    add_mesh(np.eye(3).tolist(), [], [(0, 1, 2)])


def not_finite():
    add_mesh([[0, 0, 0], [1, 0, float("nan")], [0, 1, 0]], [], [(0, 1, 2)])


def hidden_mesh():
    grid().hide_set(True)


def all_faces_hidden():
    made = grid()
    made.data.polygons.foreach_set("hide", np.ones(len(made.data.polygons), bool))


def flattened_by_scale():
    grid().scale = (0, 1, 1)


def not_selected():
    bpy.context.view_layer.objects.active = grid()
    bpy.ops.object.select_all(action="DESELECT")


STATES = (
    no_object, empty_object, camera, plain_curve, text, empty_mesh, vertices_alone, edges_alone, one_triangle, not_finite,  # noqa: E501
    hidden_mesh, all_faces_hidden, flattened_by_scale, not_selected,
)  # fmt: skip
MODES = ("OBJECT", "EDIT", "SCULPT", "VERTEX_PAINT", "WEIGHT_PAINT", "TEXTURE_PAINT")


def try_mode(mode):
    """Into the mode, if the active object has it; whether it is there now."""
    active = bpy.context.view_layer.objects.active
    if active is None:
        return mode == "OBJECT"
    if active.mode != mode:
        try:
            bpy.ops.object.mode_set(mode=mode)
        except (RuntimeError, TypeError):
            return False
    return True


def abuse(name, operator, *arguments, **properties):
    """Call it; what it says must be for people. Returns whether it did something."""
    before = count_data()
    try:
        result = operator(*arguments, **properties)
    except RuntimeError as error:
        message = str(error)
        assert "Traceback" not in message, f"{name}: {message}"
        assert len(message) > 20, f"{name}: {message}"
        assert count_data() == before, f"{name} left something behind: {message}"
        return False
    if result == {"CANCELLED"}:
        assert count_data() == before, f"{name} was cancelled and left something behind"
    return result == {"FINISHED"}


def select_some(kind):
    """A selection of a kind in Edit Mode: nothing, all, vertices, edges, faces without order."""
    active = bpy.context.view_layer.objects.active
    if active is None or active.type != "MESH" or active.mode != "EDIT":
        return
    bpy.ops.mesh.select_mode(type={"vertices": "VERT", "edges": "EDGE"}.get(kind, "FACE"))
    bpy.ops.mesh.select_all(action="SELECT" if kind == "all" else "DESELECT")
    edited = bmesh.from_edit_mesh(active.data)
    elements = {"vertices": edited.verts, "edges": edited.edges, "faces": edited.faces}.get(kind, ())
    for element in list(elements)[:3]:
        element.select_set(True)
    bmesh.update_edit_mesh(active.data)


def test_the_operators_are_found(extension):
    names = [name for name, _ in find_operators()]
    assert "mesh.smooth_polyline_add" in names
    assert len(names) >= 4


@pytest.mark.parametrize("state", STATES, ids=lambda state: state.__name__)
def test_every_operator_in_every_mode_says_what_is_wrong(scene, state):
    for (name, operator), mode in itertools.product(find_operators(), MODES):
        for selection in ("none", "all", "vertices", "edges", "faces") if mode == "EDIT" else ("none",):
            bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
            state()
            if not try_mode(mode):
                continue
            select_some(selection)
            abuse(f"{name} in {mode}, {state.__name__}, {selection}", operator)
            try_mode("OBJECT")


def test_disabled_and_enabled_twenty_times_all_is_there_once(extension):
    before = [name for name, _ in find_operators()]
    for _ in range(20):
        addon_utils.disable(EXTENSION, default_set=True)
        assert find_operators() == []
        assert addon_utils.enable(EXTENSION, default_set=True) is not None
    assert [name for name, _ in find_operators()] == before
    for name in ("depsgraph_update_post", "load_post", "frame_change_post"):
        handlers = getattr(bpy.app.handlers, name)
        ours = [(h.__module__, h.__name__) for h in handlers if h.__module__.startswith(EXTENSION)]
        assert len(ours) == len(set(ours))
