"""Every operator called from where none was meant to be called, without what it needs: a message, never a traceback.

From handlers of all kinds, amid undo and redo, without a window, as a timer does it; on linked and overridden objects;
with the library missing or of another version.
"""

import sys
from types import SimpleNamespace

import pytest

import bpy

import addon_utils

from abuse_kit import EXTENSION, abuse, describe_scene, find_operators
from blender_scenes import SUZANNE_PICKS, get_curves, get_spline_points, pick_faces

OPERATORS = ("mesh.smooth_polyline_add", "curve.smooth_polyline_update")
HANDLERS = {
    "load_pre": lambda path: bpy.ops.wm.open_mainfile(filepath=path),
    "load_post": lambda path: bpy.ops.wm.open_mainfile(filepath=path),
    "save_pre": lambda path: bpy.ops.wm.save_as_mainfile(filepath=path + "2"),
    "save_post": lambda path: bpy.ops.wm.save_as_mainfile(filepath=path + "2"),
    "frame_change_pre": lambda _: bpy.context.scene.frame_set(3),
    "frame_change_post": lambda _: bpy.context.scene.frame_set(3),
    "depsgraph_update_pre": lambda _: move_and_update(),
    "depsgraph_update_post": lambda _: move_and_update(),
    "undo_pre": lambda _: bpy.ops.ed.undo(),
    "undo_post": lambda _: bpy.ops.ed.undo(),
    "redo_pre": lambda _: (bpy.ops.ed.undo(), bpy.ops.ed.redo()),
    "redo_post": lambda _: (bpy.ops.ed.undo(), bpy.ops.ed.redo()),
}


def move_and_update():
    bpy.data.objects["Suzanne"].location.x += 1
    bpy.context.view_layer.update()


@pytest.fixture
def modules(scene):
    from bl_ext.user_default.smooth_polylines import session, surface
    from bl_ext.user_default.smooth_polylines.live import memory

    surface.forget_surfaces()
    return SimpleNamespace(session=session, surface=surface, memory=memory)


