# SPDX-License-Identifier: GPL-3.0-or-later
"""Carries a cut of the library out in a BMesh: edges split where the line crosses them, faces replaced by their pieces.

Blender itself interpolates whatever lies on the mesh. What the line does not touch is not touched: vertices keep their
numbers, faces too, and of a face that is cut the first piece has the face's number. Knows no objects and no modes.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

import bmesh
from bmesh.types import BMEdge, BMesh, BMFace, BMLoop, BMVert

from ..errors import ObjectError

# Lighter corners weigh nothing in 32 bits.
SMALLEST_WEIGHT = 1e-12


@dataclass(frozen=True)
class Applied:
    """What a cut has become in the BMesh."""

    line_edges: list[BMEdge]  # as `cut.line_edges`
    pieces: dict[int, BMFace]  # of the faces that fell into pieces, by the row of `cut.polygon_parents`


def apply_cut(edited: BMesh, cut: Any, local_positions: np.ndarray, triangles: np.ndarray) -> Applied:
    """Cut `edited`.

    edited : the mesh that the cut was made of, vertices and faces in the same order
    cut : a `smooth_polylines.Cut`
    local_positions, triangles : (V, 3) and (F, 3) of that mesh, in the object's space
    """
    edited.verts.ensure_lookup_table()
    edited.faces.ensure_lookup_table()
    old_count = len(local_positions)
    # Not indexed later on: elements that are added make the lookup tables stale.
    new_vertices: list[BMVert | None] = [None] * len(cut.vertex_triangles)
    pieces = collect_pieces(cut)
    refuse_doubled_faces(edited, pieces, old_count)
    faces = {parent: edited.faces[parent] for parent in pieces}
    needed = {v for polygons in pieces.values() for corners in polygons.values() for v in corners if v < old_count}
    needed |= {int(v) for v in np.asarray(cut.line_edges).ravel() if v < old_count}
    needed |= {int(v) for v in np.asarray(cut.vertex_edges).ravel() if v >= 0}
    is_inside = np.asarray(cut.vertex_edges)[:, 0] < 0
    corners = triangles[np.asarray(cut.vertex_triangles)]
    needed |= {int(v) for v in corners[is_inside].ravel()}
    old_vertices = {vertex: edited.verts[vertex] for vertex in needed}

    # Before the edges are split: the vertices that the new ones are weighed from are then as they were.
    for row in np.flatnonzero(is_inside):
        weights = np.asarray(cut.vertex_barycentric[row], dtype=np.float64)
        place = weights @ local_positions[corners[row]]
        new_vertices[row] = add_vertex(edited, [old_vertices[int(v)] for v in corners[row]], weights, place)
    split_edges(edited, cut, old_vertices, new_vertices)

    def get_vertex(number: int) -> BMVert:
        return old_vertices[number] if number < old_count else new_vertices[number - old_count]

    made: dict[int, BMFace] = {}
    for parent, polygons in pieces.items():
        corners = [[get_vertex(v) for v in polygon] for polygon in polygons.values()]
        made |= zip(polygons, replace_face(edited, faces[parent], corners), strict=True)
    line_edges = np.asarray(cut.line_edges).tolist()
    return Applied([edited.edges.get((get_vertex(a), get_vertex(b))) for a, b in line_edges], made)


def collect_pieces(cut: Any) -> dict[int, dict[int, list[int]]]:
    """The vertices of every piece of each face that falls into more than one, by the face and the polygon's row.

    A face that only got a vertex into an edge has been given it when the edge was split.
    """
    offsets, parents, all_corners = cut.polygon_offsets, cut.polygon_parents, cut.polygon_corners
    pieces: dict[int, dict[int, list[int]]] = {}
    for polygon in np.asarray(cut.changed_polygons).tolist():
        corners = all_corners[offsets[polygon] : offsets[polygon + 1]]
        pieces.setdefault(int(parents[polygon]), {})[polygon] = corners.tolist()
    return {parent: polygons for parent, polygons in pieces.items() if len(polygons) > 1}


def refuse_doubled_faces(edited: BMesh, pieces: dict[int, dict[int, list[int]]], old_count: int) -> None:
    """ObjectError, before anything is changed, where a piece would have the very vertices of another face.

    So it comes out where a face is folded back onto its neighbour: Blender has no two faces on the same vertices.
    """
    seen: dict[frozenset[int], int] = {}
    for parent, polygons in pieces.items():
        for corners in polygons.values():
            key = frozenset(corners)
            other = seen.get(key)
            if other is None and max(corners) < old_count:
                found = edited.faces.get([edited.verts[v] for v in corners])
                other = None if found is None or found.index in pieces else found.index
            seen[key] = parent
            if other is not None:
                raise ObjectError(
                    f"Face {parent} is folded onto face {other}, and a piece of it would have the same vertices; "
                    "unfold it there, or merge its vertices by distance (Mesh > Merge > By Distance), and cut again"
                )


def add_vertex(edited: BMesh, corners: Sequence[BMVert], weights: np.ndarray, place: np.ndarray) -> BMVert:
    """A new vertex inside a triangle, with what its three corners carry, weighed."""
    vertex = edited.verts.new(place, corners[int(np.argmax(weights))])
    weigh_vertex(edited, vertex, corners, weights)
    vertex.select = False
    return vertex


def weigh_vertex(edited: BMesh, vertex: BMVert, corners: Sequence[BMVert], weights: np.ndarray) -> None:
    """Give a vertex what three others carry, weighed; its place and its flags stay."""
    # Blender interpolates between two at a time; the heaviest come first, so that no sum is 0.
    first, second, third = np.argsort(-np.asarray(weights), kind="stable")
    if weights[second] <= SMALLEST_WEIGHT:
        # Of a part of 0 Blender makes a copy and forgets that Python knows the vertex; of two equal halves it does not.
        twin = edited.verts.new(corners[first].co, corners[first])
        vertex.copy_from_vert_interp((corners[first], twin), 0.5)
        edited.verts.remove(twin)
        return
    pair = weights[first] + weights[second]
    vertex.copy_from_vert_interp((corners[first], corners[second]), float(weights[second] / pair))
    if weights[third] > SMALLEST_WEIGHT:
        vertex.copy_from_vert_interp((vertex, corners[third]), float(weights[third]))


def split_edges(edited: BMesh, cut: Any, old_vertices: dict[int, BMVert], new_vertices: list[BMVert | None]) -> None:
    """Split every crossed edge at its parameters, from its first vertex on; fills `new_vertices`."""
    ends = np.asarray(cut.vertex_edges)
    parameters = np.asarray(cut.vertex_parameters, dtype=np.float64)
    # All rows of an edge count from the vertex of the lower number.
    is_turned = ends[:, 0] > ends[:, 1]
    parameters = np.where(is_turned, 1.0 - parameters, parameters)
    lower, upper = ends.min(axis=1), ends.max(axis=1)
    rows = np.flatnonzero(lower >= 0)
    rows = rows[np.lexsort((parameters[rows], upper[rows], lower[rows]))]
    previous: tuple[int, int] | None = None
    for row in rows:
        key = (int(lower[row]), int(upper[row]))
        if key != previous:
            start, end, passed = old_vertices[key[0]], old_vertices[key[1]], 0.0
            edge = edited.edges.get((start, end))
            is_selected = edge.select
            previous = key
        part = (parameters[row] - passed) / (1.0 - passed)
        # The edge itself keeps what lies beyond the new vertex.
        _, start = bmesh.utils.edge_split(edge, start, float(part))
        start.select = is_selected
        new_vertices[row] = start
        passed = parameters[row]


def replace_face(edited: BMesh, face: BMFace, polygons: Sequence[Sequence[BMVert]]) -> list[BMFace]:
    """Put the pieces in the place of `face`: corners that it had with all they carry, others weighed within it."""
    is_selected = face.select
    # A copy to read from, so that the first piece gets the number that the face leaves free.
    model = face.copy(verts=False, edges=False)
    corner_of = {corner.vert: corner for corner in model.loops}
    edited.faces.remove(face)
    pieces = []
    for polygon in polygons:
        piece = edited.faces.new(polygon, model)
        for corner in piece.loops:
            old = corner_of.get(corner.vert)
            if old is None:
                weigh_corner(corner, model)
            else:
                corner.copy_from(old)
        piece.normal_update()
        if is_selected:
            piece.select_set(True)
        pieces.append(piece)
    edited.faces.remove(model)
    return pieces


def weigh_corner(corner: BMLoop, face: BMFace) -> None:
    """Give a corner inside `face` what the face carries there; its vertex, and multires data, stay as they are."""
    arguments = (face, False, False)
    try:
        corner.copy_from_face_interp(*arguments)
    except TypeError:
        # Versions that were made for one argument take all of them as one.
        corner.copy_from_face_interp(arguments)
