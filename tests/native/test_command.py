"""`python -m smooth_polylines`: a line from a mesh file into a file, and every refusal in one line."""

import doctest
import json
import subprocess
import sys

import numpy as np
import pytest

import meshes
import smooth_polylines as sp
from smooth_polylines import __main__ as command
from smooth_polylines import line_files, mesh_files

pytest.importorskip("meshio")

GRID = 8


def make_grid_obj():
    """A square of GRID x GRID quads, two of them as triangles."""
    rows = [f"v {x} {y} 0" for y in range(GRID + 1) for x in range(GRID + 1)]
    for y in range(GRID):
        for x in range(GRID):
            a = y * (GRID + 1) + x + 1
            corners = [a, a + 1, a + GRID + 2, a + GRID + 1]
            rows.append("f " + " ".join(map(str, corners)))
    return "\n".join(rows) + "\n"


@pytest.fixture
def mesh_file(tmp_path):
    path = tmp_path / "grid.obj"
    path.write_text(make_grid_obj())
    return path


def test_as_in_the_readme(mesh_file, tmp_path):
    words = [mesh_file, "--picks", "0,27,63", "--filter", "geodesic", "-o", tmp_path / "line.obj"]
    done = subprocess.run(
        [sys.executable, "-m", "smooth_polylines", *map(str, words)], capture_output=True, text=True, timeout=60
    )
    assert done.returncode == 0, done.stderr
    assert "64 faces, read by smooth_polylines" in done.stdout
    assert "converged" in done.stdout
    rows = (tmp_path / "line.obj").read_text().splitlines()
    points = np.array([[float(w) for w in row.split()[1:]] for row in rows[:-1]])
    assert rows[-1] == "l " + " ".join(map(str, range(1, len(points) + 1)))
    # Faces are the file's, also where they are quads.
    np.testing.assert_allclose(points[[0, -1]] // 1, [[0, 0, 0], [7, 7, 0]])


@pytest.mark.parametrize("suffix", line_files.WRITERS)
def test_every_form_holds_the_line(mesh_file, tmp_path, suffix):
    output = tmp_path / f"line{suffix}"
    arguments = [str(mesh_file), "--picks", "0,7,63,56", "--closed", "--pinned", "all", "--filter", "fair"]
    assert command.main([*arguments, "-o", str(output)]) == 0
    read = mesh_files.read_mesh(mesh_file)
    mesh = sp.SurfaceMesh(read.positions, read.triangles, read.triangle_faces)
    line = mesh.polyline([0, 7, 63, 56], closed=True, pinned="all", filter="fair")
    if suffix == ".npz":
        with np.load(output) as arrays:
            np.testing.assert_array_equal(arrays["points"], line.points)
            assert arrays["closed"]
    elif suffix == ".json":
        assert json.loads(output.read_text())["points"] == line.points.tolist()
    elif suffix == ".csv":
        table = np.genfromtxt(output, delimiter=",", names=True)
        np.testing.assert_array_equal(np.stack([table[c] for c in "xyz"], axis=1), line.points)
    else:
        assert output.read_text().splitlines()[-1].endswith(f" {len(line.points)} 1")


@pytest.mark.parametrize("suffix", [".ply", ".stl", ".off", ".glb"])
def test_other_formats(tmp_path, suffix):
    trimesh = pytest.importorskip("trimesh")
    ball = trimesh.creation.icosphere(3)
    ball.export(tmp_path / f"ball{suffix}")
    read = mesh_files.read_mesh(tmp_path / f"ball{suffix}")
    assert len(read.triangles) == len(ball.faces)
    assert read.reader == ("trimesh" if suffix == ".glb" else "meshio")
    np.testing.assert_allclose(read.positions[read.triangles].sum(), ball.triangles.sum(), atol=1e-3)


def test_obj_with_uv_seams_negative_numbers_and_continued_rows(tmp_path):
    path = tmp_path / "seams.OBJ"
    path.write_text(
        "# comment\nmtllib x.mtl\nv 0 0 0 1.0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvt .5 .5\n"
        "vn 0 0 1\nf 1/1/1 2/2/1 3/3/1\nf -4//1 -2//1 \\\n -1//1 # the other half\n"
    )
    read = mesh_files.read_mesh(path)
    assert read.positions.tolist() == [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
    assert read.triangles.tolist() == [[0, 1, 2], [0, 2, 3]]
    assert read.triangle_faces.tolist() == [0, 1]


def test_real_obj_with_uv_seams_is_one_part():
    path = meshes.find_mesh_folder() / "spot.obj"
    if not path.is_file():
        pytest.skip(f"no test meshes in {path.parent}")
    read = mesh_files.read_mesh(path)
    report = sp.SurfaceMesh(read.positions, read.triangles, read.triangle_faces).report
    assert (report.vertices, report.triangles, report.parts) == (2930, 5856, 1)


@pytest.mark.parametrize("row", ["v 1 2", "v a b c", "f 1 0 2", "f 1 x 2", "f -9 1 2"])
def test_rows_that_are_none_are_named(tmp_path, row):
    path = tmp_path / "bad.obj"
    path.write_text(f"v 0 0 0\nv 1 0 0\nv 0 1 0\n{row}\n")
    with pytest.raises(mesh_files.MeshFileError, match="its row 4 is no vertex or face"):
        mesh_files.read_mesh(path)


REFUSALS = {
    "no file": (["{folder}/none.obj", "--picks", "0,1"], 2, "there is no such file"),
    "no mesh": (["{folder}/words.obj", "--picks", "0,1"], 2, "no faces in it"),
    "unknown form": (["{folder}/words.xyz1", "--picks", "0,1"], 2, "cannot read it"),
    "face out of range": (["{mesh}", "--picks", "0,64"], 1, "OptionError: "),
    "no numbers": (["{mesh}", "--picks", "a,b"], 2, "expected face numbers with commas"),
    "no picks": (["{mesh}"], 2, "--picks"),
    "output of unknown form": (["{mesh}", "--picks", "0,1", "-o", "line.doc"], 2, "must end in one of .obj .csv"),
    "output that cannot be": (["{mesh}", "--picks", "0,1", "-o", "{folder}/no/line.obj"], 2, "cannot be written"),
}


@pytest.mark.parametrize("name", REFUSALS)
def test_refusals(mesh_file, tmp_path, capsys, name):
    arguments, code, message = REFUSALS[name]
    (tmp_path / "words.obj").write_text("words\n")
    (tmp_path / "words.xyz1").write_text("words\n")
    given = [word.format(folder=tmp_path, mesh=mesh_file) for word in arguments]
    try:
        found = command.main(given)
    except SystemExit as end:
        found = end.code
    assert found == code
    told = capsys.readouterr().err
    assert message in told
    assert "Traceback" not in told


def test_without_readers_it_says_what_to_install(tmp_path, capsys, monkeypatch):
    path = tmp_path / "grid.ply"
    path.write_text("ply\n")
    for name in ("meshio", "trimesh"):
        monkeypatch.setitem(sys.modules, name, None)
    assert command.main([str(path), "--picks", "0,1"]) == 2
    assert "pip install 'smooth-polylines[formats]'" in capsys.readouterr().err


@pytest.mark.parametrize("module", [mesh_files, line_files])
def test_examples_in_docstrings_run(module):
    result = doctest.testmod(module)
    assert result.attempted > 0
    assert result.failed == 0
