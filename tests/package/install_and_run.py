"""Run by tests in a fresh process, or in a Blender: installs the zip into an empty profile and runs the operator.

Argument: the zip, or `-` where it has been installed already. BLENDER_USER_RESOURCES: the empty profile. Prints one
line of JSON, beginning with RESULT. Holds no assertions; the test judges what is printed.
"""

import json
import os
import sys

import bpy

import bmesh

PICKS = [377, 253, 252, 376]
EXTENSION = "bl_ext.user_default.smooth_polylines"


def main(path):
    installed = {"FINISHED"}
    if path != "-":
        installed = bpy.ops.extensions.package_install_files(filepath=path, repo="user_default", enable_on_install=True)
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    bpy.ops.mesh.primitive_monkey_add()
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_mode(type="FACE")
    bpy.ops.mesh.select_all(action="DESELECT")
    edited = bmesh.from_edit_mesh(bpy.context.edit_object.data)
    edited.faces.ensure_lookup_table()
    for face in PICKS:
        edited.faces[face].select_set(True)
        edited.select_history.add(edited.faces[face])
    ran = bpy.ops.mesh.smooth_polyline_add(filter="LINEAR")
    (curve_object,) = [o for o in bpy.data.objects if o.type == "CURVE"]
    import smooth_polylines

    result = {
        "blender": bpy.app.version_string,
        "installed": sorted(installed),
        "ran": sorted(ran),
        "points": [list(p.co)[:3] for p in curve_object.data.splines[0].points],
        "library": smooth_polylines.__file__,
        "library_version": smooth_polylines.__version__,
        "addon": sys.modules[EXTENSION].__file__,
    }
    bpy.ops.preferences.addon_disable(module=EXTENSION)
    result["operator_left"] = hasattr(bpy.types, "MESH_OT_smooth_polyline_add")
    print("RESULT", json.dumps(result), flush=True)


if __name__ == "__main__":
    try:
        main(sys.argv[-1])
    except BaseException:
        # Written here, because the exit below, which spares bpy's destructors, would lose it.
        import traceback

        traceback.print_exc()
        sys.stderr.flush()
        os._exit(1)
    os._exit(0)
