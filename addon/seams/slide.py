# SPDX-License-Identifier: GPL-3.0-or-later
"""Moves the vertices of edge paths onto their lines, where this turns no face over, with all that they carry.

A vertex takes along what the surface carries at its new place: shape keys, groups, colours; its corners likewise, each
in the patch of texture that it belongs to. Knows no objects and no modes.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from bmesh.types import BMesh, BMFace, BMLoop, BMVert

from .apply_cut import weigh_corner, weigh_vertex

# Faces may not become flatter against what they were than this cosine, nor corners smaller than this part of a sine.
SMALLEST_COSINE = 0.1
SMALLEST_CORNER = 1e-3


@dataclass(frozen=True)
class Target:
    """Where one vertex of the mesh shall go."""

    vertex: int
    triangle: np.ndarray  # (3,) vertices
    weights: np.ndarray  # (3,)


def slide_vertices(edited: BMesh, targets: Sequence[Target]) -> tuple[list[int], list[int]]:
    """Move the vertices that can be moved; their numbers, and those of the ones that could not be.

    Lookup tables of `edited` must be current. Every shape key moves likewise, on its own surface.
    """
    layers = [edited.verts.layers.shape[k] for k in range(len(edited.verts.layers.shape))]
    shown = [None, *layers]  # the vertices as they are shown, and each shape
    wanted = {target.vertex: target for target in targets}
    vertices = {number: edited.verts[number] for number in wanted}
    sources = {int(v) for target in targets for v in target.triangle} | set(wanted)
    # Where everything was: of each shape, and of the vertices as they are shown.
    shapes = [{v: np.array(edited.verts[v].co) for v in sources}]
    shapes += [{v: np.array(edited.verts[v][layer]) for v in sources} for layer in layers]
    goals = [
        {n: sum(w * shape[int(v)] for w, v in zip(t.weights, t.triangle, strict=True)) for n, t in wanted.items()}
        for shape in shapes
    ]
    faces = {face: [v.index for v in face.verts] for vertex in vertices.values() for face in vertex.link_faces}
    corners = sorted({n for numbers in faces.values() for n in numbers} | set(wanted))
    places = [[edited.verts[n].co if layer is None else edited.verts[n][layer] for n in corners] for layer in shown]
    moved = choose_moves(wanted, faces, corners, np.array(places, dtype=np.float64), goals)
    carry_over(edited, [wanted[n] for n in moved], vertices)
    for number in moved:
        vertices[number].co = goals[0][number]
        for layer, goal in zip(layers, goals[1:], strict=True):
            vertices[number][layer] = goal[number]
    for face in faces:
        face.normal_update()
    stuck = set(wanted) - set(moved)
    return moved, sorted(n for n in stuck if np.linalg.norm(goals[0][n] - shapes[0][n]) > 0.0)


def choose_moves(
    wanted: dict[int, Target],
    faces: dict[BMFace, list[int]],
    corners: Sequence[int],
    places: np.ndarray,
    goals: Sequence[dict[int, np.ndarray]],
) -> list[int]:
    """Which vertices can go to their goals together, in every shape; found greedily, the most that fit first.

    places : (S, len(corners), 3) where the corners of the faces are, in every shape
    """
    row = {number: k for k, number in enumerate(corners)}
    faces_of: dict[int, list[int]] = {n: [] for n in wanted}
    rows = [np.array([row[n] for n in numbers]) for numbers in faces.values()]
    numbers_of = list(faces.values())
    for face, numbers in enumerate(numbers_of):
        for n in numbers:
            if n in faces_of:
                faces_of[n].append(face)
    # A goal beyond the faces around a vertex would fold them.
    moving = {n for n in wanted if is_around(wanted[n], [numbers_of[face] for face in faces_of[n]])}
    now = places.copy()

    def put(number: int, is_moved: bool) -> None:
        for shape, goal in enumerate(goals):
            now[shape, row[number]] = goal[number] if is_moved else places[shape, row[number]]

    def is_turned(face: int) -> bool:
        return bool(is_turned_over(places[:, rows[face]], now[:, rows[face]]).any())

    for number in moving:
        put(number, True)
    lengths = {n: float(np.linalg.norm(goals[0][n] - places[0, row[n]])) for n in wanted}
    held: list[int] = []
    waiting = find_turned(range(len(rows)), rows, places, now)
    while waiting:
        stopped = []
        # Of each face that turns over, the vertex that goes furthest stays.
        for face in waiting:
            candidates = moving.intersection(numbers_of[face])
            if candidates and is_turned(face):
                furthest = max(candidates, key=lambda n: (lengths[n], n))
                moving.discard(furthest)
                put(furthest, False)
                stopped.append(furthest)
        held += stopped
        waiting = list(dict.fromkeys(face for number in stopped for face in faces_of[number]))
    # One by one, those that stayed for the sake of others that stayed too.
    for number in sorted(held, key=lambda n: (lengths[n], n)):
        put(number, True)
        if any(is_turned(face) for face in faces_of[number]):
            put(number, False)
        else:
            moving.add(number)
    return sorted(moving)


def find_turned(faces: Iterable[int], rows: Sequence[np.ndarray], places: np.ndarray, now: np.ndarray) -> list[int]:
    """The faces that are turned over in some shape; all of one number of corners are looked at together."""
    by_size: dict[int, list[int]] = {}
    for face in faces:
        by_size.setdefault(len(rows[face]), []).append(face)
    turned = []
    for chosen in by_size.values():
        corners = np.array([rows[face] for face in chosen])
        is_turned = is_turned_over(places[:, corners], now[:, corners]).any(axis=0)
        turned += [face for face, is_one in zip(chosen, is_turned.tolist(), strict=True) if is_one]
    return turned


def is_around(target: Target, around: Sequence[Sequence[int]]) -> bool:
    """Whether the goal lies in one of the faces around the vertex, given by their vertices."""
    corners = {int(v) for v, w in zip(target.triangle, target.weights, strict=True) if w > 0.0}
    return any(corners <= set(numbers) for numbers in around)


def is_turned_over(before: np.ndarray, after: np.ndarray) -> np.ndarray:
    """Which faces look another way, or have a corner turned in or gone that stood out; corners (..., N, 3) in order."""
    normals, new_normals = find_normals(before), find_normals(after)
    lengths, new_lengths = np.linalg.norm(normals, axis=-1), np.linalg.norm(new_normals, axis=-1)
    cosines = np.einsum("...i,...i->...", normals, new_normals)
    is_away = cosines <= SMALLEST_COSINE * lengths * new_lengths
    is_corner_lost = (is_standing_out(before, normals) & ~is_standing_out(after, new_normals)).any(axis=-1)
    return (lengths > 0.0) & (is_away | is_corner_lost)  # without an area it never looked anywhere


def find_normals(corners: np.ndarray) -> np.ndarray:
    """Twice the area, along the normal of each polygon (M. Newell's sum)."""
    return np.cross(corners, np.roll(corners, -1, axis=-2)).sum(axis=-2)


def is_standing_out(corners: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """Which corners turn the way their polygon does, each by more than rounding."""
    ahead = np.roll(corners, -1, axis=-2) - corners
    behind = corners - np.roll(corners, 1, axis=-2)
    turns = np.einsum("...ki,...i->...k", np.cross(behind, ahead), normals)
    lengths = np.linalg.norm(ahead, axis=-1) * np.linalg.norm(behind, axis=-1)
    return turns > SMALLEST_CORNER * lengths * np.linalg.norm(normals, axis=-1)[..., None]


def carry_over(edited: BMesh, targets: Sequence[Target], vertices: dict[int, BMVert]) -> None:
    """Give moved vertices and their corners what the surface carries at their goals; their places stay for now."""
    # Copies of all that is read, since neighbours may move too.
    originals = {n: edited.verts[n] for n in collect_corners(targets, vertices)}
    models = {n: edited.verts.new(original.co, original) for n, original in originals.items()}
    around = {face for target in targets for face in vertices[target.vertex].link_faces}
    copies: dict[BMFace, BMFace] = {}
    for face in around:
        copy = edited.faces.new([models[v.index] for v in face.verts], face)
        for corner, old in zip(copy.loops, face.loops, strict=True):
            corner.copy_from(old)
        copy.normal_update()
        copies[face] = copy
    for target in targets:
        vertex = vertices[target.vertex]
        triangle = [models[int(v)] for v in target.triangle]
        place = sum((w * v.co for w, v in zip(target.weights.tolist(), triangle, strict=True)), triangle[0].co * 0.0)
        charts = split_charts(edited, vertex)
        for chart in charts:
            holder = choose_holder(chart, target, place, copies)
            for corner in chart:
                # The corner itself asks what the face carries at the goal.
                here = corner.vert.co.copy()
                corner.vert.co = place
                weigh_corner(corner, copies[holder])
                corner.vert.co = here
        weigh_vertex(edited, vertex, triangle, target.weights)
    for copy in copies.values():
        edited.faces.remove(copy)
    for model in models.values():
        edited.verts.remove(model)


def collect_corners(targets: Sequence[Target], vertices: dict[int, BMVert]) -> set[int]:
    """Numbers of all vertices of the faces around those that move, and of the triangles that they go to."""
    numbers = {int(v) for target in targets for v in target.triangle}
    for target in targets:
        for face in vertices[target.vertex].link_faces:
            numbers.update(v.index for v in face.verts)
    return numbers


def split_charts(edited: BMesh, vertex: BMVert) -> list[list[BMLoop]]:
    """The corners at a vertex, in groups within which every UV map goes on from face to face."""
    maps = [edited.loops.layers.uv[k] for k in range(len(edited.loops.layers.uv))]
    left = list(vertex.link_loops)
    charts = []
    while left:
        chart = [left.pop()]
        for corner in chart:
            for other in list(left):
                if is_continued(corner, other, maps):
                    left.remove(other)
                    chart.append(other)
        charts.append(chart)
    return charts


def is_continued(corner: BMLoop, other: BMLoop, maps: Sequence[object]) -> bool:
    """Whether two corners at one vertex are joined by an edge along which no UV map is torn."""
    for edge in {corner.edge, corner.link_loop_prev.edge} & {other.edge, other.link_loop_prev.edge}:
        far = edge.other_vert(corner.vert)
        a = next(loop for loop in corner.face.loops if loop.vert == far)
        b = next(loop for loop in other.face.loops if loop.vert == far)
        if all(corner[m].uv == other[m].uv and a[m].uv == b[m].uv for m in maps):
            return True
    return False


def choose_holder(chart: Sequence[BMLoop], target: Target, place: object, copies: dict[BMFace, BMFace]) -> BMFace:
    """The face of a chart that holds the goal, else the one nearest to it, whose texture is then drawn out."""
    corners = {int(v) for v, w in zip(target.triangle, target.weights, strict=True) if w > 0.0}
    for corner in chart:
        if corners <= {v.index for v in corner.face.verts}:
            return corner.face
    return min((corner.face for corner in chart), key=lambda face: (copies[face].calc_center_median() - place).length)
