"""For the tests that call every operator of the add-on where it was not meant to be called. Import after bpy.

Finds the operators, calls them, and sees to it that a refusal is for people and changes nothing.
"""

import zlib

import numpy as np

import bpy

EXTENSION = "bl_ext.user_default.smooth_polylines"


def find_operators():
    """(idname, callable) of all operators that the add-on has registered."""
    found = []
    for name in dir(bpy.types):
        class_ = getattr(bpy.types, name)
        if (
            isinstance(class_, type)
            and issubclass(class_, bpy.types.Operator)
            and class_.__module__.startswith(EXTENSION)
        ):
            module, operator = class_.bl_idname.split(".")
            found.append((class_.bl_idname, getattr(getattr(bpy.ops, module), operator)))
    return sorted(found, key=lambda pair: pair[0])


def describe_scene():
    """All that an operator could have changed and must not have when it refuses, as something to compare."""
    objects = {
        o.name: (o.type, o.mode, o.visible_get(), o.select_get(), None if o.data is None else o.data.name)
        for o in bpy.context.view_layer.objects
    }
    active = bpy.context.view_layer.objects.active
    counts = {
        name: len(getattr(bpy.data, name)) for name in ("objects", "meshes", "curves", "materials", "collections")
    }
    return objects, None if active is None else active.name, counts, {m.name: describe_mesh(m) for m in bpy.data.meshes}


def describe_mesh(mesh):
    """Vertices, faces, where they are, and which attributes there are; in Edit Mode as it was on entering."""
    positions = np.empty(3 * len(mesh.vertices), dtype=np.float32)
    mesh.vertices.foreach_get("co", positions)
    names = sorted(a.name for a in mesh.attributes if not a.name.startswith("."))
    return len(mesh.vertices), len(mesh.edges), len(mesh.polygons), zlib.crc32(positions), names


def abuse(name, operator, *arguments, **properties):
    """Call it; what it says must be for people, and nothing is changed. Returns whether it did something."""
    before = describe_scene()
    try:
        result = operator(*arguments, **properties)
    except RuntimeError as error:
        message = str(error)
        assert "Traceback" not in message, f"{name}: {message}"
        assert "unexpectedly" not in message, f"{name}: {message}"
        assert len(message) > 20, f"{name}: {message}"
        assert describe_scene() == before, f"{name} changed something: {message}"
        return False
    if result == {"CANCELLED"}:
        assert describe_scene() == before, f"{name} was cancelled and changed something"
    return result == {"FINISHED"}
