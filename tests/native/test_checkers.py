"""The checkers themselves: a good line passes, and each kind of spoilt line is refused for its own reason."""

from types import SimpleNamespace

import numpy as np
import pytest

from native.invariants import barycentre_pins
from native.straightness import StraightnessJudge
from native.surfaces import open_surface

ARRAYS = ("points", "triangles", "barycentric", "segment_triangles", "strip", "strip_bits")


@pytest.fixture
def surface():
    return open_surface("terrain")


@pytest.fixture
def picks(surface):
    return surface.random_picks(3, 91)


def open_line(surface, picks, **options):
    """A line as plain arrays that can be spoilt."""
    line = surface.mesh.polyline(picks, **options)
    loose = SimpleNamespace(**{name: getattr(line, name).copy() for name in ARRAYS}, closed=line.closed)
    loose.length = line.length
    loose.on = lambda positions: loose.points
    return loose


def check(surface, line, picks, **kwargs):
    for name in ARRAYS:
        getattr(line, name).flags.writeable = False
    surface.checker.check(line, pins=barycentre_pins(picks), **kwargs)


@pytest.mark.parametrize("filter_name", ["none", "geodesic"])
def test_a_good_line_passes(surface, picks, filter_name):
    check(surface, open_line(surface, picks, filter=filter_name, pinned="all"), picks)


def spoil_point(line):
    line.points[4, 1] = np.nextafter(line.points[4, 1], 9)


def spoil_sum(line):
    line.barycentric[4] *= 1 + 1e-12


def spoil_sign(line):
    line.barycentric[4] = [-0.1, 0.6, 0.5]


def spoil_segment(line):
    line.segment_triangles[3] = line.segment_triangles[5]


def spoil_order(line):
    line.strip[4], line.strip[5] = line.strip[5], line.strip[4]


def spoil_gap(line):
    line.strip = np.delete(line.strip, 6)


def spoil_backtrack(line):
    line.strip = np.insert(line.strip, 7, [line.strip[7], line.strip[6]])


def spoil_end(line):
    line.strip = line.strip[1:].copy()


def spoil_length(line):
    line.length *= 1 + 1e-9


def spoil_dtype(line):
    line.triangles = line.triangles.astype(np.int64)


SPOILT = {
    spoil_point: "not what its barycentric parts give",
    spoil_sum: "do not sum to 1",
    spoil_sign: "is negative",
    spoil_segment: "does not begin in its triangle",
    spoil_order: "strip is broken",
    spoil_gap: "strip is broken",
    spoil_backtrack: "turns back",
    spoil_end: "does not begin at the first point",
    spoil_length: "segments sum to",
    spoil_dtype: "has dtype int64",
}


@pytest.mark.parametrize(("spoil", "reason"), SPOILT.items(), ids=[spoil.__name__ for spoil in SPOILT])
def test_a_spoilt_line_is_refused(surface, picks, spoil, reason):
    line = open_line(surface, picks, filter="none", pinned="all")
    spoil(line)
    with pytest.raises(AssertionError, match=reason):
        check(surface, line, picks)


def test_a_missing_pin_is_noticed(surface, picks):
    line = open_line(surface, picks, filter="none")
    with pytest.raises(AssertionError, match="is not on the line"):
        check(surface, line, picks)


def test_an_array_that_can_be_written_to_is_noticed(surface, picks):
    line = open_line(surface, picks, filter="none", pinned="all")
    with pytest.raises(AssertionError):
        surface.checker.check(line, pins=barycentre_pins(picks))


def test_a_strip_that_repeats_is_noticed(surface, picks):
    line = open_line(surface, picks[:2], filter="none")
    longer = open_line(surface, picks[:2], filter="none")
    longer.strip = np.concatenate([line.strip, line.strip[-2:-4:-1]])
    with pytest.raises(AssertionError, match="repeats triangles"):
        surface.checker._check_repeats(longer, line)


def test_the_judge_of_straightness_sees_what_is_bent(surface, picks):
    judge = StraightnessJudge(surface.checker)
    bent = surface.mesh.polyline(picks[:2], filter="none")
    straight = surface.mesh.polyline(picks[:2], filter="geodesic")
    assert sum(bend > slack for _, _, bend, slack in judge.bends(bent)) > len(bent.points) // 2
    assert all(bend <= slack for _, _, bend, slack in judge.bends(straight))


def test_the_judge_sees_a_vertex_that_could_be_passed():
    """Two sides of a flat fan: the line over the rim's far points bends at the hub by a known angle."""
    from native.invariants import SurfaceChecker
    from native.made_meshes import make_fan

    positions, triangles = make_fan(12)
    judge = StraightnessJudge(SurfaceChecker(positions, triangles))
    for steps, lack in ((6, 0.0), (5, np.pi / 6), (4, np.pi / 3), (1, np.pi * 5 / 6)):
        towards = [positions[1], positions[1 + steps]]
        # The hub is corner 0 of every triangle; the rim vertex 1 + i is in triangle i.
        bend = judge._bend_at_vertex(0, 0, steps, *towards)
        assert bend == pytest.approx(lack, abs=1e-12)
