"""Whole runs, as processes: what comes of good and bad files, of runs killed, run twice, or out of room."""

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from batch import jobs

from batching import store  # isort: skip


def start(*arguments):
    return subprocess.Popen(
        jobs.command(*arguments), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True
    )


def wait_for(condition, seconds=120):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "waited in vain"
        time.sleep(0.02)


def count_records(folder):
    return jobs.count_records(folder / "out")


@pytest.fixture
def copy_of_inputs(undisturbed, tmp_path):
    """The same inputs and job in a folder of its own."""
    source, _, _ = undisturbed
    shutil.copytree(source / "in", tmp_path / "in")
    shutil.copy(source / "job.json", tmp_path / "job.json")
    return tmp_path


def test_every_file_is_a_result_or_a_named_reason(undisturbed):
    folder, errors, done = undisturbed
    assert done.returncode == 1, done.stderr
    report = jobs.read_report(folder / "out")
    failed = {entry["file"]: entry for entry in report if entry["status"] == "failed"}
    by_file = {}
    for entry in report:
        by_file.setdefault(entry["file"], []).append(entry)
    assert len(by_file) == 22
    for name, error in errors.items():
        entries = by_file.pop(f"in/{name}")
        assert {entry["error"] for entry in entries} <= set(np.atleast_1d(error)), name
        assert all(entry["message"] and entry["advice"] for entry in entries)
        assert not (folder / "out" / "in" / name).exists()
    assert {e["object"] for e in [failed["in/far.ply"]]} == {"far"}
    for name, entries in by_file.items():
        assert [(e["line"], e["status"]) for e in entries] == [("across", "done"), ("ring", "done")], name
        names = {path.name for path in (folder / "out" / name).iterdir()}
        assert names == {"lines.json", "lines.csv", "lines.npz", "result.blend", "record.json"}
    # A word for each failure while it runs, and the table at the end.
    assert done.stderr.count("FAILED") == 10
    assert "22/22" in done.stderr
    table = dict(line.rsplit(None, 1) for line in done.stdout.splitlines() if line[-1:].isdigit())
    assert {k.strip(): int(v) for k, v in table.items()}.items() >= {"files": 22, "done": 12, "failed": 10}.items()
    assert not list((folder / "out").rglob(".part-*"))


def test_killed_in_the_middle_and_started_again_it_is_byte_equal(undisturbed, copy_of_inputs):
    source, _, _ = undisturbed
    run = start(copy_of_inputs / "job.json", "--jobs", "2")
    wait_for(lambda: count_records(copy_of_inputs) >= 4)
    run.kill()
    run.communicate()
    time.sleep(0.5)  # workers end with their run
    done_before = count_records(copy_of_inputs)
    assert 4 <= done_before < 12
    assert not (copy_of_inputs / "out" / "report.jsonl").exists()
    stamps = {p: p.stat().st_mtime_ns for p in (copy_of_inputs / "out").rglob(store.RECORD_NAME)}
    again = jobs.run_batch(copy_of_inputs / "job.json", "--jobs", "2")
    assert again.returncode == 1, again.stderr
    assert "were done before" in again.stderr
    assert jobs.hash_tree(copy_of_inputs / "out") == jobs.hash_tree(source / "out")
    # What was there has not been made again.
    assert all(p.stat().st_mtime_ns == stamp for p, stamp in stamps.items())


