# SPDX-License-Identifier: GPL-3.0-or-later
"""What mouse and keys mean while a line is drawn: a state machine over the sketch.

Plain Python: knows neither Blender nor the library. What lies under the mouse it asks of a `Canvas`, and is tested with
a flat one.
"""

import enum
from dataclasses import dataclass, field
from typing import Any, Protocol

from .sketch import Sketch, SketchPick, SketchState

REACH = 12.0  # pixels at a scale of 1 within which the mouse takes hold of a pick
SAMPLE_STEP = 2.0  # pixels at a scale of 1 between two samples of a stroke
LEAST_SIZE = 4.0  # pixels: the smallest circle that a detail size is shown by
NAVIGATION = ("MIDDLEMOUSE", "WHEEL", "TRACKPAD", "MOUSEROTATE", "MOUSESMARTZOOM", "NDOF", "NUMPAD_", "HOME")
MOVES = {"MOUSEMOVE", "INBETWEEN_MOUSEMOVE"}
KEEP_KEYS = {"RET", "NUMPAD_ENTER"}
REMOVE_KEYS = {"X", "DEL", "BACK_SPACE"}


class Answer(enum.Enum):
    """What becomes of an event."""

    TAKEN = enum.auto()
    PASSED = enum.auto()  # to Blender
    KEEP = enum.auto()  # the line becomes a curve
    LEAVE = enum.auto()  # everything is as it was


class Mode(enum.Enum):
    """What the mouse is doing."""

    IDLE = enum.auto()
    DRAGGING = enum.auto()  # a pick
    PRESSED = enum.auto()  # a pick was just set; from here on it is a click, or the beginning of a stroke
    STROKE = enum.auto()
    SIZING = enum.auto()  # the detail size, by a circle


@dataclass(frozen=True)
class Input:
    """One event: `kind` and `value` as Blender names them, the mouse in pixels of the view, and the ray under it."""

    kind: str
    value: str = "PRESS"
    mouse: tuple[float, float] = (0.0, 0.0)
    ray: Any = None
    ctrl: bool = False
    shift: bool = False
    alt: bool = False
    is_repeat: bool = False
    is_over_view: bool = True  # and over no panel or gizmo
    is_over_area: bool = True


class Canvas(Protocol):
    """What a gesture must know of the surface and of the screen."""

    scale: float  # pixels of this display for one of an ordinary one
    drag_threshold: float  # pixels

    def find_pick(self, given: Input, is_snapped: bool) -> SketchPick | None:
        """The point of the surface under the mouse."""

    def find_near_pick(self, mouse: tuple[float, float], reach: float) -> int | None:
        """The pick of the sketch nearest to the mouse, within `reach` pixels."""

    def find_leg(self, pick: SketchPick) -> int:
        """Before which pick of the sketch `pick` belongs."""

    def fit_stroke(self, before: tuple[SketchPick, ...], samples: list[SketchPick]) -> list[SketchPick]:
        """The few of `samples` through which the line, coming from `before`, keeps to all of them."""

    def measure_pixel(self, place: tuple[float, float, float]) -> float:
        """Length of a pixel at a place, in world units."""

    def measure_first_detail(self) -> float:
        """Where the detail size begins that was automatic, in world units."""


@dataclass(frozen=True)
class SizeCircle:
    """The circle that shows a detail size while it is changed."""

    centre: tuple[float, float]
    pixel: float  # its length in world units
    before: SketchState


