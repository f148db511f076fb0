"""Marks copied to a mesh of the same topology and mirrored within one: every edge, against plain loops; refusals."""

import numpy as np
import pytest

import bpy

import bmesh

from blender_scenes import add_grid, add_mesh_object, enter_edit_mode

MARKS = ("SEAM", "SHARP", "CREASE", "BEVEL_WEIGHT", "FREESTYLE", "SELECT")


@pytest.fixture
def copier(extension):
    from bl_ext.user_default.smooth_polylines.seams import copy_marks

    return copy_marks


def read(mesh_object, mark):
    from bl_ext.user_default.smooth_polylines.seams import edge_marks

    return edge_marks.read_marks(mesh_object.data, mark)


def write(mesh_object, mark, values):
    from bl_ext.user_default.smooth_polylines.seams import edge_marks

    edge_marks.write_marks(mesh_object.data, mark, values)


def mark_randomly(mesh_object, seed=3):
    """Marks of every kind; what they are, by the kind."""
    random = np.random.default_rng(seed)
    for mark in MARKS:
        values = random.random(len(mesh_object.data.edges)) * (random.random(len(mesh_object.data.edges)) < 0.4)
        write(mesh_object, mark, values if mark in {"CREASE", "BEVEL_WEIGHT"} else values > 0)
    return {mark: read(mesh_object, mark) for mark in MARKS}


def add_suzanne():
    bpy.ops.mesh.primitive_monkey_add()
    return bpy.context.object


@pytest.mark.parametrize("is_editing", [False, True])
def test_marks_are_copied_to_every_edge_of_a_posed_copy(scene, copier, is_editing):
    source = add_suzanne()
    target = source.copy()
    target.data = source.data.copy()
    bpy.context.scene.collection.objects.link(target)
    target.data.vertices.foreach_set("co", np.random.default_rng(0).random(len(target.data.vertices) * 3))
    given = mark_randomly(source)
    if is_editing:
        bpy.ops.object.select_all(action="DESELECT")
        enter_edit_mode(target)
    done = copier.copy_marks(source, target, MARKS)
    assert (bpy.context.mode == "EDIT_MESH") == is_editing
    bpy.ops.object.mode_set(mode="OBJECT")
    for mark in MARKS:
        if mark != "SELECT":  # leaving Edit Mode adds what lies between selected vertices
            np.testing.assert_array_equal(read(target, mark), given[mark], err_msg=mark)
        np.testing.assert_array_equal(read(source, mark), given[mark], err_msg=mark)
    assert done.changed >= np.count_nonzero(np.any([given[m] for m in MARKS[:-1]], axis=0))


def test_edges_in_another_order_are_the_same_topology(scene, copier):
    source = add_grid(3, 2)
    faces = [tuple(p.vertices) for p in source.data.polygons]
    mesh = bpy.data.meshes.new("Turned")
    edges = [tuple(reversed(e.vertices)) for e in source.data.edges][::-1]
    mesh.from_pydata([v.co[:] for v in source.data.vertices], edges, [f[1:] + f[:1] for f in faces])
    target = bpy.data.objects.new("Turned", mesh)
    bpy.context.scene.collection.objects.link(target)
    given = {tuple(sorted(e.vertices)): e.index % 2 == 0 for e in source.data.edges}
    write(source, "SEAM", np.array([e.index % 2 == 0 for e in source.data.edges]))
    copier.copy_marks(source, target)
    assert {tuple(sorted(e.vertices)): e.use_seam for e in target.data.edges} == given


SQUARES = [(0, 1, 4, 3), (1, 2, 5, 4)]
PLACES = [(x, y, 0) for y in range(2) for x in range(3)]


@pytest.mark.parametrize(
    ("faces", "message"),
    [
        ([(0, 1, 4, 3)], "Mine has 2 faces, but Other has 1;"),
        ([(0, 1, 4, 3), (1, 2, 5, 3)], "Mine has 7 edges, but Other has 8;"),
        ([(0, 1, 4, 3), (1, 4, 5, 2)], r"Face 1 of Mine has the vertices \[1, 2, 5, 4\], but \[1, 4, 5, 2\] in Other"),
        ([(0, 1, 2, 4, 3), (2, 5, 4)], "Face 0 of Mine has 4 corners, but 5 in Other"),
    ],
)
def test_the_first_difference_is_named_and_nothing_changed(scene, copier, faces, message):
    source = add_mesh_object("Mine", PLACES, SQUARES)
    target = add_mesh_object("Other", PLACES, faces)
    write(source, "SEAM", np.ones(len(source.data.edges)))
    with pytest.raises(copier.AddonError, match=message):
        copier.copy_marks(source, target)
    assert not any(edge.use_seam for edge in target.data.edges)


