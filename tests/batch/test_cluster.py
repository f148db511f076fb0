"""A real Dask cluster on this machine: a scheduler and two workers, processes of their own, of which one is killed."""

import contextlib
import os
import re
import shutil
import signal
import socket
import subprocess
import sys

import pytest

from batch import jobs
from batch.test_runs import count_records, start, wait_for

pytest.importorskip("distributed")


def find_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


@contextlib.contextmanager
def start_process(log, *words):
    with open(log, "wb") as file:
        process = subprocess.Popen(
            [sys.executable, "-m", *words], stdout=file, stderr=file, start_new_session=True, cwd=log.parent
        )
    try:
        yield process
    finally:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        process.wait()


@pytest.fixture
def cluster(tmp_path):
    """Address of a scheduler, and its two worker processes."""
    address = f"tcp://127.0.0.1:{find_port()}"
    folder = tmp_path / "dask"
    folder.mkdir()
    with contextlib.ExitStack() as stack:
        stack.enter_context(
            start_process(
                folder / "scheduler.log",
                *("distributed.cli.dask_scheduler", "--host", "127.0.0.1", "--port", address.rsplit(":")[-1]),
                *("--no-dashboard", "--no-show"),
            )
        )
        workers = [
            stack.enter_context(
                start_process(
                    folder / f"worker-{k}.log",
                    *("distributed.cli.dask_worker", address, "--nthreads", "1", "--no-nanny", "--no-dashboard"),
                    *("--local-directory", str(folder / f"w{k}")),
                )
            )
            for k in range(2)
        ]
        for k in range(2):
            log = folder / f"worker-{k}.log"
            wait_for(lambda log=log: b"Registered to" in log.read_bytes())
        yield address, workers


def test_a_worker_killed_in_mid_run_changes_nothing_of_the_results(undisturbed, cluster, tmp_path):
    source, _, _ = undisturbed
    address, workers = cluster
    shutil.copytree(source / "in", tmp_path / "in")
    shutil.copy(source / "job.json", tmp_path / "job.json")
    run = start(tmp_path / "job.json", "--scheduler", address)
    wait_for(lambda: count_records(tmp_path) >= 3 or run.poll() is not None)
    os.killpg(workers[0].pid, signal.SIGKILL)
    done = count_records(tmp_path)
    out, told = run.communicate(timeout=jobs.SECONDS)
    assert done < 12, "killed too late to be in mid-run"
    assert run.returncode == 1, told
    assert "Traceback" not in told
    assert jobs.hash_tree(tmp_path / "out") == jobs.hash_tree(source / "out")
    assert "on the cluster at" in told
    assert re.search(r"^  failed +10$", out, flags=re.MULTILINE)


def test_no_scheduler_there_is_said(tmp_path, monkeypatch, capsys):
    from batching import cluster, command_line

    monkeypatch.setattr(cluster, "CONNECT_SECONDS", 1)
    jobs.write_inputs(tmp_path / "in", 1)
    job = jobs.write_job(tmp_path / "job.json")
    assert command_line.main([str(job), "--scheduler", f"tcp://127.0.0.1:{find_port()}"]) == 2
    assert "no Dask scheduler answers there" in capsys.readouterr().err
    assert command_line.main([str(job), "--scheduler", "nonsense://"]) == 2
    capsys.readouterr()
    assert command_line.main([str(job), "--scheduler", "tcp://127.0.0.1:1", "--jobs", "2"]) == 2
    assert "--jobs is for this machine" in capsys.readouterr().err


def test_without_the_package_it_is_said(tmp_path):
    jobs.write_inputs(tmp_path / "in", 1)
    job = jobs.write_job(tmp_path / "job.json")
    (tmp_path / "distributed.py").write_text("raise ImportError('no such package')\n")
    done = jobs.run_batch(job, "--scheduler", "tcp://127.0.0.1:1", env={**os.environ, "PYTHONPATH": str(tmp_path)})
    assert done.returncode == 2
    assert "pip install 'smooth-polylines[dask]'" in done.stderr
    assert "Traceback" not in done.stderr
