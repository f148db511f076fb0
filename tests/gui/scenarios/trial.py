"""A new user's first hour on a subdivided Suzanne: a parting line over the head, a loop round an eye, other
filters, a dragged pick, undo and redo, save, reopen, edit again. Tells numbers and keeps pictures of every step.
"""

import importlib
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

import numpy as np
from kit import (
    FOLDER,
    begin_drawing,
    bpy,
    click,
    drag,
    draw,
    empty_scene,
    find_view,
    get_window,
    in_view,
    move,
    play,
    press,
    project,
    send,
    shoot,
    tell,
    until_redrawn,
)

EXTENSION = "bl_ext.user_default.smooth_polylines"
drawings = importlib.import_module(f"{EXTENSION}.draw_tool.drawing")


def get_drawing():
    (drawing,) = drawings.running
    return drawing


def get_curves():
    return sorted((o for o in bpy.data.objects if o.type == "CURVE"), key=lambda o: o.name)


def get_points(curve):
    values = np.empty(4 * len(curve.data.splines[0].points), dtype=np.float32)
    curve.data.splines[0].points.foreach_get("co", values)
    return values.reshape(-1, 4)[:, :3].astype(np.float64)


def measure_off_surface(curve):
    """Largest distance of the curve's points to what is seen of its mesh, by Blender's own search."""
    evaluated = curve.parent.evaluated_get(bpy.context.evaluated_depsgraph_get())
    away = [(evaluated.closest_point_on_mesh(point)[1], point) for point in get_points(curve)]
    return max(float(np.linalg.norm(np.array(found) - point)) for found, point in away)


def look(axis):
    with in_view():
        bpy.ops.view3d.view_axis(type=axis)
    yield from until_redrawn()


def set_picks(places):
    for place in places:
        yield from click(project(place))


