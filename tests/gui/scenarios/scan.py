"""Draws on a scan of a million triangles: how long opening, the first line and each dragged step take inside the tool.

A stroke; Esc while it is being opened; a mesh that changes under the drawing.
"""

import importlib
import statistics
import sys
import threading
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

import numpy as np
from kit import (
    add_mesh,
    begin_drawing,
    bpy,
    click,
    drag,
    draw,
    empty_scene,
    get_window,
    in_view,
    move,
    play,
    press,
    project,
    shoot,
    tell,
    until_redrawn,
)

EXTENSION = "bl_ext.user_default.smooth_polylines"


def measure_off_surface(points, drawing):
    return float(drawing.opened.library_mesh.closest_points(np.asarray(points, dtype=np.float64)).distances.max())


def scenario():
    yield from until_redrawn()
    drawings = importlib.import_module(f"{EXTENSION}.draw_tool.drawing")
    surface = importlib.import_module(f"{EXTENSION}.surface")
    with in_view():
        empty_scene()
        scan = add_mesh("Scan")
        begin_drawing("Scan")
    matrix, corners = np.array(scan.matrix_world), np.array(scan.bound_box)
    low, high = corners.min(axis=0), corners.max(axis=0)

    def at(x, z):
        """Pixels of a place of the scan's box, seen from the front, by parts of its width and height."""
        return project((low[0] + x * (high[0] - low[0]), low[1], low[2] + z * (high[2] - low[2])))

    tell(triangles=len(scan.data.polygons), matrix_is_identity=bool((matrix == np.eye(4)).all()))
    yield from until_redrawn()

    # Esc while it is being opened, which here takes long.
    make_ready, gate = surface.make_ready, threading.Event()

    def make_ready_slowly(reading, with_tree=False):
        gate.wait(60.0)
        return make_ready(reading, with_tree)

    surface.make_ready = make_ready_slowly
    yield from click(at(0.5, 0.6))
    yield 0.5
    (drawing,) = drawings.running
    tell(is_opening=drawing.opening is not None, told_while_opening=drawing.opening.describe())
    shoot("opening")
    start = time.perf_counter()
    yield from press("ESC")
    yield lambda: not drawings.running
    tell(esc_seconds=time.perf_counter() - start, modal_after_esc=len(get_window().modal_operators))
    surface.make_ready = make_ready
    gate.set()
    yield 1.0
    surface.forget_surfaces()

    yield from click(at(0.4, 0.6))
    yield lambda: bool(drawings.running) and drawings.running[0].opened is not None
    (drawing,) = drawings.running
    tell(picks_after_opening=len(drawing.sketch.state.picks))
    yield from click(at(0.6, 0.65))
    tell(opening_milliseconds=drawing.opening_milliseconds, first_line_milliseconds=drawing.update_milliseconds[-1])
    yield from click(at(0.55, 0.4))
    yield from click(at(0.45, 0.3))
    for filter_ in ("fair", "geodesic", "linear", "cubic"):
        before = len(drawing.update_milliseconds)
        middle = project(drawing.sketch.state.picks[1].place)
        yield from drag(middle, (middle[0] + 24, middle[1] - 24), steps=24)
        updates = drawing.update_milliseconds[before:]
        tell(**{f"{filter_}_updates": len(updates), f"{filter_}_milliseconds": statistics.median(updates)})
        tell(**{f"{filter_}_message": drawing.message, f"{filter_}_points": len(drawing.points)})
        yield from press("Z", ctrl=True)
        yield from press("T")
    tell(off_surface=measure_off_surface(drawing.points, drawing), scale=float(np.linalg.norm(high - low)))
    yield from until_redrawn()
    shoot("line")

    # A stroke in front, to the other side of the line's end.
    picks_before = len(drawing.sketch.state.picks)
    stroke = [at(0.4 + 0.25 * t, 0.25 + 0.06 * np.sin(6 * t)) for t in np.linspace(0, 1, 40)]
    yield from draw(stroke)
    tell(stroke_picks=len(drawing.sketch.state.picks) - picks_before, stroke_message=drawing.message)
    tell(stroke_milliseconds=drawing.update_milliseconds[-1])
    yield from until_redrawn()
    shoot("stroke")
    seen = np.array([project(p) for p in drawing.points])
    away = [np.linalg.norm(seen - np.array(place), axis=1).min() for place in stroke[1:]]
    tell(stroke_pixels_off=float(max(away)))

    # The mesh moves under the drawing, and then a vertex of it is edited.
    place = np.array(drawing.sketch.state.picks[0].place)
    scan.location.x += 0.25 * float(high[0] - low[0])
    yield from until_redrawn()
    move(at(0.1, 0.1))
    yield 0.3
    moved = np.array(drawing.sketch.state.picks[0].place) - place
    tell(moved_with_object=float(moved[0] / (high[0] - low[0])), moved_aside=float(np.abs(moved[1:]).max()))
    scan.location.x = 0.0
    scan.data.vertices[0].co.x += 1e-3
    scan.data.update()
    before = drawing.opened
    yield from until_redrawn()
    move(at(0.12, 0.12))
    yield 0.3
    tell(edit_is_noticed=drawing.opened is not before)

    yield from press("RET")
    yield lambda: not drawings.running
    (curve,) = [o for o in bpy.data.objects if o.type == "CURVE"]
    values = np.empty(4 * len(curve.data.splines[0].points), dtype=np.float32)
    curve.data.splines[0].points.foreach_get("co", values)
    opened = surface.open_surface(bpy.context, scan)
    off = opened.library_mesh.closest_points(values.reshape(-1, 4)[:, :3].astype(np.float64)).distances.max()
    tell(kept_off_surface=float(off), kept_state=curve.data.smooth_polyline.state)
    yield from until_redrawn()
    shoot("kept")
    move(at(0.1, 0.1))
    yield from press("Z", ctrl=True)
    yield 1.0
    tell(curves_after_undo=len([o for o in bpy.data.objects if o.type == "CURVE"]))


play(scenario)
