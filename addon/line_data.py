# SPDX-License-Identifier: GPL-3.0-or-later
"""The kinds of data-block that can hold a line: a poly curve, the edges of a mesh, and the newer Curves of hair.

Each is made, written and measured in one way here, so that nobody else need ask which kind it is. Knows no objects and
no library.
"""

from typing import Any

import numpy as np

import bpy

OUTPUTS = (
    ("CURVE", "Curve", "A poly curve, with a tube round it; it can be edited and converted as any curve"),
    ("MESH", "Mesh Edges", "A mesh of edges alone; what modifiers make of edges (Skin, Geometry Nodes) works on it"),
    (
        "CURVES",
        "Hair Curves",
        "The newer Curves of hair and Geometry Nodes, with a radius; from Blender 4.5 on",
    ),
)


def has_hair_curves() -> bool:
    """Whether this Blender can make Curves of straight pieces."""
    return hasattr(bpy.types, "Curves") and "set_types" in bpy.types.Curves.bl_rna.functions


def get_output(data: Any) -> str:
    """The kind of a data-block, as `OUTPUTS` name it."""
    return {"Mesh": "MESH", "Curves": "CURVES"}.get(type(data).__name__, "CURVE")


def list_blocks(output: str) -> Any:
    """The file's data-blocks of a kind."""
    return {"CURVE": bpy.data.curves, "MESH": bpy.data.meshes, "CURVES": getattr(bpy.data, "hair_curves", None)}[output]


def new_data(output: str, name: str) -> Any:
    """An empty data-block of a kind."""
    if output == "CURVE":
        curve = bpy.data.curves.new(name, "CURVE")
        curve.dimensions = "3D"
        curve.use_fill_caps = True
        return curve
    return list_blocks(output).new(name)


def is_being_edited(data: Any) -> bool:
    """Whether an artist has it open in a mode in which its points are not ours to write."""
    if hasattr(data, "is_editmode"):
        return data.is_editmode
    return any(found.mode != "OBJECT" for found in bpy.context.scene.objects if found.data == data)


def write_points(data: Any, local_points: np.ndarray, *, closed: bool) -> bool:
    """Make `data` one chain of straight pieces through `local_points`, (N, 3); False when it was that to the bit."""
    points = np.ascontiguousarray(local_points, dtype=np.float32)
    present, was_closed = read_points(data)
    if present is not None and len(present) == len(points) and was_closed == closed and len(points) > 0:
        if np.array_equal(present, points):
            return False
        {"CURVE": put_curve_points, "MESH": put_mesh_points, "CURVES": put_hair_points}[get_output(data)](data, points)
    else:
        {"CURVE": build_curve, "MESH": build_mesh, "CURVES": build_hair}[get_output(data)](data, points, closed)
    data.update_tag()
    return True


def read_points(data: Any) -> tuple[np.ndarray | None, bool]:
    """The points, (N, 3) float32, and whether the chain is closed; None when it is no single chain."""
    output = get_output(data)
    if output == "CURVE":
        if len(data.splines) != 1 or data.splines[0].type != "POLY":
            return None, False
        values = np.empty(4 * len(data.splines[0].points), dtype=np.float32)
        data.splines[0].points.foreach_get("co", values)
        return values.reshape(-1, 4)[:, :3], data.splines[0].use_cyclic_u
    if output == "MESH":
        count = len(data.vertices)
        if len(data.polygons) > 0 or len(data.edges) not in {count, count - 1} or count == 0:
            return None, False
        values = np.empty(3 * count, dtype=np.float32)
        data.attributes["position"].data.foreach_get("vector", values)
        return values.reshape(-1, 3), len(data.edges) == count
    if len(data.curves) != 1:
        return None, False
    values = np.empty(3 * len(data.points), dtype=np.float32)
    data.attributes["position"].data.foreach_get("vector", values)
    cyclic = data.attributes.get("cyclic")
    return values.reshape(-1, 3), cyclic is not None and bool(cyclic.data[0].value)


def put_curve_points(curve: bpy.types.Curve, points: np.ndarray) -> None:
    """Other places for the points of a poly curve."""
    rows = np.ones((len(points), 4), dtype=np.float32)  # the fourth is the weight
    rows[:, :3] = points
    curve.splines[0].points.foreach_set("co", rows.ravel())


def build_curve(curve: bpy.types.Curve, points: np.ndarray, closed: bool) -> None:
    """One POLY spline."""
    curve.splines.clear()
    spline = curve.splines.new("POLY")
    spline.points.add(len(points) - 1)
    spline.use_cyclic_u = closed
    put_curve_points(curve, points)


def put_mesh_points(mesh: bpy.types.Mesh, points: np.ndarray) -> None:
    """Other places for the vertices."""
    mesh.attributes["position"].data.foreach_set("vector", points.ravel())


def build_mesh(mesh: bpy.types.Mesh, points: np.ndarray, closed: bool) -> None:
    """Vertices in order, and an edge from each to the next."""
    mesh.clear_geometry()
    mesh.vertices.add(len(points))
    put_mesh_points(mesh, points)
    starts = np.arange(len(points) if closed else len(points) - 1, dtype=np.int32)
    mesh.edges.add(len(starts))
    mesh.edges.foreach_set("vertices", np.column_stack([starts, (starts + 1) % len(points)]).astype(np.int32).ravel())


def put_hair_points(curves: Any, points: np.ndarray) -> None:
    """Other places for the points."""
    curves.attributes["position"].data.foreach_set("vector", points.ravel())


def build_hair(curves: Any, points: np.ndarray, closed: bool) -> None:
    """One curve of straight pieces."""
    if len(curves.curves) == 1:
        curves.resize_curves([len(points)])
    else:
        if len(curves.curves) > 0:
            curves.remove_curves()
        curves.add_curves([len(points)])
    curves.set_types(type="POLY")
    cyclic = curves.attributes.get("cyclic") or curves.attributes.new("cyclic", "BOOLEAN", "CURVE")
    cyclic.data[0].value = closed
    put_hair_points(curves, points)


def set_bevel(data: Any, bevel: float) -> None:
    """The radius round the line, where the kind has one: edges of a mesh have none."""
    output = get_output(data)
    if output == "CURVE":
        data.bevel_depth = bevel
    elif output == "CURVES":
        radius = data.attributes.get("radius") or data.attributes.new("radius", "FLOAT", "POINT")
        radius.data.foreach_set("value", np.full(len(data.points), bevel, dtype=np.float32))


def set_material(data: Any, material: bpy.types.Material | None) -> None:
    """The material of the line; None: without one."""
    if material is None:
        data.materials.clear()
    elif len(data.materials) == 0:
        data.materials.append(material)
    else:
        data.materials[0] = material
