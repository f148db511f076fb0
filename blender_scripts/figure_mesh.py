"""A figure of a person in a T pose, made by rule, for pictures and tests of seams. Run inside Blender.

Quads throughout: a body of boxes grown by the Skin modifier and rounded by Subdivision. Draws and writes nothing.
"""

import bpy

# Joints: where, the radii of the skin (across, along the depth), and the joint that each hangs on.
JOINTS = {
    "hips": ((0.0, 0.0, 0.98), (0.165, 0.115), None),
    "waist": ((0.0, 0.0, 1.14), (0.135, 0.10), "hips"),
    "chest": ((0.0, 0.0, 1.34), (0.165, 0.115), "waist"),
    "neck": ((0.0, 0.0, 1.50), (0.062, 0.062), "chest"),
    "chin": ((0.0, -0.01, 1.60), (0.075, 0.085), "neck"),
    "head": ((0.0, -0.01, 1.74), (0.095, 0.11), "chin"),
    "shoulder": ((0.20, 0.0, 1.41), (0.078, 0.078), "chest"),
    "elbow": ((0.46, 0.01, 1.41), (0.055, 0.055), "shoulder"),
    "wrist": ((0.70, 0.0, 1.41), (0.04, 0.045), "elbow"),
    "hand": ((0.80, 0.0, 1.41), (0.03, 0.055), "wrist"),
    "thigh": ((0.10, 0.0, 0.84), (0.10, 0.10), "hips"),
    "knee": ((0.11, 0.0, 0.50), (0.068, 0.068), "thigh"),
    "ankle": ((0.12, 0.02, 0.10), (0.05, 0.05), "knee"),
    "toes": ((0.125, -0.14, 0.04), (0.045, 0.03), "ankle"),
}
PAIRED = {"shoulder", "elbow", "wrist", "hand", "thigh", "knee", "ankle", "toes"}


def add_figure(subdivisions: int = 3) -> bpy.types.Object:
    """The figure, standing on the ground and facing -Y; the active object."""
    positions, radii, edges, number = [], [], [], {}
    for name, (place, radius, parent) in JOINTS.items():
        for side in (1, -1) if name in PAIRED else (1,):
            number[name, side] = len(positions)
            positions.append((side * place[0], place[1], place[2]))
            radii.append(radius)
            if parent is not None:
                holder = (parent, side) if parent in PAIRED else (parent, 1)
                edges.append((number[holder], number[name, side]))
    mesh = bpy.data.meshes.new("Figure")
    mesh.from_pydata(positions, edges, [])
    figure = bpy.data.objects.new("Figure", mesh)
    bpy.context.scene.collection.objects.link(figure)
    bpy.context.view_layer.objects.active = figure
    figure.select_set(True)
    skin = figure.modifiers.new("Skin", "SKIN")
    skin.use_smooth_shade = True
    for vertex, radius in zip(mesh.skin_vertices[0].data, radii, strict=True):
        vertex.radius = radius
    mesh.skin_vertices[0].data[number["hips", 1]].use_root = True
    subdivision = figure.modifiers.new("Subdivision", "SUBSURF")
    subdivision.levels = subdivisions
    for modifier in (skin.name, subdivision.name):
        bpy.ops.object.modifier_apply(modifier=modifier)
    return figure
