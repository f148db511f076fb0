"""Long work in a thread: the same result as at once, and Esc within 0.2 seconds, which changes nothing."""

import inspect
import threading
import time
from types import SimpleNamespace

import numpy as np
import pytest

import bpy

from abuse_kit import EXTENSION, describe_scene
from blender_scenes import SUZANNE_PICKS, add_mesh_object, enter_edit_mode, get_curves, get_spline_points, pick_faces

# What the paper's own method works on for seconds, on a mesh of some size.
LONG_WORK = {"filter": "LINEAR", "solver": "HEAP", "threshold": 1e-12, "max_iterations": 1_000_000}


@pytest.fixture
def addon(extension):
    from bl_ext.user_default.smooth_polylines import ahead, errors, preferences, session, surface
    from bl_ext.user_default.smooth_polylines.operators import add_polyline, interruptible, put_lines, put_net

    surface.forget_surfaces()
    modules = (ahead, errors, preferences, session, surface, interruptible)
    return SimpleNamespace(
        **{module.__name__.rpartition(".")[2]: module for module in modules},
        add=add_polyline.MESH_OT_smooth_polyline_add,
        seam=put_lines.MESH_OT_smooth_polyline_seam,
        net=put_net.MESH_OT_smooth_polyline_net,
    )


class Screen:
    """The parts of a window that the operators touch."""

    def __init__(self):
        self.shown = []
        self.window = SimpleNamespace(
            cursor_modal_set=self.shown.append, cursor_modal_restore=lambda: self.shown.remove("WAIT")
        )
        self.workspace = SimpleNamespace(status_text_set=self.set_status)
        self.window_manager = SimpleNamespace(
            event_timer_add=lambda *_, **__: self.shown.append("timer") or "timer",
            event_timer_remove=self.shown.remove,
            modal_handler_add=lambda _: None,
        )
        self.status = None

    def set_status(self, text):
        self.status = text

    def __getattr__(self, name):
        return getattr(bpy.context, name)


def make_operator(kind, **wishes):
    """An operator as Blender makes one when it is called from a menu, with its properties; what it reports is kept."""
    values = {}
    for base in reversed(kind.__mro__):
        for name, prop in getattr(base, "__annotations__", {}).items():
            if hasattr(prop, "keywords"):
                values[name] = prop.keywords.get("default", 0 if "Int" in prop.function.__name__ else "")
    ours = [base for base in reversed(kind.__mro__) if base.__module__.startswith(EXTENSION)]
    methods = {name: each for base in ours for name, each in vars(base).items() if inspect.isfunction(each)}
    made = type("Called", (), methods)()
    made.__dict__.update({**values, **wishes, "bl_label": kind.bl_label, "reports": []})
    made.report = lambda level, text: made.reports.append((*level, text))
    return made


def press(kind):
    return SimpleNamespace(type=kind, value="PRESS")


def run_to_end(operator, screen, seconds=60):
    """Timer after timer until it ends; the last answer, and how many there were."""
    until, ticks = time.monotonic() + seconds, 0
    while time.monotonic() < until:
        answer = operator.modal(screen, press("TIMER"))
        ticks += 1
        if answer != {"RUNNING_MODAL"}:
            return answer, ticks
        time.sleep(0.005)
    raise AssertionError("it did not end")


@pytest.fixture
def picked(suzanne, addon, monkeypatch):
    monkeypatch.setattr(addon.interruptible, "has_person", lambda _context: True)
    pick_faces(suzanne, SUZANNE_PICKS)
    return suzanne


@pytest.fixture
def wavy(picked):
    """A large mesh in place of Suzanne, with far picks."""
    side = 200
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    x, y = np.meshgrid(np.arange(side), np.arange(side))
    positions = np.stack([x, y, 0.3 * np.sin(x / 3) * np.cos(y / 4)], axis=-1).reshape(-1, 3)
    corner = (np.arange(side - 1)[:, None] * side + np.arange(side - 1)).ravel()
    made = add_mesh_object("Wavy", positions, np.stack([corner, corner + 1, corner + side + 1, corner + side], axis=1))
    enter_edit_mode(made)
    pick_faces(made, [0, (side - 1) ** 2 - 1])
    return made


def slow_down(addon, monkeypatch, seconds):
    """Opening a mesh takes so long."""
    make_ready = addon.surface.make_ready

    def make(reading, **options):
        time.sleep(seconds)
        return make_ready(reading, **options)

    monkeypatch.setattr(addon.surface, "make_ready", make)


def test_short_work_is_done_in_the_call(addon, picked):
    screen = Screen()
    operator = make_operator(addon.add)
    assert operator.invoke(screen, None) == {"FINISHED"}
    assert (screen.shown, screen.status) == ([], None)
    assert len(get_curves()) == 1


