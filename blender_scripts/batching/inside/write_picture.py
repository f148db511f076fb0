"""A picture of the lines of a file on its meshes, from a side that sees them, by Blender on the processor.

Changes the scene that is open: comes after everything else. Has no say in what is made.
"""

import struct
from pathlib import Path
from typing import Any

import numpy as np

import bpy

from mathutils import Vector

import demo_render

from .fault import FileFault
from .make_lines import MadeLine
from .open_input import clean

SAMPLES = 4
# Radius of the lines, as a part of the meshes' bounding-box diagonal.
LINE_PART = 0.004
# Towards the camera where the lines look to all sides alike.
USUAL_DIRECTION = (0.5, -1.0, 0.6)
SURFACE_COLOUR, LINE_COLOUR, GROUND_COLOUR = (0.60, 0.61, 0.62), (0.80, 0.03, 0.06), (0.93, 0.93, 0.93)
# Pieces of a PNG that tell when and where it was made.
TOLD_PIECES = (b"tEXt", b"zTXt", b"iTXt", b"tIME", b"eXIf")


def write_picture(path: Path, lines: list[MadeLine], preview: dict[str, Any]) -> None:
    """Render the objects that have lines, and the lines, into a PNG; FileFault when Blender cannot."""
    scene = bpy.data.scenes.new("Preview")
    context = {"scene": scene, "view_layer": scene.view_layers[0]}
    surface = demo_render.make_material("Preview Surface", SURFACE_COLOUR)
    tube = demo_render.make_material("Preview Line", LINE_COLOUR)
    corners = [
        each.mesh_object.matrix_world @ Vector(corner) for each in lines for corner in each.mesh_object.bound_box
    ]
    low, high = np.min(corners, axis=0), np.max(corners, axis=0)
    diagonal = float(np.linalg.norm(high - low)) or 1.0
    for mesh_object in dict.fromkeys(each.mesh_object for each in lines):
        link_copy(scene, mesh_object, surface)
    for made in lines:
        link_line(scene, made, LINE_PART * diagonal, tube)
    place_camera(scene, lines, Vector((low + high) / 2), diagonal, preview["size"])
    set_up_render(scene, preview, path)
    try:
        with bpy.context.temp_override(**context):
            bpy.ops.render.render(write_still=True, scene=scene.name)
    except RuntimeError as error:
        raise FileFault("OutputError", f"Blender cannot render the picture: {clean(error)}") from error
    path.write_bytes(strip_told(path.read_bytes()))


def link_copy(scene: bpy.types.Scene, mesh_object: bpy.types.Object, material: bpy.types.Material) -> None:
    """The object as its modifiers leave it, in one plain material."""
    evaluated = mesh_object.evaluated_get(bpy.context.evaluated_depsgraph_get())
    mesh = bpy.data.meshes.new_from_object(evaluated)
    mesh.materials.clear()
    mesh.materials.append(material)
    mesh.polygons.foreach_set("material_index", np.zeros(len(mesh.polygons), dtype=np.int32))
    copy = bpy.data.objects.new("Preview", mesh)
    copy.matrix_world = mesh_object.matrix_world
    scene.collection.objects.link(copy)


def link_line(scene: bpy.types.Scene, made: MadeLine, radius: float, material: bpy.types.Material) -> None:
    """The line as a tube in world space."""
    line = made.computed.line
    curve = bpy.data.curves.new("Preview", "CURVE")
    curve.dimensions, curve.bevel_depth, curve.use_fill_caps = "3D", radius, True
    spline = curve.splines.new("POLY")
    spline.points.add(len(line.points) - 1)
    coordinates = np.ones((len(line.points), 4), dtype=np.float32)
    coordinates[:, :3] = line.points
    spline.points.foreach_set("co", coordinates.ravel())
    spline.use_cyclic_u = line.closed
    curve.materials.append(material)
    scene.collection.objects.link(bpy.data.objects.new("Preview", curve))


def choose_direction(lines: list[MadeLine]) -> Vector:
    """Towards the camera: where the faces that the lines cross look on the whole, never straight from above."""
    total = np.zeros(3)
    for made in lines:
        line, arrays = made.computed.line, made.computed.arrays
        corners = arrays.world_positions[arrays.triangles[line.triangles]]
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        lengths = np.linalg.norm(normals, axis=1)
        total += (normals[lengths > 0] / lengths[lengths > 0, None]).sum(axis=0)
    count = sum(len(made.computed.line.points) for made in lines)
    usual = Vector(USUAL_DIRECTION).normalized()
    if np.linalg.norm(total) < 0.2 * count:
        return usual
    return (Vector(total / np.linalg.norm(total)) + 0.25 * usual).normalized()


def place_camera(
    scene: bpy.types.Scene, lines: list[MadeLine], centre: Vector, diagonal: float, size: list[int]
) -> None:
    """Without perspective, so that everything is in the picture from any side; a sun beside the camera."""
    direction = choose_direction(lines)
    camera = bpy.data.objects.new("Preview", bpy.data.cameras.new("Preview"))
    camera.data.type = "ORTHO"
    camera.data.ortho_scale = 1.05 * diagonal * max(1.0, size[0] / size[1])
    camera.data.clip_start, camera.data.clip_end = 0.01 * diagonal, 10 * diagonal
    camera.location = centre + 3 * diagonal * direction
    camera.rotation_euler = direction.to_track_quat("Z", "Y").to_euler()
    sun = bpy.data.objects.new("Preview", bpy.data.lights.new("Preview", "SUN"))
    sun.data.energy, sun.data.angle = 2.6, 0.0
    above = camera.rotation_euler.to_matrix() @ Vector((-0.5, 0.7, 1.0))
    sun.rotation_euler = above.to_track_quat("Z", "Y").to_euler()
    scene.collection.objects.link(camera)
    scene.collection.objects.link(sun)
    scene.camera = camera
    scene.world = bpy.data.worlds.new("Preview")
    scene.world.color = GROUND_COLOUR
    scene.world.cycles_visibility.diffuse = False


def set_up_render(scene: bpy.types.Scene, preview: dict[str, Any], path: Path) -> None:
    """The same picture each time, on any machine with this Blender and engine."""
    render = scene.render
    if preview["engine"] == "cycles":
        render.engine = "CYCLES"
        scene.cycles.device, scene.cycles.samples, scene.cycles.seed = "CPU", SAMPLES, 1
        scene.cycles.use_denoising = scene.cycles.use_adaptive_sampling = False
        scene.cycles.max_bounces = 0
    else:
        render.engine = "BLENDER_WORKBENCH"
        scene.display.shading.color_type = "MATERIAL"
    scene.view_settings.view_transform = "Standard"
    render.resolution_x, render.resolution_y = preview["size"]
    render.resolution_percentage = 100
    render.image_settings.file_format, render.image_settings.color_mode = "PNG", "RGB"
    render.image_settings.compression = 30
    render.dither_intensity = 0.0
    render.use_file_extension = False
    render.filepath = str(path)


def strip_told(data: bytes) -> bytes:
    """A PNG without what Blender tells in it of times and machines."""
    kept, at = [data[:8]], 8
    while at + 12 <= len(data):
        (length,) = struct.unpack_from(">I", data, at)
        if data[at + 4 : at + 8] not in TOLD_PIECES:
            kept.append(data[at : at + 12 + length])
        at += 12 + length
    return b"".join(kept)
