"""The paper's figure 18 in Blender: a net of 19 lines between 10 picks, cut into a scan, a colour for each patch.

    python blender_scripts/net_picture.py --mesh igea.ply --output docs/images

The picks are spread over what the camera sees; neighbours are joined, without the longest lines, which go round the
back. Not imported by the add-on or the tests.
"""

import argparse
import os
import sys
import time
from pathlib import Path

import numpy as np

import demo  # isort: skip  (before bpy: it sets up an empty profile)

import bpy

from mathutils import Vector

import demo_meshes
import demo_render
import picture_parts

PICKS, LINES = 10, 19
# Picks lie where the surface faces the camera by more than this cosine.
FACING = 0.35
OUTSIDE = (0.62, 0.63, 0.64)


def choose_picks(mesh_object: bpy.types.Object, direction: Vector) -> list[int]:
    """Faces far from each other among those that face the camera."""
    mesh = mesh_object.data
    centres, faces = demo_meshes.read_main_part(mesh_object)
    normals = np.empty(len(mesh.polygons) * 3, dtype=np.float32)
    mesh.polygons.foreach_get("normal", normals)
    local = np.array(mesh_object.matrix_world.to_3x3().inverted() @ direction)
    towards = centres[faces] @ local
    is_seen = (normals.reshape(-1, 3)[faces] @ local > FACING) & (towards > np.median(towards))
    candidates = faces[is_seen]
    points = centres[candidates]
    picked = [int(np.linalg.norm(points - points.mean(axis=0), axis=1).argmin())]
    distances = np.full(len(points), np.inf)
    while len(picked) < PICKS:
        distances = np.minimum(distances, np.linalg.norm(points - points[picked[-1]], axis=1))
        picked.append(int(distances.argmax()))
    return candidates[picked].tolist()


def choose_connections(mesh_object: bpy.types.Object, picks: list[int]) -> np.ndarray:
    """The shortest lines of the automatic net."""
    from bl_ext.user_default.smooth_polylines import surface

    mesh = surface.open_surface(bpy.context, mesh_object).library_mesh
    net = mesh.network(picks, "automatic", filter="linear")
    lengths = np.array([line.length for line in net.lines])
    return np.array(net.connections)[np.sort(np.argsort(lengths, kind="stable")[:LINES])]


def main() -> None:
    """Mesh, picks, net, picture."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--mesh", type=Path, required=True, help="an .obj, .ply, .stl or .off file")
    parser.add_argument("--output", type=Path, required=True, help="folder for net.png")
    parser.add_argument("--width", type=int, default=960, help="of the picture, in pixels; 4:3")
    arguments = parser.parse_args()

    demo.enable_addon()
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    from bl_ext.user_default.smooth_polylines.seams import nets, report

    try:
        mesh_object = demo_meshes.load_mesh(arguments.mesh)
    except demo_meshes.MeshFileError as error:
        sys.exit(str(error))
    bpy.context.view_layer.update()
    direction = Vector((0.25, -1.0, 0.1)).normalized()
    picks = choose_picks(mesh_object, direction)
    connections = choose_connections(mesh_object, picks)
    radius = demo_render.measure_ball(mesh_object)[1]
    demo_render.mark_picks(mesh_object, picks, 0.011 * radius)
    began = time.perf_counter()
    done = nets.put_net_into_mesh(
        bpy.context, mesh_object, picks, connections=connections, filter="linear", avoid_crossings=True
    )
    print(f"{report.describe_net(done)[0]}; {len(mesh_object.data.polygons)} faces, "
          f"{done.lines.new_vertices} new vertices, {time.perf_counter() - began:.1f} s")  # fmt: skip
    for row in report.list_sides(done.sides):
        print(" ", row)

    sizes = np.bincount(done.face_patches)
    colours = picture_parts.choose_colours(len(sizes))
    colours[int(sizes.argmax())] = OUTSIDE
    picture_parts.paint_faces(mesh_object, done.face_patches, colours)
    picture_parts.add_edges(mesh_object, done.lines.edges, 0.003 * radius, (0.02, 0.02, 0.03))
    demo_render.set_up_view(direction, *demo_render.measure_ball(mesh_object))
    arguments.output.mkdir(parents=True, exist_ok=True)
    demo_render.render_picture(arguments.output.resolve() / "net.png", arguments.width)
    print(f"Wrote {arguments.output / 'net.png'}")


if __name__ == "__main__":
    main()
    sys.stdout.flush()
    # Spares the static destructors of bpy, in which some versions crash or hang.
    os._exit(0)
