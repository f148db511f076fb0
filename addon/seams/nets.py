# SPDX-License-Identifier: GPL-3.0-or-later
"""Nets of lines cut into a mesh, and the patches between them: `put_net_into_mesh`, for scripts and operators.

Which picks are joined, which lines cross, and what a patch is, the library says. Holds no messages to the artist.
"""

import colorsys
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

import bpy

from .. import ahead, mesh_read, selection, session, surface
from ..errors import AddonError, ObjectError
from . import edge_marks, edit, put
from . import unwrap as unwrapping

CONNECTIONS = ("AUTOMATIC", "ALL", "CHAIN", "LOOP")
OUTPUTS = ("FACE_SETS", "MATERIALS", "COLORS")
FACE_SETS = ".sculpt_face_set"
COLORS = "Patches"


@dataclass
class PutNet:
    """What `put_net_into_mesh` has done."""

    lines: put.PutLines
    face_patches: np.ndarray  # (F,) int: the patch of every face of the mesh now, -1 for hidden ones
    sides: np.ndarray  # (P,) int: sides of every patch
    three_sided: int  # patches that are discs of three sides
    four_sided: int
    not_discs: int  # patches with a hole or a handle in them
    crossings: int  # crossings that the picks force: vertices of the cut, and corners of patches
    crossings_as_nodes: int  # of those, how many were made picks, from which the lines start anew
    errors: list[Exception]  # of lines that could not be made
    connections: np.ndarray  # (M, 2) the picks that the lines join, new ones last


def put_net_into_mesh(
    context: bpy.types.Context,
    mesh_object: bpy.types.Object,
    picks: Sequence[Any] | None = None,
    *,
    connections: Any = "AUTOMATIC",
    outputs: Sequence[str] = ("FACE_SETS",),
    marks: Sequence[str] = (),
    weight: float = 1.0,
    tolerance: float | None = None,
    crossings_as_nodes: bool = False,
    detail_size: float | None = None,
    unwrap: bool = False,
    **line_options: Any,
) -> PutNet:
    """Join picks by lines that do not cross where it can be helped, cut them into the mesh, and tell the patches apart.

    picks : as the library takes them; None: the faces selected in Edit Mode, for CHAIN and LOOP in the order of picking
    connections : AUTOMATIC: neighbours on the surface, so that patches lie around the picks; ALL: each with each;
        CHAIN; LOOP; or (M, 2) positions in `picks`
    outputs : what the patches become: FACE_SETS (of Sculpt Mode), MATERIALS (new ones, a colour each), COLORS (a colour
        attribute); and by marks of SEAM, UV islands
    marks, weight, tolerance, unwrap : as of `put.put_lines_into_mesh`
    crossings_as_nodes : crossings that are left become picks, and the lines are made again from one to the next
    detail_size : of the filter "fair", in the object's units
    line_options : as the library's `SurfaceMesh.network` takes them: filter, pinned, threshold, ...; avoid_crossings is
        True unless told otherwise, also for pairs: crossings that are left are forced

    Raises AddonError, or the library's `smooth_polylines.Error`; the mesh is as it was then. A line that cannot be made
    is left out and told in `errors`, unless none can.
    """
    for output in outputs:
        if output not in OUTPUTS:
            raise AddonError(f"There is no output {output!r}; patches become {', '.join(OUTPUTS)}")
    chosen = edge_marks.check_marks(marks)
    session.check_object(mesh_object)
    edit.check_mode(mesh_object)
    edit.check_changeable(mesh_object, "cut")
    opened = surface.open_surface(context, mesh_object)
    joined = read_connections(connections)
    picked = read_picks(mesh_object, joined) if picks is None else list(picks)
    if detail_size is not None:
        line_options["detail_size"] = detail_size * mesh_read.measure_mean_scale(opened.arrays.world_matrix)
    line_options.setdefault("avoid_crossings", True)
    net = make_network(opened, picked, joined, line_options)
    forced = len(net.crossings)
    made_nodes = 0
    if crossings_as_nodes and forced:
        picked, joined = net.crossing_nodes()
        net = make_network(opened, picked, joined, line_options)
        made_nodes, forced = forced, len(net.crossings)
    errors = [error for error in net.errors if error is not None]
    made = [line for line in net.lines if line is not None]
    if not made:
        raise errors[0] if errors else ObjectError("The picks are joined by no line; pick at least two")
    within = {} if tolerance is None else {"tolerance": tolerance}
    patches = ahead.do(lambda: net, lambda whole, _stops: whole.patches(**within))
    with edit.leave_edit_mode(mesh_object, True):
        lines, face_patches = cut_net(mesh_object, opened, patches, made)
        put.set_marks(mesh_object, lines.edges, chosen, weight)
        write_outputs(mesh_object, face_patches, len(patches), outputs)
    lines.sharing = edit.find_sharing_objects(mesh_object)
    if unwrap:
        lines.islands = unwrapping.unwrap_and_measure(context, mesh_object)
    return PutNet(
        lines=lines,
        face_patches=face_patches,
        sides=np.array(patches.sides),
        three_sided=patches.three_sided,
        four_sided=patches.four_sided,
        not_discs=patches.not_discs,
        crossings=forced,
        crossings_as_nodes=made_nodes,
        errors=errors,
        connections=np.array(net.connections),
    )