def test_a_third_run_does_nothing_and_a_changed_input_or_job_only_what_is_needed(undisturbed, copy_of_inputs):
    folder = copy_of_inputs
    for path in [p for p in (folder / "in").iterdir() if not p.name.startswith("mesh00")]:
        path.unlink()
    (folder / "in" / "words.ply").write_text("no mesh")
    assert jobs.run_batch(folder / "job.json").returncode == 1
    before = jobs.hash_tree(folder / "out")
    idle = jobs.run_batch(folder / "job.json")
    assert (idle.returncode, idle.stderr) == (1, "")
    retried = jobs.run_batch(folder / "job.json", "--retry")
    assert "1 files to do, 10 were done before" in retried.stderr
    # Another input in place of one, and a result that somebody has thrown away.
    jobs.write_ply(folder / "in" / "mesh000.ply", *jobs.make_bumpy(8, 77))
    shutil.rmtree(folder / "out" / "in" / "mesh001.obj")
    changed = jobs.run_batch(folder / "job.json")
    assert "2 files to do, 9 were done before" in changed.stderr
    after = jobs.hash_tree(folder / "out")
    different = {Path(name).parent.name for name in before if before[name] != after.get(name)} - {"out", "."}
    assert different - {""} == {"mesh000.ply"}
    # The journals lost: the records and the inputs' bytes say the same.
    shutil.rmtree(folder / "out" / ".batch")
    lost = jobs.run_batch(folder / "job.json")
    assert "1 files to do, 10 were done before" in lost.stderr
    assert jobs.hash_tree(folder / "out") == after
    # A good file that turned bad leaves no old result to be taken for a new one.
    (folder / "in" / "mesh002.stl").write_bytes(b"")
    assert jobs.run_batch(folder / "job.json").returncode == 1
    assert not (folder / "out" / "in" / "mesh002.stl").exists()
    # Another job: all is made anew.
    jobs.write_job(folder / "job.json", lines=jobs.LINES[:1])
    assert "11 files to do" in jobs.run_batch(folder / "job.json").stderr.splitlines()[0]


def test_two_runs_at_once_in_one_folder(copy_of_inputs):
    first = start(copy_of_inputs / "job.json")
    try:
        wait_for(lambda: count_records(copy_of_inputs) >= 1)
        first.send_signal(signal.SIGSTOP)  # else it may be done before the second has begun
        second = jobs.run_batch(copy_of_inputs / "job.json")
        assert second.returncode == 2
        assert f"another run (process {first.pid} on " in second.stderr
        apart = jobs.run_batch(copy_of_inputs / "job.json", "--shard", "1/2")
        assert apart.returncode == 2
    finally:
        first.send_signal(signal.SIGCONT)
        _, told = first.communicate(timeout=jobs.SECONDS)
    assert first.returncode == 1, told
    assert count_records(copy_of_inputs) == 12


def test_shards_side_by_side_make_what_one_run_makes(undisturbed, copy_of_inputs):
    source, _, _ = undisturbed
    runs = [start(copy_of_inputs / "job.json", "--shard", f"{k}/2") for k in (1, 2)]
    for run in runs:
        _, told = run.communicate(timeout=jobs.SECONDS)
        assert run.returncode == 1, told
    reports = [(copy_of_inputs / "out" / f"report-{k}-of-2.jsonl") for k in (1, 2)]
    counts = [len({entry["file"] for entry in jobs.read_report(p.parent, p.name)}) for p in reports]
    assert counts == [11, 11]
    merged = jobs.run_batch(copy_of_inputs / "job.json", "--report")
    assert merged.returncode == 1
    assert merged.stderr == ""
    for path in reports:
        path.unlink()
    assert jobs.hash_tree(copy_of_inputs / "out") == jobs.hash_tree(source / "out")


def test_ctrl_c_ends_the_run_and_its_workers_and_says_how_to_go_on(copy_of_inputs):
    run = start(copy_of_inputs / "job.json", "--jobs", "2")
    wait_for(lambda: count_records(copy_of_inputs) >= 2)
    run.send_signal(signal.SIGINT)
    begin = time.monotonic()
    out, told = run.communicate(timeout=20)
    assert time.monotonic() - begin < 5
    assert run.returncode == 1
    assert "Traceback" not in told
    assert "interrupted; start the same command again" in told
    states = [entry["status"] for entry in jobs.read_report(copy_of_inputs / "out")]
    assert states.count("missing") >= 1
    assert "missing" in out
    if Path("/proc").is_dir():
        mine = [p for p in Path("/proc").iterdir() if p.name.isdigit() and is_worker_for(p, copy_of_inputs)]
        assert mine == []


def is_worker_for(process, folder):
    try:
        return any(os.readlink(link).startswith(str(folder)) for link in (process / "fd").iterdir())
    except OSError:
        return False


