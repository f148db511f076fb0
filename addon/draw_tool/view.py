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
from . import stroke
from .sketch import SketchPick

# The view's axes and, below them, its buttons: pixels at a scale of 1, as Blender lays them out.
GIZMO_MARGIN = 20.0
GIZMO_BUTTONS = 130.0
GIZMO_COLUMN = 45.0
# How far before the viewer of a parallel view a ray begins, as a multiple of the origin's largest coordinate.
BEHIND = 10.0
BOX_SLACK = 1e-6  # of the box's largest side


def is_over_view(area: Any, region: Any, x: int, y: int) -> bool:
    """Whether a place of the window, in its pixels, is on `region` and on no panel, header or toolbar over it."""

    def has(other: Any) -> bool:
        return other.x <= x < other.x + other.width and other.y <= y < other.y + other.height

    # A hidden region is one pixel wide or high.
    return has(region) and not any(
        has(other) for other in area.regions if other != region and min(other.width, other.height) > 1
    )


def is_over_gizmo(context: bpy.types.Context, region: Any, x: int, y: int) -> bool:
    """Whether a place of the window is where the view has its axes and buttons, at the upper right."""
    space, view = context.space_data, context.preferences.view
    if not (space.show_gizmo and space.show_gizmo_navigate) or view.mini_axis_type != "GIZMO":
        return False
    scale = context.preferences.system.ui_scale
    over = [r for r in context.area.regions if r != region and r.type in {"UI", "HEADER", "TOOL_HEADER"}]
    right, top = region.x + region.width, region.y + region.height
    for other in over:
        if min(other.width, other.height) <= 1:
            continue
        if other.type == "UI":
            right = min(right, other.x)
        elif other.y > region.y + region.height / 2:
            top = min(top, other.y)
    size = (view.gizmo_size_navigate_v3d + GIZMO_MARGIN) * scale
    buttons = GIZMO_BUTTONS * scale if view.show_navigate_ui else 0.0
    is_beside_axes = x > right - size and y > top - size
    return is_beside_axes or (x > right - GIZMO_COLUMN * scale and y > top - size - buttons)


def find_ray(region: Any, region_3d: Any, mouse: tuple[float, float]) -> tuple[np.ndarray, np.ndarray]:
    """Origin and direction, in world space, of what the mouse (region pixels) points at."""
    origin = np.array(view3d_utils.region_2d_to_origin_3d(region, region_3d, mouse), dtype=np.float64)
    direction = np.array(view3d_utils.region_2d_to_vector_3d(region, region_3d, mouse), dtype=np.float64)
    if not region_3d.is_perspective and region_3d.view_perspective != "CAMERA":
        # Blender shows what lies behind the viewer of a parallel view, too.
        origin = origin - direction * (1.0 + np.abs(origin).max()) * BEHIND
    return origin, direction


