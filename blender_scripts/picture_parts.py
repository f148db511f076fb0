"""Parts of pictures of meshes in pieces: colours by piece, edges as lines, the UV map as a flat mesh, view and light.

Run inside Blender. Renders nothing itself.
"""

import colorsys

import numpy as np

import bpy

import demo_render


def choose_colours(count: int) -> list[tuple[float, float, float]]:
    """Colours that neighbours in number have far apart."""
    golden = 0.61803398875
    return [
        colorsys.hsv_to_rgb((0.58 + k * golden) % 1.0, 0.42 + 0.2 * (k % 2), 0.78 - 0.14 * (k % 3))
        for k in range(count)
    ]


def paint_faces(mesh_object: bpy.types.Object, pieces: np.ndarray, colours: list[tuple[float, float, float]]) -> None:
    """A material for each piece, given to its faces."""
    mesh = mesh_object.data
    mesh.materials.clear()
    for number, colour in enumerate(colours):
        mesh.materials.append(demo_render.make_material(f"Piece {number}", colour))
    mesh.polygons.foreach_set("material_index", np.asarray(pieces, dtype=np.int32))
    mesh.polygons.foreach_set("use_smooth", np.ones(len(mesh.polygons), dtype=bool))
    mesh.update()


def add_edges(
    mesh_object: bpy.types.Object, edges: np.ndarray, radius: float, colour: tuple[float, float, float]
) -> bpy.types.Object:
    """Edges of a mesh as tubes."""
    curve = bpy.data.curves.new("Edges", "CURVE")
    curve.dimensions, curve.bevel_depth, curve.use_fill_caps = "3D", radius, True
    mesh = mesh_object.data
    for edge in np.asarray(edges).tolist():
        spline = curve.splines.new("POLY")
        spline.points.add(1)
        for point, vertex in zip(spline.points, mesh.edges[edge].vertices, strict=True):
            point.co = (*mesh.vertices[vertex].co, 1.0)
    tubes = bpy.data.objects.new("Edges", curve)
    tubes.matrix_world = mesh_object.matrix_world
    bpy.context.scene.collection.objects.link(tubes)
    demo_render.paint(tubes, demo_render.make_material("Edges", colour))
    return tubes


def add_uv_chart(
    mesh_object: bpy.types.Object, pieces: np.ndarray, colours: list[tuple[float, float, float]], is_shown: np.ndarray
) -> bpy.types.Object:
    """The active UV map as a flat mesh, a vertex a corner, in the same colours; only pieces that are shown."""
    mesh = mesh_object.data
    uvs = np.empty(len(mesh.loops) * 2, dtype=np.float32)
    mesh.uv_layers.active.uv.foreach_get("vector", uvs)
    positions = np.column_stack([uvs.reshape(-1, 2), np.zeros(len(mesh.loops))])
    chart_mesh = bpy.data.meshes.new("Chart")
    shown = np.flatnonzero(is_shown[pieces])
    corners = [list(mesh.polygons[face].loop_indices) for face in shown.tolist()]
    used = sorted({corner for polygon in corners for corner in polygon})
    number = {corner: row for row, corner in enumerate(used)}
    chart_mesh.from_pydata(positions[used].tolist(), [], [[number[c] for c in polygon] for polygon in corners])
    chart = bpy.data.objects.new("Chart", chart_mesh)
    bpy.context.scene.collection.objects.link(chart)
    paint_faces(chart, pieces[shown], colours)
    return chart


def look_down_on(chart: bpy.types.Object) -> None:
    """Turn the camera so that it looks straight down on a flat mesh, all of it in view."""
    camera = bpy.context.scene.camera
    corners = np.array(chart.bound_box)
    middle, spans = corners.mean(axis=0), np.ptp(corners, axis=0)
    camera.data.type = "ORTHO"
    camera.data.ortho_scale = 1.06 * max(float(spans[0]), 4 / 3 * float(spans[1]))
    camera.location = (*middle[:2], 10.0)
    camera.rotation_euler = (0.0, 0.0, 0.0)
    camera.data.clip_end = 100.0
