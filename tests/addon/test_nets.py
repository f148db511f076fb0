"""Nets cut into meshes: the patches, against a flood fill of the test's own; what they become; crossings; refusals."""

import numpy as np
import pytest

import bpy

import bmesh

from blender_scenes import add_grid, enter_edit_mode, pick_faces, select_faces_without_order
from cut_meshes import add_ball, flood, measure


@pytest.fixture
def nets(extension):
    from bl_ext.user_default.smooth_polylines.seams import nets

    return nets


def spread_picks(mesh, count, seed=0):
    """Faces far from each other."""
    centres = np.array([p.center for p in mesh.polygons])
    picks = [int(np.random.default_rng(seed).integers(len(centres)))]
    distances = np.full(len(centres), np.inf)
    while len(picks) < count:
        distances = np.minimum(distances, np.linalg.norm(centres - centres[picks[-1]], axis=1))
        picks.append(int(distances.argmax()))
    return picks


def check_patches(mesh, done):
    """The patches are what a flood fill finds that stops at the lines' edges."""
    parts = flood(mesh, set(done.lines.edges.tolist()))
    pairs = {*zip(parts.tolist(), done.face_patches.tolist(), strict=True)}
    assert len(pairs) == len(set(parts)) == len(done.sides)
    assert set(done.face_patches) == set(range(len(done.sides)))


@pytest.mark.parametrize("kind", ["quads", "triangles", "n-gons"])
def test_an_automatic_net_parts_a_ball_into_triangles(scene, nets, kind):
    ball = add_ball(kind)
    before = measure(ball.data)
    picks = spread_picks(ball.data, 12)
    done = nets.put_net_into_mesh(bpy.context, ball, picks, filter="geodesic", outputs=nets.OUTPUTS, marks=("SEAM",))
    mesh = ball.data
    assert mesh.validate() is False
    check_patches(mesh, done)
    assert done.crossings == 0
    assert done.errors == []
    # Euler: a net of V nodes and E lines that joins all of them parts a ball into E - V + 2 patches.
    assert len(done.sides) == len(done.connections) - len(picks) + 2
    assert done.three_sided >= len(done.sides) // 2
    assert done.three_sided == np.count_nonzero(done.sides == 3)
    assert done.four_sided == np.count_nonzero(done.sides == 4)
    after = measure(mesh)
    assert (after.euler, after.border) == (before.euler, 0)
    # What the patches have become.
    sets = np.array([a.value for a in mesh.attributes[".sculpt_face_set"].data])
    np.testing.assert_array_equal(sets, done.face_patches + 1)
    names = [mesh.materials[p.material_index].name for p in mesh.polygons]
    assert names == [f"Patch {patch + 1}" for patch in done.face_patches]
    colours = {}
    layer = mesh.color_attributes["Patches"]
    for polygon, patch in zip(mesh.polygons, done.face_patches, strict=True):
        for loop in polygon.loop_indices:
            colours.setdefault(patch, set()).add(tuple(layer.data[loop].color))
    assert all(len(found) == 1 for found in colours.values())
    assert len({next(iter(found)) for found in colours.values()}) == len(done.sides)
    assert {e.index for e in mesh.edges if e.use_seam} == set(done.lines.edges.tolist())


def test_crossings_that_are_forced_can_become_nodes(scene, nets):
    for as_nodes in (False, True):
        grid = add_grid(8, 8, name=f"Grid {as_nodes}")
        # All pairs of five: the complete graph of five cannot be drawn in the plane.
        done = nets.put_net_into_mesh(
            bpy.context,
            grid,
            [9, 14, 54, 49, 44],
            connections="ALL",
            filter="geodesic",
            crossings_as_nodes=as_nodes,
        )
        check_patches(grid.data, done)
        assert (done.crossings, done.crossings_as_nodes) == ((0, 1) if as_nodes else (1, 0))
        assert len(done.connections) == (12 if as_nodes else 10)
        # Four lines meet in each pick, and in the crossing.
        ends = np.bincount([v for e in done.lines.edges for v in grid.data.edges[e].vertices])
        assert np.count_nonzero(ends == 4) == 6


def test_crossings_that_are_not_forced_are_gone_round_unless_told_otherwise(scene, nets):
    for avoids, crossings in ((True, 0), (False, 1)):
        grid = add_grid(8, 8, name=f"Square {avoids}")
        # Both diagonals of a square.
        done = nets.put_net_into_mesh(
            bpy.context,
            grid,
            [9, 14, 54, 49],
            connections=[[0, 2], [1, 3]],
            filter="geodesic",
            avoid_crossings=avoids,
        )
        check_patches(grid.data, done)
        assert (done.crossings, len(done.connections)) == (crossings, 2)
        ends = np.bincount([v for e in done.lines.edges for v in grid.data.edges[e].vertices])
        assert np.count_nonzero(ends == 4) == crossings


