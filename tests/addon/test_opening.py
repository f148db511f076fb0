"""A mesh is opened for drawing without waiting: which one the mouse is on, progress, refusals, changes meanwhile."""

import threading
from types import SimpleNamespace

import numpy as np
import pytest

import bpy

import bmesh

from blender_scenes import add_grid, add_mesh_object, count_data, enter_edit_mode

DOWN = (np.array([0.3, 0.4, 50.0]), np.array([0.0, 0.0, -1.0]))
ASIDE = (np.array([900.0, 0.4, 50.0]), np.array([0.0, 0.0, -1.0]))


@pytest.fixture
def tool(scene):
    from bl_ext.user_default.smooth_polylines import errors, surface
    from bl_ext.user_default.smooth_polylines.draw_tool import canvas, drawing, opening, view

    surface.forget_surfaces()
    return SimpleNamespace(surface=surface, opening=opening, errors=errors, view=view, drawing=drawing, canvas=canvas)


def list_all(*objects):
    bpy.context.view_layer.update()
    return [(50.0 - o.location.z - 1e-6, o) for o in objects]


@pytest.fixture
def stack(tool):
    """Three grids over each other, the uppermost last."""
    grids = [add_grid(3, 3, name=f"Grid {k}") for k in range(3)]
    for k, grid in enumerate(grids):
        grid.location.z = 2.0 * k
    return grids


def test_the_first_that_the_ray_meets_is_chosen_and_those_behind_are_not_opened(tool, stack):
    opening = tool.opening.Opening(list_all(*reversed(stack)), DOWN)
    assert opening.go_on(bpy.context, 5.0)
    assert (opening.chosen, opening.source) == ("Grid 2", "BASE")
    assert opening.distance == pytest.approx(46.0)
    assert len(tool.surface._surfaces) == 1


def test_a_box_that_is_met_but_not_its_mesh_is_looked_through(tool, stack):
    stack[2].data.polygons[0].hide = True
    opening = tool.opening.Opening(list_all(*reversed(stack)), DOWN)
    assert opening.go_on(bpy.context, 5.0)
    assert opening.chosen == "Grid 1"
    opening = tool.opening.Opening(list_all(*reversed(stack)), ASIDE)
    assert opening.go_on(bpy.context, 5.0)
    assert (opening.chosen, opening.surface) == ("", None)


def test_what_is_seen_is_what_modifiers_make(tool):
    grid = add_grid(3, 3)
    grid.modifiers.new("Subdivision", "SUBSURF").levels = 1
    for wish, source, count in (("SEEN", "EVALUATED", 72), ("BASE", "BASE", 18), ("EVALUATED", "EVALUATED", 72)):
        opening = tool.opening.Opening(list_all(grid), DOWN, wish)
        assert opening.go_on(bpy.context, 5.0)
        assert opening.source == source
        assert len(opening.surface.arrays.triangles) == count
    enter_edit_mode(grid)
    opening = tool.opening.Opening(list_all(grid), DOWN)
    assert opening.go_on(bpy.context, 5.0)
    assert opening.source == "BASE"


def test_of_several_meshes_in_edit_mode_the_one_under_the_mouse(tool, stack):
    bpy.ops.object.select_all(action="DESELECT")
    for grid in stack[:2]:
        grid.select_set(True)
    enter_edit_mode(stack[0])
    candidates = tool.view.list_candidates(bpy.context, DOWN)
    assert sorted(o.name for _, o in candidates) == ["Grid 0", "Grid 1"]  # Grid 2 is not edited
    opening = tool.opening.Opening(candidates, DOWN)
    assert opening.go_on(bpy.context, 5.0)
    assert opening.chosen == "Grid 1"


def test_what_takes_long_shows_progress_and_can_be_left(tool, stack, monkeypatch):
    gate, make_ready = threading.Event(), tool.surface.make_ready

    def wait(reading, with_tree=False):
        gate.wait(30.0)
        return make_ready(reading, with_tree)

    monkeypatch.setattr(tool.surface, "make_ready", wait)
    before = count_data()
    opening = tool.opening.Opening(list_all(stack[2]), DOWN)
    left = tool.opening.Opening(list_all(stack[1]), DOWN)
    for one in (opening, left):
        assert not one.go_on(bpy.context, 0.0)
        assert not one.go_on(bpy.context, 0.0)
        assert "18 triangles" in one.describe()
        assert 0.0 <= one.measure_progress() < 1.0
        assert one.chosen == ""
    gate.set()
    assert opening.go_on(bpy.context, 10.0)
    assert opening.chosen == "Grid 2"
    left.thread.join(10.0)  # nobody asks it again
    assert count_data() == before
    assert len(tool.surface._surfaces) == 1


