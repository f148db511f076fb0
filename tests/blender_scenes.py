"""Scenes and picks for the tests that run in Blender, and measures of what came out. Import after bpy.

Holds no assertions and no fixtures.
"""

import numpy as np

import bpy

import bmesh

# Faces of Suzanne: ear, brow, brow, the other ear, far apart.
SUZANNE_PICKS = [377, 253, 252, 376]


def enter_edit_mode(mesh_object):
    """Make the object the active one, in Edit Mode, face select mode, nothing selected."""
    bpy.context.view_layer.objects.active = mesh_object
    mesh_object.select_set(True)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_mode(type="FACE")
    bpy.ops.mesh.select_all(action="DESELECT")
    return mesh_object


def pick_faces(mesh_object, faces):
    """Select faces one after another, as clicks with Shift do."""
    edited = bmesh.from_edit_mesh(mesh_object.data)
    edited.faces.ensure_lookup_table()
    for face in faces:
        edited.faces[face].select_set(True)
        edited.select_history.add(edited.faces[face])
    edited.select_flush_mode()
    bmesh.update_edit_mesh(mesh_object.data, loop_triangles=False, destructive=False)


def select_faces_without_order(mesh_object, faces):
    """Select faces as a box does: no order."""
    edited = bmesh.from_edit_mesh(mesh_object.data)
    edited.faces.ensure_lookup_table()
    for face in faces:
        edited.faces[face].select_set(True)
    edited.select_flush_mode()
    bmesh.update_edit_mesh(mesh_object.data, loop_triangles=False, destructive=False)


def add_mesh_object(name, positions, polygons):
    """A new mesh object in the scene, in Object Mode."""
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata([tuple(p) for p in positions], [], [tuple(p) for p in polygons])
    mesh_object = bpy.data.objects.new(name, mesh)
    bpy.context.scene.collection.objects.link(mesh_object)
    return mesh_object


def add_grid(columns, rows, *, name="Grid"):
    """A flat grid of unit quads; face `row * columns + column` lies at that place."""
    positions = [(x, y, 0.0) for y in range(rows + 1) for x in range(columns + 1)]
    polygons = [
        (a, a + 1, a + columns + 2, a + columns + 1)
        for a in (row * (columns + 1) + column for row in range(rows) for column in range(columns))
    ]
    return add_mesh_object(name, positions, polygons)


def get_curves():
    """All curve objects of the file."""
    return [o for o in bpy.data.objects if o.type == "CURVE"]


def get_spline_points(curve_object):
    """Points of the only spline, (N, 3) float64, the object's space."""
    (spline,) = curve_object.data.splines
    values = np.empty(len(spline.points) * 4, dtype=np.float32)
    spline.points.foreach_get("co", values)
    return values.reshape(-1, 4)[:, :3].astype(np.float64)


def get_world_points(curve_object):
    """Points of the only spline in world space."""
    matrix = np.array(curve_object.matrix_world)
    return get_spline_points(curve_object) @ matrix[:3, :3].T + matrix[:3, 3]


def read_mesh_slowly(mesh):
    """Positions, loop triangles and their polygons by plain Python loops: the oracle of the quick reading."""
    mesh.calc_loop_triangles()
    positions = np.array([tuple(v.co) for v in mesh.vertices], dtype=np.float64)
    triangles = np.array([tuple(t.vertices) for t in mesh.loop_triangles], dtype=np.int32)
    faces = np.array([t.polygon_index for t in mesh.loop_triangles], dtype=np.int32)
    is_visible = np.array([not mesh.polygons[f].hide for f in faces], dtype=bool)
    return positions, triangles[is_visible], faces[is_visible]


def measure_distances(points, positions, triangles):
    """Distance of each point to the nearest triangle, by brute force over all of them."""
    a, b, c = (positions[triangles[:, i]] for i in range(3))
    normals = np.cross(b - a, c - a)
    areas = np.linalg.norm(normals, axis=1)
    whole = areas > 0
    a, b, c, normals = a[whole], b[whole], c[whole], normals[whole] / areas[whole, None]
    distances = []
    for point in points:
        heights = np.einsum("ij,ij->i", point - a, normals)
        foot = point - heights[:, None] * normals
        inside = np.ones(len(a), dtype=bool)
        nearest = np.full(len(a), np.inf)
        for start, end in ((a, b), (b, c), (c, a)):
            edge = end - start
            inside &= np.einsum("ij,ij->i", np.cross(edge, foot - start), normals) >= 0
            t = np.clip(np.einsum("ij,ij->i", point - start, edge) / np.einsum("ij,ij->i", edge, edge), 0, 1)
            nearest = np.minimum(nearest, np.linalg.norm(point - (start + t[:, None] * edge), axis=1))
        distances.append(np.where(inside, np.abs(heights), nearest).min())
    return np.array(distances)


def count_data():
    """How many data-blocks of each kind the file has: equal before and after a refusal."""
    return {
        name: len(getattr(bpy.data, name))
        for name in ("objects", "meshes", "curves", "shape_keys", "collections", "materials")
    }
