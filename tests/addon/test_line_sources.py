"""Where lines come from: splines of all kinds, hair curves, grease pencil, points, curves that remember; refusals."""

import numpy as np
import pytest

import bpy

from mathutils import Matrix
from mathutils.geometry import interpolate_bezier

from blender_scenes import add_grid, count_data, measure_distances

MATRIX = Matrix.Translation((0.5, -0.25, 0.0)) @ Matrix.Diagonal((1.5, 0.75, 1.0, 1.0))


@pytest.fixture
def sources(extension):
    from bl_ext.user_default.smooth_polylines.seams import line_sources, strokes

    return line_sources, strokes


def add_curve(name="Curve", matrix=MATRIX):
    curve = bpy.data.curves.new(name, "CURVE")
    curve.dimensions = "3D"
    curve_object = bpy.data.objects.new(name, curve)
    curve_object.matrix_world = matrix
    bpy.context.scene.collection.objects.link(curve_object)
    bpy.context.view_layer.update()
    return curve_object


def add_spline(curve_object, points, closed=False, kind="POLY"):
    spline = curve_object.data.splines.new(kind)
    rows = spline.bezier_points if kind == "BEZIER" else spline.points
    rows.add(len(points) - 1)
    for row, point in zip(rows, points, strict=True):
        row.co = point if kind == "BEZIER" else (*point, 1.0)
        if kind == "BEZIER":
            row.handle_left_type = row.handle_right_type = "AUTO"
    spline.use_cyclic_u = closed
    return spline


def to_world(points, matrix=MATRIX):
    m = np.array(matrix)
    return np.asarray(points, dtype=np.float64) @ m[:3, :3].T + m[:3, 3]


OPEN = [(0.0, 0.0, 0.0), (1.0, 0.5, 0.0), (2.0, 0.0, 0.1)]
ROUND = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (1.0, 1.0, 0.0), (0.0, 1.0, 0.0)]


def test_poly_splines_are_their_points_whatever_shows_them(scene, sources):
    curve_object = add_curve()
    add_spline(curve_object, OPEN)
    add_spline(curve_object, ROUND, closed=True)
    add_spline(curve_object, OPEN[:1])
    add_spline(curve_object, OPEN[::-1])
    curve_object.data.bevel_depth, curve_object.data.use_fill_caps = 0.1, True
    curve_object.data.extrude = 0.2
    curve_object.modifiers.new("Subdivision", "SUBSURF")
    before = count_data()
    found = sources[1].read_strokes(bpy.context, curve_object)
    assert count_data() == before
    assert [s.closed for s in found] == [False, True, False]
    for stroke, points in zip(found, (OPEN, ROUND, OPEN[::-1]), strict=True):
        np.testing.assert_allclose(stroke.points, to_world(points), atol=1e-6)


def test_a_flat_filled_curve_is_its_outline(scene, sources):
    curve_object = add_curve()
    curve_object.data.dimensions, curve_object.data.fill_mode = "2D", "BOTH"
    add_spline(curve_object, ROUND, closed=True)
    (found,) = sources[1].read_strokes(bpy.context, curve_object)
    assert found.closed
    np.testing.assert_allclose(found.points, to_world(ROUND), atol=1e-6)


def test_bezier_splines_are_followed_as_they_are_seen(scene, sources):
    curve_object = add_curve()
    spline = add_spline(curve_object, OPEN, kind="BEZIER")
    bpy.context.view_layer.update()
    (found,) = sources[1].read_strokes(bpy.context, curve_object)
    a, b, c = spline.bezier_points
    steps = curve_object.data.resolution_u + 1
    expected = [tuple(p) for p in interpolate_bezier(a.co, a.handle_right, b.handle_left, b.co, steps)]
    expected += [tuple(p) for p in interpolate_bezier(b.co, b.handle_right, c.handle_left, c.co, steps)][1:]
    np.testing.assert_allclose(found.points, to_world(expected), atol=1e-5)


def test_nurbs_circle_is_closed_and_round(scene, sources):
    bpy.ops.curve.primitive_nurbs_circle_add(radius=2.0)
    (found,) = sources[1].read_strokes(bpy.context, bpy.context.object)
    assert found.closed
    np.testing.assert_allclose(np.linalg.norm(found.points, axis=1), 2.0, atol=0.02)


def test_hair_curves_are_their_points(scene, sources):
    curves = bpy.data.hair_curves.new("Hair")
    curves.add_curves([3, 2])
    curves.points.foreach_set("position", np.array([*OPEN, *ROUND[:2]], dtype=np.float32).ravel())
    hair = bpy.data.objects.new("Hair", curves)
    hair.matrix_world = MATRIX
    scene.collection.objects.link(hair)
    bpy.context.view_layer.update()
    found = sources[1].read_strokes(bpy.context, hair)
    assert [len(s.points) for s in found] == [3, 2]
    np.testing.assert_allclose(found[0].points, to_world(OPEN), atol=1e-6)


