"""The extension that is shipped, installed into an empty profile of every Blender there is; operator and batch run.

The Blenders: the bpy of this environment, and those that `.blender` holds (made by `make test-gui`) or the one that
BLENDER names. Every step is a process of its own, as for a user.
"""

import json
import os
import shutil
import subprocess
import tomllib
import zipfile
from pathlib import Path

import numpy as np
import pytest

from batch import jobs

HERE = Path(__file__).parent
REPOSITORY = HERE.parents[1]
VERSION = tomllib.loads((REPOSITORY / "Cargo.toml").read_text())["workspace"]["package"]["version"]
SECONDS = 300


def test_shipped_wheel_runs_on_old_systems_and_keeps_to_the_stable_interface(shipped_zip):
    with zipfile.ZipFile(shipped_zip) as archive:
        (wheel,) = [Path(name).name for name in archive.namelist() if name.endswith(".whl")]
    assert wheel.startswith(f"smooth_polylines-{VERSION}-cp311-abi3-")
    if "linux" in wheel:
        # Blender itself needs glibc 2.28.
        glibc = [
            tuple(map(int, tag.split("_")[1:3])) for tag in wheel[:-4].split("-")[-1].split(".") if "linux_" in tag
        ]
        assert glibc
        assert max(glibc) <= (2, 28)


def read_result(done):
    assert done.returncode == 0, done.stdout[-3000:] + done.stderr[-3000:]
    (line,) = [line for line in done.stdout.splitlines() if line.startswith("RESULT ")]
    return json.loads(line.removeprefix("RESULT "))


def check_operator(result, profile):
    assert result["installed"] == result["ran"] == ["FINISHED"]
    assert Path(result["library"]).is_relative_to(profile)
    assert Path(result["addon"]).is_relative_to(profile)
    assert result["library_version"] == VERSION
    assert not result["operator_left"]
    points = np.array(result["points"])
    assert len(points) > 10
    assert points[0, 0] < -1.2
    assert points[-1, 0] > 1.2


def write_inputs(folder):
    jobs.write_inputs(folder / "in", 3)
    (folder / "in" / "bad.ply").write_text("no mesh")
    return jobs.write_job(folder / "job.json")


def check_batch(folder, done, profile):
    """Three results and a reason, made with the library of the zip."""
    assert done.returncode == 1, done.stdout[-3000:] + done.stderr[-3000:]
    entries = jobs.read_report(folder / "out")
    assert [e["status"] for e in entries].count("done") == 6
    assert [e["error"] for e in entries if e["status"] == "failed"] == ["ImportFailedError"]
    logs = [path.read_text(errors="replace") for path in (folder / "out" / ".batch" / "logs").iterdir()]
    told = [line for log in logs for line in log.splitlines() if line.startswith(f"library {VERSION} from ")]
    assert told
    assert all(line.split(" from ")[1].startswith(str(profile)) for line in told)
    for name in ("mesh000.ply", "mesh001.obj", "mesh002.stl"):
        written = json.loads((folder / "out" / "in" / name / "lines.json").read_text(encoding="utf-8"))
        assert [line["line"] for line in written["lines"]] == ["across", "ring"]
        assert (folder / "out" / "in" / name / "result.blend").stat().st_size > 100_000


def test_in_the_bpy_of_this_environment(shipped_zip, run_without_ours, tmp_path):
    profile = tmp_path / "profile"
    profile.mkdir()
    done = run_without_ours(HERE / "install_and_run.py", shipped_zip, BLENDER_USER_RESOURCES=str(profile))
    check_operator(read_result(done), profile)
    # The run of the operator has disabled it in its own process; the batch enables it in each of its own.
    job = write_inputs(tmp_path)
    done = run_without_ours(jobs.BATCH, job, "--profile", profile, "--jobs", "2")
    check_batch(tmp_path, done, profile)


def test_profile_without_the_extension_is_said(run_without_ours, tmp_path):
    job = write_inputs(tmp_path)
    done = run_without_ours(jobs.BATCH, job, "--profile", tmp_path / "empty")
    assert done.returncode == 2
    assert "install its zip file first" in done.stderr
    assert "Traceback" not in done.stderr


