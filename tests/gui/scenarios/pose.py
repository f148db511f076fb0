"""A line drawn along an arm that is then bent, which it follows frame by frame; a head drawn on both sides at once."""

import importlib
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

import numpy as np
from kit import (
    begin_drawing,
    bpy,
    click,
    draw,
    empty_scene,
    find_view,
    in_view,
    move,
    play,
    press,
    project,
    shoot,
    tell,
    until_redrawn,
)

drawings = importlib.import_module("bl_ext.user_default.smooth_polylines.draw_tool.drawing")


def get_points(curve):
    values = np.empty(4 * len(curve.data.splines[0].points), dtype=np.float32)
    curve.data.splines[0].points.foreach_get("co", values)
    return values.reshape(-1, 4)[:, :3].astype(np.float64)


def measure_off_surface(curve):
    """Largest distance of the curve's points to its mesh as it is now, by Blender's own search."""
    evaluated = curve.parent.evaluated_get(bpy.context.evaluated_depsgraph_get())
    return max(
        float(np.linalg.norm(np.array(evaluated.closest_point_on_mesh(point)[1]) - point))
        for point in get_points(curve)
    )


def add_arm():
    """A sleeve along x with two bones, which bends at its middle over frames 1 to 20."""
    bpy.ops.mesh.primitive_cylinder_add(
        vertices=48, radius=0.35, depth=4.0, rotation=(0, np.pi / 2, 0), end_fill_type="NGON"
    )
    arm = bpy.context.object
    bpy.ops.object.transform_apply(rotation=True)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.mesh.bisect(plane_co=(0, 0, 0), plane_no=(1, 0, 0))
    for k in range(1, 24):
        for x in (-2.0 * k / 24, 2.0 * k / 24):
            bpy.ops.mesh.select_all(action="SELECT")
            bpy.ops.mesh.bisect(plane_co=(x, 0, 0), plane_no=(1, 0, 0))
    bpy.ops.object.mode_set(mode="OBJECT")
    for vertex in arm.data.vertices:
        vertex.co.y *= 1.0 + 0.25 * np.cos(1.3 * vertex.co.x)
        vertex.co.z *= 1.0 + 0.25 * np.cos(1.3 * vertex.co.x)
    bpy.ops.object.shade_smooth()
    armature = bpy.data.objects.new("Bones", bpy.data.armatures.new("Bones"))
    bpy.context.scene.collection.objects.link(armature)
    bpy.context.view_layer.objects.active = armature
    bpy.ops.object.mode_set(mode="EDIT")
    upper, lower = armature.data.edit_bones.new("Upper"), armature.data.edit_bones.new("Lower")
    upper.head, upper.tail = (-2, 0, 0), (0, 0, 0)
    lower.head, lower.tail, lower.parent = (0, 0, 0), (2, 0, 0), upper
    bpy.ops.object.mode_set(mode="OBJECT")
    for name, side in (("Upper", -1), ("Lower", 1)):
        group = arm.vertex_groups.new(name=name)
        for vertex in arm.data.vertices:
            group.add([vertex.index], float(np.clip(0.5 + side * vertex.co.x / 0.9, 0, 1)), "REPLACE")
    arm.modifiers.new("Bones", "ARMATURE").object = armature
    bone = armature.pose.bones["Lower"]
    bone.rotation_mode = "XYZ"
    for frame, angle in ((1, 0.0), (20, 1.3)):
        bone.rotation_euler = (angle, 0.0, 0.0)
        bone.keyframe_insert("rotation_euler", frame=frame)
    armature.hide_set(True)
    return arm


def scenario():
    yield from until_redrawn()
    with in_view():
        empty_scene()
        add_arm()
        bpy.context.scene.frame_set(1)
        bpy.ops.object.select_all(action="DESELECT")
        begin_drawing("Arm")
    find_view()[0].spaces.active.overlay.show_floor = False
    yield from until_redrawn()
    stroke = [project((x, -0.4, 0.22 * np.sin(2.2 * x))) for x in np.linspace(-1.7, 1.7, 60)]
    yield from draw(stroke)
    yield from click(project((1.85, -0.4, -0.1)))
    yield from until_redrawn()
    shoot("1_drawn", is_picture=True)
    (drawing,) = drawings.running
    tell(picks=len(drawing.sketch.state.picks), message=drawing.message, source=drawing.source)
    yield from press("RET")
    yield lambda: not drawings.running
    (curve,) = [o for o in bpy.data.objects if o.type == "CURVE"]
    move(project((0, 0, -1.5)))
    rest, off = get_points(curve), []
    stored = curve.data.smooth_polyline.stored
    for frame in (1, 5, 10, 15, 20):
        bpy.context.scene.frame_set(frame)
        yield from until_redrawn()
        off.append(measure_off_surface(curve))
        if frame in {10, 20}:
            shoot(f"2_frame_{frame}", is_picture=True)
    tell(off_surface=max(off), moved=float(np.abs(get_points(curve) - rest).max()))
    tell(is_same_line=curve.data.smooth_polyline.stored == stored)
    bpy.context.scene.frame_set(1)
    yield from until_redrawn()
    tell(came_back=bool(np.array_equal(get_points(curve), rest)))

    # A head with the symmetry on: both sides at once.
    with in_view():
        empty_scene()
        for left in list(bpy.data.objects):
            bpy.data.objects.remove(left)
        bpy.ops.mesh.primitive_monkey_add()
        head = bpy.context.object
        bpy.ops.object.shade_smooth()
        head.modifiers.new("Subdivision", "SUBSURF").levels = 2
        head.data.use_mirror_x = True
        bpy.ops.view3d.view_selected()
        bpy.ops.object.select_all(action="DESELECT")
    yield from until_redrawn()
    yield from draw([project((0.08 + 0.55 * t, -0.6, 0.86 - 0.3 * t * t)) for t in np.linspace(0, 1, 40)])
    yield from until_redrawn()
    shoot("3_mirrored", is_picture=True)
    (drawing,) = drawings.running
    tell(mirror_lines=len(drawing.lines), mirror_lengths=[line.length for line in drawing.lines])
    yield from press("RET")
    yield lambda: not drawings.running
    tell(mirror_curves=len([o for o in bpy.data.objects if o.type == "CURVE"]))


play(scenario)
