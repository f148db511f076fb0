# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes a finished line into the scene: one object, child of the mesh object.

Knows neither the library nor the picks. Creates everything or nothing.
"""

import numpy as np

import bpy

from . import line_data
from .errors import ObjectError

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
    output: str = "CURVE",
    collection: bpy.types.Collection | None = None,
    material: bpy.types.Material | None = None,
) -> bpy.types.Object:
    """Make the object: one chain of straight pieces through `local_points`, (N, 3) in the space of `mesh_object`.

    It is a child of `mesh_object` without any transform of its own, so the two share their space and move
    together; it goes into `collection`, or the mesh object's own.
    """
    data, new_object = line_data.new_data(output, name), None
    try:
        line_data.write_points(data, local_points, closed=closed)
        line_data.set_bevel(data, bevel)
        if material is not None:
            line_data.set_material(data, material)
        new_object = bpy.data.objects.new(name, data)
        new_object.parent = mesh_object
        (collection or choose_collection(context, mesh_object)).objects.link(new_object)
    except BaseException:
        if new_object is not None:
            bpy.data.objects.remove(new_object)
        line_data.list_blocks(output).remove(data)
        raise
    show_in_local_view(context, new_object)
    return new_object


def remove_line(line_object: bpy.types.Object) -> None:
    """Take an object and its data-block out of the file."""
    data, output = line_object.data, line_data.get_output(line_object.data)
    bpy.data.objects.remove(line_object)
    if data.users == 0:
        line_data.list_blocks(output).remove(data)


def copy_as_output(line_object: bpy.types.Object, output: str) -> bpy.types.Object:
    """Another kind of object beside `line_object`: with its points, parent, collections and materials.

    What is the old kind's own, such as modifiers, it does not get.
    """
    old = line_object.data
    points, closed = line_data.read_points(old)
    if points is None:
        raise ObjectError(f"{line_object.name} is no single chain of straight pieces any more, so it cannot be changed")
    data = line_data.new_data(output, old.name)
    line_data.write_points(data, points, closed=closed)
    for material in old.materials:
        data.materials.append(material)
    name = line_object.name
    new_object = bpy.data.objects.new(name, data)
    new_object.parent = line_object.parent
    new_object.matrix_parent_inverse = line_object.matrix_parent_inverse
    new_object.matrix_basis = line_object.matrix_basis
    for collection in line_object.users_collection:
        collection.objects.link(new_object)
    return new_object


def choose_collection(context: bpy.types.Context, mesh_object: bpy.types.Object) -> bpy.types.Collection:
    """The first collection of the mesh object that takes new objects, else the scene's own."""
    for collection in mesh_object.users_collection:
        if collection.library is None and collection.override_library is None:
            return collection
    return context.scene.collection


def show_in_local_view(context: bpy.types.Context, curve_object: bpy.types.Object) -> None:
    """Show the new object also in a viewport that shows only chosen ones."""
    space = getattr(context, "space_data", None)  # none in a timer
    if space is not None and space.type == "VIEW_3D" and space.local_view is not None:
        curve_object.local_view_set(space, True)
