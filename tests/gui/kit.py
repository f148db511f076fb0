"""Drives Blender's window from a script inside it: mouse and keys by simulated events, pictures of the display.

A scenario is a generator function that `play` runs. What it yields gives control back to Blender: a number waits so
many seconds, a function waits until it returns true, another generator is run to its end. An error ends Blender with
3, too long a scenario with 4.
"""

import json
import os
import struct
import sys
import time
import traceback
import zlib
from pathlib import Path

import numpy as np
from bpy_extras.view3d_utils import location_3d_to_region_2d

import bpy

FOLDER = Path(os.environ["SCENARIO_FOLDER"])
LONGEST_SCENARIO = 400.0  # seconds
LONGEST_CONDITION = 60.0
BETWEEN_EVENTS = 0.05
BETWEEN_MOVES = 0.02

bpy.context.preferences.view.show_splash = False
bpy.context.preferences.view.smooth_view = 0  # what is projected now is so at the next event
bpy.context.preferences.use_preferences_save = False

_told = {}
_mouse = [(640, 400)]
_redraws = [0]


def tell(**values):
    """Numbers and words for the test that runs the scenario."""
    _told.update(values)


def add_mesh(name):
    """A mesh object of the triangles that the test gave to the scenario."""
    arrays = np.load(FOLDER / "mesh.npz")
    positions, triangles = arrays["positions"].astype(np.float32), arrays["triangles"].astype(np.int32)
    mesh = bpy.data.meshes.new(name)
    mesh.vertices.add(len(positions))
    mesh.attributes["position"].data.foreach_set("vector", positions.ravel())
    mesh.loops.add(triangles.size)
    mesh.loops.foreach_set("vertex_index", triangles.ravel())
    mesh.polygons.add(len(triangles))
    mesh.polygons.foreach_set("loop_start", np.arange(0, triangles.size, 3, dtype=np.int32))
    mesh.update(calc_edges=True)
    mesh_object = bpy.data.objects.new(name, mesh)
    bpy.context.scene.collection.objects.link(mesh_object)
    return mesh_object


def get_window():
    return bpy.context.window_manager.windows[0]


def find_view():
    """The 3D view: its area and its main region."""
    area = next(area for area in get_window().screen.areas if area.type == "VIEW_3D")
    return area, next(region for region in area.regions if region.type == "WINDOW")


def in_view():
    """A context in which operators of the 3D view can be called."""
    area, region = find_view()
    return bpy.context.temp_override(window=get_window(), area=area, region=region)


def empty_scene():
    """Delete all objects; in Object Mode."""
    bpy.ops.object.select_all(action="SELECT")
    bpy.ops.object.delete()


def begin_drawing(message, *, view_selected=False):
    """See all from the front, or what is selected; an undo step of that name; the draw tool."""
    bpy.ops.view3d.view_axis(type="FRONT")
    if view_selected:
        bpy.ops.view3d.view_selected()
    else:
        bpy.ops.view3d.view_all()
    bpy.ops.ed.undo_push(message=message)
    bpy.ops.wm.tool_set_by_id(name="smooth_polylines.draw")


def project(place):
    """Pixels of the window for a place in world space."""
    area, region = find_view()
    x, y = location_3d_to_region_2d(region, area.spaces.active.region_3d, place)
    return round(region.x + x), round(region.y + y)


def send(kind, value, **modifiers):
    get_window().event_simulate(type=kind, value=value, x=_mouse[0][0], y=_mouse[0][1], **modifiers)


def move(place):
    _mouse[0] = place
    send("MOUSEMOVE", "NOTHING")


def click(place, **modifiers):
    move(place)
    yield BETWEEN_EVENTS
    send("LEFTMOUSE", "PRESS", **modifiers)
    yield BETWEEN_EVENTS
    send("LEFTMOUSE", "RELEASE", **modifiers)
    yield BETWEEN_EVENTS