@dataclass
class Gestures:
    """The state between two events. `is_changed` says that the line must be made again; who makes it sets it back."""

    canvas: Canvas
    sketch: Sketch
    mode: Mode = Mode.IDLE
    held: int | None = None
    hovered: int | None = None
    trail: list[SketchPick] = field(default_factory=list)  # samples of the stroke that is being drawn
    start: tuple[float, float] = (0.0, 0.0)
    last: tuple[float, float] = (0.0, 0.0)
    circle: SizeCircle | None = None
    hint: str = ""
    is_changed: bool = False

    def take(self, given: Input) -> Answer:
        """Do what an event asks for."""
        is_press = given.value in {"PRESS", "DOUBLE_CLICK"}
        if given.kind.startswith("WHEEL") and given.ctrl:
            self.scale_detail(1 if given.kind == "WHEELUPMOUSE" else -1)
            return Answer.TAKEN
        if given.kind.startswith(NAVIGATION) and given.kind != "NUMPAD_ENTER":
            return Answer.PASSED
        if given.kind in MOVES:
            return self.move(given)
        if self.mode is not Mode.IDLE and given.kind in {"ESC", "RIGHTMOUSE"}:
            if is_press:
                self.call_off()
            return Answer.TAKEN
        if given.kind == "LEFTMOUSE":
            if self.mode is Mode.SIZING:
                if is_press:
                    self.end_sizing()
                return Answer.TAKEN
            # With Alt the left button navigates: in some keymaps, and as the middle one of three.
            if given.alt and self.mode is Mode.IDLE:
                return Answer.PASSED
            if given.value == "RELEASE":
                return self.release(given)
            return self.press(given) if is_press else Answer.TAKEN
        return self.take_key(given) if is_press else Answer.PASSED

    def take_key(self, given: Input) -> Answer:
        """A key that went down."""
        sketch = self.sketch
        if given.kind in KEEP_KEYS:
            return self.keep(given)
        if given.kind == "ESC":
            return Answer.LEAVE
        if given.kind == "Z" and given.ctrl:
            self.call_off()
            (sketch.redo if given.shift else sketch.undo)()
            self.hovered, self.is_changed = None, True
            return Answer.TAKEN
        if not given.is_over_area:
            return Answer.PASSED
        if given.is_repeat or self.mode in {Mode.DRAGGING, Mode.PRESSED, Mode.STROKE}:
            return Answer.TAKEN
        if given.kind == "F":
            self.end_sizing() if self.mode is Mode.SIZING else self.begin_sizing(given)
            return Answer.TAKEN
        if given.kind in REMOVE_KEYS and sketch.state.picks:
            sketch.remove(len(sketch.state.picks) - 1 if self.hovered is None else self.hovered)
        elif given.kind == "C":
            if not sketch.toggle_closed():
                self.hint = "a loop needs three picks"
        elif given.kind == "T":
            sketch.cycle_filter()
        else:
            # Nothing that Blender's own keys do belongs into a drawing, but its view's menus and panels do.
            return Answer.TAKEN if given.is_over_view and given.kind not in {"N", "ACCENT_GRAVE"} else Answer.PASSED
        self.hovered, self.is_changed = None, True
        return Answer.TAKEN

    def keep(self, given: Input) -> Answer:
        """Enter: ends what is going on, and keeps the line where there is one."""
        if self.mode is Mode.SIZING:
            self.end_sizing()
            return Answer.TAKEN
        if self.mode is not Mode.IDLE:
            self.release(given)
        if self.sketch.has_line():
            return Answer.KEEP
        self.hint = "two picks make a line, three a loop; click on the mesh"
        return Answer.TAKEN

    def press(self, given: Input) -> Answer:
        """Take hold of the pick under the mouse, or set one."""
        if not given.is_over_view:
            return Answer.PASSED
        sketch = self.sketch
        self.start = self.last = given.mouse
        near = self.canvas.find_near_pick(given.mouse, REACH * self.canvas.scale)
        if near is not None and not given.ctrl:
            sketch.hold()
            self.mode, self.held = Mode.DRAGGING, near
            return Answer.TAKEN
        pick = self.canvas.find_pick(given, given.shift)
        if pick is None:
            return Answer.TAKEN
        sketch.hold()
        picks = sketch.state.picks
        place = self.canvas.find_leg(pick) if given.ctrl and len(picks) > 1 else len(picks)
        sketch.change(picks=(*picks[:place], pick, *picks[place:]))
        # One that is put between others, or onto a vertex, is adjusted while the button is down; others draw.
        self.mode = Mode.DRAGGING if given.ctrl or given.shift else Mode.PRESSED
        self.held = self.hovered = place
        self.trail = [pick]
        self.is_changed = True
        return Answer.TAKEN

    def move(self, given: Input) -> Answer:
        """The mouse moved."""
        if self.mode is Mode.IDLE:
            self.hovered = self.canvas.find_near_pick(given.mouse, REACH * self.canvas.scale)
            return Answer.PASSED
        if self.mode is Mode.SIZING:
            radius = max(measure_distance(given.mouse, self.circle.centre), LEAST_SIZE)
            self.sketch.change(detail_size=radius * self.circle.pixel)
            self.is_changed = True
            return Answer.TAKEN
        has_left = measure_distance(given.mouse, self.start) >= self.canvas.drag_threshold
        if self.mode is Mode.PRESSED and has_left:
            self.mode, self.hovered = Mode.STROKE, None
        if self.mode is Mode.STROKE:
            if measure_distance(given.mouse, self.last) >= SAMPLE_STEP * self.canvas.scale:
                self.sample(given)
        elif self.mode is Mode.DRAGGING and (has_left or self.last != self.start):
            self.last = given.mouse
            pick = self.canvas.find_pick(given, given.shift)
            picks = self.sketch.state.picks
            if pick is not None and pick != picks[self.held]:
                self.sketch.change(picks=(*picks[: self.held], pick, *picks[self.held + 1 :]))
                self.is_changed = True
        return Answer.TAKEN

    def sample(self, given: Input) -> None:
        """One more point of the stroke; beside the surface there is none, and the line will bridge the gap."""
        self.last = given.mouse
        pick = self.canvas.find_pick(given, False)
        if pick is not None and pick.place != self.trail[-1].place:
            self.trail.append(pick)

    def release(self, given: Input) -> Answer:
        """Let go of what the press took hold of."""
        if self.mode is Mode.IDLE:
            return Answer.TAKEN
        sketch, mode = self.sketch, self.mode
        if mode is Mode.STROKE:
            if given.mouse != self.last and given.kind == "LEFTMOUSE":
                self.sample(given)
            self.end_stroke(given)
        elif mode is Mode.DRAGGING and self.held == 0 and self.last == self.start and not sketch.state.is_closed:
            # A click on the first pick closes the line, as in other drawing tools.
            sketch.change(is_closed=len(sketch.state.picks) >= 3 and sketch.done[-1].picks == sketch.state.picks)
        self.mode, self.held, self.trail = Mode.IDLE, None, []
        sketch.let_go()
        self.is_changed = True
        return Answer.TAKEN

    def end_stroke(self, given: Input) -> None:
        """The stroke becomes a few picks; one that ends at the line's first pick closes the line."""
        before = self.sketch.done[-1]
        fitted = self.canvas.fit_stroke(before.picks, self.trail)
        picks = (*before.picks, *fitted)
        self.sketch.change(picks=picks)
        is_at_start = (
            self.canvas.find_near_pick(given.mouse, REACH * self.canvas.scale) in {0, len(picks) - 1}
            and len(picks) > 3
            and self.canvas.measure_pixel(picks[0].place) * 2 * REACH * self.canvas.scale
            > measure_distance(picks[0].place, picks[-1].place)
        )
        if is_at_start and not before.is_closed:
            self.sketch.change(picks=picks[:-1], is_closed=True)

    def call_off(self) -> None:
        """End what is going on and take it back."""
        if self.mode is not Mode.IDLE:
            self.sketch.call_off()
            self.mode, self.held, self.trail, self.circle = Mode.IDLE, None, [], None
            self.is_changed = True

    def scale_detail(self, steps: int) -> None:
        """One step of the wheel."""
        if self.sketch.state.filter != "FAIR":
            self.hint = "only Fair has a detail size; T chooses the filter"
        elif self.mode is Mode.IDLE and self.sketch.state.picks:
            self.sketch.scale_detail(steps, self.canvas.measure_first_detail())
            self.is_changed = True

    def begin_sizing(self, given: Input) -> None:
        """Change the detail size by a circle, as Blender's brushes do their radius."""
        state = self.sketch.state
        if state.filter != "FAIR":
            self.hint = "only Fair has a detail size; T chooses the filter"
            return
        if not state.picks:
            self.hint = "set a pick first"
            return
        under = self.canvas.find_pick(given, False)
        pixel = self.canvas.measure_pixel(under.place if under is not None else state.picks[-1].place)
        size = state.detail_size or self.canvas.measure_first_detail()
        radius = max(size / pixel, LEAST_SIZE)
        self.sketch.hold()
        self.circle = SizeCircle((given.mouse[0] - radius, given.mouse[1]), pixel, state)
        self.mode = Mode.SIZING
        self.sketch.change(detail_size=radius * pixel)
        self.is_changed = True

    def end_sizing(self) -> None:
        """Keep the detail size as it is now."""
        self.mode, self.circle = Mode.IDLE, None
        self.sketch.let_go()
        self.is_changed = True


def measure_distance(a: tuple[float, ...], b: tuple[float, ...]) -> float:
    """Between two points."""
    return sum((x - y) ** 2 for x, y in zip(a, b, strict=True)) ** 0.5


def forget_hint(gestures: Gestures) -> str:
    """The hint of the last event, once."""
    hint, gestures.hint = gestures.hint, ""
    return hint
