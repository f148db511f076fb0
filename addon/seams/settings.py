# SPDX-License-Identifier: GPL-3.0-or-later
"""What can be set where lines are put into a mesh, and marks copied. Holds no logic."""

from bpy.props import BoolProperty, EnumProperty, FloatProperty

from . import edge_marks

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


def order_marks(chosen: set[str]) -> tuple[str, ...]:
    """The chosen marks in the order in which they are shown: a set has none."""
    return tuple(mark for mark in edge_marks.MARKS if mark in chosen)
