# SPDX-License-Identifier: GPL-3.0-or-later
"""Unwraps a mesh by its seams, and measures how much each island of the UV map is stretched.

The measures are plain functions of arrays. Knows no lines.
"""

from dataclasses import dataclass

import numpy as np

import bpy

import bmesh

from .. import mesh_read
from ..active import is_in_object_mode, list_edited_meshes, list_selected
from ..errors import ObjectError

# Triangles flatter than this (twice their area over the square of a side) have no shape left in 32 bits: not measured.
SMALLEST_SHAPE = 1e-3

# Face attributes that the measures are written to, to be looked at.
ANGLE_ATTRIBUTE = "uv_angle_stretch"
AREA_ATTRIBUTE = "uv_area_stretch"


@dataclass(frozen=True)
class Island:
    """One connected piece of the UV map. Stretch is 1 where there is none; means are weighed by area in space."""

    faces: int
    area: float  # in space, object's units
    angle_stretch: float  # mean of the larger over the smaller of the two scales of the map
    area_stretch: float  # mean of how many times larger or smaller than the island's own scale
    worst_angle_stretch: float
    worst_area_stretch: float
    flipped: int  # triangles that lie mirrored in the map


@dataclass(frozen=True)
class Islands:
    """All islands, the largest first, and the island of every face."""

    islands: list[Island]
    face_islands: np.ndarray  # (F,) int
    face_angle_stretch: np.ndarray  # (F,) float
    face_area_stretch: np.ndarray  # (F,) float


def unwrap_and_measure(
    context: bpy.types.Context, mesh_object: bpy.types.Object, *, method: str = "ANGLE_BASED", write: bool = True
) -> Islands:
    """Unwrap all faces of `mesh_object` by its seams, and measure the islands.

    write : also as face attributes ANGLE_ATTRIBUTE and AREA_ATTRIBUTE (in Object Mode)

    The selection stays as it was. Runs Blender's own operator, in Edit Mode, of which there is no other form.
    """
    mesh = mesh_object.data
    check_unwrappable(context, mesh_object)
    run_unwrap(context, mesh_object, method)
    with mesh_read.open_current_mesh(mesh_object) as current:
        measured = measure_islands(current)
    if write and not mesh.is_editmode:
        for name, values in (
            (ANGLE_ATTRIBUTE, measured.face_angle_stretch),
            (AREA_ATTRIBUTE, measured.face_area_stretch),
        ):
            attribute = mesh.attributes.get(name) or mesh.attributes.new(name, "FLOAT", "FACE")
            attribute.data.foreach_set("value", values.astype(np.float32))
    return measured


def check_unwrappable(context: bpy.types.Context, mesh_object: bpy.types.Object) -> None:
    """ObjectError when Blender's operator could not be run on the mesh."""
    mesh = mesh_object.data
    if mesh.is_editmode:
        return
    if len(mesh.polygons) == 0:
        raise ObjectError(f"{mesh_object.name} has no faces to unwrap")
    if not is_in_object_mode(context) or not mesh_object.visible_get(view_layer=context.view_layer):
        raise ObjectError(
            f"{mesh_object.name} cannot be unwrapped: it must be visible, and Blender in Object Mode, or the mesh in "
            "Edit Mode; show it, or turn Unwrap off"
        )


def run_unwrap(context: bpy.types.Context, mesh_object: bpy.types.Object, method: str) -> None:
    """Blender's unwrapping of every visible face, from whatever mode; mode, selection and active object stay."""
    view_layer = context.view_layer
    was_editing, active = mesh_object.data.is_editmode, view_layer.objects.active
    if not was_editing:
        selected_objects = list_selected(context)
        for other in selected_objects:
            other.select_set(False)
        view_layer.objects.active = mesh_object
        bpy.ops.object.mode_set(mode="EDIT")
    try:
        # Others in Edit Mode keep their maps: only what is selected is unwrapped.
        edited = list_edited_meshes(context)
        selected = {o: read_selection(o) for o in edited}
        bpy.ops.mesh.select_all(action="SELECT")
        for other in edited:
            if other.data != mesh_object.data:
                deselect_all(other)
        bpy.ops.uv.unwrap(method=method, margin=0.005)
        bpy.ops.mesh.select_all(action="DESELECT")
        for other in edited:
            restore_selection(other, selected[other])
    finally:
        if not was_editing:
            bpy.ops.object.mode_set(mode="OBJECT")
            for other in selected_objects:
                other.select_set(True)
            view_layer.objects.active = active


