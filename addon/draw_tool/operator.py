# SPDX-License-Identifier: GPL-3.0-or-later
"""The draw tool's events: mouse and keys in, steps of the sketch and a redraw out; Enter makes the curve.

Nothing in the file changes before Enter. Holds no geometry and no drawing.
"""

import time
from typing import Any

import numpy as np

import bpy
from bpy.props import StringProperty

from .. import guard, mesh_read, session, surface
from ..errors import ObjectError
from ..live import memory
from . import overlay, view
from .sketch import Sketch, SketchPick, SketchState

REACH = 12.0  # pixels at a scale of 1 within which the mouse takes hold of a pick
PASSED_ON = ("MIDDLEMOUSE", "WHEEL", "TRACKPAD", "MOUSEROTATE", "MOUSESMARTZOOM", "NDOF", "NUMPAD_")
KEYS = (
    "Click: pick   Drag: move pick   Ctrl Click: insert   Shift: snap   X: remove   C: close   T: filter   "
    "Ctrl Wheel: detail size   Ctrl Z: step back   Enter: keep   Esc: leave"
)
# At a finer threshold the cubic does not settle on scans (docs/filters.md).
CUBIC_THRESHOLD = 1e-2
# Of a mesh's bounding-box diagonal: where the detail size begins when it was automatic.
FIRST_DETAIL = 0.02

_running: list[Any] = []


def stop_all() -> None:
    """Stop showing what is being drawn; for when the add-on is disabled."""
    for drawing in list(_running):
        drawing.stop()


class Drawing:
    """What one run of the tool holds; `update_milliseconds` tells how long each new line took."""

    def __init__(self, context: bpy.types.Context) -> None:
        self.sketch = Sketch()
        self.mesh_name = ""
        self.curve_name = ""
        self.source = "BASE"
        self.cubic_options: dict[str, Any] = {"threshold": CUBIC_THRESHOLD}
        self.opened: surface.Surface | None = None
        self.points = np.empty((0, 3))
        self.mirror = (False, False, False)
        self.mirrored_points: list[np.ndarray] = []
        self.length = 0.0
        self.message = ""
        self.dragged: int | None = None
        self.hovered: int | None = None
        self.update_milliseconds: list[float] = []
        self.area, self.region = context.area, context.region
        self.workspace = context.workspace
        self.handlers = overlay.add_handlers(self.draw_view, self.draw_pixels)
        self.workspace.status_text_set(KEYS)
        _running.append(self)

    def draw_view(self) -> None:
        """The line, in the view that is drawn in."""
        if bpy.context.area == self.area:
            for points in (self.points, *self.mirrored_points):
                overlay.draw_line(bpy.context, points, self.sketch.state.is_closed)

    def draw_pixels(self) -> None:
        """The picks, over it."""
        if bpy.context.area == self.area:
            projected = [view.project(bpy.context, pick.place) for pick in self.sketch.state.picks]
            overlay.draw_picks(bpy.context, [p for p in projected if p is not None], self.hovered)

    def stop(self) -> None:
        """Leave nothing on the screen."""
        overlay.remove_handlers(self.handlers)
        if self in _running:
            _running.remove(self)
            self.workspace.status_text_set(None)
            self.area.header_text_set(None)
            self.area.tag_redraw()

    def open(self, context: bpy.types.Context, mesh_object: bpy.types.Object, source: str | None = None) -> None:
        """Take up the mesh that is drawn on: what is seen of it, so after its modifiers where it has any."""
        session.check_object(mesh_object)
        has_shape = len(mesh_object.modifiers) > 0 or mesh_object.data.shape_keys is not None
        self.source = source or ("EVALUATED" if has_shape and context.mode == "OBJECT" else "BASE")
        self.opened = surface.open_surface(context, mesh_object, source=self.source)
        self.mesh_name = mesh_object.name
        mesh = mesh_object.data
        self.mirror = (mesh.use_mirror_x, mesh.use_mirror_y, mesh.use_mirror_z)

    def choose_options(self) -> dict[str, Any]:
        """What the library's `polyline` takes beside the picks; the detail size in world units."""
        state = self.sketch.state
        options = {"closed": state.is_closed, "filter": state.filter.lower(), "pinned": "all"}
        if state.filter == "FAIR" and state.detail_size > 0.0:
            options["detail_size"] = state.detail_size
        if state.filter == "CUBIC":
            options |= self.cubic_options
        return options

    def list_picks(self) -> list[tuple[int, tuple[float, float, float]]]:
        """The picks as the library takes them."""
        return [(pick.triangle, pick.barycentric) for pick in self.sketch.state.picks]

    def update(self) -> None:
        """Make the line of the sketch; a refusal is told and the picks stay."""
        start = time.perf_counter()
        self.points, self.length, self.message, self.mirrored_points = np.empty((0, 3)), 0.0, "", []
        if self.sketch.has_line():
            self.message = guard.run_quietly(self.make_line) or ""
        self.update_milliseconds.append(1e3 * (time.perf_counter() - start))
        state = self.sketch.state
        told = f"Smooth Polyline on {self.mesh_name}: " if self.mesh_name else "Smooth Polyline: click on a mesh; "
        told += f"{len(state.picks)} picks, length {self.length:.4g}, {state.filter.title()}"
        if state.detail_size > 0.0:
            told += f", detail size {state.detail_size:.4g}"
        self.area.header_text_set(f"{told}. {self.message}" if self.message else told)
        self.area.tag_redraw()

    def make_line(self) -> None:
        """Ask the library."""
        line = self.opened.library_mesh.polyline(self.list_picks(), **self.choose_options())
        self.points, self.length = line.points, line.length
        for picks in self.list_mirrored_picks():
            mirrored = self.opened.library_mesh.polyline(picks, **self.choose_options())
            self.mirrored_points.append(mirrored.points)

    def list_mirrored_picks(self) -> list[list[Any]]:
        """The picks of each mirrored line; an edited curve has none."""
        if self.curve_name:
            return []
        return view.mirror_picks(self.opened, self.sketch.state.picks, self.mirror)


