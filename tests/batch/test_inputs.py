"""Every kind of input, pick, guide and output, on a plane on which each answer is known; seen in Blender again."""

import csv
import json
import xml.etree.ElementTree as ET
import zipfile

import numpy as np
import pytest

from batch import jobs, pictures

FORMATS = ("obj", "ply", "stl", "fbx", "glb", "gltf", "usda", "usdc", "usd")


def straight(name, *picks, **more):
    return {"name": name, "filter": "geodesic", "picks": list(picks), **more}


START, END = {"point": [0.1, 0.2, 0.01]}, {"point": [0.9, 0.6, -0.01]}

# A face stands for the barycentre of its triangle nearest to its middle.
FIRST, LAST = (2 / 60, 1 / 60), (0.95 + 2 / 60, 0.95 + 1 / 60)

# What each line on the plane must be: its two ends in the world.
PLANE_LINES = {
    "points": (straight("points", START, END), (0.1, 0.2), (0.9, 0.6)),
    "faces": (straight("faces", 0, {"face": 399}), FIRST, LAST),
    "object space": (
        straight("object space", {"point": [0.3, 0.3, 0], "space": "object"}, END),
        (0.3, 0.3),
        (0.9, 0.6),
    ),
    "vertex group": (straight("vertex group", {"vertex_group": "quad"}, END), (3.5 / 20, 5.5 / 20), (0.9, 0.6)),
    "lone vertex": (straight("lone vertex", {"vertex_group": "lone vertex"}, END), (0.5, 0.5), (0.9, 0.6)),
    "face attribute": (
        straight("face attribute", {"attribute": "region", "value": 3}, START),
        (13 / 20, 16 / 20),
        (0.1, 0.2),
    ),
    "point attribute": (
        straight("point attribute", {"attribute": "mark", "value": True}, START),
        (17 / 20, 2 / 20),
        (0.1, 0.2),
    ),
    "poly": ({"name": "poly", "along": {"object": "Poly"}, "filter": "geodesic"}, (0.1, 0.33), (0.82, 0.33)),
    "pencil": (
        {"name": "pencil", "along": {"object": "Pencil", "layer": "Lines", "stroke": 1}, "filter": "geodesic"},
        (0.7, 0.3),
        (0.7, 0.7),
    ),
}
PLANE_FAULTS = {
    "no such group": (straight("f", START, {"vertex_group": "goup"}), "PickError", "are: quad, empty, lone vertex"),
    "empty group": (straight("f", START, {"vertex_group": "empty"}), "PickError", "no vertex has a weight"),
    "no such attribute": (straight("f", START, {"attribute": "regin", "value": 3}), "PickError", "no attribute regin"),
    "no such value": (straight("f", START, {"attribute": "region", "value": 9}), "PickError", "the value 9 nowhere"),
    "colours": (straight("f", START, {"attribute": "colour", "value": 1}), "PickError", "FLOAT_COLOR on POINT"),
    "too far": (straight("f", START, {"point": [0, 0, 1], "radius": 0.5}), "PickError", "is 1 away from the point"),
    "face out of range": (straight("f", 0, 400), "OptionError", "400"),
    "no guide": ({"name": "f", "along": {"object": "Poli"}}, "GuideError", "there are: "),
    "guide that is a mesh": ({"name": "f", "along": {"object": "Bare"}}, "GuideError", "Bare is a mesh object"),
    "guide too far": ({"name": "f", "along": {"object": "Far"}}, "GuideError", "point 4 of the guide is 5 away"),
    "no such stroke": ({"name": "f", "along": {"object": "Pencil", "stroke": 2}}, "GuideError", "has 2 strokes"),
    "no such layer": ({"name": "f", "along": {"object": "Pencil", "layer": "Lins"}}, "GuideError", "there are: Lines"),
    "no such object": (straight("f", 0, 1, objects=["plane"]), "NoObjectError", "there are: Bare, Bent, Moved, Plane"),
    "hidden object": (straight("f", 0, 1, objects=["Hidden"]), "NoObjectError", "no mesh object matches Hidden"),
    "closed and flat": (
        straight("f", 0, 19, 399, closed=True),
        "CollapsedError",
        "",
    ),
}  # fmt: skip


