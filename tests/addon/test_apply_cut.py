"""A cut by hand, carried out in a BMesh: what each element carries, old ones to the byte, new ones by a formula.

The cut runs over the attributed grid through its second row of faces: from the left border through every upright edge,
one of them twice, into the last face, where it ends at a point inside.
"""

import itertools
from types import SimpleNamespace

import numpy as np
import pytest

import bmesh

from attributed_mesh import (
    COLUMNS,
    FLOATS,
    add_attributed_grid,
    read_edges,
    read_everything,
    read_faces,
)

WIDTH = COLUMNS + 1
ROW = 1
PARAMETERS = [0.25, 0.5, 0.3, 0.6, 0.7]
TWICE = 0.8  # the second crossing of the third upright edge


def make_cut(mesh):
    """The cut described above, as the library gives it."""
    count = len(mesh.vertices)
    below = [ROW * WIDTH + column for column in range(WIDTH)]
    above = [v + WIDTH for v in below]
    edges = [(below[i], above[i]) for i in range(COLUMNS)]
    parameters = list(PARAMETERS)
    # Counted from the other end: as good as any.
    edges[1], parameters[1] = (edges[1][1], edges[1][0]), 1 - parameters[1]
    edges += [edges[2], (-1, -1)]
    parameters += [TWICE, 0.0]
    new = [count + i for i in range(len(edges))]
    twice, inside = new[COLUMNS], new[COLUMNS + 1]
    triangles, corners_of = read_triangles(mesh)
    in_triangle = [corners_of[ROW * COLUMNS + min(i, COLUMNS - 1)][0] for i in range(COLUMNS)]
    last = corners_of[ROW * COLUMNS + COLUMNS - 1][0]
    barycentric = np.zeros((len(edges), 3))
    barycentric[-1] = [0.2, 0.3, 0.5]

    polygons, parents = [], []
    for face, corners in enumerate(read_faces(mesh)):
        column = face - ROW * COLUMNS
        if face // COLUMNS != ROW:
            pieces = [corners]
        elif column == COLUMNS - 1:  # ends inside: joined to a corner
            pieces = [
                (below[column], below[column + 1], inside, new[column]),
                (new[column], inside, below[column + 1], above[column + 1], above[column]),
            ]
        else:
            a, b, c, d = below[column], below[column + 1], above[column + 1], above[column]
            left, right = new[column], new[column + 1]
            if column == 1:  # leaves through the third edge below, and comes back into it above
                pieces = [(a, b, right, left), (left, right, twice), (left, twice, c, d)]
            elif column == 2:
                pieces = [(a, b, right, left), (left, right, c, d, twice)]
            else:
                pieces = [(a, b, right, left), (left, right, c, d)]
        polygons += pieces
        parents += [face] * len(pieces)
    chain = [*new[:COLUMNS], inside]
    return SimpleNamespace(
        vertex_triangles=np.array([*in_triangle, in_triangle[1], last]),
        vertex_barycentric=barycentric,
        vertex_edges=np.array(edges),
        vertex_parameters=np.array(parameters),
        polygon_corners=np.array([v for polygon in polygons for v in polygon]),
        polygon_offsets=np.cumsum([0, *map(len, polygons)]),
        polygon_parents=np.array(parents),
        changed_polygons=np.flatnonzero(np.bincount(parents)[parents] > 1),
        line_edges=np.array(list(itertools.pairwise(chain))),
        triangles=triangles,
    )


def read_triangles(mesh):
    mesh.calc_loop_triangles()
    corners_of = {}
    for index, triangle in enumerate(mesh.loop_triangles):
        corners_of.setdefault(triangle.polygon_index, []).append(index)
    return np.array([tuple(t.vertices) for t in mesh.loop_triangles]), corners_of


