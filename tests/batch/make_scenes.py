"""Run by tests in a process of its own, with bpy: writes inputs of every kind into a folder, and looks into results.

    make_scenes.py write FOLDER     the plane, in every format, and in .blend with marks, guides and hidden things
    make_scenes.py look FILE...     one line of JSON, beginning with RESULT, of what each .blend file holds

Holds no assertions.
"""

import itertools
import json
import os
import sys
import tempfile
from pathlib import Path

os.environ["BLENDER_USER_RESOURCES"] = tempfile.mkdtemp()

import bpy

import addon_utils
import mathutils

SIDE = 20  # quads a side; the plane covers 0..1 in x and y, its face `row * SIDE + column` at that place


def make_plane(name):
    positions = [(x / SIDE, y / SIDE, 0.0) for y in range(SIDE + 1) for x in range(SIDE + 1)]
    polygons = [
        (a, a + 1, a + SIDE + 2, a + SIDE + 1)
        for a in (row * (SIDE + 1) + column for row in range(SIDE) for column in range(SIDE))
    ]
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(positions, [], polygons)
    layer = mesh.uv_layers.new(name="UVMap")
    for loop in mesh.loops:
        layer.uv[loop.index].vector = positions[loop.vertex_index][:2]
    plane = bpy.data.objects.new(name, mesh)
    bpy.context.scene.collection.objects.link(plane)
    return plane


def mark(plane):
    """Vertex groups and attributes at known places."""
    mesh = plane.data
    quad = mesh.polygons[5 * SIDE + 3].vertices
    plane.vertex_groups.new(name="quad").add(list(quad), 1.0, "ADD")
    plane.vertex_groups.new(name="empty")
    lone = plane.vertex_groups.new(name="lone vertex")
    lone.add([10 * (SIDE + 1) + 10], 0.5, "ADD")
    region = mesh.attributes.new("region", "INT", "FACE")
    for row in (15, 16):
        for column in (12, 13):
            region.data[row * SIDE + column].value = 3
    point = mesh.attributes.new("mark", "BOOLEAN", "POINT")
    point.data[2 * (SIDE + 1) + 17].value = True
    mesh.attributes.new("colour", "FLOAT_COLOR", "POINT")


def add_guides():
    """Strokes 0.02 above the plane."""
    height = 0.02
    poly = bpy.data.curves.new("Poly", "CURVE")
    poly.dimensions, poly.bevel_depth = "3D", 0.01
    spline = poly.splines.new("POLY")
    spline.points.add(9)
    for k, point in enumerate(spline.points):
        point.co = (0.1 + 0.08 * k, 0.33, height, 1)
    bezier = bpy.data.curves.new("Bezier", "CURVE")
    bezier.dimensions = "3D"
    spline = bezier.splines.new("BEZIER")
    spline.bezier_points.add(3)
    for point, (x, y) in zip(spline.bezier_points, ((0.8, 0.5), (0.5, 0.8), (0.2, 0.5), (0.5, 0.2)), strict=True):
        point.co, point.handle_left_type, point.handle_right_type = (x, y, height), "AUTO", "AUTO"
    spline.use_cyclic_u = True
    far = poly.copy()
    far.splines[0].points[4].co[2] = 5.0
    for name, data in (("Poly", poly), ("Bezier", bezier), ("Far", far)):
        bpy.context.scene.collection.objects.link(bpy.data.objects.new(name, data))
    strokes = [[(0.2 + 0.05 * k, 0.6, height) for k in range(8)], [(0.7, 0.3 + 0.05 * k, height) for k in range(9)]]
    add_grease_pencil(strokes)


def add_grease_pencil(strokes):
    if hasattr(bpy.data, "grease_pencils_v3"):
        data = bpy.data.grease_pencils_v3.new("Pencil")
    else:
        data = bpy.data.grease_pencils.new("Pencil")
    layer = data.layers.new("Lines")
    frame = layer.frames.new(1)
    if hasattr(frame, "drawing"):
        frame.drawing.add_strokes([len(points) for points in strokes])
        for stroke, points in zip(frame.drawing.strokes, strokes, strict=True):
            for point, place in zip(stroke.points, points, strict=True):
                point.position = place
    else:
        for points in strokes:
            stroke = frame.strokes.new()
            stroke.points.add(len(points))
            for point, place in zip(stroke.points, points, strict=True):
                point.co = place
    bpy.context.scene.collection.objects.link(bpy.data.objects.new("Pencil", data))


