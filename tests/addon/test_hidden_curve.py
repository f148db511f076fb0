"""A curve that is hidden while it is edited is not hidden in files that are saved meanwhile."""

import pytest

import bpy


@pytest.fixture
def hidden(scene):
    from bl_ext.user_default.smooth_polylines.draw_tool.hidden_curve import HiddenCurve

    bpy.ops.curve.primitive_bezier_curve_add()
    return HiddenCurve(), bpy.context.object


def count_handlers():
    return [len(getattr(bpy.app.handlers, name)) for name in ("save_pre", "save_post", "save_post_fail")]


def read_hidden(path):
    """Whether the curve in a file is hidden, and selected."""
    bpy.ops.wm.open_mainfile(filepath=path)
    (curve,) = bpy.context.view_layer.objects
    return curve.hide_get(), curve.select_get()


@pytest.mark.parametrize("is_selected", [True, False])
def test_saved_in_the_middle_it_is_shown_in_the_file_and_still_hidden_here(hidden, tmp_path, is_selected):
    keeper, curve = hidden
    curve.select_set(is_selected)
    before = count_handlers()
    keeper.hide(curve.name)
    assert curve.hide_get()
    path = str(tmp_path / "a.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path, copy=True)
    assert curve.hide_get()
    with pytest.raises(RuntimeError):
        bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "no such folder" / "a.blend"), copy=True)
    assert curve.hide_get()
    keeper.show()
    assert (curve.hide_get(), curve.select_get()) == (False, is_selected)
    assert count_handlers() == before
    assert read_hidden(path) == (False, is_selected)


def test_what_was_hidden_before_stays_so_and_what_is_gone_does_no_harm(hidden, tmp_path):
    keeper, curve = hidden
    curve.hide_set(True)
    keeper.hide(curve.name)
    keeper.show()
    assert curve.hide_get()
    curve.hide_set(False)
    keeper.hide(curve.name)
    bpy.data.objects.remove(curve)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "b.blend"))
    # Another file takes the handlers with it.
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    keeper.show()
    assert not any(h.__module__.endswith("hidden_curve") for h in bpy.app.handlers.save_pre)