@pytest.fixture
def done(scene):
    """The grid before, the cut, and the grid after."""
    from bl_ext.user_default.smooth_polylines.seams import apply_cut, edit

    grid = add_attributed_grid()
    grid.data.polygons[ROW * COLUMNS].select = True
    before = SimpleNamespace(
        values=read_everything(grid), faces=read_faces(grid.data), edges=read_edges(grid.data), cut=make_cut(grid.data)
    )
    positions = before.values["positions"][1].astype(np.float64)
    before.colours = (grid.data.attributes.active_color_name, grid.data.attributes.default_color_name)
    with edit.open_bmesh(grid) as edited:
        line = apply_cut.apply_cut(edited, before.cut, positions, before.cut.triangles).line_edges
        before.line_edges = [edge is not None and edge.is_valid for edge in line]
    return SimpleNamespace(
        before=before,
        grid=grid,
        values=read_everything(grid),
        faces=read_faces(grid.data),
        edges=read_edges(grid.data),
    )


def test_faces_are_the_pieces_and_others_keep_their_numbers(done):
    cut, before = done.before.cut, done.before
    wanted = {}
    for polygon, parent in enumerate(cut.polygon_parents):
        corners = cut.polygon_corners[cut.polygon_offsets[polygon] : cut.polygon_offsets[polygon + 1]]
        wanted.setdefault(parent, []).append(rotate(corners))
    new_of = match_new_vertices(done)
    found = [rotate([new_of.get(v, v) for v in face]) for face in done.faces]
    assert sorted(found) == sorted(face for faces in wanted.values() for face in faces)
    for parent, face in enumerate(before.faces):
        if len(wanted[parent]) == 1:
            # To the byte, unless the cut put a vertex into a border of it.
            assert done.faces[parent] == face
        else:
            assert found[parent] in wanted[parent]
    assert all(done.before.line_edges)
    assert done.grid.data.validate() is False


def test_every_value_of_every_old_element_is_as_it_was(done):
    old = done.before
    edge_rows = {key: index for key, index in old.edges.items() if key in done.edges}
    assert len(edge_rows) == len(old.edges) - COLUMNS
    corners = {(f, v): row for f, v, row in list_corners(old.faces)}
    for name, (domain, values) in old.values.items():
        new_domain, new_values = done.values[name]
        assert new_domain == domain
        if domain == "POINT":
            np.testing.assert_array_equal(new_values[: len(values)], values, err_msg=name)
        elif domain == "EDGE":
            for key, row in edge_rows.items():
                np.testing.assert_array_equal(new_values[done.edges[key]], values[row], err_msg=name)
        elif domain == "FACE":
            for face, parent in enumerate(find_parents(done)):
                np.testing.assert_array_equal(new_values[face], values[parent], err_msg=name)
        else:
            parents = find_parents(done)
            for face, vertex, row in list_corners(done.faces):
                old_row = corners.get((parents[face], vertex))
                if old_row is not None:
                    np.testing.assert_array_equal(new_values[row], values[old_row], err_msg=name)


def test_new_vertices_and_halves_of_edges_carry_what_lies_between(done):
    old, cut = done.before, done.before.cut
    new_of = match_new_vertices(done)
    for name, (domain, values) in old.values.items():
        new_values = done.values[name][1]
        if domain == "POINT" and is_interpolated(name):
            for vertex, row in ((v, n - len(values)) for v, n in new_of.items()):
                if row < COLUMNS + 1:
                    a, b = cut.vertex_edges[row]
                    t = cut.vertex_parameters[row]
                    check_mixed(name, new_values[vertex], values[[a, b]], [1 - t, t], row)
                else:
                    corners = values[cut.triangles[cut.vertex_triangles[row]]]
                    check_mixed(name, new_values[vertex], corners, cut.vertex_barycentric[row], row)
        elif domain == "EDGE" and not name.startswith("edge select"):
            for key, edge in done.edges.items():
                whole = find_whole_edge(done, key)
                if whole is not None:
                    np.testing.assert_array_equal(new_values[edge], values[old.edges[whole]], err_msg=name)