def read_selection(mesh_object: bpy.types.Object) -> dict[str, np.ndarray]:
    """What is selected in Edit Mode, by kind of element."""
    with mesh_read.open_current_mesh(mesh_object) as mesh:
        found = {}
        for name in ("vertices", "edges", "polygons"):
            rows = getattr(mesh, name)
            found[name] = np.empty(len(rows), dtype=bool)
            rows.foreach_get("select", found[name])
        return found


def deselect_all(mesh_object: bpy.types.Object) -> None:
    """Select nothing of one mesh in Edit Mode."""
    edited = bmesh.from_edit_mesh(mesh_object.data)
    for face in edited.faces:
        face.select = False
    for edge in edited.edges:
        edge.select = False
    for vertex in edited.verts:
        vertex.select = False
    bmesh.update_edit_mesh(mesh_object.data, loop_triangles=False, destructive=False)


def restore_selection(mesh_object: bpy.types.Object, selected: dict[str, np.ndarray]) -> None:
    """Select this of a mesh of which nothing is selected."""
    edited = bmesh.from_edit_mesh(mesh_object.data)
    for items, name in ((edited.verts, "vertices"), (edited.edges, "edges"), (edited.faces, "polygons")):
        if selected[name].any():
            items.ensure_lookup_table()
            for number in np.flatnonzero(selected[name]).tolist():
                items[number].select = True
    edited.select_flush_mode()
    bmesh.update_edit_mesh(mesh_object.data, loop_triangles=False, destructive=False)


def measure_islands(mesh: bpy.types.Mesh) -> Islands:
    """Islands of the active UV map of a mesh that is not in Edit Mode, joined where faces share an edge in the map."""
    layer = mesh.uv_layers.active
    if layer is None:
        raise ObjectError(f"{mesh.name} has no UV map; unwrap it first")
    mesh.calc_loop_triangles()
    corners = np.empty(len(mesh.loop_triangles) * 3, dtype=np.int32)
    mesh.loop_triangles.foreach_get("loops", corners)
    faces = np.empty(len(mesh.loop_triangles), dtype=np.int32)
    mesh.loop_triangle_polygons.foreach_get("value", faces)
    corners = corners.reshape(-1, 3)
    uvs = np.empty(len(mesh.loops) * 2, dtype=np.float32)
    layer.uv.foreach_get("vector", uvs)
    uvs = uvs.reshape(-1, 2).astype(np.float64)
    positions = mesh_read.read_floats(mesh.attributes["position"].data, "vector", len(mesh.vertices))
    places = positions[mesh_read.read_corner_vertices(mesh)[corners]]
    offsets = np.empty(len(mesh.polygons), dtype=np.int32)
    mesh.polygons.foreach_get("loop_start", offsets)
    edges = np.empty(len(mesh.loops), dtype=np.int32)
    mesh.loops.foreach_get("edge_index", edges)
    labels = label_islands(edges, offsets, mesh_read.read_corner_vertices(mesh), uvs)
    return measure_stretch(places, uvs[corners], faces, labels)


def label_islands(edges: np.ndarray, offsets: np.ndarray, vertices: np.ndarray, uvs: np.ndarray) -> np.ndarray:
    """The island of every face, (F,): joined over edges whose two ends have the same place in the map on both sides."""
    count = len(offsets)
    sizes = np.diff(np.append(offsets, len(edges)))
    faces = np.repeat(np.arange(count), sizes)
    starts = np.repeat(offsets, sizes)
    following = starts + (np.arange(len(edges)) - starts + 1) % np.repeat(sizes, sizes)
    # Both ends of each corner's edge, that of the lower vertex first.
    is_turned = vertices > vertices[following]
    ends = np.where(is_turned[:, None], np.hstack([uvs[following], uvs]), np.hstack([uvs, uvs[following]]))
    order = np.argsort(edges, kind="stable")
    a, b = order[:-1], order[1:]
    is_joined = (edges[a] == edges[b]) & (np.abs(ends[a] - ends[b]).max(axis=1, initial=0.0) < 1e-6)
    return label_parts(count, faces[a[is_joined]], faces[b[is_joined]])


