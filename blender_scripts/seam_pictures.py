"""Pictures of the guide to seams: a shirt on a figure, cut and unwrapped; its islands in space and on the UV map.

    python blender_scripts/seam_pictures.py --output out/images

Enables the add-on, draws lines round sleeves, neck and waist, puts them into the mesh as seams, unwraps and renders.
Not imported by the add-on or the tests.
"""

import argparse
import os
import sys
from pathlib import Path

import numpy as np

import demo  # isort: skip  (before bpy: it sets up an empty profile)

import bpy

from mathutils import Vector

import demo_render
import figure_mesh
import picture_parts

RING_PICKS = 16
# Rings of the shirt: a point inside, and the direction that the ring goes round.
RINGS = {
    "armhole left": ((0.19, 0.0, 1.40), (1.0, 0.0, 0.35)),
    "armhole right": ((-0.19, 0.0, 1.40), (-1.0, 0.0, 0.35)),
    "cuff left": ((0.64, 0.0, 1.41), (1.0, 0.0, 0.0)),
    "cuff right": ((-0.64, 0.0, 1.41), (1.0, 0.0, 0.0)),
    "neck": ((0.0, 0.0, 1.49), (0.0, -0.35, 1.0)),
    "waist": ((0.0, 0.0, 1.02), (0.0, 0.0, 1.0)),
}
# Seams between two rings: where on each they begin and end, as the furthest point in a direction.
JOINS = [
    ("armhole left", (0, 0, -1), "cuff left", (0, 0, -1)),
    ("armhole right", (0, 0, -1), "cuff right", (0, 0, -1)),
    ("armhole left", (0, 0, -1), "waist", (1, 0, 0)),
    ("armhole right", (0, 0, -1), "waist", (-1, 0, 0)),
    ("neck", (1, 0, 0), "armhole left", (0, 0, 1)),
    ("neck", (-1, 0, 0), "armhole right", (0, 0, 1)),
]
SURFACE = (0.62, 0.63, 0.64)
FLAT_STRETCH = 1.05


def make_lines(figure: bpy.types.Object, opened: object) -> list[object]:
    """The library's lines of the shirt, in world space; the figure's own space is the same."""
    mesh = opened.library_mesh
    rings = {}
    for name, (inside, around) in RINGS.items():
        picks = mesh.closest_points(cast_ring(figure, Vector(inside), Vector(around))).surface_points
        rings[name] = mesh.polyline(picks, closed=True, filter="fair", detail_size=0.03)
    lines = list(rings.values())
    for first, from_direction, second, to_direction in JOINS:
        ends = [pick_furthest(rings[first], from_direction), pick_furthest(rings[second], to_direction)]
        lines.append(mesh.polyline(ends, filter="geodesic"))
    return lines


def cast_ring(figure: bpy.types.Object, inside: Vector, around: Vector) -> np.ndarray:
    """Points of the surface all around a point inside it, in a plane."""
    side = around.orthogonal().normalized()
    other = around.normalized().cross(side)
    points = []
    for angle in np.arange(RING_PICKS) * 2 * np.pi / RING_PICKS:
        is_hit, place, _, _ = figure.ray_cast(inside, float(np.cos(angle)) * side + float(np.sin(angle)) * other)
        if is_hit:
            points.append(tuple(place))
    return np.array(points)


def pick_furthest(line: object, direction: tuple[float, float, float]) -> tuple[int, list[float]]:
    """The point of a line that lies furthest in a direction, as a pick."""
    index = int(np.argmax(line.points @ np.array(direction, dtype=np.float64)))
    return int(line.triangles[index]), line.barycentric[index].tolist()


def main() -> None:
    """The figure, its shirt, two pictures."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--output", type=Path, required=True, help="folder for the pictures")
    parser.add_argument("--width", type=int, default=960, help="of a picture, in pixels; 4:3")
    arguments = parser.parse_args()

    demo.enable_addon()
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    from bl_ext.user_default.smooth_polylines import surface
    from bl_ext.user_default.smooth_polylines.seams import put, report

    figure = figure_mesh.add_figure()
    opened = surface.open_surface(bpy.context, figure)
    lines = make_lines(figure, opened)
    done = put.put_lines_into_mesh(bpy.context, figure, lines, method="CUT", unwrap=True)
    print(report.describe(done)[0])
    for row in report.list_islands(done.islands):
        print(" ", row)

    arguments.output.mkdir(parents=True, exist_ok=True)
    # The shirt's pieces can be flattened; head, hands and hips stay grey and are left out of the chart.
    is_flat = [island.angle_stretch < FLAT_STRETCH for island in done.islands.islands]
    colours = [
        colour if flat else SURFACE
        for colour, flat in zip(picture_parts.choose_colours(len(is_flat)), is_flat, strict=True)
    ]
    seams = picture_parts.add_edges(figure, done.edges, 0.004, (0.75, 0.03, 0.05))
    picture_parts.paint_faces(figure, done.islands.face_islands, colours)
    chart = picture_parts.add_uv_chart(figure, done.islands.face_islands, colours, np.array(is_flat))
    chart.hide_render = True
    demo_render.set_up_view(Vector((0.45, -1.0, 0.22)).normalized(), Vector((0.0, 0.0, 1.24)), 0.85)
    demo_render.render_picture(arguments.output.resolve() / "seams_shirt.png", arguments.width)
    figure.hide_render = seams.hide_render = True
    chart.hide_render = False
    picture_parts.look_down_on(chart)
    demo_render.render_picture(arguments.output.resolve() / "seams_islands.png", arguments.width)
    print(f"Wrote seams_shirt.png and seams_islands.png to {arguments.output}")


if __name__ == "__main__":
    main()
    sys.stdout.flush()
    # Spares the static destructors of bpy, in which some versions crash or hang.
    os._exit(0)
