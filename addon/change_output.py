# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes the object of a line that remembers another kind of object. Knows no library and makes no line."""

import numpy as np

import bpy

from . import curve_write, line_data, session
from .errors import ObjectError
from .live import memory


def change_output(context: bpy.types.Context, line_object: bpy.types.Object, output: str) -> bpy.types.Object:
    """Make the object of a line that remembers another kind, with the same name and memory: the new object.

    Other objects that share the data-block keep the old one.
    """
    session.check_output(output)
    known = memory.find_memory(line_object)
    if known is None:
        raise ObjectError(f"{line_object.name} was not made by Smooth Polylines")
    for data in (line_object, line_object.data):
        session.check_local(data)
    if line_data.get_output(line_object.data) == output:
        return line_object
    new_object = curve_write.copy_as_output(line_object, output)
    memory.copy_memory(line_object.data, new_object.data)
    bevel = known.bevel
    if bevel == 0.0:
        bevel = curve_write.choose_bevel(line_data.read_points(line_object.data)[0])
        if not memory.is_mesh_gone(known):
            box = np.array(known.surface.bound_box, dtype=np.float64)
            bevel = curve_write.choose_bevel(box)
    line_data.set_bevel(new_object.data, bevel)
    name, is_active = line_object.name, context.view_layer.objects.active == line_object
    is_selected = line_object.select_get()
    curve_write.remove_line(line_object)
    new_object.name = name
    new_object.select_set(is_selected)
    if is_active:
        context.view_layer.objects.active = new_object
    return new_object
