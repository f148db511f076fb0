"""Lines put into meshes by the operator and by the plain function: what is marked, what is cut, what must stay.

Old values to the byte, areas and volumes, and a flood fill of its own that must stop at the line and nowhere else.
"""

import numpy as np
import pytest

import bpy

import bmesh

import meshes
import smooth_polylines as sp
from attributed_mesh import add_attributed_grid, read_edges, read_everything, read_faces
from blender_scenes import add_grid, add_mesh_object, count_data, enter_edit_mode, pick_faces
from cut_meshes import add_ball, circle_on_ball, flood, measure, seam_edges


@pytest.mark.parametrize("kind", ["quads", "triangles", "n-gons"])
@pytest.mark.parametrize("options", [{}, {"filter": "fair", "detail_size": 0.2}, {"filter": "geodesic"}])
def test_a_closed_cut_parts_the_ball_exactly_along_the_line(scene, seams, kind, options):
    ball = add_ball(kind)
    before, faces = measure(ball.data), read_faces(ball.data)
    places = np.array([v.co for v in ball.data.vertices])
    closed = (circle_on_ball(0.2), True)
    if options.get("filter") == "geodesic":
        # Through points of its own, so that it does not slip off.
        options = {**options, "pinned": "all"}
    done = seams.put.put_lines_into_mesh(bpy.context, ball, [closed], max_distance=0.2, **options)
    mesh = ball.data
    after = measure(mesh)
    assert after.euler == before.euler == 2
    assert after.border == before.border == 0
    # Coordinates have 32 bits; a face that is not flat has no one area: its pieces are cut into other triangles.
    rounding = 1e-4 if kind == "n-gons" else 2e-6
    assert after.area == pytest.approx(before.area, rel=rounding)
    assert after.volume == pytest.approx(before.volume, rel=rounding)
    assert mesh.validate() is False
    np.testing.assert_array_equal(np.array([v.co for v in mesh.vertices])[: len(places)], places)
    assert len(mesh.vertices) == len(places) + done.new_vertices
    assert len(mesh.polygons) == len(faces) + done.new_faces
    untouched = [face for face, corners in enumerate(faces) if tuple(mesh.polygons[face].vertices) == corners]
    touched = {face for face in range(len(faces))} - set(untouched)
    assert 0 < len(touched) < len(faces) // 2
    walls = set(done.edges.tolist())
    assert seam_edges(mesh) == walls
    parts = flood(mesh, walls)
    assert len(set(parts)) == 2
    # Every wall has a part on either side: nothing else is a wall, nothing is open.
    for edge in walls:
        sides = {parts[p.index] for p in mesh.polygons if edge in {mesh.loops[i].edge_index for i in p.loop_indices}}
        assert sides == {0, 1}
    # Its edges are the segments of the line.
    line = done.lines[0]
    vertices = {v for edge in walls for v in mesh.edges[edge].vertices}
    found = np.array([mesh.vertices[v].co for v in vertices])
    gaps = np.linalg.norm(found[:, None] - line.points[None], axis=2)
    assert gaps.min(axis=1).max() < 1e-3
    assert gaps.min(axis=0).max() < 1e-3
    total = sum(
        np.linalg.norm(np.subtract(*(mesh.vertices[v].co for v in mesh.edges[edge].vertices))) for edge in walls
    )
    assert total == pytest.approx(line.length, rel=1e-3)


