"""Draws a smooth line on a mesh in real Blender, as an artist would, and leaves a .blend and a picture.

    python blender_scripts/demo.py --output out [--mesh head.obj] [--filter linear]

Enables the add-on, picks faces in Edit Mode one after another, runs the operator, prints what it did. What to pick
is in `demo_meshes`, how it looks in `demo_render`. Not imported by the add-on or the tests.
"""

import argparse
import os
import sys
import tempfile
import time
from pathlib import Path

# Before bpy is imported: the demo neither reads nor changes the Blender settings of whoever runs it.
PROFILE = tempfile.TemporaryDirectory(prefix="smooth-polylines-demo-")
os.environ["BLENDER_USER_RESOURCES"] = PROFILE.name

import bpy  # noqa: E402

import addon_utils  # noqa: E402
import bmesh  # noqa: E402
from mathutils import Vector  # noqa: E402

import demo_meshes  # noqa: E402
import demo_render  # noqa: E402

ADDON = Path(__file__).resolve().parents[1] / "addon"
EXTENSION = "bl_ext.user_default.smooth_polylines"


def enable_addon() -> None:
    """Make the source folder an extension of the empty profile and enable it."""
    extensions = Path(PROFILE.name, "extensions", "user_default")
    extensions.mkdir(parents=True)
    (extensions / "smooth_polylines").symlink_to(ADDON, target_is_directory=True)
    if addon_utils.enable(EXTENSION, default_set=True) is None:
        sys.exit("Blender could not enable the add-on (its message is above)")


def pick_faces(mesh_object: bpy.types.Object, picks: list[int]) -> None:
    """Enter Edit Mode and select faces one after another, as clicks with Shift do."""
    bpy.context.view_layer.objects.active = mesh_object
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_mode(type="FACE")
    bpy.ops.mesh.select_all(action="DESELECT")
    edited = bmesh.from_edit_mesh(mesh_object.data)
    edited.faces.ensure_lookup_table()
    for face in picks:
        edited.faces[face].select_set(True)
        edited.select_history.add(edited.faces[face])
    bmesh.update_edit_mesh(mesh_object.data, loop_triangles=False, destructive=False)


def add_line(**properties: object) -> bpy.types.Object:
    """Run the operator; the new curve object. Ends the demo with the operator's message when it refuses."""
    before = set(bpy.data.objects)
    try:
        bpy.ops.mesh.smooth_polyline_add(**properties)
    except RuntimeError as error:
        sys.exit(f"No line: {error}")
    (curve_object,) = set(bpy.data.objects) - before
    return curve_object


def print_report(mesh_object: bpy.types.Object, picks: list[int], properties: dict, operator_seconds: float) -> None:
    """What the line took, from the library's own report of the same line."""
    from bl_ext.user_default.smooth_polylines import session

    computed = session.compute_polyline(
        bpy.context, mesh_object, **{k: v.lower() if isinstance(v, str) else v for k, v in properties.items()}
    )
    line, report = computed.line, computed.line.report
    print(f"  mesh                 {mesh_object.name}: {len(computed.arrays.triangles)} triangles")
    print(f"  settings             {', '.join(f'{k} {str(v).lower()}' for k, v in properties.items())}")
    print(f"  picks                {len(picks)} faces, in order: {' '.join(map(str, picks))}")
    print(f"  strip                {report.strip_triangles} triangles, {report.pops} taken from the search queue")
    print(f"  rounds               {report.iterations}, until: {report.stop_reason}")
    print(f"  moves of crossings   {report.moves}")
    print(f"  vertex passes        {report.vertex_passes}")
    print(f"  points               {len(line.points)}")
    print(f"  length               {report.start_length:.4f} before, {line.length:.4f} after")
    print(f"  time                 {report.seconds['total'] * 1e3:.2f} ms for the line, "
          f"{operator_seconds * 1e3:.1f} ms for the whole operator")  # fmt: skip


def main() -> None:
    """Mesh, picks, operator, report, picture, file."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--output", type=Path, required=True, help="folder for demo.blend and demo.png")
    parser.add_argument("--mesh", type=Path, help="an .obj, .ply, .stl or .off file; without it: Suzanne")
    parser.add_argument("--filter", default="CUBIC", type=str.upper, help="filter of the operator (default: cubic)")
    parser.add_argument("--width", type=int, default=1600, help="of the picture, in pixels; 4:3")
    arguments = parser.parse_args()

    enable_addon()
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    try:
        mesh_object = demo_meshes.load_mesh(arguments.mesh) if arguments.mesh else demo_meshes.add_suzanne()
    except demo_meshes.MeshFileError as error:
        sys.exit(str(error))
    if arguments.mesh:
        # These picks are hints: what nobody placed with care would only dent the line if it were pinned.
        picks, closed, pinned = demo_meshes.choose_picks(mesh_object), True, "ENDS"
    else:
        picks, closed, pinned = demo_meshes.choose_suzanne_picks(mesh_object), False, "ENDS"
    pick_faces(mesh_object, picks)

    properties = {"filter": arguments.filter, "closed": closed, "pinned": pinned}
    if arguments.filter == "CUBIC":
        # The strips of dense scans are stairs, which take a finer threshold to go.
        properties |= {"threshold": 1e-3 if arguments.mesh else 1e-2}
    diagonal = demo_meshes.measure_diagonal(mesh_object)
    start_object = add_line(filter="NONE", closed=closed, pinned=pinned, bevel=0.0012 * diagonal, name="Start")
    began = time.perf_counter()
    curve_object = add_line(**properties, name="Smooth Polyline")
    operator_seconds = time.perf_counter() - began
    print_report(mesh_object, picks, properties, operator_seconds)
    bpy.ops.object.mode_set(mode="OBJECT")

    arguments.output.mkdir(parents=True, exist_ok=True)
    print("Rendering the picture (some 10 to 30 seconds) ...", flush=True)
    if arguments.mesh:
        direction = demo_render.choose_direction(mesh_object, curve_object)
    else:
        direction = Vector(demo_meshes.SUZANNE_VIEW).normalized()
    demo_render.prepare_picture(mesh_object, curve_object, start_object, picks, direction)
    bpy.ops.wm.save_as_mainfile(filepath=str(arguments.output.resolve() / "demo.blend"), compress=True)
    demo_render.render_picture(arguments.output.resolve() / "demo.png", arguments.width)
    print(f"Wrote {arguments.output / 'demo.blend'} and {arguments.output / 'demo.png'}")
    print("  red: the smooth line; thin blue: where it started; balls: the picks, the first one green")


if __name__ == "__main__":
    main()
    sys.stdout.flush()
    # Spares the static destructors of bpy, in which some versions crash or hang.
    os._exit(0)
