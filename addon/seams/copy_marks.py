# SPDX-License-Identifier: GPL-3.0-or-later
"""Marks of edges copied to another mesh of the same topology, or mirrored within a mesh. For scripts and operators.

Works in Object Mode and in Edit Mode; in the latter the edit mesh is brought up to date and changed where it lies.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

import bpy

import bmesh

from .. import mesh_read, session
from ..errors import AddonError
from . import edge_marks, edit, mirror, topology

METHODS = ("POSITION", "TOPOLOGY")
DIRECTIONS = ("POSITIVE_TO_NEGATIVE", "NEGATIVE_TO_POSITIVE", "BOTH")


@dataclass(frozen=True)
class CopiedMarks:
    """What was changed."""

    changed: int  # edges whose marks are others now
    unmatched: int  # edges that have no image, and were left as they are


def copy_marks(
    source_object: bpy.types.Object,
    target_object: bpy.types.Object,
    chosen: Sequence[str] = ("SEAM",),
) -> CopiedMarks:
    """Give every edge of the target the marks of the same edge of the source.

    Both must have the same vertices, edges and faces in the same order; where they lie does not matter. Raises
    ObjectError with the first difference; nothing has been changed then.
    """
    wanted = edge_marks.check_marks(chosen)
    (matched,) = check_topologies(source_object, [target_object])
    with mesh_read.open_current_mesh(source_object) as mesh:
        values = {mark: edge_marks.read_marks(mesh, mark) for mark in wanted}
    changed = write_to_object(target_object, {mark: values[mark][matched] for mark in wanted})
    return CopiedMarks(changed, 0)


def check_topologies(source_object: bpy.types.Object, targets: Sequence[bpy.types.Object]) -> list[np.ndarray]:
    """For each target the edge of the source that each of its edges is; refusals as of `copy_marks`."""
    if source_object is None or source_object.type != "MESH":
        raise AddonError("Marks are copied from a mesh; select the one that has them, then the one that shall get them")
    with mesh_read.open_current_mesh(source_object) as mesh:
        source = topology.read_topology(mesh)
    matched = []
    for target_object in targets:
        session.check_object(target_object)
        if source_object.data == target_object.data:
            raise AddonError(f"{source_object.name} and {target_object.name} have the same mesh already")
        with mesh_read.open_current_mesh(target_object) as mesh:
            target = topology.read_topology(mesh)
        matched.append(topology.match_edges(source, target, (source_object.name, target_object.name)))
    return matched


def mirror_marks(
    mesh_object: bpy.types.Object,
    axis: str = "X",
    chosen: Sequence[str] = ("SEAM",),
    *,
    method: str = "POSITION",
    direction: str = "POSITIVE_TO_NEGATIVE",
    tolerance: float = 1e-4,
) -> CopiedMarks:
    """Mirror the marks of edges across a plane through the object's origin.

    axis : X, Y or Z, the object's own, at a right angle to the plane
    method : POSITION: the edge nearest to the mirror image; TOPOLOGY: by who is joined to whom, from the plane
        outwards, also where the sides have other shapes
    direction : which side's marks the other side gets: it loses its own; BOTH: each side gets those of the other too
    tolerance : in the object's units: how far from its image, and from the plane, a vertex may lie

    Edges without an image keep their marks and are counted. Raises AddonError; nothing has been changed then.
    """
    wanted = edge_marks.check_marks(chosen)
    for name, value, allowed in (
        ("axis", axis, mirror.AXES),
        ("method", method, METHODS),
        ("direction", direction, DIRECTIONS),
    ):
        if value not in allowed:
            raise AddonError(f"{name} is {value!r}; it must be one of {', '.join(allowed)}")
    if not tolerance > 0.0:
        raise AddonError(f"tolerance is {tolerance}; it must be larger than 0")
    session.check_object(mesh_object)
    number = mirror.AXES.index(axis)
    with mesh_read.open_current_mesh(mesh_object) as mesh:
        joined = topology.read_topology(mesh)
        positions = mesh_read.read_positions(mesh_object, mesh)
        values = {mark: edge_marks.read_marks(mesh, mark) for mark in wanted}
    if len(joined.edges) == 0:
        raise AddonError(f"{mesh_object.name} has no edges")
    is_finite = np.isfinite(positions).all(axis=1)
    if not is_finite.all():
        raise AddonError(
            f"Vertex {int(np.argmin(is_finite))} of {mesh_object.name} has no finite position; move or delete it"
        )
    if method == "POSITION":
        partners = mirror.match_by_position(positions, number, tolerance)
    else:
        partners = mirror.match_by_topology(joined, positions, number, tolerance)
    pairs = partners[joined.edges]
    has_both = (pairs != topology.NO_PARTNER).all(axis=1)
    images = np.full(len(joined.edges), topology.NO_PARTNER)
    images[has_both] = topology.find_edges(joined.edges, joined.vertex_count, pairs[has_both])
    middles = positions[joined.edges].mean(axis=1)[:, number]
    # By its own place and, where a posed side crosses the plane, by which of the two lies further out.
    has_image = images != topology.NO_PARTNER
    side = np.where(has_image, middles - middles[images], 0.0)
    if direction == "BOTH":
        is_taker = has_image
    else:
        is_taker = has_image & (side < 0 if direction == "POSITIVE_TO_NEGATIVE" else side > 0)
    mirrored = {}
    for mark, old in values.items():
        new = old.copy()
        given = old[images[is_taker]]
        new[is_taker] = np.maximum(given, old[is_taker]) if direction == "BOTH" else given
        mirrored[mark] = new
    return CopiedMarks(write_to_object(mesh_object, mirrored), int((~has_image).sum()))


def write_to_object(mesh_object: bpy.types.Object, values: dict[str, np.ndarray]) -> int:
    """Give every edge its marks, in Object Mode or Edit Mode; the number of edges that have others now."""
    mesh = mesh_object.data
    needs_object_mode = "FREESTYLE" in values and edge_marks.has_freestyle_property()
    with edit.leave_edit_mode(mesh_object, needs_object_mode):
        if not mesh.is_editmode:
            is_changed = np.zeros(len(mesh.edges), dtype=bool)
            for mark, wanted in values.items():
                is_different = edge_marks.read_marks(mesh, mark) != wanted
                is_changed |= is_different
                if is_different.any():
                    if mark == "SELECT":
                        edge_marks.select_only(mesh, np.flatnonzero(wanted))
                    else:
                        edge_marks.write_marks(mesh, mark, wanted)
            mesh.update()
            return int(is_changed.sum())
        edited = bmesh.from_edit_mesh(mesh)
        edge_marks.prepare_layers(edited, tuple(values))
        changed: set[int] = set()
        for mark, wanted in values.items():
            changed |= edge_marks.write_bmesh_marks(edited, mark, wanted)
        edited.select_flush_mode()
        bmesh.update_edit_mesh(mesh, loop_triangles=False, destructive=False)
        return len(changed)
