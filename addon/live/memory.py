# SPDX-License-Identifier: GPL-3.0-or-later
"""What a curve remembers: its mesh, its settings, its picks, and of which mesh vertices its points are made.

It lies on the curve's data-block, so that copies, links, undo, files and appending keep it. Picks are kept as faces or
points of faces, and as places, by which they are found again when the mesh has been rebuilt. Makes no line itself: that
is `session.update_curve`.
"""

import functools
import json
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

import bpy
from bpy.props import EnumProperty, PointerProperty, StringProperty

from .. import line_data, mesh_read, settings
from ..errors import ObjectError

# A pick that is this far from the surface, as a part of the mesh's bounding-box diagonal, is not found again.
LARGEST_DRIFT = 0.1

STATES = (
    ("CURRENT", "Current", "The line is that of its picks and settings"),
    ("FOUND_AGAIN", "Found Again", "The mesh has been rebuilt; the picks were found again by position"),
    ("STALE", "Stale", "The line could not be made again; it is as it was"),
)


@dataclass(frozen=True)
class PlacedLine:
    """Points in the object's space, (N, 3), and the mesh vertices and weights, both (N, 3), that they are made of."""

    local_points: np.ndarray
    vertices: np.ndarray
    weights: np.ndarray


@dataclass(frozen=True)
class Pick:
    """One pick: a face, or a point of a triangle by its vertices; and its place in the object's space."""

    place: list[float]
    face: int | None = None
    triangle: int | None = None  # where it was last: looked at first
    vertices: list[int] | None = None
    weights: list[float] | None = None


@dataclass(frozen=True)
class Recalled:
    """What a line is made from again."""

    picks: list[Any]  # as the library takes them
    pinned: list[bool] | None  # one a pick; None: as the settings say
    is_found_again: bool


def on_change(memory: Any, context: bpy.types.Context) -> None:
    """A setting was changed: the line is made again, and a refusal becomes the curve's state."""
    # The session knows this module; asked only now, so that the two do not import each other while loading.
    from .. import guard, session

    if memory.stored and not memory.is_locked:
        message = guard.run_quietly(lambda: session.update_curve(context, memory.id_data))
        if message is not None:
            memory.state, memory.message = "STALE", message


def on_pinned_change(memory: Any, context: bpy.types.Context) -> None:
    """The choice for all picks replaces one that a script made for each."""
    if memory.stored and not memory.is_locked:
        memory.stored = json.dumps({**json.loads(memory.stored), "pinned": None})
    on_change(memory, context)


def make_annotations() -> dict[str, Any]:
    """The settings of a line, each with the update that makes the line again."""
    annotations = {}
    for name, prop in settings.LineSettings.__annotations__.items():
        update = on_pinned_change if name == "pinned" else on_change
        annotations[name] = prop.function(**{**prop.keywords, "update": update})
    return annotations


class SmoothPolylineMemory(bpy.types.PropertyGroup):
    """What a curve made by Smooth Polylines remembers"""

    __annotations__ = {
        **make_annotations(),
        "surface": PointerProperty(
            name="Surface",
            description="The mesh object that the curve lies on",
            type=bpy.types.Object,
            poll=lambda _memory, candidate: candidate.type == "MESH",
            update=on_change,
        ),
        "state": EnumProperty(name="State", description="Whether the line is up to date", items=STATES),
        "message": StringProperty(name="Message", description="What the state means here"),
        "stored": StringProperty(name="Stored", description="Picks and points, as JSON", options={"HIDDEN"}),
        "is_locked": bpy.props.BoolProperty(
            name="Locked", description="While set, changes of settings make no new line", options={"HIDDEN"}
        ),
    }


def remember(
    curve: Any,
    mesh_object: bpy.types.Object,
    picks: Sequence[Any],
    arrays: mesh_read.MeshArrays,
    placed: PlacedLine,
    wishes: dict[str, Any],
) -> None:
    """Make `curve` remember: picks as the library takes them, and the options as `session.add_polyline` does."""
    memory = get_memory(curve)
    memory.is_locked = True
    try:
        memory.surface = mesh_object
    finally:
        memory.is_locked = False
    change_settings(curve, wishes)
    pinned = wishes.get("pinned", "ends")
    flags = None if isinstance(pinned, str) else [bool(flag) for flag in pinned]
    keep(curve, mesh_object, Recalled(list(picks), flags, False), arrays, placed)


