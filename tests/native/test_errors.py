"""The exceptions: their bases, their messages, and that none of them is a panic."""

import pickle

import numpy as np
import pytest

import smooth_polylines as sp
from native.made_meshes import make_grid

NAMES = ("MeshError", "OptionError", "NoPathError", "CollapsedError", "LimitError", "InternalError")


def test_all_errors_have_one_base_and_the_bases_of_the_contract():
    assert sp.Error.__bases__ == (Exception,)
    assert sp.MeshError.__bases__ == (sp.Error, ValueError)
    assert sp.OptionError.__bases__ == (sp.Error, ValueError)
    assert sp.NoPathError.__bases__ == (sp.Error,)
    assert sp.CollapsedError.__bases__ == (sp.Error,)
    assert sp.LimitError.__bases__ == (sp.Error, TimeoutError)
    assert sp.InternalError.__bases__ == (sp.Error,)


@pytest.mark.parametrize("name", ["Error", *NAMES])
def test_an_error_is_known_by_its_public_name_and_can_be_pickled(name):
    error = getattr(sp, name)
    assert f"{error.__module__}.{error.__qualname__}" == f"smooth_polylines.{name}"
    assert error.__doc__
    again = pickle.loads(pickle.dumps(error("what, where, advice")))
    assert type(again) is error
    assert str(again) == "what, where, advice"


def make_two_squares():
    positions, triangles = make_grid(2)
    return np.vstack([positions, positions + 5]), np.vstack([triangles, triangles + len(positions)])


@pytest.mark.parametrize("filter_name", ["none", "linear", "cubic", "geodesic", "fair"])
def test_picks_on_two_parts_are_a_no_path_error_that_names_them_and_the_parts(filter_name):
    mesh = sp.SurfaceMesh(*make_two_squares())
    assert mesh.report.parts == 2
    message = (
        r"^picks 1 and 2 lie on parts of the mesh that are not connected \(2 parts\); "
        r"join them or merge vertices by distance first$"
    )
    with pytest.raises(sp.NoPathError, match=message):
        mesh.polyline([0, 3, 12], filter=filter_name)


def test_a_wall_separates():
    # Three triangles on one edge: nothing crosses it.
    positions = np.array([[0.0, 0, 0], [0, 0, 1], [1, 0, 0], [-1, 1, 0], [-1, -1, 0]])
    mesh = sp.SurfaceMesh(positions, [[0, 1, 2], [0, 1, 3], [0, 1, 4]])
    assert (mesh.report.wall_edges, mesh.report.parts) == (1, 3)
    with pytest.raises(sp.NoPathError, match=r"picks 0 and 1 .*\(3 parts\)"):
        mesh.polyline([0, 1])


def test_the_last_pick_of_a_closed_line_has_to_reach_the_first():
    mesh = sp.SurfaceMesh(*make_two_squares())
    with pytest.raises(sp.NoPathError, match=r"^picks 1 and 2 "):
        mesh.polyline([0, 3, 9], closed=True)


def test_an_error_leaves_the_mesh_usable():
    mesh = sp.SurfaceMesh(*make_two_squares())
    before = mesh.polyline([0, 7], filter="none").to_bytes()
    for _ in range(3):
        with pytest.raises(sp.NoPathError):
            mesh.polyline([0, 9])
        with pytest.raises(sp.OptionError):
            mesh.polyline([0, 99])
    assert mesh.polyline([0, 7], filter="none").to_bytes() == before


@pytest.mark.parametrize("closed_filter", ["linear", "geodesic"])
def test_a_closed_line_that_shrinks_to_a_point_is_a_collapsed_error(closed_filter):
    # In the plane nothing holds a loop open.
    mesh = sp.SurfaceMesh(*make_grid(8))
    with pytest.raises(sp.CollapsedError, match=r"closed line shrank to a point.*pin some picks"):
        mesh.polyline([20, 90, 60], closed=True, filter=closed_filter)


def test_objects_of_the_library_are_made_by_it_alone():
    for name in ("Polyline", "Report", "MeshReport", "Network"):
        with pytest.raises(TypeError):
            getattr(sp, name)()
    for attribute in ("report", "positions", "extra"):
        with pytest.raises(AttributeError):
            setattr(sp.SurfaceMesh(*make_grid(1)), attribute, None)
