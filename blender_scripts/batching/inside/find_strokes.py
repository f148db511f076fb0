"""Strokes of guide objects in world space: curves of all kinds, and grease pencil of old and new. Reads only."""

from typing import Any

import numpy as np

import bpy

from .fault import FileFault

KINDS = ("CURVE", "CURVES", "GPENCIL", "GREASEPENCIL")
MOST_NAMES = 8


def find_strokes(along: dict[str, Any]) -> list[tuple[np.ndarray, bool]]:
    """Points (N, 3) in world space of each stroke that `along` means, and whether it is closed; FileFault for none.

    along : "object", and where given "layer" and "stroke", as in the job
    """
    guide = bpy.context.scene.objects.get(along["object"])
    if guide is None or guide.type not in KINDS:
        there = [o.name for o in bpy.context.scene.objects if o.type in KINDS]
        names = ", ".join(there[:MOST_NAMES]) or "none"
        kind = "" if guide is None else f" ({along['object']} is a {guide.type.lower()} object)"
        raise FileFault(
            "GuideError", f"there is no curve or grease pencil object {along['object']}{kind} (there are: {names})"
        )
    if "layer" in along and guide.type in ("CURVE", "CURVES"):
        raise FileFault("GuideError", f"{guide.name} is a curve and has no layers; leave out layer")
    strokes = READERS[guide.type](guide, along.get("layer"))
    strokes = [(points, closed) for points, closed in strokes if len(points) > 1]
    if "stroke" in along:
        if along["stroke"] >= len(strokes):
            raise FileFault(
                "GuideError", f"{guide.name} has {len(strokes)} strokes, from 0; there is no {along['stroke']}"
            )
        strokes = [strokes[along["stroke"]]]
    if not strokes:
        raise FileFault("GuideError", f"{guide.name} has no strokes of two points or more")
    matrix = np.array(guide.matrix_world, dtype=np.float64)
    return [(points @ matrix[:3, :3].T + matrix[:3, 3], closed) for points, closed in strokes]


def read_curve(guide: bpy.types.Object, _layer: str | None) -> list[tuple[np.ndarray, bool]]:
    """Bezier, NURBS and poly splines, each as Blender draws it, without bevel."""
    strokes = []
    for spline in guide.data.splines:
        plain = bpy.data.curves.new("Guide", "CURVE")
        bare = bpy.data.objects.new("Guide", plain)
        try:
            plain.dimensions, plain.resolution_u = guide.data.dimensions, guide.data.resolution_u
            copy_spline(spline, plain)
            points = read_vertices(bare.to_mesh())
            bare.to_mesh_clear()
        finally:
            bpy.data.objects.remove(bare)
            bpy.data.curves.remove(plain)
        strokes.append((points, spline.use_cyclic_u))
    return strokes


def copy_spline(spline: bpy.types.Spline, target: bpy.types.Curve) -> None:
    """The same spline, alone in another curve."""
    made = target.splines.new(spline.type)
    if spline.type == "BEZIER":
        made.bezier_points.add(len(spline.bezier_points) - 1)
        for point in made.bezier_points:
            point.handle_left_type = point.handle_right_type = "FREE"  # else moving one handle moves the other
        for name in ("co", "handle_left", "handle_right"):
            values = np.empty(3 * len(spline.bezier_points), dtype=np.float32)
            spline.bezier_points.foreach_get(name, values)
            made.bezier_points.foreach_set(name, values)
    else:
        made.points.add(len(spline.points) - 1)
        values = np.empty(4 * len(spline.points), dtype=np.float32)
        spline.points.foreach_get("co", values)
        made.points.foreach_set("co", values)
    made.use_cyclic_u = spline.use_cyclic_u
    made.resolution_u = spline.resolution_u
    if spline.type == "NURBS":
        made.order_u, made.use_endpoint_u, made.use_bezier_u = (
            spline.order_u,
            spline.use_endpoint_u,
            spline.use_bezier_u,
        )


def read_vertices(mesh: bpy.types.Mesh) -> np.ndarray:
    """Vertex positions, (N, 3)."""
    values = np.empty(3 * len(mesh.vertices), dtype=np.float32)
    mesh.vertices.foreach_get("co", values)
    return values.reshape(-1, 3).astype(np.float64)


def read_curves(guide: bpy.types.Object, _layer: str | None) -> list[tuple[np.ndarray, bool]]:
    """The newer Curves type: its control points."""
    data = guide.data
    values = np.empty(3 * len(data.points), dtype=np.float32)
    data.points.foreach_get("position", values)
    points = values.reshape(-1, 3).astype(np.float64)
    cyclic = data.attributes.get("cyclic")
    return [
        (points[curve.first_point_index :][: curve.points_length], bool(cyclic and cyclic.data[k].value))
        for k, curve in enumerate(data.curves)
    ]


def choose_layers(guide: bpy.types.Object, layer: str | None, name_of: str) -> list[Any]:
    """The layer that is named, or all that are shown."""
    layers = list(guide.data.layers)
    if layer is None:
        return [each for each in layers if not each.hide]
    found = [each for each in layers if getattr(each, name_of) == layer]
    if not found:
        names = ", ".join(getattr(each, name_of) for each in layers[:MOST_NAMES]) or "none"
        raise FileFault("GuideError", f"{guide.name} has no layer {layer} (there are: {names})")
    return found


def read_old_grease_pencil(guide: bpy.types.Object, layer: str | None) -> list[tuple[np.ndarray, bool]]:
    """Grease pencil up to Blender 4.2: the strokes of the current frame, by layer."""
    strokes = []
    for each in choose_layers(guide, layer, "info"):
        frame = each.active_frame or (each.frames[0] if len(each.frames) else None)
        for stroke in frame.strokes if frame is not None else ():
            values = np.empty(3 * len(stroke.points), dtype=np.float32)
            stroke.points.foreach_get("co", values)
            strokes.append((values.reshape(-1, 3).astype(np.float64), stroke.use_cyclic))
    return strokes


def read_grease_pencil(guide: bpy.types.Object, layer: str | None) -> list[tuple[np.ndarray, bool]]:
    """Grease pencil from Blender 4.3 on: the strokes of the current frame, by layer."""
    strokes = []
    for each in choose_layers(guide, layer, "name"):
        frame = each.current_frame() or (each.frames[0] if len(each.frames) else None)
        if frame is None:
            continue
        matrix = np.array(each.matrix_local, dtype=np.float64)
        for stroke in frame.drawing.strokes:
            points = np.array([tuple(point.position) for point in stroke.points], dtype=np.float64).reshape(-1, 3)
            strokes.append((points @ matrix[:3, :3].T + matrix[:3, 3], bool(stroke.cyclic)))
    return strokes


READERS = {
    "CURVE": read_curve,
    "CURVES": read_curves,
    "GPENCIL": read_old_grease_pencil,
    "GREASEPENCIL": read_grease_pencil,
}
