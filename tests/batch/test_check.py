"""`--check` tells what a run would fail at, file by file and line by line, and makes nothing."""

import numpy as np
import pytest

from batch import jobs
from batch.test_inputs import END, PLANE_FAULTS, PLANE_LINES, START, straight

# Of these a run alone can tell: the line has to be smoothed for it.
TOLD_BY_A_RUN_ALONE = {"closed and flat"}


def list_faults(done):
    """What was told, one line each, but for the last one on the whole."""
    return done.stdout.splitlines()[:-1]


def test_broken_files_are_told_by_opening_them_and_nothing_is_made(tmp_path):
    jobs.write_inputs(tmp_path / "in", 3)
    errors = jobs.write_broken(tmp_path / "in")
    job = jobs.write_job(tmp_path / "job.json")
    before = sorted(tmp_path.rglob("*"))
    done = jobs.run_batch(job, "--check", "--jobs", "2")
    assert done.returncode == 1, done.stderr
    faults = list_faults(done)
    # In the order of the plan; each named as the report of a run names it.
    assert list(dict.fromkeys(line.split(": ")[0] for line in faults)) == sorted(f"in/{name}" for name in errors)
    for line in faults:
        name, *rest = line.split(": ")
        assert set(np.atleast_1d(errors[name.removeprefix("in/")])) & set(rest), line
    assert "is a good job: 13 files (10 of them will fail), 2 lines, 0 nets" in done.stdout
    assert "9 files to look at; in Blender" in done.stderr
    assert sorted(tmp_path.rglob("*")) == before


def test_names_picks_and_guides_are_told_line_by_line(scenes, tmp_path):
    lines = [line for line, *_ in PLANE_LINES.values()]
    faults = [{**line, "name": name} for name, (line, *_) in PLANE_FAULTS.items()]
    nets = [
        {"name": "net", "picks": [0, 19, 399], "connections": "automatic"},
        {"name": "bad net", "picks": [0, 19, {"vertex_group": "empty"}]},
    ]
    job = jobs.write_job(
        tmp_path / "job.json",
        inputs=[str(scenes / "scene.blend")],
        objects=["Plane"],
        search_radius=0.1,
        lines=[*lines, *faults],
        nets=nets,
        **{"import": None},
    )
    done = jobs.run_batch(job, "--check")
    assert done.returncode == 1, done.stderr
    told = {}
    for line in list_faults(done):
        _, *where, error, message = line.split(": ", 4) if ": Plane: " in line else line.split(": ", 3)
        told[where[-1]] = (error, message)
    for name, (_, error, message) in PLANE_FAULTS.items():
        if name not in TOLD_BY_A_RUN_ALONE:
            assert told[name][0] == error, name
            assert message in told[name][1], name
    assert set(told) == {*PLANE_FAULTS, "bad net"} - TOLD_BY_A_RUN_ALONE
    assert not (tmp_path / "out").exists()


def test_parts_that_are_not_joined_and_maps_that_are_missing(scenes, tmp_path):
    lines = [
        straight("bare", 0, 399, objects=["Bare"]),
        straight("bent", {"point": [0.5, 20.5, 0]}, {"point": [1.5, 20.5, 0]}, objects=["Bent"]),
    ]
    outputs = {"folder": "out", "formats": ["svg"]}
    values = {"inputs": [str(scenes / "scene.blend")], "search_radius": 0.05, "outputs": outputs, "import": None}
    done = jobs.run_batch(jobs.write_job(tmp_path / "job.json", lines=lines, source="evaluated", **values), "--check")
    assert done.returncode == 1, done.stderr
    told = [line.split("scene.blend: ")[1] for line in list_faults(done)]
    assert [line.split(": ")[:-1] for line in told] == [["Bare", "NoUVMapError"], ["Bent", "bent", "NoPathError"]]
    # What the seams' own unwrapping makes is not missed.
    make = {"seams": {"method": "cut"}, "unwrap": {}}
    job = jobs.write_job(tmp_path / "seams.json", lines=lines[:1], make=make, **values)
    done = jobs.run_batch(job, "--check")
    assert (done.returncode, list_faults(done)) == (0, []), done.stderr


@pytest.mark.parametrize("along", [{}, {"along": {"object": "Poly"}}])
def test_a_good_job_is_one(scenes, tmp_path, along):
    line = {"name": "a", "filter": "cubic", "support": 4, **along} if along else straight("a", START, END)
    job = jobs.write_job(
        tmp_path / "job.json", inputs=[str(scenes / "scene.blend")], objects=["Plane"], lines=[line], **{"import": None}
    )
    done = jobs.run_batch(job, "--check", "--quiet")
    assert (done.returncode, done.stderr) == (0, "")
    assert "1 files (0 of them will fail), 1 lines" in done.stdout


def test_without_a_blender_it_is_said(tmp_path):
    jobs.write_inputs(tmp_path / "in", 1)
    done = jobs.run_batch(jobs.write_job(tmp_path / "job.json"), "--check", "--blender", "no-such-blender")
    assert done.returncode == 2
    assert "cannot be started" in done.stderr
    assert "Traceback" not in done.stderr
