"""Draws on a million triangles and drags a pick: how long the first line and each further one take inside the tool."""

import importlib
import statistics
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

from kit import bpy, click, drag, in_view, play, press, project, shoot, tell, until_redrawn

PLACES = [(-0.5, -0.8, 0.5), (0.0, -0.7, 0.6), (0.5, -0.8, 0.5), (0.0, -0.8, 0.0)]


def scenario():
    yield from until_redrawn()
    drawings = importlib.import_module("bl_ext.user_default.smooth_polylines.draw_tool.drawing")
    with in_view():
        bpy.ops.object.select_all(action="SELECT")
        bpy.ops.object.delete()
        bpy.ops.mesh.primitive_monkey_add()
        bpy.context.object.modifiers.new("Subdivision", "SUBSURF").levels = 5
        bpy.ops.object.modifier_apply(modifier="Subdivision")
        bpy.ops.view3d.view_axis(type="FRONT")
        bpy.ops.view3d.view_all()
        bpy.ops.wm.tool_set_by_id(name="smooth_polylines.draw")
    mesh = bpy.context.object.data
    mesh.calc_loop_triangles()
    tell(triangles=len(mesh.loop_triangles))
    yield from until_redrawn()

    start = time.perf_counter()
    yield from click(project(PLACES[0]))
    tell(first_click_seconds=time.perf_counter() - start)
    for place in PLACES[1:]:
        yield from click(project(place))
    drawing = drawings.running[0]
    before = len(drawing.update_milliseconds)
    middle = project(drawing.sketch.state.picks[1].place)
    yield from drag(middle, (middle[0] + 40, middle[1] - 40), steps=40)
    updates = drawing.update_milliseconds[before:]
    tell(picks=len(drawing.sketch.state.picks), points=len(drawing.points), updates=len(updates))
    tell(dragged_milliseconds=statistics.median(updates), message=drawing.message)
    yield from until_redrawn()
    shoot("line")
    yield from press("ESC")
    yield 0.2
    tell(objects=len(bpy.data.objects))


play(scenario)