def list_blenders():
    """Name, root folder and program of each Blender program."""
    if "BLENDER" in os.environ:
        return [("own", Path("/"), os.environ["BLENDER"])]
    complete = sorted((REPOSITORY / ".blender").glob("*/.complete"))
    return [(path.parent.name, path.parent.resolve(), "/usr/bin/blender") for path in complete]


class Program:
    """A Blender program, in a root folder of its own."""

    def __init__(self, root, program, work):
        self.root, self.program, self.work = root, program, work
        self.profile = work / "profile"

    def inside(self, path):
        return "/" + str(path.relative_to(self.root))

    def run(self, *words):
        prefix = [] if self.root == Path("/") else ["chroot", str(self.root)]
        settings = {
            "PATH": "/usr/bin:/bin",
            "HOME": self.inside(self.work),
            "LANG": "C.UTF-8",
            "BLENDER_USER_RESOURCES": self.inside(self.profile),
        }
        command = [*prefix, "/usr/bin/env", "-i", *[f"{k}={v}" for k, v in settings.items()], self.program, *words]
        return subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=SECONDS)


@pytest.fixture(scope="module", params=list_blenders(), ids=lambda found: found[0])
def program(request, shipped_zip):
    """A Blender program with the extension installed by its own command, and our scripts beside it."""
    _, root, path = request.param
    work = root / "tmp" / f"smooth-polylines-package-{os.getpid()}"
    work.mkdir(parents=True)
    try:
        blender = Program(root, path, work)
        shutil.copy(shipped_zip, work / "extension.zip")
        scripts = shutil.ignore_patterns("__pycache__")
        shutil.copytree(REPOSITORY / "blender_scripts", work / "blender_scripts", ignore=scripts)
        (work / "addon").mkdir()
        shutil.copy(REPOSITORY / "addon" / "blender_manifest.toml", work / "addon")
        shutil.copy(HERE / "install_and_run.py", work)
        install = ["--command", "extension", "install-file", "-r", "user_default", "-e"]
        done = blender.run(*install, blender.inside(work / "extension.zip"))
        assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-2000:]
        yield blender
    finally:
        shutil.rmtree(work, ignore_errors=True)


def test_operator_in_a_blender_program(program):
    done = program.run("-b", "-P", program.inside(program.work / "install_and_run.py"), "--", "-")
    check_operator(read_result(done), Path(program.inside(program.profile)))


def test_batch_in_a_blender_program(program):
    folder = program.work / "many"
    job = write_inputs(folder)
    batch = program.inside(program.work / "blender_scripts" / "batch.py")
    done = program.run("-b", "-P", batch, "--", program.inside(job), "--jobs", "2")
    check_batch(folder, done, Path(program.inside(program.profile)))


def test_batch_on_the_file_that_blender_was_started_with(program):
    """`blender -b FILE -P batch.py -- JOB.json`, with the result of another batch as the file."""
    folder = program.work / "one"
    jobs.write_inputs(folder / "in", 1)
    batch = program.inside(program.work / "blender_scripts" / "batch.py")
    done = program.run("-b", "-P", batch, "--", program.inside(jobs.write_job(folder / "first.json")))
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-2000:]
    shutil.copy(folder / "out" / "in" / "mesh000.ply" / "result.blend", folder / "file.blend")
    outputs = {"folder": "again", "formats": ["json", "png"], "preview": {"size": [64, 48]}}
    job = jobs.write_job(folder / "second.json", inputs=None, outputs=outputs, **{"import": None})
    done = program.run("-b", program.inside(folder / "file.blend"), "-P", batch, "--", program.inside(job))
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-2000:]
    first, again = (
        json.loads(path.read_text(encoding="utf-8"))
        for path in (
            folder / "out" / "in" / "mesh000.ply" / "lines.json",
            folder / "again" / "file.blend" / "lines.json",
        )
    )
    assert [line["points"] for line in first["lines"]] == [line["points"] for line in again["lines"]]
    assert (folder / "again" / "file.blend" / "preview.png").stat().st_size > 500
    bad = program.run("-b", "-P", batch, "--", program.inside(job))
    assert bad.returncode == 2
    assert '"inputs" is missing' in bad.stderr