@pytest.mark.parametrize("is_editing", [False, True])
def test_old_values_are_the_same_to_the_byte(scene, seams, is_editing):
    grid = add_attributed_grid()
    before, faces, edges = read_everything(grid), read_faces(grid.data), read_edges(grid.data)
    if is_editing:
        grid.active_shape_key_index = 0
        bpy.context.view_layer.objects.active = grid
        grid.select_set(True)
        bpy.ops.object.mode_set(mode="EDIT")
        bpy.ops.object.mode_set(mode="OBJECT")
        before = read_everything(grid)  # with what Edit Mode itself changes
        bpy.ops.object.mode_set(mode="EDIT")
    line = np.array([(0.3, 0.4, 0.2), (2.5, 1.7, -0.1), (4.6, 3.4, 0)])
    done = seams.put.put_lines_into_mesh(bpy.context, grid, [line], marks=("SHARP",), max_distance=1.0)
    if is_editing:
        assert bpy.context.mode == "EDIT_MESH"
        bpy.ops.object.mode_set(mode="OBJECT")
    after = read_everything(grid)
    assert set(before) <= set(after)
    new_faces, new_edges = read_faces(grid.data), read_edges(grid.data)
    kept_faces = [face for face in range(len(faces)) if new_faces[face] == faces[face]]
    kept_edges = [key for key in edges if key in new_edges]
    assert 4 < len(kept_faces) < len(faces)
    corners = np.cumsum([0, *map(len, faces)])
    new_corners = np.cumsum([0, *map(len, new_faces)])
    for name, (domain, values) in before.items():
        found = after[name][1]
        if domain == "POINT":
            np.testing.assert_array_equal(found[: len(values)], values, err_msg=name)
        elif domain == "FACE":
            np.testing.assert_array_equal(found[: len(values)], values, err_msg=name)
        elif domain == "EDGE":
            rows = [edges[key] for key in kept_edges], [new_edges[key] for key in kept_edges]
            np.testing.assert_array_equal(found[rows[1]], values[rows[0]], err_msg=name)
        else:
            for face in kept_faces:
                np.testing.assert_array_equal(
                    found[new_corners[face] : new_corners[face + 1]],
                    values[corners[face] : corners[face + 1]],
                    err_msg=name,
                )
    old_sharp = {tuple(sorted(e.vertices)) for e in grid.data.edges if e.use_edge_sharp and e.index not in done.edges}
    assert all(grid.data.edges[e].use_edge_sharp for e in done.edges)
    assert len(old_sharp) >= 10
    # New corners lie between the old ones of their face, in every map.
    for layer in grid.data.uv_layers:
        uvs = np.array([uv.vector for uv in layer.uv])
        assert uvs.min() >= -1e-6
        assert uvs.max() <= 1 + 1e-6


# Blender stores a custom normal as two angles from the corner's own normal, of 16 bits each: its tilt, and its
# direction round it, taken for 0 where its cosine is above 0.9999 (LNOR_SPACE_TRIGO_THRESHOLD in its sources).
# So it comes back to within that angle times the sine of its tilt, and to half a step of both angles and the rounding
# of cosines near 1. A tilt below that angle may be dropped (Blender 5).
DIRECTION_LOST = np.arccos(0.9999)
ANGLES_ROUNDED = 4e-4


@pytest.mark.parametrize("kind", ["quads", "triangles", "n-gons"])
def test_custom_normals_are_carried_over_to_what_their_encoding_allows(scene, seams, kind):
    ball = add_ball(kind)
    mesh = ball.data
    mesh.polygons.foreach_set("use_smooth", np.ones(len(mesh.polygons), dtype=bool))
    leaning = np.array([0.3, 0.2, 0.1]) + np.array([mesh.vertices[loop.vertex_index].co for loop in mesh.loops])
    leaning /= np.linalg.norm(leaning, axis=1)[:, None]
    mesh.normals_split_custom_set([tuple(n) for n in leaning])
    count = len(mesh.vertices)
    for editing in (False, True):
        before = read_normals(mesh)
        if editing:
            bpy.ops.object.mode_set(mode="EDIT")
        height = -0.4 if editing else 0.3
        seams.put.put_lines_into_mesh(bpy.context, ball, [(circle_on_ball(height), True)], max_distance=0.2)
        if editing:
            assert bpy.context.mode == "EDIT_MESH"
            bpy.ops.object.mode_set(mode="OBJECT")
        mesh = ball.data
        assert mesh.has_custom_normals
        assert "smooth_polyline_normals" not in mesh.attributes
        after = read_normals(mesh)
        # Corners at old vertices: all faces at one have the same normal.
        own = np.array([mesh.vertices[v].normal for v in range(count)], dtype=np.float64)
        lost = []
        for vertex in range(count):
            for normal in after[vertex]:
                tilt = np.linalg.norm(np.cross(before[vertex][0], own[vertex]))
                allowed = tilt if tilt < DIRECTION_LOST else DIRECTION_LOST * tilt
                lost.append(np.linalg.norm(normal - before[vertex][0]) - allowed)
        assert len(lost) > 1000
        assert max(lost) < ANGLES_ROUNDED
        # New ones lie between their neighbours, which are near.
        for vertex in range(count, len(mesh.vertices)):
            expected = np.array(mesh.vertices[vertex].co) + np.array([0.3, 0.2, 0.1])
            assert (after[vertex] @ expected / np.linalg.norm(expected)).min() > 0.99


