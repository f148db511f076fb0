"""The contract of the input arrays, and of `on`: what is taken, how the rest is refused."""

import numpy as np
import pytest

import smooth_polylines as sp
from native.made_meshes import make_grid, make_square

POSITIONS, TRIANGLES = make_square()
EXPECTED = sp.SurfaceMesh(POSITIONS, TRIANGLES).polyline([0, 1], filter="none").points


def line_points(positions, triangles, **kwargs):
    return sp.SurfaceMesh(positions, triangles, **kwargs).polyline([0, 1], filter="none").points


def spread(array):
    """The same values with a gap after each and each row: no stride is the natural one."""
    wide = np.zeros((2 * array.shape[0], 2 * array.shape[1]), array.dtype)
    wide[::2, ::2] = array
    return wide[::2, ::2]


def misalign(array):
    raw = np.zeros(array.nbytes + 1, np.uint8)
    shifted = raw[1:].view(array.dtype).reshape(array.shape)
    shifted[:] = array
    assert not shifted.flags.aligned
    return shifted


def freeze(array):
    array = array.copy()
    array.flags.writeable = False
    return array


LAYOUTS = {
    "C": np.ascontiguousarray,
    "Fortran": np.asfortranarray,
    "spread": spread,
    "backwards": lambda array: array[::-1].copy()[::-1],
    "mirrored": lambda array: np.ascontiguousarray(array[:, ::-1])[:, ::-1],
    "misaligned": misalign,
    "read-only": freeze,
    "swapped bytes": lambda array: array.astype(array.dtype.newbyteorder()),
    "subclass": lambda array: array.view(np.ma.MaskedArray),
    "nested list": lambda array: array.tolist(),
    "nested tuple": lambda array: tuple(map(tuple, array.tolist())),
}


@pytest.mark.parametrize("layout", LAYOUTS.values(), ids=LAYOUTS.keys())
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_positions_of_any_layout_give_the_same_line(layout, dtype):
    # The square's coordinates are exact in float32.
    assert line_points(layout(POSITIONS.astype(dtype)), TRIANGLES).tobytes() == EXPECTED.tobytes()


@pytest.mark.parametrize("layout", LAYOUTS.values(), ids=LAYOUTS.keys())
@pytest.mark.parametrize("dtype", ["i1", "i2", "i4", "i8", "u1", "u2", "u4", "u8"])
def test_triangles_of_any_layout_and_integer_type_give_the_same_line(layout, dtype):
    if layout is misalign and dtype in ("i1", "u1"):
        layout = np.ascontiguousarray  # single bytes are always aligned
    assert line_points(POSITIONS, layout(TRIANGLES.astype(dtype))).tobytes() == EXPECTED.tobytes()


@pytest.mark.parametrize("layout", ["C", "Fortran", "spread", "mirrored"])
def test_fortran_order_is_not_mistaken_for_row_order(layout):
    # 3 x 3: shapes cannot give the mistake away.
    positions = np.array([[0.0, 0, 0], [1, 0, 0], [0, 2, 5]])
    mesh = sp.SurfaceMesh(LAYOUTS[layout](positions), LAYOUTS[layout](np.array([[0, 1, 2], [1, 2, 0], [2, 1, 0]])))
    assert mesh.positions.tolist() == positions.tolist()
    assert mesh.triangles.tolist() == [[0, 1, 2], [1, 2, 0], [2, 1, 0]]


def test_positions_are_copied():
    positions = POSITIONS.copy()
    mesh = sp.SurfaceMesh(positions, TRIANGLES)
    positions[:] = np.nan
    assert mesh.polyline([0, 1], filter="none").points.tobytes() == EXPECTED.tobytes()


@pytest.mark.parametrize("dtype", [np.float16, np.longdouble, np.int32, np.bool_, np.complex128, object, "U8"])
def test_positions_of_another_type_are_type_errors(dtype):
    with pytest.raises(TypeError, match=r"^positions: has dtype .*expected float32 or float64"):
        sp.SurfaceMesh(POSITIONS.astype(dtype), TRIANGLES)


@pytest.mark.parametrize("dtype", [np.float64, np.bool_, object, np.complex64, "U8", "m8[s]"])
def test_triangles_of_another_type_are_type_errors(dtype):
    with pytest.raises(TypeError, match=r"^triangles: has dtype .*expected an integer type"):
        sp.SurfaceMesh(POSITIONS, TRIANGLES.astype(dtype))


