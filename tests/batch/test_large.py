"""The big run: 200 files, made and real, 10 of them broken, killed in the middle. By `make test-batch-large` only."""

import os
import shutil
import time

import pytest

import meshes
from batch import jobs
from batch.test_runs import start, wait_for

pytestmark = pytest.mark.skipif(
    "SMOOTH_POLYLINES_LARGE" not in os.environ, reason="takes some minutes: make test-batch-large"
)
REAL = ("spot.obj", "fandisk.obj", "mountain.obj", "igea.ply", "moebius.obj")
FILES = 200


@pytest.fixture(scope="module")
def inputs(tmp_path_factory):
    folder = tmp_path_factory.mktemp("large")
    errors = jobs.write_broken(folder / "in")
    for name in REAL:
        (folder / "in" / "real").mkdir(exist_ok=True)
        shutil.copy(meshes.find_shared_mesh(name), folder / "in" / "real" / name)
    jobs.write_inputs(folder / "in" / "made", FILES - len(errors) - len(REAL), sizes=(16, 24, 40, 64))
    return folder, errors


def test_200_files_10_broken_killed_in_the_middle_and_started_again(inputs, tmp_path):
    folder, errors = inputs
    outputs = {"formats": ["json", "npz", "blend"]}
    for kind in ("undisturbed", "disturbed"):
        # One job for each kind of file, so that no line is asked for where it has no objects.
        for part, patterns, lines in (
            ("made", ["in/*", "in/made/*"], jobs.LINES),
            ("real", ["in/real/*"], [{"name": "faces", "filter": "geodesic", "picks": [0, 3]}]),
        ):
            jobs.write_job(
                folder / f"{kind}-{part}.json",
                inputs=patterns,
                lines=lines,
                outputs={"folder": str(tmp_path / kind / part), **outputs},
            )
    for part in ("made", "real"):
        done = jobs.run_batch(folder / f"undisturbed-{part}.json", "--jobs", "2")
        assert done.returncode == (1 if part == "made" else 0), done.stderr
    expected = jobs.hash_tree(tmp_path / "undisturbed")
    entries = jobs.read_report(tmp_path / "undisturbed" / "made")
    failed = {entry["file"] for entry in entries if entry["status"] == "failed"}
    assert failed == {f"in/{name}" for name in errors}
    assert sum(name.endswith("record.json") for name in expected) == FILES - len(errors)

    run = start(folder / "disturbed-made.json", "--jobs", "2")
    wait_for(lambda: jobs.count_records(tmp_path / "disturbed") >= 80, seconds=600)
    run.kill()
    run.communicate()
    time.sleep(1)
    assert not (tmp_path / "disturbed" / "made" / "report.jsonl").exists()
    for part in ("made", "real"):
        again = jobs.run_batch(folder / f"disturbed-{part}.json", "--jobs", "2")
        assert again.returncode == (1 if part == "made" else 0), again.stderr
        assert part == "real" or "were done before" in again.stderr
    assert jobs.hash_tree(tmp_path / "disturbed") == expected
