"""Arrays of any make at the Python border: what the plain contiguous copy gives, or a named refusal; never a panic."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

import smooth_polylines as sp
from native.made_meshes import make_grid

POSITIONS, TRIANGLES = make_grid(3)
MESH = sp.SurfaceMesh(POSITIONS, TRIANGLES)
REFUSALS = (TypeError, sp.MeshError, sp.OptionError, sp.NoPathError, sp.CollapsedError)

INTEGERS = ["b", "B", "h", "H", "i", "I", "q", "Q"]
FLOATS = ["e", "f", "d", "g"]
OTHERS = ["?", "F", "O", "S8", "U4", "M8[s]", "V8", [("x", "d")]]
DTYPES = st.one_of(st.sampled_from(INTEGERS + FLOATS), st.sampled_from(OTHERS))
ODD_VALUES = [np.nan, np.inf, -np.inf, -1, 2**31, 2**32, -(2**63), 2**63, 1e151, 1e308, 0.5]
quick = settings(max_examples=150, deadline=None)


def laid_out(array, way):
    """The same values in another layout."""
    if way == "Fortran":
        return np.asfortranarray(array)
    if way == "backwards":
        return array[::-1].copy()[::-1]
    if way == "strided":
        wide = np.zeros((*array.shape[:-1], 2 * array.shape[-1]), array.dtype) if array.ndim else array
        wide[..., ::2] = array
        return wide[..., ::2]
    if way == "swapped":
        return array.astype(array.dtype.newbyteorder())
    if way == "read-only":
        array = array.copy()
        array.flags.writeable = False
        return array
    if way == "transposed twice":
        return np.ascontiguousarray(array.T).T
    return array


WAYS = st.sampled_from(["plain", "Fortran", "backwards", "strided", "swapped", "read-only", "transposed twice"])


@st.composite
def arrays_like(draw, good):
    """Arrays near a good one: another dtype and layout, some values odd, rows or columns missing or more."""
    array = np.array(good)
    dtype = draw(DTYPES)
    try:
        with np.errstate(all="ignore"):
            array = array.astype(dtype)
    except (TypeError, ValueError, OverflowError, DeprecationWarning):
        array = np.zeros(array.shape, dtype)
    for _ in range(draw(st.integers(0, 2))):
        place = draw(st.integers(0, array.size - 1))
        try:
            with np.errstate(all="ignore"):
                array.reshape(-1)[place] = draw(st.sampled_from(ODD_VALUES))
        except (TypeError, ValueError, OverflowError, DeprecationWarning):
            pass
    shape = draw(
        st.sampled_from(["as it is"] * 6 + ["no rows", "a row less", "two columns", "flat", "deep", "no rank"])
    )
    if shape == "no rows":
        array = array[:0]
    elif shape == "a row less":
        array = array[:-1]
    elif shape == "two columns":
        array = array[..., :2]
    elif shape == "flat":
        array = array.reshape(-1)
    elif shape == "deep":
        array = array[None]
    elif shape == "no rank":
        array = array.reshape(-1)[0:1].reshape(())
    return laid_out(array, draw(WAYS)) if array.ndim and array.size else array


def outcome(call):
    """What a call gives, as bytes, or the kind and words of its refusal; all else is raised and fails the test."""
    try:
        return call()
    except REFUSALS as error:
        return type(error), str(error)


def same_as_plain(call, array):
    """The call on the array gives what it gives on the plain contiguous copy."""
    plain = np.array(array, dtype=array.dtype.newbyteorder("="), order="C", copy=True)
    found, expected = outcome(lambda: call(array)), outcome(lambda: call(plain))
    if isinstance(found, tuple) and array.dtype != plain.dtype:
        # The words name the dtype, and its byte order.
        found, expected = found[0], expected[0]
    assert found == expected


@quick
@given(arrays_like(POSITIONS))
def test_positions(array):
    same_as_plain(lambda a: sp.SurfaceMesh(a, TRIANGLES).polyline([0, 17], filter="geodesic").to_bytes(), array)


@quick
@given(arrays_like(TRIANGLES))
def test_triangles(array):
    same_as_plain(lambda a: sp.SurfaceMesh(POSITIONS, a).polyline([0, len(a) - 1]).to_bytes(), array)


@quick
@given(arrays_like(np.arange(18) // 2))
def test_triangle_faces(array):
    same_as_plain(lambda a: sp.SurfaceMesh(POSITIONS, TRIANGLES, a).polyline([0, 8]).to_bytes(), array)


@quick
@given(arrays_like(np.array([0, 5, 17, 9])))
def test_picks_as_an_array(array):
    same_as_plain(lambda a: MESH.polyline(a, pinned="all").to_bytes(), array)


@quick
@given(arrays_like(POSITIONS[[0, 5, 10, 15]] + 0.01))
def test_strokes_and_nearest_points(array):
    same_as_plain(lambda a: MESH.stroke(a, filter="none").to_bytes(), array)
    same_as_plain(lambda a: MESH.closest_points(a).distances.tobytes(), array)


@quick
@given(arrays_like(np.array([[0, 1], [1, 2], [2, 0]])))
def test_connections(array):
    same_as_plain(lambda a: [line and line.to_bytes() for line in MESH.network([0, 5, 17], a).lines], array)


@quick
@given(arrays_like(POSITIONS))
def test_moved_positions(array):
    line = MESH.polyline([0, 17])
    same_as_plain(lambda a: line.on(a).tobytes(), array)


@quick
@given(
    st.lists(
        st.one_of(
            st.integers(-(2**70), 2**70),
            st.integers(0, 17),
            st.floats(),
            st.none(),
            st.text(max_size=2),
            st.tuples(st.integers(-1, 19), st.lists(st.floats(-0.1, 1.1), max_size=4)),
        ),
        max_size=5,
    ),
    st.booleans(),
    st.sampled_from(["none", "linear", "cubic", "geodesic", "fair"]),
)
def test_picks_of_anything(picks, closed, name):
    first = outcome(lambda: MESH.polyline(picks, closed=closed, filter=name).to_bytes())
    assert first == outcome(lambda: MESH.polyline(list(picks), closed=closed, filter=name).to_bytes())


@quick
@given(st.binary(max_size=80), st.integers(0, 200), st.binary(min_size=1, max_size=8))
def test_bytes_of_anything(head, place, patch):
    whole = bytearray(MESH.polyline([0, 17, 4], pinned="all").to_bytes())
    whole[place : place + len(patch)] = patch
    for data in (head, bytes(whole)):
        made = outcome(lambda data=data: MESH.line_from_bytes(data).to_bytes())
        assert isinstance(made, tuple) or made == data


@settings(max_examples=20, deadline=None)
@given(st.lists(arrays_like(POSITIONS), min_size=4, max_size=4))
def test_threads_that_call_at_once_get_what_each_gets_alone(arrays):
    def call(array):
        return outcome(lambda: sp.SurfaceMesh(array, TRIANGLES).polyline([0, 17, 4], filter="fair").to_bytes())

    alone = [call(array) for array in arrays]
    with ThreadPoolExecutor(8) as pool:
        assert list(pool.map(call, arrays * 4)) == alone * 4
