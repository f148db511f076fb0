"""Opened meshes are kept while nothing changes, and every kind of change is noticed."""

import pytest

import bpy

import bmesh

from blender_scenes import add_grid, enter_edit_mode


@pytest.fixture
def surface(extension):
    from bl_ext.user_default.smooth_polylines import surface

    surface.forget_surfaces()
    return surface


def move_vertex(mesh_object):
    mesh_object.data.vertices[3].co.z += 0.25


def move_vertex_in_bulk(mesh_object):
    values = [0.0] * (3 * len(mesh_object.data.vertices))
    mesh_object.data.attributes["position"].data.foreach_get("vector", values)
    values[5] += 1.0
    mesh_object.data.attributes["position"].data.foreach_set("vector", values)


def hide_face(mesh_object):
    mesh_object.data.polygons[1].hide = True


def scale(mesh_object):
    mesh_object.scale.x = 2.0


def add_face(mesh_object):
    edited = bmesh.new()
    edited.from_mesh(mesh_object.data)
    bmesh.ops.poke(edited, faces=list(edited.faces)[:1])
    edited.to_mesh(mesh_object.data)
    edited.free()


def turn_face(mesh_object):
    edited = bmesh.new()
    edited.from_mesh(mesh_object.data)
    bmesh.ops.reverse_faces(edited, faces=list(edited.faces)[:1])
    edited.to_mesh(mesh_object.data)
    edited.free()


def give_corner_to_the_next_face(mesh_object):
    """The same corners in the same order: two quads become a triangle and a pentagon."""
    mesh = mesh_object.data
    positions = [vertex.co[:] for vertex in mesh.vertices]
    faces = [list(polygon.vertices) for polygon in mesh.polygons]
    order = [corner for face in faces for corner in face]
    sizes = [3, 5] + [4] * (len(faces) - 2)
    ends = [sum(sizes[: k + 1]) for k in range(len(sizes))]
    mesh.clear_geometry()
    mesh.from_pydata(positions, [], [order[end - size : end] for size, end in zip(sizes, ends, strict=True)])
    assert [vertex for polygon in mesh.polygons for vertex in polygon.vertices] == order


@pytest.mark.parametrize(
    "change", [move_vertex, move_vertex_in_bulk, hide_face, scale, add_face, turn_face, give_corner_to_the_next_face]
)
def test_kept_until_something_changes(scene, surface, change):
    grid = add_grid(4, 3)
    first = surface.open_surface(bpy.context, grid)
    assert surface.open_surface(bpy.context, grid) is first
    change(grid)
    second = surface.open_surface(bpy.context, grid)
    assert second is not first
    assert surface.open_surface(bpy.context, grid) is second


def test_an_edit_in_edit_mode_is_noticed(scene, surface):
    grid = enter_edit_mode(add_grid(4, 3))
    first = surface.open_surface(bpy.context, grid)
    assert surface.open_surface(bpy.context, grid) is first
    edited = bmesh.from_edit_mesh(grid.data)
    edited.verts.ensure_lookup_table()
    edited.verts[0].co.z = 1.0
    bmesh.update_edit_mesh(grid.data)
    second = surface.open_surface(bpy.context, grid)
    assert second is not first
    assert second.arrays.local_positions[0, 2] == 1.0


def test_few_are_kept(scene, surface):
    grids = [add_grid(2, 2, name=f"Grid {k}") for k in range(surface.MOST_SURFACES + 2)]
    opened = [surface.open_surface(bpy.context, grid) for grid in grids]
    assert len(surface._surfaces) == surface.MOST_SURFACES
    assert surface.open_surface(bpy.context, grids[-1]) is opened[-1]
    assert surface.open_surface(bpy.context, grids[0]) is not opened[0]


def test_moving_alone_keeps_the_topology(scene, surface):
    from bl_ext.user_default.smooth_polylines import mesh_read

    grid = add_grid(4, 3)
    before = mesh_read.measure_topology(grid.data)
    move_vertex(grid)
    assert mesh_read.measure_topology(grid.data) == before
    turn_face(grid)
    assert mesh_read.measure_topology(grid.data) != before
