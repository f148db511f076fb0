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
    layers = list_blended_layers(edited)
    corner_models = {
        face: {v.index: c for v, c in zip(face.verts, copy.loops, strict=True)} for face, copy in copies.items()
    }
    for target in targets:
        vertex = vertices[target.vertex]
        triangle = [models[int(v)] for v in target.triangle]
        place = sum((w * v.co for w, v in zip(target.weights.tolist(), triangle, strict=True)), triangle[0].co * 0.0)
        corners = list(vertex.link_loops)
        here = vertex.co.copy()
        vertex.co = place
        for corner in corners:
            # A corner asks what its face carries where its vertex is.
            weigh_corner(corner, copies[corner.face])
        vertex.co = here
        # What went on from face to face goes on: one face of each patch says what all have.
        for layer, name in layers:
            for chart in split_charts(corners, corner_models, layer, name):
                holder = choose_holder(chart, target, place, copies)
                value = get_value(holder, layer, name).copy() if name != "float" else holder[layer]
                for corner in chart:
                    set_value(corner, layer, name, value)
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


def list_blended_layers(edited: BMesh) -> list[tuple[object, str]]:
    """The layers of corners whose values are blended, and the name of their kind."""
    kinds = ("uv", "color", "float_color", "float_vector", "float")
    found = [(name, getattr(edited.loops.layers, name, ())) for name in kinds]
    return [(layers[k], name) for name, layers in found for k in range(len(layers))]


def get_value(corner: BMLoop, layer: object, name: str) -> object:
    """What a corner has in a layer."""
    return corner[layer].uv if name == "uv" else corner[layer]


def set_value(corner: BMLoop, layer: object, name: str, value: object) -> None:
    """Give a corner a value in a layer."""
    if name == "uv":
        corner[layer].uv = value
    else:
        corner[layer] = value


def split_charts(
    corners: Sequence[BMLoop], models: dict[BMFace, dict[int, BMLoop]], layer: object, name: str
) -> list[list[BMLoop]]:
    """The corners at a vertex, in groups within which a layer went on from face to face.

    models : the corners as they were, by the face and the number of the vertex
    """
    left = list(corners)
    charts = []
    while left:
        chart = [left.pop()]
        for corner in chart:
            for other in list(left):
                if is_continued(corner, other, models, layer, name):
                    left.remove(other)
                    chart.append(other)
        charts.append(chart)
    return charts


def is_continued(
    corner: BMLoop, other: BMLoop, models: dict[BMFace, dict[int, BMLoop]], layer: object, name: str
) -> bool:
    """Whether two corners at one vertex are joined by an edge along which the layer was not torn."""
    near = corner.vert.index
    for edge in {corner.edge, corner.link_loop_prev.edge} & {other.edge, other.link_loop_prev.edge}:
        far = edge.other_vert(corner.vert).index
        a, b = models[corner.face], models[other.face]
        if all(get_value(a[v], layer, name) == get_value(b[v], layer, name) for v in (near, far)):
            return True
    return False


def choose_holder(chart: Sequence[BMLoop], target: Target, place: object, copies: dict[BMFace, BMFace]) -> BMLoop:
    """The corner of a chart whose face holds the goal, else that of the nearest face, whose values are drawn out."""
    corners = {int(v) for v, w in zip(target.triangle, target.weights, strict=True) if w > 0.0}
    for corner in chart:
        if corners <= {v.index for v in corner.face.verts}:
            return corner
    return min(chart, key=lambda corner: (copies[corner.face].calc_center_median() - place).length)
