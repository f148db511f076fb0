# SPDX-License-Identifier: GPL-3.0-or-later
"""Who is joined to whom in a mesh, as arrays; whether two meshes are the same in that; and mirror images within one.

Arrays alone, but for reading them from a mesh that is not in Edit Mode. Knows no marks and no lines.
"""

from dataclasses import dataclass

import numpy as np

import bpy

from .. import mesh_read
from ..errors import ObjectError
from . import edge_marks

NO_PARTNER = -1


@dataclass(frozen=True)
class Topology:
    """Vertices by number, edges as pairs (E, 2), faces as corners (L,) with their first ones (F + 1,)."""

    vertex_count: int
    edges: np.ndarray
    corners: np.ndarray
    offsets: np.ndarray


def read_topology(mesh: bpy.types.Mesh) -> Topology:
    """The topology of a mesh as it is stored."""
    offsets = np.empty(len(mesh.polygons) + 1, dtype=np.int32)
    mesh.polygons.foreach_get("loop_start", offsets[:-1])
    offsets[-1] = len(mesh.loops)
    return Topology(
        len(mesh.vertices), edge_marks.read_edge_vertices(mesh), mesh_read.read_corner_vertices(mesh), offsets
    )


def match_edges(source: Topology, target: Topology, names: tuple[str, str]) -> np.ndarray:
    """For every edge of `target` the edge of `source` between the same vertices, (E,).

    ObjectError names the first difference: in the numbers of vertices, faces or edges, in a face's vertices (from
    whichever corner they are counted), or in an edge.
    """
    first, second = names
    for what, a, b in (
        ("vertices", source.vertex_count, target.vertex_count),
        ("faces", len(source.offsets) - 1, len(target.offsets) - 1),
        ("edges", len(source.edges), len(target.edges)),
    ):
        if a != b:
            raise ObjectError(f"{first} has {a} {what}, but {second} has {b}; marks are copied between meshes {SAME}")
    if not np.array_equal(source.offsets, target.offsets):
        sizes_a, sizes_b = np.diff(source.offsets), np.diff(target.offsets)
        face = int(np.flatnonzero(sizes_a != sizes_b)[0])
        raise ObjectError(
            f"Face {face} of {first} has {sizes_a[face]} corners, but {sizes_b[face]} in {second}; marks are copied "
            f"between meshes {SAME}"
        )
    faces_a, faces_b = (rotate_to_least(t.corners, t.offsets) for t in (source, target))
    if not np.array_equal(faces_a, faces_b):
        corner = int(np.flatnonzero(faces_a != faces_b)[0])
        face = int(np.searchsorted(source.offsets, corner, side="right")) - 1
        rows = slice(source.offsets[face], source.offsets[face + 1])
        raise ObjectError(
            f"Face {face} of {first} has the vertices {faces_a[rows].tolist()}, but {faces_b[rows].tolist()} in "
            f"{second}; marks are copied between meshes {SAME}"
        )
    keys_a, keys_b = (make_edge_keys(t.edges, t.vertex_count) for t in (source, target))
    order_a, order_b = np.argsort(keys_a, kind="stable"), np.argsort(keys_b, kind="stable")
    if not np.array_equal(keys_a[order_a], keys_b[order_b]):
        # Where only repeated edges differ there is no edge that the other lacks.
        is_lacking = ~np.isin(keys_b, keys_a)
        edge = int(np.argmax(is_lacking)) if is_lacking.any() else int(order_b[-1])
        raise ObjectError(
            f"Edge {edge} of {second} joins the vertices {target.edges[edge].tolist()}, but {first} has no such edge; "
            f"marks are copied between meshes {SAME}"
        )
    matched = np.empty(len(keys_b), dtype=np.int64)
    matched[order_b] = order_a
    return matched


SAME = "of the same vertices, edges and faces in the same order"


def rotate_to_least(corners: np.ndarray, offsets: np.ndarray) -> np.ndarray:
    """The same faces, each counted from its vertex of the lowest number."""
    if len(corners) == 0:
        return corners
    sizes = np.diff(offsets)
    starts = np.repeat(offsets[:-1], sizes)
    least = np.repeat(np.minimum.reduceat(corners, offsets[:-1]), sizes)
    # The place of the least vertex within its face.
    is_least = corners == least
    place = np.zeros(len(sizes), dtype=np.int64)
    faces = np.repeat(np.arange(len(sizes)), sizes)
    rows = np.flatnonzero(is_least)[::-1]
    place[faces[rows]] = rows - starts[rows]
    within = np.arange(len(corners)) - starts
    return corners[starts + (within + place[faces]) % sizes[faces]]


def make_edge_keys(edges: np.ndarray, vertex_count: int) -> np.ndarray:
    """One number an edge, whichever end is counted first."""
    ends = np.sort(edges.astype(np.int64), axis=1)
    return ends[:, 0] * max(vertex_count, 1) + ends[:, 1]


def find_edges(edges: np.ndarray, vertex_count: int, pairs: np.ndarray) -> np.ndarray:
    """The number of the edge between each pair of vertices, NO_PARTNER where there is none."""
    if len(edges) == 0 or len(pairs) == 0:
        return np.full(len(pairs), NO_PARTNER)
    keys, wanted = make_edge_keys(edges, vertex_count), make_edge_keys(pairs, vertex_count)
    if len(pairs) * 20 < len(edges):
        # Few of many: only edges with both ends among the wanted can be meant.
        is_wanted = np.zeros(vertex_count, dtype=bool)
        is_wanted[pairs.ravel()] = True
        rows = np.flatnonzero(is_wanted[edges[:, 0]] & is_wanted[edges[:, 1]])
    else:
        rows = np.arange(len(edges))
    if len(rows) == 0:
        return np.full(len(pairs), NO_PARTNER)
    order = rows[np.argsort(keys[rows], kind="stable")]
    place = np.minimum(np.searchsorted(keys[order], wanted), len(order) - 1)
    return np.where(keys[order[place]] == wanted, order[place], NO_PARTNER)
