# SPDX-License-Identifier: GPL-3.0-or-later
"""What can be set of a line: the properties, how they are laid out, and what they mean to the library.

The same for the operator and for a curve that remembers. Names and enum items are fixed: scripts rely on them. Holds no
geometry and changes nothing.
"""

from typing import Any

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, StringProperty

from . import line_data

FILTERS = (
    ("LINEAR", "Linear", "Straighten: every crossing moves to the straight line between its neighbours"),
    ("CUBIC", "Cubic", "Keep the overall shape and take out small detail"),
    ("GEODESIC", "Geodesic", "The locally shortest line on the surface, exactly"),
    ("FAIR", "Fair", "The smoothest line near the picks, whatever the triangulation"),
    ("NONE", "None", "No smoothing: through the midpoints of the edges between the picked faces"),
)
PINS = (
    ("ENDS", "Ends", "Only the two ends of an open line are passed exactly; the other picks are hints"),
    ("ALL", "All Picks", "The line passes through the centre of every picked face"),
)
SOLVERS = (
    ("AUTO", "Automatic", "The fastest that goes all the way"),
    (
        "HEAP",
        "One by One",
        "The method of the paper: one crossing at a time, the most wrong first, up to the threshold",
    ),
)
KNOTS = (
    ("CENTRIPETAL", "Centripetal", "Steps by the square root of the distances: the smoothest lines"),
    ("UNIFORM", "Uniform", "As in the paper: equal steps, whatever the distances of the crossings"),
    ("CHORDAL", "Chordal", "Steps by the distances"),
)

DEFAULT_NAME = "Smooth Polyline"
SOURCES = (
    ("BASE", "Base Mesh", "The mesh as it is edited; the curve then follows what modifiers make of it"),
    ("EVALUATED", "With Modifiers", "The mesh after its modifiers, such as Subdivision; picked faces give the places"),
)


class LineSettings:
    """Mixed into whatever shows these settings."""

    source: EnumProperty(name="Source", description="What the line is made on", items=SOURCES, default="BASE")
    filter: EnumProperty(name="Filter", description="What makes the line smooth", items=FILTERS, default="LINEAR")
    closed: BoolProperty(name="Closed", description="Join the last pick to the first", default=False)
    pinned: EnumProperty(name="Pinned", description="Picks that the line passes exactly", items=PINS, default="ENDS")
    solver: EnumProperty(name="Solver", description="How Linear and Cubic are computed", items=SOLVERS, default="AUTO")
    knots: EnumProperty(name="Knots", description="Spacing that Cubic works with", items=KNOTS, default="CENTRIPETAL")
    support: IntProperty(
        name="Support",
        description="Crossings on each side that Cubic looks at; 2: as in the paper, more: larger detail goes",
        default=2,
        min=2,
        max=16,
    )
    threshold: FloatProperty(
        name="Threshold",
        description="Error at which sliding stops, as a part of an edge: for Cubic, and for Linear one by one",
        default=1e-4,
        min=1e-12,
        max=1.0,
        soft_min=1e-8,
        soft_max=0.1,
        precision=6,
    )
    max_iterations: IntProperty(
        name="Max Iterations",
        description="Most rounds of smoothing; 0: the filter's own limit",
        default=0,
        min=0,
        soft_max=1000,
    )
    detail_size: FloatProperty(
        name="Detail Size",
        description="Fair only: wiggles much shorter than this go, longer ones stay; 0: automatic",
        default=0.0,
        min=0.0,
        subtype="DISTANCE",
        unit="LENGTH",
    )
    bevel: FloatProperty(
        name="Bevel",
        description="Radius of the tube that shows the curve; 0: automatic, from the size of the mesh",
        default=0.0,
        min=0.0,
        precision=4,
        subtype="DISTANCE",
        unit="LENGTH",
    )
    offset: FloatProperty(
        name="Offset",
        description="Distance from the surface along its normal; 0: exactly on it",
        default=0.0,
        precision=4,
        subtype="DISTANCE",
        unit="LENGTH",
    )
    resample: FloatProperty(
        name="Resample",
        description="Even spacing of the points along the curve; 0: a point at every edge that the line crosses",
        default=0.0,
        min=0.0,
        precision=4,
        subtype="DISTANCE",
        unit="LENGTH",
    )


