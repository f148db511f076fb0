"""Long lines stopped by Esc or left to end, Edit Picks from the Properties editor, and calls from a real timer."""

import importlib
import itertools
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

import numpy as np
from kit import bpy, get_window, in_view, play, press, shoot, tell, until_redrawn

import bmesh

SIDE = 400
LONG_WORK = {"filter": "LINEAR", "solver": "HEAP", "threshold": 1e-12, "max_iterations": 1_000_000}
PACKAGE = "bl_ext.user_default.smooth_polylines"


def add_wavy():
    """A large wavy plane in Edit Mode, its first and last face picked."""
    x, y = np.meshgrid(np.arange(SIDE), np.arange(SIDE))
    positions = np.stack([x, y, 0.3 * np.sin(x / 3) * np.cos(y / 4)], axis=-1).reshape(-1, 3)
    corner = (np.arange(SIDE - 1)[:, None] * SIDE + np.arange(SIDE - 1)).ravel()
    mesh = bpy.data.meshes.new("Wavy")
    mesh.from_pydata(
        positions.tolist(), [], np.stack([corner, corner + 1, corner + SIDE + 1, corner + SIDE], 1).tolist()
    )
    made = bpy.data.objects.new("Wavy", mesh)
    bpy.context.scene.collection.objects.link(made)
    bpy.context.view_layer.objects.active = made
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_mode(type="FACE")
    bpy.ops.mesh.select_all(action="DESELECT")
    edited = bmesh.from_edit_mesh(mesh)
    edited.faces.ensure_lookup_table()
    for face in (0, len(edited.faces) - 1):
        edited.faces[face].select_set(True)
        edited.select_history.add(edited.faces[face])
    edited.select_flush_mode()
    bmesh.update_edit_mesh(mesh)


def count():
    edited = bpy.context.view_layer.objects.active
    return [len(bpy.data.objects), len(bpy.data.curves), edited.data.total_face_sel, edited.mode]


def note_events():
    """The events that operators get from here on: kind, when it came, and when it had been dealt with."""
    events = []
    kind = importlib.import_module(f"{PACKAGE}.operators.interruptible").Interruptible
    modal = kind.modal

    def note(operator, context, event):
        came = time.monotonic()
        answer = modal(operator, context, event)
        events.append((event.type, came, time.monotonic()))
        return answer

    kind.modal = note
    return events


def list_modal():
    return [operator.bl_idname for operator in get_window().modal_operators]


def scenario():
    yield from until_redrawn()
    drawings = importlib.import_module(f"{PACKAGE}.draw_tool.drawing")
    with in_view():
        bpy.ops.object.select_all(action="SELECT")
        bpy.ops.object.delete()
        add_wavy()
        bpy.ops.view3d.view_all()
        bpy.ops.ed.undo_push(message="Wavy")
    yield from until_redrawn()
    before = count()
    events = note_events()

    for name in ("add", "seam", "net"):
        with in_view():
            answer = getattr(bpy.ops.mesh, f"smooth_polyline_{name}")("INVOKE_DEFAULT", True, **LONG_WORK)
        tell(**{f"{name}_begun": [sorted(answer), len(list_modal())]})
        yield 0.5
        if name == "add":
            yield from until_redrawn()
            shoot("at_work")
        yield 1.0  # nothing is left to be drawn
        pressed = time.monotonic()
        yield from press("ESC")
        yield lambda: not list_modal()
        *others, (last, _, ended) = events
        # A window that is drawn by software gives events at its own pace, whatever an operator does.
        pace = max(b[1] - a[2] for a, b in itertools.pairwise(others))
        tell(**{f"{name}_ended_by": last, f"{name}_unchanged": count() == before})
        tell(**{f"{name}_took": max(done - begun for _, begun, done in events), f"{name}_pace": pace})
        tell(**{f"{name}_after_esc": ended - pressed})
        events.clear()

    with in_view():
        bpy.ops.mesh.smooth_polyline_add("INVOKE_DEFAULT", True, filter="LINEAR", solver="HEAP", threshold=1e-3)
    yield lambda: not list_modal()
    yield 0.3
    tell(made=len(bpy.data.curves), last=bpy.context.window_manager.operators[-1].bl_idname)
    yield from press("Z", ctrl=True)
    yield 0.5
    tell(after_undo=len(bpy.data.curves))
    yield from press("Z", ctrl=True, shift=True)
    yield 0.5
    tell(after_redo=len(bpy.data.curves))

    # From the Properties editor, where the button of the panel stands.
    with in_view():
        bpy.ops.object.mode_set(mode="OBJECT")
    curve = next(o for o in bpy.data.objects if o.type == "CURVE")
    bpy.context.view_layer.objects.active = curve
    area = next(area for area in get_window().screen.areas if area.type == "PROPERTIES")
    region = next(region for region in area.regions if region.type == "WINDOW")
    with bpy.context.temp_override(window=get_window(), area=area, region=region):
        area.spaces.active.context = "DATA"
    yield from until_redrawn()
    yield 0.5
    with bpy.context.temp_override(window=get_window(), area=area, region=region):
        tell(panel=bpy.types.DATA_PT_smooth_polyline.poll(bpy.context))
        bpy.ops.view3d.smooth_polyline_edit_picks("INVOKE_DEFAULT", curve=curve.name)
    yield lambda: drawings.running and drawings.running[0].opening is None
    yield from until_redrawn()
    shoot("from_properties")
    tell(picks=len(drawings.running[0].sketch.state.picks), hidden=curve.hide_get())
    yield from press("ESC")
    yield lambda: not drawings.running
    tell(shown=not curve.hide_get())

    # A scenario runs in a timer: what is called here without more ado is called from one.
    tell(window_in_timer=bpy.context.window is not None)
    said = []
    for call in (bpy.ops.curve.smooth_polyline_update, bpy.ops.object.smooth_polyline_change_output):
        try:
            said.append(sorted(call()))
        except RuntimeError as error:
            said.append(str(error))
    tell(update_in_timer=said)
    bpy.context.view_layer.objects.active = bpy.data.objects["Wavy"]
    with in_view():
        bpy.ops.object.mode_set(mode="EDIT")
    said = []
    for name in ("add", "seam", "net"):
        try:
            said.append(sorted(getattr(bpy.ops.mesh, f"smooth_polyline_{name}")(filter="GEODESIC")))
        except RuntimeError as error:
            said.append(str(error))
        yield 0.1
    tell(made_in_timer=said)


play(scenario)
