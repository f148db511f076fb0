# SPDX-License-Identifier: GPL-3.0-or-later
"""The points of a line as weights of mesh vertices, so that they can be placed on any shape of the same mesh.

Arrays in, arrays out; no Blender in here. A row is a point: three vertices and their weights.
"""

from typing import Any

import numpy as np


def describe_points(line: Any, triangles: np.ndarray, spacing: float) -> tuple[np.ndarray, np.ndarray]:
    """Vertices (N, 3) int32 and weights (N, 3) float64 of the points of a library's polyline.

    triangles : (F, 3) the mesh that the line was made on
    spacing : even steps along the line of about this length, in the units of the line; 0: the line's own points
    """
    vertices, weights = triangles[line.triangles], line.barycentric
    if spacing <= 0.0 or len(vertices) < 2:
        return vertices, weights
    ends = line.points[1:] if not line.closed else np.roll(line.points, -1, axis=0)
    lengths = np.linalg.norm(ends - line.points[: len(ends)], axis=1)
    along = np.concatenate([[0.0], np.cumsum(lengths)])
    # A closed line of fewer than three points would be no loop.
    steps = max(round(along[-1] / spacing), 3 if line.closed else 1)
    wanted = along[-1] * np.arange(steps if line.closed else steps + 1) / steps
    segment = np.clip(np.searchsorted(along, wanted, side="right") - 1, 0, len(lengths) - 1)
    part = np.clip((wanted - along[segment]) / np.where(lengths > 0, lengths, 1.0)[segment], 0.0, 1.0)[:, None]
    corners = triangles[line.segment_triangles[segment]]
    start = weigh_corners(corners, vertices[segment], weights[segment])
    following = (segment + 1) % len(vertices)
    end = weigh_corners(corners, vertices[following], weights[following])
    return corners, (1.0 - part) * start + part * end


def weigh_corners(corners: np.ndarray, vertices: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """The same points as weights of other corners, (N, 3), which hold every vertex whose weight is not 0."""
    return (weights[:, None, :] * (corners[:, :, None] == vertices[:, None, :])).sum(axis=2)


def place_points(vertices: np.ndarray, weights: np.ndarray, positions: np.ndarray) -> np.ndarray:
    """Where the points lie for these vertex positions, (N, 3) float64; summed in the library's own order."""
    corners = positions[vertices].astype(np.float64)
    first, second, third = (weights[:, [k]] * corners[:, k] for k in range(3))
    return (first + second) + third