def label_parts(count: int, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """One number a node, 0 and up, equal where links between `a` and `b` connect."""
    labels = np.arange(count)
    while True:
        least = np.minimum(labels[a], labels[b])
        previous = labels.copy()
        np.minimum.at(labels, labels[a], least)
        np.minimum.at(labels, labels[b], least)
        labels = labels[labels]
        if np.array_equal(labels, previous):
            return np.unique(labels, return_inverse=True)[1].ravel()


def measure_stretch(places: np.ndarray, uvs: np.ndarray, faces: np.ndarray, labels: np.ndarray) -> Islands:
    """Stretch of every face and island.

    places : (T, 3, 3), uvs : (T, 3, 2) corners of triangles; faces : (T,) the face of each; labels : (F,) its island

    The two scales of a triangle are the singular values of the map from space to UV; the island's own scale is such
    that areas agree in total.
    """
    first, second = places[:, 1] - places[:, 0], places[:, 2] - places[:, 0]
    normals = np.cross(first, second)
    areas = 0.5 * np.linalg.norm(normals, axis=1)
    lengths = np.linalg.norm(first, axis=1)
    # A frame in each triangle: along its first side, and at a right angle to it.
    x = np.divide(np.einsum("ti,ti->t", second, first), lengths, out=np.zeros_like(lengths), where=lengths > 0)
    height = np.divide(2.0 * areas, lengths, out=np.zeros_like(lengths), where=lengths > 0)
    longest = np.maximum(lengths, np.linalg.norm(second, axis=1))
    is_whole = height * lengths > SMALLEST_SHAPE * longest**2
    u1, u2 = uvs[:, 1] - uvs[:, 0], uvs[:, 2] - uvs[:, 0]
    along = np.divide(u1, lengths[:, None], out=np.zeros_like(u1), where=is_whole[:, None])
    across = np.divide(u2 - along * x[:, None], height[:, None], out=np.zeros_like(u2), where=is_whole[:, None])
    # Singular values of the 2 by 2 map with these columns.
    total = (along**2).sum(axis=1) + (across**2).sum(axis=1)
    determinant = along[:, 0] * across[:, 1] - along[:, 1] * across[:, 0]
    root = np.sqrt(np.maximum(total**2 - 4.0 * determinant**2, 0.0))
    larger, smaller = np.sqrt(0.5 * (total + root)), np.sqrt(np.maximum(0.5 * (total - root), 0.0))
    angle = np.divide(larger, smaller, out=np.full_like(larger, np.inf), where=smaller > 0)
    islands = labels[faces]
    count = int(labels.max(initial=-1)) + 1
    weights = np.where(is_whole, areas, 0.0)
    area_sum = np.bincount(islands, weights, count)
    uv_sum = np.bincount(islands, weights * np.abs(determinant), count)
    own = np.divide(uv_sum, area_sum, out=np.ones(count), where=area_sum > 0)
    ratio = np.divide(np.abs(determinant), own[islands], out=np.zeros_like(determinant), where=own[islands] > 0)
    area = np.maximum(ratio, np.divide(1.0, ratio, out=np.full_like(ratio, np.inf), where=ratio > 0))
    angle, area = np.where(is_whole, angle, 1.0), np.where(is_whole, area, 1.0)

    face_count = len(labels)
    face_area = np.maximum(np.bincount(faces, weights, face_count), np.finfo(np.float64).tiny)
    face_angle = np.bincount(faces, weights * angle, face_count) / face_area
    face_stretch = np.bincount(faces, weights * area, face_count) / face_area
    order = np.argsort(-area_sum, kind="stable")
    found = [
        Island(
            faces=int((labels == island).sum()),
            area=float(area_sum[island]),
            angle_stretch=float((weights * angle)[islands == island].sum() / max(area_sum[island], 1e-300)),
            area_stretch=float((weights * area)[islands == island].sum() / max(area_sum[island], 1e-300)),
            worst_angle_stretch=float(angle[islands == island].max(initial=1.0)),
            worst_area_stretch=float(area[islands == island].max(initial=1.0)),
            flipped=count_flipped(determinant[(islands == island) & is_whole]),
        )
        for island in order
    ]
    renumbered = np.empty(count, dtype=np.int64)
    renumbered[order] = np.arange(count)
    return Islands(found, renumbered[labels], face_angle, face_stretch)


def count_flipped(determinants: np.ndarray) -> int:
    """Triangles that lie the other way round than most of their island."""
    negative = int((determinants < 0).sum())
    return min(negative, len(determinants) - negative)
