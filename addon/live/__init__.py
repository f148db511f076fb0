# SPDX-License-Identifier: GPL-3.0-or-later
"""Curves that remember what made them: `memory` what they know, `follow` how they stay on a moving mesh.

Holds nothing but what must be registered.
"""

from . import follow, memory

CLASSES = (memory.SmoothPolylineMemory,)


def register() -> None:
    """After the classes: what curves know, and the handlers."""
    memory.register()
    follow.register()


def unregister() -> None:
    """Take both back; what is not there does no harm."""
    follow.unregister()
    memory.unregister()