def test_a_mesh_of_edges_is_its_chains(scene, sources):
    mesh = bpy.data.meshes.new("Edges")
    places = [*OPEN, *[(x, y, 1.0) for x, y, _ in ROUND], (2.0, 2.0, 0.0)]
    # An open chain out of order with a branch at its middle, and a ring.
    mesh.from_pydata(places, [(2, 1), (0, 1), (1, 7), (4, 3), (5, 4), (6, 5), (3, 6)], [])
    edges = bpy.data.objects.new("Edges", mesh)
    edges.matrix_world = MATRIX
    scene.collection.objects.link(edges)
    bpy.context.view_layer.update()
    assert sources[1].is_line(edges)
    found = sources[1].read_strokes(bpy.context, edges)
    assert sorted((len(s.points), s.closed) for s in found) == [(2, False), (2, False), (2, False), (4, True)]
    ring = next(s for s in found if s.closed)
    steps = np.linalg.norm(np.diff(np.vstack([ring.points, ring.points[:1]]), axis=0), axis=1)
    np.testing.assert_allclose(sorted(steps), [0.75, 0.75, 1.5, 1.5], atol=1e-6)


def add_pencil(lines):
    """Grease pencil, old or new, with one stroke for each (points, closed)."""
    if hasattr(bpy.data, "grease_pencils_v3") or bpy.app.version >= (4, 3):
        data = getattr(bpy.data, "grease_pencils_v3", bpy.data.grease_pencils).new("Pencil")
        drawing = data.layers.new("Layer").frames.new(1).drawing
        drawing.add_strokes([len(points) for points, _ in lines])
        for stroke, (points, closed) in zip(drawing.strokes, lines, strict=True):
            for row, point in zip(stroke.points, points, strict=True):
                row.position = point
            stroke.cyclic = closed
    else:
        data = bpy.data.grease_pencils.new("Pencil")
        frame = data.layers.new("Layer").frames.new(1)
        for points, closed in lines:
            stroke = frame.strokes.new()
            stroke.points.add(len(points))
            stroke.points.foreach_set("co", np.array(points, dtype=np.float32).ravel())
            stroke.use_cyclic = closed
    pencil = bpy.data.objects.new("Pencil", data)
    bpy.context.scene.collection.objects.link(pencil)
    return pencil


def test_grease_pencil_strokes_of_shown_layers(scene, sources):
    pencil = add_pencil([(OPEN, False), (ROUND, True)])
    pencil.matrix_world = MATRIX
    bpy.context.view_layer.update()
    found = sources[1].read_strokes(bpy.context, pencil)
    assert [s.closed for s in found] == [False, True]
    np.testing.assert_allclose(found[1].points, to_world(ROUND), atol=1e-6)
    pencil.data.layers[0].hide = True
    assert sources[1].read_strokes(bpy.context, pencil) == []


def test_drawn_lines_are_followed_on_the_surface(scene, sources):
    from bl_ext.user_default.smooth_polylines import surface

    grid = add_grid(8, 8)
    opened = surface.open_surface(bpy.context, grid)
    angle = np.linspace(0, 2 * np.pi, 40, endpoint=False)
    circle = np.column_stack([4 + 2.3 * np.cos(angle), 4 + 2.3 * np.sin(angle), np.full(40, 0.05)])
    curve_object = add_curve(matrix=Matrix.Identity(4))
    add_spline(curve_object, circle.tolist(), closed=True)
    for source in (curve_object, (circle, True)):
        (line,) = sources[0].make_lines(bpy.context, grid, [source], opened)
        assert line.closed
        # Through every drawn point, and nowhere off the polygon that they make.
        gaps = np.linalg.norm(line.points[None] - (circle * [1, 1, 0])[:, None], axis=2).min(axis=1)
        assert gaps.max() < 1e-6
        assert abs(line.length - 40 * 2 * 2.3 * np.sin(np.pi / 40)) < 1e-5
        assert measure_distances(line.points, opened.arrays.world_positions, opened.arrays.triangles).max() < 1e-12
    smooth = sources[0].make_lines(bpy.context, grid, [(circle, True)], opened, filter="fair", detail_size=0.3)
    assert abs(smooth[0].length - 2 * np.pi * 2.3) < 0.3  # chords of a coarse grid


def test_a_curve_that_remembers_is_made_again_and_not_projected(scene, sources):
    from bl_ext.user_default.smooth_polylines import session, surface

    grid = add_grid(8, 8)
    added = session.add_polyline(bpy.context, grid, [0, 37, 63], filter="fair", offset=0.3, pinned="all")
    opened = surface.open_surface(bpy.context, grid)
    (line,) = sources[0].make_lines(bpy.context, grid, [added.curve_object], opened)
    np.testing.assert_array_equal(line.points, added.line.points)


def test_refusals(scene, sources):
    from bl_ext.user_default.smooth_polylines import surface

    grid = add_grid(8, 8)
    opened = surface.open_surface(bpy.context, grid)
    far = np.array([(1.0, 1.0, 2.0), (3.0, 3.0, 2.0)])
    with pytest.raises(sources[0].ObjectError, match=r"The line is up to 2 away from the mesh, more than 0\.\d+"):
        sources[0].make_lines(bpy.context, grid, [far], opened)
    assert len(sources[0].make_lines(bpy.context, grid, [far], opened, max_distance=3.0)) == 1
    with pytest.raises(sources[0].ObjectError, match="no line to put into Grid"):
        sources[0].make_lines(bpy.context, grid, [], opened)
    with pytest.raises(sources[0].ObjectError, match="Curve has no line"):
        sources[0].make_lines(bpy.context, grid, [add_curve()], opened)
