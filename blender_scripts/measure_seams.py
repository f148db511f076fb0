"""How long Put Lines into Mesh takes on a mesh of a million triangles, and how much memory: a table, printed.

    python blender_scripts/measure_seams.py [--mesh scan.ply]

Each method runs in a process of its own, in Object Mode and in Edit Mode, on a mesh that was opened before, as after
the line has been drawn. Not imported by the add-on or the tests.
"""

import argparse
import os
import resource
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

import demo  # isort: skip  (before bpy: it sets up an empty profile)

import bpy

import demo_meshes

SIDE = 707  # quads of two triangles along the side of the sheet: a million triangles
CROSSINGS = 2000
METHODS = ("SNAP", "SLIDE", "CUT")


def add_sheet() -> bpy.types.Object:
    """A wavy sheet of triangles with a UV map."""
    steps = np.arange(SIDE + 1, dtype=np.float32)
    x, y = np.meshgrid(steps, steps)
    corner = (np.arange(SIDE)[:, None] * (SIDE + 1) + np.arange(SIDE)).ravel()
    triangles = np.concatenate(
        [
            np.column_stack([corner, corner + 1, corner + SIDE + 2]),
            np.column_stack([corner, corner + SIDE + 2, corner + SIDE + 1]),
        ]
    ).astype(np.int32)
    mesh = bpy.data.meshes.new("Sheet")
    mesh.vertices.add(x.size)
    mesh.vertices.foreach_set("co", np.column_stack([x.ravel(), y.ravel(), 20 * np.sin(x.ravel() / 50)]).ravel())
    mesh.loops.add(triangles.size)
    mesh.loops.foreach_set("vertex_index", triangles.ravel())
    mesh.polygons.add(len(triangles))
    mesh.polygons.foreach_set("loop_start", np.arange(len(triangles), dtype=np.int32) * 3)
    mesh.update(calc_edges=True)
    mesh.uv_layers.new(name="UVMap")
    sheet = bpy.data.objects.new("Sheet", mesh)
    bpy.context.scene.collection.objects.link(sheet)
    return sheet


def make_line(opened: object) -> object:
    """A geodesic between random faces with about as many crossings as wanted."""
    random = np.random.default_rng(3)
    faces = np.unique(opened.arrays.triangle_faces)
    picks = [int(random.choice(faces)), int(random.choice(faces))]
    while True:
        line = opened.library_mesh.polyline(picks, filter="geodesic", pinned="all")
        if len(line.points) >= CROSSINGS:
            return line
        picks.append(int(random.choice(faces)))


def measure(method: str, is_editing: bool, path: Path | None) -> str:
    """One row of the table."""
    demo.enable_addon()
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    from bl_ext.user_default.smooth_polylines import surface
    from bl_ext.user_default.smooth_polylines.seams import put

    mesh_object = add_sheet() if path is None else demo_meshes.load_mesh(path)
    bpy.context.view_layer.objects.active = mesh_object
    if is_editing:
        bpy.ops.object.mode_set(mode="EDIT")
    bpy.context.view_layer.update()
    opened = surface.open_surface(bpy.context, mesh_object)
    line = make_line(opened)
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    wall, cpu = time.perf_counter(), time.process_time()
    put.put_lines_into_mesh(bpy.context, mesh_object, [line], method=method)
    wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - memory
    return (
        f"| {bpy.app.version_string} | {method.title()} | {'Edit' if is_editing else 'Object'} | "
        f"{len(opened.arrays.triangles)} | {len(line.points)} | {wall:.2f} | {cpu:.2f} | {memory / 1024:.0f} |"
    )


def main() -> None:
    """The table; with --row one row of it."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--mesh", type=Path, help="an .obj, .ply, .stl or .off file; without it: a sheet")
    parser.add_argument("--row", nargs=2, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.row:
        print(measure(arguments.row[0], arguments.row[1] == "EDIT", arguments.mesh))
        return
    print("| Blender | method | mode | triangles | points | s, wall | s, CPU | MB more at the peak |")
    print("|---|---|---|---|---|---|---|---|", flush=True)
    for method in METHODS:
        for mode in ("OBJECT", "EDIT"):
            command = [sys.executable, __file__, "--row", method, mode]
            command += ["--mesh", str(arguments.mesh)] if arguments.mesh else []
            done = subprocess.run(command, capture_output=True, text=True, check=False)
            rows = [row for row in done.stdout.splitlines() if row.startswith("|")]
            print(rows[-1] if rows else f"{method} failed: {done.stderr[-500:]}", flush=True)


if __name__ == "__main__":
    main()
    sys.stdout.flush()
    # Spares the static destructors of bpy, in which some versions crash or hang.
    os._exit(0)