@pytest.fixture(scope="module")
def plane(scenes):
    """All lines and all faults in one job on the plane of the scene."""
    lines = [line for line, *_ in PLANE_LINES.values()]
    faults = [{**line, "name": name} for name, (line, *_) in PLANE_FAULTS.items()]
    more = [
        {"name": "bezier", "along": {"object": "Bezier"}, "filter": "fair"},
        {"name": "strokes", "along": {"object": "Pencil"}, "filter": "linear"},
        straight("pinned", 0, {"face": 210, "pinned": True}, 19),
        straight("hint", 0, 210, 19),
    ]
    nets = [
        {
            "name": "net",
            "filter": "geodesic",
            "picks": [0, 19, 399, 380],
            "connections": "all",
            "avoid_crossings": False,
        },
        {"name": "round", "filter": "geodesic", "picks": [0, 19, 399, 380], "connections": "all"},
        {"name": "two", "filter": "geodesic", "picks": [0, 19, 399], "connections": [[0, 1], [1, 2]]},
        {"name": "auto", "filter": "geodesic", "picks": [0, 19, 399, 380, 190], "connections": "automatic"},
    ]
    job = jobs.write_job(
        scenes / "plane.json",
        inputs=["scene.blend"],
        objects=["Plane"],
        search_radius=0.1,
        lines=[*lines, *more, *faults],
        nets=nets,
        make={"curves": {"bevel": 0.003, "offset": 0.25}},
        outputs={
            "folder": "out plane",
            "formats": ["json", "csv", "npz", "blend", "svg", "png"],
            "preview": {"size": [200, 160]},
        },
        **{"import": None},
    )
    done = jobs.run_batch(job)
    assert done.returncode == 1, done.stderr
    results = scenes / "out plane" / "scene.blend"
    written = json.loads((results / "lines.json").read_text(encoding="utf-8"))
    lines = {line["line"]: line for line in written["lines"]}
    report = jobs.read_report(scenes / "out plane")
    return results, lines, {entry["line"]: entry for entry in report if entry["line"] is not None}, report


@pytest.mark.parametrize("name", PLANE_LINES)
def test_picks_and_guides_are_where_they_should_be(plane, name):
    _, lines, entries, _ = plane
    _, start, end = PLANE_LINES[name]
    points = np.array(lines[name]["points"])
    np.testing.assert_allclose(points[0], [*start, 0], atol=1e-6)
    np.testing.assert_allclose(points[-1], [*end, 0], atol=1e-6)
    # The shortest line on a plane is straight.
    assert lines[name]["length"] == pytest.approx(np.linalg.norm(np.subtract(end, start)), rel=1e-5)
    assert entries[name]["status"] == "done"
    assert entries[name]["length"] == lines[name]["length"]


@pytest.mark.parametrize("name", PLANE_FAULTS)
def test_what_cannot_be_found_is_an_entry_with_advice(plane, name):
    _, lines, entries, _ = plane
    _, error, message = PLANE_FAULTS[name]
    assert name not in lines
    assert entries[name]["status"] == "failed"
    assert entries[name]["error"] == error
    assert message in entries[name]["message"]
    assert entries[name]["advice"]


