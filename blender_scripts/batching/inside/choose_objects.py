"""Which mesh objects of an opened file the job means. Reads only."""

import fnmatch

import bpy

from .fault import FileFault

MOST_NAMES = 8


def list_meshes() -> list[bpy.types.Object]:
    """All mesh objects of the scene that are not hidden, by name."""
    found = [o for o in bpy.context.scene.objects if o.type == "MESH" and o.visible_get()]
    return sorted(found, key=lambda o: o.name)


def choose_objects(meshes: list[bpy.types.Object], patterns: list[str]) -> list[bpy.types.Object]:
    """Those whose names match a pattern; FileFault when there are none."""
    chosen = [o for o in meshes if any(fnmatch.fnmatchcase(o.name, pattern) for pattern in patterns)]
    if chosen:
        return chosen
    if not meshes:
        hidden = sum(o.type == "MESH" for o in bpy.context.scene.objects)
        said = f"has no visible mesh objects ({hidden} are hidden)" if hidden else "has no mesh objects"
        raise FileFault("NoObjectError", said)
    names = ", ".join(o.name for o in meshes[:MOST_NAMES]) + (", ..." if len(meshes) > MOST_NAMES else "")
    raise FileFault("NoObjectError", f"no mesh object matches {' or '.join(patterns)} (there are: {names})")
