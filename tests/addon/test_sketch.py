"""The draw tool without a window: steps of a sketch, what lies near what, and where a script is told it belongs."""

import itertools
from types import SimpleNamespace

import numpy as np
import pytest

import bpy

from blender_scenes import SUZANNE_PICKS, add_grid, get_curves, get_spline_points


@pytest.fixture
def tool(extension):
    from bl_ext.user_default.smooth_polylines.draw_tool import sketch

    return sketch


def make_pick(tool, x):
    return tool.SketchPick(int(x), (1.0, 0.0, 0.0), (float(x), 0.0, 0.0))


def places(sketch):
    return [pick.place[0] for pick in sketch.state.picks]


def add(tool, sketch, x):
    sketch.hold()
    sketch.change(picks=(*sketch.state.picks, make_pick(tool, x)))
    sketch.let_go()


def test_steps_go_back_and_forward(tool):
    sketch = tool.Sketch()
    for x in range(3):
        add(tool, sketch, x)
    sketch.remove(0)
    assert places(sketch) == [1, 2]
    for expected in ([0, 1, 2], [0, 1], [0], []):
        assert sketch.undo()
        assert places(sketch) == expected
    assert not sketch.undo()
    while sketch.redo():
        pass
    assert places(sketch) == [1, 2]


def test_a_step_called_off_leaves_what_was_undone(tool):
    sketch = tool.Sketch()
    add(tool, sketch, 0)
    add(tool, sketch, 1)
    sketch.undo()
    sketch.hold()
    sketch.change(picks=())
    sketch.call_off()
    assert places(sketch) == [0]
    assert sketch.redo()
    sketch.undo()
    add(tool, sketch, 7)  # a new step forgets it
    assert not sketch.redo()
    assert places(sketch) == [0, 7]


def test_picks_move_with_their_surface_in_every_step(tool):
    sketch = tool.Sketch()
    for x in range(3):
        add(tool, sketch, x)
    sketch.undo()
    sketch.move_picks(lambda pick: make_pick(tool, pick.place[0] + 10))
    assert places(sketch) == [10, 11]
    sketch.redo()
    assert places(sketch) == [10, 11, 12]
    sketch.undo()
    sketch.undo()
    assert places(sketch) == [10]


def test_a_loop_needs_three_picks_and_opens_when_they_go(tool):
    sketch = tool.Sketch()
    for x in range(2):
        add(tool, sketch, x)
    assert sketch.has_line()
    assert not sketch.toggle_closed()
    add(tool, sketch, 2)
    assert sketch.toggle_closed()
    sketch.remove(1)
    assert not sketch.state.is_closed
    assert sketch.has_line()


def test_filters_come_round_and_detail_grows_by_steps(tool):
    sketch = tool.Sketch()
    seen = []
    for _ in tool.FILTERS:
        seen.append(sketch.state.filter)
        sketch.cycle_filter()
    assert sorted(seen) == ["CUBIC", "FAIR", "GEODESIC", "LINEAR"]
    assert sketch.state.filter == seen[0]
    sketch.scale_detail(1, 2.0)
    assert sketch.state.detail_size == pytest.approx(2.0 * tool.DETAIL_STEP)
    sketch.scale_detail(-1, 2.0)
    assert sketch.state.detail_size == pytest.approx(2.0)


def test_where_an_inserted_pick_belongs(tool):
    from bl_ext.user_default.smooth_polylines.draw_tool import view

    points = np.array([[x, 0.0, 0.0] for x in np.linspace(0, 10, 41)])
    picks = tuple(make_pick(tool, x) for x in (0, 4, 10))
    found = [view.find_leg(points, False, picks, (x, 0.5, 0.0)) for x in (-1.0, 2.0, 3.9, 4.3, 9.0, 11.0)]
    assert found == [1, 1, 1, 2, 2, 2]
    # On the way back of a loop: at the end.
    corner = np.array([[0.0, 0, 0], [10, 0, 0], [10, 10, 0]])
    picks = tuple(tool.SketchPick(0, (1.0, 0.0, 0.0), tuple(place)) for place in corner.tolist())
    assert [view.find_leg(corner, True, picks, place) for place in ((5, 1, 0), (9, 5, 0), (4, 5, 0))] == [1, 2, 3]


