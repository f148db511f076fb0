# SPDX-License-Identifier: GPL-3.0-or-later
"""The marks that an edge can have: seam, sharp, crease, bevel weight, freestyle, select; read, set and taken off.

The same names for a mesh in Object Mode and for a BMesh, whatever the Blender version calls them. Knows no lines.
"""

from collections.abc import Iterable, Sequence

import numpy as np

import bpy

import bmesh

from ..errors import AddonError

MARK_ITEMS = (
    ("SEAM", "Seam", "Where UV unwrapping cuts"),
    ("SHARP", "Sharp", "A hard edge in shading"),
    ("CREASE", "Crease", "A crease for Subdivision Surface"),
    ("BEVEL_WEIGHT", "Bevel Weight", "A weight for the Bevel modifier"),
    ("FREESTYLE", "Freestyle", "A line that Freestyle draws"),
    ("SELECT", "Select", "Select the edges, and nothing else"),
)
MARKS = tuple(item[0] for item in MARK_ITEMS)
# What is kept as an attribute of floats, by its name; absent until first set.
WEIGHT_ATTRIBUTES = {"CREASE": "crease_edge", "BEVEL_WEIGHT": "bevel_weight_edge"}
# Marks that are on or off, by the property of an edge of a mesh.
FLAG_PROPERTIES = {"SEAM": "use_seam", "SHARP": "use_edge_sharp", "FREESTYLE": "use_freestyle_mark", "SELECT": "select"}
# From Blender 5.0 on Freestyle's mark is an attribute like any other.
FREESTYLE_ATTRIBUTE = "freestyle_edge"


def check_marks(marks: Iterable[str]) -> tuple[str, ...]:
    """The marks as a tuple; AddonError names one that there is not."""
    wanted = tuple(marks)
    for mark in wanted:
        if mark not in MARKS:
            raise AddonError(f"There is no mark {mark!r}; the marks are {', '.join(MARKS)}")
    return wanted


def read_marks(mesh: bpy.types.Mesh, mark: str) -> np.ndarray:
    """The mark of every edge, (E,) float32: 0 or 1, or the weight. Not of a mesh in Edit Mode."""
    count = len(mesh.edges)
    if mark in WEIGHT_ATTRIBUTES:
        attribute = mesh.attributes.get(WEIGHT_ATTRIBUTES[mark])
        values = np.zeros(count, dtype=np.float32)
        if attribute is not None:
            attribute.data.foreach_get("value", values)
        return values
    if mark == "FREESTYLE" and not has_freestyle_property():
        attribute = mesh.attributes.get(FREESTYLE_ATTRIBUTE)
        flags = np.zeros(count, dtype=bool)
        if attribute is not None:
            attribute.data.foreach_get("value", flags)
        return flags.astype(np.float32)
    flags = np.zeros(count, dtype=bool)
    mesh.edges.foreach_get(FLAG_PROPERTIES[mark], flags)
    return flags.astype(np.float32)


def has_freestyle_property() -> bool:
    """Whether Freestyle's mark is a property of edges, which a BMesh cannot set; later it is an attribute."""
    return "use_freestyle_mark" in bpy.types.MeshEdge.bl_rna.properties


def write_marks(mesh: bpy.types.Mesh, mark: str, values: np.ndarray) -> None:
    """Give every edge its mark, (E,) numbers: 0 takes it off. Not of a mesh in Edit Mode."""
    if mark in WEIGHT_ATTRIBUTES or (mark == "FREESTYLE" and not has_freestyle_property()):
        name = WEIGHT_ATTRIBUTES.get(mark, FREESTYLE_ATTRIBUTE)
        kind, dtype = ("FLOAT", np.float32) if mark in WEIGHT_ATTRIBUTES else ("BOOLEAN", bool)
        attribute = mesh.attributes.get(name)
        if attribute is None:
            attribute = mesh.attributes.new(name, kind, "EDGE")
        attribute.data.foreach_set("value", np.ascontiguousarray(values, dtype=dtype))
    else:
        mesh.edges.foreach_set(FLAG_PROPERTIES[mark], np.ascontiguousarray(values, dtype=bool))
    mesh.update_tag()


