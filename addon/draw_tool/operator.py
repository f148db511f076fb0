# SPDX-License-Identifier: GPL-3.0-or-later
"""The draw tool's operator: Blender's events to the gestures, and Enter to a curve.

Nothing in the file changes before Enter. Holds no geometry, no drawing, and nothing of what an event means.
"""

import json
import time
from typing import Any

import bpy
from bpy.props import StringProperty

from .. import guard, mesh_read, session, settings
from ..errors import ObjectError
from ..live import memory
from . import drawing as drawings
from . import view
from .drawing import CUBIC_THRESHOLD, Drawing
from .gestures import NAVIGATION, Answer, Input
from .opening import Opening
from .sketch import SketchState

TICK = 0.02  # seconds between two looks at a mesh that is being opened
SOURCES = (
    ("SEEN", "As Seen", "The mesh after its modifiers in Object Mode, as it is edited in Edit Mode"),
    *settings.SOURCES,
)
# What differs from the operator for picked faces: picks are exact places, so the line goes through them.
DEFAULTS = {"filter": "FAIR", "pinned": "ALL", "threshold": CUBIC_THRESHOLD}


def make_annotations() -> dict[str, Any]:
    """The settings of a line, as the tool begins with them: those in its header, not those of the last time."""
    annotations = {}
    both = {**settings.LineSettings.__annotations__, **settings.NewLineSettings.__annotations__}
    for name, prop in both.items():
        changes = {"default": DEFAULTS[name]} if name in DEFAULTS else {}
        if name == "source":
            changes = {"items": SOURCES, "default": "SEEN"}
        annotations[name] = prop.function(**{**prop.keywords, **changes, "options": {"SKIP_SAVE"}})
    return annotations