class NewLineSettings(LineSettings):
    """Mixed into what makes new lines: what becomes of them in the scene."""

    output: EnumProperty(
        name="Output", description="The kind of object that the line becomes", items=line_data.OUTPUTS, default="CURVE"
    )
    name: StringProperty(name="Name", description="Name of the new object", default=DEFAULT_NAME)
    collection: StringProperty(name="Collection", description="Where the new object goes; empty: where the mesh is")
    material: StringProperty(name="Material", description="Material of the new object; empty: none")


def copy_line_settings(source: Any, target: Any) -> None:
    """Give `target` the settings of a line that `source` has."""
    for name in LineSettings.__annotations__:
        setattr(target, name, getattr(source, name))


def read_decimal(value: float) -> float:
    """The number that was typed: Blender keeps it in single precision, in which 0.0001 is a little less than that."""
    return float(f"{value:.7g}")


def choose_line_options(settings: Any) -> dict[str, Any]:
    """The options of the library's `SurfaceMesh.polyline`, but for `detail_size` in the object's units.

    What the filter does not use is greyed out in the panel; a value left over from before does no harm.
    """
    is_cubic = settings.filter == "CUBIC"
    return {
        "closed": settings.closed,
        "filter": settings.filter.lower(),
        "pinned": settings.pinned.lower(),
        "solver": settings.solver.lower() if settings.filter in {"LINEAR", "CUBIC"} else "auto",
        "knots": settings.knots.lower() if is_cubic else "centripetal",
        "support": settings.support if is_cubic else 2,
        "threshold": read_decimal(settings.threshold),
        "max_iterations": settings.max_iterations or None,
        "detail_size": (settings.detail_size or None) if settings.filter == "FAIR" else None,
    }


def choose_new_line_options(settings: Any) -> dict[str, Any]:
    """What `session.add_polylines` takes beside the options of the line."""
    names = ("source", "offset", "resample", "output", "name", "collection", "material")
    return {"bevel": settings.bevel or None, **{name: getattr(settings, name) for name in names}}


def draw_line_settings(layout: bpy.types.UILayout, settings: Any, output: str = "CURVE") -> None:
    """Lay the settings out, one a row; what the filter does not use is greyed out."""
    layout.use_property_split = True
    layout.use_property_decorate = False
    is_by_heap = settings.solver == "HEAP" and settings.filter in {"LINEAR", "CUBIC"}
    for name, is_enabled in (
        ("source", True),
        ("filter", True),
        ("closed", True),
        ("pinned", True),
        ("detail_size", settings.filter == "FAIR"),
        ("knots", settings.filter == "CUBIC"),
        ("support", settings.filter == "CUBIC"),
        ("solver", settings.filter in {"LINEAR", "CUBIC"}),
        ("threshold", settings.filter == "CUBIC" or is_by_heap),
        ("max_iterations", settings.filter != "NONE"),
    ):
        row = layout.row()
        row.enabled = is_enabled
        row.prop(settings, name)
    layout.separator()
    for name in ("bevel", "offset", "resample"):
        row = layout.row()
        # The edges of a mesh have no thickness.
        row.enabled = name != "bevel" or output != "MESH"
        row.prop(settings, name)


def draw_new_line_settings(layout: bpy.types.UILayout, settings: Any) -> None:
    """The same, and what becomes of a new line."""
    draw_line_settings(layout, settings, settings.output)
    layout.separator()
    layout.prop(settings, "output")
    layout.prop(settings, "name")
    layout.prop_search(settings, "collection", bpy.data, "collections")
    layout.prop_search(settings, "material", bpy.data, "materials")
