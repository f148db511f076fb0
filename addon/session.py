# SPDX-License-Identifier: GPL-3.0-or-later
"""The whole way from picked faces to a curve in the scene, as one plain function for scripts and operators.

Reads, then computes, then writes: whatever is refused is refused before anything has been created.
Holds no geometry (the library's) and no messages to the artist (the operators').
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

import bpy

from . import (
    ahead,
    curve_write,
    line_data,
    line_points,
    mesh_read,
    native,
    selection,
    settings,
    surface,
    surface_offset,
)
from .errors import ObjectError
from .live import memory, shape


@dataclass(frozen=True)
class ComputedPolyline:
    """A finished line that is not yet in the scene."""

    line: Any  # the library's polyline, in world space, with its report
    picks: list[Any]
    arrays: mesh_read.MeshArrays


@dataclass(frozen=True)
class AddedPolyline:
    """What `add_polyline` made."""

    curve_object: bpy.types.Object
    line: Any  # the library's polyline, in world space, with its report
    picks: list[Any]


def compute_polyline(
    context: bpy.types.Context | None,
    mesh_object: bpy.types.Object,
    picks: Sequence[Any] | None = None,
    *,
    source: str = "BASE",
    with_normals: bool = False,
    detail_size: float | None = None,
    **line_options: Any,
) -> ComputedPolyline:
    """Make a smooth line on `mesh_object` as it is now, and change nothing in the file.

    picks : polygon ids in order; None: the faces picked in Edit Mode
    source : BASE: on the mesh as it is edited; EVALUATED: after its modifiers, where faces stand for their centres
    with_normals : read the mesh's normals too, for an offset
    detail_size : of the filter "fair", a length in the object's units
    line_options : what the library's `SurfaceMesh.polyline` takes: closed, filter, pinned, solver, threshold, ...

    Raises AddonError, or the library's `smooth_polylines.Error`.
    """
    check_object(mesh_object)
    native.load_library()
    ordered_picks = selection.read_picks(mesh_object) if picks is None else list(picks)
    opened = surface.open_surface(context, mesh_object, source=source, with_normals=with_normals)
    if source == "EVALUATED":
        ordered_picks = find_evaluated_picks(mesh_object, ordered_picks, opened)
    arrays = opened.arrays
    if detail_size is not None:
        line_options["detail_size"] = detail_size * mesh_read.measure_mean_scale(arrays.world_matrix)
    line = ahead.do(
        lambda: ordered_picks, lambda chosen, stops: opened.library_mesh.polyline(chosen, **line_options, **stops)
    )
    return ComputedPolyline(line, ordered_picks, arrays)


def find_evaluated_picks(mesh_object: bpy.types.Object, picks: Sequence[Any], opened: surface.Surface) -> list[Any]:
    """Picks on the surface after modifiers: a face of the mesh becomes the point nearest to its centre."""
    faces = [k for k, pick in enumerate(picks) if isinstance(pick, (int, np.integer))]
    found = list(picks)
    if faces:
        base = mesh_read.read_mesh(mesh_object)
        for k in faces:
            corners = base.triangles[base.triangle_faces == picks[k]]
            if len(corners) == 0:
                raise ObjectError(
                    f"Face {picks[k]} of {mesh_object.name} is hidden or not there; pick visible faces of the mesh"
                )
            centre = base.world_positions[corners].mean(axis=(0, 1))
            found[k] = opened.library_mesh.closest_points(centre[None]).surface_points[0]
    return found


def add_polyline(
    context: bpy.types.Context, mesh_object: bpy.types.Object, picks: Sequence[Any] | None = None, **wishes: Any
) -> AddedPolyline:
    """Make a smooth line on `mesh_object` and add it to the scene as an object that remembers what made it.

    picks : polygon ids in order, or points of the surface, as the library takes them; None: the picked faces
    wishes : as for `add_polylines`

    Raises AddonError, or the library's `smooth_polylines.Error`; nothing has been created then.
    """
    return add_polylines(context, [(mesh_object, picks)], **wishes)[0]


def add_polylines(
    context: bpy.types.Context,
    requests: Sequence[tuple[bpy.types.Object, Sequence[Any] | None]],
    *,
    source: str = "BASE",
    bevel: float | None = None,
    offset: float = 0.0,
    resample: float = 0.0,
    output: str = "CURVE",
    name: str = settings.DEFAULT_NAME,
    collection: str = "",
    material: str = "",
    **line_options: Any,
) -> list[AddedPolyline]:
    """Make smooth lines and add them to the scene, all of them or none.

    requests : for each line the mesh object, and its picks as for `add_polyline`
    source : BASE: on the mesh as it is edited; EVALUATED: after its modifiers
    bevel : radius of the tube in the object's units; None: chosen from the size of the mesh
    offset : distance from the surface along its normal, in the object's units; 0: on the surface
    resample : even spacing of the points, in the object's units; 0: the points of the line
    output : the kind of object: CURVE, MESH (edges), or CURVES (as hair; Blender 4.5 and newer)
    name : of the new object
    collection : name of the collection that it goes into; "": that of the mesh object
    material : name of its material; "": none
    line_options : as for `compute_polyline`: closed, filter, pinned, threshold, detail_size, ...

    Raises AddonError, or the library's `smooth_polylines.Error`; nothing has been created then.
    """
    check_output(output)
    chosen_collection = find_named(bpy.data.collections, collection, "collection")
    chosen_material = find_named(bpy.data.materials, material, "material")
    computed = [
        compute_named(context, *request, len(requests) > 1, source=source, with_normals=offset != 0.0, **line_options)
        for request in requests
    ]
    wishes = {**line_options, "source": source, "bevel": bevel, "offset": offset, "resample": resample}
    wishes |= {"output": output, "name": name, "collection": chosen_collection, "material": chosen_material}
    added: list[AddedPolyline] = []
    try:
        for (mesh_object, _), one in zip(requests, computed, strict=True):
            added.append(add_computed_polyline(context, mesh_object, one, **wishes))
    except BaseException:
        for one in added:
            curve_write.remove_line(one.curve_object)
        raise
    return added


def add_computed_polyline(
    context: bpy.types.Context,
    mesh_object: bpy.types.Object,
    computed: ComputedPolyline,
    *,
    bevel: float | None = None,
    offset: float = 0.0,
    resample: float = 0.0,
    output: str = "CURVE",
    name: str = settings.DEFAULT_NAME,
    collection: bpy.types.Collection | None = None,
    material: bpy.types.Material | None = None,
    **wishes: Any,
) -> AddedPolyline:
    """Add a line that was made by `compute_polyline` to the scene, as `add_polyline` does; all of it or nothing.

    wishes : what the line was computed with, for the curve to remember; a line without picks, as one made along a drawn
        stroke, remembers nothing
    """
    placed = place_line(computed, offset=offset, resample=resample)
    line_object = curve_write.write_curve(
        context,
        mesh_object,
        placed.local_points,
        closed=computed.line.closed,
        bevel=curve_write.choose_bevel(computed.arrays.local_positions) if bevel is None else bevel,
        name=name or settings.DEFAULT_NAME,
        output=output,
        collection=collection,
        material=material,
    )
    if computed.picks:
        wishes = {**wishes, "bevel": bevel, "offset": offset, "resample": resample}
        try:
            memory.remember(line_object.data, mesh_object, computed.picks, computed.arrays, placed, wishes)
            shape.place_on_shape(line_object.data, mesh_object, context.evaluated_depsgraph_get())
        except BaseException:
            curve_write.remove_line(line_object)
            raise
    return AddedPolyline(line_object, computed.line, computed.picks)


def compute_named(
    context: bpy.types.Context, mesh_object: bpy.types.Object, picks: Any, is_one_of_many: bool, **options: Any
) -> ComputedPolyline:
    """`compute_polyline`, whose refusals name the object where it is one of many."""
    try:
        return compute_polyline(context, mesh_object, picks, **options)
    except Exception as error:
        if is_one_of_many and native.is_refusal(error):
            raise ObjectError(f"{mesh_object.name}: {error}") from error
        raise


def check_output(output: str) -> None:
    """ObjectError when this Blender cannot make such an object."""
    kinds = [kind for kind, _, _ in line_data.OUTPUTS]
    if output not in kinds:
        raise ObjectError(f"There is no output {output!r}; choose one of {', '.join(kinds)}")
    if output == "CURVES" and not line_data.has_hair_curves():
        raise ObjectError(
            f"Blender {bpy.app.version_string} cannot make hair Curves of straight pieces, which came with 4.5; choose "
            "the output Curve"
        )


def find_named(blocks: Any, name: str, noun: str) -> Any:
    """The data-block of a name, None for ""; ObjectError where there is none that can be used."""
    if not name:
        return None
    found = blocks.get(name)
    if found is None:
        raise ObjectError(f"There is no {noun} {name!r} in this file; choose another, or none")
    if noun == "collection" and found.library is not None:
        raise ObjectError(f"The collection {name} is linked and takes no new objects; choose another, or none")
    return found


def replace_picks(context: bpy.types.Context, curve: Any, picks: Sequence[Any], **wishes: Any) -> None:
    """Give a curve that remembers other picks, and the settings in `wishes` (as `add_polyline` takes them)."""
    memory.change_settings(curve, wishes)
    update_curve(context, curve, picks)


def update_curve(context: bpy.types.Context | None, curve: Any, picks: Sequence[Any] | None = None) -> None:
    """Make the line of a curve that remembers again, by its settings, on its mesh as it is now; the same data-block.

    picks : others than it remembers, as the library takes them

    Picks whose faces are no more are found again by position, and the curve's state says so. `context` is None in a
    handler, where everything has just been evaluated. Raises AddonError, or the
    library's `smooth_polylines.Error`; the curve is as it was then.
    """
    check_local(curve)
    settings_of_curve = memory.get_memory(curve)
    computed, recalled = compute_remembered(context, curve, picks)
    mesh_object = memory.find_mesh(curve)
    placed = place_line(computed, offset=settings_of_curve.offset, resample=settings_of_curve.resample)
    line_data.write_points(curve, placed.local_points, closed=computed.line.closed)
    line_data.set_bevel(curve, settings_of_curve.bevel or curve_write.choose_bevel(computed.arrays.local_positions))
    memory.keep(curve, mesh_object, recalled, computed.arrays, placed)
    if context is not None:
        shape.place_on_shape(curve, mesh_object, context.evaluated_depsgraph_get())


def compute_remembered(
    context: bpy.types.Context | None, curve: Any, picks: Sequence[Any] | None = None
) -> tuple[ComputedPolyline, memory.Recalled]:
    """Make the line of a curve that remembers again, and what it was made from; changes nothing. As `update_curve`."""
    settings_of_curve = memory.get_memory(curve)
    mesh_object = memory.find_mesh(curve)
    check_object(mesh_object)
    source, with_normals = settings_of_curve.source, settings_of_curve.offset != 0.0
    opened = surface.open_surface(context, mesh_object, source=source, with_normals=with_normals)
    recalled = memory.recall(curve, opened) if picks is None else memory.Recalled(list(picks), None, False)
    options = settings.choose_line_options(settings_of_curve)
    if recalled.pinned is not None:
        options["pinned"] = recalled.pinned
    computed = compute_polyline(
        context, mesh_object, recalled.picks, source=source, with_normals=with_normals, **options
    )
    return computed, recalled


def place_line(computed: ComputedPolyline, *, offset: float, resample: float) -> memory.PlacedLine:
    """The points of a line in the object's space, and what they are made of."""
    arrays = computed.arrays
    spacing = resample * mesh_read.measure_mean_scale(arrays.world_matrix)
    vertices, weights = line_points.describe_points(computed.line, arrays.triangles, spacing)
    # The same weights on the unmoved vertices: no inverse of the world matrix, no rounding by one.
    local_points = line_points.place_points(vertices, weights, arrays.local_positions)
    if offset != 0.0:
        local_points = surface_offset.lift_points(
            local_points, vertices, weights, arrays.local_normals, arrays.world_matrix, offset
        )
    return memory.PlacedLine(local_points, vertices, weights)


def check_object(mesh_object: bpy.types.Object) -> None:
    """ObjectError when the object can carry no line of ours."""
    if mesh_object is None or mesh_object.type != "MESH":
        found = "nothing" if mesh_object is None else f"{mesh_object.name}, a {mesh_object.type.lower()} object"
        raise ObjectError(f"A smooth polyline lies on a mesh object, but the object is {found}; make a mesh active")
    for data in (mesh_object, mesh_object.data):
        check_local(data)


def check_local(data: Any) -> None:
    """ObjectError when a data-block is another file's."""
    if data.library is not None:
        raise ObjectError(
            f"{data.name} is linked from {data.library.filepath} and cannot be changed here; make it local first "
            "(Object > Relations > Make Local > Selected Objects and Data)"
        )
