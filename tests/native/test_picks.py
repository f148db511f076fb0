"""The contract of `picks` and of `sp.SurfacePoint`: kinds, ranges, order, duplicates."""

import copy
import pickle
from collections import deque

import numpy as np
import pytest

import smooth_polylines as sp
from native.invariants import SurfaceChecker, same_line
from native.made_meshes import make_grid, make_square

GRID = make_grid(6)
MESH = sp.SurfaceMesh(*GRID)
THIRD = (1 / 3, 1 / 3, 1 / 3)
INSIDE = (0.2, 0.3, 0.5)


def strip_line(picks, **options):
    return MESH.polyline(picks, filter="none", **options)


@pytest.mark.parametrize(
    "picks",
    [
        (3, 37, 71),
        range(3, 72, 34),
        deque([3, 37, 71]),
        np.array([3, 37, 71]),
        np.array([3, 37, 71], np.uint8),
        np.array([3, 37, 71], ">u8"),
        np.array([3, 0, 37, 0, 71])[::2],
        [np.int16(3), np.uint64(37), 71],
        [3, sp.SurfacePoint(37, THIRD), (71, THIRD)],
        [3, [37, list(THIRD)], (np.int32(71), np.array(THIRD))],
        np.array([3, (37, THIRD), sp.SurfacePoint(71, THIRD)], dtype=object),
    ],
    ids=str,
)
def test_every_kind_of_sequence_and_pick_gives_the_same_line(picks):
    assert same_line(strip_line(picks), strip_line([3, 37, 71]))


@pytest.mark.parametrize(
    ("picks", "message"),
    [
        (5, "found int"),
        (None, "found NoneType"),
        ("12", "found str"),
        (b"12", "found bytes"),
        ({1, 2}, "found set"),
        ({1: 2}, "found dict"),
        pytest.param(iter([1, 2]), "found list_iterator", id="iterator"),
        ([1.0, 2], "entry 0 is of type float"),
        ([1, np.float64(2)], "entry 1 is of type float64"),
        ([1, True], "entry 1 is of type bool"),
        ([1, np.True_], "entry 1 is of type bool"),
        ([1, None], "entry 1 is of type NoneType"),
        ([1, "2"], "entry 1 is of type str"),
        ((5, INSIDE), "entry 1 is a sequence of 3 values"),
        ([(5, INSIDE, 1)], "entry 0 is a sequence of 3 values"),
        ([()], "entry 0 is a sequence of 0 values"),
        ([(5, (0.5, 0.5))], "entry 0 is a pair whose second value is not three numbers"),
        ([(5, (0.2, 0.2, 0.3, 0.3))], "entry 0 is a pair whose second value is not three numbers"),
        ([(5, "abc")], "entry 0 is a pair whose second value is not three numbers"),
        ([(5, 1.0)], "entry 0 is a pair whose second value is not three numbers"),
        ([(5, (1.0, 0.0, None))], "entry 0 is a pair whose second value is not three numbers"),
        ([(5.0, INSIDE)], "entry 0 is a pair whose triangle id is of type float"),
        ([(True, INSIDE)], "entry 0 is a pair whose triangle id is of type bool"),
        (np.array([1.0, 2.0]), "has dtype float64"),
        (np.array([True, False]), "has dtype bool"),
        (np.array([[1, 2]]), r"has shape \(1, 2\)"),
        (np.array(3), r"has shape \(\)"),
    ],
    ids=str,
)
def test_what_is_no_pick_is_a_type_error_that_names_the_entry(picks, message):
    with pytest.raises(TypeError, match=f"^picks: {message}"):
        strip_line(picks)


@pytest.mark.parametrize("wrong", [-1, 72, 2**31, 2**32, 2**63, -(2**63), 2**64])
def test_an_id_out_of_range_is_an_option_error_that_names_it(wrong):
    for pick in (wrong, (wrong, INSIDE)):
        with pytest.raises(sp.OptionError, match=f"^picks: pick 1 .*{wrong}.*72"):
            strip_line([0, pick])
    strip_line([0, 71])


@pytest.mark.parametrize("wrong", [2**127, -(2**127) - 1, 10**5000], ids=["2^127", "-2^127 - 1", "10^5000"])
def test_an_id_beyond_every_integer_type_is_an_option_error(wrong):
    for pick in (wrong, (wrong, INSIDE)):
        with pytest.raises(sp.OptionError, match=r"^picks: pick 1 is an integer of more than 127 bits"):
            strip_line([0, pick])


