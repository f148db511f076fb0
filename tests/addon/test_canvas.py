"""The surface under the mouse without a window: exact picks and strokes on every kind of object and view."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

import bpy

import mathutils

from blender_scenes import add_grid, add_mesh_object, count_data, measure_distances, read_mesh_slowly

SIZE = (800, 600)


def make_view(eye, target, *, is_perspective=True, width=4.0):
    """A region and its view, as Blender's: looking from `eye` to `target`; a parallel one shows `width`."""
    towards = mathutils.Vector(target) - mathutils.Vector(eye)
    rotation = towards.to_track_quat("-Z", "Y").to_matrix().to_4x4()
    to_world = mathutils.Matrix.Translation(eye) @ rotation
    view = to_world.inverted()
    aspect, near, far = SIZE[0] / SIZE[1], 0.1, 1000.0
    if is_perspective:
        zoom = 1.5
        window = mathutils.Matrix(
            (
                (zoom, 0, 0, 0),
                (0, zoom * aspect, 0, 0),
                (0, 0, -(far + near) / (far - near), -2 * far * near / (far - near)),
                (0, 0, -1, 0),
            )
        )
    else:
        scale = 2 / width
        window = mathutils.Matrix(((scale, 0, 0, 0), (0, scale * aspect, 0, 0), (0, 0, -1 / far, 0), (0, 0, 0, 1)))
    region_3d = SimpleNamespace(
        view_matrix=view,
        window_matrix=window,
        perspective_matrix=window @ view,
        is_perspective=is_perspective,
        view_perspective="PERSP" if is_perspective else "ORTHO",
        view_distance=towards.length,
    )
    return SimpleNamespace(width=SIZE[0], height=SIZE[1], x=0, y=0), region_3d


@pytest.fixture
def tool(scene):
    from bl_ext.user_default.smooth_polylines import surface
    from bl_ext.user_default.smooth_polylines.draw_tool import canvas, gestures, sketch, stroke, view

    return SimpleNamespace(surface=surface, canvas=canvas, gestures=gestures, sketch=sketch, stroke=stroke, view=view)


def make_canvas(tool, mesh_object, region, region_3d, source="BASE"):
    preferences = SimpleNamespace(system=SimpleNamespace(ui_scale=1.0), inputs=SimpleNamespace(drag_threshold_mouse=3))
    context = SimpleNamespace(region=region, region_data=region_3d, preferences=preferences)
    canvas = tool.canvas.SurfaceCanvas(context, tool.sketch.Sketch())
    canvas.opened = tool.surface.open_surface(bpy.context, mesh_object, source=source)
    canvas.make_points = lambda picks: canvas.opened.library_mesh.polyline(picks, filter="fair", pinned="all").points
    return canvas


def look_at(tool, canvas, mouse):
    ray = tool.view.find_ray(canvas.region, canvas.region_3d, mouse)
    return tool.gestures.Input("MOUSEMOVE", mouse=mouse, ray=ray)


def shear(mesh_object):
    parent = bpy.data.objects.new("Parent", None)
    bpy.context.scene.collection.objects.link(parent)
    parent.scale = (1.4, 0.7, 1.0)
    mesh_object.parent = parent
    mesh_object.rotation_euler = (0.2, 0.3, 0.4)


def subdivide(mesh_object):
    mesh_object.modifiers.new("Subdivision", "SUBSURF").levels = 2


def add_multires(mesh_object):
    mesh_object.modifiers.new("Multires", "MULTIRES")
    bpy.context.view_layer.objects.active = mesh_object
    for _ in range(2):
        bpy.ops.object.multires_subdivide(modifier="Multires", mode="CATMULL_CLARK")


def make_ngons(mesh_object):
    decimate = mesh_object.modifiers.new("Decimate", "DECIMATE")
    decimate.decimate_type = "DISSOLVE"
    decimate.angle_limit = 0.3
    bpy.context.view_layer.objects.active = mesh_object
    bpy.ops.object.modifier_apply(modifier="Decimate")
    assert max(len(polygon.vertices) for polygon in mesh_object.data.polygons) > 4


KINDS = {
    "quads": (lambda _: None, "BASE"),
    "ngons": (make_ngons, "BASE"),
    "scaled": (lambda o: setattr(o, "scale", (1.5, 0.6, -1.2)), "BASE"),
    "sheared": (shear, "BASE"),
    "subdivision": (subdivide, "EVALUATED"),
    "subdivision_base": (subdivide, "BASE"),
    "multires": (add_multires, "EVALUATED"),
    "multires_base": (add_multires, "BASE"),
}
VIEWS = {
    "perspective": {},
    "parallel": {"is_perspective": False},
    "parallel_from_inside": {"is_perspective": False, "eye": (0.0, 0.1, 0.0)},
}


