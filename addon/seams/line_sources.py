# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the lines come from that are put into a mesh: curves that remember, any curve or grease pencil, points, picks.

All become the library's polylines on the opened surface. Changes nothing in the file.
"""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

import bpy

from .. import ahead, mesh_read, session, surface
from ..errors import ObjectError
from ..live import memory
from . import strokes

# Drawn lines further from the surface than this part of the mesh's bounding-box diagonal were meant for another one.
LARGEST_DISTANCE = 0.05


def make_lines(
    context: bpy.types.Context,
    mesh_object: bpy.types.Object,
    sources: Sequence[Any],
    opened: surface.Surface,
    *,
    max_distance: float | None = None,
    **line_options: Any,
) -> list[Any]:
    """The library's polylines on `opened`, one or more for each source, in order.

    sources : polylines of the library on this surface (taken as they are), curve or grease pencil objects, or points in
        world space, (N, 3), or a pair of such points and whether they are closed
    max_distance : in world units; a drawn line further off is refused; None: LARGEST_DISTANCE of the mesh's diagonal
    line_options : how drawn lines are smoothed, as for `SurfaceMesh.stroke`, with `detail_size` in the object's units;
        none: exactly along the drawn points

    Raises ObjectError, or the library's errors.
    """
    if len(sources) == 0:
        raise ObjectError(
            f"There is no line to put into {mesh_object.name}; select a curve that lies on it, or pick faces in order"
        )
    lines = []
    for source in sources:
        if hasattr(source, "segment_triangles"):
            lines.append(take_over(source, opened))
        elif isinstance(source, bpy.types.Object):
            lines += list(make_lines_of_object(context, mesh_object, source, opened, max_distance, line_options))
        else:
            points, closed = source if isinstance(source, tuple) and len(source) == 2 else (source, False)
            lines.append(project(points, closed, opened, "The line", max_distance, line_options))
    return lines


def make_lines_of_object(
    context: bpy.types.Context,
    mesh_object: bpy.types.Object,
    source: bpy.types.Object,
    opened: surface.Surface,
    max_distance: float | None,
    line_options: dict[str, Any],
) -> Iterator[Any]:
    """One line made again from what a curve remembers, else each drawn stroke projected to the surface."""
    if is_remembered_on(source, mesh_object):
        yield take_over(session.compute_remembered(context, source.data)[0].line, opened)
        return
    drawn = strokes.read_strokes(context, source)
    if not drawn:
        raise ObjectError(f"{source.name} has no line: draw one, or select another curve or grease pencil")
    for stroke in drawn:
        yield project(stroke.points, stroke.closed, opened, source.name, max_distance, line_options)


def take_over(line: Any, opened: surface.Surface) -> Any:
    """The same line on `opened`, from whichever opening of the same mesh it comes: lines are cut on one alone."""
    return opened.library_mesh.line_from_bytes(line.to_bytes())


def is_remembered_on(source: bpy.types.Object, mesh_object: bpy.types.Object) -> bool:
    """Whether `source` is a line that was made on the base mesh of `mesh_object`, and can be made again on it."""
    known = memory.find_memory(source)
    return known is not None and known.surface == mesh_object and known.source == "BASE"


def project(
    points: Any,
    closed: bool,
    opened: surface.Surface,
    name: str,
    max_distance: float | None,
    line_options: dict[str, Any],
) -> Any:
    """The library's polyline along drawn points in world space; ObjectError when they are not near the surface."""
    options = {**(line_options or {"filter": "geodesic", "pinned": "all"}), "closed": closed}
    if options.get("detail_size") is not None:
        options["detail_size"] *= mesh_read.measure_mean_scale(opened.arrays.world_matrix)
    line = ahead.do(
        lambda: np.asarray(points, dtype=np.float64),
        lambda drawn, stops: opened.library_mesh.stroke(drawn, **options, **stops),
    )
    diagonal = float(np.linalg.norm(np.ptp(opened.arrays.world_positions, axis=0)))
    limit = LARGEST_DISTANCE * diagonal if max_distance is None else max_distance
    if line.report.stroke_distance > limit:
        raise ObjectError(
            f"{name} is up to {line.report.stroke_distance:.4g} away from the mesh, more than {limit:.4g}; draw "
            "it on the surface, or allow a larger distance (Max Distance)"
        )
    return line
