# SPDX-License-Identifier: GPL-3.0-or-later
"""A mesh object's mesh as a BMesh that can be changed, in Edit Mode or out of it, and what a BMesh alone would lose.

Entering or leaving Edit Mode is never needed for it, which on a scan takes as long as all the rest. Knows no lines.
"""

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np

import bpy

import bmesh

from ..errors import ObjectError

# Carries the custom normals through a BMesh as plain vectors, which are interpolated like all others.
CARRIED_NORMALS = "smooth_polyline_normals"


@contextmanager
def open_bmesh(mesh_object: bpy.types.Object) -> Iterator[bmesh.types.BMesh]:
    """The mesh as a BMesh; what was done to it is in the mesh afterwards, unless an error came in between."""
    mesh = mesh_object.data
    if mesh.is_editmode:
        edited = bmesh.from_edit_mesh(mesh)
        edited.verts.index_update()
        edited.faces.index_update()
        yield edited
        # Faces know their normals; nothing else is left to be worked out.
        bmesh.update_edit_mesh(mesh)
        return
    names = get_active_names(mesh)
    has_normals = carry_normals(mesh)
    edited = bmesh.new(use_operators=False)
    try:
        edited.from_mesh(mesh, face_normals=False, vertex_normals=False)
        yield edited
        edited.to_mesh(mesh)
    finally:
        edited.free()
        if has_normals:
            put_normals_back(mesh)
    set_active_names(mesh, names)
    mesh.update()


def carry_normals(mesh: bpy.types.Mesh) -> bool:
    """Copy custom normals that Blender keeps relative to the faces into an attribute; whether there are any."""
    if not mesh.has_custom_normals:
        return False
    stored = mesh.attributes.get("custom_normal")
    if stored is not None and stored.data_type == "FLOAT_VECTOR":
        return False  # plain vectors already
    values = np.empty(len(mesh.loops) * 3, dtype=np.float32)
    mesh.corner_normals.foreach_get("vector", values)
    mesh.attributes.new(CARRIED_NORMALS, "FLOAT_VECTOR", "CORNER").data.foreach_set("vector", values)
    return True


def put_normals_back(mesh: bpy.types.Mesh) -> None:
    """Make the carried vectors the custom normals again, and remove their attribute."""
    attribute = mesh.attributes[CARRIED_NORMALS]
    values = np.empty(len(mesh.loops) * 3, dtype=np.float32)
    attribute.data.foreach_get("vector", values)
    mesh.attributes.remove(attribute)
    mesh.normals_split_custom_set(values.reshape(-1, 3))


def get_active_names(mesh: bpy.types.Mesh) -> tuple[str | None, str | None]:
    """Which colours are edited, and which are rendered."""
    return mesh.attributes.active_color_name, mesh.attributes.default_color_name


def set_active_names(mesh: bpy.types.Mesh, names: tuple[str | None, str | None]) -> None:
    """Some versions forget these when a BMesh is written."""
    active, default = names
    if active and mesh.attributes.active_color_name != active:
        mesh.attributes.active_color_name = active
    if default and mesh.attributes.default_color_name != default:
        mesh.attributes.default_color_name = default


def check_mode(mesh_object: bpy.types.Object) -> None:
    """ObjectError in modes, such as Sculpt Mode, that hold the mesh in a form of their own."""
    if mesh_object.mode not in {"OBJECT", "EDIT"}:
        mode = mesh_object.mode.replace("_", " ").title()
        raise ObjectError(f"{mesh_object.name} is in {mode} Mode; go to Object Mode or Edit Mode first")


def check_changeable(mesh_object: bpy.types.Object, what: str) -> None:
    """ObjectError when the base mesh must not be changed: levels of a Multiresolution modifier hang on it."""
    if any(modifier.type == "MULTIRES" for modifier in mesh_object.modifiers):
        raise ObjectError(
            f"{mesh_object.name} has a Multiresolution modifier, whose details would be lost if the mesh below it were "
            f"{what}; apply the modifier first, or use the method Snap, which changes no mesh"
        )


def find_sharing_objects(mesh_object: bpy.types.Object) -> list[str]:
    """Names of the other objects that have the same mesh, and change with it."""
    return [o.name for o in bpy.data.objects if o.data == mesh_object.data and o != mesh_object]


@contextmanager
def leave_edit_mode(mesh_object: bpy.types.Object, is_needed: bool) -> Iterator[None]:
    """Out of Edit Mode for a while, where something cannot be done in it."""
    if not (is_needed and mesh_object.data.is_editmode):
        yield
        return
    # There is no other way in and out than the operator.
    bpy.ops.object.mode_set(mode="OBJECT")
    try:
        yield
    finally:
        bpy.ops.object.mode_set(mode="EDIT")