INSIDE_OR_OUT = [
    ((1, 0, 0), True),
    ((0.5, 0.5, 0), True),
    ((-0.9e-9, 0.5, 0.5), True),
    ((-1.1e-9, 0.5, 0.5), False),
    ((0.5, 0.5 + 0.9e-6, 0), True),
    ((0.5, 0.5 + 1.1e-6, 0), False),
    ((0.5, 0.5 - 0.9e-6, 0), True),
    ((0.5, 0.5 - 1.1e-6, 0), False),
    ((2, -1, 0), False),
    ((0, 0, 0), False),
    ((np.nan, 0.5, 0.5), False),
    ((np.inf, 0, 0), False),
    ((np.inf, -np.inf, 1), False),
    ((1e308, 1e308, 1e308), False),
]


@pytest.mark.parametrize(("barycentric", "is_taken"), INSIDE_OR_OUT, ids=str)
def test_barycentric_parts_just_inside_and_just_outside(barycentric, is_taken):
    if is_taken:
        line = strip_line([(30, barycentric), 71])
        SurfaceChecker(*GRID).check(line)
        assert sp.SurfacePoint(30, barycentric).barycentric == barycentric
        return
    with pytest.raises(sp.OptionError, match=r"^picks: .*barycentric"):
        strip_line([(30, barycentric), 71])
    with pytest.raises(sp.OptionError, match=r"^barycentric: "):
        sp.SurfacePoint(30, barycentric)


def test_a_pair_and_a_surface_point_are_the_same_pick_to_the_bit():
    rng = np.random.default_rng(1)
    for weights in rng.dirichlet([1, 1, 1], 50):
        skewed = weights * (1 + rng.uniform(-9e-7, 9e-7))
        pair, point = (30, skewed), sp.SurfacePoint(30, skewed)
        assert same_line(strip_line([pair, 71]), strip_line([point, 71]))


def test_normalised_weights_are_kept_to_the_bit():
    line = strip_line([(30, (0.5, 0.25, 0.25)), 71])
    assert line.barycentric[0].tolist() == [0.5, 0.25, 0.25]
    assert strip_line([(line.triangles[0], line.barycentric[0]), 71]).points.tobytes() == line.points.tobytes()


def test_one_distinct_pick_gives_one_point_and_no_length():
    for picks in ([7], [7, 7, 7], [(7, INSIDE)], [(7, INSIDE), (7, INSIDE)]):
        for filter_name in ("none", "linear", "cubic", "geodesic", "fair"):
            line = MESH.polyline(picks, filter=filter_name)
            assert line.points.shape == (1, 3)
            assert line.segment_triangles.shape == (0,)
            assert (line.length, line.strip.tolist()) == (0, [7])
            assert str(line.length) == "0.0"
            assert (line.report.stop_reason, line.report.iterations) == ("converged", 0)


@pytest.mark.parametrize("picks", [[], (), np.array([], int), range(0)])
@pytest.mark.parametrize("closed", [False, True])
def test_no_pick_is_an_option_error(picks, closed):
    with pytest.raises(sp.OptionError, match=r"^picks: "):
        strip_line(picks, closed=closed)


@pytest.mark.parametrize("picks", [[1], [1, 9], [1, 9, 1], [1, 1, 9, 9, 1, 1], [1, 9, 9]])
def test_a_closed_line_needs_three_distinct_picks(picks):
    with pytest.raises(sp.OptionError, match=r"^picks: .*3"):
        strip_line(picks, closed=True)
    with pytest.raises(sp.OptionError, match=r"^picks: .*3"):
        MESH.polyline(picks, closed=True)


def test_equal_neighbours_count_once_and_a_closed_line_drops_the_repeated_first():
    open_line = strip_line([3, 37, 71])
    assert same_line(strip_line([3, 3, 37, 37, 37, 71]), open_line)
    closed_line = strip_line([3, 37, 60], closed=True)
    assert same_line(strip_line([3, 37, 60, 3], closed=True), closed_line)
    assert same_line(strip_line([3, 3, 37, 60, 60, 3, 3], closed=True), closed_line)