@pytest.mark.parametrize("kind", ["add", "seam", "net"])
def test_in_a_thread_it_makes_what_is_made_at_once(addon, picked, monkeypatch, kind):
    operator = make_operator(getattr(addon, kind), marks={"SEAM"}, outputs={"FACE_SETS"}, unwrap=False)
    assert operator.execute(bpy.context) == {"FINISHED"}
    expected, reports = describe_result(), operator.reports
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    bpy.ops.mesh.primitive_monkey_add()
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_mode(type="FACE")
    bpy.ops.mesh.select_all(action="DESELECT")
    pick_faces(bpy.context.edit_object, SUZANNE_PICKS)
    addon.surface.forget_surfaces()
    slow_down(addon, monkeypatch, 0.3)
    screen, operator = (
        Screen(),
        make_operator(getattr(addon, kind), marks={"SEAM"}, outputs={"FACE_SETS"}, unwrap=False),
    )
    before = describe_scene()
    assert operator.invoke(screen, None) == {"RUNNING_MODAL"}
    assert describe_scene() == before
    assert "Esc stops it" in screen.status
    # Other events are swallowed: nothing may change the mesh meanwhile.
    assert operator.modal(screen, press("G")) == {"RUNNING_MODAL"}
    answer, ticks = run_to_end(operator, screen)
    assert answer == {"FINISHED"}
    assert ticks > 5
    assert (screen.shown, screen.status) == ([], None)
    assert operator.reports == reports
    for one, other in zip(describe_result(), expected, strict=True):
        np.testing.assert_array_equal(one, other)


def describe_result():
    """Points of the curves, and positions and seams of the mesh."""
    bpy.ops.object.mode_set(mode="OBJECT")
    mesh = bpy.data.objects["Suzanne"].data
    found = [[v.co[:] for v in mesh.vertices], [e.use_seam for e in mesh.edges]]
    return [np.array(values) for values in found] + [get_spline_points(curve) for curve in get_curves()]


@pytest.mark.parametrize("kind", ["add", "seam", "net"])
def test_esc_ends_a_line_that_takes_long(addon, wavy, kind):
    before = describe_scene()
    wishes = {"marks": {"SEAM"}, "outputs": {"FACE_SETS"}, "unwrap": False, **LONG_WORK}
    screen, operator = Screen(), make_operator(getattr(addon, kind), **wishes)
    begin = time.monotonic()
    assert operator.invoke(screen, None) == {"RUNNING_MODAL"}
    assert time.monotonic() - begin < 1.0
    for _ in range(10):
        assert operator.modal(screen, press("TIMER")) == {"RUNNING_MODAL"}
        time.sleep(0.02)
    worker = operator.run.thread
    begin = time.monotonic()
    assert operator.modal(screen, press("ESC")) == {"CANCELLED"}
    assert time.monotonic() - begin < 0.2
    worker.join(5)
    assert not worker.is_alive(), "the library did not stop"
    assert operator.reports == [("INFO", f"{operator.bl_label} was stopped; nothing was changed")]
    assert describe_scene() == before
    assert (screen.shown, screen.status) == ([], None)
    assert not [t for t in threading.enumerate() if "smooth polylines" in t.name]


def test_a_refusal_from_the_thread_is_told_as_ever(addon, picked, monkeypatch):
    slow_down(addon, monkeypatch, 0.2)
    screen, operator = Screen(), make_operator(addon.add, closed=True)
    bpy.ops.mesh.select_all(action="DESELECT")
    pick_faces(picked, SUZANNE_PICKS[:2])
    assert operator.invoke(screen, None) == {"RUNNING_MODAL"}
    answer, _ = run_to_end(operator, screen)
    assert answer == {"CANCELLED"}
    ((level, text),) = operator.reports
    assert level == "ERROR"
    assert "3" in text
    assert "unexpectedly" not in text


def test_handlers_amid_a_run_have_no_part_in_it(addon, picked, monkeypatch):
    bpy.ops.object.mode_set(mode="OBJECT")
    other = addon.session.add_polyline(bpy.context, picked, SUZANNE_PICKS, filter="geodesic").curve_object
    other.data.smooth_polyline.source = "EVALUATED"
    bpy.ops.object.mode_set(mode="EDIT")
    run = addon.ahead.Run()

    def execute():
        # As an evaluation of the scene amid it, which finds that the other mesh has been rebuilt.
        with addon.ahead.at_work(None):
            addon.session.update_curve(bpy.context, other.data)
        return {"FINISHED"} if addon.ahead.do(lambda: 1, lambda value, _: value + 1) == 2 else {"CANCELLED"}

    assert addon.ahead.finish(run, execute, 10.0) == {"FINISHED"}
    assert len(run.done) == 1


def test_what_cannot_be_stopped_ends_at_the_time_limit_of_the_preferences(addon, wavy, monkeypatch):
    assert addon.preferences.get_time_limit() is None  # without a window nobody waits
    bpy.ops.object.mode_set(mode="OBJECT")
    curve = addon.session.add_polyline(bpy.context, wavy, [0, 39_600], filter="fair").curve_object
    points = get_spline_points(curve)
    monkeypatch.setattr(addon.preferences, "get_time_limit", lambda: 0.5)
    known = curve.data.smooth_polyline
    known.solver, known.max_iterations = "HEAP", 1_000_000
    known.threshold = 1e-12
    begin = time.monotonic()
    known.filter = "LINEAR"
    assert time.monotonic() - begin < 5
    assert known.state == "STALE"
    assert "longer than 0.5 seconds" in known.message
    assert "Time Limit" in known.message
    np.testing.assert_array_equal(get_spline_points(curve), points)
    with pytest.raises(addon.errors.LimitError):
        addon.session.update_curve(bpy.context, curve.data)
