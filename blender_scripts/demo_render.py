"""How the demo's picture looks: materials, marks of the picks, light, and the view that shows most of the line.

Run by `demo`, inside Blender. Adds objects to the scene for the picture; changes neither mesh nor curves.
"""

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

import bpy

from mathutils import Vector
from mathutils.bvhtree import BVHTree

# Above this the drawn edges would cover the surface.
MOST_FACES_WITH_EDGES = 40_000
# All light but the sun's is painted on, so there is nothing to be denoised and samples only smooth the outlines.
SAMPLES = 8
# Part of the light that comes from the viewer, where the sun does not reach.
HEADLIGHT = 0.6


def prepare_picture(
    mesh_object: bpy.types.Object,
    curve_object: bpy.types.Object,
    start_object: bpy.types.Object,
    picks: list[int],
    direction: Vector,
) -> None:
    """Materials, marks, light and camera; `direction` is from the mesh towards the camera, in the world."""
    centre, radius = measure_ball(mesh_object)
    paint(
        mesh_object,
        make_material(
            "Surface", (0.60, 0.61, 0.62), draws_edges=len(mesh_object.data.polygons) <= MOST_FACES_WITH_EDGES
        ),
    )
    paint(curve_object, make_material("Line", (0.80, 0.03, 0.06)))
    paint(start_object, make_material("Start", (0.03, 0.12, 0.55)))
    mark_picks(mesh_object, picks, 0.013 * radius)

    set_up_view(direction, centre, radius)
    mesh_object.data.polygons.foreach_set("use_smooth", np.ones(len(mesh_object.data.polygons), dtype=bool))


def set_up_view(direction: Vector, centre: Vector, radius: float) -> None:
    """Camera and light for a ball in the world; `direction` is from it towards the camera."""
    scene = bpy.context.scene
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.data.lens = 70
    camera.location = centre + direction * radius * 3.9
    camera.rotation_euler = direction.to_track_quat("Z", "Y").to_euler()
    camera.data.clip_start, camera.data.clip_end = 0.01 * radius, 20 * radius
    scene.camera = camera
    light = bpy.data.objects.new("Sun", bpy.data.lights.new("Sun", "SUN"))
    light.data.energy, light.data.angle = 2.6, 0.0
    light.rotation_euler = (
        (camera.rotation_euler.to_matrix() @ Vector((-0.5, 0.7, 1.0))).to_track_quat("Z", "Y").to_euler()
    )
    scene.collection.objects.link(camera)
    scene.collection.objects.link(light)
    scene.world = bpy.data.worlds.new("World")
    scene.world.color = (0.72, 0.77, 0.83)
    scene.world.cycles_visibility.diffuse = False  # seen, but no light: it would have to be sampled


def measure_ball(mesh_object: bpy.types.Object) -> tuple[Vector, float]:
    """Centre and radius of a ball round the object, in the world."""
    corners = [mesh_object.matrix_world @ Vector(corner) for corner in mesh_object.bound_box]
    centre = sum(corners, Vector()) / len(corners)
    return centre, max((corner - centre).length for corner in corners)


def make_material(name: str, colour: tuple[float, float, float], *, draws_edges: bool = False) -> bpy.types.Material:
    """A plain material; with `draws_edges` the triangles' edges show as fine darker lines."""
    material = bpy.data.materials.new(name)
    if material.node_tree is None:  # since Blender 5.0 it is always there, and the switch is deprecated
        material.use_nodes = True
    material.diffuse_color = (*colour, 1)
    nodes, links = material.node_tree.nodes, material.node_tree.links
    colours = nodes.new("ShaderNodeMixRGB")
    colours.inputs["Fac"].default_value = 0.0
    colours.inputs["Color1"].default_value = (*colour, 1)
    colours.inputs["Color2"].default_value = (*(0.5 * c for c in colour), 1)
    if draws_edges:
        wire = nodes.new("ShaderNodeWireframe")
        wire.use_pixel_size = True
        wire.inputs["Size"].default_value = 0.6
        links.new(wire.outputs["Fac"], colours.inputs["Fac"])
    # 1 where the surface looks at the viewer, 0 at its outline.
    facing = nodes.new("ShaderNodeLayerWeight")
    facing.inputs["Blend"].default_value = 0.5
    towards_viewer = nodes.new("ShaderNodeMapRange")
    towards_viewer.inputs["To Min"].default_value = HEADLIGHT
    towards_viewer.inputs["To Max"].default_value = 0.15
    links.new(facing.outputs["Facing"], towards_viewer.inputs["Value"])
    headlight, diffuse, both = (
        nodes.new(f"Shader{kind}") for kind in ("NodeEmission", "NodeBsdfDiffuse", "NodeAddShader")
    )
    links.new(colours.outputs["Color"], headlight.inputs["Color"])
    links.new(towards_viewer.outputs["Result"], headlight.inputs["Strength"])
    links.new(colours.outputs["Color"], diffuse.inputs["Color"])
    links.new(headlight.outputs["Emission"], both.inputs[0])
    links.new(diffuse.outputs["BSDF"], both.inputs[1])
    links.new(both.outputs["Shader"], nodes["Material Output"].inputs["Surface"])
    return material