@pytest.mark.parametrize("view_name", VIEWS)
@pytest.mark.parametrize("kind", KINDS)
def test_a_pick_is_exactly_under_the_mouse_and_on_the_surface(tool, kind, view_name):
    bpy.ops.mesh.primitive_monkey_add()
    head = bpy.context.object
    change, source = KINDS[kind]
    change(head)
    view = {"eye": (0.3, -4.0, 0.5), "target": (0.0, 1.0, 0.0), **VIEWS[view_name]}
    canvas = make_canvas(tool, head, *make_view(**view), source)
    arrays = canvas.opened.arrays
    bpy.context.view_layer.update()
    graph = bpy.context.evaluated_depsgraph_get()
    shown = head.evaluated_get(graph).data if source == "EVALUATED" else head.data
    positions, triangles, _ = read_mesh_slowly(shown)
    matrix = np.array(head.matrix_world)
    world = positions @ matrix[:3, :3].T + matrix[:3, 3]
    assert len(arrays.triangles) == len(triangles)
    hits = 0
    for mouse in [(400 + dx, 300 + dy) for dx in (-110, -37, 0, 61, 93) for dy in (-70, -13, 44, 81)]:
        pick = canvas.find_pick(look_at(tool, canvas, mouse), False)
        if pick is None:
            continue
        hits += 1
        on_screen = tool.view.project(canvas.region, canvas.region_3d, pick.place)
        assert np.abs(on_screen - mouse).max() < 0.02
        assert measure_distances(np.array([pick.place]), world, triangles).max() < 1e-5
        # The first surface that the ray meets, by Blender's own search where it knows the mesh.
        if source == "EVALUATED" or kind in {"quads", "scaled", "sheared"}:
            origin, direction = tool.view.find_ray(canvas.region, canvas.region_3d, mouse)
            local = np.linalg.inv(matrix) @ np.append(origin, 1.0)
            towards = np.linalg.inv(matrix[:3, :3]) @ direction
            is_hit, place, _, _ = head.evaluated_get(graph).ray_cast(local[:3], towards)
            assert is_hit
            np.testing.assert_allclose((matrix @ np.append(np.array(place), 1.0))[:3], pick.place, atol=1e-2)
    assert hits >= 12


def test_snapping_goes_to_what_is_nearest_on_the_screen(tool):
    grid = add_grid(4, 4)
    canvas = make_canvas(tool, grid, *make_view((2, 2, 8), (2, 2, 0)))
    for wanted in ((1.0, 1.0, 0.0), (2.0, 1.5, 0.0), (2.5, 3.0, 0.0)):
        x, y = tool.view.project(canvas.region, canvas.region_3d, wanted)
        pick = canvas.find_pick(look_at(tool, canvas, (x + 5, y + 4)), True)
        np.testing.assert_allclose(pick.place, wanted, atol=1e-12)


def test_hidden_faces_are_looked_through(tool):
    near = add_mesh_object(
        "Two sheets",
        [(0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1), (0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)],
        [(0, 1, 2, 3), (4, 5, 6, 7)],
    )
    region, region_3d = make_view((0.5, 0.5, 5), (0.5, 0.5, 0))
    canvas = make_canvas(tool, near, region, region_3d)
    assert canvas.find_pick(look_at(tool, canvas, (400, 300)), False).place[2] == pytest.approx(1.0)
    near.data.polygons[0].hide = True
    canvas = make_canvas(tool, near, region, region_3d)
    assert canvas.find_pick(look_at(tool, canvas, (400, 300)), False).place[2] == pytest.approx(0.0)


@pytest.mark.parametrize("is_perspective", [True, False])
def test_the_length_of_a_pixel(tool, is_perspective):
    region, region_3d = make_view((1, -6, 2), (0, 0, 0), is_perspective=is_perspective)
    places = np.array([(0.0, 0.0, 0.0), (0.5, 2.0, 0.3)])
    right = np.array(region_3d.view_matrix.inverted())[:3, 0]
    for place, pixel in zip(places, tool.view.measure_pixels(region, region_3d, places), strict=True):
        ends = [tool.view.project(region, region_3d, place + step * right) for step in (0.0, 100 * pixel)]
        assert np.linalg.norm(ends[1] - ends[0]) == pytest.approx(100, rel=1e-3)


def draw(tool, canvas, places):
    """Samples of a stroke through places of the screen; those beside the surface are missing."""
    found = [canvas.find_pick(look_at(tool, canvas, mouse), False) for mouse in places]
    return [pick for pick in found if pick is not None]