def test_snapping_offers_vertices_and_true_edges_only(scene, tool):
    from bl_ext.user_default.smooth_polylines import surface
    from bl_ext.user_default.smooth_polylines.draw_tool import view

    opened = surface.open_surface(bpy.context, add_grid(2, 2))
    for triangle in range(len(opened.arrays.triangles)):
        snaps = view.list_snaps(opened, triangle)
        assert len(snaps) == 5  # three vertices, two sides of the quad; not its diagonal
        found = [view.place_of(opened, triangle, weights) for weights in snaps]
        assert all(float(2 * x).is_integer() and float(2 * y).is_integer() for x, y, _ in found)
        assert all(float(x).is_integer() or float(y).is_integer() for x, y, _ in found)


def test_panels_over_the_view_are_not_the_view(extension):
    from bl_ext.user_default.smooth_polylines.draw_tool import view

    def make_region(x, y, width, height):
        return SimpleNamespace(x=x, y=y, width=width, height=height)

    region, toolbar, hidden = make_region(0, 0, 800, 600), make_region(0, 100, 60, 400), make_region(300, 0, 1, 600)
    area = SimpleNamespace(regions=[toolbar, region, hidden])
    places = [(400, 300), (30, 300), (30, 50), (300, 10), (800, 300), (-1, 5)]
    assert [view.is_over_view(area, region, *place) for place in places] == [True, False, True, True, False, False]


@pytest.mark.parametrize(("axes", "count"), [((0, 0, 0), 0), ((1, 0, 0), 1), ((1, 1, 0), 3), ((1, 1, 1), 7)])
def test_mirrored_picks_lie_across_the_objects_planes(scene, tool, axes, count):
    from bl_ext.user_default.smooth_polylines import surface
    from bl_ext.user_default.smooth_polylines.draw_tool import view

    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=3, location=(1, 2, 3), rotation=(0.3, 0.5, 0.7), scale=(1, 2, 1))
    ball = bpy.context.object
    opened = surface.open_surface(bpy.context, ball)
    picks = []
    for triangle in (5, 40, 77):
        weights = (0.2, 0.3, 0.5)
        picks.append(tool.SketchPick(triangle, weights, tuple(view.place_of(opened, triangle, weights))))
    mirrored = view.mirror_picks(opened, tuple(picks), tuple(map(bool, axes)))
    assert len(mirrored) == count
    inverse = np.linalg.inv(np.array(ball.matrix_world))

    def to_local(place):
        return inverse[:3, :3] @ place + inverse[:3, 3]

    signs = [sign for sign in itertools.product(*[(1, -1) if is_on else (1,) for is_on in axes]) if min(sign) < 0]
    for there in mirrored:
        places = [to_local(view.place_of(opened, point.triangle, point.barycentric)) for point in there]
        here = [to_local(pick.place) for pick in picks]
        assert any(np.allclose(places, np.array(here) * np.array(sign), atol=0.01) for sign in signs)


def test_other_picks_for_a_curve_that_remembers(suzanne):
    from bl_ext.user_default.smooth_polylines import session

    bpy.ops.object.mode_set(mode="OBJECT")
    curve_object = session.add_polyline(bpy.context, suzanne, SUZANNE_PICKS, filter="fair", pinned="all").curve_object
    expected = session.add_polyline(bpy.context, suzanne, SUZANNE_PICKS[:3], filter="linear", pinned="all").curve_object
    session.replace_picks(bpy.context, curve_object.data, SUZANNE_PICKS[:3], filter="linear", pinned="all")
    np.testing.assert_array_equal(get_spline_points(curve_object), get_spline_points(expected))
    assert curve_object.data.smooth_polyline.filter == "LINEAR"
    assert len(get_curves()) == 2


def test_without_a_3d_view_the_operator_says_where_it_belongs(suzanne):
    with pytest.raises(RuntimeError, match="3D view"):
        bpy.ops.view3d.smooth_polyline_draw("INVOKE_DEFAULT")
