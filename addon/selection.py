# SPDX-License-Identifier: GPL-3.0-or-later
"""The picks of an artist: the selected faces of a mesh in Edit Mode, in the order they were picked.

A selection without an order is refused, never guessed at. Reads only; knows no lines.
"""

import bpy

import bmesh

from . import active
from .errors import SelectionError

# Fewer give no line that could be seen.
LEAST_PICKS = 2
# More selected faces are an area and no picks.
MOST_UNORDERED_PICKS = 500

HOW_TO_PICK = (
    "Deselect all (Alt A), then in face select mode (3) click the first face and Shift-click the others, "
    "one after another"
)


def read_picks(mesh_object: bpy.types.Object) -> list[int]:
    """Polygon ids in the order of picking; SelectionError when the selection has no complete order."""
    mesh = mesh_object.data
    if not mesh.is_editmode:
        raise SelectionError(
            f"{mesh_object.name} is not in Edit Mode, so it has no picked faces; enter Edit Mode and pick some"
        )
    edited = bmesh.from_edit_mesh(mesh)
    edited.faces.index_update()  # stale after a script has added or removed faces
    # The history as a list: in some builds of Blender its iterator does not work in a comprehension.
    history = list(edited.select_history)
    picks = [item.index for item in history if isinstance(item, bmesh.types.BMFace) and item.select]
    selected_count = mesh.total_face_sel
    if selected_count == 0:
        raise SelectionError(f"No faces are selected on {mesh_object.name}. {HOW_TO_PICK}")
    if len(picks) < selected_count:
        raise SelectionError(
            f"{selected_count - len(picks)} of the {selected_count} selected faces have no order, as after box, "
            f"circle, linked or select all. {HOW_TO_PICK}"
        )
    if len(picks) < LEAST_PICKS:
        raise SelectionError(f"Only one face is selected; a line needs at least two. {HOW_TO_PICK}")
    return picks


def read_selected_faces(mesh_object: bpy.types.Object) -> list[int]:
    """Polygon ids of the selected faces, whatever way they were selected; SelectionError when they are no picks."""
    mesh = mesh_object.data
    count = mesh.total_face_sel if mesh.is_editmode else 0
    if not LEAST_PICKS <= count <= MOST_UNORDERED_PICKS:
        raise SelectionError(
            f"{count} faces are selected on {mesh_object.name}; a net joins {LEAST_PICKS} to {MOST_UNORDERED_PICKS} "
            "picks: in Edit Mode, face select mode (3), select one face for each"
        )
    edited = bmesh.from_edit_mesh(mesh)
    edited.faces.index_update()
    return [face.index for face in edited.faces if face.select]


def list_picked_objects(context: bpy.types.Context) -> list[bpy.types.Object]:
    """The meshes in Edit Mode that have selected faces, the active one first."""
    picked = [mesh_object for mesh_object in active.list_edited_meshes(context) if mesh_object.data.total_face_sel > 0]
    return sorted(picked, key=lambda mesh_object: mesh_object != active.get_edited(context))
