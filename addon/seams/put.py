# SPDX-License-Identifier: GPL-3.0-or-later
"""Puts lines into a mesh, as one plain function for scripts, batch runs and operators: `put_lines_into_mesh`.

Reads, then computes, then writes: whatever is refused is refused before the mesh has been changed. Holds no
geometry (the library's) and no messages to the artist (the operators').
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

import bpy

import bmesh

from .. import line_points, mesh_read, session, surface
from ..errors import AddonError
from . import align, apply_cut, edge_marks, edit, line_sources, slide, topology
from . import unwrap as unwrapping

METHODS = ("SNAP", "SLIDE", "CUT")
# The library's own, as a part of an edge or of a triangle's height.
DEFAULT_TOLERANCE = 1e-3


@dataclass
class PutLines:
    """What `put_lines_into_mesh` has done."""

    method: str
    edges: np.ndarray  # (E,) int: the marked edges, as numbered in the mesh now
    lines: list[Any]  # the library's polylines
    new_vertices: int = 0
    new_faces: int = 0
    moved: list[int] = field(default_factory=list)  # SLIDE: vertices that lie on a line now
    not_moved: list[int] = field(default_factory=list)  # SLIDE: vertices that would have turned a face over
    distance: float = 0.0  # SNAP: the largest distance of a marked edge from its line, in world units
    crossings: int = 0  # CUT: places where lines cross each other or themselves
    sharing: list[str] = field(default_factory=list)  # other objects with the same mesh, which has changed for them too
    islands: Any = None  # of `unwrap.unwrap_and_measure`, when asked for


def put_lines_into_mesh(
    context: bpy.types.Context,
    mesh_object: bpy.types.Object,
    lines: Sequence[Any],
    *,
    method: str = "CUT",
    marks: Sequence[str] = ("SEAM",),
    weight: float = 1.0,
    tolerance: float | None = None,
    max_distance: float | None = None,
    unwrap: bool = False,
    **line_options: Any,
) -> PutLines:
    """Make lines a part of the mesh, in Object Mode or Edit Mode, and mark their edges.

    lines : curve objects that remember; any curve or grease pencil objects near the surface; points in world space,
        (N, 3) or (points, closed); the library's polylines on `surface.open_surface(context, mesh_object)`
    method : SNAP: the path of existing edges nearest to each line, the mesh stays as it is; SLIDE: the vertices of that
        path are moved onto the line where this turns no face over; CUT: faces are cut along the line
    marks : any of SEAM, SHARP, CREASE, BEVEL_WEIGHT, FREESTYLE, SELECT
    weight : of creases and bevels, 0 to 1
    tolerance : CUT: how near to a vertex or an edge, as a part of it, the line goes through it; None: the library's
    max_distance : world units: a drawn line further from the surface is refused; None: 0.05 of the mesh's diagonal
    unwrap : unwrap the UV map by the seams and measure the islands
    line_options : how drawn lines are smoothed, as `SurfaceMesh.stroke` takes them; none: along the drawn points

    Returns a `PutLines`: the edges of the lines as they are numbered now, what was added or moved, what could not be.
    Raises AddonError, or the library's `smooth_polylines.Error`; the mesh is as it was then.
    """
    if method not in METHODS:
        raise AddonError(f"method is {method!r}; it must be one of {', '.join(METHODS)}")
    chosen = edge_marks.check_marks(marks)
    session.check_object(mesh_object)
    edit.check_mode(mesh_object)
    if unwrap:
        unwrapping.check_unwrappable(context, mesh_object)
    if method != "SNAP":
        edit.check_changeable(mesh_object, "cut" if method == "CUT" else "moved")
    opened = surface.open_surface(context, mesh_object)
    made = line_sources.make_lines(context, mesh_object, lines, opened, max_distance=max_distance, **line_options)
    with edit.leave_edit_mode(mesh_object, needs_object_mode(mesh_object, method, chosen)):
        if method == "CUT":
            result = cut_lines(mesh_object, opened, made, tolerance)
        else:
            result = follow_paths(mesh_object, opened, made, method)
        set_marks(mesh_object, result.edges, chosen, weight)
    if method != "SNAP":
        result.sharing = edit.find_sharing_objects(mesh_object)
    if unwrap:
        result.islands = unwrapping.unwrap_and_measure(context, mesh_object)
    return result


def needs_object_mode(mesh_object: bpy.types.Object, method: str, chosen: Sequence[str]) -> bool:
    """Whether something is to be done that cannot be done in Edit Mode: custom normals; Freestyle in older versions."""
    has_normals = method != "SNAP" and mesh_object.data.has_custom_normals
    return has_normals or ("FREESTYLE" in chosen and edge_marks.has_freestyle_property())


def cut_lines(
    mesh_object: bpy.types.Object, opened: surface.Surface, made: Sequence[Any], tolerance: float | None
) -> PutLines:
    """Cut the faces along all lines at once."""
    options = {} if tolerance is None else {"tolerance": tolerance}
    cut = opened.library_mesh.cut(list(made), **options)
    applied = apply_to_object(mesh_object, cut, opened.arrays)
    return PutLines(
        "CUT",
        np.unique(applied.line_edges),
        list(made),
        new_vertices=len(cut.vertex_triangles),
        new_faces=applied.new_faces,
        crossings=len(cut.crossings),
    )


@dataclass(frozen=True)
class AppliedCut:
    """What a cut has become in the mesh."""

    line_edges: np.ndarray  # (E,) the edges' numbers, as `cut.line_edges`
    polygon_faces: np.ndarray  # (P,) the faces' numbers, as `cut.polygon_parents`
    new_faces: int


def apply_to_object(mesh_object: bpy.types.Object, cut: Any, arrays: mesh_read.MeshArrays) -> AppliedCut:
    """Carry out a cut of the library's, in Object Mode or Edit Mode."""
    with edit.open_bmesh(mesh_object) as edited:
        before = len(edited.faces)
        applied = apply_cut.apply_cut(edited, cut, arrays.local_positions, arrays.triangles)
        edited.edges.index_update()
        edited.faces.index_update()
        polygon_faces = np.array(cut.polygon_parents, dtype=np.int64)
        for row, face in applied.pieces.items():
            polygon_faces[row] = face.index
        line_edges = np.array([edge.index for edge in applied.line_edges], dtype=np.int64)
        return AppliedCut(line_edges, polygon_faces, len(edited.faces) - before)


