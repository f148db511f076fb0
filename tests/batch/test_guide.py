"""The guide: its commands are run as they stand there, one after another, and its job is a good one."""

import json
import os
import re
import subprocess
import sys

import jsonschema
import pytest

from batch import jobs

from batching import job_file, schema_check  # isort: skip

GUIDE = (jobs.REPOSITORY / "docs" / "batch.md").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def told(tmp_path_factory):
    """What the guide's commands print, in a folder in which nothing is but this repository's scripts."""
    folder = tmp_path_factory.mktemp("guide")
    (script,) = re.findall(r"```python\n(.*?)```", GUIDE, flags=re.DOTALL)
    subprocess.run([sys.executable, "-c", script], cwd=folder, check=True, timeout=60)
    (folder / "blender_scripts").symlink_to(jobs.REPOSITORY / "blender_scripts")
    path = os.pathsep.join([os.path.dirname(sys.executable), os.environ["PATH"]])
    commands = re.findall(r"```sh\n(.*?)```", GUIDE, flags=re.DOTALL)
    assert len(commands) == 2
    done = [
        subprocess.run(
            ["bash", "-e", "-c", text],
            cwd=folder,
            env={**os.environ, "PATH": path},
            capture_output=True,
            text=True,
            timeout=jobs.SECONDS,
        )
        for text in commands
    ]
    assert all(each.returncode == 0 for each in done), [each.stderr for each in done]
    return folder, [each.stdout for each in done]


def test_commands_of_the_guide_do_what_it_says(told):
    folder, (made, looked) = told
    assert "is a good job: 10 files (0 of them will fail), 2 lines" in made
    assert re.search(r"^  done +10$", made, flags=re.MULTILINE)
    assert re.search(r"^lines done +20$", made, flags=re.MULTILINE)
    assert len(list((folder / "results" / "meshes").iterdir())) == 10
    words = looked.splitlines()
    assert words[:5] == ["lines.csv", "lines.json", "lines.npz", "record.json", "result.blend"]
    assert words[5].startswith("object,line,point,x,y,z,face")
    assert words[6].startswith("ball3,across,0,-")
    assert json.loads(words[7])["file"] == "meshes/ball0.obj"


def test_job_of_the_guide_is_good():
    (text,) = re.findall(r"```json\n(.*?)```", GUIDE, flags=re.DOTALL)
    job = json.loads(text)
    assert schema_check.list_faults(job, job_file.read_schema()) == []
    jsonschema.validate(job, job_file.read_schema())
    assert job_file.list_reference_faults(job) == []


def test_every_key_and_error_is_in_the_guide():
    schema = job_file.read_schema()
    inner = [schema["properties"]["make"]["properties"], schema["properties"]["limits"]["properties"]]
    keys = {*schema["properties"], *inner[0], *inner[1], *schema["properties"]["options"]["properties"]}
    assert {key for key in keys if f"`{key}`" not in GUIDE} - {"$schema"} == set()
