# SPDX-License-Identifier: GPL-3.0-or-later
"""What is being drawn: picks on the surface and a few settings, with every step kept for undo and redo.

Plain Python: knows neither Blender nor the library, and is tested by itself.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

FILTERS = ("FAIR", "GEODESIC", "LINEAR", "CUBIC")

# One turn of the wheel makes the detail size larger or smaller by this factor.
DETAIL_STEP = 1.25


@dataclass(frozen=True)
class SketchPick:
    """A point of the surface: its triangle, its weights there, and its place in world space."""

    triangle: int
    barycentric: tuple[float, float, float]
    place: tuple[float, float, float]


@dataclass(frozen=True)
class SketchState:
    """One step of a drawing."""

    picks: tuple[SketchPick, ...] = ()
    is_closed: bool = False
    filter: str = FILTERS[0]
    detail_size: float = 0.0  # in world units; 0: automatic


@dataclass
class Sketch:
    """The drawing now, and the way to it."""

    state: SketchState = field(default_factory=SketchState)
    done: list[SketchState] = field(default_factory=list)
    undone: list[SketchState] = field(default_factory=list)

    def step(self, state: SketchState) -> None:
        """Go on to `state`, so that one undo leads back; an equal state is no step."""
        if state != self.state:
            self.done.append(self.state)
            self.undone.clear()
            self.state = state

    def change(self, **changes: Any) -> None:
        """Change the state as a part of the step that `hold` began."""
        self.state = replace(self.state, **changes)

    def hold(self) -> None:
        """Begin a step whose end is still open, such as a drag."""
        self.done.append(self.state)

    def let_go(self) -> None:
        """End the step that `hold` began; one that changed nothing is none."""
        if self.done[-1] == self.state:
            self.done.pop()
        else:
            self.undone.clear()

    def call_off(self) -> None:
        """End the step that `hold` began, and take it back."""
        self.state = self.done.pop()

    def move_picks(self, move: Callable[[SketchPick], SketchPick]) -> None:
        """Replace every pick, also in the steps that undo and redo lead to: the surface under them has changed."""
        moved: dict[SketchPick, SketchPick] = {}

        def replace_picks(state: SketchState) -> SketchState:
            for pick in state.picks:
                if pick not in moved:
                    moved[pick] = move(pick)
            return replace(state, picks=tuple(moved[pick] for pick in state.picks))

        self.state = replace_picks(self.state)
        self.done = [replace_picks(state) for state in self.done]
        self.undone = [replace_picks(state) for state in self.undone]

    def remove(self, place: int) -> None:
        """Take a pick out; a loop of two picks is none."""
        picks = self.state.picks
        left = (*picks[:place], *picks[place + 1 :])
        self.step(replace(self.state, picks=left, is_closed=self.state.is_closed and len(left) >= 3))

    def toggle_closed(self) -> bool:
        """Close the line or open it; False when it has too few picks for a loop."""
        if len(self.state.picks) < 3:
            return False
        self.step(replace(self.state, is_closed=not self.state.is_closed))
        return True

    def cycle_filter(self) -> None:
        """The next filter."""
        following = (FILTERS.index(self.state.filter) + 1) % len(FILTERS)
        self.step(replace(self.state, filter=FILTERS[following]))

    def scale_detail(self, steps: int, start: float) -> None:
        """A larger or smaller detail size; `start` stands for automatic."""
        size = (self.state.detail_size or start) * DETAIL_STEP**steps
        self.step(replace(self.state, detail_size=size))

    def undo(self) -> bool:
        """One step back; False at the beginning."""
        if not self.done:
            return False
        self.undone.append(self.state)
        self.state = self.done.pop()
        return True

    def redo(self) -> bool:
        """One step forward again; False at the end."""
        if not self.undone:
            return False
        self.done.append(self.state)
        self.state = self.undone.pop()
        return True

    def has_line(self) -> bool:
        """Whether there are picks enough for a line."""
        return len(self.state.picks) >= (3 if self.state.is_closed else 2)
