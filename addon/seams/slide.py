# SPDX-License-Identifier: GPL-3.0-or-later
"""Moves the vertices of edge paths onto their lines, where this turns no face over, with all that they carry.

A vertex takes along what the surface carries at its new place: shape keys, groups, colours; its corners likewise, each
in the patch of texture that it belongs to. Knows no objects and no modes.
"""

from collections.abc import Sequence
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
    known = [read_shape(faces, edited, None)] + [read_shape(faces, edited, layer) for layer in layers]
    moved = choose_moves(list(wanted), faces, known, goals, wanted)
    carry_over(edited, [wanted[n] for n in moved], vertices)
    for number in moved:
        vertices[number].co = goals[0][number]
        for layer, goal in zip(layers, goals[1:], strict=True):
            vertices[number][layer] = goal[number]
    for face in faces:
        face.normal_update()
    stuck = set(wanted) - set(moved)
    return moved, sorted(n for n in stuck if np.linalg.norm(goals[0][n] - shapes[0][n]) > 0.0)


def read_shape(faces: dict[BMFace, list[int]], edited: BMesh, layer: object) -> dict[int, np.ndarray]:
    """Places of all corners of the faces in one shape; None: as shown."""
    numbers = {n for corners in faces.values() for n in corners}
    return {n: np.array(edited.verts[n].co if layer is None else edited.verts[n][layer]) for n in numbers}


def choose_moves(
    numbers: Sequence[int],
    faces: dict[BMFace, list[int]],
    shapes: Sequence[dict[int, np.ndarray]],
    goals: Sequence[dict[int, np.ndarray]],
    wanted: dict[int, Target],
) -> list[int]:
    """Which vertices can go to their goals together, in every shape; found greedily, the most that fit first."""
    faces_of: dict[int, list[BMFace]] = {n: [] for n in numbers}
    for face, corners in faces.items():
        for n in corners:
            if n in faces_of:
                faces_of[n].append(face)

    # A goal beyond the faces around a vertex would fold them.
    moving = {n for n in numbers if is_around(wanted[n], faces, faces_of[n])}

    def is_turned(face: BMFace) -> bool:
        corners = faces[face]
        return any(
            is_turned_over(
                np.array([shape[n] for n in corners]), np.array([goal[n] if n in moving else shape[n] for n in corners])
            )
            for shape, goal in zip(shapes, goals, strict=True)
        )

    waiting = [face for face in faces if moving.intersection(faces[face])]
    held: list[int] = []
    while waiting:
        stopped = []
        # Of each face that turns over, the vertex that goes furthest stays.
        for face in waiting:
            candidates = moving.intersection(faces[face])
            if candidates and is_turned(face):
                furthest = max(candidates, key=lambda n: (np.linalg.norm(goals[0][n] - shapes[0][n]), n))
                moving.discard(furthest)
                stopped.append(furthest)
        held += stopped
        waiting = list(dict.fromkeys(face for number in stopped for face in faces_of[number]))
    # One by one, those that stayed for the sake of others that stayed too.
    for number in sorted(held, key=lambda n: (np.linalg.norm(goals[0][n] - shapes[0][n]), n)):
        moving.add(number)
        if any(is_turned(face) for face in faces_of[number]):
            moving.discard(number)
    return sorted(moving)


def is_around(target: Target, faces: dict[BMFace, list[int]], around: Sequence[BMFace]) -> bool:
    """Whether the goal lies in a face of the vertex."""
    corners = {int(v) for v, w in zip(target.triangle, target.weights, strict=True) if w > 0.0}
    return any(corners <= set(faces[face]) for face in around)


def is_turned_over(before: np.ndarray, after: np.ndarray) -> bool:
    """Whether a face looks another way, or a corner that stood out is turned in or gone; (N, 3) corners in order."""
    normal = find_normal(before)
    length = np.linalg.norm(normal)
    if length == 0.0:
        return False  # it never looked anywhere
    normal /= length
    new_normal = find_normal(after)
    new_length = np.linalg.norm(new_normal)
    if new_length == 0.0 or new_normal @ normal < SMALLEST_COSINE * new_length:
        return True
    return bool((is_standing_out(before, normal) & ~is_standing_out(after, new_normal / new_length)).any())


def find_normal(corners: np.ndarray) -> np.ndarray:
    """Twice the area, along the normal of a polygon (M. Newell's sum)."""
    return np.cross(corners, np.roll(corners, -1, axis=0)).sum(axis=0)


def is_standing_out(corners: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """Which corners turn the way the polygon does, each by more than rounding."""
    ahead = np.roll(corners, -1, axis=0) - corners
    behind = corners - np.roll(corners, 1, axis=0)
    lengths = np.linalg.norm(ahead, axis=1) * np.linalg.norm(behind, axis=1)
    return np.cross(behind, ahead) @ normal > SMALLEST_CORNER * lengths


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
        weigh_vertex(vertex, triangle, target.weights)
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