def read_normals(mesh):
    """The custom normals of the corners at each vertex: (n, 3) each."""
    found = [[] for _ in mesh.vertices]
    for loop, normal in zip(mesh.loops, mesh.corner_normals, strict=True):
        found[loop.vertex_index].append(tuple(normal.vector))
    return [np.array(normals, dtype=np.float64) for normals in found]


def test_all_marks_in_both_modes(scene, seams):
    marks = ("SEAM", "SHARP", "CREASE", "BEVEL_WEIGHT", "FREESTYLE", "SELECT")
    from bl_ext.user_default.smooth_polylines.seams import edge_marks

    for editing in (False, True):
        grid = add_grid(6, 6, name=f"Grid {editing}")
        bpy.ops.object.select_all(action="DESELECT")
        if editing:
            enter_edit_mode(grid)
        line = np.array([(0.3, 0.4, 0), (2.5, 1.7, 0), (4.6, 3.4, 0)])
        done = seams.put.put_lines_into_mesh(bpy.context, grid, [line], marks=marks, weight=0.75)
        if editing:
            assert bpy.context.mode == "EDIT_MESH"
            bpy.ops.object.mode_set(mode="OBJECT")
        chosen = np.zeros(len(grid.data.edges), dtype=bool)
        chosen[done.edges] = True
        assert 5 < chosen.sum() < 40
        for mark in marks:
            expected = chosen * (0.75 if mark in {"CREASE", "BEVEL_WEIGHT"} else 1.0)
            np.testing.assert_allclose(edge_marks.read_marks(grid.data, mark), expected, err_msg=mark)


def test_nothing_is_selected_that_was_not_and_hidden_faces_stay_hidden(scene, seams):
    grid = add_grid(6, 6)
    enter_edit_mode(grid)
    edited = bmesh.from_edit_mesh(grid.data)
    edited.faces.ensure_lookup_table()
    for face in (7, 8, 13):
        edited.faces[face].select_set(True)
    for face in (10, 16):
        edited.faces[face].hide_set(True)
    bmesh.update_edit_mesh(grid.data)
    line = np.array([(0.3, 1.5, 0), (3.7, 1.6, 0)])  # through 7 and 8, up to the hidden 10
    seams.put.put_lines_into_mesh(bpy.context, grid, [line])
    bpy.ops.object.mode_set(mode="OBJECT")
    chosen = [p for p in grid.data.polygons if p.select]
    assert sum(p.area for p in chosen) == pytest.approx(3)
    for polygon in chosen:
        x, y, _ = polygon.center
        assert (int(x), int(y)) in {(1, 1), (2, 1), (1, 2)}
    hidden = [p for p in grid.data.polygons if p.hide]
    assert [round(p.area, 6) for p in hidden] == [1, 1]
    assert hidden[0].index == 10


def test_the_mesh_of_several_objects_changes_for_all_and_is_told(scene, seams):
    grid = add_grid(6, 6)
    twin = bpy.data.objects.new("Twin", grid.data)
    scene.collection.objects.link(twin)
    line = np.array([(0.3, 0.4, 0), (4.6, 3.4, 0)])
    done = seams.put.put_lines_into_mesh(bpy.context, grid, [line])
    assert done.sharing == ["Twin"]
    assert twin.data == grid.data
    assert len(twin.data.vertices) == 49 + done.new_vertices