def find_workers(folder):
    """Processes that write a worker's log under `folder`."""
    return [int(p.name) for p in Path("/proc").iterdir() if p.name.isdigit() and writes_log(p, folder)]


def writes_log(process, folder):
    try:
        target = os.readlink(process / "fd" / "2")
    except OSError:
        return False
    return target.startswith(str(folder)) and "worker" in target


@pytest.mark.skipif(not Path("/proc").is_dir(), reason="finds the workers in the list of processes")
def test_a_worker_that_dies_costs_its_file_an_attempt_and_no_more(undisturbed, copy_of_inputs):
    source, _, _ = undisturbed
    run = start(copy_of_inputs / "job.json")
    wait_for(lambda: count_records(copy_of_inputs) >= 2)
    (worker,) = find_workers(copy_of_inputs)
    os.kill(worker, signal.SIGSEGV)
    run.communicate(timeout=jobs.SECONDS)
    assert run.returncode == 1
    assert jobs.hash_tree(copy_of_inputs / "out") == jobs.hash_tree(source / "out")


CRASHING_WORKER = """
import json, os, sys, time
sys.stdin.buffer.readline()
mark = "SMOOTH-POLYLINES-BATCH "
print(mark + json.dumps({"blender": "0", "process": os.getpid()}), flush=True)
for line in sys.stdin.buffer:
    name = json.loads(line)["name"]
    if "crash" in name:
        os.abort()
    if "hang" in name:
        time.sleep(1000)
    if "exit" in name:
        os._exit(7)
    entry = {"file": name, "object": "o", "line": "l", "status": "done"}
    print("noise of Blender " + mark + json.dumps({"entries": [entry], "saved": False, "transient": False}), flush=True)
"""


def test_crashes_and_hangs_of_blender_are_entries_and_the_rest_goes_on(tmp_path, monkeypatch, capsys):
    from batching import command_line

    for name in ("a", "crash", "exit", "hang", "z"):
        jobs.write_ply(tmp_path / "in" / f"{name}.ply", *jobs.make_bumpy(6, 0))
    job = jobs.write_job(tmp_path / "job.json", limits={"seconds": 1.5})
    script = tmp_path / "worker.py"
    script.write_text(CRASHING_WORKER)
    monkeypatch.setattr(command_line, "find_worker_command", lambda blender: [sys.executable, str(script)])
    assert command_line.main([str(job), "--jobs", "2"]) == 1
    told = {entry["file"]: entry for entry in jobs.read_report(tmp_path / "out")}
    assert told["in/a.ply"]["status"] == told["in/z.ply"]["status"] == "done"
    assert told["in/crash.ply"]["error"] == told["in/exit.ply"]["error"] == "WorkerDiedError"
    assert "SIGABRT" in told["in/crash.ply"]["message"]
    assert "exit code 7" in told["in/exit.ply"]["message"]
    assert told["in/hang.ply"]["error"] == "TimeLimitError"
    assert "1.5 seconds" in told["in/hang.ply"]["message"]
    # Next night they are tried again, as the reason may be gone.
    capsys.readouterr()
    assert command_line.main([str(job)]) == 1
    assert "3 files to do" in capsys.readouterr().err


def test_no_blender_is_said_before_anything_is_done(tmp_path):
    jobs.write_inputs(tmp_path / "in", 2)
    job = jobs.write_job(tmp_path / "job.json")
    for program, expected in (("no-such-blender", "cannot be started"), ("true", "ended or was silent (exit code 0)")):
        done = jobs.run_batch(job, "--blender", program)
        assert done.returncode == 2
        assert expected in done.stderr
        assert "Traceback" not in done.stderr


def can_mount():
    return hasattr(os, "geteuid") and os.geteuid() == 0 and shutil.which("mount") is not None


@pytest.fixture
def small_disk(tmp_path):
    """A file system of a few megabytes."""
    folder = tmp_path / "disk"
    folder.mkdir()
    if not can_mount() or subprocess.run(["mount", "-t", "tmpfs", "-o", "size=3m", "none", folder]).returncode != 0:
        pytest.skip("needs to mount a small file system, which takes root")
    yield folder
    subprocess.run(["umount", "-l", folder], check=True)