@pytest.mark.parametrize("shape", [(12,), (4, 2), (4, 4), (1, 4, 3), (3, 4), ()])
def test_positions_of_another_shape_are_type_errors(shape):
    with pytest.raises(TypeError, match=r"^positions: has shape \(.*\), expected \(V, 3\)"):
        sp.SurfaceMesh(np.zeros(shape), TRIANGLES)


@pytest.mark.parametrize("shape", [(6,), (2, 4), (2, 2), (1, 2, 3), ()])
def test_triangles_of_another_shape_are_type_errors(shape):
    with pytest.raises(TypeError, match=r"^triangles: has shape \(.*\), expected \(F, 3\)"):
        sp.SurfaceMesh(POSITIONS, np.zeros(shape, np.int32))


@pytest.mark.parametrize("shape", [(2, 1), (1, 2), ()])
def test_triangle_faces_of_another_shape_are_type_errors(shape):
    with pytest.raises(TypeError, match=r"^triangle_faces: has shape \(.*\), expected \(F,\)"):
        sp.SurfaceMesh(POSITIONS, TRIANGLES, np.zeros(shape, np.int32))


@pytest.mark.parametrize("value", [None, "positions", 3.5, [[0, 1], [2]], object(), {}])
def test_what_is_no_array_is_a_type_error(value):
    for arguments in [(value, TRIANGLES), (POSITIONS, value)]:
        name = "positions" if arguments[0] is value else "triangles"
        with pytest.raises(TypeError, match=f"^{name}: "):
            sp.SurfaceMesh(*arguments)


def test_an_exception_from_an_array_like_is_kept_as_cause():
    class Broken:
        def __array__(self, dtype=None, copy=None):
            raise RuntimeError("no values today")

    with pytest.raises(TypeError, match=r"^positions: .*no values today") as caught:
        sp.SurfaceMesh(Broken(), TRIANGLES)
    assert isinstance(caught.value.__cause__, RuntimeError)


@pytest.mark.parametrize("positions", [np.zeros((0, 3)), POSITIONS, POSITIONS.astype(np.float32)[:0]])
def test_empty_arrays_are_legal_meshes(positions):
    mesh = sp.SurfaceMesh(positions, np.zeros((0, 3), np.int32), np.zeros(0, np.int32))
    assert (mesh.report.triangles, mesh.report.parts) == (0, 0)
    assert mesh.report.unreferenced_vertices == len(positions)
    with pytest.raises(sp.OptionError, match=r"^picks"):
        mesh.polyline([0])


@pytest.mark.parametrize(
    ("dtype", "value"),
    [("i1", -1), ("i4", 4), ("i4", -(2**31)), ("i8", 2**40), ("i8", -(2**63)), ("u4", 2**32 - 1), ("u8", 2**64 - 1)],
)
def test_an_index_out_of_range_is_named_with_its_row(dtype, value):
    triangles = np.vstack([TRIANGLES, TRIANGLES, TRIANGLES]).astype(dtype)
    triangles[3, 1] = value
    triangles[5, 0] = value  # a second offender is not the one named
    with pytest.raises(sp.MeshError, match=rf"^triangles\[3\] names vertex {value}, but positions has 4 rows"):
        sp.SurfaceMesh(POSITIONS, triangles)


def test_the_last_index_is_in_range_and_the_next_is_not():
    sp.SurfaceMesh(POSITIONS, [[0, 1, 3]])
    with pytest.raises(sp.MeshError, match=r"^triangles\[0\] names vertex 4"):
        sp.SurfaceMesh(POSITIONS, [[0, 1, 4]])
    with pytest.raises(sp.MeshError, match=r"^triangles\[0\] names vertex -1"):
        sp.SurfaceMesh(POSITIONS, [[0, 1, -1]])


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_a_position_that_is_not_finite_is_named_when_a_triangle_uses_it(value, dtype):
    positions = np.vstack([POSITIONS, [[0, 0, 0]]]).astype(dtype)
    positions[4, 2] = value
    sp.SurfaceMesh(positions, TRIANGLES)  # vertex 4 is not used
    positions[2, 1] = value
    with pytest.raises(sp.MeshError, match=r"^positions\[2\] is .*triangles\[0\]"):
        sp.SurfaceMesh(positions, TRIANGLES)


