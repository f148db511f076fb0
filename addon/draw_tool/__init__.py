# SPDX-License-Identifier: GPL-3.0-or-later
"""The draw tool: `sketch` what is drawn and its steps, `view` where on the surface and on the screen, `overlay` how it
is shown, `operator` the events, `tool` its place in the toolbar.

Holds nothing but what must be registered.
"""

from . import operator, tool

CLASSES = (operator.VIEW3D_OT_smooth_polyline_draw,)


def register() -> None:
    """After the classes: the tool in the toolbars."""
    tool.register()


def unregister() -> None:
    """Take it back, and end a drawing that is going on; what is not there does no harm."""
    operator.stop_all()
    tool.unregister()