def make_network(opened: surface.Surface, picks: Sequence[Any], joined: Any, options: dict[str, Any]) -> Any:
    """The library's network of lines between picks."""
    return ahead.do(
        lambda: picks, lambda chosen, stops: opened.library_mesh.network(chosen, joined, **options, **stops)
    )


def read_connections(connections: Any) -> Any:
    """Connections as the library takes them."""
    if not isinstance(connections, str):
        return np.asarray(connections)
    if connections.upper() not in CONNECTIONS:
        raise AddonError(
            f"connections is {connections!r}; it must be one of {', '.join(CONNECTIONS)}, or pairs of picks"
        )
    return connections.lower()


def read_picks(mesh_object: bpy.types.Object, connections: Any) -> list[int]:
    """The faces selected in Edit Mode: in the order of picking where that matters, else any."""
    if isinstance(connections, str) and connections in {"automatic", "all"}:
        return selection.read_selected_faces(mesh_object)
    return selection.read_picks(mesh_object)


def cut_net(
    mesh_object: bpy.types.Object, opened: surface.Surface, patches: Any, made: list[Any]
) -> tuple[put.PutLines, np.ndarray]:
    """Cut the mesh, and find the patch of every face as it is numbered now."""
    cut = patches.cut
    applied = put.apply_to_object(mesh_object, cut, opened.arrays)
    face_patches = np.full(len(mesh_object.data.polygons), -1, dtype=np.int64)
    face_patches[applied.polygon_faces] = patches.polygon_patches
    lines = put.PutLines(
        "CUT",
        np.unique(applied.line_edges),
        made,
        new_vertices=len(cut.vertex_triangles),
        new_faces=applied.new_faces,
        crossings=len(cut.crossings),
    )
    return lines, face_patches


def write_outputs(mesh_object: bpy.types.Object, face_patches: np.ndarray, count: int, outputs: Sequence[str]) -> None:
    """Make the patches visible, on a mesh that is not in Edit Mode; faces of no patch stay as they are."""
    mesh = mesh_object.data
    colours = choose_colours(count)
    rows = np.flatnonzero(face_patches >= 0)
    if "FACE_SETS" in outputs:
        attribute = mesh.attributes.get(FACE_SETS) or mesh.attributes.new(FACE_SETS, "INT", "FACE")
        values = np.empty(len(mesh.polygons), dtype=np.int32)
        attribute.data.foreach_get("value", values)
        values[rows] = face_patches[rows] + 1
        attribute.data.foreach_set("value", values)
    if "MATERIALS" in outputs:
        first = len(mesh.materials)
        for number, colour in enumerate(colours):
            material = bpy.data.materials.new(f"Patch {number + 1}")
            material.diffuse_color = (*colour, 1.0)
            if material.node_tree is None:  # since Blender 5.0 it is always there, and the switch is deprecated
                material.use_nodes = True
            shader = next((node for node in material.node_tree.nodes if node.type == "BSDF_PRINCIPLED"), None)
            if shader is not None:
                shader.inputs["Base Color"].default_value = (*colour, 1.0)
            mesh.materials.append(material)
        values = np.empty(len(mesh.polygons), dtype=np.int32)
        mesh.polygons.foreach_get("material_index", values)
        values[rows] = face_patches[rows] + first
        mesh.polygons.foreach_set("material_index", values)
    if "COLORS" in outputs:
        attribute = mesh.color_attributes.get(COLORS) or mesh.color_attributes.new(COLORS, "BYTE_COLOR", "CORNER")
        sizes = np.empty(len(mesh.polygons), dtype=np.int32)
        mesh.polygons.foreach_get("loop_total", sizes)
        table = np.array([(*colour, 1.0) for colour in colours] + [(1.0, 1.0, 1.0, 1.0)], dtype=np.float32)
        attribute.data.foreach_set("color", table[np.repeat(face_patches, sizes)].ravel())
        mesh.color_attributes.active_color = attribute
    mesh.update()


def choose_colours(count: int) -> list[tuple[float, float, float]]:
    """Colours that are far apart for numbers that follow each other (hues by the golden section), linear."""
    return [colorsys.hsv_to_rgb((0.58 + 0.61803398875 * k) % 1.0, 0.55, 0.75 - 0.15 * (k % 3)) for k in range(count)]