def test_a_triangle_that_repeats_a_vertex_is_named():
    with pytest.raises(sp.MeshError, match=r"^triangles\[1\] is \[3, 0, 3\] and repeats a vertex"):
        sp.SurfaceMesh(POSITIONS, [[0, 1, 2], [3, 0, 3], [1, 1, 1]])


@pytest.mark.parametrize("dtype", ["i1", "u2", "i4", "u4", "i8", "u8"])
def test_triangle_faces_make_picks_polygon_ids(dtype):
    positions, triangles = make_grid(3)
    faces = np.repeat(np.arange(9), 2).astype(dtype)
    mesh = sp.SurfaceMesh(positions, triangles, faces)
    assert mesh.report.faces == 9
    line = mesh.polyline([0, 8], filter="none")
    # Ids in results stay rows of `triangles`.
    assert line.strip[0] in (0, 1)
    assert line.strip[-1] in (16, 17)
    with pytest.raises(sp.OptionError, match=r"^picks.*9"):
        mesh.polyline([0, 9])


@pytest.mark.parametrize("count", [1, 3])
def test_triangle_faces_of_another_length_are_refused(count):
    sp.SurfaceMesh(POSITIONS, TRIANGLES, np.zeros(2, int))
    with pytest.raises(sp.MeshError, match=f"^triangle_faces has {count} entries, but triangles has 2 rows"):
        sp.SurfaceMesh(POSITIONS, TRIANGLES, np.zeros(count, int))


def test_face_ids_are_from_0_to_the_last_of_32_bits_but_one():
    sp.SurfaceMesh(POSITIONS, TRIANGLES, np.array([0, 2**32 - 2]))
    for wrong in (-1, 2**32 - 1, 2**40):
        with pytest.raises(sp.MeshError, match=rf"^triangle_faces\[1\] is {wrong}, "):
            sp.SurfaceMesh(POSITIONS, TRIANGLES, np.array([0, wrong]))
    with pytest.raises(TypeError, match=r"^triangle_faces: has dtype float64"):
        sp.SurfaceMesh(POSITIONS, TRIANGLES, np.zeros(2))


@pytest.mark.parametrize("layout", LAYOUTS.values(), ids=LAYOUTS.keys())
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_on_takes_every_layout(layout, dtype):
    line = sp.SurfaceMesh(POSITIONS, TRIANGLES).polyline([0, 1], filter="none")
    moved = (POSITIONS * 2 + 1).astype(dtype)
    assert np.allclose(line.on(layout(moved)), line.points * 2 + 1, rtol=0, atol=1e-15)


def test_on_refuses_other_rows_types_and_ranks():
    line = sp.SurfaceMesh(POSITIONS, TRIANGLES).polyline([0, 1], filter="none")
    for rows in (3, 5):
        with pytest.raises(sp.OptionError, match=f"^new_positions: has {rows} rows, expected 4"):
            line.on(np.zeros((rows, 3)))
    with pytest.raises(TypeError, match=r"^new_positions: has dtype int64"):
        line.on(POSITIONS.astype(int))
    with pytest.raises(TypeError, match=r"^new_positions: has shape \(4, 2\)"):
        line.on(POSITIONS[:, :2])


def test_on_gives_a_fresh_array_and_lets_odd_values_through():
    line = sp.SurfaceMesh(POSITIONS, TRIANGLES).polyline([0, 1], filter="none")
    first, second = line.on(POSITIONS), line.on(POSITIONS)
    first[:] = 7
    assert second.tobytes() == line.points.tobytes()
    assert np.isnan(line.on(np.full_like(POSITIONS, np.nan))).all()


def test_results_cannot_be_written_to_and_are_kept():
    line = sp.SurfaceMesh(POSITIONS, TRIANGLES).polyline([0, 1], filter="none")
    for name in ("points", "triangles", "barycentric", "segment_triangles", "strip", "strip_bits"):
        assert getattr(line, name) is getattr(line, name)
        with pytest.raises(ValueError, match="read-only"):
            getattr(line, name)[...] = 0
