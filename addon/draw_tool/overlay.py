# SPDX-License-Identifier: GPL-3.0-or-later
"""Shows what is being drawn over the surface: the line, its hidden parts dimmed, and the picks.

Draws arrays that others have made. Touches the graphics card only while drawing.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

import bpy

LINE_WIDTH = 3.0  # pixels at a scale of 1
PICK_RADIUS = 5.0
HIDDEN_ALPHA = 0.25
PICK_RIM = 1.5
HOVERED_GROWTH = 1.4
CIRCLE_WIDTH = 1.5
CIRCLE = np.array([(np.cos(a), np.sin(a)) for a in np.linspace(0, 2 * np.pi, 33)])
# How much nearer to the viewer the line is drawn than it is, as a part of the distance: so that it is not half inside.
LIFT = 0.002
KEYS = (
    (("MOUSE_LMB",), "Pick"),
    (("MOUSE_LMB_DRAG",), "Stroke, or Move a Pick"),
    (("EVENT_CTRL", "MOUSE_LMB"), "Insert"),
    (("EVENT_SHIFT",), "Snap"),
    (("EVENT_X",), "Remove"),
    (("EVENT_C",), "Close"),
    (("EVENT_T",), "Filter"),
    (("EVENT_F",), "Detail Size"),
    (("EVENT_CTRL", "EVENT_Z"), "Step Back"),
    (("EVENT_RETURN",), "Keep"),
    (("EVENT_ESC",), "Leave"),
)


def get_scale(context: bpy.types.Context) -> float:
    """Pixels on this display for one of an ordinary one."""
    return context.preferences.system.ui_scale


def draw_line(context: bpy.types.Context, points: np.ndarray, is_closed: bool) -> None:
    """In world space: once what is seen, once, dimmed, what the surface hides."""
    import gpu

    if len(points) < 2:
        return
    region_3d = context.region_data
    view = np.array(region_3d.view_matrix.inverted(), dtype=np.float64)
    towards = view[:3, 3] - points if region_3d.is_perspective else view[:3, 2] * region_3d.view_distance
    lifted = points + LIFT * towards
    if is_closed:
        lifted = np.concatenate([lifted, lifted[:1]])
    color = context.preferences.themes[0].view_3d.edge_select[:3]
    for test, alpha in (("GREATER", HIDDEN_ALPHA), ("LESS_EQUAL", 1.0)):
        gpu.state.depth_test_set(test)
        draw_chain(context, lifted, LINE_WIDTH, (*color, alpha))
    gpu.state.depth_test_set("NONE")


def draw_picks(
    context: bpy.types.Context, places: list[np.ndarray | None], hovered: int | None, is_hidden: list[bool]
) -> None:
    """In region pixels: a disc at each place, the one under the mouse larger, those behind the surface dimmed."""
    import gpu

    theme = context.preferences.themes[0].view_3d
    scale = get_scale(context)
    gpu.state.blend_set("ALPHA")
    for number, place in enumerate(places):
        if place is None:
            continue
        alpha = HIDDEN_ALPHA if number < len(is_hidden) and is_hidden[number] and number != hovered else 1.0
        radius = PICK_RADIUS * scale * (HOVERED_GROWTH if number == hovered else 1.0)
        draw_disc(place, radius + PICK_RIM * scale, (*theme.wire_edit[:3], alpha))
        draw_disc(place, radius, (*theme.vertex_select[:3], alpha))
    gpu.state.blend_set("NONE")


def draw_disc(centre: np.ndarray, radius: float, color: tuple[float, ...]) -> None:
    """A filled disc in region pixels, with a soft rim so that it is round on any display."""
    from gpu_extras.batch import batch_for_shader

    import gpu

    inner, outer = centre + (radius - 0.5) * CIRCLE, centre + (radius + 0.5) * CIRCLE
    solid, faded = color, (*color[:3], 0.0)
    corners, colors = [], []
    for k in range(len(CIRCLE) - 1):
        corners += [centre, inner[k], inner[k + 1]]
        colors += [solid] * 3
        corners += [inner[k], outer[k], outer[k + 1], inner[k], outer[k + 1], inner[k + 1]]
        colors += [solid, faded, faded, solid, faded, solid]
    shader = gpu.shader.from_builtin("SMOOTH_COLOR")
    batch = batch_for_shader(shader, "TRIS", {"pos": np.array(corners, dtype=np.float32), "color": colors})
    shader.bind()
    batch.draw(shader)


def draw_circle(context: bpy.types.Context, centre: tuple[float, float], radius: float) -> None:
    """In region pixels: the circle whose radius is the detail size, as for a brush."""
    rim = np.array(centre) + radius * CIRCLE
    color = (*context.preferences.themes[0].view_3d.vertex_select[:3], 1.0)
    draw_chain(context, np.column_stack([rim, np.zeros(len(rim))]), CIRCLE_WIDTH, color)


def draw_chain(context: bpy.types.Context, points: np.ndarray, width: float, color: tuple[float, ...]) -> None:
    """Straight pieces of a width in pixels of an ordinary display."""
    from gpu_extras.batch import batch_for_shader

    import gpu

    shader = gpu.shader.from_builtin("POLYLINE_UNIFORM_COLOR")
    batch = batch_for_shader(shader, "LINE_STRIP", {"pos": points.astype(np.float32)})
    shader.bind()
    shader.uniform_float("viewportSize", gpu.state.viewport_get()[2:])
    shader.uniform_float("lineWidth", width * get_scale(context))
    shader.uniform_float("color", color)
    gpu.state.blend_set("ALPHA")
    batch.draw(shader)
    gpu.state.blend_set("NONE")


def draw_status(header: bpy.types.Header, _context: bpy.types.Context) -> None:
    """The keys, in the status bar, by Blender's own icons."""
    row = header.layout.row(align=True)
    for icons, text in KEYS:
        for icon in icons:
            row.label(text="", icon=icon)
        # The icons of keys with long names are wider than their place.
        row.label(text=f"  {text}" if icons[-1] in {"EVENT_ESC", "EVENT_RETURN"} else text)
        row.separator(factor=0.7)


def add_handlers(draw_view: Callable[[], None], draw_pixels: Callable[[], None]) -> list[Any]:
    """Call these at each redraw of a 3D view; what `remove_handlers` takes."""
    add = bpy.types.SpaceView3D.draw_handler_add
    return [add(draw_view, (), "WINDOW", "POST_VIEW"), add(draw_pixels, (), "WINDOW", "POST_PIXEL")]


def remove_handlers(handlers: list[Any]) -> None:
    """Take them back; a second time does no harm."""
    while handlers:
        bpy.types.SpaceView3D.draw_handler_remove(handlers.pop(), "WINDOW")