def test_an_object_that_goes_while_another_is_opened_is_passed_over(tool, stack):
    opening = tool.opening.Opening(list_all(*reversed(stack)), DOWN)
    bpy.data.objects.remove(stack[2])
    assert opening.go_on(bpy.context, 5.0)
    assert opening.chosen == "Grid 1"


def test_linked_data_is_refused_with_the_reason(tool, tmp_path):
    grid = add_grid(3, 3)
    library = tmp_path / "library.blend"
    bpy.data.libraries.write(str(library), {grid})
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    with bpy.data.libraries.load(str(library), link=True) as (_, wanted):
        wanted.objects = ["Grid"]
    (linked,) = wanted.objects
    bpy.context.scene.collection.objects.link(linked)
    opening = tool.opening.Opening(list_all(linked), DOWN)
    with pytest.raises(tool.errors.ObjectError, match=r"linked from .*library\.blend.*make it local"):
        opening.go_on(bpy.context, 5.0)
    # One that lies behind it is no way out; one before it is.
    near = add_grid(3, 3, name="Near")
    near.location.z = 1.0
    opening = tool.opening.Opening(list_all(near, linked), DOWN)
    assert opening.go_on(bpy.context, 5.0)
    assert opening.chosen == "Near"


def test_meshes_that_cannot_be_opened_are_said_where_nothing_else_is_hit(tool):
    edges = add_mesh_object("Edges", [(0, 0, 3), (1, 1, 3)], [])
    broken = add_mesh_object("Broken", [(0, 0, 2), (1, 0, float("nan")), (1, 1, 2)], [(0, 1, 2)])
    for objects, message in (([edges], "no visible faces"), ([edges, broken], "nan|finite")):
        opening = tool.opening.Opening([(0.0, o) for o in objects], DOWN)
        with pytest.raises(Exception, match=message):
            opening.go_on(bpy.context, 5.0)
    grid = add_grid(3, 3)
    opening = tool.opening.Opening([(0.0, edges), (0.0, broken), (1.0, grid)], DOWN)
    assert opening.go_on(bpy.context, 5.0)
    assert opening.chosen == "Grid"


def make_picks(tool, opened, count=4):
    triangles = np.linspace(0, len(opened.arrays.triangles) - 1, count).astype(int)
    return [tool.canvas.make_pick(opened, triangle, (0.2, 0.3, 0.5)) for triangle in triangles]


def test_picks_go_with_a_mesh_that_moves_or_is_deformed(tool):
    grid = add_grid(6, 6)
    before = tool.surface.open_surface(bpy.context, grid)
    picks = make_picks(tool, before)
    grid.location.x = 3.0
    for vertex in grid.data.vertices:
        vertex.co.z = vertex.co.x
    now = tool.surface.open_surface(bpy.context, grid)
    move = tool.drawing.make_mover(before, now)
    for pick in picks:
        x, y, _ = pick.place
        np.testing.assert_allclose(move(pick).place, (x + 3.0, y, x), atol=1e-6)


def test_picks_are_found_again_by_position_on_a_rebuilt_mesh(tool):
    grid = add_grid(6, 6)
    grid.rotation_euler.x = 0.7
    before = tool.surface.open_surface(bpy.context, grid)
    picks = make_picks(tool, before)
    edited = bmesh.new()
    edited.from_mesh(grid.data)
    bmesh.ops.subdivide_edges(edited, edges=edited.edges[:20], cuts=2, use_grid_fill=True)
    edited.to_mesh(grid.data)
    edited.free()
    grid.location.y = 2.0
    now = tool.surface.open_surface(bpy.context, grid)
    move = tool.drawing.make_mover(before, now)
    for pick in picks:
        np.testing.assert_allclose(move(pick).place, np.array(pick.place) + np.array([0, 2, 0]), atol=1e-6)


def test_lengths_are_told_in_the_scenes_units(tool):
    units = bpy.context.scene.unit_settings
    units.system = "METRIC"
    assert tool.drawing.describe_length(units, 0.5) == "50 cm"
    units.system = "NONE"
    assert tool.drawing.describe_length(units, 0.123456) == "0.1235"