def drag(start, end, steps=8, **modifiers):
    places = [tuple(round(a + (b - a) * k / steps) for a, b in zip(start, end, strict=True)) for k in range(steps + 1)]
    yield from draw(places, **modifiers)


def draw(places, **modifiers):
    """Press at the first place, move through the others, release."""
    move(places[0])
    yield BETWEEN_EVENTS
    send("LEFTMOUSE", "PRESS", **modifiers)
    yield BETWEEN_EVENTS
    for place in places[1:]:
        move(place)
        yield BETWEEN_MOVES
    send("LEFTMOUSE", "RELEASE", **modifiers)
    yield BETWEEN_EVENTS


def press(key, **modifiers):
    send(key, "PRESS", **modifiers)
    send(key, "RELEASE", **modifiers)
    yield 2 * BETWEEN_EVENTS


def until_redrawn(times=2):
    """Until the 3D view has been drawn again so often."""
    until = _redraws[0] + times

    def is_redrawn():
        find_view()[0].tag_redraw()
        return _redraws[0] >= until

    yield is_redrawn


def read_screen():
    """The display as (height, width, 3) bytes: an XWD file that the X server keeps up to date."""
    data = (FOLDER / "Xvfb_screen0").read_bytes()
    header = struct.unpack(">25I", data[:100])
    size, width, height, row, colors = header[0], header[4], header[5], header[12], header[19]
    pixels = np.frombuffer(data, np.uint8, height * row, size + 12 * colors).reshape(height, row)
    return pixels[:, : 4 * width].reshape(height, width, 4)[:, :, 2::-1]


def shoot(name, *, is_picture=False):
    """Keep a picture of the display, where it can be read; `is_picture`: for the docs, of the 3D view alone."""
    if not (FOLDER / "Xvfb_screen0").exists():
        return
    screen = read_screen()
    if is_picture:
        area = find_view()[0]
        top = len(screen) - area.y - area.height
        screen = screen[top : top + area.height, area.x : area.x + area.width]
    height, width = screen.shape[:2]
    rows = np.zeros((height, 1 + 3 * width), np.uint8)
    rows[:, 1:] = screen.reshape(height, -1)

    def chunk(kind, body):
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))

    header = chunk(b"IHDR", struct.pack(">2I5B", width, height, 8, 2, 0, 0, 0))
    body = chunk(b"IDAT", zlib.compress(rows.tobytes())) + chunk(b"IEND", b"")
    (FOLDER / f"{name}.png").write_bytes(b"\x89PNG\r\n\x1a\n" + header + body)


def leave(status):
    (FOLDER / "told.json").write_text(json.dumps(_told))
    sys.stdout.flush()
    # Without Blender's own way out, which asks whether to save and may crash in other add-ons.
    os._exit(status)


def play(scenario):
    """Run a scenario from the window's timer until it ends."""
    stack = [scenario()]
    waiting = [None, 0.0]
    end = time.monotonic() + LONGEST_SCENARIO

    def count_redraw():
        _redraws[0] += 1

    bpy.types.SpaceView3D.draw_handler_add(count_redraw, (), "WINDOW", "POST_PIXEL")

    def go_on():
        if time.monotonic() > end:
            print("the scenario took too long")
            shoot("too_long")
            leave(4)
        condition, until = waiting
        if condition is not None:
            if not condition():
                if time.monotonic() > until:
                    raise TimeoutError(f"waited in vain for {condition}")
                return BETWEEN_EVENTS
            waiting[0] = None
        while True:
            try:
                value = next(stack[-1])
            except StopIteration:
                stack.pop()
                if not stack:
                    leave(0)
                continue
            if hasattr(value, "__next__"):
                stack.append(value)
            elif callable(value):
                waiting[:] = value, time.monotonic() + LONGEST_CONDITION
                return BETWEEN_EVENTS
            else:
                return float(value)

    def tick():
        try:
            return go_on()
        except BaseException:
            traceback.print_exc()
            shoot("failure")
            leave(3)

    # Persistent: a scenario may open a file.
    bpy.app.timers.register(tick, first_interval=0.5, persistent=True)