def test_lines_in_world_space_on_a_sheared_object(scene, seams):
    from mathutils import Matrix

    grid = add_grid(6, 6)
    grid.matrix_world = Matrix(((2, 0.5, 0, 3), (0, 1, 0, -1), (0, 0.2, 0.5, 2), (0, 0, 0, 1)))
    bpy.context.view_layer.update()
    m = np.array(grid.matrix_world)
    ends = np.array([(0.5, 0.5, 0), (5.5, 4.5, 0)]) @ m[:3, :3].T + m[:3, 3]
    done = seams.put.put_lines_into_mesh(bpy.context, grid, [ends])
    for edge in done.edges:
        for vertex in grid.data.edges[edge].vertices:
            x, y, z = grid.data.vertices[vertex].co
            assert abs((y - 0.5) - 0.8 * (x - 0.5)) < 1e-3 + 2e-3  # a tolerance of the cut: through near vertices
            assert z == 0


def test_curves_that_remember_survive_the_cut(scene, seams):
    grid = add_grid(12, 12)
    first = seams.session.add_polyline(bpy.context, grid, [0, 70, 143], filter="fair", pinned="all").curve_object
    second = seams.session.add_polyline(bpy.context, grid, [11, 132], filter="geodesic").curve_object
    before = [np.array([p.co[:3] for p in c.data.splines[0].points]) for c in (first, second)]
    done = seams.put.put_lines_into_mesh(bpy.context, grid, [first])
    bpy.context.view_layer.update()
    for curve_object, points in zip((first, second), before, strict=True):
        known = curve_object.data.smooth_polyline
        assert known.state == "FOUND_AGAIN"
        now = np.array([p.co[:3] for p in curve_object.data.splines[0].points])
        gaps = np.linalg.norm(now[:, None] - points[None], axis=2).min(axis=1)
        assert gaps.max() < 0.6
        ends = np.linalg.norm(now[[0, -1]] - points[[0, -1]], axis=1)
        assert ends.max() < 0.3  # a face's own point is another than the middle of the face
    assert len(done.edges) > 10


def test_two_lines_that_cross_meet_in_a_vertex(scene, seams):
    grid = add_grid(6, 6)
    lines = [np.array([(0.3, 0.4, 0), (5.6, 5.2, 0)]), np.array([(0.4, 5.3, 0), (5.5, 0.3, 0)])]
    done = seams.put.put_lines_into_mesh(bpy.context, grid, lines)
    counts = np.bincount([v for e in done.edges for v in grid.data.edges[e].vertices])
    assert np.count_nonzero(counts == 4) == done.crossings == 1
    assert np.count_nonzero(counts == 1) == 4
    assert measure(grid.data).euler == 1


def call_as_the_interface_does(**properties):
    return bpy.ops.mesh.smooth_polyline_seam("EXEC_DEFAULT", True, **properties)


def test_operator_on_picks_with_undo_and_redo(scene, seams):
    grid = add_grid(6, 6)
    enter_edit_mode(grid)
    pick_faces(grid, [0, 14, 35])
    bpy.ops.ed.undo_push(message="Pick")
    assert call_as_the_interface_does(filter="GEODESIC") == {"FINISHED"}
    count = len(bmesh.from_edit_mesh(bpy.data.objects["Grid"].data).verts)
    assert count > 49
    bpy.ops.ed.undo()
    edited = bmesh.from_edit_mesh(bpy.data.objects["Grid"].data)
    assert len(edited.verts) == 49
    assert [f.index for f in list(edited.select_history)] == [0, 14, 35]
    assert not any(e.seam for e in edited.edges)
    bpy.ops.ed.redo()
    edited = bmesh.from_edit_mesh(bpy.data.objects["Grid"].data)
    assert len(edited.verts) == count
    assert sum(e.seam for e in edited.edges) > 5


def test_operator_on_selected_curves_in_object_mode_with_undo(scene, seams):
    grid = add_grid(6, 6)
    curve_object = seams.session.add_polyline(bpy.context, grid, [0, 35], filter="geodesic").curve_object
    bpy.ops.object.select_all(action="DESELECT")
    curve_object.select_set(True)
    bpy.context.view_layer.objects.active = curve_object  # the curve alone says which mesh
    bpy.ops.ed.undo_push(message="Before")
    assert call_as_the_interface_does(unwrap=True) == {"FINISHED"}
    grid = bpy.data.objects["Grid"]
    count = len(grid.data.vertices)
    assert count > 49
    assert len(grid.data.uv_layers) == 1
    bpy.ops.ed.undo()
    assert len(bpy.data.objects["Grid"].data.vertices) == 49
    bpy.ops.ed.redo()
    assert len(bpy.data.objects["Grid"].data.vertices) == count


