"""Several lines in one call: each is the line that `polyline` makes, or the error that it raises."""

import gc
import weakref

import numpy as np
import pytest

import smooth_polylines as sp
from native.invariants import same_line
from native.made_meshes import make_grid
from native.surfaces import open_surface


@pytest.mark.parametrize("filter_name", ["none", "linear", "cubic", "geodesic", "fair"])
@pytest.mark.parametrize("name", ["terrain", "sphere", "cow.off"])
def test_a_network_is_its_lines(name, filter_name):
    surface = open_surface(name)
    picks = surface.random_picks(10, 1)
    rng = np.random.default_rng(2)
    connections = np.array([rng.choice(10, 2, replace=False) for _ in range(19)])
    net = surface.mesh.network(picks, connections, filter=filter_name)
    assert len(net) == len(net.lines) == len(net.errors) == 19
    assert net.errors == [None] * 19
    for line, (start, goal) in zip(net, connections, strict=True):
        assert same_line(line, surface.mesh.polyline([picks[start], picks[goal]], filter=filter_name))
        surface.checker.check(line)
    assert set(net.seconds) == {"search", "relax", "vertex_pass", "assemble", "total"}


def make_parts():
    positions, triangles = make_grid(3)
    return sp.SurfaceMesh(np.vstack([positions, positions + 5]), np.vstack([triangles, triangles + len(positions)]))


def test_a_connection_that_fails_leaves_the_others():
    net = make_parts().network([0, 9, 20, 30], [[0, 1], [1, 2], [2, 3], [3, 0]])
    assert [line is not None for line in net] == [True, False, True, False]
    assert [type(error) for error in net.errors] == [type(None), sp.NoPathError, type(None), sp.NoPathError]
    # Named by their places in the picks of the call.
    assert str(net.errors[1]).startswith("picks 1 and 2 lie on parts")
    assert str(net.errors[3]).startswith("picks 3 and 0 lie on parts")
    assert repr(net) == "<Network: 4 connections, 2 lines, 2 errors>"
    with pytest.raises(sp.NoPathError, match=r"picks 1 and 2"):
        raise net.errors[1]


def test_a_network_is_indexed_like_a_sequence():
    net = make_parts().network([0, 9, 20], [[0, 1], [1, 2]])
    assert net[0] is net.lines[0] is net[-2]
    assert net[1] is None is net[-1]
    for index in (2, -3, 2**62):
        with pytest.raises(IndexError):
            net[index]
    with pytest.raises(TypeError):
        net["0"]
    assert list(net) == net.lines


@pytest.mark.parametrize("dtype", ["i1", "u2", "i8", "u8", ">i4"])
def test_connections_are_of_any_integer_type(dtype):
    mesh = make_parts()
    expected = mesh.network([0, 9], [[0, 1]])
    assert same_line(mesh.network([0, 9], np.array([[0, 1]], dtype))[0], expected[0])
    assert same_line(mesh.network([0, 9], np.asfortranarray([[0, 1], [1, 0]], dtype))[0], expected[0])


def test_no_connections_are_an_empty_network():
    net = make_parts().network([0, 9], np.zeros((0, 2), int))
    assert (len(net), net.lines, net.errors, list(net)) == (0, [], [], [])


@pytest.mark.parametrize("wrong", [-1, 2, 2**40, -(2**63)])
def test_a_connection_to_no_pick_is_an_option_error(wrong):
    with pytest.raises(sp.OptionError, match=rf"^connections: row 1 .*{wrong}.*2 picks"):
        make_parts().network([0, 9], [[0, 1], [1, wrong]])


@pytest.mark.parametrize("connections", [None, [0, 1], [[0, 1, 2]], [[0.0, 1.0]], [[True, False]], [[0], [1, 2]]])
def test_connections_of_another_type_or_shape_are_type_errors(connections):
    with pytest.raises(TypeError, match=r"^connections: "):
        make_parts().network([0, 9], connections)


@pytest.mark.parametrize(
    ("options", "argument"),
    [({"filter": "cubik"}, "filter"), ({"threshold": 0}, "threshold"), ({"max_iterations": 0}, "max_iterations")],
)
def test_a_wrong_option_is_raised_by_the_call_itself(options, argument):
    with pytest.raises(sp.OptionError, match=f"^{argument}: "):
        make_parts().network([0, 9], [[0, 1]], **options)


def test_a_pick_out_of_range_fails_the_lines_that_use_it():
    net = make_parts().network([0, 9, 99], [[0, 1], [1, 2]])
    assert [line is not None for line in net] == [True, False]
    assert type(net.errors[1]) is sp.OptionError
    assert str(net.errors[1]).startswith("picks: pick 2 is triangle 99")


def test_a_raised_error_does_not_keep_the_network_alive():
    class Marker:
        pass

    def hold():
        marker = Marker()
        net = make_parts().network([0, 20], [[0, 1]])
        try:
            raise net.errors[0]
        except sp.NoPathError:
            return weakref.ref(marker)

    alive = hold()
    gc.collect()
    assert alive() is None


def test_connections_by_a_word():
    mesh = make_parts()
    for word, expected in (
        ("all", [[0, 1], [0, 2], [1, 2]]),
        ("chain", [[0, 1], [1, 2]]),
        ("loop", [[0, 1], [1, 2], [2, 0]]),
    ):
        assert mesh.network([0, 9, 4], word).connections.tolist() == expected
    with pytest.raises(sp.OptionError, match=r'^connections: found "chains", .*did you mean "chain"'):
        mesh.network([0, 9], "chains")
    for word, picks in (("all", [0]), ("loop", [0, 9]), ("automatic", [])):
        with pytest.raises(sp.OptionError, match=r"^picks: found \d picks"):
            mesh.network(picks, word)
    with pytest.raises(TypeError, match="^avoid_crossings: "):
        mesh.network([0, 9], "all", avoid_crossings="no")
