"""The draw tool in the modes and on the displays that people have: local view, perspective, several meshes at once.

Every output, mirrored, the panel of the last operation, a display of twice the density, the buttons of the view.
"""

import importlib
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

import numpy as np
from kit import (
    begin_drawing,
    bpy,
    click,
    empty_scene,
    find_view,
    in_view,
    move,
    play,
    press,
    project,
    read_screen,
    shoot,
    tell,
    until_redrawn,
)

EXTENSION = "bl_ext.user_default.smooth_polylines"
drawings = importlib.import_module(f"{EXTENSION}.draw_tool.drawing")
PLACES = [(-0.5, -0.8, 0.5), (0.0, -0.7, 0.6), (0.5, -0.8, 0.5)]


def get_drawing():
    (drawing,) = drawings.running
    return drawing


def start_over(*objects):
    """An empty scene but for what `objects` make, seen from the front, with the tool chosen."""
    with in_view():
        if bpy.context.mode != "OBJECT":
            bpy.ops.object.mode_set(mode="OBJECT")
        empty_scene()
        made = [make() for make in objects]
        begin_drawing("Start")
    yield from until_redrawn()
    return made


def add_monkey(**options):
    bpy.ops.mesh.primitive_monkey_add(**options)
    return bpy.context.object


def count_line_color():
    """Pixels of the 3D view that have the colour of the line."""
    _, region = find_view()
    wanted = 255 * np.array(bpy.context.preferences.themes[0].view_3d.edge_select[:3])
    screen = read_screen().astype(float)[::-1][
        region.y + 10 : region.y + region.height - 60, region.x + 60 : region.x + region.width - 80
    ]
    return int((np.abs(screen - wanted).max(axis=2) < 12).sum())


def draw_line(places=PLACES):
    for place in places:
        yield from click(project(place))


def leave():
    yield from press("ESC")
    yield lambda: not drawings.running