def test_new_corners_on_edges_carry_what_lies_between_in_their_own_face(done):
    old, cut = done.before, done.before.cut
    new_of = match_new_vertices(done)
    rows_of = {(f, v): row for f, v, row in list_corners(old.faces)}
    checked = 0
    for name, (domain, values) in old.values.items():
        if domain != "CORNER" or not is_interpolated(name):
            continue
        parents = find_parents(done)
        for face, vertex, row in list_corners(done.faces):
            number = new_of.get(vertex, 0) - len(old.values["positions"][1])
            if not 0 <= number <= COLUMNS:
                continue
            a, b = cut.vertex_edges[number]
            t = cut.vertex_parameters[number]
            ends = values[[rows_of[parents[face], a], rows_of[parents[face], b]]]
            check_mixed(name, done.values[name][1][row], ends, [1 - t, t], number)
            checked += 1
    assert checked > 100


def test_corners_at_a_point_inside_carry_what_lies_there(done):
    """In a flat quad whose values are linear over it, there is only one answer."""
    from bl_ext.user_default.smooth_polylines.seams import apply_cut

    grid = add_attributed_grid("Flat")
    mesh = grid.data
    grid.shape_key_clear()
    flat = done.before.values["positions"][1].copy()
    flat[:, 2] = 0
    mesh.attributes["position"].data.foreach_set("vector", flat.ravel())
    layer = mesh.uv_layers["UV 0"]
    for loop in mesh.loops:
        x, y, _ = mesh.vertices[loop.vertex_index].co
        layer.data[loop.index].uv = (0.1 * x + 0.02 * y, 0.3 - 0.05 * x + 0.1 * y)
    cut = make_cut(mesh)
    positions = np.array([v.co for v in mesh.vertices], dtype=np.float64)
    edited = bmesh.new()
    edited.from_mesh(mesh)
    apply_cut.apply_cut(edited, cut, positions, cut.triangles)
    edited.to_mesh(mesh)
    edited.free()
    for loop in mesh.loops:
        x, y, z = mesh.vertices[loop.vertex_index].co
        assert z == 0
        uv = mesh.uv_layers["UV 0"].data[loop.index].uv
        np.testing.assert_allclose(uv, (0.1 * x + 0.02 * y, 0.3 - 0.05 * x + 0.1 * y), atol=1e-6)


def test_layers_groups_and_keys_are_those_there_were(done):
    mesh = done.grid.data
    assert mesh.uv_layers.active.name == "UV 1"
    assert [layer.active_render for layer in mesh.uv_layers] == [True, False, False]
    assert (mesh.attributes.active_color_name, mesh.attributes.default_color_name) == done.before.colours
    assert [m.name for m in mesh.materials] == [f"Material {i}" for i in range(3)]
    keys = mesh.shape_keys.key_blocks
    assert [k.name for k in keys] == ["Basis", "Key 0", "Key 1"]
    assert [k.value for k in keys[1:]] == [0.25, 0.25]
    assert keys[2].relative_key == keys[1]
    assert [g.name for g in done.grid.vertex_groups] == ["Group 0", "Group 1"]


def test_a_new_vertex_carries_what_blenders_own_split_of_the_edge_gives(done):
    """Every kind of attribute, also INT8, which Blender does not mix: the values of an edge split by Blender alone."""
    old, cut = done.before, done.before.cut
    new_of = match_new_vertices(done)
    count = len(old.values["positions"][1])
    alone = add_attributed_grid("Alone")
    edited = bmesh.new()
    edited.from_mesh(alone.data)
    edited.verts.ensure_lookup_table()
    rows = [row for row in range(COLUMNS) if row != 2]  # the third edge is split twice
    for row in rows:
        (first, second), t = cut.vertex_edges[row], cut.vertex_parameters[row]
        if first > second:
            first, second, t = second, first, 1 - t
        a, b = edited.verts[int(first)], edited.verts[int(second)]
        bmesh.utils.edge_split(edited.edges.get((a, b)), a, float(t))
        edited.verts.ensure_lookup_table()
    edited.to_mesh(alone.data)
    edited.free()
    expected = read_everything(alone)
    kinds = 0
    for name, (domain, values) in expected.items():
        if domain != "POINT" or not is_interpolated(name):
            continue
        for place, row in enumerate(rows):
            vertex = next(v for v, number in new_of.items() if number - count == row)
            np.testing.assert_array_equal(done.values[name][1][vertex], values[count + place], err_msg=name)
        kinds += 1
    assert kinds >= 13