def measure_off_stroke(tool, canvas, points, mouse_places):
    """Largest distance in pixels of a place of the stroke to the line as it is seen."""
    seen = np.array([tool.view.project(canvas.region, canvas.region_3d, p) for p in points])
    flat = np.column_stack([np.array(mouse_places), np.zeros(len(mouse_places))])
    return tool.stroke.measure_distances(flat, np.column_stack([seen, np.zeros(len(seen))])).max()


@pytest.mark.parametrize("filter_", ["fair", "geodesic", "linear", "cubic"])
def test_a_stroke_is_kept_to_by_few_picks_with_every_filter(tool, filter_):
    bpy.ops.mesh.primitive_uv_sphere_add(segments=48, ring_count=24)
    ball = bpy.context.object
    canvas = make_canvas(tool, ball, *make_view((0, -3.6, 0.3), (0, 0, 0)))
    options = {"filter": filter_, "pinned": "all"} | ({"threshold": 1e-2} if filter_ == "cubic" else {})
    canvas.make_points = lambda picks: canvas.opened.library_mesh.polyline(picks, **options).points
    mouse_places = [(270 + k, 300 + 60 * math.sin(k / 40)) for k in range(0, 260, 2)]
    samples = draw(tool, canvas, mouse_places)
    assert len(samples) == len(mouse_places)
    picks = canvas.fit_stroke((), samples)
    assert (picks[0], picks[-1]) == (samples[0], samples[-1])
    assert len(picks) < (14 if filter_ in {"fair", "cubic"} else 40)
    points = canvas.make_points([(pick.triangle, pick.barycentric) for pick in picks])
    assert measure_off_stroke(tool, canvas, points, mouse_places) < tool.canvas.STROKE_TOLERANCE + 1.5


def test_a_trembling_stroke_becomes_a_smooth_line(tool):
    bpy.ops.mesh.primitive_uv_sphere_add(segments=48, ring_count=24)
    canvas = make_canvas(tool, bpy.context.object, *make_view((0, -3.6, 0.3), (0, 0, 0)))
    rng = np.random.default_rng(4)
    mouse_places = [(270 + k, 300 + 0.1 * k + rng.normal(0, 0.7)) for k in range(0, 260, 2)]
    picks = canvas.fit_stroke((), draw(tool, canvas, mouse_places))
    assert len(picks) <= 6
    points = canvas.make_points([(pick.triangle, pick.barycentric) for pick in picks])
    seen = np.array([tool.view.project(canvas.region, canvas.region_3d, p) for p in points])
    steps = np.diff(seen, axis=0)
    headings = np.unwrap(np.arctan2(steps[:, 1], steps[:, 0]))
    assert np.abs(np.diff(headings)).sum() < 0.8  # radians in all; that of the stroke is dozens


def test_a_stroke_goes_the_way_it_was_drawn_and_not_the_shortest(tool):
    bpy.ops.mesh.primitive_torus_add(major_segments=64, minor_segments=24)
    canvas = make_canvas(tool, bpy.context.object, *make_view((0, 0, 6), (0, 0, 0)))
    angles = np.linspace(-0.4, 1.5 * math.pi, 120)
    centre = np.array([tool.view.project(canvas.region, canvas.region_3d, (0, 0, 0.25))]).ravel()
    edge = tool.view.project(canvas.region, canvas.region_3d, (1, 0, 0.25))
    mouse_places = [centre + (edge[0] - centre[0]) * np.array([math.cos(a), math.sin(a)]) for a in angles]
    samples = draw(tool, canvas, mouse_places)
    assert len(samples) == len(mouse_places)
    picks = canvas.fit_stroke((), samples)
    points = canvas.make_points([(pick.triangle, pick.barycentric) for pick in picks])
    assert measure_off_stroke(tool, canvas, points, mouse_places) < tool.canvas.STROKE_TOLERANCE + 1.5
    assert len(picks) < 20


def test_a_stroke_leaves_out_other_parts_and_gaps(tool):
    bpy.ops.mesh.primitive_monkey_add()  # its eyes are parts of their own
    head = bpy.context.object
    subdivide(head)
    canvas = make_canvas(tool, head, *make_view((0, -6, 0.3), (0, 0, 0.2)), "EVALUATED")
    parts = canvas.opened.library_mesh.triangle_parts()
    start = tool.view.project(canvas.region, canvas.region_3d, (-0.85, -0.3, 0.3))
    end = tool.view.project(canvas.region, canvas.region_3d, (0.85, -0.3, 0.3))
    samples = draw(tool, canvas, [start + (end - start) * t for t in np.linspace(-0.6, 1.6, 200)])
    assert len(samples) < 200
    assert len({int(parts[sample.triangle]) for sample in samples}) > 1, "the stroke met no eye: the test shows nothing"
    picks = canvas.fit_stroke((), samples)
    assert {int(parts[pick.triangle]) for pick in picks} == {int(parts[samples[0].triangle])}
    assert len(canvas.make_points([(pick.triangle, pick.barycentric) for pick in picks])) > len(picks)


