# SPDX-License-Identifier: GPL-3.0-or-later
"""The draw tool: `sketch` what is drawn and its steps, `gestures` what mouse and keys mean, both plain Python; `stroke`
which samples of a stroke become picks; `view` where on the surface and on the screen, `canvas` that for the gestures;
`opening` how a mesh is opened; `drawing` one run; `overlay` how it is shown; `operator` the events; `tool` the toolbar.

Holds nothing but what must be registered.
"""

from . import drawing, edit_picks, operator, tool

CLASSES = (
    operator.VIEW3D_OT_smooth_polyline_draw,
    edit_picks.VIEW3D_OT_smooth_polyline_edit_picks,
    tool.VIEW3D_PT_smooth_polyline_tool,
)


def register() -> None:
    """After the classes: the tool in the toolbars."""
    tool.register()


def unregister() -> None:
    """Take it back, and end a drawing that is going on; what is not there does no harm."""
    drawing.stop_all()
    tool.unregister()