def scenario():
    yield from until_redrawn()
    with in_view():
        empty_scene()
        bpy.ops.mesh.primitive_monkey_add()
        bpy.ops.object.shade_smooth()
        bpy.context.object.modifiers.new("Subdivision", "SUBSURF").levels = 2
        begin_drawing("Suzanne", view_selected=True)
    find_view()[0].spaces.active.overlay.show_floor = False
    yield from until_redrawn()
    shoot("1_start")

    # The parting: from the forehead over the top to the back, turning the view meanwhile.
    yield from set_picks([(0.05, -0.8, 0.55), (0.06, -0.7, 0.75)])
    view_before = np.array(find_view()[0].spaces.active.region_3d.view_matrix)
    yield from press("NUMPAD_7")
    yield from until_redrawn(4)
    turned = np.abs(np.array(find_view()[0].spaces.active.region_3d.view_matrix) - view_before).max()
    tell(turned_by_numpad=float(turned), picks_after_turn=len(get_drawing().sketch.state.picks))
    yield from set_picks([(0.03, -0.1, 0.95), (0.0, 0.4, 0.8)])
    yield from until_redrawn()
    shoot("2_parting_from_above")
    start, before = project((0.9, 0.0, 0.9)), len(get_drawing().sketch.state.picks)
    view_before = np.array(find_view()[0].spaces.active.region_3d.view_matrix)
    move(start)
    send("MIDDLEMOUSE", "PRESS")
    yield 0.1
    for k in range(8):
        move((start[0] - 25 * k, start[1] + 18 * k))
        yield 0.05
    send("MIDDLEMOUSE", "RELEASE")
    yield from until_redrawn()
    turned = np.abs(np.array(find_view()[0].spaces.active.region_3d.view_matrix) - view_before).max()
    tell(turned_by_mouse=float(turned), picks_after_mouse=len(get_drawing().sketch.state.picks) - before)
    shoot("3_turned_by_mouse", is_picture=True)
    tell(parting_message=get_drawing().message, parting_length=get_drawing().length)
    yield from press("RET")
    yield lambda: not drawings.running
    yield from look("FRONT")
    shoot("4_parting_kept")
    (parting,) = get_curves()
    tell(parting_off_surface=measure_off_surface(parting), parting_active=bpy.context.object == parting)

    # A loop round an eye, by one stroke.
    yield from press("ESC")  # nothing is going on: nothing happens
    centre, right, top = project((0.35, -0.8, 0.25)), project((0.62, -0.8, 0.25)), project((0.35, -0.8, 0.5))
    angles = np.linspace(0.3, 0.3 + 2 * np.pi, 60)
    places = [
        (round(centre[0] + (right[0] - centre[0]) * np.cos(a)), round(centre[1] + (top[1] - centre[1]) * np.sin(a)))
        for a in angles
    ]
    yield from draw(places[:40])
    tell(open_after_forty=get_drawing().sketch.state.is_closed, picks_after_forty=len(get_drawing().sketch.state.picks))
    yield from press("Z", ctrl=True)
    tell(picks_after_stroke_undo=len(get_drawing().sketch.state.picks))
    yield from draw(places)
    yield from until_redrawn()
    shoot("5_loop", is_picture=True)
    loop = get_drawing()
    seen = np.array([project(p) for p in loop.points])
    away = [np.linalg.norm(seen - np.array(place), axis=1).min() for place in places[1:-1]]
    tell(loop_closed=loop.sketch.state.is_closed, loop_picks=len(loop.sketch.state.picks), loop_message=loop.message)
    tell(loop_pixels_off=float(np.median(away)), loop_pixels_off_most=float(max(away)))

    # The detail size by a circle.
    yield from press("F")
    x, y = places[0]
    for k in range(6):
        move((x + 6 * k, y))
        yield 0.05
    yield from until_redrawn()
    shoot("6_detail_size", is_picture=True)
    tell(detail_size=loop.sketch.state.detail_size)
    yield from press("ESC")
    tell(detail_size_after_esc=loop.sketch.state.detail_size, still_drawing=len(drawings.running))

    # Cubic, a dragged pick, undo, redo.
    for _ in range(3):
        yield from press("T")
    tell(filter_chosen=loop.sketch.state.filter, cubic_message=loop.message)
    picked = project(loop.sketch.state.picks[2].place)
    yield from drag(picked, (picked[0] - 12, picked[1] + 30))
    dragged = loop.points.copy()
    yield from until_redrawn()
    shoot("7_cubic_dragged", is_picture=True)
    yield from press("Z", ctrl=True)
    tell(undo_changed=bool(dragged.shape != loop.points.shape or (dragged != loop.points).any()))
    yield from press("Z", ctrl=True, shift=True)
    tell(redo_is_same=bool(dragged.shape == loop.points.shape and (dragged == loop.points).all()))
    yield from press("RET")
    yield lambda: not drawings.running
    yield from until_redrawn()
    shoot("8_kept")
    tell(curves=len(get_curves()), loop_off_surface=measure_off_surface(get_curves()[-1]))
    tell(
        loop_filter=get_curves()[-1].data.smooth_polyline.filter,
        loop_cyclic=get_curves()[-1].data.splines[0].use_cyclic_u,
    )
    move(project((1.2, 0, -0.9)))
    yield from press("Z", ctrl=True)
    yield 0.3
    tell(curves_after_undo=len(get_curves()))
    yield from press("Z", ctrl=True, shift=True)
    yield 0.3
    tell(curves_after_redo=len(get_curves()))

    # Save, reopen, edit again.
    before = {curve.name: get_points(curve) for curve in get_curves()}
    path = str(FOLDER / "trial.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.open_mainfile(filepath=path)
    yield 0.5
    yield from until_redrawn()
    tell(same_after_reopening=all(np.array_equal(before[c.name], get_points(c)) for c in get_curves()))
    with in_view():
        bpy.ops.object.select_all(action="DESELECT")
        curve = get_curves()[-1]
        curve.select_set(True)
        bpy.context.view_layer.objects.active = curve
    find_view()[0].spaces.active.show_region_ui = True
    sidebar = next(region for region in find_view()[0].regions if region.type == "UI")
    yield from until_redrawn(4)
    # Before 4.4 a script cannot choose the tab: the lowest of its kind, in a column at the right.
    try:
        sidebar.active_panel_category = "Smooth Polyline"
    except (AttributeError, TypeError):
        yield from click((sidebar.x + sidebar.width - 12, sidebar.y + sidebar.height - 260))
    yield from until_redrawn(4)
    shoot("9_reopened")
    # The button at the top of the panel.
    yield from click((sidebar.x + sidebar.width // 2, sidebar.y + sidebar.height - 46))
    yield lambda: bool(drawings.running) and drawings.running[0].opened is not None
    again = get_drawing()
    tell(picks_again=len(again.sketch.state.picks), filter_again=again.sketch.state.filter)
    tell(closed_again=again.sketch.state.is_closed)
    picked = project(again.sketch.state.picks[0].place)
    yield from drag(picked, (picked[0] + 10, picked[1] + 24))
    yield from until_redrawn()
    shoot("10_edited_again", is_picture=True)
    yield from press("RET")
    yield lambda: not drawings.running
    yield from until_redrawn()
    curve = get_curves()[-1]
    tell(curves_at_the_end=len(get_curves()), edited_off_surface=measure_off_surface(curve))
    tell(edit_changed=not np.array_equal(before[curve.name], get_points(curve)), state=curve.data.smooth_polyline.state)
    tell(modal_at_the_end=len(get_window().modal_operators))
    shoot("11_end")


play(scenario)