def test_a_loose_edge_elsewhere_is_a_difference(scene, copier):
    source, target = (add_mesh_object(name, [*PLACES, (9, 9, 9)], SQUARES) for name in ("Mine", "Other"))
    for mesh_object, ends in ((source, (0, 6)), (target, (1, 6))):
        mesh_object.data.edges.add(1)
        mesh_object.data.edges[-1].vertices = ends
    with pytest.raises(copier.AddonError, match=r"Edge 7 of Other joins the vertices \[1, 6\], but Mine has no such"):
        copier.copy_marks(source, target)


@pytest.mark.parametrize("method", ["POSITION", "TOPOLOGY"])
@pytest.mark.parametrize("direction", ["POSITIVE_TO_NEGATIVE", "NEGATIVE_TO_POSITIVE", "BOTH"])
def test_mirrored_marks_are_those_of_the_image_of_every_edge(scene, copier, method, direction):
    suzanne = add_suzanne()
    # Without the eyes: parts that do not reach the plane can be compared by position alone.
    keep_largest_part(suzanne)
    given = mark_randomly(suzanne)
    done = copier.mirror_marks(suzanne, "X", MARKS[:-1], method=method, direction=direction, tolerance=1e-4)
    assert done.unmatched == 0
    check_mirrored(suzanne, given, direction, [v.co for v in suzanne.data.vertices])


def test_by_topology_a_posed_side_is_still_the_other_side(scene, copier):
    suzanne = add_suzanne()
    keep_largest_part(suzanne)
    places = [v.co.copy() for v in suzanne.data.vertices]
    for vertex in suzanne.data.vertices:
        if vertex.co.x > 1e-4:
            vertex.co.x *= 1.5
            vertex.co.z += 0.3 * vertex.co.x
    given = mark_randomly(suzanne)
    by_position = copier.mirror_marks(suzanne, "X", ("SEAM",), tolerance=1e-4)
    assert by_position.unmatched > len(suzanne.data.edges) // 2
    write(suzanne, "SEAM", given["SEAM"])
    done = copier.mirror_marks(suzanne, "X", MARKS[:-1], method="TOPOLOGY", direction="NEGATIVE_TO_POSITIVE")
    assert done.unmatched == 0
    check_mirrored(suzanne, given, "NEGATIVE_TO_POSITIVE", places)


def check_mirrored(mesh_object, given, direction, places):
    """Every edge against the edge between the images of its ends, found by plain loops over all vertices."""
    image = {}
    for number, place in enumerate(places):
        flipped = np.array([-place[0], place[1], place[2]])
        distances = np.linalg.norm(np.array(places) - flipped, axis=1)
        image[number] = int(np.argmin(distances))
        assert distances.min() < 1e-4
    edges = {tuple(sorted(e.vertices)): e.index for e in mesh_object.data.edges}
    found = {mark: read(mesh_object, mark) for mark in given}
    taken = 0
    for (a, b), number in edges.items():
        other = edges[tuple(sorted((image[a], image[b])))]
        x = places[a][0] + places[b][0]
        takes = other != number and (
            direction == "BOTH" or (x < -1e-5 if direction == "POSITIVE_TO_NEGATIVE" else x > 1e-5)
        )
        for mark, values in given.items():
            if mark == "SELECT":
                continue
            expected = values[number]
            if takes:
                expected = max(expected, values[other]) if direction == "BOTH" else values[other]
            assert found[mark][number] == expected
        taken += takes
    assert taken > len(edges) // 3


def keep_largest_part(mesh_object):
    edited = bmesh.new()
    edited.from_mesh(mesh_object.data)
    edited.verts.ensure_lookup_table()
    seen, front = set(), [min(edited.verts, key=lambda v: v.co.z)]
    while front:
        vertex = front.pop()
        if vertex not in seen:
            seen.add(vertex)
            front += [edge.other_vert(vertex) for edge in vertex.link_edges]
    bmesh.ops.delete(edited, geom=[v for v in edited.verts if v not in seen], context="VERTS")
    edited.to_mesh(mesh_object.data)
    edited.free()


