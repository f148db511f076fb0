"""The UV layout of one object as SVG: faces, borders of islands, seams, and where the lines run over the layout."""

import re
from pathlib import Path

import numpy as np

import bpy

from .fault import FileFault
from .make_lines import MadeLine

SIDE = 1024.0  # user units of the picture for the unit square of UV space
# Corners nearer than this in UV space are the same corner.
SAME_UV = 1e-6
STYLES = {
    "face": 'stroke="#b8bcc2" stroke-width="0.6"',
    "border": 'stroke="#30343a" stroke-width="1.6"',
    "seam": 'stroke="#d43a2f" stroke-width="2.4"',
    "line": 'stroke="#1769c4" stroke-width="3"',
}


def make_file_name(object_name: str) -> str:
    """The object's name as a part of a file's name on any system."""
    return re.sub(r'[<>:"/\\|?*\x00-\x1f]', "_", object_name).rstrip(" .") or "_"


def write_uv_layout(path: Path, mesh_object: bpy.types.Object, lines: list[MadeLine], is_evaluated: bool) -> None:
    """Draw the active UV map of the object; FileFault when it has none."""
    if is_evaluated:
        evaluated = mesh_object.evaluated_get(bpy.context.evaluated_depsgraph_get())
        try:
            groups = collect(evaluated.to_mesh(), mesh_object.name, lines)
        finally:
            evaluated.to_mesh_clear()
    else:
        groups = collect(mesh_object.data, mesh_object.name, lines)
    everything = np.concatenate([group.reshape(-1, 2) for group in groups.values() if len(group)])
    path.write_text(draw(groups, everything), encoding="utf-8", newline="\n")


def collect(mesh: bpy.types.Mesh, name: str, lines: list[MadeLine]) -> dict[str, np.ndarray]:
    """Segments in UV space, (N, 2, 2), by what they are."""
    layer = mesh.uv_layers.active
    if layer is None or len(mesh.loops) == 0:
        raise FileFault("NoUVMapError", f"{name} has no UV map")
    uv = np.empty(2 * len(mesh.loops), dtype=np.float32)
    layer.uv.foreach_get("vector", uv)
    uv = uv.reshape(-1, 2).astype(np.float64)
    starts = np.empty(len(mesh.polygons), dtype=np.int32)
    mesh.polygons.foreach_get("loop_start", starts)
    edges = np.empty(len(mesh.loops), dtype=np.int32)
    mesh.loops.foreach_get("edge_index", edges)
    following = np.arange(1, len(uv) + 1)
    following[np.append(starts[1:], len(uv)) - 1] = starts
    segments = np.stack([uv, uv[following]], axis=1)
    keys = np.round(segments / SAME_UV).astype(np.int64)
    is_turned = (keys[:, 0, 0] > keys[:, 1, 0]) | ((keys[:, 0, 0] == keys[:, 1, 0]) & (keys[:, 0, 1] > keys[:, 1, 1]))
    keys[is_turned] = keys[is_turned][:, ::-1]
    _, first, counts = np.unique(keys.reshape(-1, 4), axis=0, return_index=True, return_counts=True)
    seams = np.zeros(len(mesh.edges), dtype=bool)
    mesh.edges.foreach_get("use_seam", seams)
    return {
        "face": segments[np.sort(first[counts > 1])],
        "border": segments[np.sort(first[counts == 1])],
        "seam": segments[seams[edges]],
        "line": trace_lines(mesh, uv, lines),
    }


def trace_lines(mesh: bpy.types.Mesh, uv: np.ndarray, lines: list[MadeLine]) -> np.ndarray:
    """The segments of the lines in UV space; none where the mesh is no longer the one they were made on."""
    mesh.calc_loop_triangles()
    corners = np.empty(3 * len(mesh.loop_triangles), dtype=np.int32)
    mesh.loop_triangles.foreach_get("loops", corners)
    corners = corners.reshape(-1, 3)
    vertices = np.empty(len(mesh.loops), dtype=np.int32)
    mesh.loops.foreach_get("vertex_index", vertices)
    corner_rows = {tuple(row): k for k, row in enumerate(vertices[corners].tolist())}
    traced = []
    for made in lines:
        line, arrays = made.computed.line, made.computed.arrays
        rows = [corner_rows.get(tuple(row)) for row in arrays.triangles[line.segment_triangles].tolist()]
        if not rows or None in rows:
            continue
        used = corners[np.array(rows)]
        held = vertices[used]
        ends = np.arange(len(rows)), np.arange(1, len(rows) + 1) % len(line.points)
        points = [
            np.einsum(
                "nc,nci->ni",
                weigh(held, arrays.triangles[line.triangles[end]], line.barycentric[end]),
                uv[used],
            )
            for end in ends
        ]
        traced.append(np.stack(points, axis=1))
    return np.concatenate(traced) if traced else np.empty((0, 2, 2))


def weigh(held: np.ndarray, vertices: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Points given by weights of `vertices` as weights of the vertices `held`, which have all of weight."""
    return (weights[:, None, :] * (held[:, :, None] == vertices[:, None, :])).sum(axis=2)


def draw(groups: dict[str, np.ndarray], everything: np.ndarray) -> str:
    """The SVG: the unit square, or more where the layout leaves it; V upwards."""
    low = np.minimum(np.floor(everything.min(axis=0)), 0.0)
    high = np.maximum(np.ceil(everything.max(axis=0)), 1.0)
    width, height = SIDE * (high - low)
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:g} {height:g}" fill="none">',
        f'<rect width="{width:g}" height="{height:g}" fill="#ffffff"/>',
    ]
    for name, segments in groups.items():
        if len(segments) == 0:
            continue
        placed = (segments - low) * SIDE
        placed[..., 1] = height - placed[..., 1]
        rows = np.round(placed.reshape(-1, 4), 2) + 0.0  # no -0
        path = "".join(f"M{a:g} {b:g}L{c:g} {d:g}" for a, b, c, d in rows.tolist())
        parts.append(f'<path class="{name}" {STYLES[name]} d="{path}"/>')
    return "\n".join([*parts, "</svg>", ""])
