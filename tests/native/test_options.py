"""The contract of every other argument of `polyline`: one value just inside, one just outside."""

import inspect
import math

import numpy as np
import pytest

import smooth_polylines as sp
from native.invariants import same_line
from native.made_meshes import make_grid

MESH = sp.SurfaceMesh(*make_grid(6))
PICKS = [3, 37, 71]


def test_the_signature_is_the_contract():
    expected = {
        "closed": False, "filter": "linear", "pinned": "ends", "solver": "auto", "threshold": 1e-4,
        "max_iterations": None, "detail_size": None, "knots": "centripetal", "support": 2,
        "stages": False, "time_limit": None, "stop": None,
    }  # fmt: skip
    for method, leading in ((sp.SurfaceMesh.polyline, 2), (sp.SurfaceMesh.stroke, 2), (sp.SurfaceMesh.network, 3)):
        parameters = list(inspect.signature(method).parameters.values())[leading:]
        more = {"avoid_crossings": None} if method is sp.SurfaceMesh.network else {}
        assert {p.name: p.default for p in parameters} == expected | more
        by_name_only = {p.name for p in parameters if p.kind is p.KEYWORD_ONLY}
        assert by_name_only == {"knots", "support", "stages", "time_limit", "stop", *more}


def test_told_defaults_are_the_real_ones():
    defaults = {
        name: parameter.default
        for name, parameter in inspect.signature(sp.SurfaceMesh.polyline).parameters.items()
        if parameter.default is not parameter.empty
    }
    assert same_line(MESH.polyline(PICKS, **defaults), MESH.polyline(PICKS))


@pytest.mark.parametrize(
    ("argument", "word", "near"),
    [
        ("filter", "Linear", "linear"),
        ("filter", "cubik", "cubic"),
        ("filter", "geodesics", "geodesic"),
        ("filter", "fare", "fair"),
        ("filter", "None", "none"),
        ("solver", "atuo", "auto"),
        ("solver", "HEAP", "heap"),
        ("knots", "cordal", "chordal"),
        ("pinned", "end", "ends"),
        ("pinned", "ALL", "all"),
    ],
)
def test_a_word_that_is_nearly_right_is_refused_with_a_hint(argument, word, near):
    with pytest.raises(
        sp.OptionError, match=f'^{argument}: found "{word}", expected .*did you mean "{near}"'
    ) as caught:
        MESH.polyline(PICKS, **{argument: word})
    assert f'"{near}"' in str(caught.value).split("did you mean")[0]


@pytest.mark.parametrize("argument", ["filter", "solver", "knots", "pinned"])
@pytest.mark.parametrize("word", ["", "something else", "\u00e9\U0001f600", "x" * 100_000, "a\0b"])
def test_another_word_is_refused_with_the_choices_alone(argument, word):
    with pytest.raises(sp.OptionError, match=f"^{argument}: found .*expected one of ") as caught:
        MESH.polyline(PICKS, **{argument: word})
    assert "did you mean" not in str(caught.value)
    assert len(str(caught.value)) < 300


@pytest.mark.parametrize(
    ("argument", "value"),
    [
        ("closed", 1), ("closed", None), ("closed", "yes"), ("stages", 0), ("stages", None),
        ("filter", None), ("filter", 3), ("filter", b"linear"), ("solver", None), ("knots", 1.0),
        ("threshold", "1e-4"), ("threshold", None), ("threshold", True), ("threshold", 1j), ("threshold", [1e-4]),
        ("detail_size", "1"), ("detail_size", True),
        ("support", 2.0), ("support", True), ("support", None), ("support", "2"), ("support", [2]),
        ("max_iterations", 1.0), ("max_iterations", True), ("max_iterations", "1"), ("max_iterations", [1]),
        ("pinned", None), ("pinned", True), ("pinned", [1, 0, 1]), ("pinned", [True, None, True]),
        ("pinned", {True}), ("pinned", np.array([1, 0, 1])), ("pinned", np.array([[True]])),
        pytest.param("pinned", iter([True]), id="pinned-iterator"),
    ],
    ids=str,
)  # fmt: skip
def test_another_type_is_a_type_error_that_names_the_argument(argument, value):
    with pytest.raises(TypeError, match=f"^{argument}: .*expected"):
        MESH.polyline(PICKS, **{argument: value})