def test_mirror_in_edit_mode_reads_what_is_being_edited(scene, copier):
    grid = add_grid(4, 2)
    for vertex in grid.data.vertices:
        vertex.co.x -= 2
    enter_edit_mode(grid)
    edited = bmesh.from_edit_mesh(grid.data)
    for edge in edited.edges:
        edge.seam = all(v.co.x >= 1 for v in edge.verts)
    bmesh.update_edit_mesh(grid.data)
    done = copier.mirror_marks(grid)
    assert done.changed == 7
    assert {round(sum(v.co.x for v in e.verts)) for e in bmesh.from_edit_mesh(grid.data).edges if e.seam} == {
        -4,
        -3,
        -2,
        2,
        3,
        4,
    }


def test_refusals_of_the_mirror(scene, copier):
    grid = add_grid(3, 2)
    for vertex in grid.data.vertices:
        vertex.co.z = 1
    with pytest.raises(copier.AddonError, match=r"No edge lies on the plane Z = 0 .*mirror by position"):
        copier.mirror_marks(grid, "Z", method="TOPOLOGY")
    with pytest.raises(copier.AddonError, match="axis is 'W'; it must be one of X, Y, Z"):
        copier.mirror_marks(grid, "W")
    with pytest.raises(copier.AddonError, match="There is no mark 'SEEM'"):
        copier.mirror_marks(grid, "X", ("SEEM",))
    with pytest.raises(copier.AddonError, match=r"tolerance is 0\.0"):
        copier.mirror_marks(grid, "X", tolerance=0.0)
    with pytest.raises(copier.AddonError, match="same mesh already"):
        copier.copy_marks(grid, grid)


def test_operators_copy_to_selected_and_mirror_with_undo(scene, copier):
    source, target = add_grid(3, 2, name="Source"), add_grid(3, 2, name="Target")
    add_grid(2, 2, name="Other")
    write(source, "SEAM", np.arange(17) % 2)
    for mesh_object in (source, target):
        mesh_object.select_set(True)
    bpy.context.view_layer.objects.active = source
    bpy.ops.ed.undo_push(message="Before")
    assert bpy.ops.mesh.smooth_polyline_copy_marks("EXEC_DEFAULT", True) == {"FINISHED"}
    assert [e.use_seam for e in target.data.edges] == [i % 2 == 1 for i in range(17)]
    bpy.ops.ed.undo()
    assert not any(e.use_seam for e in bpy.data.objects["Target"].data.edges)
    bpy.ops.ed.redo()
    assert sum(e.use_seam for e in bpy.data.objects["Target"].data.edges) == 8

    bpy.data.objects["Other"].select_set(True)
    write(bpy.data.objects["Source"], "SEAM", np.zeros(17))
    with pytest.raises(RuntimeError, match="Source has 12 vertices, but Other has 9"):
        bpy.ops.mesh.smooth_polyline_copy_marks()
    assert sum(e.use_seam for e in bpy.data.objects["Target"].data.edges) == 8  # all or none
    bpy.ops.object.select_all(action="DESELECT")
    with pytest.raises(RuntimeError, match="No other mesh is selected"):
        bpy.ops.mesh.smooth_polyline_copy_marks()
    assert bpy.ops.mesh.smooth_polyline_mirror_marks(marks={"SEAM", "SHARP"}) == {"FINISHED"}


def test_marks_are_not_written_to_linked_data(scene, copier, tmp_path):
    target = add_grid(3, 2, name="Linked")
    bpy.data.libraries.write(str(tmp_path / "library.blend"), {target})
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    with bpy.data.libraries.load(str(tmp_path / "library.blend"), link=True) as (_, wanted):
        wanted.objects = ["Linked"]
    source = add_grid(3, 2, name="Source")
    with pytest.raises(copier.AddonError, match=r"Linked is linked from .*make it local"):
        copier.copy_marks(source, wanted.objects[0])
    with pytest.raises(copier.AddonError, match=r"Linked is linked from"):
        copier.mirror_marks(wanted.objects[0])
    # From a linked mesh they may be read.
    assert copier.copy_marks(wanted.objects[0], source).changed == 0