@pytest.mark.parametrize(("connections", "lines"), [("CHAIN", 3), ("LOOP", 4), ("ALL", 6), ("AUTOMATIC", 5)])
def test_the_kinds_of_connections(scene, nets, connections, lines):
    ball = add_ball("quads")
    done = nets.put_net_into_mesh(
        bpy.context, ball, spread_picks(ball.data, 4), connections=connections, filter="geodesic"
    )
    check_patches(ball.data, done)
    if connections == "AUTOMATIC":
        assert len(done.connections) in {lines, 6}
    else:
        assert len(done.connections) == lines


def test_a_patch_that_is_no_disc_is_told(scene, nets):
    from bl_ext.user_default.smooth_polylines.seams import report

    bpy.ops.mesh.primitive_torus_add(major_segments=24, minor_segments=12)
    torus = bpy.context.object
    done = nets.put_net_into_mesh(bpy.context, torus, spread_picks(torus.data, 3), connections="CHAIN")
    assert (len(done.sides), done.not_discs) == (1, 1)
    told, _ = report.describe_net(done)
    assert "1 patch: 0 of three sides, 0 of four; 1 of them is no disc" in told
    ball = add_ball("quads")
    done = nets.put_net_into_mesh(bpy.context, ball, spread_picks(ball.data, 8))
    assert done.not_discs == 0
    assert "disc" not in report.describe_net(done)[0]


def test_operator_with_undo_and_what_it_tells(scene, nets):
    ball = add_ball("quads")
    picks = spread_picks(ball.data, 6)
    count = len(ball.data.vertices)
    enter_edit_mode(ball)
    select_faces_without_order(ball, picks)
    bpy.ops.ed.undo_push(message="Select")
    assert bpy.ops.mesh.smooth_polyline_net("EXEC_DEFAULT", True, filter="GEODESIC", marks={"SEAM"}) == {"FINISHED"}
    assert bpy.context.mode == "EDIT_MESH"
    ball = bpy.context.edit_object
    edited = bmesh.from_edit_mesh(ball.data)
    assert len(edited.verts) > count
    sets = {face[edited.faces.layers.int[".sculpt_face_set"]] for face in edited.faces}
    assert len(sets) >= 6
    bpy.ops.ed.undo()
    edited = bmesh.from_edit_mesh(bpy.context.edit_object.data)
    assert len(edited.verts) == count
    assert sum(face.select for face in edited.faces) == 6
    bpy.ops.ed.redo()
    assert len(bmesh.from_edit_mesh(bpy.context.edit_object.data).verts) > count


def test_hidden_faces_are_in_no_patch(scene, nets):
    grid = add_grid(8, 8)
    for face in (27, 28):
        grid.data.polygons[face].hide = True
    done = nets.put_net_into_mesh(
        bpy.context, grid, [0, 7, 63, 56], connections="LOOP", filter="geodesic", outputs=("FACE_SETS", "MATERIALS")
    )
    hidden = np.array([p.hide for p in grid.data.polygons])
    np.testing.assert_array_equal(done.face_patches < 0, hidden)
    assert hidden.sum() == 2
    assert {grid.data.polygons[f].material_index for f in np.flatnonzero(hidden)} == {0}


def test_refusals(scene, nets):
    grid = add_grid(8, 8)
    enter_edit_mode(grid)
    with pytest.raises(RuntimeError, match="0 faces are selected on Grid; a net joins 2 to 500"):
        bpy.ops.mesh.smooth_polyline_net()
    select_faces_without_order(grid, [0, 9, 18])
    with pytest.raises(RuntimeError, match="have no order"):
        bpy.ops.mesh.smooth_polyline_net(connections="LOOP")
    with pytest.raises(nets.AddonError, match="no output 'SETS'"):
        nets.put_net_into_mesh(bpy.context, grid, [0, 5], outputs=("SETS",))
    with pytest.raises(nets.AddonError, match="connections is 'STAR'"):
        nets.put_net_into_mesh(bpy.context, grid, [0, 5], connections="STAR")
    assert len(bmesh.from_edit_mesh(grid.data).verts) == 81


def test_lines_that_cannot_be_made_are_told_and_the_rest_is_cut(scene, nets):
    grid = add_grid(8, 8)
    for face in range(32, 40):  # a wall across
        grid.data.polygons[face].hide = True
    done = nets.put_net_into_mesh(bpy.context, grid, [0, 30, 63], connections="CHAIN", filter="geodesic")
    assert len(done.errors) == 1
    assert "not connected" in str(done.errors[0])
    assert len(done.lines.edges) > 4


def test_picks_in_order_of_clicking(scene, nets):
    grid = add_grid(8, 8)
    enter_edit_mode(grid)
    pick_faces(grid, [0, 63, 7])
    assert bpy.ops.mesh.smooth_polyline_net(connections="CHAIN", filter="GEODESIC") == {"FINISHED"}
