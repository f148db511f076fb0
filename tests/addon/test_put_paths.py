"""Snap and Slide by the plain function: the path of edges, what moves, what stays to the byte."""

import numpy as np
import pytest

import bpy

import bmesh

from attributed_mesh import add_attributed_grid, read_everything
from blender_scenes import add_grid, add_mesh_object, enter_edit_mode, pick_faces
from cut_meshes import add_ball, circle_on_ball, flood, measure, seam_edges


def walk(mesh, edges):
    """Degree of every vertex of some edges."""
    return np.bincount([v for e in edges for v in mesh.edges[e].vertices], minlength=len(mesh.vertices))


@pytest.mark.parametrize("kind", ["quads", "triangles", "n-gons"])
@pytest.mark.parametrize("is_editing", [False, True])
def test_snap_marks_a_ring_of_edges_near_the_line_and_changes_nothing_else(scene, seams, kind, is_editing):
    ball = add_ball(kind)
    before = read_everything(ball)
    if is_editing:
        enter_edit_mode(ball)
    done = seams.put.put_lines_into_mesh(bpy.context, ball, [(circle_on_ball(0.2), True)], method="SNAP")
    if is_editing:
        bpy.ops.object.mode_set(mode="OBJECT")
    after = read_everything(ball)
    for name, (_, values) in before.items():
        if "select" not in name and name != "edge use_seam":
            np.testing.assert_array_equal(after[name][1], values, err_msg=name)
    edges = seam_edges(ball.data)
    assert edges == set(done.edges.tolist())
    degrees = walk(ball.data, edges)
    assert set(degrees) == {0, 2}  # one ring, or several: but not more than one
    assert len(set(flood(ball.data, edges))) == 2
    places = np.array([v.co for v in ball.data.vertices])[degrees > 0]
    gaps = np.linalg.norm(places[:, None] - done.lines[0].points[None], axis=2).min(axis=1)
    longest = max((ball.data.vertices[a].co - ball.data.vertices[b].co).length for a, b in ball.data.edge_keys)
    assert gaps.max() < longest
    assert done.distance < longest


@pytest.mark.parametrize("is_editing", [False, True])
def test_slide_puts_the_ring_on_the_line(scene, seams, is_editing):
    ball = add_ball("triangles")
    before = measure(ball.data)
    places = np.array([v.co for v in ball.data.vertices])
    if is_editing:
        enter_edit_mode(ball)
    line = (circle_on_ball(0.2), True)
    done = seams.put.put_lines_into_mesh(bpy.context, ball, [line], method="SLIDE")
    if is_editing:
        bpy.ops.object.mode_set(mode="OBJECT")
    mesh = ball.data
    now = np.array([v.co for v in mesh.vertices])
    path = np.flatnonzero(walk(mesh, done.edges))
    assert set(done.moved) | set(done.not_moved) <= set(path.tolist())
    assert len(done.moved) > 0.8 * len(path)
    others = np.setdiff1d(np.arange(len(now)), done.moved)
    np.testing.assert_array_equal(now[others], places[others])
    points = done.lines[0].points
    starts, ends = points, np.roll(points, -1, axis=0)
    for number in done.moved:
        t = np.clip(((now[number] - starts) * (ends - starts)).sum(1) / ((ends - starts) ** 2).sum(1), 0, 1)
        assert np.linalg.norm(starts + t[:, None] * (ends - starts) - now[number], axis=1).min() < 1e-6
    assert len(set(flood(mesh, set(done.edges.tolist())))) == 2
    after = measure(mesh)
    assert after.euler == before.euler
    assert after.volume == pytest.approx(before.volume, rel=5e-3)
    for polygon in mesh.polygons:
        assert polygon.normal.dot(polygon.center) > 0


def test_slide_keeps_everything_but_the_row(scene, seams):
    grid = add_attributed_grid()
    before = read_everything(grid)
    line = np.array([(0.0, 1.7, 0.1), (5.0, 2.4, 0.1)])
    done = seams.put.put_lines_into_mesh(bpy.context, grid, [line], method="SLIDE", max_distance=1.0)
    after = read_everything(grid)
    others = np.setdiff1d(np.arange(len(grid.data.vertices)), done.moved)
    assert len(done.moved) >= 4
    for name, (domain, values) in before.items():
        if domain == "POINT":
            np.testing.assert_array_equal(after[name][1][others], values[others], err_msg=name)
        elif domain == "FACE":
            np.testing.assert_array_equal(after[name][1], values, err_msg=name)


def test_seams_of_a_snap_part_the_islands_of_the_unwrapped_map_exactly(scene, seams):
    for method in ("SNAP", "CUT"):
        grid = add_grid(10, 8, name=method)
        line = np.array([(0.0, 2.3, 0), (5.0, 4.4, 0), (10.0, 3.6, 0)])
        done = seams.put.put_lines_into_mesh(bpy.context, grid, [line], method=method, unwrap=True)
        parts = flood(grid.data, set(done.edges.tolist()))
        assert len(set(parts)) == 2
        islands = done.islands.face_islands
        # The same partition of the faces, whatever the numbers.
        assert len({*zip(parts.tolist(), islands.tolist(), strict=True)}) == 2
        assert max(i.worst_angle_stretch for i in done.islands.islands) < 1.02


def test_operator_snaps_picks_in_edit_mode(scene, seams):
    grid = add_grid(6, 6)
    enter_edit_mode(grid)
    pick_faces(grid, [0, 14, 35])
    assert bpy.ops.mesh.smooth_polyline_seam(method="SNAP", marks={"SEAM", "SHARP"}) == {"FINISHED"}
    edited = bmesh.from_edit_mesh(grid.data)
    assert len(edited.verts) == 49
    marked = [e for e in edited.edges if e.seam]
    assert len(marked) >= 5
    assert marked == [e for e in edited.edges if not e.smooth]


def test_a_face_folded_onto_its_neighbour_is_refused(scene, seams):
    """A piece that has the vertices of another face, old or new, is none that Blender can make."""
    from bl_ext.user_default.smooth_polylines.seams import apply_cut

    positions = [(0, 0, 0), (0.5, -0.1, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
    folded = add_mesh_object("Folded", positions, [(0, 1, 2, 3, 4), (2, 1, 0), (4, 3, 2, 1, 0)])
    edited = bmesh.new()
    edited.from_mesh(folded.data)
    edited.verts.ensure_lookup_table()
    apply_cut.refuse_doubled_faces(edited, {0: {0: [0, 1, 3], 1: [1, 2, 3], 2: [0, 3, 4]}}, 5)
    for pieces in ({0: {0: [0, 1, 2], 1: [0, 2, 3, 4]}}, {0: {0: [0, 1, 5], 1: [5, 3, 4]}, 2: {0: [0, 5, 1]}}):
        with pytest.raises(apply_cut.ObjectError, match="is folded onto face [01]"):
            apply_cut.refuse_doubled_faces(edited, pieces, 5)
    # The small face itself may go.
    apply_cut.refuse_doubled_faces(edited, {0: {0: [0, 1, 2], 1: [0, 2, 3, 4]}, 1: {0: [2, 1, 5], 1: [1, 0, 5]}}, 5)
    edited.free()
