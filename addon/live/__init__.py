# SPDX-License-Identifier: GPL-3.0-or-later
"""Curves that remember what made them: `memory` what they know, `follow` how they stay on a moving mesh,
`place` the collection and material of their object.

Holds nothing but what must be registered.
"""

from . import follow, memory, place

CLASSES = (memory.SmoothPolylineMemory,)


def register() -> None:
    """After the classes: what curves know, and the handlers."""
    memory.register()
    place.register()
    follow.register()


def unregister() -> None:
    """Take both back; what is not there does no harm."""
    follow.unregister()
    place.unregister()
    memory.unregister()
