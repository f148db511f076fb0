# SPDX-License-Identifier: GPL-3.0-or-later
"""Edit Picks from where there is no 3D view, as the Properties editor: starts the draw tool in the window's largest."""

import bpy
from bpy.props import StringProperty

from .. import guard
from ..errors import ObjectError
from ..live import memory


class VIEW3D_OT_smooth_polyline_edit_picks(bpy.types.Operator):
    """Edit the picks of this line in the 3D view"""

    bl_idname = "view3d.smooth_polyline_edit_picks"
    bl_label = "Edit Picks"
    bl_options = {"INTERNAL"}

    curve: StringProperty(name="Curve", description="The curve object whose picks are edited")

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Start the draw tool."""
        return guard.run_guarded(self, lambda: start(context, self.curve))


def start(context: bpy.types.Context, curve: str) -> None:
    """Start the draw tool on the picks of a curve object, in a 3D view of the window."""
    if memory.find_memory(bpy.data.objects.get(curve)) is None:
        raise ObjectError(f"{curve or 'Nothing'} is no curve made by Smooth Polylines; select one")
    views = [] if context.screen is None else [area for area in context.screen.areas if area.type == "VIEW_3D"]
    if not views:
        raise ObjectError("There is no 3D view in this window; open one, then edit the picks")
    area = max(views, key=lambda view: view.width * view.height)
    region = next(region for region in area.regions if region.type == "WINDOW")
    with context.temp_override(area=area, region=region):
        try:
            bpy.ops.view3d.smooth_polyline_draw("INVOKE_DEFAULT", curve=curve)
        except RuntimeError as error:
            # What the tool has said already, as a refusal of this operator too.
            raise ObjectError(str(error).removeprefix("Error: ").strip()) from error
