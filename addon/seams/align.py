# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the vertices of an edge path come to lie on their line: each near its own place, and all in the line's order.

Arrays in, arrays out; no Blender in here.
"""

import numpy as np


def align_path(places: np.ndarray, points: np.ndarray, closed: bool) -> tuple[np.ndarray, np.ndarray]:
    """For every vertex of a path the segment of the line and how far along it, (K,) int and (K,) float in 0..1.

    places : (K, 3) the path's vertices in order, from about the start of the line to about its end
    points : (N, 3) the line; a closed one does not repeat its first point

    The sum of squared distances is the least with the vertices in the line's order (dynamic programming, O(K N)). The
    ends of an open path lie at the ends of the line.
    """
    following = np.roll(points, -1, axis=0) if closed else points[1:]
    starts = points[: len(following)]
    if closed:
        # The round is cut open at the path's first vertex: its own nearest segment.
        parts, distances = measure_segments(places[:1], starts, following)
        first = int(np.argmin(distances[0]))
        order = np.roll(np.arange(len(starts)), -first)
        # The first segment once more at the end: its part before the cut.
        order = np.append(order, first)
        segments, along = align_open(places, starts[order], following[order], (0, float(parts[0, first])))
        return order[segments], along
    return align_open(places, starts, following, None)


def align_open(
    places: np.ndarray, starts: np.ndarray, ends: np.ndarray, first: tuple[int, float] | None
) -> tuple[np.ndarray, np.ndarray]:
    """Segments and parts for a row of segments; `first`: where the first vertex lies, else at the start of them."""
    parts, costs = measure_segments(places, starts, ends)
    count = len(places)
    segments = np.empty(count, dtype=np.int64)
    # The least cost of all vertices up to k with the k-th in segment j or before it.
    reached = np.empty_like(costs)
    begin = (0, 0.0) if first is None else first
    row = np.full(costs.shape[1], np.inf)
    row[begin[0]] = 0.0
    for k in range(count):
        if k > 0:
            row = reached[k - 1] + costs[k]
        reached[k] = np.minimum.accumulate(row)
    last = costs.shape[1] - 1
    if first is None and count > 1:
        segments[-1], top = last, last
    else:
        top = int(np.searchsorted(-reached[-1], -reached[-1, last]))
        segments[-1] = top
    for k in range(count - 2, -1, -1):
        top = int(np.searchsorted(-reached[k, : top + 1], -reached[k, top]))
        segments[k] = top
    along = parts[np.arange(count), segments]
    segments[0], along[0] = begin
    if first is None and count > 1:
        along[-1] = 1.0
    elif first is not None:
        # The last segment is the first one, up to the cut.
        is_wrapped = segments == last
        along[is_wrapped] = np.minimum(along[is_wrapped], begin[1])
        is_first = segments == 0
        along[is_first] = np.maximum(along[is_first], begin[1])
    return segments, keep_order(segments, along)


def measure_segments(places: np.ndarray, starts: np.ndarray, ends: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Part of the nearest point of each segment to each place, and its squared distance, both (K, N)."""
    directions = ends - starts
    squares = np.einsum("ni,ni->n", directions, directions)
    offsets = np.einsum("ni,ni->n", starts, directions)
    parts = (places @ directions.T - offsets) / np.where(squares > 0.0, squares, 1.0)
    parts = np.clip(parts, 0.0, 1.0)
    distances = np.zeros_like(parts)
    for i in range(3):
        distances += (places[:, [i]] - (starts[:, i] + parts * directions[:, i])) ** 2
    return parts, distances


def keep_order(segments: np.ndarray, along: np.ndarray) -> np.ndarray:
    """Parts that do not fall within a segment: what would lie before its forerunner lies at the same place."""
    ordered = np.maximum.accumulate(segments + np.clip(along, 0.0, 1.0)) - segments
    return np.clip(ordered, 0.0, 1.0)
