"""Curves follow their mesh in renders: an animation is rendered without a window, and the pictures are looked at."""

import numpy as np
import pytest

import bpy

from blender_scenes import SUZANNE_PICKS

SIZE = 48


@pytest.fixture
def stage(scene):
    """A black head in front of a camera, on a black background, which a shape key moves aside over frames 1 to 9."""
    from bl_ext.user_default.smooth_polylines import session

    bpy.ops.mesh.primitive_monkey_add()
    head = bpy.context.object
    head.shape_key_add(name="Basis")
    key = head.shape_key_add(name="Aside")
    for point in key.data:
        point.co.x += 1.5
    for frame, value in ((1, 0.0), (9, 1.0)):
        key.value = value
        key.keyframe_insert("value", frame=frame)
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.location, camera.rotation_euler = (0.75, -6.0, 0.3), (np.pi / 2, 0, 0)
    camera.data.type, camera.data.ortho_scale = "ORTHO", 4.0
    scene.collection.objects.link(camera)
    scene.camera = camera
    make_material("Black", 0.0, head.data)
    make_material("White", 1.0, None)
    scene.frame_set(1)
    scene.world = None
    scene.render.engine = "CYCLES"
    scene.cycles.samples, scene.cycles.use_denoising = 4, False
    scene.render.resolution_x = scene.render.resolution_y = SIZE
    scene.render.image_settings.file_format = "PNG"
    return session, head


def make_material(name, strength, mesh):
    material = bpy.data.materials.new(name)
    if material.node_tree is None:  # since Blender 5.0 it is always there, and the switch is deprecated
        material.use_nodes = True
    nodes = material.node_tree.nodes
    nodes.clear()
    emission, output = nodes.new("ShaderNodeEmission"), nodes.new("ShaderNodeOutputMaterial")
    emission.inputs["Strength"].default_value = strength
    material.node_tree.links.new(emission.outputs[0], output.inputs[0])
    if mesh is not None:
        mesh.materials.append(material)


def find_bright(path):
    """Middle of the bright pixels from left to right, 0 to 1, and how many there are."""
    image = bpy.data.images.load(str(path))
    pixels = np.array(image.pixels[:]).reshape(SIZE, SIZE, 4)[:, :, 0]
    bpy.data.images.remove(image)
    _, columns = np.nonzero(pixels > 0.3)
    return columns.mean() / SIZE if len(columns) else None, len(columns)


def test_an_animation_shows_the_curve_on_the_mesh_in_every_frame(stage, tmp_path):
    session, head = stage
    session.add_polyline(
        bpy.context, head, SUZANNE_PICKS, filter="fair", pinned="all", bevel=0.05, offset=0.03, material="White"
    )
    scene = bpy.context.scene
    scene.render.filepath = str(tmp_path / "frame_")
    scene.frame_start, scene.frame_end, scene.frame_step = 1, 9, 4
    bpy.ops.render.render(animation=True)
    found = [find_bright(tmp_path / f"frame_{frame:04d}.png") for frame in (1, 5, 9)]
    assert min(count for _, count in found) > 15, found
    # The camera shows 4 units; the key moves by 1.5, half of it at frame 5.
    middles = np.array([middle for middle, _ in found])
    np.testing.assert_allclose(np.diff(middles), [0.75 / 4, 0.75 / 4], atol=0.03)
