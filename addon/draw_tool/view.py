# SPDX-License-Identifier: GPL-3.0-or-later
"""Between the screen and the surface: rays under the mouse, snapping, and what lies near the mouse.

Reads a region and an opened surface; changes nothing.
"""

import itertools
from typing import Any

import numpy as np
from bpy_extras import view3d_utils

import bpy

from ..surface import Surface
from .sketch import SketchPick


def is_over_view(area: Any, region: Any, x: int, y: int) -> bool:
    """Whether a place of the window, in its pixels, is on `region` and on no panel, header or toolbar over it."""

    def has(other: Any) -> bool:
        return other.x <= x < other.x + other.width and other.y <= y < other.y + other.height

    # A hidden region is one pixel wide or high.
    return has(region) and not any(
        has(other) for other in area.regions if other != region and min(other.width, other.height) > 1
    )


def find_ray(context: bpy.types.Context, mouse: tuple[float, float]) -> tuple[Any, Any]:
    """Origin and direction, in world space, of what the mouse (region pixels) points at."""
    region, region_3d = context.region, context.region_data
    return (
        view3d_utils.region_2d_to_origin_3d(region, region_3d, mouse),
        view3d_utils.region_2d_to_vector_3d(region, region_3d, mouse),
    )


def find_pick(context: bpy.types.Context, opened: Surface, mouse: tuple[float, float], is_snapped: bool) -> Any:
    """The pick under the mouse (region pixels), or None beside the surface; snapped to a vertex or an edge's middle."""
    origin, direction = find_ray(context, mouse)
    hits = opened.library_mesh.ray_cast(np.array([origin]), np.array([direction]))
    triangle = int(hits.triangles[0])
    if triangle < 0:
        return None
    weights = hits.barycentric[0]
    if is_snapped:
        weights = min(
            list_snaps(opened, triangle),
            key=lambda snap: measure_screen_distance(context, place_of(opened, triangle, snap), mouse),
        )
    place = place_of(opened, triangle, weights)
    return SketchPick(triangle, tuple(float(w) for w in weights), tuple(float(x) for x in place))


def place_of(opened: Surface, triangle: int, weights: np.ndarray) -> np.ndarray:
    """A point of a triangle in world space."""
    return np.asarray(weights) @ opened.arrays.world_positions[opened.arrays.triangles[triangle]]


def mirror_picks(opened: Surface, picks: tuple[SketchPick, ...], axes: tuple[bool, bool, bool]) -> list[list[Any]]:
    """The picks on the other sides of the object's own planes, one list for each combination of mirrored axes.

    Each is the point of the surface nearest to the mirrored place, so the mesh need not be quite symmetric.
    """
    matrix = opened.arrays.world_matrix
    places = np.array([pick.place for pick in picks]).reshape(-1, 3)
    local = np.linalg.solve(matrix[:3, :3], (places - matrix[:3, 3]).T).T
    mirrored = []
    for signs in itertools.product(*[(1, -1) if is_on else (1,) for is_on in axes]):
        if min(signs) < 0 and len(picks) > 0:
            there = (local * signs) @ matrix[:3, :3].T + matrix[:3, 3]
            mirrored.append(opened.library_mesh.closest_points(there).surface_points)
    return mirrored


def list_snaps(opened: Surface, triangle: int) -> list[np.ndarray]:
    """Weights of the vertices of a triangle, and of the middles of its edges that are edges of the mesh."""
    arrays = opened.arrays
    corners = arrays.triangles[triangle]
    snaps = list(np.eye(3))
    same_face = arrays.triangles[arrays.triangle_faces == arrays.triangle_faces[triangle]]
    for k in range(3):
        ends = corners[[k, (k + 1) % 3]]
        # A diagonal is shared by two triangles of one face.
        if (np.isin(same_face, ends).sum(axis=1) == 2).sum() == 1:
            snaps.append((np.eye(3)[k] + np.eye(3)[(k + 1) % 3]) / 2)
    return snaps


def project(context: bpy.types.Context, place: Any) -> np.ndarray | None:
    """Region pixels of a place in world space; None behind the viewer."""
    found = view3d_utils.location_3d_to_region_2d(context.region, context.region_data, place)
    return None if found is None else np.array(found)


def measure_screen_distance(context: bpy.types.Context, place: Any, mouse: tuple[float, float]) -> float:
    """Pixels between a place and the mouse; infinite behind the viewer."""
    found = project(context, place)
    return float("inf") if found is None else float(np.linalg.norm(found - np.array(mouse)))


def find_near_pick(
    context: bpy.types.Context, picks: tuple[SketchPick, ...], mouse: tuple[float, float], reach: float
) -> int | None:
    """The pick nearest to the mouse, within `reach` pixels."""
    distances = [measure_screen_distance(context, pick.place, mouse) for pick in picks]
    if not distances or min(distances) > reach:
        return None
    return distances.index(min(distances))


def find_leg(
    points: np.ndarray, is_closed: bool, picks: tuple[SketchPick, ...], place: tuple[float, float, float]
) -> int:
    """Where a pick at `place` belongs among the picks of a line: before the one at the returned place.

    points : (N, 3) of the line, which passes through the picks in order
    """
    begin, starts = 0, []
    for pick in picks:
        begin += int(np.argmin(np.linalg.norm(points[begin:] - pick.place, axis=1)))
        starts.append(begin)
    ends = np.roll(points, -1, axis=0)
    segments = ends - points
    squares = (segments**2).sum(axis=1)
    parts = np.clip(((np.array(place) - points) * segments).sum(axis=1) / np.where(squares > 0, squares, 1), 0, 1)
    distances = np.linalg.norm(points + parts[:, None] * segments - place, axis=1)
    nearest = int(np.argmin(distances if is_closed else distances[:-1]))
    return max(1, int(np.searchsorted(starts, nearest, side="right")))