class VIEW3D_OT_smooth_polyline_draw(bpy.types.Operator):
    """Draw a smooth line on a mesh, by clicks and strokes on its surface"""

    bl_idname = "view3d.smooth_polyline_draw"
    bl_label = "Draw Smooth Polyline"
    bl_options = {"REGISTER", "UNDO"}

    __annotations__ = {
        **make_annotations(),
        "curve": StringProperty(
            name="Curve",
            description="The curve object whose picks are edited; none: a new curve",
            options={"SKIP_SAVE", "HIDDEN"},
        ),
        "surface": StringProperty(
            name="Surface", description="The mesh object that was drawn on", options={"SKIP_SAVE", "HIDDEN"}
        ),
        "lines": StringProperty(
            name="Lines",
            description="What was drawn, as JSON: lines of picks, each a triangle and its three weights",
            options={"SKIP_SAVE", "HIDDEN"},
        ),
    }

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Whether there is a 3D view in Object Mode or in Edit Mode of a mesh."""
        if context.region_data is not None and context.mode in {"OBJECT", "EDIT_MESH"}:
            return True
        cls.poll_message_set("Go to a 3D view in Object Mode, or in Edit Mode of a mesh")
        return False

    def draw(self, _context: bpy.types.Context) -> None:
        """Lay out the panel of the last operation."""
        settings.draw_new_line_settings(self.layout, self)

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Make what was drawn, with the settings as they are: after Enter, and from the panel of the last operation."""
        return guard.run_guarded(self, lambda: self.make(context))

    def make(self, context: bpy.types.Context) -> None:
        """Add the curves, or give the edited one its picks."""
        if not self.lines:
            raise ObjectError("Nothing has been drawn; start the tool in a 3D view and click on a mesh")
        mesh_object = bpy.data.objects.get(self.surface)
        if mesh_object is None:
            raise ObjectError(f"{self.surface}, which was drawn on, is gone")
        lines = [[(triangle, tuple(weights)) for triangle, weights in line] for line in json.loads(self.lines)]
        if self.curve:
            wishes = {name: getattr(self, name) for name in settings.LineSettings.__annotations__}
            session.replace_picks(context, bpy.data.objects[self.curve].data, lines[0], **wishes)
            return
        added = session.add_polylines(
            context,
            [(mesh_object, line) for line in lines],
            **settings.choose_new_line_options(self),
            **settings.choose_line_options(self),
        )
        if context.mode == "OBJECT":
            for selected in context.selected_objects:
                selected.select_set(False)
            for one in added:
                one.curve_object.select_set(True)
            context.view_layer.objects.active = added[0].curve_object

    # --- the modal part

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Begin: on a curve's picks, or with the click that started the tool."""
        if drawings.running:
            return {"PASS_THROUGH"}
        self.timer = None
        self.is_by_click = not self.curve and event.type == "LEFTMOUSE"
        state = SketchState((), False, self.filter_of_tool(), 0.0)
        self.drawing = Drawing(context, state, self.choose_cubic())
        message = guard.run_quietly(lambda: self.begin(context, event))
        if message is not None:
            self.stop(context)
            self.report({"ERROR"}, message)
            return {"CANCELLED"}
        if self.drawing not in drawings.running:
            return {"CANCELLED"}
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def filter_of_tool(self) -> str:
        """The filter to draw with; picks of the tool are points of the surface, which None would not go through."""
        return self.filter if self.filter != "NONE" else DEFAULTS["filter"]

    def choose_cubic(self) -> dict[str, Any]:
        """What the library takes for a cubic."""
        return {
            "threshold": settings.read_decimal(self.threshold),
            "knots": self.knots.lower(),
            "support": self.support,
        }

    def begin(self, context: bpy.types.Context, event: bpy.types.Event) -> None:
        """Take up the curve that is edited, or the click."""
        drawing = self.drawing
        if self.curve:
            curve_object = bpy.data.objects.get(self.curve)
            known = memory.find_memory(curve_object)
            if known is None:
                raise ObjectError(f"{self.curve or 'Nothing'} is no curve made by Smooth Polylines; select one")
            mesh_object = memory.find_mesh(curve_object.data)
            session.check_object(mesh_object)
            session.check_local(curve_object.data)
            settings.copy_line_settings(known, self)
            drawing.options = self.choose_cubic()
            drawing.curve_name = self.curve
            drawing.sketch.state = SketchState((), known.closed, self.filter_of_tool(), 0.0)
            self.open(context, Opening([(0.0, mesh_object)], None, known.source))
            return
        if event.type == "LEFTMOUSE" and event.value in {"PRESS", "DOUBLE_CLICK"}:
            self.handle(context, event)
        else:
            drawing.tell()

    def open(self, context: bpy.types.Context, opening: Opening) -> None:
        """Begin to open a mesh, and finish at once where that takes no time."""
        self.drawing.opening = opening
        if opening.go_on(context):
            self.end_opening(context)
        elif self.timer is None:
            self.timer = context.window_manager.event_timer_add(TICK, window=context.window)
            context.window_manager.progress_begin(0, 100)

    def end_opening(self, context: bpy.types.Context) -> None:
        """Draw on what was opened, and take the events that came meanwhile."""
        drawing = self.drawing
        opening, drawing.opening = drawing.opening, None
        self.stop_timer(context)
        waiting, drawing.waiting = drawing.waiting, []
        if not opening.chosen:
            drawing.hint = "click on a mesh"
            drawing.tell()
            if self.is_by_click:
                # Nothing was begun, and the next click, perhaps on another tool, is none of ours.
                self.report({"INFO"}, "There is no mesh under the mouse; click on one")
                self.stop(context)
            return
        drawing.hint = ""
        drawing.take_surface(opening)
        if self.curve:
            data = bpy.data.objects[self.curve].data
            size = memory.get_memory(data).detail_size * mesh_read.measure_mean_scale(
                opening.surface.arrays.world_matrix
            )
            drawing.recall(data, size)
            drawing.hidden.hide(self.curve)
        drawing.update()
        for given in waiting:
            drawing.gestures.take(given)
        if drawing.gestures.is_changed:
            drawing.update()
        drawing.tell()
        drawing.tag_redraw()

    def stop_timer(self, context: bpy.types.Context) -> None:
        """Take back what shows progress."""
        if self.timer is not None:
            context.window_manager.event_timer_remove(self.timer)
            context.window_manager.progress_end()
            self.timer = None

    def stop(self, context: bpy.types.Context) -> None:
        """Leave nothing on the screen."""
        self.stop_timer(context)
        self.drawing.stop()

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
            self.stop(context)
        return result

    def cancel(self, context: bpy.types.Context) -> None:
        """Blender ends the tool: another file, or the end."""
        self.stop(context)

    def handle(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """What an event does; the modal state that follows."""
        drawing, since = self.drawing, time.perf_counter()
        if drawing not in drawings.running or context.region_data is None:
            return {"CANCELLED"}
        drawing.canvas.look(context)
        given = read_event(context, event)
        if drawing.opening is not None:
            return self.wait(context, event, given)
        is_click = given.kind == "LEFTMOUSE" and given.value in {"PRESS", "DOUBLE_CLICK"}
        if drawing.is_moved or is_click or given.kind in {"RET", "NUMPAD_ENTER"}:
            drawing.refresh(context)
        if is_click and drawing.opened is None and given.is_over_view and not given.alt:
            drawing.waiting = [given]
            self.open(context, Opening(view.list_candidates(context, given.ray), given.ray, self.source))
            return {"RUNNING_MODAL" if drawing in drawings.running else "CANCELLED"}
        hovered = drawing.gestures.hovered
        answer = drawing.gestures.take(given)
        if drawing.gestures.is_changed:
            drawing.update(since)
            drawing.tell()
            drawing.tag_redraw()
        elif hovered != drawing.gestures.hovered or drawing.gestures.trail:
            drawing.tag_redraw()
        if drawing.gestures.hint:
            drawing.tell()
        drawing.hint = ""
        if answer is Answer.KEEP:
            return self.keep(context)
        states = {Answer.TAKEN: "RUNNING_MODAL", Answer.PASSED: "PASS_THROUGH", Answer.LEAVE: "CANCELLED"}
        return {states[answer]}

    def wait(self, context: bpy.types.Context, event: bpy.types.Event, given: Input) -> set[str]:
        """An event while a mesh is being opened: it is looked at later, but for Esc and the view's own."""
        drawing = self.drawing
        if given.kind == "ESC" and given.value == "PRESS":
            return {"CANCELLED"}
        if given.kind == "TIMER":
            if drawing.opening.go_on(context, 0.0):
                self.end_opening(context)
                return {"RUNNING_MODAL" if drawing in drawings.running else "CANCELLED"}
            context.window_manager.progress_update(round(100 * drawing.opening.measure_progress()))
            drawing.tell()
            return {"RUNNING_MODAL"}
        if given.kind.startswith(NAVIGATION):
            return {"PASS_THROUGH"}
        if not given.kind.startswith("TIMER"):
            drawing.waiting.append(given)
        return {"RUNNING_MODAL"}

    def keep(self, context: bpy.types.Context) -> set[str]:
        """Make the curve; what it was made from stays in the operator, for the panel of the last operation."""
        drawing, state = self.drawing, self.drawing.sketch.state
        lines = [drawing.list_picks()]
        lines += [[(p.triangle, p.barycentric) for p in picks] for picks in drawing.list_mirrored_picks()]
        self.lines, self.surface, self.source = json.dumps(lines), drawing.mesh_name, drawing.source
        self.filter, self.closed, self.pinned = state.filter, state.is_closed, "ALL"
        drawing.hidden.show()
        self.detail_size = state.detail_size / mesh_read.measure_mean_scale(drawing.opened.arrays.world_matrix)
        return self.execute(context)


def read_event(context: bpy.types.Context, event: bpy.types.Event) -> Input:
    """An event as the gestures take it."""
    region, region_3d = context.region, context.region_data
    mouse = (event.mouse_x - region.x, event.mouse_y - region.y)
    area = context.area
    is_over_area = area.x <= event.mouse_x < area.x + area.width and area.y <= event.mouse_y < area.y + area.height
    return Input(
        event.type,
        event.value,
        mouse,
        view.find_ray(region, region_3d, mouse),
        event.ctrl or event.oskey,
        event.shift,
        event.alt,
        event.is_repeat,
        view.is_over_view(area, region, event.mouse_x, event.mouse_y)
        and not view.is_over_gizmo(context, region, event.mouse_x, event.mouse_y),
        is_over_area,
    )