@pytest.mark.parametrize("value", [5e-324, 1e-300, 1e-8, 0.5, 1e300, np.float32(0.01), 1, np.int64(1)])
def test_a_threshold_above_0_is_taken(value):
    MESH.polyline(PICKS, filter="none", threshold=value)


@pytest.mark.parametrize("value", [0.0, -0.0, -1e-9, math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("filter_name", ["none", "linear", "geodesic"])
def test_a_threshold_of_0_or_not_finite_is_refused_by_every_filter(value, filter_name):
    with pytest.raises(sp.OptionError, match=r"^threshold: "):
        MESH.polyline(PICKS, filter=filter_name, threshold=value)


@pytest.mark.parametrize("value", [1, 2, np.uint8(7), 2**32, 2**200, None])
def test_max_iterations_from_1_on_are_taken(value):
    MESH.polyline(PICKS, filter="none", max_iterations=value)


@pytest.mark.parametrize("value", [0, -1, -(2**200)])
def test_max_iterations_below_1_are_refused(value):
    with pytest.raises(sp.OptionError, match=r"^max_iterations: .*at least 1"):
        MESH.polyline(PICKS, max_iterations=value)


@pytest.mark.parametrize("value", [2, 16, np.uint8(7)])
def test_a_support_from_2_to_16_is_taken(value):
    MESH.polyline(PICKS, filter="cubic", support=value, threshold=1e-2)


@pytest.mark.parametrize("value", [-(2**200), -1, 0, 1, 17, 2**40, 2**200])
def test_another_support_is_refused(value):
    with pytest.raises(sp.OptionError, match=r"^support: found .*expected 2 to 16 neighbours a side"):
        MESH.polyline(PICKS, filter="cubic", support=value, threshold=1e-2)


@pytest.mark.parametrize("filter_name", ["linear", "geodesic", "fair", "none"])
def test_a_support_is_for_the_cubic_only(filter_name):
    with pytest.raises(sp.OptionError, match=r'^support: found 3, .*"cubic"'):
        MESH.polyline(PICKS, filter=filter_name, support=3)


@pytest.mark.parametrize("filter_name", ["linear", "cubic", "geodesic", "none"])
def test_a_detail_size_is_for_fair_only(filter_name):
    with pytest.raises(sp.OptionError, match=r'^detail_size: .*"fair"'):
        MESH.polyline(PICKS, filter=filter_name, detail_size=1.0)


@pytest.mark.parametrize("value", [0.0, -1.0, math.nan, -math.inf])
def test_a_detail_size_has_to_be_a_length(value):
    with pytest.raises(sp.OptionError, match=r"^detail_size: .*above 0"):
        MESH.polyline(PICKS, filter="fair", detail_size=value)


@pytest.mark.parametrize("filter_name", ["geodesic", "fair", "none"])
def test_the_heap_is_for_the_papers_filters_only(filter_name):
    with pytest.raises(sp.OptionError, match=r"^solver: "):
        MESH.polyline(PICKS, filter=filter_name, solver="heap")


@pytest.mark.parametrize("flags", [[], [True], [True] * 2, [True] * 4])
def test_pinned_flags_are_one_for_each_pick(flags):
    with pytest.raises(sp.OptionError, match=r"^pinned: .*3"):
        MESH.polyline(PICKS, pinned=flags)


@pytest.mark.parametrize("flags", [[False, True, True], [True, True, False], [False] * 3])
def test_the_ends_of_an_open_line_cannot_be_set_free(flags):
    with pytest.raises(sp.OptionError, match=r"^pinned: "):
        MESH.polyline(PICKS, filter="none", pinned=flags)
    MESH.polyline(PICKS, filter="none", pinned=flags, closed=True)


@pytest.mark.parametrize("make", [list, tuple, np.array])
def test_pinned_flags_mean_the_same_as_the_words(make):
    for word, flags in (("ends", [True, False, True]), ("all", [True] * 3)):
        by_word = MESH.polyline(PICKS, filter="none", pinned=word)
        assert same_line(MESH.polyline(PICKS, filter="none", pinned=make(flags)), by_word)
    for word, flags in (("ends", [False] * 3), ("all", [True] * 3)):
        by_word = MESH.polyline(PICKS, filter="none", pinned=word, closed=True)
        assert same_line(MESH.polyline(PICKS, filter="none", pinned=make(flags), closed=True), by_word)


def test_an_unknown_argument_is_a_type_error():
    with pytest.raises(TypeError, match="treshold"):
        MESH.polyline(PICKS, treshold=1e-4)