def test_several_picks_in_one_triangle_are_legal():
    corners = [(7, (0.8, 0.1, 0.1)), (7, (0.1, 0.8, 0.1)), (7, (0.1, 0.1, 0.8))]
    line = strip_line(corners, pinned="all")
    assert (len(line.points), line.strip.tolist()) == (3, [7])
    SurfaceChecker(*GRID).check(line, pins=corners)
    ring = strip_line(corners, pinned="all", closed=True)
    assert (len(ring.points), ring.segment_triangles.tolist()) == (3, [7, 7, 7])


@pytest.mark.parametrize("filter_name", ["none", "linear", "geodesic"])
def test_a_pick_at_a_vertex_leaves_by_the_best_triangle(filter_name):
    positions, triangles = GRID
    # Vertex 24 is the centre of the grid; the pick names it through each of the triangles round it.
    for triangle, corner in np.argwhere(triangles == 24):
        weights = np.eye(3)[corner]
        line = MESH.polyline([(int(triangle), weights), 71], filter=filter_name)
        SurfaceChecker(positions, triangles).check(line)
        assert line.points[0].tolist() == positions[24].tolist()
        assert 24 in triangles[line.strip[0]]
        # Leaving by the best triangle, the strip does not go round the vertex first.
        assert not any(24 in triangles[t] for t in line.strip[3:])


def test_face_pick_of_a_polygon_is_a_point_of_its_triangle_next_to_the_centre():
    # A pentagon as a fan of three triangles: the middle one holds the centre.
    angle = 2 * np.pi * np.arange(5) / 5
    positions = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(5)])
    mesh = sp.SurfaceMesh(positions, [[0, 1, 2], [0, 2, 3], [0, 3, 4]], [4, 4, 4])
    line = mesh.polyline([4])
    assert line.strip.tolist() == [1]
    with pytest.raises(sp.OptionError, match=r"^picks: pick 0 "):
        mesh.polyline([0])


class TestSurfacePoint:
    def test_is_equal_and_hashable_by_value(self):
        one, same = sp.SurfacePoint(7, (1, 0, 0)), sp.SurfacePoint(np.int64(7), np.array([1.0, -0.0, 0.0]))
        assert one == same
        assert hash(one) == hash(same)
        assert len({one, same, sp.SurfacePoint(8, (1, 0, 0)), sp.SurfacePoint(7, (0, 1, 0))}) == 3
        assert one != 7
        assert one != (7, (1.0, 0.0, 0.0))

    def test_repr_can_be_evaluated(self):
        point = sp.SurfacePoint(7, (0.1, 0.2, 0.7))
        assert eval(repr(point), {"SurfacePoint": sp.SurfacePoint}) == point

    def test_is_copied_and_pickled(self):
        point = sp.SurfacePoint(7, INSIDE)
        assert pickle.loads(pickle.dumps(point)) == point
        assert copy.deepcopy(point) == point

    def test_cannot_be_changed(self):
        point = sp.SurfacePoint(7, INSIDE)
        for name, value in (("triangle", 8), ("barycentric", INSIDE), ("other", 1)):
            with pytest.raises(AttributeError):
                setattr(point, name, value)

    @pytest.mark.parametrize("triangle", [1.0, True, "1", None, (1,)])
    def test_refuses_an_id_of_another_type(self, triangle):
        with pytest.raises(TypeError, match=r"^triangle: found "):
            sp.SurfacePoint(triangle, INSIDE)

    @pytest.mark.parametrize("triangle", [-1, 2**32 - 1, 2**200])
    def test_refuses_an_id_that_no_mesh_can_have(self, triangle):
        with pytest.raises(sp.OptionError, match=r"^triangle: expected a triangle id"):
            sp.SurfacePoint(triangle, INSIDE)
        sp.SurfacePoint(2**32 - 2, INSIDE)

    @pytest.mark.parametrize("weights", [None, 1.0, "abc", (1, 0), (1, 0, 0, 0), (1, 0, "0"), {0, 1}])
    def test_refuses_weights_of_another_type(self, weights):
        with pytest.raises(TypeError, match=r"^barycentric: found "):
            sp.SurfacePoint(0, weights)

    def test_an_id_beyond_the_mesh_is_refused_by_the_line(self):
        mesh = sp.SurfaceMesh(*make_square())
        with pytest.raises(sp.OptionError, match=r"^picks: pick 0 .*2"):
            mesh.polyline([sp.SurfacePoint(2, INSIDE)])
