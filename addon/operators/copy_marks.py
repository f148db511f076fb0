# SPDX-License-Identifier: GPL-3.0-or-later
"""Copies the active mesh's marks to other selected meshes; mirrors marks within a mesh. Holds no logic of its own."""

import bpy
from bpy.props import EnumProperty, FloatProperty

from .. import active, guard
from ..errors import ObjectError
from ..seams import copy_marks, settings


def has_active_mesh(operator: type[bpy.types.Operator], context: bpy.types.Context, advice: str) -> bool:
    """Whether the active object is a mesh; else what to do is shown."""
    if active.is_mesh_active(context):
        return True
    operator.poll_message_set(advice)
    return False


class MESH_OT_smooth_polyline_copy_marks(settings.MarkSettings, bpy.types.Operator):
    """Give the other selected meshes of the same topology the seams and other edge marks of the active one"""

    bl_idname = "mesh.smooth_polyline_copy_marks"
    bl_label = "Copy Edge Marks to Selected"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Whether the active object is a mesh."""
        return has_active_mesh(
            cls, context, "Select the meshes that shall get the marks, and last the mesh that has them"
        )

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Copy to each selected mesh; all or none."""
        return guard.run_guarded(self, lambda: self.copy(context))

    def copy(self, context: bpy.types.Context) -> None:
        """Call the plain function once a mesh, tell what came out."""
        source = active.get_active(context)
        targets = {o.data: o for o in active.list_selected(context) if o.type == "MESH" and o.data != source.data}
        if not targets:
            raise ObjectError(
                f"No other mesh is selected; select those that shall get the marks, and last {source.name} with them"
            )
        chosen = settings.order_marks(self.marks)
        # All are compared before any is changed.
        copy_marks.check_topologies(source, list(targets.values()))
        changed = sum(copy_marks.copy_marks(source, target, chosen).changed for target in targets.values())
        self.report({"INFO"}, f"{changed} edges of {len(targets)} meshes have other marks now")


class MESH_OT_smooth_polyline_mirror_marks(settings.MarkSettings, bpy.types.Operator):
    """Mirror seams and other edge marks across a plane through the object's origin"""

    bl_idname = "mesh.smooth_polyline_mirror_marks"
    bl_label = "Mirror Edge Marks"
    bl_options = {"REGISTER", "UNDO"}

    axis: EnumProperty(
        name="Axis",
        description="The object's axis across the plane",
        items=[(axis, axis, f"Mirror across the plane {axis} = 0") for axis in "XYZ"],
        default="X",
    )
    direction: EnumProperty(
        name="Direction",
        description="Which side's marks are kept",
        items=[
            ("POSITIVE_TO_NEGATIVE", "+ to -", "The negative side gets the marks of the positive one"),
            ("NEGATIVE_TO_POSITIVE", "- to +", "The positive side gets the marks of the negative one"),
            ("BOTH", "Both", "Each side gets those of the other too"),
        ],
        default="POSITIVE_TO_NEGATIVE",
    )
    method: EnumProperty(
        name="Method",
        description="How the other side of an edge is found",
        items=[
            ("POSITION", "Position", "The edge nearest to the mirror image"),
            ("TOPOLOGY", "Topology", "By who is joined to whom, from the plane outwards: also on a posed mesh"),
        ],
        default="POSITION",
    )
    tolerance: FloatProperty(
        name="Tolerance",
        description="How far a vertex may lie from its mirror image, and from the plane",
        default=1e-4,
        min=1e-9,
        precision=5,
        subtype="DISTANCE",
        unit="LENGTH",
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Whether the active object is a mesh."""
        return has_active_mesh(cls, context, "Make a mesh the active object")

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Mirror the marks of the active mesh."""
        return guard.run_guarded(self, lambda: self.mirror(context))

    def mirror(self, context: bpy.types.Context) -> None:
        """Call the plain function, tell what came out."""
        done = copy_marks.mirror_marks(
            active.get_active(context),
            self.axis,
            settings.order_marks(self.marks),
            method=self.method,
            direction=self.direction,
            tolerance=self.tolerance,
        )
        told = f"{done.changed} edges have other marks now"
        if done.unmatched:
            self.report({"WARNING"}, f"{told}; {done.unmatched} edges have no mirror image and were left as they are")
        else:
            self.report({"INFO"}, told)
