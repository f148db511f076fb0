# SPDX-License-Identifier: GPL-3.0-or-later
"""What can be set where lines are put into a mesh, and marks copied, and how that is shown. Holds no logic."""

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, StringProperty

from . import edge_marks, put

METHODS = (
    ("SNAP", "Snap", "Mark the existing edges nearest to the line; the mesh stays as it is"),
    ("SLIDE", "Slide", "Move the vertices of those edges onto the line, where this turns no face over"),
    ("CUT", "Cut", "Cut the faces along the line; what lies on the mesh is interpolated"),
)


class MarkSettings:
    """Which marks."""

    marks: EnumProperty(
        name="Marks",
        description="Marks of edges; Shift-click for several",
        items=edge_marks.MARK_ITEMS,
        options={"ENUM_FLAG"},
        default={"SEAM"},
    )


class WeightSettings:
    """How strong the marks are that have a strength."""

    weight: FloatProperty(
        name="Weight", description="Of creases and bevel weights", default=1.0, min=0.0, max=1.0, subtype="FACTOR"
    )


class UnwrapSettings:
    """What follows a seam."""

    unwrap: BoolProperty(
        name="Unwrap",
        description="Unwrap the mesh by its seams, and tell how much the islands are stretched",
        default=False,
    )


class PutSettings(MarkSettings, WeightSettings, UnwrapSettings):
    """What is set alike where lines or nets are put into a mesh, and what is told in the panel afterwards."""

    tolerance: FloatProperty(
        name="Tolerance",
        description="Cut: a line this near to a vertex or an edge, as a part of the edge or face, goes through it",
        default=put.DEFAULT_TOLERANCE,
        min=0.0,
        max=0.25,
        precision=4,
    )
    told: StringProperty(options={"HIDDEN", "SKIP_SAVE"})

    def draw_marks(self, layout: bpy.types.UILayout) -> None:
        """Marks, and the weight of those that have one."""
        layout.column().prop(self, "marks")
        row = layout.row()
        row.enabled = bool(self.marks & {"CREASE", "BEVEL_WEIGHT"})
        row.prop(self, "weight")

    def draw_told(self, layout: bpy.types.UILayout) -> None:
        """What came out the last time."""
        for line in self.told.splitlines():
            layout.label(text=line)


def order_marks(chosen: set[str]) -> tuple[str, ...]:
    """The chosen marks in the order in which they are shown: a set has none."""
    return tuple(mark for mark in edge_marks.MARKS if mark in chosen)