def test_a_stroke_that_no_line_can_follow_keeps_its_picks(tool):
    two = add_mesh_object(
        "Bow tie",
        [(0, 0, 0), (2, 0, 0), (1, 1, 0), (0, 2, 0), (2, 2, 0)],
        [(0, 1, 2), (2, 4, 3), (1, 0, 2), (0, 2, 1)],
    )
    canvas = make_canvas(tool, two, *make_view((1, 1, 6), (1, 1, 0)))
    canvas.choose_connected = lambda samples: samples
    places = [tool.view.project(canvas.region, canvas.region_3d, (1, y, 0)) for y in np.linspace(0.2, 1.8, 40)]
    picks = canvas.fit_stroke((), draw(tool, canvas, places))
    assert len(picks) >= 2


def test_boxes_say_which_objects_may_be_under_the_mouse(tool):
    grid, far = add_grid(2, 2, name="Near"), add_grid(2, 2, name="Far")
    far.location.z, far.rotation_euler.x = -3, 0.2
    aside = add_grid(2, 2, name="Aside")
    aside.location.x = 50
    flat = add_grid(2, 2, name="Flat")
    flat.scale.z = 0.0
    hidden = add_grid(2, 2, name="Hidden")
    hidden.hide_set(True)
    bpy.context.view_layer.update()
    space = SimpleNamespace()
    ray = (np.array([1.0, 1.0, 5.0]), np.array([0.0, 0.0, -1.0]))
    context = SimpleNamespace(
        mode="OBJECT",
        space_data=space,
        evaluated_depsgraph_get=bpy.context.evaluated_depsgraph_get,
        visible_objects=[
            SimpleNamespace(
                name=o.name,
                type=o.type,
                matrix_world=o.matrix_world,
                evaluated_get=o.evaluated_get,
                # Near is left out of the local view of the second look.
                visible_get=lambda viewport, o=o: o.name not in getattr(viewport, "left_out", ()),
            )
            for o in bpy.context.visible_objects
        ],
    )
    found = tool.view.list_candidates(context, ray)
    assert [o.name for _, o in found] == ["Near", "Far"]
    assert found[0][0] == pytest.approx(5.0, abs=1e-4)
    space.left_out = ("Near",)
    assert [o.name for _, o in tool.view.list_candidates(context, ray)] == ["Far"]
    assert count_data()["objects"] == 5
    assert grid.name == "Near"


@pytest.mark.parametrize("closed", [False, True])
def test_a_dragged_pick_gives_the_line_that_a_fresh_one_would_be(tool, closed):
    from bl_ext.user_default.smooth_polylines.draw_tool import drawing as drawings

    bpy.ops.mesh.primitive_uv_sphere_add(segments=48, ring_count=24)
    canvas = make_canvas(tool, bpy.context.object, *make_view((0, -3.6, 0.3), (0, 0, 0)))
    picks = draw(tool, canvas, [(300, 260), (360, 330), (440, 320), (500, 280)])
    made = drawings.Drawing.__new__(drawings.Drawing)
    made.sketch, made.canvas, made.options, made.made_with = canvas.sketch, canvas, {}, {}
    made.mirror, made.curve_name, made.lines = (True, False, False), "", []
    made.gestures = SimpleNamespace(mode=tool.gestures.Mode.IDLE)
    canvas.sketch.state = tool.sketch.SketchState(tuple(picks), closed, "GEODESIC")
    made.make_lines([])
    made.gestures.mode = tool.gestures.Mode.DRAGGING
    for mouse in ((362, 335), (366, 345), (371, 352)):
        (moved,) = draw(tool, canvas, [mouse])
        canvas.sketch.change(picks=(picks[0], moved, *picks[2:]))
        before, made.lines = made.lines, []
        made.make_lines(before)
        assert len(made.lines) == 2  # and its mirror
        for line, its_picks in zip(made.lines, [made.list_picks(), *made.list_mirrored_picks()], strict=True):
            fresh = canvas.opened.library_mesh.polyline(its_picks, closed=closed, filter="geodesic", pinned="all")
            np.testing.assert_array_equal(line.points, fresh.points)
    assert closed or made.lines[0].report.kept_legs == 1
    # Other options: nothing can be kept.
    canvas.sketch.cycle_filter()
    before, made.lines = made.lines, []
    made.make_lines(before)
    fresh = canvas.opened.library_mesh.polyline(made.list_picks(), closed=closed, filter="linear", pinned="all")
    np.testing.assert_array_equal(made.lines[0].points, fresh.points)
