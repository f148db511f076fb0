"""Islands of UV maps and their stretch: closed forms, Blender's unwrapping by seams, what is left as it was."""

import numpy as np
import pytest

import bpy

from blender_scenes import add_grid


@pytest.fixture
def unwrap(extension):
    from bl_ext.user_default.smooth_polylines.seams import unwrap

    return unwrap


def set_uvs(mesh, rule):
    layer = mesh.uv_layers.new(name="UV") if not mesh.uv_layers else mesh.uv_layers[0]
    for polygon in mesh.polygons:
        for loop in polygon.loop_indices:
            layer.data[loop].uv = rule(polygon, mesh.vertices[mesh.loops[loop].vertex_index].co)


@pytest.mark.parametrize(("u", "v"), [(1.0, 1.0), (0.1, 0.1), (2.0, 0.5), (-1.0, 3.0)])
def test_a_linear_map_stretches_angles_by_the_ratio_of_its_scales(scene, unwrap, u, v):
    grid = add_grid(4, 3)
    set_uvs(grid.data, lambda _, co: (u * co.x, v * co.y))
    (island,) = unwrap.measure_islands(grid.data).islands
    assert island.faces == 12
    assert island.area == pytest.approx(12)
    assert island.angle_stretch == pytest.approx(max(abs(u / v), abs(v / u)), rel=1e-5)
    assert island.worst_angle_stretch == pytest.approx(island.angle_stretch, rel=1e-4)
    assert island.area_stretch == pytest.approx(1.0, rel=1e-5)
    assert island.flipped == 0


def test_areas_are_measured_against_the_islands_own_scale(scene, unwrap):
    grid = add_grid(2, 1)
    # The left quad is shown twice as wide as the right one, in one island.
    set_uvs(grid.data, lambda _, co: (2 * min(co.x, 1) + max(co.x - 1, 0), co.y))
    found = unwrap.measure_islands(grid.data)
    (island,) = found.islands
    # Own scale 1.5: the left quad 4/3 too large, the right one 3/2 too small.
    np.testing.assert_allclose(found.face_area_stretch, [4 / 3, 3 / 2], rtol=1e-6)
    np.testing.assert_allclose(found.face_angle_stretch, [2, 1], rtol=1e-6)
    assert island.area_stretch == pytest.approx(17 / 12)
    assert island.worst_area_stretch == pytest.approx(1.5)


def test_islands_are_what_is_joined_in_the_map_and_flips_are_counted(scene, unwrap):
    grid = add_grid(4, 1)
    # The third quad lies mirrored, the fourth is torn off.
    set_uvs(grid.data, lambda polygon, co: (co.x if co.x <= 2 else 4 - co.x, co.y) if polygon.index < 3 else co[:2])
    found = unwrap.measure_islands(grid.data)
    assert found.face_islands.tolist() == [0, 0, 0, 1]
    assert [i.faces for i in found.islands] == [3, 1]
    assert [i.flipped for i in found.islands] == [2, 0]


def test_no_map_is_refused(scene, unwrap):
    grid = add_grid(2, 2)
    with pytest.raises(unwrap.ObjectError, match="no UV map"):
        unwrap.measure_islands(grid.data)