class VIEW3D_OT_smooth_polyline_draw(bpy.types.Operator):
    """Draw a smooth line on a mesh by clicking on its surface"""

    bl_idname = "view3d.smooth_polyline_draw"
    bl_label = "Draw Smooth Polyline"
    bl_options = {"UNDO"}

    curve: StringProperty(
        name="Curve", description="The curve object whose picks are edited; none: a new curve", options={"SKIP_SAVE"}
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Whether there is a 3D view in Object Mode or in Edit Mode of a mesh."""
        if context.region_data is not None and context.mode in {"OBJECT", "EDIT_MESH"}:
            return True
        cls.poll_message_set("Go to a 3D view in Object Mode, or in Edit Mode of a mesh")
        return False

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Begin: on a curve's picks, or with the click that started the tool."""
        self.drawing = Drawing(context)
        message = guard.run_quietly(lambda: self.begin(context))
        if message is not None:
            self.drawing.stop()
            self.report({"ERROR"}, message)
            return {"CANCELLED"}
        context.window_manager.modal_handler_add(self)
        if not self.curve and event.type == "LEFTMOUSE" and event.value == "PRESS":
            self.handle(context, event)
        self.drawing.update()
        return {"RUNNING_MODAL"}

    def begin(self, context: bpy.types.Context) -> None:
        """Take up the picks of the curve that is edited."""
        if not self.curve:
            return
        curve_object = bpy.data.objects.get(self.curve)
        if curve_object is None or curve_object.type != "CURVE":
            raise ObjectError(f"There is no curve object {self.curve}; select a curve made by Smooth Polylines")
        drawing, known = self.drawing, curve_object.data.smooth_polyline
        drawing.open(context, memory.find_mesh(curve_object.data), known.source)
        drawing.curve_name = self.curve
        recalled = memory.recall(curve_object.data, drawing.opened)
        picks = tuple(self.place_pick(pick) for pick in recalled.picks)
        shown = known.filter if known.filter != "NONE" else "FAIR"
        drawing.cubic_options = {
            "threshold": known.threshold,
            "knots": known.knots.lower(),
            "support": known.support,
        }
        detail_size = known.detail_size * mesh_read.measure_mean_scale(drawing.opened.arrays.world_matrix)
        drawing.sketch = Sketch(SketchState(picks, known.closed, shown, detail_size))

    def place_pick(self, pick: Any) -> SketchPick:
        """A recalled pick as one of the sketch."""
        opened = self.drawing.opened
        if isinstance(pick, int):
            corners = opened.arrays.triangles[opened.arrays.triangle_faces == pick]
            centre = opened.arrays.world_positions[corners].mean(axis=(0, 1))
            pick = opened.library_mesh.closest_points(centre[None]).surface_points[0]
        triangle, weights = pick if isinstance(pick, tuple) else (pick.triangle, pick.barycentric)
        return SketchPick(triangle, tuple(weights), tuple(view.place_of(opened, triangle, weights)))

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """One event; an unforeseen error ends the tool with a message."""
        result: set[str] = {"CANCELLED"}

        def work() -> None:
            nonlocal result
            result = self.handle(context, event)

        message = guard.run_quietly(work)
        if message is not None:
            self.report({"ERROR"}, message)
        if result & {"FINISHED", "CANCELLED"}:
            self.drawing.stop()
        return result

    def cancel(self, context: bpy.types.Context) -> None:
        """Blender ends the tool: another file, or the end."""
        self.drawing.stop()

    def handle(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """What an event does; the modal state that follows."""
        drawing, sketch = self.drawing, self.drawing.sketch
        if drawing not in _running:
            return {"CANCELLED"}
        is_press = event.value == "PRESS"
        if event.type in {"WHEELUPMOUSE", "WHEELDOWNMOUSE"} and event.ctrl:
            if drawing.opened is not None:
                diagonal = float(np.linalg.norm(np.ptp(drawing.opened.arrays.world_positions, axis=0)))
                sketch.scale_detail(1 if event.type == "WHEELUPMOUSE" else -1, FIRST_DETAIL * diagonal)
                drawing.update()
            return {"RUNNING_MODAL"}
        if event.type.startswith(PASSED_ON):
            return {"PASS_THROUGH"}
        region = drawing.region
        mouse = (event.mouse_x - region.x, event.mouse_y - region.y)
        is_inside = view.is_over_view(drawing.area, region, event.mouse_x, event.mouse_y)
        if event.type == "LEFTMOUSE":
            return self.handle_button(context, event, mouse, is_inside)
        if event.type == "MOUSEMOVE":
            self.handle_move(context, event, mouse)
            return {"RUNNING_MODAL" if drawing.dragged is not None else "PASS_THROUGH"}
        if not is_press:
            return {"PASS_THROUGH"}
        if event.type in {"RET", "NUMPAD_ENTER"}:
            return self.keep(context)
        if event.type == "ESC":
            return {"CANCELLED"}
        if event.type == "Z" and event.ctrl:
            (sketch.redo if event.shift else sketch.undo)()
        elif event.type in {"X", "DEL", "BACK_SPACE"} and sketch.state.picks:
            sketch.remove(len(sketch.state.picks) - 1 if drawing.hovered is None else drawing.hovered)
        elif event.type == "C":
            sketch.toggle_closed()
        elif event.type == "T":
            sketch.cycle_filter()
        else:
            return {"PASS_THROUGH"} if not is_inside else {"RUNNING_MODAL"}
        drawing.hovered = None
        drawing.update()
        return {"RUNNING_MODAL"}

    def handle_button(
        self, context: bpy.types.Context, event: bpy.types.Event, mouse: tuple[int, int], is_inside: bool
    ) -> set[str]:
        """Press takes hold of a pick or makes one; release lets go."""
        drawing, sketch = self.drawing, self.drawing.sketch
        if event.value == "RELEASE":
            if drawing.dragged is not None:
                drawing.dragged = None
                sketch.let_go()
                drawing.update()
            return {"RUNNING_MODAL"}
        if not is_inside:
            return {"PASS_THROUGH"}
        near = view.find_near_pick(context, sketch.state.picks, mouse, REACH * overlay.get_scale(context))
        if near is not None and not event.ctrl:
            sketch.hold()
            drawing.dragged = near
            return {"RUNNING_MODAL"}
        if drawing.opened is None:
            mesh_object = self.find_object(context, mouse)
            if mesh_object is None:
                drawing.area.header_text_set("Smooth Polyline: click on a mesh")
                return {"RUNNING_MODAL"}
            drawing.open(context, mesh_object)
        pick = view.find_pick(context, drawing.opened, mouse, event.shift)
        if pick is None:
            return {"RUNNING_MODAL"}
        if event.ctrl and len(drawing.points) > 1:
            state = sketch.state
            leg = view.find_leg(drawing.points, state.is_closed, state.picks, pick.place)
            drawing.dragged = sketch.insert(leg, pick)
        else:
            drawing.dragged = sketch.add(pick)
        drawing.hovered = drawing.dragged
        drawing.update()
        return {"RUNNING_MODAL"}

    def handle_move(self, context: bpy.types.Context, event: bpy.types.Event, mouse: tuple[int, int]) -> None:
        """Drag the pick that is held, or find the one under the mouse."""
        drawing, sketch = self.drawing, self.drawing.sketch
        if drawing.dragged is None:
            reach = REACH * overlay.get_scale(context)
            hovered = view.find_near_pick(context, sketch.state.picks, mouse, reach)
            if hovered != drawing.hovered:
                drawing.hovered = hovered
                drawing.area.tag_redraw()
            return
        pick = view.find_pick(context, drawing.opened, mouse, event.shift)
        if pick is not None and pick != sketch.state.picks[drawing.dragged]:
            sketch.move(drawing.dragged, pick)
            drawing.update()

    def find_object(self, context: bpy.types.Context, mouse: tuple[int, int]) -> bpy.types.Object | None:
        """The mesh object under the mouse: in Edit Mode among those that are edited."""
        origin, direction = view.find_ray(context, mouse)
        if context.mode == "EDIT_MESH":
            best = (float("inf"), None)
            for mesh_object in context.objects_in_mode_unique_data:
                opened = surface.open_surface(context, mesh_object)
                distance = opened.library_mesh.ray_cast(np.array([origin]), np.array([direction])).distances[0]
                best = min(best, (float(distance), mesh_object), key=lambda entry: entry[0])
            return best[1]
        graph = context.evaluated_depsgraph_get()
        is_hit, _, _, _, found, _ = context.scene.ray_cast(graph, origin, direction)
        return found.original if is_hit and found.type == "MESH" else None

    def keep(self, context: bpy.types.Context) -> set[str]:
        """Make the curve, or give the edited one its new picks."""
        drawing = self.drawing
        if not drawing.sketch.has_line():
            drawing.area.header_text_set("Smooth Polyline: two picks make a line, three a loop. Click on the mesh")
            return {"RUNNING_MODAL"}
        wishes = drawing.choose_options()
        if "detail_size" in wishes:
            wishes["detail_size"] /= mesh_read.measure_mean_scale(drawing.opened.arrays.world_matrix)
        if drawing.curve_name:
            curve = bpy.data.objects[drawing.curve_name].data
            # Automatic is a choice, too: the size of before must not stay.
            session.replace_picks(context, curve, drawing.list_picks(), **{"detail_size": 0.0, **wishes})
            return {"FINISHED"}
        mesh_object = bpy.data.objects[drawing.mesh_name]
        added = session.add_polyline(context, mesh_object, drawing.list_picks(), source=drawing.source, **wishes)
        for picks in drawing.list_mirrored_picks():
            session.add_polyline(context, mesh_object, picks, source=drawing.source, **wishes)
        if context.mode == "OBJECT":
            for selected in context.selected_objects:
                selected.select_set(False)
            added.curve_object.select_set(True)
            context.view_layer.objects.active = added.curve_object
        return {"FINISHED"}