def scenario():
    yield from until_redrawn()

    # A click beside every mesh begins nothing.
    yield from start_over(add_monkey)
    yield from click(project((2.5, 0, 0)))
    yield 0.3
    tell(begun_beside=len(drawings.running))

    # Two heads, one before the other: in a local view of the far one, clicks go to that.
    near, far = yield from start_over(lambda: add_monkey(location=(0, -3, 0)), lambda: add_monkey(location=(0, 3, 0)))
    near.name, far.name = "Near", "Far"
    yield from draw_line()
    tell(of_two=get_drawing().mesh_name)
    yield from leave()
    with in_view():
        bpy.ops.object.select_all(action="DESELECT")
        far.select_set(True)
        bpy.context.view_layer.objects.active = far
        bpy.ops.view3d.localview(frame_selected=False)
    yield from until_redrawn()
    yield from draw_line([(x, y + 3, z) for x, y, z in PLACES])
    tell(in_local_view=get_drawing().mesh_name, local_picks=len(get_drawing().sketch.state.picks))
    yield from press("RET")
    yield lambda: not drawings.running
    curve = bpy.context.object
    tell(local_curve_seen=curve.visible_get(viewport=find_view()[0].spaces.active), local_parent=curve.parent.name)
    with in_view():
        bpy.ops.view3d.localview(frame_selected=False)

    # In perspective, from the side, on a scaled and turned head.
    def add_turned():
        return add_monkey(scale=(1.4, 0.8, 1.0), rotation=(0.2, 0.1, 0.4))

    (head,) = yield from start_over(add_turned)
    with in_view():
        bpy.ops.view3d.view_persportho()
        bpy.ops.view3d.view_orbit(angle=0.4, type="ORBITRIGHT")
    yield from until_redrawn(4)
    wanted = []
    for place in PLACES:
        target = head.matrix_world @ type(head.location)(place)
        wanted.append(project(target))
        yield from click(wanted[-1])
    found = [project(pick.place) for pick in get_drawing().sketch.state.picks]
    tell(perspective=find_view()[0].spaces.active.region_3d.is_perspective)
    tell(perspective_off=float(np.abs(np.array(found) - np.array(wanted)).max()))
    # Clicks on the view's axes and buttons, on its panels, and beside the mesh set no pick.
    area, region = find_view()
    before = len(get_drawing().sketch.state.picks)
    corner = (region.x + region.width, region.y + region.height)
    yield from click((corner[0] - 26, corner[1] - 259))  # the button for parallel views
    yield from until_redrawn(6)
    tell(button_worked=not area.spaces.active.region_3d.is_perspective)
    yield from click((region.x + 25, region.y + 150))
    yield from click((region.x + 300, region.y + 20))
    tell(picks_by_buttons=len(get_drawing().sketch.state.picks) - before)
    yield from until_redrawn()
    shoot("perspective")
    yield from leave()

    # A display of twice the density: the line is twice as wide.
    yield from start_over(add_monkey)
    bpy.context.view_layer.objects.active = None
    with in_view():
        bpy.ops.object.select_all(action="DESELECT")
    yield from draw_line([PLACES[0], PLACES[2]])
    move((project((0, 0, -0.9))[0], project((0, 0, -0.9))[1]))
    yield from until_redrawn(4)
    tell(line_pixels=count_line_color())
    shoot("density_1")
    bpy.context.preferences.view.ui_scale = 2.0
    yield from until_redrawn(6)
    with in_view():
        bpy.ops.view3d.view_axis(type="FRONT")
    yield from until_redrawn(4)
    tell(line_pixels_twice=count_line_color(), scale=bpy.context.preferences.system.ui_scale)
    shoot("density_2")
    bpy.context.preferences.view.ui_scale = 1.0
    yield from until_redrawn(4)
    yield from leave()

    # Mirrored, in Object Mode.
    (head,) = yield from start_over(add_monkey)
    head.data.use_mirror_x = True
    yield from draw_line([(0.15, -0.7, 0.7), (0.55, -0.7, 0.55), (0.75, -0.5, 0.1)])
    tell(mirrors=len(get_drawing().lines) - 1)
    yield from until_redrawn()
    shoot("mirrored")
    yield from press("RET")
    yield lambda: not drawings.running
    tell(mirrored_curves=len([o for o in bpy.data.objects if o.type == "CURVE"]))

    # Every output, by the tool's own settings; then the panel of the last operation.
    for output in ("CURVE", "MESH", "CURVES"):
        if output == "CURVES" and "set_types" not in bpy.types.Curves.bl_rna.functions:
            continue
        yield from start_over(add_monkey)
        with in_view():
            tool = bpy.context.workspace.tools.from_space_view3d_mode("OBJECT")
        wishes = tool.operator_properties("view3d.smooth_polyline_draw")
        wishes.output, wishes.name, wishes.resample = output, f"Line {output}", 0.05
        yield from draw_line()
        yield from press("RET")
        yield lambda: not drawings.running
        yield from until_redrawn()
        made = bpy.context.object
        tell(**{f"made_{output}": [made.type, made.name, len(made.data.smooth_polyline.stored) > 0]})
        shoot(f"output_{output.lower()}")
    wishes.output, wishes.name, wishes.resample = "CURVE", "Smooth Polyline", 0.0
    yield from start_over(add_monkey)
    yield from draw_line()
    yield from press("RET")
    yield lambda: not drawings.running
    last = bpy.context.window_manager.operators[-1]
    tell(last_operation=last.bl_idname, last_filter=last.properties.filter)
    with in_view():
        last.properties.filter = "GEODESIC"
        bpy.ops.ed.undo_redo()
    yield 0.3
    curves = [o for o in bpy.data.objects if o.type == "CURVE"]
    tell(curves_after_redo=len(curves), filter_after_redo=curves[0].data.smooth_polyline.filter)

    # Two meshes in Edit Mode: the one under the mouse.
    left, right = yield from start_over(
        lambda: add_monkey(location=(-1.5, 0, 0)), lambda: add_monkey(location=(1.5, 0, 0))
    )
    left.name, right.name = "Left", "Right"
    with in_view():
        bpy.ops.object.select_all(action="SELECT")
        bpy.ops.object.mode_set(mode="EDIT")
        bpy.ops.wm.tool_set_by_id(name="smooth_polylines.draw_in_edit_mode")
    yield from until_redrawn()
    for side, name in ((-1.5, "Left"), (1.5, "Right")):
        yield from draw_line([(x + side, y, z) for x, y, z in PLACES])
        tell(**{f"edited_{name}": get_drawing().mesh_name})
        if side < 0:
            yield from until_redrawn()
            shoot("two_in_edit_mode")
        yield from press("RET")
        yield lambda: not drawings.running
    parents = sorted(o.parent.name for o in bpy.data.objects if o.type == "CURVE")
    tell(parents=parents, mode=bpy.context.mode)


play(scenario)
