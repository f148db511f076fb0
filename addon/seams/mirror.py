# SPDX-License-Identifier: GPL-3.0-or-later
"""The mirror image of every vertex across a plane of the object: by position, or by who is joined to whom.

Arrays in, arrays out; no Blender in here.
"""

import itertools

import numpy as np

from ..errors import ObjectError
from .topology import NO_PARTNER, Topology

AXES = ("X", "Y", "Z")


def match_by_position(positions: np.ndarray, axis: int, tolerance: float) -> np.ndarray:
    """For every vertex the one nearest to its mirror image, within `tolerance`, (V,); NO_PARTNER where there is none.

    Only pairs that choose each other count, so that no vertex is the image of two.
    """
    images = positions.copy()
    images[:, axis] *= -1.0
    # A grid of cells of the tolerance: what is within it of a point lies in the 27 cells around.
    origin = np.minimum(positions.min(axis=0), images.min(axis=0)) - tolerance
    cells = np.floor((positions - origin) / tolerance).astype(np.int64)
    wanted = np.floor((images - origin) / tolerance).astype(np.int64)
    spans = np.maximum(cells.max(axis=0), wanted.max(axis=0)) + 3
    if float(spans[0]) * float(spans[1]) * float(spans[2]) > 2.0**62:
        raise ObjectError(
            f"The tolerance {tolerance:.3g} is too small beside the size of the mesh; take at least a millionth of it"
        )
    keys = number_cells(cells, spans)
    order = np.argsort(keys, kind="stable")
    nearest = np.full(len(positions), NO_PARTNER)
    best = np.full(len(positions), tolerance)
    for step in itertools.product((-1, 0, 1), repeat=3):
        cell = number_cells(wanted + np.array(step), spans)
        first = np.searchsorted(keys[order], cell, side="left")
        last = np.searchsorted(keys[order], cell, side="right")
        for place in range(int((last - first).max(initial=0))):
            rows = np.flatnonzero(first + place < last)
            candidates = order[first[rows] + place]
            distances = np.linalg.norm(positions[candidates] - images[rows], axis=1)
            is_nearer = distances <= best[rows]
            # The lower number among equals, so that the answer does not depend on the order of the cells.
            is_nearer &= (distances < best[rows]) | (nearest[rows] == NO_PARTNER) | (candidates < nearest[rows])
            nearest[rows[is_nearer]] = candidates[is_nearer]
            best[rows[is_nearer]] = distances[is_nearer]
    return keep_mutual(nearest)


def number_cells(cells: np.ndarray, spans: np.ndarray) -> np.ndarray:
    """One number a cell."""
    shifted = cells + 1
    return (shifted[:, 0] * spans[1] + shifted[:, 1]) * spans[2] + shifted[:, 2]


def keep_mutual(partners: np.ndarray) -> np.ndarray:
    """Only partners that are each other's."""
    has = partners != NO_PARTNER
    rows = np.flatnonzero(has)
    is_mutual = partners[partners[rows]] == rows
    kept = np.full_like(partners, NO_PARTNER)
    kept[rows[is_mutual]] = partners[rows[is_mutual]]
    return kept


def match_by_topology(topology: Topology, positions: np.ndarray, axis: int, tolerance: float) -> np.ndarray:
    """The same by walking away on both sides at once from the edges on the plane, (V,): for meshes that are posed.

    Only the edges on the plane are found by position. ObjectError where there is none.
    """
    corners, offsets = topology.corners.astype(np.int64), topology.offsets.astype(np.int64)
    sizes = np.diff(offsets)
    starts = np.repeat(offsets[:-1], sizes)
    count = np.repeat(sizes, sizes)
    within = np.arange(len(corners)) - starts
    following = starts + (within + 1) % count
    preceding = starts + (within - 1) % count
    twins = find_twins(corners, corners[following], topology.vertex_count)

    is_on_plane = np.abs(positions[:, axis]) <= tolerance
    seeds = np.flatnonzero(is_on_plane[corners] & is_on_plane[corners[following]] & (twins != NO_PARTNER))
    if len(seeds) == 0:
        raise ObjectError(
            f"No edge lies on the plane {AXES[axis]} = 0 of the object, within {tolerance:.3g}: from there the "
            "two sides are compared. Raise the tolerance, or mirror by position"
        )
    # A corner stands for the directed edge from it to the next. The mirror turns faces round: the image of the edge
    # from a to b runs from the image of b to that of a; so an edge on the plane has its own twin for an image.
    image = np.full(len(corners), NO_PARTNER)
    image[seeds] = twins[seeds]
    front = seeds
    while len(front) > 0:
        # Next in the face is previous in its image; across an edge is across its image.
        pairs = [(following[front], preceding[image[front]])]
        has_twins = (twins[front] != NO_PARTNER) & (twins[image[front]] != NO_PARTNER)
        pairs.append((twins[front[has_twins]], twins[image[front[has_twins]]]))
        sources = np.concatenate([pair[0] for pair in pairs])
        images = np.concatenate([pair[1] for pair in pairs])
        # Faces of other sizes are no images: the two sides differ there.
        is_new = (image[sources] == NO_PARTNER) & (count[sources] == count[images])
        sources, images = sources[is_new], images[is_new]
        sources, unique = np.unique(sources, return_index=True)
        image[sources] = images[unique]
        front = sources
    partners = np.full(topology.vertex_count, NO_PARTNER)
    rows = np.flatnonzero(image != NO_PARTNER)
    partners[corners[rows]] = corners[following[image[rows]]]
    return keep_mutual(partners)


def find_twins(starts: np.ndarray, ends: np.ndarray, vertex_count: int) -> np.ndarray:
    """For every directed edge the one that runs the other way in the only other face; NO_PARTNER elsewhere."""
    forward = starts * vertex_count + ends
    backward = ends * vertex_count + starts
    order = np.argsort(forward, kind="stable")
    place = np.minimum(np.searchsorted(forward[order], backward), max(len(order) - 1, 0))
    found = order[place]
    is_twin = forward[found] == backward
    # An edge of three faces or more has none, nor one between faces that are turned differently.
    _, inverse, counts = np.unique(forward, return_inverse=True, return_counts=True)
    is_single = counts[inverse.ravel()] == 1
    is_twin &= is_single & is_single[found]
    return np.where(is_twin, found, NO_PARTNER)
