"""The job type for Flamenco: loaded by a JavaScript engine with what Flamenco's manager offers to such scripts."""

import json
import shutil
import subprocess

import pytest

from batch import jobs

SCRIPT = jobs.REPOSITORY / "blender_scripts" / "flamenco" / "smooth_polylines_batch.js"
# What the manager takes: of its interface description for job types.
TYPES = {"string", "int32", "float", "bool"}
SUBTYPES = {"file_path", "dir_path", "file_name", "hashed_file_path"}
KEYS = {
    *("key", "type", "subtype", "choices", "propargs", "description", "label", "default", "eval", "evalInfo"),
    *("visible", "required", "editable"),
}
MANAGER = """
const fs = require("fs"), vm = require("vm");
class Task {
    constructor(name, type) { this.name = name; this.type = type; this.commands = []; this.dependencies = []; }
    addCommand(command) { this.commands.push(command); }
    addDependency(task) {
        if (!(task instanceof Task)) { throw new Error("no task"); }
        this.dependencies.push(task.name);
    }
}
const author = {
    Task: (name, type) => new Task(name, type),
    Command: (name, parameters) => ({ name, parameters }),
};
const context = vm.createContext({ author, print: () => {} });
// Strict, and without anything of a browser's or of node's: like the engine in the manager.
const script = "'use strict';" + fs.readFileSync(process.argv[2], "utf-8") + ";({ JOB_TYPE, compileJob })";
const { JOB_TYPE, compileJob } = vm.runInContext(script, context, { filename: "job.js" });
const tasks = [];
const given = JSON.parse(process.argv[3]);
const settings = {};
for (const setting of JOB_TYPE.settings) {
    if (setting.default !== undefined) { settings[setting.key] = setting.default; }
}
Object.assign(settings, given);
compileJob({ settings, addTask: (task) => tasks.push(task) });
console.log(JSON.stringify({ JOB_TYPE, tasks }));
"""


def compile_job(**settings):
    node = shutil.which("node")
    if node is None:
        pytest.skip("needs node, as a JavaScript engine")
    done = subprocess.run(
        [node, "-e", MANAGER, "--", "-", str(SCRIPT), json.dumps(settings)], capture_output=True, text=True, timeout=60
    )
    if done.returncode != 0:
        raise RuntimeError(done.stderr)
    return json.loads(done.stdout)


@pytest.fixture(scope="module")
def told():
    return compile_job(job_file="/srv/studio/job.json", batch_script="/srv/studio/batch.py", shards=3)


def test_settings_are_of_the_kinds_that_the_manager_knows(told):
    job_type = told["JOB_TYPE"]
    assert set(job_type) <= {"label", "description", "settings"}
    kinds = {"string": str, "int32": int, "bool": bool}
    for setting in job_type["settings"]:
        assert set(setting) <= KEYS
        assert setting["type"] in TYPES
        assert setting.get("subtype", "file_path") in SUBTYPES
        assert "subtype" not in setting or setting["type"] == "string"
        assert setting["description"]
        if "default" in setting:
            assert type(setting["default"]) is kinds[setting["type"]]
        else:
            assert setting["required"]  # what has no value otherwise must be asked for
    keys = [setting["key"] for setting in job_type["settings"]]
    assert len(set(keys)) == len(keys)


def test_a_task_for_each_shard_and_then_the_report(told):
    tasks = told["tasks"]
    assert [task["name"] for task in tasks] == ["shard 1 of 3", "shard 2 of 3", "shard 3 of 3", "report"]
    assert [task["type"] for task in tasks] == ["blender"] * 3 + ["misc"]
    assert tasks[-1]["dependencies"] == ["shard 1 of 3", "shard 2 of 3", "shard 3 of 3"]
    for number, task in enumerate(tasks[:-1], start=1):
        assert task["dependencies"] == []
        (command,) = task["commands"]
        assert command["name"] == "exec"
        assert command["parameters"]["exe"] == "{blender}"
        assert command["parameters"]["args"] == [
            *(
                "--background",
                "--python-exit-code",
                "3",
                "--python",
                "/srv/studio/batch.py",
                "--",
                "/srv/studio/job.json",
            ),
            *("--shard", f"{number}/3", "--jobs", "1", "--failures-ok"),
        ]


def test_the_commands_are_ones_that_batch_takes(told):
    from batching import command_line

    for task in told["tasks"]:
        arguments = task["commands"][0]["parameters"]["args"]
        options = command_line.parse(arguments[arguments.index("--") + 1 :])
        assert str(options.job) == "/srv/studio/job.json"
        assert options.failures_ok


def test_processes_retry_and_a_wrong_number(told):
    tasks = compile_job(job_file="j", batch_script="b", shards=1, processes=4, retry=True)["tasks"]
    arguments = tasks[0]["commands"][0]["parameters"]["args"]
    assert arguments[-5:] == ["1/1", "--jobs", "4", "--retry", "--failures-ok"]
    with pytest.raises(RuntimeError, match="Tasks must be 1 or more, found 0"):
        compile_job(job_file="j", batch_script="b", shards=0)