@pytest.mark.parametrize("is_editing", [False, True])
def test_seams_part_the_islands_and_all_else_is_as_it_was(scene, unwrap, is_editing):
    grid, other = add_grid(6, 4), add_grid(1, 1, name="Other")
    for edge in grid.data.edges:
        edge.use_seam = all(grid.data.vertices[v].co.x == 2 for v in edge.vertices)
        edge.select = False
    for vertex in grid.data.vertices:
        vertex.select = False
    for polygon in grid.data.polygons:
        polygon.select = polygon.index in (3, 9)
    for polygon in (3, 9):
        for vertex in grid.data.polygons[polygon].vertices:
            grid.data.vertices[vertex].select = True
    bpy.context.view_layer.objects.active = other
    if is_editing:
        bpy.context.view_layer.objects.active = grid
        grid.select_set(True)
        bpy.context.tool_settings.mesh_select_mode = (False, False, True)
        bpy.ops.object.mode_set(mode="EDIT")
    before = (bpy.context.mode, bpy.context.view_layer.objects.active)
    found = unwrap.unwrap_and_measure(bpy.context, grid)
    assert (bpy.context.mode, bpy.context.view_layer.objects.active) == before
    if is_editing:
        bpy.ops.object.mode_set(mode="OBJECT")
    assert [p.index for p in grid.data.polygons if p.select] == [3, 9]
    assert len(found.islands) == 2
    columns = np.arange(24) % 6
    np.testing.assert_array_equal(found.face_islands, np.where(columns < 2, 1, 0))
    for island in found.islands:
        # Flat pieces need no stretch.
        assert island.worst_angle_stretch == pytest.approx(1, abs=1e-3)
        assert island.worst_area_stretch == pytest.approx(1, abs=1e-3)
    if not is_editing:
        written = np.empty(24, dtype=np.float32)
        grid.data.attributes[unwrap.ANGLE_ATTRIBUTE].data.foreach_get("value", written)
        np.testing.assert_allclose(written, found.face_angle_stretch, rtol=1e-6)


def test_other_meshes_in_edit_mode_keep_their_maps_and_selection(scene, unwrap):
    grids = [add_grid(6, 4, name=name) for name in ("Mine", "Other")]
    for grid in grids:
        set_uvs(grid.data, lambda _, co: (0.01 * co.x, 0.03 * co.y))
        grid.data.polygons.foreach_set("select", np.arange(24) % 5 == 0)
        grid.select_set(True)
    bpy.context.view_layer.objects.active = grids[0]
    bpy.context.tool_settings.mesh_select_mode = (False, False, True)
    bpy.ops.object.mode_set(mode="EDIT")
    (island,) = unwrap.unwrap_and_measure(bpy.context, grids[0]).islands
    bpy.ops.object.mode_set(mode="OBJECT")
    assert island.angle_stretch == pytest.approx(1, abs=1e-3)
    assert unwrap.measure_islands(grids[1].data).islands[0].angle_stretch == pytest.approx(3, rel=1e-5)
    for grid in grids:
        assert [p.index for p in grid.data.polygons if p.select] == [0, 5, 10, 15, 20]


def test_what_cannot_be_unwrapped_is_refused_before_anything_is_cut(scene, unwrap, seams):
    grid = add_grid(6, 4)
    line = np.array([(0.3, 0.4, 0), (4.6, 3.4, 0)])
    grid.hide_set(True)
    with pytest.raises(unwrap.ObjectError, match="must be visible"):
        seams.put.put_lines_into_mesh(bpy.context, grid, [line], unwrap=True)
    grid.hide_set(False)
    bpy.context.view_layer.objects.active = grid
    bpy.ops.object.mode_set(mode="SCULPT")
    with pytest.raises(unwrap.ObjectError, match="Grid is in Sculpt Mode"):
        seams.put.put_lines_into_mesh(bpy.context, grid, [line])
    bpy.ops.object.mode_set(mode="OBJECT")
    assert len(grid.data.vertices) == 35


def test_a_ball_in_one_piece_is_stretched_and_less_in_two(scene, unwrap):
    bpy.ops.mesh.primitive_uv_sphere_add(segments=24, ring_count=12)
    ball = bpy.context.object
    mesh = ball.data
    stretches = []
    for is_seam in (lambda z: False, lambda z: abs(z) < 1e-5):
        for edge in mesh.edges:
            ends = [mesh.vertices[v].co for v in edge.vertices]
            is_meridian = all(abs(co.y) < 1e-5 and co.x > -1e-5 for co in ends)
            edge.use_seam = is_meridian or all(is_seam(co.z) for co in ends)
        found = unwrap.unwrap_and_measure(bpy.context, ball)
        stretches.append(max(i.area_stretch for i in found.islands))
        assert len(found.islands) == len(stretches)
    assert stretches[0] > 1.2 * stretches[1] > 1.2
