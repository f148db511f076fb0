# SPDX-License-Identifier: GPL-3.0-or-later
"""Lifts the points of a line off the surface, along its normal. Arrays in, arrays out; no Blender in here."""

import numpy as np


def lift_points(
    points: np.ndarray,
    corners: np.ndarray,
    barycentric: np.ndarray,
    local_normals: np.ndarray,
    world_matrix: np.ndarray,
    distance: float,
) -> np.ndarray:
    """Move each point by `distance` (the object's units) along the smooth surface normal of world space.

    points : (N, 3) float64, the object's space
    corners : (N, 3) vertices of the triangle that holds the point
    barycentric : (N, 3) the point inside that triangle
    local_normals : (V, 3) unit vertex normals, the object's space
    world_matrix : (4, 4) local to world

    The normal is the one of the scaled or sheared surface that is seen, brought back into the object's space;
    where vertex normals cancel out it is undefined and the point stays.
    """
    linear = world_matrix[:3, :3]
    normals = np.einsum("nc,nci->ni", barycentric, local_normals[corners])
    # A normal goes to the world by the inverse transpose, a direction comes back by the inverse.
    to_local = np.linalg.inv(linear) @ np.linalg.inv(linear).T
    directions = normals @ to_local.T
    lengths = np.linalg.norm(directions, axis=1, keepdims=True)
    return points + distance * np.divide(directions, lengths, out=np.zeros_like(directions), where=lengths > 0)
