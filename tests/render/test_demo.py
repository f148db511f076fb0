"""The demo as a person runs it, with small pictures: what it prints, the file it leaves, the line to be seen."""

import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

REPOSITORY = Path(__file__).resolve().parents[2]
WIDTH, HEIGHT = 320, 240

# Run in Blender: how many pixels of the picture are the line's red, and what the file holds.
LOOK = """
import os, sys, bpy, numpy as np
image = bpy.data.images.load(sys.argv[1] + "/demo.png")
pixels = np.array(image.pixels[:]).reshape(-1, image.channels)[:, :3]
red = (pixels[:, 0] > 0.5) & (pixels[:, 0] > 2 * pixels[:, 1]) & (pixels[:, 0] > 2 * pixels[:, 2])
grey = np.ptp(pixels, axis=1) < 0.06
print("SIZE", *image.size, "RED", red.sum(), "GREY", grey.sum(), flush=True)
bpy.ops.wm.open_mainfile(filepath=sys.argv[1] + "/demo.blend")
curve = bpy.data.objects["Smooth Polyline"]
points = curve.data.splines[0].points
print("CURVE", len(points), curve.data.splines[0].use_cyclic_u, curve.parent.name, flush=True)
os._exit(0)
"""


def run_python(*arguments):
    return subprocess.run(
        [sys.executable, *map(str, arguments)], capture_output=True, text=True, timeout=180, env=dict(os.environ)
    )


def run_demo(output, *arguments):
    return run_python(REPOSITORY / "blender_scripts" / "demo.py", "--output", output, "--width", WIDTH, *arguments)


def look_at(output):
    done = run_python("-c", LOOK, output)
    assert done.returncode == 0, done.stdout + done.stderr
    size = re.search(r"SIZE (\d+) (\d+) RED (\d+) GREY (\d+)", done.stdout)
    curve = re.search(r"CURVE (\d+) (\w+) (.+)", done.stdout)
    return [int(n) for n in size.groups()], (int(curve[1]), curve[2] == "True", curve[3])


def test_suzanne(tmp_path):
    done = run_demo(tmp_path)
    assert done.returncode == 0, done.stdout + done.stderr
    printed = done.stdout
    for word in ("picks", "strip", "rounds", "vertex passes", "length", "time"):
        assert re.search(rf"^  {word} ", printed, flags=re.MULTILINE), word
    before, after = map(float, re.search(r"length +(\S+) before, (\S+) after", printed).groups())
    assert 0.5 * before < after < before
    (width, height, red, grey), (points, is_cyclic, parent) = look_at(tmp_path)
    assert (width, height) == (WIDTH, HEIGHT)
    # A red thread across a grey head that fills about a quarter of the picture: as long as the picture is wide at
    # least, and at most a dozen pixels thick.
    assert 0.8 * WIDTH < red < 12 * WIDTH
    assert grey > 0.15 * WIDTH * HEIGHT
    assert points == int(re.search(r"points +(\d+)", printed)[1])
    assert (is_cyclic, parent) == (False, "Suzanne")


def make_ball():
    """A closed mesh of quads and triangles: rings of a sphere, longer along one axis."""
    rings, sides = 9, 16
    positions = [(0.0, 0.0, -1.5)]
    for ring in range(1, rings + 1):
        angle = np.pi * ring / (rings + 1)
        turn = 2 * np.pi * np.arange(sides) / sides
        positions += [(np.sin(angle) * np.cos(t), np.sin(angle) * np.sin(t), -1.5 * np.cos(angle)) for t in turn]
    positions.append((0.0, 0.0, 1.5))
    last = len(positions) - 1
    polygons = [(0, 1 + (s + 1) % sides, 1 + s) for s in range(sides)]
    for ring in range(rings - 1):
        a = 1 + ring * sides
        polygons += [(a + s, a + (s + 1) % sides, a + sides + (s + 1) % sides, a + sides + s) for s in range(sides)]
    a = 1 + (rings - 1) * sides
    polygons += [(a + s, a + (s + 1) % sides, last) for s in range(sides)]
    return positions, polygons


def write_ball(path):
    positions, polygons = make_ball()
    triangles = [(p[0], p[i], p[i + 1]) for p in polygons for i in range(1, len(p) - 1)]
    rows = [" ".join(map(str, p)) for p in positions]
    if path.suffix == ".off":
        faces = [" ".join(map(str, (len(p), *p))) for p in polygons]
        text = "\n".join(["OFF", f"{len(rows)} {len(faces)} 0", *rows, *faces])
    elif path.suffix == ".obj":
        text = "\n".join([f"v {r}" for r in rows] + ["f " + " ".join(str(c + 1) for c in p) for p in polygons])
    elif path.suffix == ".ply":
        head = ["ply", "format ascii 1.0", f"element vertex {len(rows)}"] + [f"property float {a}" for a in "xyz"]
        head += [f"element face {len(polygons)}", "property list uchar int vertex_indices", "end_header"]
        text = "\n".join([*head, *rows, *(" ".join(map(str, (len(p), *p))) for p in polygons)])
    else:
        corners = [[f"vertex {rows[c]}" for c in t] for t in triangles]
        facets = ["facet normal 0 0 0\nouter loop\n" + "\n".join(c) + "\nendloop\nendfacet" for c in corners]
        text = "\n".join(["solid ball", *facets, "endsolid ball"])
    path.write_text(text + "\n")


@pytest.mark.parametrize("suffix", [".obj", ".ply", ".stl", ".off"])
def test_own_mesh(tmp_path, suffix):
    write_ball(tmp_path / f"ball{suffix}")
    done = run_demo(tmp_path / "out", "--mesh", tmp_path / f"ball{suffix}")
    assert done.returncode == 0, done.stdout + done.stderr
    assert int(re.search(r"picks +(\d+) faces", done.stdout)[1]) > 12
    (_, _, red, _), (points, is_cyclic, parent) = look_at(tmp_path / "out")
    assert red > 200
    assert points > 15
    assert (is_cyclic, parent) == (True, "ball")


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("missing.obj", None, "there is no file"),
        ("notes.txt", "hello", "reads .obj, .ply, .stl and .off files"),
        ("half.off", "OFF\n4 4 0\n0 0 0\n", "is not a whole OFF file"),
        ("small.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", "has too few faces"),
    ],
)
def test_mesh_that_cannot_be_used_is_said(tmp_path, name, content, message):
    if content is not None:
        (tmp_path / name).write_text(content)
    done = run_demo(tmp_path / "out", "--mesh", tmp_path / name)
    assert done.returncode == 1
    assert message in done.stderr
    assert "Traceback" not in done.stderr
    assert not (tmp_path / "out").exists()
