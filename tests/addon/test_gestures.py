"""What mouse and keys mean, on a flat canvas: the plane z = 0 with pixels for units, without any surface or window."""

import numpy as np
import pytest


@pytest.fixture
def tool(extension):
    from bl_ext.user_default.smooth_polylines.draw_tool import gestures

    return gestures


class FlatCanvas:
    """The plane between 0 and 100, with picks exactly under the mouse; snapped, to whole tens."""

    scale = 1.0
    drag_threshold = 3.0

    def __init__(self, tool, sketch):
        self.tool, self.sketch, self.fits = tool, sketch, []

    def find_pick(self, given, is_snapped):
        from bl_ext.user_default.smooth_polylines.draw_tool.sketch import SketchPick

        x, y = given.mouse
        if not (0 <= x <= 100 and 0 <= y <= 100):
            return None
        if is_snapped:
            x, y = round(x, -1), round(y, -1)
        return SketchPick(0, (1.0, 0.0, 0.0), (float(x), float(y), 0.0))

    def find_near_pick(self, mouse, reach):
        distances = [np.hypot(p.place[0] - mouse[0], p.place[1] - mouse[1]) for p in self.sketch.state.picks]
        return int(np.argmin(distances)) if distances and min(distances) <= reach else None

    def find_leg(self, pick):
        return 1

    def fit_stroke(self, before, samples):
        self.fits.append((len(before), len(samples)))
        return [samples[0], samples[len(samples) // 2], samples[-1]]

    def measure_pixel(self, place):
        return 1.0

    def measure_first_detail(self):
        return 8.0


class Hand:
    """Sends events to gestures."""

    def __init__(self, tool):
        from bl_ext.user_default.smooth_polylines.draw_tool.sketch import Sketch

        self.tool, self.sketch = tool, Sketch()
        self.canvas = FlatCanvas(tool, self.sketch)
        self.gestures = tool.Gestures(self.canvas, self.sketch)
        self.mouse = (0, 0)

    def send(self, kind, value="PRESS", **more):
        return self.gestures.take(self.tool.Input(kind, value, self.mouse, **more))

    def move(self, x, y, **more):
        self.mouse = (x, y)
        return self.send("MOUSEMOVE", "NOTHING", **more)

    def click(self, x, y, **more):
        self.move(x, y)
        answer = self.send("LEFTMOUSE", "PRESS", **more)
        self.send("LEFTMOUSE", "RELEASE", **more)
        return answer

    def drag(self, *places, **more):
        self.move(*places[0])
        self.send("LEFTMOUSE", "PRESS", **more)
        for place in places[1:]:
            self.move(*place, **more)
        self.send("LEFTMOUSE", "RELEASE", **more)

    @property
    def places(self):
        return [pick.place[:2] for pick in self.sketch.state.picks]


@pytest.fixture
def hand(tool):
    return Hand(tool)


def test_clicks_add_picks_and_a_double_click_is_two(hand, tool):
    assert hand.click(10, 10) is tool.Answer.TAKEN
    hand.click(50, 10)
    hand.move(90, 10)
    hand.send("LEFTMOUSE", "DOUBLE_CLICK")
    hand.send("LEFTMOUSE", "RELEASE")
    assert hand.places == [(10, 10), (50, 10), (90, 10)]
    hand.click(150, 10)  # beside the surface
    assert len(hand.places) == 3
    assert hand.gestures.is_changed


def test_a_trembling_click_is_no_stroke(hand):
    hand.drag((10, 10), (11, 11), (12, 10))
    assert hand.places == [(10, 10)]
    assert hand.canvas.fits == []


def test_a_stroke_becomes_few_picks_as_one_step_after_those_that_were_there(hand):
    hand.click(10, 10)
    hand.drag((30, 30), *[(30 + k, 30) for k in range(1, 61)])
    assert hand.canvas.fits == [(1, 31)]  # a sample every two pixels, and the last
    assert hand.places == [(10, 10), (30, 30), (61, 30), (90, 30)]
    hand.click(90, 60)
    hand.send("Z", ctrl=True)
    assert len(hand.places) == 4
    hand.send("Z", ctrl=True)
    assert hand.places == [(10, 10)]
    hand.send("Z", ctrl=True, shift=True)
    assert len(hand.places) == 4


def test_a_stroke_over_the_rim_goes_on_where_it_comes_back(hand):
    hand.drag((80, 50), (95, 50), (120, 50), (95, 60), (80, 60))
    assert hand.canvas.fits == [(0, 4)]
    assert hand.places[-1] == (80, 60)


def test_a_stroke_that_comes_back_to_the_first_pick_closes_the_line(hand):
    hand.canvas.fit_stroke = lambda before, samples: samples
    hand.drag((20, 20), (80, 20), (80, 80), (20, 80), (22, 24))
    assert hand.sketch.state.is_closed
    assert hand.places == [(20, 20), (80, 20), (80, 80), (20, 80)]
    hand.send("Z", ctrl=True)
    assert hand.places == []


def test_a_click_on_the_first_pick_closes_the_line_but_a_drag_moves_it(hand):
    for place in ((10, 10), (50, 10), (50, 50)):
        hand.click(*place)
    hand.drag((10, 10), (20, 20), (12, 30))
    assert (hand.places[0], hand.sketch.state.is_closed) == ((12, 30), False)
    hand.click(12, 30)
    assert hand.sketch.state.is_closed
    hand.send("Z", ctrl=True)
    assert not hand.sketch.state.is_closed
    assert hand.places[0] == (12, 30)


def test_a_click_on_the_first_of_two_picks_closes_nothing_and_is_no_step(hand):
    for place in ((10, 10), (50, 10)):
        hand.click(*place)
    hand.click(10, 10)
    assert not hand.sketch.state.is_closed
    hand.send("Z", ctrl=True)
    assert hand.places == [(10, 10)]


def test_dragging_a_pick_is_one_step_and_esc_takes_it_back(hand, tool):
    hand.click(10, 10)
    hand.click(50, 50)
    hand.drag((50, 50), (55, 50), (60, 40), (70, 30))
    assert hand.places == [(10, 10), (70, 30)]
    hand.send("Z", ctrl=True)
    assert hand.places == [(10, 10), (50, 50)]
    hand.move(50, 50)
    hand.send("LEFTMOUSE", "PRESS")
    hand.move(90, 90)
    assert hand.places[1] == (90, 90)
    assert hand.send("ESC") is tool.Answer.TAKEN
    assert hand.places[1] == (50, 50)
    hand.send("LEFTMOUSE", "RELEASE")
    assert hand.send("ESC") is tool.Answer.LEAVE


def test_a_stroke_is_called_off_by_the_right_button(hand):
    hand.move(10, 10)
    hand.send("LEFTMOUSE", "PRESS")
    hand.move(60, 10)
    hand.send("RIGHTMOUSE")
    hand.send("LEFTMOUSE", "RELEASE")
    assert hand.places == []
    assert hand.gestures.trail == []
    assert hand.canvas.fits == []


def test_ctrl_click_inserts_and_adjusts_while_the_button_is_down(hand):
    hand.click(10, 10)
    hand.click(90, 10)
    hand.drag((50, 40), (50, 30), (50, 20), ctrl=True)
    assert hand.places == [(10, 10), (50, 20), (90, 10)]
    hand.send("Z", ctrl=True)
    assert hand.places == [(10, 10), (90, 10)]


def test_shift_snaps_clicks_and_drags(hand):
    hand.click(13, 18, shift=True)
    assert hand.places == [(10, 20)]
    hand.drag((42, 42), (50, 50), (58, 61), shift=True)
    assert hand.places == [(10, 20), (60, 60)]


def test_keys_remove_close_and_change_the_filter(hand):
    for place in ((10, 10), (50, 10), (50, 50)):
        hand.click(*place)
    hand.move(50, 10)
    hand.send("X")
    assert hand.places == [(10, 10), (50, 50)]
    hand.move(0, 99)
    hand.send("C")
    assert not hand.sketch.state.is_closed
    assert "three" in hand.gestures.hint
    hand.click(90, 90)
    hand.send("C")
    assert hand.sketch.state.is_closed
    hand.move(0, 99)
    hand.send("X")  # the last, and with it the loop
    assert (len(hand.places), hand.sketch.state.is_closed) == (2, False)
    hand.send("T")
    assert hand.sketch.state.filter == "GEODESIC"
    hand.send("T", is_repeat=True)
    assert hand.sketch.state.filter == "GEODESIC"


def test_the_detail_size_by_a_circle_and_by_the_wheel(hand, tool):
    hand.click(10, 10)
    hand.move(50, 50)
    assert hand.send("F") is tool.Answer.TAKEN
    assert hand.gestures.circle.centre == (42, 50)  # eight pixels away, as large as the size is
    hand.move(62, 50)
    assert hand.sketch.state.detail_size == pytest.approx(20)
    hand.send("ESC")
    assert hand.sketch.state.detail_size == 0
    hand.move(50, 50)
    hand.send("F")
    hand.move(58, 50)
    hand.send("LEFTMOUSE", "PRESS")
    hand.send("LEFTMOUSE", "RELEASE")
    assert hand.sketch.state.detail_size == pytest.approx(16)
    assert len(hand.places) == 1
    hand.send("WHEELUPMOUSE", ctrl=True)
    assert hand.sketch.state.detail_size == pytest.approx(20)
    hand.send("Z", ctrl=True)
    hand.send("Z", ctrl=True)
    assert hand.sketch.state.detail_size == 0
    hand.send("T")
    hand.send("F")
    assert hand.gestures.circle is None
    assert "Fair" in hand.gestures.hint


@pytest.mark.parametrize(
    "event",
    [
        ("MIDDLEMOUSE", {}),
        ("MIDDLEMOUSE", {"shift": True}),
        ("WHEELUPMOUSE", {}),
        ("TRACKPADPAN", {}),
        ("TRACKPADZOOM", {"ctrl": True}),
        ("NUMPAD_1", {}),
        ("HOME", {}),
        ("NDOF_MOTION", {}),
        ("LEFTMOUSE", {"alt": True}),
    ],
)
def test_navigation_is_passed_on(hand, tool, event):
    hand.click(10, 10)
    hand.move(60, 60)
    kind, more = event
    assert hand.send(kind, **more) is tool.Answer.PASSED
    assert hand.places == [(10, 10)]


def test_other_keys_stay_out_of_the_drawing_but_work_elsewhere(hand, tool):
    hand.click(10, 10)
    assert hand.send("G") is tool.Answer.TAKEN
    assert hand.send("X", is_over_view=False, is_over_area=False) is tool.Answer.PASSED
    assert hand.send("LEFTMOUSE", is_over_view=False) is tool.Answer.PASSED
    assert hand.send("N") is tool.Answer.PASSED
    assert len(hand.places) == 1


def test_enter_keeps_a_line_and_says_what_is_missing(hand, tool):
    hand.click(10, 10)
    assert hand.send("RET") is tool.Answer.TAKEN
    assert "two picks" in hand.gestures.hint
    hand.move(90, 10)
    hand.send("LEFTMOUSE", "PRESS")
    hand.move(90, 50)
    assert hand.send("RET") is tool.Answer.KEEP  # with the stroke that is being drawn
    assert hand.canvas.fits == [(1, 2)]
