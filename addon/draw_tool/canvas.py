# SPDX-License-Identifier: GPL-3.0-or-later
"""What gestures ask of the surface and of the screen, answered for one view and one opened mesh.

Holds no state of the drawing but the sketch it is asked about, and changes nothing.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

import bpy

from .. import native
from ..surface import Surface
from . import stroke, view
from .gestures import Input
from .sketch import Sketch, SketchPick

# Of a mesh's bounding-box diagonal: where the detail size begins when it was automatic.
FIRST_DETAIL = 0.02
STROKE_TOLERANCE = 3.0  # pixels at a scale of 1 that the smooth line may lie off the stroke
# Picks before a stroke that its fit takes into account: how the line comes to it.
CONTEXT_PICKS = 2


class SurfaceCanvas:
    """The canvas of `gestures`. `opened` is None until a mesh has been chosen."""

    def __init__(self, context: bpy.types.Context, sketch: Sketch) -> None:
        self.sketch = sketch
        self.opened: Surface | None = None
        self.points = np.empty((0, 3))  # of the line as it is now
        self.make_points: Callable[[list[tuple[int, Any]]], np.ndarray] | None = None
        self.look(context)

    def look(self, context: bpy.types.Context) -> None:
        """Take up the view as it is now."""
        self.region, self.region_3d = context.region, context.region_data
        self.scale = context.preferences.system.ui_scale
        self.drag_threshold = context.preferences.inputs.drag_threshold_mouse * self.scale

    def find_pick(self, given: Input, is_snapped: bool) -> SketchPick | None:
        """The point of the surface under the mouse, exactly; snapped, the nearest vertex or edge's middle."""
        if self.opened is None:
            return None
        origin, direction = given.ray
        hits = self.opened.library_mesh.ray_cast(origin[None], direction[None])
        triangle = int(hits.triangles[0])
        if triangle < 0:
            return None
        weights = hits.barycentric[0]
        if is_snapped:
            weights = view.snap(self.region, self.region_3d, self.opened, triangle, given.mouse)
        return make_pick(self.opened, triangle, weights)

    def find_near_pick(self, mouse: tuple[float, float], reach: float) -> int | None:
        """The pick nearest to the mouse on the screen."""
        return view.find_near_pick(self.region, self.region_3d, self.sketch.state.picks, mouse, reach)

    def find_leg(self, pick: SketchPick) -> int:
        """Between which picks of the line a new one belongs: before the one told."""
        state = self.sketch.state
        if len(self.points) < 2:
            return len(state.picks)
        return view.find_leg(self.points, state.is_closed, state.picks, pick.place)

    def measure_pixel(self, place: tuple[float, float, float]) -> float:
        """Length of a pixel at a place."""
        return float(view.measure_pixels(self.region, self.region_3d, np.array([place]))[0])

    def measure_first_detail(self) -> float:
        """A small part of the mesh's size."""
        return FIRST_DETAIL * float(np.linalg.norm(np.ptp(self.opened.arrays.world_positions, axis=0)))

    def fit_stroke(self, before: tuple[SketchPick, ...], samples: list[SketchPick]) -> list[SketchPick]:
        """The few samples through which the line keeps to all of them, to some pixels.

        Samples on another part of the mesh than the first, over which the mouse passed, are left out.
        """
        samples = self.choose_connected(samples)
        if len(samples) < 3:
            return samples
        places = np.array([sample.place for sample in samples])
        tolerances = STROKE_TOLERANCE * self.scale * view.measure_pixels(self.region, self.region_3d, places)
        led = before[-CONTEXT_PICKS:]

        def make_line(chosen: list[int]) -> tuple[np.ndarray, list[int]]:
            picks = [*led, *[samples[k] for k in chosen]]
            points = self.make_points([(pick.triangle, pick.barycentric) for pick in picks])
            return points, stroke.find_rows(points, np.array([pick.place for pick in picks]))[len(led) :]

        try:
            chosen = stroke.fit_picks(places, tolerances, make_line)
        except Exception as error:
            # Why there is no line will be said when the whole of it is made.
            if not native.is_refusal(error):
                raise
            chosen = stroke.simplify(places, tolerances)
        return [samples[k] for k in chosen]

    def choose_connected(self, samples: list[SketchPick]) -> list[SketchPick]:
        """The samples on the same part of the mesh as the first."""
        mesh = self.opened.library_mesh
        if mesh.report.parts == 1:
            return samples
        parts = mesh.triangle_parts()
        return [sample for sample in samples if parts[sample.triangle] == parts[samples[0].triangle]]


def make_pick(opened: Surface, triangle: int, weights: Any) -> SketchPick:
    """A point of the surface as a pick of the sketch."""
    place = view.place_of(opened, triangle, weights)
    return SketchPick(int(triangle), tuple(float(w) for w in weights), tuple(float(x) for x in place))