def mark_mesh_edges(mesh: bpy.types.Mesh, edges: Sequence[int], marks: Sequence[str], weight: float = 1.0) -> None:
    """Mark these edges of a mesh that is not in Edit Mode; `weight` is that of creases and bevels."""
    for mark in marks:
        if mark == "SELECT":
            select_only(mesh, edges)
        elif mark in FLAG_PROPERTIES and (mark != "FREESTYLE" or has_freestyle_property()):
            # One by one: few edges of many.
            name = FLAG_PROPERTIES[mark]
            for edge in edges:
                setattr(mesh.edges[edge], name, True)
        else:
            values = read_marks(mesh, mark)
            values[np.asarray(edges, dtype=np.int64)] = weight if mark in WEIGHT_ATTRIBUTES else 1.0
            write_marks(mesh, mark, values)
    mesh.update_tag()


def select_only(mesh: bpy.types.Mesh, edges: Sequence[int]) -> None:
    """Select these edges and their vertices, and no others."""
    chosen = np.zeros(len(mesh.edges), dtype=bool)
    chosen[np.asarray(edges, dtype=np.int64)] = True
    ends = read_edge_vertices(mesh)
    is_end = np.zeros(len(mesh.vertices), dtype=bool)
    is_end[ends[chosen].ravel()] = True
    mesh.vertices.foreach_set("select", is_end)
    mesh.edges.foreach_set("select", chosen)
    mesh.polygons.foreach_set("select", np.zeros(len(mesh.polygons), dtype=bool))


def read_edge_vertices(mesh: bpy.types.Mesh) -> np.ndarray:
    """The two vertices of every edge, (E, 2) int32."""
    ends = np.empty(len(mesh.edges) * 2, dtype=np.int32)
    if len(ends) > 0:
        mesh.attributes[".edge_verts"].data.foreach_get("value", ends)
    return ends.reshape(-1, 2)


def prepare_layers(edited: bmesh.types.BMesh, marks: Sequence[str]) -> None:
    """Make the layers that these marks need: before any element is held, since that makes it stale."""
    layers = edited.edges.layers
    for mark in marks:
        if mark in WEIGHT_ATTRIBUTES and layers.float.get(WEIGHT_ATTRIBUTES[mark]) is None:
            layers.float.new(WEIGHT_ATTRIBUTES[mark])
        elif mark == "FREESTYLE" and layers.bool.get(FREESTYLE_ATTRIBUTE) is None:
            layers.bool.new(FREESTYLE_ATTRIBUTE)


def mark_bmesh_edges(
    edited: bmesh.types.BMesh, edges: Sequence[bmesh.types.BMEdge], marks: Sequence[str], weight: float = 1.0
) -> None:
    """Mark these edges; `prepare_layers` comes first. SELECT leaves nothing else selected."""
    layers = edited.edges.layers
    for mark in marks:
        if mark in WEIGHT_ATTRIBUTES:
            layer = layers.float[WEIGHT_ATTRIBUTES[mark]]
            for edge in edges:
                edge[layer] = weight
        elif mark == "SEAM":
            for edge in edges:
                edge.seam = True
        elif mark == "SHARP":
            for edge in edges:
                edge.smooth = False
        elif mark == "FREESTYLE":
            layer = layers.bool[FREESTYLE_ATTRIBUTE]
            for edge in edges:
                edge[layer] = True
        else:
            select_only_bmesh(edited, edges)


def write_bmesh_marks(edited: bmesh.types.BMesh, mark: str, values: np.ndarray) -> set[int]:
    """Give every edge its mark, as `write_marks`, after `prepare_layers`; the numbers of those that had another."""
    if mark in WEIGHT_ATTRIBUTES:
        layer = edited.edges.layers.float[WEIGHT_ATTRIBUTES[mark]]
    elif mark == "FREESTYLE":
        layer = edited.edges.layers.bool[FREESTYLE_ATTRIBUTE]
    else:
        layer = None
    changed = set()
    for number, (edge, value) in enumerate(zip(edited.edges, values.tolist(), strict=True)):
        if layer is not None:
            if float(edge[layer]) != value:
                edge[layer] = value if mark in WEIGHT_ATTRIBUTES else bool(value)
                changed.add(number)
        elif mark == "SEAM" and edge.seam != bool(value):
            edge.seam = bool(value)
            changed.add(number)
        elif mark == "SHARP" and edge.smooth == bool(value):
            edge.smooth = not value
            changed.add(number)
        elif mark == "SELECT" and edge.select != bool(value):
            edge.select_set(bool(value))
            changed.add(number)
    return changed


def select_only_bmesh(edited: bmesh.types.BMesh, edges: Sequence[bmesh.types.BMEdge]) -> None:
    """Select these edges and their vertices, and no others; hidden ones stay as they are."""
    for items in (edited.faces, edited.edges, edited.verts):
        for item in items:
            if item.select:
                item.select = False
    edited.select_history.clear()
    for edge in edges:
        edge.select_set(True)
