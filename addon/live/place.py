# SPDX-License-Identifier: GPL-3.0-or-later
"""The collection and the material of a line's object, by name, for its panel: nothing but what Blender itself keeps.

Setting one changes the object; a name that is not there changes nothing.
"""

import bpy
from bpy.props import StringProperty

from .. import line_data


def get_collection(line_object: bpy.types.Object) -> str:
    """The name of the first collection that the object is in."""
    return next((collection.name for collection in line_object.users_collection), "")


def set_collection(line_object: bpy.types.Object, name: str) -> None:
    """Move the object into a collection of the file, out of all others."""
    chosen = bpy.data.collections.get(name)
    if chosen is None or chosen.library is not None:
        return
    for collection in line_object.users_collection:
        if collection != chosen:
            collection.objects.unlink(line_object)
    if line_object.name not in chosen.objects:
        chosen.objects.link(line_object)


def get_material(line_object: bpy.types.Object) -> str:
    """The name of the first material of the object's data."""
    materials = getattr(line_object.data, "materials", ())
    return materials[0].name if len(materials) > 0 and materials[0] is not None else ""


def set_material(line_object: bpy.types.Object, name: str) -> None:
    """Give the object's data a material of the file, or none for ""."""
    chosen = bpy.data.materials.get(name)
    if chosen is not None or not name:
        line_data.set_material(line_object.data, chosen)


PROPERTIES = {
    "smooth_polyline_collection": ("Collection", "Where the line is", get_collection, set_collection),
    "smooth_polyline_material": ("Material", "Material of the line", get_material, set_material),
}


def register() -> None:
    """Give objects these properties, which hold nothing of their own."""
    for name, (label, description, read, write) in PROPERTIES.items():
        prop = StringProperty(name=label, description=description, get=read, set=write)
        setattr(bpy.types.Object, name, prop)


def unregister() -> None:
    """Take them back."""
    for name in PROPERTIES:
        if hasattr(bpy.types.Object, name):
            delattr(bpy.types.Object, name)