def export(folder):
    """The plane alone, in every format that Blender also reads."""
    for name in ("io_scene_fbx", "io_scene_gltf2"):
        addon_utils.enable(name)
    bpy.ops.wm.obj_export(filepath=str(folder / "plane.obj"))
    bpy.ops.wm.ply_export(filepath=str(folder / "plane.ply"))
    bpy.ops.wm.stl_export(filepath=str(folder / "plane.stl"))
    bpy.ops.export_scene.fbx(filepath=str(folder / "plane.fbx"))
    bpy.ops.export_scene.gltf(filepath=str(folder / "plane.glb"))
    bpy.ops.export_scene.gltf(filepath=str(folder / "plane.gltf"), export_format="GLTF_SEPARATE")
    for suffix in (".usda", ".usdc", ".usd"):
        bpy.ops.wm.usd_export(filepath=str(folder / f"plane{suffix}"))


def write(folder):
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    make_plane("plane")
    export(folder)
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    plane = make_plane("Plane")
    mark(plane)
    moved = bpy.data.objects.new("Moved", plane.data.copy())
    moved.location, moved.scale = (10, 0, 0), (2, 1, 1)
    bpy.context.scene.collection.objects.link(moved)
    hidden = make_plane("Hidden")
    hidden.hide_viewport = True
    bare = make_plane("Bare")
    bare.data.uv_layers.remove(bare.data.uv_layers[0])
    bare.location = (0, 10, 0)
    bent = make_plane("Bent")
    bent.location = (0, 20, 0)
    bent.modifiers.new("Array", "ARRAY")
    add_guides()
    text = bpy.data.texts.new("script.py")
    text.write("import bpy\nbpy.data.objects['Plane'].name = 'Hacked'\n")
    text.use_module = True
    bpy.ops.wm.save_as_mainfile(filepath=str(folder / "scene.blend"), compress=False)


def edit_on(package, curve):
    """What a curve remembers, and how far it moves when it is made again by it: nothing, and by another filter."""
    session, memory = (sys.modules[f"{package}.{name}"] for name in ("session", "live.memory"))
    if not memory.is_remembering(curve.data):
        return None
    known = memory.get_memory(curve.data)
    before = read_places(curve)
    session.update_curve(bpy.context, curve.data)
    again = read_places(curve)
    picks = len(json.loads(known.stored)["picks"])
    said = {"state": known.state, "pinned": known.pinned, "filter": known.filter, "picks": picks}
    return {**said, "moved": measure_gap(before, again, curve.data.splines[0].use_cyclic_u)}


def read_places(curve):
    return [mathutils.Vector(p.co[:3]) for p in curve.data.splines[0].points]


def measure_gap(places, chain, is_closed):
    """The largest distance of a place from a chain of straight pieces."""
    chain = [*chain, chain[0]] if is_closed else chain
    largest = 0.0
    for place in places:
        near = []
        for a, b in itertools.pairwise(chain):
            at, part = mathutils.geometry.intersect_point_line(place, a, b)
            near.append((place - (a if part < 0 else b if part > 1 else at)).length)
        largest = max(largest, min(near))
    return largest


def look(package, path):
    bpy.ops.wm.open_mainfile(filepath=path)
    curves = {}
    for each in bpy.data.objects:
        if each.type == "CURVE" and each.parent is not None:
            spline = each.data.splines[0]
            curves[each.name] = {
                "parent": each.parent.name,
                "points": [list(p.co)[:3] for p in spline.points],
                "closed": spline.use_cyclic_u,
                "bevel": each.data.bevel_depth,
            }
            curves[each.name]["memory"] = edit_on(package, each)
    meshes = {}
    for each in bpy.data.objects:
        if each.type == "MESH":
            places = [vertex.co[:2] for vertex in each.data.vertices]
            seams = [[list(places[v]) for v in edge.vertices] for edge in each.data.edges if edge.use_seam]
            meshes[each.name] = {"vertices": len(places), "seams": seams}
    names = sorted(o.name for o in bpy.data.objects)
    print("RESULT", json.dumps({"curves": curves, "objects": names, "meshes": meshes}), flush=True)


if __name__ == "__main__":
    if sys.argv[1] == "write":
        write(Path(sys.argv[2]))
    else:
        sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "blender_scripts"))
        from batching.inside import addon_door

        name = addon_door.load_addon(is_installed=False)
        for each in sys.argv[2:]:
            look(name, each)
    sys.stdout.flush()
    os._exit(0)
