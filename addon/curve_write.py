# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes a finished line into the scene: one curve object, child of the mesh object.

Knows neither the library nor the picks. Creates everything or nothing.
"""

import numpy as np

import bpy

# Radius of the tube as a part of the mesh's bounding-box diagonal: seen at a glance, thin beside most faces.
AUTOMATIC_BEVEL_PART = 0.004


def choose_bevel(local_positions: np.ndarray) -> float:
    """The automatic radius of the tube, in the object's units."""
    return AUTOMATIC_BEVEL_PART * float(np.linalg.norm(np.ptp(local_positions, axis=0)))


def write_curve(
    context: bpy.types.Context,
    mesh_object: bpy.types.Object,
    local_points: np.ndarray,
    *,
    closed: bool,
    bevel: float,
    name: str,
) -> bpy.types.Object:
    """Make the curve object: one POLY spline through `local_points`, (N, 3) in the space of `mesh_object`.

    It is a child of `mesh_object` without any transform of its own, so the two share their space and move
    together; it goes into the mesh object's collection.
    """
    curve = bpy.data.curves.new(name, "CURVE")
    curve_object = None
    try:
        curve.dimensions = "3D"
        write_points(curve, local_points, closed=closed)
        curve.bevel_depth = bevel
        curve.use_fill_caps = True
        curve_object = bpy.data.objects.new(name, curve)
        curve_object.parent = mesh_object
        choose_collection(context, mesh_object).objects.link(curve_object)
    except BaseException:
        if curve_object is not None:
            bpy.data.objects.remove(curve_object)
        bpy.data.curves.remove(curve)
        raise
    show_in_local_view(context, curve_object)
    return curve_object


def write_points(curve: bpy.types.Curve, local_points: np.ndarray, *, closed: bool) -> bool:
    """Make `curve` one POLY spline through `local_points`, (N, 3); False when it was that already, to the bit."""
    coordinates = np.ones((len(local_points), 4), dtype=np.float32)  # the fourth is the weight
    coordinates[:, :3] = local_points
    spline = curve.splines[0] if len(curve.splines) == 1 else None
    if spline is None or spline.type != "POLY" or len(spline.points) != len(coordinates):
        curve.splines.clear()
        spline = curve.splines.new("POLY")
        spline.points.add(len(coordinates) - 1)
    else:
        present = np.empty_like(coordinates)
        spline.points.foreach_get("co", present.ravel())
        if spline.use_cyclic_u == closed and np.array_equal(present, coordinates):
            return False
    spline.points.foreach_set("co", coordinates.ravel())
    spline.use_cyclic_u = closed
    curve.update_tag()
    return True


def choose_collection(context: bpy.types.Context, mesh_object: bpy.types.Object) -> bpy.types.Collection:
    """The first collection of the mesh object that takes new objects, else the scene's own."""
    for collection in mesh_object.users_collection:
        if collection.library is None and collection.override_library is None:
            return collection
    return context.scene.collection


def show_in_local_view(context: bpy.types.Context, curve_object: bpy.types.Object) -> None:
    """Show the new object also in a viewport that shows only chosen ones."""
    space = context.space_data
    if space is not None and space.type == "VIEW_3D" and space.local_view is not None:
        curve_object.local_view_set(space, True)
