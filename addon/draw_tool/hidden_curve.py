# SPDX-License-Identifier: GPL-3.0-or-later
"""Hides a curve while its line is drawn in its place, and shows it for as long as a file is being saved.

Hiding is a part of the file: without that, saving in the middle of a drawing would leave it hidden for good. Knows no
lines.
"""

from typing import Any

import bpy


class HiddenCurve:
    """An object that may be hidden for a while, by name: undo and scripts may take it away meanwhile."""

    def __init__(self) -> None:
        self.name = ""
        self.was_selected = False
        self.is_hiding = False
        self.handlers = (
            (bpy.app.handlers.save_pre, self.before_saving),
            (bpy.app.handlers.save_post, self.after_saving),
            (bpy.app.handlers.save_post_fail, self.after_saving),
        )

    def hide(self, name: str) -> None:
        """Hide the object of that name until `show`; one that is hidden already stays so after it."""
        self.name = name
        self.is_hiding = self.set_hidden(True)
        if self.is_hiding:
            for handlers, handler in self.handlers:
                handlers.append(handler)

    def show(self) -> None:
        """Show it again, selected as it was."""
        if self.is_hiding:
            self.is_hiding = False
            for handlers, handler in self.handlers:
                if handler in handlers:  # another file has none of them
                    handlers.remove(handler)
            self.set_hidden(False)

    def before_saving(self, *_arguments: Any) -> None:
        """What is saved is as if nothing were being drawn."""
        self.set_hidden(False)

    def after_saving(self, *_arguments: Any) -> None:
        """Go on."""
        self.set_hidden(True)

    def set_hidden(self, is_hidden: bool) -> bool:
        """Hide or show the object; whether that changed anything."""
        found = bpy.context.view_layer.objects.get(self.name)
        if found is None or found.hide_get() == is_hidden:
            return False
        if is_hidden:
            self.was_selected = found.select_get()
        found.hide_set(is_hidden)
        if not is_hidden:
            found.select_set(self.was_selected)
        return True