def change_settings(curve: Any, wishes: dict[str, Any]) -> None:
    """Set what `wishes` name, as `session.add_polyline` takes them, without making the line again."""
    memory = get_memory(curve)
    memory.is_locked = True
    try:
        for name in settings.LineSettings.__annotations__:
            wish = wishes.get(name)
            if wish is None or (name == "pinned" and not isinstance(wish, str)):
                continue
            setattr(memory, name, wish.upper() if isinstance(wish, str) else wish)
    finally:
        memory.is_locked = False


def keep(
    curve: Any,
    mesh_object: bpy.types.Object,
    recalled: Recalled,
    arrays: mesh_read.MeshArrays,
    placed: PlacedLine,
) -> None:
    """Store the picks and points of a line that was just made."""
    memory = get_memory(curve)
    memory.stored = json.dumps(
        {
            "picks": [asdict(describe_pick(pick, arrays)) for pick in recalled.picks],
            "pinned": recalled.pinned,
            "topology": measure_current_topology(mesh_object, memory.source),
            "vertices": placed.vertices.tolist(),
            "weights": placed.weights.tolist(),
        }
    )
    memory.state = "FOUND_AGAIN" if recalled.is_found_again else "CURRENT"
    memory.message = (
        "The mesh has been rebuilt since; the picks were found again by position" if recalled.is_found_again else ""
    )


def describe_pick(pick: Any, arrays: mesh_read.MeshArrays) -> Pick:
    """A pick as the library takes it, in a form that outlives the opened mesh."""
    surface_point = getattr(pick, "triangle", None)
    if surface_point is None and not isinstance(pick, (tuple, list)):
        face = int(pick)
        corners = arrays.triangles[arrays.triangle_faces == face]
        return Pick(place=arrays.local_positions[corners].mean(axis=(0, 1)).tolist(), face=face)
    triangle, weights = (pick.triangle, pick.barycentric) if surface_point is not None else pick
    vertices = arrays.triangles[int(triangle)]
    place = np.asarray(weights, dtype=np.float64) @ arrays.local_positions[vertices]
    return Pick(place.tolist(), None, int(triangle), vertices.tolist(), [float(weight) for weight in weights])


def get_memory(data: Any) -> SmoothPolylineMemory:
    """The memory of a data-block that can hold a line."""
    return data.smooth_polyline


def find_memory(line_object: bpy.types.Object | None) -> SmoothPolylineMemory | None:
    """The memory of an object's data, where it holds a line that was made by us."""
    data = getattr(line_object, "data", None)
    return get_memory(data) if data is not None and is_remembering(data) else None


def is_remembering(data: Any) -> bool:
    """Whether a data-block holds a line made by us. Merely looking must not give it a memory, as access would."""
    return (
        isinstance(data, tuple(list_types()))
        and data.is_property_set("smooth_polyline")
        and bool(data.smooth_polyline.stored)
    )


def list_remembering() -> Iterator[Any]:
    """All data-blocks of the file that hold a line made by us."""
    for output, _, _ in line_data.OUTPUTS:
        for data in line_data.list_blocks(output) or ():
            if is_remembering(data):
                yield data


def copy_memory(old: Any, new: Any) -> None:
    """Make the data-block `new`, of another kind, remember what `old` does."""
    source, target = get_memory(old), get_memory(new)
    target.is_locked = True
    try:
        settings.copy_line_settings(source, target)
        for name in ("surface", "state", "message", "stored"):
            setattr(target, name, getattr(source, name))
    finally:
        target.is_locked = False


def find_mesh(curve: Any) -> bpy.types.Object:
    """The mesh object that the curve lies on; ObjectError when the curve knows none."""
    memory = get_memory(curve)
    if not memory.stored:
        raise ObjectError(f"{curve.name} was not made by Smooth Polylines, so there is nothing to make it from again")
    if is_mesh_gone(memory):
        raise ObjectError(f"The mesh of {curve.name} is gone; the curve stays as it is. Choose a mesh as its Surface")
    return memory.surface