def test_full_disk_ends_the_run_and_with_room_it_goes_on(undisturbed, copy_of_inputs, small_disk):
    source, _, _ = undisturbed
    (copy_of_inputs / "out").symlink_to(small_disk)
    full = jobs.run_batch(copy_of_inputs / "job.json")
    assert full.returncode == 1
    assert "no space left on the disk; make room, then start the same command again" in full.stderr.lower()
    done = count_records(copy_of_inputs)
    assert 0 < done < 12
    # Nothing half-made lies under a result's name.
    for record in (copy_of_inputs / "out").rglob(store.RECORD_NAME):
        folder = record.parent
        expected = jobs.hash_tree(source / "out" / folder.relative_to(copy_of_inputs / "out"))
        assert jobs.hash_tree(folder) == expected
    subprocess.run(["mount", "-o", "remount,size=64m", small_disk], check=True)
    again = jobs.run_batch(copy_of_inputs / "job.json")
    assert f"{done} were done before" in again.stderr or "were done before" in again.stderr
    assert jobs.hash_tree(small_disk) == jobs.hash_tree(source / "out")


def test_names_that_are_not_english_or_not_even_unicode(tmp_path):
    names = ["Büste Ω 頭.ply", "a b'c\"&;$(x).ply", "[x]*.ply", "naïve.ply"]
    for k, name in enumerate(names):
        jobs.write_ply(tmp_path / "in" / "дом" / name, *jobs.make_bumpy(8, k))
    bad = os.fsdecode(b"in/no-\xff-unicode.ply")
    jobs.write_ply(tmp_path / bad, *jobs.make_bumpy(8, 0))
    lines = [{**jobs.LINES[0], "name": 'Linie ü, "x" 線'}]
    job = jobs.write_job(tmp_path / "job ö.json", inputs=["in/**/*.ply"], lines=lines)
    done = jobs.run_batch(job, env={**os.environ, "LANG": "C", "LC_ALL": "C"})
    assert done.returncode == 1, done.stderr
    report = jobs.read_report(tmp_path / "out")
    told = {entry["file"]: entry for entry in report}
    assert {name for name, e in told.items() if e["status"] == "done"} == {f"in/дом/{name}" for name in names}
    (failed,) = [e for e in report if e["status"] == "failed"]
    assert failed["error"] == "NameNotUnicodeError"
    assert failed["file"] == "in/no-\\udcff-unicode.ply"
    assert told[f"in/дом/{names[0]}"]["line"] == lines[0]["name"]
    written = json.loads((tmp_path / "out" / "in" / "дом" / names[0] / "lines.json").read_text(encoding="utf-8"))
    assert written["lines"][0]["line"] == lines[0]["name"]


def test_a_terminal_gets_a_bar(tmp_path):
    pty = pytest.importorskip("pty")
    jobs.write_inputs(tmp_path / "in", 3)
    job = jobs.write_job(tmp_path / "job.json")
    master, slave = pty.openpty()
    run = subprocess.Popen(jobs.command(job), stdout=subprocess.DEVNULL, stderr=slave)
    os.close(slave)
    seen = b""
    while True:
        try:
            piece = os.read(master, 4096)
        except OSError:
            break
        if not piece:
            break
        seen += piece
    assert run.wait(60) == 0
    os.close(master)
    assert b"[################" in seen
    assert b"3/3" in seen
    assert b" left" in seen


def test_exit_code_zero_and_failures_ok(tmp_path):
    jobs.write_inputs(tmp_path / "in", 2)
    job = jobs.write_job(tmp_path / "job.json")
    done = jobs.run_batch(job, "--quiet")
    assert (done.returncode, done.stderr) == (0, "")
    (tmp_path / "in" / "bad.ply").write_text("no mesh")
    assert jobs.run_batch(job, "--quiet").returncode == 1
    assert jobs.run_batch(job, "--quiet", "--failures-ok").returncode == 0