def test_pins_nets_and_closed_guides(plane):
    _, lines, entries, report = plane
    middle = [(210 % 20 + 0.5) / 20, (210 // 20 + 0.5) / 20, 0]
    nearest = {n: np.linalg.norm(np.array(lines[n]["points"]) - middle, axis=1).min() for n in ("pinned", "hint")}
    assert nearest["pinned"] == pytest.approx(2**0.5 / 120, rel=1e-4)  # from the middle of a square to that of its half
    assert nearest["hint"] > 0.3
    pairs = ["0-1", "0-2", "0-3", "1-2", "1-3", "2-3"]
    assert [n for n in lines if n.startswith("net[")] == [f"net[{p}]" for p in pairs]
    assert lines["net[0-2]"]["length"] == pytest.approx(0.95 * 2**0.5, rel=1e-6)
    assert [n for n in lines if n.startswith("two[")] == ["two[0-1]", "two[1-2]"]
    told = {entry["net"]: entry for entry in report if "net" in entry}
    # Corners 0 and 1, 1 and 2 are nearer to the one in the middle than to each other half-way. Euler: 6 - 5 + 2.
    assert [n for n in lines if n.startswith("auto[")] == [
        f"auto[{p}]" for p in ("0-3", "0-4", "1-4", "2-3", "2-4", "3-4")
    ]
    assert (told["auto"]["patches"], told["auto"]["three_sided"], told["auto"]["crossings"]) == (3, 2, 0)
    assert told["net"]["crossings"] == 1  # the two diagonals
    # One of them goes round an end of the other. Euler: 6 - 4 + 2, of which one lies outside.
    assert (told["round"]["crossings"], told["round"]["patches"]) == (0, 4)
    assert [n for n in lines if n.startswith("round[")] == [f"round[{p}]" for p in pairs]
    assert lines["round[0-2]"]["length"] > 0.95 * 2**0.5 + 0.1
    assert entries["bezier"]["closed"]
    assert lines["bezier"]["closed"]
    radii = np.linalg.norm(np.array(lines["bezier"]["points"])[:, :2] - 0.5, axis=1)
    assert 0.27 < radii.min() < radii.max() < 0.32
    assert {"strokes.0", "strokes.1"} <= set(lines)


def test_csv_and_npz_say_what_json_says(plane):
    results, lines, _, _ = plane
    with np.load(results / "lines.npz", allow_pickle=False) as arrays:
        npz = {name: arrays[name] for name in arrays.files}
    with (results / "lines.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert list(npz["lines"]) == list(lines) == list(dict.fromkeys(row["line"] for row in rows))
    for k, line in enumerate(lines.values()):
        part = slice(npz["starts"][k], npz["starts"][k + 1])
        for key in ("points", "faces", "vertices", "weights"):
            np.testing.assert_array_equal(npz[key][part], np.array(line[key]))
        mine = rows[part]
        np.testing.assert_array_equal([[float(r[c]) for c in "xyz"] for r in mine], line["points"])
        np.testing.assert_array_equal([[int(r[f"vertex_{c}"]) for c in range(3)] for r in mine], line["vertices"])
        np.testing.assert_array_equal([[float(r[f"weight_{c}"]) for c in range(3)] for r in mine], line["weights"])
        np.testing.assert_array_equal([int(r["face"]) for r in mine], line["faces"])
        # Vertices and weights give the points, on the plane's own grid.
        grid = np.array(line["vertices"])
        places = np.stack([grid % 21 / 20, grid // 21 / 20], axis=-1)
        made = np.einsum("nc,nci->ni", np.array(line["weights"]), places)
        np.testing.assert_allclose(made, np.array(line["points"])[:, :2], atol=1e-7)
    with zipfile.ZipFile(results / "lines.npz") as archive:
        assert {entry.date_time for entry in archive.infolist()} == {(1980, 1, 1, 0, 0, 0)}


def test_blend_file_holds_the_curves_as_asked_for(plane):
    results, lines, _, _ = plane
    (told,) = jobs.run_maker("look", results / "result.blend")
    assert set(told["curves"]) == {line["curve"] for line in lines.values()}
    assert "Hacked" not in told["objects"]
    assert {"Plane", "Moved", "Hidden", "Bare", "Poly", "Pencil"} <= set(told["objects"])
    for line in lines.values():
        curve = told["curves"][line["curve"]]
        points = np.array(curve["points"])
        assert curve["parent"] == "Plane"
        assert curve["closed"] == line["closed"]
        assert curve["bevel"] == pytest.approx(0.003)
        np.testing.assert_allclose(points[:, :2], np.array(line["points"])[:, :2], atol=1e-6)
        np.testing.assert_allclose(points[:, 2], 0.25, atol=1e-6)


def test_curves_can_be_edited_on_also_those_along_guides(plane):
    results, lines, _, _ = plane
    (told,) = jobs.run_maker("look", results / "result.blend")
    for name, line in lines.items():
        known = told["curves"][line["curve"]]["memory"]
        assert known is not None, name
        assert known["state"] == "CURRENT"
        assert known["filter"] == line["settings"]["filter"].upper()
        is_guided = name in {"poly", "pencil", "bezier", "round[0-2]"} or name.startswith("strokes.")
        # Made again from its picks the line is where it was; along a guide, or where it was led round another line,
        # within a thousandth of the plane's diagonal.
        assert known["moved"] < (1.5e-3 if is_guided else 1e-5), name
        if is_guided:
            assert known["pinned"] == "ALL"
            assert (3 if line["closed"] else 2) <= known["picks"] <= 20, name
            assert line["settings"]["pinned"] == "ends", name


def test_uv_layout_shows_borders_and_lines_where_they_are(plane):
    results, _, _, _ = plane
    root = ET.fromstring((results / "uv-Plane.svg").read_text(encoding="utf-8"))
    groups = {p.get("class"): p.get("d") for p in root.iter() if p.get("class")}
    segments = {
        name: np.array([[float(w) for w in m.replace("L", " ").split()] for m in path.split("M")[1:]])
        for name, path in groups.items()
    }
    assert len(segments["face"]) == 2 * 20 * 19
    assert len(segments["border"]) == 4 * 20
    assert set(np.unique(segments["border"])) >= {0.0, 1024.0}
    uv = segments["line"].reshape(-1, 2, 2) / 1024
    uv[..., 1] = 1 - uv[..., 1]
    for start, end in [(s, e) for _, s, e in PLANE_LINES.values()]:
        for place in (start, end):
            assert np.linalg.norm(uv.reshape(-1, 2) - place, axis=1).min() < 2e-5
    assert not {"seam"} & set(groups)


def test_picture_shows_the_lines_and_tells_no_time(plane):
    results, _, _, _ = plane
    pixels, pieces = pictures.read_png(results / "preview.png")
    assert pixels.shape == (160, 200, 3)
    assert set(pieces) <= {b"IHDR", b"IDAT", b"IEND", b"sRGB", b"gAMA", b"pHYs", b"oFFs", b"cICP", b"cHRM"}
    assert 300 < pictures.count_red(pixels) < 8000


@pytest.fixture(scope="module")
def formats(scenes):
    job = jobs.write_job(
        scenes / "formats.json",
        inputs=[f"plane.{suffix}" for suffix in FORMATS],
        search_radius=0.05,
        lines=[straight("a", START, END)],
        outputs={"folder": "out formats", "formats": ["json", "blend"]},
        **{"import": None},
    )
    done = jobs.run_batch(job, "--jobs", "2")
    assert done.returncode == 0, done.stdout + done.stderr
    return scenes / "out formats"


@pytest.mark.parametrize("suffix", FORMATS)
def test_every_format_gives_the_same_line(formats, suffix):
    written = json.loads((formats / f"plane.{suffix}" / "lines.json").read_text(encoding="utf-8"))
    (line,) = written["lines"]
    points = np.array(line["points"])
    np.testing.assert_allclose(points[[0, -1]], [[0.1, 0.2, 0], [0.9, 0.6, 0]], atol=2e-6)
    assert line["length"] == pytest.approx(0.8**0.5, rel=1e-5)


def test_axes_and_scale_of_the_job(scenes):
    lines = [straight("a", {"point": [1, 0, 2]}, {"point": [9, 0, 6]})]
    jobs.write_job(
        scenes / "axes.json",
        inputs=["plane.ply"],
        search_radius=0.2,
        lines=lines,
        outputs={"folder": "out axes", "formats": ["json"]},
        **{"import": {"forward": "-z", "up": "y", "scale": 10}},
    )
    done = jobs.run_batch(scenes / "axes.json")
    assert done.returncode == 0, done.stdout + done.stderr
    (line,) = json.loads((scenes / "out axes" / "plane.ply" / "lines.json").read_text())["lines"]
    np.testing.assert_allclose(np.array(line["points"])[:, 1], 0, atol=1e-5)
    assert line["length"] == pytest.approx(10 * 0.8**0.5, rel=1e-5)


def test_moved_and_modified_objects_and_object_space(scenes):
    lines = [
        straight("moved", {"point": [10.2, 0.2, 0]}, {"point": [11.8, 0.6, 0]}, objects=["Moved"]),
        straight("bare", 0, 399, objects=["B*e"]),
        straight("bent", {"point": [0.5, 20.5, 0]}, {"point": [1.5, 20.5, 0]}, objects=["Bent"]),
    ]
    values = {"inputs": ["scene.blend"], "search_radius": 0.05, "import": None, "make": {}}
    outputs = {"folder": "out moved", "formats": ["json", "svg"], "space": "object"}
    jobs.write_job(scenes / "moved.json", lines=lines, source="evaluated", outputs=outputs, **values)
    done = jobs.run_batch(scenes / "moved.json")
    assert done.returncode == 1, done.stderr
    told = {entry["line"]: entry for entry in jobs.read_report(scenes / "out moved")}
    # Through both copies of the array modifier, which are not joined: no way.
    assert told["bent"]["error"] == "NoPathError"
    assert told[None]["error"] == "NoUVMapError"
    results = scenes / "out moved" / "scene.blend"
    written = {line["line"]: line for line in json.loads((results / "lines.json").read_text())["lines"]}
    np.testing.assert_allclose(np.array(written["moved"]["points"])[[0, -1]], [[0.1, 0.2, 0], [0.9, 0.6, 0]], atol=1e-6)
    assert written["moved"]["length"] == pytest.approx((1.6**2 + 0.4**2) ** 0.5, rel=1e-6)
    assert written["moved"]["curve"] is None
    assert {path.name for path in results.iterdir()} == {"lines.json", "uv-Moved.svg", "record.json"}


def test_saved_by_a_newer_blender_is_said(scenes, tmp_path):
    data = (scenes / "scene.blend").read_bytes()
    assert data.startswith(b"BLENDER")
    version = data[14:17] if data.startswith(b"BLENDER17") else data[9:12]
    newer = data.replace(b"BLENDER-v" + version, b"BLENDER-v499", 1) if len(version) == 3 else data
    if newer == data:
        newer = data.replace(b"v" + data[13:17], b"v0999", 1)
    (tmp_path / "newer.blend").write_bytes(newer)
    jobs.write_job(tmp_path / "job.json", inputs=["newer.blend"], lines=[straight("a", 0, 399)], **{"import": None})
    done = jobs.run_batch(tmp_path / "job.json")
    assert done.returncode == 1
    (entry,) = jobs.read_report(tmp_path / "out")
    assert entry["error"] == "NewerBlenderError"
    assert "--blender" in entry["advice"]


@pytest.mark.parametrize("method", ["snap", "slide", "cut"])
def test_seams_and_unwrap(scenes, method):
    """A line across the plane parts it in two islands; what the mesh then has is looked at in Blender."""
    lines = [straight("across", {"point": [0.52, 0, 0]}, {"point": [0.47, 1, 0]}, objects=["Plane"])]
    job = jobs.write_job(
        scenes / f"{method}.json",
        inputs=["scene.blend"],
        search_radius=0.05,
        lines=lines,
        make={"seams": {"method": method, "marks": ["seam", "sharp"]}, "unwrap": {}},
        outputs={"folder": f"out {method}", "formats": ["blend", "svg", "json"]},
        **{"import": None},
    )
    done = jobs.run_batch(job)
    assert done.returncode == 0, done.stdout + done.stderr
    line, seams = jobs.read_report(scenes / f"out {method}")
    assert (line["line"], line["status"], seams["status"]) == ("across", "done", "done")
    assert seams["islands"] == 2
    assert seams["flipped"] == 0
    (told,) = jobs.run_maker("look", scenes / f"out {method}" / "scene.blend" / "result.blend")
    mesh = told["meshes"]["Plane"]
    assert len(mesh["seams"]) == seams["edges"]
    assert mesh["vertices"] == 21 * 21 + seams["new_vertices"]
    places = np.array(mesh["seams"]).reshape(-1, 2)
    off = np.abs((places[:, 0] - 0.52) + 0.05 * places[:, 1])
    if method == "cut":
        assert seams["new_vertices"] > 15
        assert off.max() < 1e-5
    else:
        assert seams["new_vertices"] == 0
        assert seams["edges"] >= 20
        assert off.max() < 0.05
    if method == "slide":
        assert seams["moved"] > 10
    svg = (scenes / f"out {method}" / "scene.blend" / "uv-Plane.svg").read_text()
    assert 'class="seam"' in svg
