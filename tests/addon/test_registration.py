"""Menus, registration and its undoing, the guard against unexpected errors, and a missing or foreign library."""

import importlib
import sys
from types import SimpleNamespace

import pytest

import bpy

import addon_utils

from blender_scenes import SUZANNE_PICKS, count_data, pick_faces

ADD = "mesh.smooth_polyline_add"
OPERATORS = {
    "VIEW3D_MT_edit_mesh_faces": [ADD, "mesh.smooth_polyline_net"],
    "VIEW3D_MT_edit_mesh_context_menu": [ADD],
    "VIEW3D_MT_edit_mesh_edges": ["mesh.smooth_polyline_seam", "mesh.smooth_polyline_mirror_marks"],
    "VIEW3D_MT_object": ["mesh.smooth_polyline_seam"],
    "VIEW3D_MT_make_links": ["mesh.smooth_polyline_copy_marks"],
}
MENUS = tuple(OPERATORS)
EXTENSION = "bl_ext.user_default.smooth_polylines"


def find_entries(menu):
    """Our draw functions in the menu; Blender's own list of them is the only way to see them without a window."""
    functions = getattr(bpy.types, menu)._dyn_ui_initialize()
    return [f for f in functions if f.__module__.startswith(EXTENSION)]


class LayoutRecorder:
    """Stands for a layout: remembers the operators drawn."""

    def __init__(self):
        self.operators = []

    def operator(self, name):
        self.operators.append(name)

    def separator(self):
        pass


class MenuRecorder:
    """Stands for an open menu."""

    def __init__(self):
        self.layout = LayoutRecorder()


@pytest.mark.parametrize("menu", MENUS)
def test_menu_entry_draws_the_operator(suzanne, menu):
    (draw,) = find_entries(menu)
    recorder = MenuRecorder()
    draw(recorder, bpy.context)
    assert recorder.layout.operators == OPERATORS[menu]


def test_context_menu_is_quiet_while_vertices_are_selected(suzanne):
    bpy.ops.mesh.select_mode(type="VERT")
    (draw,) = find_entries("VIEW3D_MT_edit_mesh_context_menu")
    recorder = MenuRecorder()
    draw(recorder, bpy.context)
    assert recorder.layout.operators == []


def test_disable_takes_everything_back_and_enable_brings_it_again(suzanne):
    addon_utils.disable(EXTENSION, default_set=False)
    try:
        assert [find_entries(menu) for menu in MENUS] == [[] for _ in MENUS]
        assert not hasattr(bpy.types, "MESH_OT_smooth_polyline_add")
    finally:
        assert addon_utils.enable(EXTENSION, default_set=False) is not None
    assert [len(find_entries(menu)) for menu in MENUS] == [1 for _ in MENUS]


def test_half_failed_registration_leaves_nothing_and_can_be_repeated(extension, monkeypatch):
    package = sys.modules[EXTENSION]
    package.unregister()

    def fail():
        raise RuntimeError("menus broke")

    with monkeypatch.context() as patched:
        patched.setattr(package.menus, "register", fail)
        with pytest.raises(RuntimeError, match="menus broke"):
            package.register()
    assert not hasattr(bpy.types, "MESH_OT_smooth_polyline_add")
    assert [find_entries(menu) for menu in MENUS] == [[] for _ in MENUS]
    package.unregister()  # once more does no harm
    package.register()
    assert hasattr(bpy.types, "MESH_OT_smooth_polyline_add")


def test_all_properties_are_there_under_their_fixed_names(extension):
    properties = bpy.ops.mesh.smooth_polyline_add.get_rna_type().properties
    assert properties["filter"].enum_items.keys() == ["LINEAR", "CUBIC", "GEODESIC", "FAIR", "NONE"]
    assert properties["pinned"].enum_items.keys() == ["ENDS", "ALL"]
    defaults = {name: properties[name].default for name in ("closed", "max_iterations", "detail_size", "offset")}
    assert defaults == {"closed": False, "max_iterations": 0, "detail_size": 0.0, "offset": 0.0}
    assert properties["threshold"].default == pytest.approx(1e-4)
    assert properties["output"].enum_items.keys() == ["CURVE", "MESH", "CURVES"]
    assert {"bevel", "name", "collection", "material", "solver", "knots", "support"} <= set(properties.keys())


