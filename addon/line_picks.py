# SPDX-License-Identifier: GPL-3.0-or-later
"""Few picks for a line that was made without any, as along a drawn guide: what it is made from again, and edited by.

Knows the library's meshes and lines; no Blender in here.
"""

from typing import Any

import numpy as np

from . import native, surface
from .draw_tool import stroke

# How far the line through the picks may pass from the line, as a part of the mesh's bounding-box diagonal.
TOLERANCE_PART = 1e-3
# Points of the line that can become picks: enough for the form of any line that is edited by hand.
MOST_SAMPLES = 400


def choose_picks(opened: surface.Surface, line: Any, **line_options: Any) -> list[tuple[int, np.ndarray]]:
    """Points of `line` as picks; a line with all of them pinned keeps to it within a thousandth of the mesh's diagonal.

    line_options : what the library makes lines by, in world units; `closed` and `pinned` are left out
    """
    rows = choose_samples(line)
    options = {**line_options, "closed": line.closed, "pinned": "all"}

    def make_picks(chosen: list[int]) -> list[tuple[int, np.ndarray]]:
        # A closed line ends where it began.
        kept = chosen[:-1] if line.closed else chosen
        return [(int(line.triangles[rows[k]]), line.barycentric[rows[k]]) for k in kept]

    def make_line(chosen: list[int]) -> tuple[np.ndarray, list[int]]:
        points = opened.library_mesh.polyline(make_picks(chosen), **options).points
        if line.closed:
            first = int(np.argmin(np.linalg.norm(points - places[0], axis=1)))
            points = np.roll(points, -first, axis=0)
            points = np.concatenate([points, points[:1]])
            return points, [*stroke.find_rows(points, places[chosen[:-1]]), len(points) - 1]
        return points, stroke.find_rows(points, places[chosen])

    places = line.points[rows]
    diagonal = float(np.linalg.norm(np.ptp(opened.arrays.world_positions, axis=0)))
    tolerances = np.full(len(rows), TOLERANCE_PART * diagonal)
    # A loop through fewer than three picks is none.
    start = [len(rows) // 3, 2 * len(rows) // 3] if line.closed else []
    if len(rows) < 4:
        return make_picks(list(range(len(rows))))
    try:
        return make_picks(stroke.fit_picks(places, tolerances, make_line, start))
    except Exception as error:
        # A line through some of them may not exist, where one along all does.
        if not native.is_refusal(error):
            raise
        return make_picks(sorted({*stroke.simplify(places, tolerances), *start}))


def choose_samples(line: Any) -> np.ndarray:
    """Rows of the line's points, evenly along it, the first and the last among them; closed: the first again."""
    points = np.concatenate([line.points, line.points[:1]]) if line.closed else line.points
    rows = np.arange(len(points))
    if len(points) > MOST_SAMPLES:
        along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
        wanted = np.linspace(0.0, along[-1], MOST_SAMPLES)
        rows = np.unique(np.searchsorted(along, wanted).clip(0, len(points) - 1))
        rows[0], rows[-1] = 0, len(points) - 1
    return rows % len(line.points)
