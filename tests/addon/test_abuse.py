"""Every operator of the add-on in states that it was not made for: a message, never a traceback; nothing is changed.

The operators are found by asking Blender for the add-on's own classes, so a new one is covered without being named.
"""

import itertools

import numpy as np
import pytest

import bpy

import addon_utils
import bmesh

from abuse_kit import EXTENSION, abuse, find_operators
from blender_scenes import add_grid


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


def armature():
    bpy.ops.object.armature_add()


def lattice():
    bpy.ops.object.add(type="LATTICE")


def surface():
    bpy.ops.surface.primitive_nurbs_surface_torus_add()


def metaball():
    bpy.ops.object.metaball_add()


def grease_pencil():
    if bpy.app.version < (4, 3):
        bpy.ops.object.gpencil_add(type="STROKE")
    else:
        bpy.ops.object.grease_pencil_add(type="STROKE")


def hair_curves():
    made = bpy.data.objects.new("Hair", bpy.data.hair_curves.new("Hair"))
    bpy.context.scene.collection.objects.link(made)
    bpy.context.view_layer.objects.active = made
    made.select_set(True)


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


def in_an_excluded_collection():
    made = grid()
    collection = bpy.data.collections.new("Excluded")
    bpy.context.scene.collection.children.link(collection)
    collection.objects.link(made)
    bpy.context.scene.collection.objects.unlink(made)
    bpy.context.view_layer.layer_collection.children["Excluded"].exclude = True


def not_selected():
    bpy.context.view_layer.objects.active = grid()
    bpy.ops.object.select_all(action="DESELECT")


STATES = (
    no_object, empty_object, camera, plain_curve, text, armature, lattice, surface, metaball, grease_pencil,
    hair_curves,
    empty_mesh, vertices_alone, edges_alone, one_triangle, not_finite, hidden_mesh, in_an_excluded_collection,
    all_faces_hidden, flattened_by_scale, not_selected,
)  # fmt: skip
# Every mode of every kind of object, in all versions: an object is tried in those that it has.
MODES = (
    "OBJECT", "EDIT", "SCULPT", "VERTEX_PAINT", "WEIGHT_PAINT", "TEXTURE_PAINT", "POSE", "SCULPT_CURVES",
    "EDIT_GPENCIL", "SCULPT_GPENCIL", "PAINT_GPENCIL", "WEIGHT_GPENCIL", "VERTEX_GPENCIL",
    "SCULPT_GREASE_PENCIL", "PAINT_GREASE_PENCIL", "WEIGHT_GREASE_PENCIL", "VERTEX_GREASE_PENCIL",
)  # fmt: skip


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


def begin(state, mode):
    """A new file in that state and mode; False where the state has no such mode."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    state()
    return try_mode(mode)


@pytest.mark.parametrize("state", STATES, ids=lambda state: state.__name__)
def test_every_operator_in_every_mode_says_what_is_wrong(scene, state):
    modes = [mode for mode in MODES if begin(state, mode)]
    assert "OBJECT" in modes
    for (name, operator), mode in itertools.product(find_operators(), modes):
        for selection in ("none", "all", "vertices", "edges", "faces") if is_mesh_edit(mode) else ("none",):
            begin(state, mode)
            select_some(selection)
            abuse(f"{name} in {mode}, {state.__name__}, {selection}", operator)
            try_mode("OBJECT")


def is_mesh_edit(mode):
    active = bpy.context.view_layer.objects.active
    return mode == "EDIT" and active is not None and active.type == "MESH"


def test_disabled_and_enabled_twenty_times_all_is_there_once(extension):
    before = [name for name, _ in find_operators()]
    for _ in range(20):
        addon_utils.disable(EXTENSION, default_set=True)
        assert find_operators() == []
        assert addon_utils.enable(EXTENSION, default_set=True) is not None
    assert [name for name, _ in find_operators()] == before
    for name in ("depsgraph_update_post", "load_post", "frame_change_post", "save_pre", "save_post"):
        handlers = getattr(bpy.app.handlers, name)
        ours = [(h.__module__, h.__name__) for h in handlers if h.__module__.startswith(EXTENSION)]
        assert len(ours) == len(set(ours))
