# SPDX-License-Identifier: GPL-3.0-or-later
"""One run of the draw tool: the sketch, the surface it is on, the line as it is now, and what is told of it.

Nothing in the file changes in here. Holds no events: those are the gestures' and the operator's.
"""

import time
from dataclasses import replace
from typing import Any

import numpy as np

import bpy

from .. import guard, mesh_read, surface
from ..errors import ObjectError
from ..live import memory
from . import overlay, view
from .canvas import SurfaceCanvas, make_pick
from .gestures import Gestures, Input, Mode, forget_hint
from .hidden_curve import HiddenCurve
from .opening import Opening
from .sketch import Sketch, SketchPick, SketchState

# At a finer threshold the cubic does not settle on scans (docs/filters.md).
CUBIC_THRESHOLD = 1e-2
# A pick is hidden when what is seen in its place lies this far from it.
HIDDEN_PIXELS = 4.0

running: list["Drawing"] = []


def stop_all() -> None:
    """Stop showing what is being drawn; for when the add-on is disabled."""
    for drawing in list(running):
        drawing.stop()


class Drawing:
    """What one run of the tool holds; `update_milliseconds` tells how long each new line took, from event to line."""

    def __init__(self, context: bpy.types.Context, state: SketchState, options: dict[str, Any]) -> None:
        self.sketch = Sketch(state)
        self.canvas = SurfaceCanvas(context, self.sketch)
        self.canvas.make_points = lambda picks: (
            self.opened.library_mesh.polyline(picks, **{**self.choose_options(), "closed": False}).points
        )
        self.gestures = Gestures(self.canvas, self.sketch)
        self.options = options  # of the cubic
        self.opening: Opening | None = None
        self.waiting: list[Input] = []  # events that came while a mesh was being opened
        self.mesh_name, self.curve_name, self.source = "", "", "BASE"
        self.mirror = (False, False, False)
        self.lines: list[Any] = []  # of the library: the line, then its mirrors
        self.made_with: dict[str, Any] = {}  # the options of those lines
        self.length, self.message, self.hint = 0.0, "", ""
        self.hidden = HiddenCurve()  # the curve that is edited
        self.is_moved = False  # something of the mesh may have changed
        self.update_milliseconds: list[float] = []
        self.opening_milliseconds = 0.0
        # What belongs to the window outlives an undo from the menu; a scene does not, so only its name is kept.
        self.window, self.area, self.scene_name = context.window, context.area, context.scene.name
        self.workspace = context.workspace
        self.handlers = overlay.add_handlers(self.draw_view, self.draw_pixels)
        self.workspace.status_text_set(overlay.draw_status)
        bpy.app.handlers.depsgraph_update_post.append(self.on_update)
        running.append(self)

    @property
    def opened(self) -> surface.Surface | None:
        """The surface that is drawn on."""
        return self.canvas.opened

    @property
    def points(self) -> np.ndarray:
        """Points of the line, (N, 3), world space."""
        return self.canvas.points

    # --- what is shown

    def draw_view(self) -> None:
        """The line, its mirrors and the stroke, in every 3D view of the scene."""
        if bpy.context.scene.name == self.scene_name:
            for line in self.lines:
                overlay.draw_line(bpy.context, line.points, line.closed)
            trail = self.gestures.trail
            if self.gestures.mode is Mode.STROKE and len(trail) > 1:
                overlay.draw_line(bpy.context, np.array([pick.place for pick in trail]), False)

    def draw_pixels(self) -> None:
        """The picks, over it, and the circle of the detail size."""
        context = bpy.context
        if context.scene.name != self.scene_name:
            return
        region, region_3d = context.region, context.region_data
        picks = self.sketch.state.picks
        overlay.draw_picks(
            context,
            [view.project(region, region_3d, pick.place) for pick in picks],
            self.gestures.hovered,
            self.find_hidden(region, region_3d, picks),
        )
        if self.gestures.circle is not None and context.area == self.area:
            circle = self.gestures.circle
            overlay.draw_circle(context, circle.centre, self.sketch.state.detail_size / circle.pixel)

    def find_hidden(self, region: Any, region_3d: Any, picks: tuple[SketchPick, ...]) -> list[bool]:
        """Which picks lie behind something of their own surface."""
        if self.opened is None or not picks:
            return []
        places = np.array([pick.place for pick in picks])
        hits = self.opened.library_mesh.ray_cast(*view.find_rays_to(region_3d, places))
        away = np.linalg.norm(hits.points - places, axis=1)
        return list(away > HIDDEN_PIXELS * view.measure_pixels(region, region_3d, places))

    def tag_redraw(self) -> None:
        """Every 3D view of the window."""
        for area in self.window.screen.areas:
            if area.type == "VIEW_3D":
                area.tag_redraw()

    def tell(self) -> None:
        """Say in the header where the drawing stands."""
        state = self.sketch.state
        self.hint = forget_hint(self.gestures) or self.hint
        if self.opening is not None:
            self.area.header_text_set(f"Smooth Polyline: {self.opening.describe()}")
            return
        told = f"Smooth Polyline on {self.mesh_name}: " if self.mesh_name else "Smooth Polyline: click on a mesh; "
        units, loop = bpy.context.scene.unit_settings, "Closed " * state.is_closed
        length = describe_length(units, self.length)
        told += f"{len(state.picks)} picks, length {length}, {loop}{state.filter.title()}"
        if state.filter == "FAIR" and state.detail_size > 0.0:
            told += f", detail size {describe_length(units, state.detail_size)}"
        notes = [note for note in (self.message, self.hint) if note]
        self.area.header_text_set(". ".join([told, *notes]))

    def stop(self) -> None:
        """Leave nothing on the screen."""
        overlay.remove_handlers(self.handlers)
        if self in running:
            running.remove(self)
            bpy.app.handlers.depsgraph_update_post.remove(self.on_update)
            self.workspace.status_text_set(None)
            self.hidden.show()
            if any(area == self.area for area in self.window.screen.areas):
                self.area.header_text_set(None)
            self.tag_redraw()

    # --- the surface

    def take_surface(self, opening: Opening) -> None:
        """Draw on what was opened from here on."""
        self.mesh_name, self.source, self.canvas.opened = opening.chosen, opening.source, opening.surface
        self.opening_milliseconds = opening.milliseconds
        mesh = bpy.data.objects[self.mesh_name].data
        self.mirror = (mesh.use_mirror_x, mesh.use_mirror_y, mesh.use_mirror_z)

    def on_update(self, _scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> None:
        """Blender has evaluated something: where it was the mesh that is drawn on, look at it before the next step."""
        mesh_object = bpy.data.objects.get(self.mesh_name)
        if mesh_object is None:
            self.is_moved = True
            return
        known = {mesh_object.session_uid, mesh_object.data.session_uid}
        self.is_moved |= any(update.id.original.session_uid in known for update in depsgraph.updates)

    def refresh(self, context: bpy.types.Context) -> None:
        """Notice that the mesh has changed: the picks go with it, or are found again by position."""
        self.is_moved = False
        if self.opened is None:
            return
        mesh_object = bpy.data.objects.get(self.mesh_name)
        if mesh_object is None:
            raise ObjectError(f"{self.mesh_name}, which is drawn on, is gone; the drawing has ended")
        before = self.opened
        now = surface.open_surface(context, mesh_object, source=self.source)
        if now is before:
            return
        self.canvas.opened, self.lines = now, []
        self.sketch.move_picks(make_mover(before, now))
        self.gestures.is_changed = True
        self.hint = "the mesh has changed"

    # --- the line

    def choose_options(self) -> dict[str, Any]:
        """What the library's `polyline` takes beside the picks; the detail size in world units."""
        state = self.sketch.state
        options = {"closed": state.is_closed, "filter": state.filter.lower(), "pinned": "all"}
        if state.filter == "FAIR" and state.detail_size > 0.0:
            options["detail_size"] = state.detail_size
        if state.filter == "CUBIC":
            options |= self.options
        return options

    def choose_wishes(self) -> dict[str, Any]:
        """The same for `session.add_polyline`, which takes lengths in the object's units."""
        wishes = self.choose_options()
        size = wishes.pop("detail_size", 0.0)
        scale = mesh_read.measure_mean_scale(self.opened.arrays.world_matrix)
        return {**wishes, "detail_size": size / scale if size else None}

    def list_picks(self) -> list[tuple[int, tuple[float, float, float]]]:
        """The picks as the library takes them."""
        return [(pick.triangle, pick.barycentric) for pick in self.sketch.state.picks]

    def update(self, since: float | None = None) -> None:
        """Make the line of the sketch; a refusal is told and the picks stay. `since`: when the event came."""
        since = time.perf_counter() if since is None else since
        self.gestures.is_changed = False
        before, self.lines = self.lines, []
        self.canvas.points, self.length, self.message = np.empty((0, 3)), 0.0, ""
        if self.sketch.has_line():
            self.message = guard.run_quietly(lambda: self.make_lines(before)) or ""
        self.update_milliseconds.append(1e3 * (time.perf_counter() - since))

    def make_lines(self, before: list[Any]) -> None:
        """Ask the library: while a pick is dragged, for the lines `before` with what that changes; else afresh."""
        options, mesh = self.choose_options(), self.opened.library_mesh
        all_picks = [self.list_picks(), *self.list_mirrored_picks()]
        is_dragged = self.gestures.mode is Mode.DRAGGING and self.made_with == options and len(before) == len(all_picks)
        self.made_with = options
        for number, picks in enumerate(all_picks):
            line = before[number].with_picks(picks) if is_dragged else mesh.polyline(picks, **options)
            self.lines.append(line)
        self.canvas.points, self.length = self.lines[0].points, self.lines[0].length

    def list_mirrored_picks(self) -> list[list[Any]]:
        """The picks of each mirrored line; an edited curve has none."""
        if self.curve_name:
            return []
        return view.mirror_picks(self.opened, self.sketch.state.picks, self.mirror)

    def recall(self, data: Any, detail_size: float) -> None:
        """Take up the picks of a data-block that remembers, on the surface that was opened; the size in world units."""
        picks = tuple(place_pick(self.opened, pick) for pick in memory.recall(data, self.opened).picks)
        self.sketch.state = replace(self.sketch.state, picks=picks, detail_size=detail_size)


def make_mover(before: surface.Surface, now: surface.Surface) -> Any:
    """How a pick goes from a surface to what has become of it."""
    old, new = before.arrays, now.arrays
    if np.array_equal(old.triangles, new.triangles):
        return lambda pick: make_pick(now, pick.triangle, pick.barycentric)
    inverse = np.linalg.inv(old.world_matrix)

    def move(pick: SketchPick) -> SketchPick:
        local = inverse[:3, :3] @ pick.place + inverse[:3, 3]
        there = new.world_matrix[:3, :3] @ local + new.world_matrix[:3, 3]
        (found,) = now.library_mesh.closest_points(there[None]).surface_points
        return make_pick(now, found.triangle, found.barycentric)

    return move


def place_pick(opened: surface.Surface, pick: Any) -> SketchPick:
    """A pick as the library takes it as one of the sketch; a face is the point nearest to its centre."""
    if isinstance(pick, int):
        corners = opened.arrays.triangles[opened.arrays.triangle_faces == pick]
        centre = opened.arrays.world_positions[corners].mean(axis=(0, 1))
        pick = opened.library_mesh.closest_points(centre[None]).surface_points[0]
    triangle, weights = pick if isinstance(pick, tuple) else (pick.triangle, pick.barycentric)
    return make_pick(opened, triangle, weights)


def describe_length(units: Any, length: float) -> str:
    """A length of world space in the scene's units."""
    if units.system == "NONE":
        return f"{length:.4g}"
    return bpy.utils.units.to_string(units.system, "LENGTH", length * units.scale_length, precision=4)
