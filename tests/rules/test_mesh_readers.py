"""The mesh readers of the tests themselves: the same little mesh out of every format, and the fans of polygons."""

import numpy as np
import pytest

import meshes

POSITIONS = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.5, 0.5, 2]], dtype=np.float64)
TRIANGLES = np.array([[0, 2, 1], [0, 3, 2], [0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]], dtype=np.int32)
FACES = np.array([0, 0, 1, 2, 3, 4], dtype=np.int32)  # the base is a quad

OBJ = """# a pyramid
v 0 0 0
v 1 0 0
v 1 1 0
v 0 1 0
v 0.5 0.5 2
vt 0 0
f 1/1 4/1 3/1 2/1
f 1//1 2//1 5//1
f -4 -3 -1
f 3 4 5
f 4 1 5
"""
OFF = """OFF # a pyramid
5 5 0

0 0 0
1 0 0
1 1 0
0 1 0
0.5 0.5 2
4 0 3 2 1
3 0 1 4
3 1 2 4 255 0 0
3 2 3 4
3 3 0 4
"""
PLY_HEADER = (
    "ply\nformat {} 1.0\ncomment a pyramid\nelement vertex 5\nproperty float x\nproperty float y\nproperty uchar red\n"
    "property float z\nelement face {}\nproperty list uchar int vertex_indices\nend_header\n"
)


def make_ply(encoding, polygons):
    header = PLY_HEADER.format(encoding, len(polygons)).encode()
    if encoding == "ascii":
        rows = [f"{x} {y} 7 {z}" for x, y, z in POSITIONS] + [" ".join(map(str, [len(p), *p])) for p in polygons]
        return header + ("\n".join(rows) + "\n").encode()
    order = "<" if "little" in encoding else ">"
    vertices = np.zeros(5, dtype=[("x", order + "f4"), ("y", order + "f4"), ("red", "u1"), ("z", order + "f4")])
    vertices["x"], vertices["y"], vertices["z"] = POSITIONS.T
    faces = b"".join(bytes([len(p)]) + np.array(p, dtype=order + "i4").tobytes() for p in polygons)
    return header + vertices.tobytes() + faces


QUAD_AND_TRIANGLES = [[0, 3, 2, 1], [0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]]
FILES = {
    "pyramid.obj": OBJ.encode(),
    "pyramid.off": OFF.encode(),
    "ascii.ply": make_ply("ascii", QUAD_AND_TRIANGLES),
    "little.ply": make_ply("binary_little_endian", QUAD_AND_TRIANGLES),
    "big.ply": make_ply("binary_big_endian", QUAD_AND_TRIANGLES),
}


@pytest.mark.parametrize("name", FILES)
def test_polygon_file_gives_the_pyramid(tmp_path, name):
    (tmp_path / name).write_bytes(FILES[name])
    mesh = meshes.read_mesh(tmp_path / name)
    np.testing.assert_array_equal(mesh.positions, POSITIONS)
    np.testing.assert_array_equal(mesh.triangle_faces, FACES)
    # The quad is fanned from its first corner: 0 3 2 and 0 2 1.
    np.testing.assert_array_equal(mesh.triangles, [[0, 3, 2], [0, 2, 1], *TRIANGLES[2:]])


def test_binary_ply_of_triangles_alone_is_read_as_one_table(tmp_path):
    (tmp_path / "t.ply").write_bytes(make_ply("binary_little_endian", TRIANGLES.tolist()))
    mesh = meshes.read_mesh(tmp_path / "t.ply")
    np.testing.assert_array_equal(mesh.triangles, TRIANGLES)
    np.testing.assert_array_equal(mesh.triangle_faces, np.arange(6))


@pytest.mark.parametrize("encoding", ["ascii", "binary"])
def test_stl_corners_become_shared_vertices(tmp_path, encoding):
    corners = POSITIONS[TRIANGLES]
    if encoding == "ascii":
        facets = [
            "facet normal 0 0 0\nouter loop\n"
            + "".join(f"vertex {x} {y} {z}\n" for x, y, z in t)
            + "endloop\nendfacet\n"
            for t in corners
        ]
        data = ("solid pyramid\n" + "".join(facets) + "endsolid pyramid\n").encode()
    else:
        table = np.zeros(6, dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
        table["corners"] = corners
        data = b"solid of a binary kind".ljust(80) + np.array([6], dtype="<u4").tobytes() + table.tobytes()
    (tmp_path / "pyramid.stl").write_bytes(data)
    mesh = meshes.read_mesh(tmp_path / "pyramid.stl")
    assert mesh.positions.shape == (5, 3)
    np.testing.assert_array_equal(mesh.positions[mesh.triangles], corners)


def test_missing_folder_skips_with_a_message_and_a_missing_mesh_fails(tmp_path, monkeypatch):
    monkeypatch.setenv("SMOOTH_POLYLINES_MESHES", str(tmp_path / "nowhere"))
    with pytest.raises(pytest.skip.Exception, match=r"needs the test mesh cow\.off.*SMOOTH_POLYLINES_MESHES"):
        meshes.find_shared_mesh("cow.off")
    monkeypatch.setenv("SMOOTH_POLYLINES_MESHES", str(tmp_path))
    with pytest.raises(FileNotFoundError, match=r"cow\.off"):
        meshes.find_shared_mesh("cow.off")