def is_mesh_gone(memory: SmoothPolylineMemory) -> bool:
    """Whether the mesh object was deleted: a deleted one that the memory still points to is in no scene."""
    return memory.surface is None or len(memory.surface.users_scene) == 0


def recall(curve: Any, opened: Any) -> Recalled:
    """The picks of `curve` on the opened surface: the same faces, or, on a rebuilt mesh, the nearest points.

    Raises ObjectError when a pick has no surface near it any more.
    """
    stored = json.loads(get_memory(curve).stored)
    picks = [Pick(**pick) for pick in stored["picks"]]
    pinned = stored["pinned"]
    if stored["topology"] == measure_current_topology(get_memory(curve).surface, get_memory(curve).source):
        found = [find_same(pick, opened.arrays) for pick in picks]
        if all(pick is not None for pick in found):
            return Recalled(found, pinned, False)
    arrays = opened.arrays
    matrix = arrays.world_matrix
    places = np.array([pick.place for pick in picks]) @ matrix[:3, :3].T + matrix[:3, 3]
    near = opened.library_mesh.closest_points(places)
    diagonal = float(np.linalg.norm(np.ptp(arrays.world_positions, axis=0)))
    farthest = int(np.argmax(near.distances))
    if near.distances[farthest] > LARGEST_DRIFT * diagonal:
        raise ObjectError(
            f"Pick {farthest} of {curve.name} is {near.distances[farthest]:.4g} away from the mesh, which has been "
            "rebuilt; the curve stays as it was. Draw it again, or choose another Surface"
        )
    return Recalled(near.surface_points, pinned, True)


def find_same(pick: Pick, arrays: mesh_read.MeshArrays) -> Any | None:
    """The pick on a mesh of the same topology; None when its face is hidden now."""
    if pick.face is not None:
        return pick.face if (arrays.triangle_faces == pick.face).any() else None
    wanted = sorted(pick.vertices)
    triangle = pick.triangle
    if triangle >= len(arrays.triangles) or sorted(arrays.triangles[triangle].tolist()) != wanted:
        same = np.flatnonzero((np.sort(arrays.triangles, axis=1) == wanted).all(axis=1))
        if len(same) == 0:
            return None
        triangle = int(same[0])
    weight_of = dict(zip(pick.vertices, pick.weights, strict=True))
    return triangle, [weight_of[vertex] for vertex in arrays.triangles[triangle].tolist()]


def is_on_topology(curve: Any, mesh_object: bpy.types.Object) -> bool:
    """Whether the mesh still has the vertices and faces that the points of `curve` were made on."""
    return read_points(get_memory(curve).stored)[2] == measure_current_topology(mesh_object, get_memory(curve).source)


def measure_current_topology(mesh_object: bpy.types.Object, source: str) -> list[int]:
    """As `mesh_read.measure_topology`, also in Edit Mode, of the mesh before or after its modifiers."""
    with mesh_read.open_current_mesh(mesh_object, source) as mesh:
        return list(mesh_read.measure_topology(mesh))


@functools.lru_cache(maxsize=64)
def read_points(stored: str) -> tuple[np.ndarray, np.ndarray, list[int]]:
    """Vertices and weights of the points, both (N, 3), and the topology that they were made on."""
    values = json.loads(stored)
    return (
        np.array(values["vertices"], dtype=np.int32).reshape(-1, 3),
        np.array(values["weights"], dtype=np.float64).reshape(-1, 3),
        values["topology"],
    )


def list_types() -> list[type]:
    """The types of data-block that can remember: every kind that holds a line, as far as this Blender has it."""
    return [getattr(bpy.types, name) for name in ("Curve", "Mesh", "Curves") if hasattr(bpy.types, name)]


def register() -> None:
    """Give data-blocks their memory."""
    for kind in list_types():
        kind.smooth_polyline = PointerProperty(type=SmoothPolylineMemory)


def unregister() -> None:
    """Take it back; what files hold of it stays in them."""
    for kind in list_types():
        if hasattr(kind, "smooth_polyline"):
            del kind.smooth_polyline