def is_interpolated(name):
    return not name.startswith(("vertex select", "vertex hide", "."))


def weigh(name, values, weights):
    """What Blender makes of it: sums, rounded where the kind is whole; either of two flags; groups over members."""
    weights = np.asarray(weights, dtype=np.float64)
    if name.startswith("group "):
        total = (np.where(values[:, 0] < 0, 0, values[:, 0]) * weights).sum()
        return [total if (values[:, 0] >= 0).any() else -1.0]
    mixed = weights @ values.astype(np.float64)
    kind = name.split(" ")[-1]
    if kind == "INT":
        return np.floor(mixed + 0.5)
    if kind == "BOOLEAN":
        return (values != 0).any(axis=0)
    assert kind in {*FLOATS, "BYTE_COLOR"} or name.startswith(("positions", "uv ", "UV ", "key "))
    return mixed


def check_mixed(name, found, values, weights, number):
    """Equal to the mixed value but for rounding: of bytes, and of whole numbers once at each crossing of an edge."""
    if name.endswith("INT8"):
        # Blender has no rule for mixing these; it takes one of them.
        assert found in values
        return
    tolerance = 3e-6
    if name.endswith("BYTE_COLOR"):
        tolerance = 0.006
    elif name.endswith("INT") and number >= COLUMNS:
        tolerance = 1.0
    np.testing.assert_allclose(found, weigh(name, values, weights), atol=tolerance, err_msg=name)


def rotate(corners):
    start = int(np.argmin(corners))
    return tuple(int(v) for v in (*corners[start:], *corners[:start]))


def match_new_vertices(done):
    """The number in the cut of every vertex of the mesh that is new, by its number in the mesh, found by position."""
    old, cut = done.before, done.before.cut
    positions = old.values["positions"][1].astype(np.float64)
    count = len(positions)
    new_of = {}
    for row, (a, b) in enumerate(cut.vertex_edges):
        if a >= 0:
            place = (1 - cut.vertex_parameters[row]) * positions[a] + cut.vertex_parameters[row] * positions[b]
        else:
            place = cut.vertex_barycentric[row] @ positions[cut.triangles[cut.vertex_triangles[row]]]
        distances = np.linalg.norm(done.values["positions"][1][count:] - place, axis=1)
        assert distances.min() < 1e-6
        new_of[count + int(distances.argmin())] = count + row
    assert len(new_of) == len(done.values["positions"][1]) - count
    return new_of


def list_corners(faces):
    row = 0
    for face, corners in enumerate(faces):
        for vertex in corners:
            yield face, vertex, row
            row += 1


def find_parents(done):
    """The old face of every face, by what lies under its centre."""
    parents = []
    for corners in done.faces:
        x, y = done.values["positions"][1][list(corners), :2].mean(axis=0)
        parents.append(int(y) * COLUMNS + int(x))
    return parents


def find_whole_edge(done, key):
    """The old edge that an edge is a part of; None for one that is new."""
    old, cut = done.before, done.before.cut
    if key in old.edges:
        return key
    new_of = match_new_vertices(done)
    count = len(old.values["positions"][1])
    sides = []
    for vertex in key:
        if vertex < count:
            sides.append({e for e in old.edges if vertex in e})
        else:
            ends = cut.vertex_edges[new_of[vertex] - count]
            sides.append({tuple(sorted(int(v) for v in ends))})
    shared = sides[0] & sides[1] & set(old.edges)
    return shared.pop() if len(shared) == 1 else None
