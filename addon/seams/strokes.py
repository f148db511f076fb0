# SPDX-License-Identifier: GPL-3.0-or-later
"""Points of what artists draw: splines of curves, hair curves, grease pencil of either kind; in world space.

Reads only; knows no mesh and no surface.
"""

from dataclasses import dataclass

import numpy as np

import bpy

# What can hold lines; the names of grease pencil before and after it was rebuilt.
LINE_TYPES = {"CURVE", "CURVES", "GPENCIL", "GREASEPENCIL"}


def is_line(candidate: bpy.types.Object) -> bool:
    """Whether an object is a line or lines: of the types that are, or a mesh of edges alone."""
    if candidate.type == "MESH":
        return len(candidate.data.polygons) == 0 and len(candidate.data.edges) > 0 and candidate.mode == "OBJECT"
    return candidate.type in LINE_TYPES


@dataclass(frozen=True)
class Stroke:
    """Points in world space, (N, 3) float64; a closed one does not repeat its first."""

    points: np.ndarray
    closed: bool


def read_strokes(context: bpy.types.Context, source: bpy.types.Object) -> list[Stroke]:
    """The lines of a curve or grease pencil object, as seen at the current frame; those of one point are left out."""
    readers = {
        "CURVE": read_splines,
        "CURVES": read_hair,
        "MESH": read_loose_edges,
        "GPENCIL": read_old_pencil,
        "GREASEPENCIL": read_pencil,
    }
    if source.type not in readers:
        return []
    matrix = np.array(source.matrix_world, dtype=np.float64)
    found = []
    for points, closed in readers[source.type](context, source):
        if len(points) > 1:
            world = np.asarray(points, dtype=np.float64) @ matrix[:3, :3].T + matrix[:3, 3]
            found.append(Stroke(world, closed))
    return found


def read_splines(context: bpy.types.Context, source: bpy.types.Object) -> list[tuple[np.ndarray, bool]]:
    """Splines of any kind at the resolution they are shown with, without their tube, fill and modifiers."""
    plain = source.data.copy()
    plain.bevel_depth, plain.extrude, plain.bevel_object, plain.taper_object = 0.0, 0.0, None, None
    plain.offset = 0.0
    plain.dimensions = "3D"
    plain.bevel_mode = "ROUND"
    carrier = bpy.data.objects.new("Splines", plain)
    try:
        mesh = carrier.to_mesh()
        if mesh is None:  # no splines
            return []
        positions = np.empty((len(mesh.vertices), 3), dtype=np.float32)
        mesh.vertices.foreach_get("co", positions.ravel())
        ends = np.empty(len(mesh.edges) * 2, dtype=np.int32)
        mesh.edges.foreach_get("vertices", ends)
        carrier.to_mesh_clear()
    finally:
        bpy.data.objects.remove(carrier)
        bpy.data.curves.remove(plain)
    return split_chains(positions, ends.reshape(-1, 2))


def split_chains(positions: np.ndarray, edges: np.ndarray) -> list[tuple[np.ndarray, bool]]:
    """Runs of vertices that follow one another; closed where an edge leads back to the start of its run."""
    steps = edges[np.abs(edges[:, 1] - edges[:, 0]) == 1].min(axis=1)
    is_joined = np.zeros(max(len(positions) - 1, 0), dtype=bool)
    is_joined[steps] = True
    starts = np.concatenate([[0], np.flatnonzero(~is_joined) + 1])
    stops = np.concatenate([starts[1:], [len(positions)]])
    long_edges = {tuple(sorted(edge)) for edge in edges.tolist()}
    return [
        (positions[start:stop], stop - start > 2 and (int(start), int(stop - 1)) in long_edges)
        for start, stop in zip(starts, stops, strict=True)
        if stop > start
    ]


def read_loose_edges(_context: bpy.types.Context, source: bpy.types.Object) -> list[tuple[np.ndarray, bool]]:
    """Chains of edges of a mesh without faces, each from one branching or end to the next; rings are closed."""
    mesh = source.data
    if len(mesh.polygons) > 0:
        return []
    positions = np.array([vertex.co for vertex in mesh.vertices], dtype=np.float64).reshape(-1, 3)
    neighbours: dict[int, list[int]] = {}
    for a, b in (edge.vertices for edge in mesh.edges):
        neighbours.setdefault(a, []).append(b)
        neighbours.setdefault(b, []).append(a)
    ends = [vertex for vertex, near in neighbours.items() if len(near) != 2]
    walked: set[tuple[int, int]] = set()
    found = []
    for start in [*ends, *neighbours]:  # rings have no ends: they begin anywhere
        for step in neighbours[start]:
            chain = [start]
            while (chain[-1], step) not in walked:
                walked |= {(chain[-1], step), (step, chain[-1])}
                chain.append(step)
                if len(neighbours[step]) != 2 or step == start:
                    break
                step = next((near for near in neighbours[step] if near != chain[-2]), chain[-2])
            if len(chain) > 1:
                closed = chain[0] == chain[-1]
                found.append((positions[chain[:-1] if closed else chain], closed))
    return found


def read_hair(_context: bpy.types.Context, source: bpy.types.Object) -> list[tuple[np.ndarray, bool]]:
    """The points of the newer kind of curves."""
    curves = source.data
    positions = np.empty((len(curves.points), 3), dtype=np.float32)
    curves.points.foreach_get("position", positions.ravel())
    cyclic = curves.attributes.get("cyclic")
    found = []
    for index, curve in enumerate(curves.curves):
        first = curve.first_point_index
        closed = cyclic is not None and bool(cyclic.data[index].value)
        found.append((positions[first : first + curve.points_length], closed))
    return found


def read_old_pencil(context: bpy.types.Context, source: bpy.types.Object) -> list[tuple[np.ndarray, bool]]:
    """Strokes of grease pencil as it was up to Blender 4.2: of the shown layers, the frames that are active."""
    found = []
    for layer in source.data.layers:
        if layer.hide or layer.active_frame is None:
            continue
        for stroke in layer.active_frame.strokes:
            points = np.empty((len(stroke.points), 3), dtype=np.float32)
            stroke.points.foreach_get("co", points.ravel())
            found.append((points, bool(stroke.use_cyclic)))
    return found


def read_pencil(context: bpy.types.Context, source: bpy.types.Object) -> list[tuple[np.ndarray, bool]]:
    """Strokes of grease pencil as it is since Blender 4.3."""
    found = []
    for layer in source.data.layers:
        frame = None if layer.hide else layer.current_frame()
        if frame is None:
            continue
        for stroke in frame.drawing.strokes:
            points = np.array([tuple(point.position) for point in stroke.points], dtype=np.float64)
            found.append((points.reshape(-1, 3), bool(stroke.cyclic)))
    return found
