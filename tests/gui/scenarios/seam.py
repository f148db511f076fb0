"""Put Lines into Mesh as an artist does it: pick faces by clicks, F3, the panel of the last operation, the sidebar."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

from kit import bpy, click, empty_scene, find_view, in_view, play, press, project, send, shoot, tell, until_redrawn

import bmesh

# On the forehead and the cheeks, from the front.
PLACES = [(-0.45, -0.8, 0.62), (0.0, -0.7, 0.62), (0.45, -0.8, 0.62)]


def look(name):
    """What the edited mesh is like now."""
    edited = bmesh.from_edit_mesh(bpy.context.edit_object.data)
    seams = [edge for edge in edited.edges if edge.seam]
    tell(**{f"{name}_vertices": len(edited.verts), f"{name}_seams": len(seams)})
    tell(**{f"{name}_places": round(sum(sum(map(abs, vertex.co)) for vertex in edited.verts), 3)})


def type_text(text):
    for letter in text:
        get = {" ": "SPACE"}.get(letter, letter.upper())
        send(get, "PRESS", unicode=letter)
        send(get, "RELEASE")
        yield 0.05


def scenario():
    yield from until_redrawn()
    with in_view():
        empty_scene()
        bpy.ops.mesh.primitive_monkey_add()
        bpy.ops.object.mode_set(mode="EDIT")
        bpy.ops.mesh.select_mode(type="FACE")
        bpy.ops.mesh.select_all(action="DESELECT")
        bpy.ops.view3d.view_axis(type="FRONT")
        bpy.ops.view3d.view_all()
        area, _ = find_view()
        area.spaces.active.show_region_ui = True
        bpy.ops.ed.undo_push(message="Start")
    yield from until_redrawn()
    for number, place in enumerate(PLACES):
        yield from click(project(place), **({"shift": True} if number else {}))
    yield from until_redrawn()
    tell(picked=bpy.context.edit_object.data.total_face_sel)
    look("before")

    # Found by its name, as in the search of all operators.
    yield from press("F3")
    yield 0.5
    yield from type_text("put lines into mesh")
    yield 0.5
    yield from press("RET")
    yield (
        lambda: (
            bpy.context.window_manager.operators[-1:] and "seam" in bpy.context.window_manager.operators[-1].bl_idname
        )
    )
    yield from until_redrawn()
    look("cut")
    shoot("seam_cut")

    # The panel of the last operation does this when a setting is changed.
    for method in ("SNAP", "SLIDE", "CUT"):
        with in_view():
            bpy.context.window_manager.operators[-1].method = method
            bpy.ops.ed.undo_redo("EXEC_DEFAULT", True)
        yield from until_redrawn()
        look(f"redo_{method.lower()}")
    with in_view():
        bpy.context.window_manager.operators[-1].unwrap = True
        bpy.ops.ed.undo_redo("EXEC_DEFAULT", True)
    yield from until_redrawn()
    tell(told=bpy.context.window_manager.operators[-1].told)
    shoot("seam_unwrapped")
    yield from press("F9")
    yield 0.5
    shoot("seam_panel")
    yield from press("ESC")
    yield from until_redrawn()

    yield from press("Z", ctrl=True)
    yield from until_redrawn()
    look("undone")
    tell(picked_after_undo=bpy.context.edit_object.data.total_face_sel)
    yield from press("Z", ctrl=True, shift=True)
    yield from until_redrawn()
    look("redone")


play(scenario)
