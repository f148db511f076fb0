"""A grid that carries one of everything a mesh can carry, and readers of all of it. Import after bpy.

Holds no assertions.
"""

import numpy as np

import bpy

from blender_scenes import add_grid

COLUMNS, ROWS = 5, 4
# Every kind of generic attribute, with the number of its components and the name of its value.
KINDS = {
    "FLOAT": (1, "value"),
    "INT": (1, "value"),
    "BOOLEAN": (1, "value"),
    "INT8": (1, "value"),
    "FLOAT_VECTOR": (3, "vector"),
    "FLOAT2": (2, "vector"),
    "FLOAT_COLOR": (4, "color"),
    "BYTE_COLOR": (4, "color_srgb"),
}
FLOATS = {"FLOAT", "FLOAT_VECTOR", "FLOAT2", "FLOAT_COLOR"}
DOMAINS = ("POINT", "EDGE", "FACE", "CORNER")


def add_attributed_grid(name="Attributed"):
    """A bumpy grid of quads with UV maps, colours, groups, shape keys, marks, materials and generic attributes."""
    random = np.random.default_rng(7)
    grid = add_grid(COLUMNS, ROWS, name=name)
    mesh = grid.data
    positions = np.empty((len(mesh.vertices), 3), dtype=np.float32)
    mesh.vertices.foreach_get("co", positions.ravel())
    positions[:, 2] = 0.2 * np.sin(positions[:, 0] + 2 * positions[:, 1])
    mesh.vertices.foreach_set("co", positions.ravel())
    for index in range(2):  # UV islands: nothing is shared between faces
        layer = mesh.uv_layers.new(name=f"UV {index}")
        layer.data.foreach_set("uv", random.random(len(mesh.loops) * 2))
    mesh.uv_layers.active_index = 1
    mesh.uv_layers[0].active_render = True
    for domain in DOMAINS:
        for kind, (width, value) in KINDS.items():
            attribute = mesh.attributes.new(f"{domain} {kind}", kind, domain)
            values = random.random(len(attribute.data) * width)
            if kind in {"INT", "INT8"}:
                values = np.round(values * 100).astype(np.int32)
            elif kind == "BOOLEAN":
                values = values > 0.5
            attribute.data.foreach_set(value, values)
    mesh.color_attributes.active_color_index = 1
    for edge in mesh.edges:
        edge.use_seam = edge.index % 3 == 0
        edge.use_edge_sharp = edge.index % 4 == 0
    for attribute_name in ("crease_edge", "bevel_weight_edge"):
        attribute = mesh.attributes.new(attribute_name, "FLOAT", "EDGE")
        attribute.data.foreach_set("value", random.random(len(mesh.edges)))
    sets = mesh.attributes.new(".sculpt_face_set", "INT", "FACE")
    sets.data.foreach_set("value", np.arange(len(mesh.polygons), dtype=np.int32) % 5 + 1)
    for index in range(3):
        mesh.materials.append(bpy.data.materials.new(f"Material {index}"))
    mesh.polygons.foreach_set("material_index", np.arange(len(mesh.polygons), dtype=np.int32) % 3)
    mesh.polygons.foreach_set("use_smooth", np.arange(len(mesh.polygons)) % 2 == 0)
    for index in range(2):
        group = grid.vertex_groups.new(name=f"Group {index}")
        for vertex in range(0, len(mesh.vertices), index + 1):
            group.add([vertex], float(random.random()), "REPLACE")
    grid.shape_key_add(name="Basis")
    for index in range(2):
        key = grid.shape_key_add(name=f"Key {index}", from_mix=False)
        moved = positions + random.random(positions.shape).astype(np.float32)
        key.data.foreach_set("co", moved.ravel())
        key.value = 0.25
    grid.data.shape_keys.key_blocks[2].relative_key = grid.data.shape_keys.key_blocks[1]
    return grid


def read_everything(mesh_object):
    """All that the mesh carries, by name: a pair of the domain and the values, one row an element."""
    mesh = mesh_object.data
    found = {"positions": ("POINT", get(mesh.vertices, "co", 3))}
    for attribute in mesh.attributes:
        width, value = KINDS.get(attribute.data_type, (0, ""))
        if width and not attribute.name.startswith((".edge_verts", ".corner_", "position")):
            found[attribute.name] = (attribute.domain, get(attribute.data, value, width))
    for layer in mesh.uv_layers:
        found[f"uv {layer.name}"] = ("CORNER", get(layer.data, "uv", 2))
    for name in ("use_seam", "use_edge_sharp", "select", "hide"):
        found[f"edge {name}"] = ("EDGE", get(mesh.edges, name, 1, bool))
    for name in ("material_index", "use_smooth", "select", "hide"):
        found[f"face {name}"] = ("FACE", get(mesh.polygons, name, 1, np.int32 if "index" in name else bool))
    for name in ("select", "hide"):
        found[f"vertex {name}"] = ("POINT", get(mesh.vertices, name, 1, bool))
    for group in mesh_object.vertex_groups:
        found[f"group {group.name}"] = ("POINT", read_group(mesh, group.index))
    if mesh.shape_keys is not None:
        for key in mesh.shape_keys.key_blocks:
            found[f"key {key.name}"] = ("POINT", get(key.data, "co", 3))
    return found


def get(rows, name, width, dtype=np.float32):
    """One property of all rows, (count, width); numbers as floats, as Blender gives them."""
    values = np.empty(len(rows) * width, dtype=dtype)
    rows.foreach_get(name, values)
    return values.reshape(-1, width)


def read_group(mesh, group):
    """Weights of a vertex group, -1 where a vertex is not in it, (V, 1)."""
    weights = np.full((len(mesh.vertices), 1), -1.0, dtype=np.float32)
    for vertex in mesh.vertices:
        for member in vertex.groups:
            if member.group == group:
                weights[vertex.index] = member.weight
    return weights


def read_faces(mesh):
    """The vertices of every face, as tuples."""
    return [tuple(polygon.vertices) for polygon in mesh.polygons]


def read_edges(mesh):
    """The number of every edge, by its two vertices in order."""
    return {tuple(sorted(edge.vertices)): edge.index for edge in mesh.edges}
