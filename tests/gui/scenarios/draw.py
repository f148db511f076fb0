"""Draws on Suzanne with mouse and keys, from the first click to Enter, edits the curve again, and leaves by Esc."""

import importlib
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

from kit import (
    begin_drawing,
    bpy,
    click,
    drag,
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

PLACES = [(-0.5, -0.8, 0.5), (0.0, -0.7, 0.6), (0.5, -0.8, 0.5)]


def count_data():
    return [len(bpy.data.objects), len(bpy.data.curves), len(bpy.data.meshes)]


def get_curves():
    return [o for o in bpy.data.objects if o.type == "CURVE"]


def scenario():
    yield from until_redrawn()
    drawings = importlib.import_module("bl_ext.user_default.smooth_polylines.draw_tool.drawing")

    def get_drawing():
        return drawings.running[0]

    with in_view():
        empty_scene()
        bpy.ops.mesh.primitive_monkey_add()
        begin_drawing("Suzanne")
    yield from until_redrawn()
    before = count_data()

    for place in PLACES:
        yield from click(project(place))
    drawing = get_drawing()
    tell(clicked=len(drawing.sketch.state.picks), shown=len(drawing.points), message=drawing.message)
    tell(data_while_drawing=count_data() == before)
    yield from until_redrawn()
    shoot("line")

    start = project(drawing.sketch.state.picks[1].place)
    old = drawing.points.copy()
    yield from drag(start, (start[0] + 30, start[1] - 60))
    tell(dragged_by=abs(project(drawing.sketch.state.picks[1].place)[1] - start[1] + 60))
    tell(line_moved=bool(old.shape != drawing.points.shape or (old != drawing.points).any()))
    yield from until_redrawn()
    shoot("dragged")
    yield from press("Z", ctrl=True)
    tell(undone_drag=project(drawing.sketch.state.picks[1].place) == start)
    yield from press("Z", ctrl=True)
    tell(undone_click=len(drawing.sketch.state.picks))
    yield from press("Z", ctrl=True, shift=True)
    tell(redone_click=len(drawing.sketch.state.picks))

    yield from click(project(drawing.points[len(drawing.points) // 4]), ctrl=True)
    tell(inserted=len(drawing.sketch.state.picks))
    yield from press("X")
    yield from press("C")
    tell(removed=len(drawing.sketch.state.picks), closed=drawing.sketch.state.is_closed)
    yield from until_redrawn()
    shoot("closed")
    yield from press("C")
    yield from press("T")
    yield from press("RET")
    yield lambda: not drawings.running
    (curve,) = get_curves()
    tell(kept_filter=curve.data.smooth_polyline.filter, kept_points=len(curve.data.splines[0].points))
    yield from until_redrawn()
    shoot("kept")

    with in_view():
        bpy.ops.view3d.smooth_polyline_draw("INVOKE_DEFAULT", curve=curve.name)
    yield 0.2
    tell(edited=len(get_drawing().sketch.state.picks))
    yield from press("T")
    yield from press("RET")
    yield lambda: not drawings.running
    tell(edited_filter=get_curves()[0].data.smooth_polyline.filter, curves_after_edit=len(get_curves()))
    move(project((1.5, 0, -1)))
    yield from press("Z", ctrl=True)
    yield 0.3
    tell(filter_after_undo=get_curves()[0].data.smooth_polyline.filter)
    yield from press("Z", ctrl=True)
    yield 0.3
    tell(curves_after_undo=len(get_curves()))

    with in_view():
        bpy.ops.wm.tool_set_by_id(name="smooth_polylines.draw")
    for place in PLACES[:2]:
        yield from click(project(place))
    tell(drawing_again=len(drawings.running))
    yield from press("ESC")
    yield 0.2
    tell(after_esc=[len(drawings.running), len(get_curves()), len(get_window().modal_operators)])

    with in_view():
        bpy.ops.object.mode_set(mode="EDIT")
        bpy.ops.wm.tool_set_by_id(name="smooth_polylines.draw_in_edit_mode")
    yield 0.2
    for place in PLACES:
        yield from click(project(place))
    yield from until_redrawn()
    shoot("edit_mode")
    yield from press("RET")
    yield 0.3
    tell(in_edit_mode=len(get_curves()), mode=bpy.context.mode)

    bpy.context.object.data.use_mirror_x = True
    for place in ((0.5, -0.8, 0.5), (0.2, -0.8, 0.7)):
        yield from click(project(place))
    yield from until_redrawn()
    shoot("mirrored")
    yield from press("RET")
    yield 0.3
    ends = [curve.data.splines[0].points[0].co.x for curve in get_curves()[-2:]]
    tell(with_mirror=len(get_curves()), mirrored_apart=abs(sum(ends)), mirrored_ends=ends)


play(scenario)
