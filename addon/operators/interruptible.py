# SPDX-License-Identifier: GPL-3.0-or-later
"""Mixed into operators that may take long: called by a person they run in a thread, and Esc ends them.

Called by a script, or again from the panel of the last operation, they are executed at once. Holds no work of its own.
"""

import bpy

from .. import ahead

# How long the call itself waits: nobody notices, and most lines are done in it.
PATIENCE = 0.1
TICK = 0.02  # seconds between two looks at the thread


def has_person(context: bpy.types.Context) -> bool:
    """Whether somebody could press Esc."""
    return context.window is not None and not bpy.app.background


class Interruptible:
    """Calls the operator's own `execute`, as often as there are steps to be waited for."""

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        """Begin; done at once where it is short."""
        if not has_person(context):
            return self.execute(context)
        self.run, self.timer = ahead.Run(), None
        outcome = ahead.finish(self.run, lambda: self.execute(context), PATIENCE)
        if outcome is not None:
            return outcome
        self.window, self.workspace = context.window, context.workspace
        self.timer = context.window_manager.event_timer_add(TICK, window=context.window)
        self.window.cursor_modal_set("WAIT")
        self.workspace.status_text_set(f"{self.bl_label} is at work. Esc stops it; nothing is changed then")
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Esc ends it; else look whether the thread is done."""
        if event.type == "ESC" and event.value == "PRESS":
            self.cancel(context)
            self.report({"INFO"}, f"{self.bl_label} was stopped; nothing was changed")
            return {"CANCELLED"}
        if event.type == "TIMER":
            outcome = ahead.finish(self.run, lambda: self.execute(context), 0.0)
            if outcome is not None:
                self.cancel(context)
                return outcome
        return {"RUNNING_MODAL"}

    def cancel(self, context: bpy.types.Context) -> None:
        """Leave nothing on the screen and nothing at work; also called by Blender, when another file is opened."""
        self.run.leave()
        if self.timer is not None:
            context.window_manager.event_timer_remove(self.timer)
            self.timer = None
            self.window.cursor_modal_restore()
            self.workspace.status_text_set(None)