def prepare(modules, mode):
    """Suzanne with a curve that remembers: the curve is active, or Suzanne is in Edit Mode with picked faces."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    bpy.ops.mesh.primitive_monkey_add()
    head = bpy.context.object
    curve = modules.session.add_polyline(bpy.context, head, SUZANNE_PICKS, filter="fair").curve_object
    if mode == "OBJECT":
        bpy.context.view_layer.objects.active = curve
        curve.select_set(True)
    else:
        bpy.ops.object.mode_set(mode="EDIT")
        bpy.ops.mesh.select_mode(type="FACE")
        bpy.ops.mesh.select_all(action="DESELECT")
        pick_faces(head, SUZANNE_PICKS)
    bpy.ops.ed.undo_push(message="Prepared")
    bpy.ops.ed.undo_push(message="Once more")
    return head, curve


def assert_quiet(capfd, what):
    """Neither our guard nor Blender has printed a traceback."""
    told = capfd.readouterr()
    assert "Traceback" not in told.err + told.out, f"{what}:\n{told.err}"


@pytest.mark.parametrize("mode", ["OBJECT", "EDIT"])
@pytest.mark.parametrize("where", HANDLERS)
def test_called_from_a_handler(modules, tmp_path, capfd, where, mode):
    finished, calls = set(), 0
    for name, operator in find_operators():
        prepare(modules, mode)
        path = str(tmp_path / "file.blend")
        bpy.ops.wm.save_as_mainfile(filepath=path, compress=False)
        is_inside, faults = [False], []

        @bpy.app.handlers.persistent
        def handler(*_arguments, name=name, operator=operator, is_inside=is_inside, faults=faults):
            # Blender evaluates the scene before and after every operator that a script calls: without this any
            # operator, also Blender's own, calls itself again without end from depsgraph_update_post.
            if is_inside[0]:
                return
            is_inside[0] = True
            try:
                if abuse(f"{name} from {where}", operator):
                    finished.add(name)
            except AssertionError as fault:
                faults.append(fault)
            finally:
                is_inside[0] = False
                nonlocal calls
                calls += 1

        handlers = getattr(bpy.app.handlers, where)
        handlers.append(handler)
        try:
            HANDLERS[where](path)
        finally:
            handlers.remove(handler)
        assert faults == []
        assert_quiet(capfd, f"{name} from {where} in {mode}")
    assert calls >= len(find_operators())
    # What can work does: a handler may well make and update lines. (A file holds no order of picks.)
    if not where.startswith("load"):
        assert finished & set(OPERATORS), finished


@pytest.mark.parametrize("mode", ["OBJECT", "EDIT"])
def test_undone_and_redone_amid_other_lines(modules, mode, capfd):
    """An operator after each undo and redo of another: nothing that it keeps is of a state that is gone."""
    for name, operator in find_operators():
        prepare(modules, mode)
        for step in (bpy.ops.ed.undo, bpy.ops.ed.undo, bpy.ops.ed.redo, bpy.ops.ed.redo, bpy.ops.ed.undo):
            if step.poll():
                step()
            abuse(f"{name} amid undo", operator, "EXEC_DEFAULT", True)
        assert_quiet(capfd, f"{name} amid undo in {mode}")


@pytest.mark.parametrize("mode", ["OBJECT", "EDIT"])
def test_without_a_window_as_from_a_timer(modules, mode, capfd):
    for name, operator in find_operators():
        prepare(modules, mode)
        with bpy.context.temp_override(window=None):
            for how in ("EXEC_DEFAULT", "INVOKE_DEFAULT"):
                abuse(f"{name} without a window", operator, how)
        assert_quiet(capfd, f"{name} without a window in {mode}")


@pytest.fixture
def library_file(modules, tmp_path):
    """A file with Suzanne and her curve, in a collection."""
    head, curve = prepare(modules, "OBJECT")
    collection = bpy.data.collections.new("Linked")
    bpy.context.scene.collection.children.link(collection)
    for each in (head, curve):
        collection.objects.link(each)
        bpy.context.scene.collection.objects.unlink(each)
    path = str(tmp_path / "library.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path, compress=False)
    return path


@pytest.mark.parametrize("kind", ["linked", "overridden", "overridden with data"])
@pytest.mark.parametrize("active", ["MESH", "CURVE"])
def test_linked_and_overridden_objects(modules, library_file, kind, active, capfd):
    for name, operator in find_operators():
        bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
        with bpy.data.libraries.load(library_file, link=True) as (_, wanted):
            wanted.collections = ["Linked"]
        (collection,) = wanted.collections
        bpy.context.scene.collection.children.link(collection)
        if kind != "linked":
            made = collection.override_hierarchy_create(
                bpy.context.scene, bpy.context.view_layer, do_fully_editable=True
            )
            bpy.context.scene.collection.children.unlink(collection)
            collection = made
        for each in collection.all_objects:
            if kind == "overridden with data" and each.data.library is not None:
                each.data = each.data.override_create()
            each.select_set(True)
            if each.type == active:
                bpy.context.view_layer.objects.active = each
        assert bpy.context.object.type == active
        abuse(f"{name} on {kind} {active}", operator)
        # The mesh moves, frames go by: what follows it leaves alone what is another file's.
        bpy.context.scene.frame_set(7)
        bpy.context.view_layer.update()
        assert_quiet(capfd, f"{name} on {kind} {active}")


def other_version(monkeypatch):
    import smooth_polylines

    monkeypatch.setattr(smooth_polylines, "__version__", "99.0.0")
    return "is loaded is version 99.0.0"


def missing(monkeypatch):
    monkeypatch.setitem(sys.modules, "smooth_polylines", None)
    return "cannot be loaded"


# They look at edges and objects alone.
NEED_NO_LIBRARY = {
    "mesh.smooth_polyline_copy_marks",
    "mesh.smooth_polyline_mirror_marks",
    "object.smooth_polyline_change_output",
    "view3d.smooth_polyline_edit_picks",
}


@pytest.mark.parametrize("broken", [missing, other_version])
def test_with_the_library_missing_or_of_another_version(modules, monkeypatch, broken, capfd):
    for mode in ("OBJECT", "EDIT"):
        for name, operator in find_operators():
            _, curve = prepare(modules, mode)
            modules.surface.forget_surfaces()
            with monkeypatch.context() as patched:
                expected = broken(patched)
                before = describe_scene()
                said = ""
                try:
                    result = operator()
                except RuntimeError as error:
                    said, result = str(error), {"CANCELLED"}
                assert "unexpectedly" not in said, said
                if result == {"CANCELLED"}:
                    assert describe_scene() == before
                if name not in NEED_NO_LIBRARY and "poll()" not in said:
                    assert expected in said, f"{name}: {said or result}"
                # A setting of the curve, a frame, an edit of the mesh: the curve says what is wrong.
                known = modules.memory.find_memory(curve) if name not in NEED_NO_LIBRARY else None
                if known is not None and mode == "OBJECT":
                    points = get_spline_points(curve)
                    known.filter = "GEODESIC"
                    bpy.context.scene.frame_set(5)
                    assert (known.state, expected in known.message) == ("STALE", True)
                    assert (get_spline_points(curve) == points).all()
            assert_quiet(capfd, f"{name} without its library")


def test_disabled_and_enabled_twenty_times_with_curves_in_the_file_all_still_works(modules, capfd):
    prepare(modules, "EDIT")
    for _ in range(20):
        addon_utils.disable(EXTENSION, default_set=True)
        bpy.context.scene.frame_set(bpy.context.scene.frame_current + 1)
        addon_utils.enable(EXTENSION, default_set=True)
    from bl_ext.user_default.smooth_polylines.live import memory

    assert bpy.ops.mesh.smooth_polyline_add(filter="GEODESIC") == {"FINISHED"}
    curves = get_curves()
    assert len(curves) == 2
    # The curve from before knows what it knew, and is made again.
    for curve in curves:
        known = memory.find_memory(curve)
        before = get_spline_points(curve)
        known.filter = "LINEAR"
        assert known.state == "CURRENT"
        assert len(get_spline_points(curve)) > 0
        assert get_spline_points(curve).shape != before.shape or (get_spline_points(curve) != before).any()
    assert_quiet(capfd, "disabled and enabled")