def follow_paths(mesh_object: bpy.types.Object, opened: surface.Surface, made: Sequence[Any], method: str) -> PutLines:
    """Mark existing edges, and for SLIDE move their vertices."""
    paths = [line.edge_path() for line in made]
    pairs = np.concatenate([np.asarray(path.edges, dtype=np.int64).reshape(-1, 2) for path in paths])
    with mesh_read.open_current_mesh(mesh_object) as mesh:
        edges = topology.find_edges(edge_marks.read_edge_vertices(mesh), len(mesh.vertices), pairs)
    edges = np.unique(edges[edges != topology.NO_PARTNER])
    result = PutLines(method, edges, list(made), distance=max((path.distance["max"] for path in paths), default=0.0))
    if method == "SLIDE":
        targets = [target for line, path in zip(made, paths, strict=True) for target in aim(line, path, opened.arrays)]
        # Where lines meet, the first one has the vertex.
        unique = {target.vertex: target for target in reversed(targets)}
        with edit.open_bmesh(mesh_object) as edited:
            edited.verts.ensure_lookup_table()
            result.moved, result.not_moved = slide.slide_vertices(edited, list(unique.values()))
    return result


def aim(line: Any, path: Any, arrays: mesh_read.MeshArrays) -> list[slide.Target]:
    """Where the vertices of a path shall go on their line."""
    numbers = np.asarray(path.vertices, dtype=np.int64)
    if len(numbers) == 0 or len(line.points) < 2:
        return []
    segments, along = align.align_path(arrays.world_positions[numbers], line.points, line.closed)
    corners = arrays.triangles[line.segment_triangles[segments]]
    following = (segments + 1) % len(line.points)
    vertices = arrays.triangles[line.triangles]
    start, end = (
        line_points.weigh_corners(corners, vertices[rows], line.barycentric[rows]) for rows in (segments, following)
    )
    weights = (1.0 - along[:, None]) * start + along[:, None] * end
    return [
        slide.Target(int(number), corners[k], weights[k] / weights[k].sum())
        for k, number in enumerate(numbers.tolist())
    ]


def set_marks(mesh_object: bpy.types.Object, edges: np.ndarray, chosen: Sequence[str], weight: float) -> None:
    """Mark the edges of these numbers, in Object Mode or Edit Mode."""
    mesh = mesh_object.data
    if not chosen or len(edges) == 0:
        return
    if not mesh.is_editmode:
        edge_marks.mark_mesh_edges(mesh, edges.tolist(), chosen, weight)
        return
    edited = bmesh.from_edit_mesh(mesh)
    edge_marks.prepare_layers(edited, chosen)
    edited.edges.ensure_lookup_table()
    edge_marks.mark_bmesh_edges(edited, [edited.edges[edge] for edge in edges.tolist()], chosen, weight)
    bmesh.update_edit_mesh(mesh, loop_triangles=False, destructive=False)
