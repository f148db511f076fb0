"""The library example of the README runs as it stands there."""

import re
from pathlib import Path

import numpy as np

README = (Path(__file__).resolve().parents[2] / "README.md").read_text(encoding="utf-8")


def test_library_example_runs_and_gives_a_line(capsys):
    library_example, stroke_example, blender_example = re.findall(r"```python\n(.*?)```", README, flags=re.DOTALL)
    names = {}
    exec(compile(library_example, "README.md", "exec"), names)
    line = names["line"]
    assert line.report.stop_reason in capsys.readouterr().out
    assert len(line.points) > 10
    corners = names["triangles"][line.triangles]
    expected = np.einsum("nc,nci->ni", line.barycentric, names["positions"][corners])
    np.testing.assert_allclose(line.points, expected, atol=1e-12)
    exec(compile(stroke_example, "README.md", "exec"), names)
    stroke = names["stroke"]
    assert capsys.readouterr().out.split() == [str(stroke.report.stroke_distance), str(stroke.report.stroke_breaks)]
    assert len(names["nearest"]) == len(names["drawn"])
    compile(blender_example, "README.md", "exec")


def test_blender_example_uses_what_the_addon_has():
    root = Path(__file__).resolve().parents[2]
    session = (root / "addon" / "session.py").read_text(encoding="utf-8")
    assert "bl_ext.user_default.smooth_polylines import session" in README
    assert "def add_polyline(" in session
    assert "curve_object: bpy.types.Object" in session
