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
CIRCLE = np.array([(np.cos(a), np.sin(a)) for a in np.linspace(0, 2 * np.pi, 17)])
# How much nearer to the viewer the line is drawn than it is, as a part of the distance: so that it is not half inside.
LIFT = 0.002


def get_scale(context: bpy.types.Context) -> float:
    """Pixels on this display for one of an ordinary one."""
    return context.preferences.system.ui_scale


def draw_line(context: bpy.types.Context, points: np.ndarray, is_closed: bool) -> None:
    """In world space: once what is seen, once, dimmed, what the surface hides."""
    from gpu_extras.batch import batch_for_shader

    import gpu

    if len(points) < 2:
        return
    region_3d = context.region_data
    view = np.array(region_3d.view_matrix.inverted(), dtype=np.float64)
    towards = view[:3, 3] - points if region_3d.is_perspective else view[:3, 2] * region_3d.view_distance
    lifted = points + LIFT * towards
    if is_closed:
        lifted = np.concatenate([lifted, lifted[:1]])
    shader = gpu.shader.from_builtin("POLYLINE_UNIFORM_COLOR")
    batch = batch_for_shader(shader, "LINE_STRIP", {"pos": lifted.astype(np.float32)})
    shader.bind()
    shader.uniform_float("viewportSize", gpu.state.viewport_get()[2:])
    shader.uniform_float("lineWidth", LINE_WIDTH * get_scale(context))
    color = (*context.preferences.themes[0].view_3d.edge_select[:3], 1.0)
    gpu.state.blend_set("ALPHA")
    for test, alpha in (("GREATER", HIDDEN_ALPHA), ("LESS_EQUAL", 1.0)):
        gpu.state.depth_test_set(test)
        shader.uniform_float("color", (*color[:3], alpha))
        batch.draw(shader)
    gpu.state.depth_test_set("NONE")
    gpu.state.blend_set("NONE")


def draw_picks(context: bpy.types.Context, places: list[np.ndarray], hovered: int | None) -> None:
    """In region pixels: a disc at each place, the one under the mouse in another colour."""
    from gpu_extras.batch import batch_for_shader

    import gpu

    shader = gpu.shader.from_builtin("UNIFORM_COLOR")
    theme = context.preferences.themes[0].view_3d
    gpu.state.blend_set("ALPHA")
    for number, place in enumerate(places):
        is_hovered = number == hovered
        for radius, color in ((PICK_RADIUS + 1.5, (0, 0, 0)), (PICK_RADIUS, theme.vertex_select)):
            rim = place + radius * get_scale(context) * (1.4 if is_hovered else 1.0) * CIRCLE
            fan = np.concatenate([np.stack([np.broadcast_to(place, (16, 2)), rim[:-1], rim[1:]], axis=1)])
            batch = batch_for_shader(shader, "TRIS", {"pos": fan.reshape(-1, 2).astype(np.float32)})
            shader.bind()
            shader.uniform_float("color", (*color[:3], 1.0))
            batch.draw(shader)
    gpu.state.blend_set("NONE")


def add_handlers(draw_view: Callable[[], None], draw_pixels: Callable[[], None]) -> list[Any]:
    """Call these at each redraw of a 3D view; what `remove_handlers` takes."""
    add = bpy.types.SpaceView3D.draw_handler_add
    return [add(draw_view, (), "WINDOW", "POST_VIEW"), add(draw_pixels, (), "WINDOW", "POST_PIXEL")]


def remove_handlers(handlers: list[Any]) -> None:
    """Take them back; a second time does no harm."""
    while handlers:
        bpy.types.SpaceView3D.draw_handler_remove(handlers.pop(), "WINDOW")