class Panic(BaseException):
    """Stands for a panic of native code, which is no Exception."""


@pytest.mark.parametrize("error", [ZeroDivisionError("secret detail"), Panic("secret detail")])
def test_unexpected_error_is_a_short_message_and_a_traceback_on_the_console(suzanne, monkeypatch, capsys, error):
    session = importlib.import_module(f"{EXTENSION}.session")
    pick_faces(suzanne, SUZANNE_PICKS)
    before = count_data()

    def fail(*_arguments, **_options):
        raise error

    monkeypatch.setattr(session, "add_polylines", fail)
    with pytest.raises(RuntimeError, match=rf"failed unexpectedly \({type(error).__name__}\)") as caught:
        bpy.ops.mesh.smooth_polyline_add()
    assert "secret detail" not in str(caught.value)
    console = capsys.readouterr().err
    assert "Traceback" in console
    assert "secret detail" in console
    assert count_data() == before


def test_failing_write_takes_back_what_it_made(suzanne, monkeypatch):
    curve_write = importlib.import_module(f"{EXTENSION}.curve_write")
    pick_faces(suzanne, SUZANNE_PICKS)
    before = count_data()

    def fail(*_arguments):
        raise ZeroDivisionError("no collection")

    monkeypatch.setattr(curve_write, "choose_collection", fail)
    with pytest.raises(RuntimeError, match="failed unexpectedly"):
        bpy.ops.mesh.smooth_polyline_add()
    assert count_data() == before


def test_interrupt_is_passed_on(extension):
    guard = importlib.import_module(f"{EXTENSION}.guard")

    def interrupt():
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        guard.run_guarded(None, interrupt)


def test_missing_library_is_said_clearly(suzanne, monkeypatch):
    pick_faces(suzanne, SUZANNE_PICKS)
    monkeypatch.setitem(sys.modules, "smooth_polylines", None)
    with pytest.raises(RuntimeError, match=r"library smooth_polylines.*cannot be loaded.*Install the extension again"):
        bpy.ops.mesh.smooth_polyline_add()


def test_library_of_another_version_is_refused(suzanne, monkeypatch):
    import smooth_polylines

    pick_faces(suzanne, SUZANNE_PICKS)
    monkeypatch.setattr(smooth_polylines, "__version__", "99.0.0")
    with pytest.raises(RuntimeError, match=r"loaded is version 99\.0\.0.*Restart Blender"):
        bpy.ops.mesh.smooth_polyline_add()


class PanelRecorder(LayoutRecorder):
    """A layout that also takes rows, properties and labels, and gives the operators' properties."""

    def row(self, **_):
        return self

    column = row

    def operator(self, name, **_):
        self.operators.append(name)
        return SimpleNamespace()

    def prop(self, holder, name, **_):
        assert name in holder.bl_rna.properties, name

    def label(self, **_):
        pass


def test_seams_panel_offers_what_the_mode_allows(suzanne):
    panel = bpy.types.VIEW3D_PT_smooth_polyline_seams
    methods = ["mesh.smooth_polyline_seam"] * 3
    for mode, others in (
        ("EDIT", ["mesh.smooth_polyline_net", "mesh.smooth_polyline_mirror_marks"]),
        ("OBJECT", ["mesh.smooth_polyline_mirror_marks", "mesh.smooth_polyline_copy_marks"]),
    ):
        bpy.ops.object.mode_set(mode=mode)
        assert panel.poll(bpy.context)
        layout = PanelRecorder()
        panel.draw(SimpleNamespace(layout=layout), bpy.context)
        assert layout.operators == methods + others