def paint(painted: bpy.types.Object, material: bpy.types.Material) -> None:
    """Give the object this material alone."""
    painted.data.materials.clear()
    painted.data.materials.append(material)


def mark_picks(mesh_object: bpy.types.Object, picks: list[int], radius: float) -> None:
    """A small ball on each picked face; the first is green."""
    first, other = make_material("First Pick", (0.05, 0.55, 0.10)), make_material("Pick", (0.95, 0.75, 0.05))
    for number, face in enumerate(picks):
        bpy.ops.mesh.primitive_uv_sphere_add(
            radius=radius * (1.5 if number == 0 else 1.2),
            location=mesh_object.matrix_world @ mesh_object.data.polygons[face].center,
        )
        ball = bpy.context.object
        ball.name = f"Pick {number}"
        bpy.ops.object.shade_smooth()
        paint(ball, first if number == 0 else other)


def choose_direction(mesh_object: bpy.types.Object, curve_object: bpy.types.Object) -> Vector:
    """Towards the camera, in the world: the direction, not from below, that sees most of the line."""
    tree = BVHTree.FromObject(mesh_object, bpy.context.evaluated_depsgraph_get())
    points = curve_object.data.splines[0].points
    samples = [points[i].co.xyz for i in range(0, len(points), max(1, len(points) // 150))]
    to_local = mesh_object.matrix_world.inverted().to_3x3()
    _, radius = measure_ball(mesh_object)
    best_count, best = -1, Vector((0, -1, 0))
    for height in (0.15, 0.35, 0.6, 0.9):
        for turn in range(16):
            angle = np.pi * (turn - 4) / 8 + 0.25
            direction = Vector((np.cos(angle), np.sin(angle), height)).normalized()
            local = (to_local @ direction).normalized()
            lift = local * 0.02 * radius
            count = sum(tree.ray_cast(sample + lift, local)[0] is None for sample in samples)
            if count > best_count:
                best_count, best = count, direction
    return best


def render_picture(path: Path, width: int) -> None:
    """Render with Cycles on the processor: it needs no graphics card and no window."""
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.device = "CPU"
    scene.cycles.samples = SAMPLES
    scene.cycles.use_denoising = False
    scene.cycles.use_adaptive_sampling = False
    scene.cycles.max_bounces = 0
    scene.cycles.seed = 1
    scene.view_settings.view_transform = "Standard"
    scene.render.resolution_x, scene.render.resolution_y = width, width * 3 // 4
    scene.render.image_settings.file_format = "PNG"
    scene.render.image_settings.color_mode = "RGB"
    scene.render.image_settings.compression = 30
    scene.render.dither_intensity = 0.0
    scene.render.filepath = str(path)
    with silence_blender():
        bpy.ops.render.render(write_still=True)


@contextmanager
def silence_blender() -> Iterator[None]:
    """Keep Blender's own lines of progress, hundreds in a render, from the terminal; errors are still seen."""
    sys.stdout.flush()
    terminal = os.dup(1)
    nowhere = os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(nowhere, 1)
        yield
    finally:
        os.dup2(terminal, 1)
        os.close(nowhere)
        os.close(terminal)