def find_rays_to(region_3d: Any, places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Origins and directions, (N, 3), of rays from the viewer to places in world space, which they reach at 1."""
    to_world = np.array(region_3d.view_matrix.inverted(), dtype=np.float64)
    if region_3d.is_perspective:
        origins = np.broadcast_to(to_world[:3, 3], places.shape)
    else:
        far = np.linalg.norm(places - to_world[:3, 3], axis=1).max() + region_3d.view_distance
        origins = places + BEHIND * far * to_world[:3, 2]
    return origins, places - origins


def measure_pixels(region: Any, region_3d: Any, places: np.ndarray) -> np.ndarray:
    """Length of a pixel, across the view, at places in world space, (N, 3): (N,) in world units."""
    perspective = np.array(region_3d.perspective_matrix, dtype=np.float64)
    depths = places @ perspective[3, :3] + perspective[3, 3]
    return np.abs(2.0 * depths / (region.width * region_3d.window_matrix[0][0]))


def list_candidates(context: bpy.types.Context, ray: tuple[np.ndarray, np.ndarray]) -> list[tuple[float, Any]]:
    """Mesh objects whose boxes a ray meets, each with how far away, nearest first.

    In Edit Mode those that are edited; else those that this view shows: with its local view, and no instances.
    """
    if context.mode == "EDIT_MESH":
        # Their boxes may be of before the edit.
        return [(0.0, mesh_object) for mesh_object in context.objects_in_mode_unique_data]
    graph, found = context.evaluated_depsgraph_get(), []
    for mesh_object in context.visible_objects:
        if mesh_object.type != "MESH" or not mesh_object.visible_get(viewport=context.space_data):
            continue
        box = np.array(mesh_object.evaluated_get(graph).bound_box, dtype=np.float64)
        distance = meet_box(ray, np.array(mesh_object.matrix_world, dtype=np.float64), box.min(axis=0), box.max(axis=0))
        if distance is not None:
            found.append((distance, mesh_object))
    return sorted(found, key=lambda entry: entry[0])


def meet_box(ray: tuple[np.ndarray, np.ndarray], matrix: np.ndarray, low: np.ndarray, high: np.ndarray) -> float | None:
    """How far along a ray of world space a box begins that is given in the space of `matrix`; None where it misses.

    0 where the ray begins inside. Source: T. Kay, J. Kajiya, Ray Tracing Complex Scenes (1986).
    """
    if abs(np.linalg.det(matrix[:3, :3])) == 0.0:
        return None
    inverse = np.linalg.inv(matrix[:3, :3])
    origin, direction = inverse @ (ray[0] - matrix[:3, 3]), inverse @ ray[1]
    # A flat box has some thickness, or rounding would let rays slip through.
    slack = BOX_SLACK * (high - low).max()
    with np.errstate(divide="ignore", invalid="ignore"):
        first, second = (low - slack - origin) / direction, (high + slack - origin) / direction
    near, far = np.nanmax(np.minimum(first, second)), np.nanmin(np.maximum(first, second))
    return max(float(near), 0.0) if max(near, 0.0) <= far else None


def snap(region: Any, region_3d: Any, opened: Surface, triangle: int, mouse: tuple[float, float]) -> np.ndarray:
    """Weights of the vertex or edge's middle of a triangle that is nearest to the mouse."""
    return min(
        list_snaps(opened, triangle),
        key=lambda weights: measure_screen_distance(region, region_3d, place_of(opened, triangle, weights), mouse),
    )


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


def project(region: Any, region_3d: Any, place: Any) -> np.ndarray | None:
    """Region pixels of a place in world space; None behind the viewer."""
    found = view3d_utils.location_3d_to_region_2d(region, region_3d, place)
    return None if found is None else np.array(found)


def measure_screen_distance(region: Any, region_3d: Any, place: Any, mouse: tuple[float, float]) -> float:
    """Pixels between a place and the mouse; infinite behind the viewer."""
    found = project(region, region_3d, place)
    return float("inf") if found is None else float(np.linalg.norm(found - np.array(mouse)))


def find_near_pick(
    region: Any, region_3d: Any, picks: tuple[SketchPick, ...], mouse: tuple[float, float], reach: float
) -> int | None:
    """The pick nearest to the mouse, within `reach` pixels."""
    distances = [measure_screen_distance(region, region_3d, pick.place, mouse) for pick in picks]
    if not distances or min(distances) > reach:
        return None
    return distances.index(min(distances))


def find_leg(
    points: np.ndarray, is_closed: bool, picks: tuple[SketchPick, ...], place: tuple[float, float, float]
) -> int:
    """Where a pick at `place` belongs among the picks of a line: before the one at the returned place.

    points : (N, 3) of the line, which passes through the picks in order
    """
    starts = stroke.find_rows(points, np.array([pick.place for pick in picks]))
    chain = np.concatenate([points, points[:1]]) if is_closed else points
    nearest = int(np.argmin(stroke.measure_piece_distances(np.array([place]), chain)[0]))
    return max(1, int(np.searchsorted(starts, nearest, side="right")))