def test_refusals_leave_everything_as_it_was(scene, seams, tmp_path):
    grid = add_grid(6, 6)
    bpy.context.view_layer.objects.active = grid
    line = np.array([(0.3, 0.4, 0), (4.6, 3.4, 0)])
    far = np.add(line, [0, 0, 50])
    before = (count_data(), read_everything(grid))

    def refused(match, mesh_object=grid, lines=(line,), **options):
        with pytest.raises(seams.session.ObjectError.__mro__[1], match=match):
            seams.put.put_lines_into_mesh(bpy.context, mesh_object, list(lines), **options)

    refused("no line to put into Grid", lines=())
    refused("away from the mesh", lines=(far,))
    refused("method is 'SAW'", method="SAW")
    refused("no mark 'SEEM'", marks=("SEEM",))
    refused("a curve object", mesh_object=seams.session.add_polyline(bpy.context, grid, [0, 1]).curve_object)
    bpy.data.objects.remove(bpy.data.objects["Smooth Polyline"])
    bpy.data.curves.remove(bpy.data.curves[0])
    modifier = grid.modifiers.new("Levels", "MULTIRES")
    refused("Multiresolution.*would be lost.*cut", method="CUT")
    refused("Multiresolution.*moved", method="SLIDE")
    grid.modifiers.remove(modifier)
    with pytest.raises(RuntimeError, match="no line to put into Grid"):
        bpy.ops.mesh.smooth_polyline_seam()
    now = (count_data(), read_everything(grid))
    assert now[0] == before[0]
    for name, (_, values) in before[1].items():
        np.testing.assert_array_equal(now[1][name][1], values, err_msg=name)
    bpy.data.libraries.write(str(tmp_path / "library.blend"), {grid})
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    with bpy.data.libraries.load(str(tmp_path / "library.blend"), link=True) as (_, wanted):
        wanted.objects = ["Grid"]
    refused("Grid is linked from .*make it local", mesh_object=wanted.objects[0])


@pytest.mark.parametrize(
    "name",
    [
        "cow.off",
        "fandisk.obj",
        "fertility.off",
        "moebius.obj",
        "openscad_crash.obj",
        "shark_holes.off",
        "spot.obj",
        "tray_cad.off",
    ],
)
def test_random_lines_on_real_meshes_keep_their_shape(scene, seams, name):
    shared = meshes.load_shared_mesh(name)
    mesh_object = add_mesh_object("Real", shared.positions, shared.triangles.tolist())
    before = measure(mesh_object.data)
    random = np.random.default_rng(1)
    opened = seams.surface.open_surface(bpy.context, mesh_object)
    centres = shared.positions[shared.triangles].mean(axis=1)
    lines = []
    for filter_name in ("linear", "geodesic", "fair", "cubic"):
        for closed in (False, True):
            start = int(random.integers(len(centres)))
            near = np.argsort(np.linalg.norm(centres - centres[start], axis=1))[: max(30, len(centres) // 12)]
            picks = [start, *random.choice(near, 4).tolist()]
            try:
                lines.append(opened.library_mesh.polyline(picks, filter=filter_name, closed=closed))
            except sp.Error:
                continue  # on another part, or shrunk to a point
    assert len(lines) >= 3
    done = seams.put.put_lines_into_mesh(bpy.context, mesh_object, lines)
    mesh = mesh_object.data
    after = measure(mesh)
    assert (after.euler, after.border) == (before.euler, before.border)
    assert after.area == pytest.approx(before.area, rel=1e-7)  # coordinates have 32 bits
    if before.border == 0:
        assert after.volume == pytest.approx(before.volume, rel=1e-6)
    assert mesh.validate() is False
    assert len({tuple(sorted(edge.vertices)) for edge in mesh.edges}) == len(mesh.edges)
    assert seam_edges(mesh) == set(done.edges.tolist())
