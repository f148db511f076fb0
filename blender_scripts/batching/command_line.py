"""The command: arguments, what is printed, and the exit code. 0: all done; 1: some failed or are missing; 2: bad job.

Holds no work of its own.
"""

import argparse
import os
import sys
import threading
from pathlib import Path

from . import job_file, plan, report, run, run_lock, store
from .check_run import check
from .errors import JobError
from .local_pool import LocalPool
from .progress import Progress
from .worker_process import WorkerStartError, find_worker_command

ALL_DONE, SOME_FAILED, BAD_JOB = 0, 1, 2


def main(arguments: list[str], *, blender: str | None = None, open_file: str | None = None) -> int:
    """Run the command; the exit code.

    blender : the Blender program that this runs in; None in a plain Python
    open_file : the file that this Blender was started with
    """
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="backslashreplace")
    try:
        options = parse(arguments)
    except SystemExit as end:
        return int(end.code or 0)
    if options.example or options.schema:
        path = job_file.EXAMPLE_FILE if options.example else job_file.SCHEMA_FILE
        print(path.read_text(encoding="utf-8"), end="")
        return ALL_DONE
    try:
        if options.job is None:
            raise JobError("name a job: batch.py JOB.json (--example prints one to begin with)")
        return run_job(options, options.blender or blender, open_file)
    except (JobError, WorkerStartError) as error:
        for line in getattr(error, "faults", [str(error)]):
            print(f"Bad job: {line}", file=sys.stderr)
        return BAD_JOB


def parse(arguments: list[str]) -> argparse.Namespace:
    """What the arguments say; SystemExit(2) with a line where they are wrong."""
    parser = argparse.ArgumentParser(
        prog="batch.py", description="Smooth lines on the meshes of many files, as a job describes them."
    )
    parser.add_argument("job", nargs="?", type=Path, metavar="JOB.json", help="the job")
    parser.add_argument("--check", action="store_true", help="check the job, and its inputs in Blender; make nothing")
    parser.add_argument(
        "--check-names", action="store_true", help="the same without opening the inputs: quick, and without Blender"
    )
    parser.add_argument("--example", action="store_true", help="print a job to begin with")
    parser.add_argument("--schema", action="store_true", help="print the JSON Schema of a job")
    parser.add_argument("--jobs", type=int, default=1, metavar="N", help="worker processes on this machine (1)")
    parser.add_argument("--shard", default="1/1", metavar="I/N", help="only every N-th file, from the I-th on")
    parser.add_argument("--scheduler", metavar="ADDRESS", help="run on the Dask cluster with this scheduler")
    parser.add_argument("--blender", metavar="PROGRAM", help="the Blender that the workers run (this one)")
    parser.add_argument(
        "--profile", metavar="FOLDER", help="Blender's user settings with the extension (with bpy: none)"
    )
    parser.add_argument("--retry", action="store_true", help="do again what failed, whatever the reason was")
    parser.add_argument("--report", action="store_true", help="write the report of what is there; make nothing")
    parser.add_argument("--failures-ok", action="store_true", help="exit code 0 also when files failed")
    parser.add_argument("--quiet", action="store_true", help="no progress, only the summary")
    options = parser.parse_args(arguments)
    if options.jobs < 1:
        parser.error("--jobs must be 1 or more")
    if options.scheduler and options.jobs != 1:
        parser.error("--jobs is for this machine; on a cluster its workers decide")
    return options


def run_job(options: argparse.Namespace, blender: str | None, open_file: str | None) -> int:
    """Check, report or run the job."""
    job = job_file.load_job(options.job)
    shard = plan.Shard.parse(options.shard)
    items = shard.choose(plan.make_plan(job, open_file))
    if options.check or options.check_names:
        return check(options, job, items, blender)
    if job.output.exists() and not job.output.is_dir():
        raise JobError(f"{options.job.name}: outputs.folder: {job.output} is a file")
    if options.report:
        return finish(options, job, shard, run.find_state(job, items), None)
    if not items:
        print("this shard has no files")
        return ALL_DONE
    try:
        job.output.mkdir(parents=True, exist_ok=True)
        return run_with_lock(options, job, shard, items, blender)
    except OSError as error:
        if not isinstance(error.filename, str) or not error.filename.startswith(str(job.output)):
            raise
        raise JobError(f"outputs.folder: {error.filename}: {error.strerror}") from error


def run_with_lock(
    options: argparse.Namespace, job: job_file.Job, shard: plan.Shard, items: list[plan.Item], blender: str | None
) -> int:
    """Run while nobody else writes the same results."""
    with run_lock.hold_run_lock(job.output, shard):
        if run_lock.is_alone(job.output, shard):
            store.remove_parts(job.output)
        state = run.find_state(job, items, retry=options.retry)
        if not state.to_do:
            return finish(options, job, shard, state, None)
        if options.scheduler:
            from .cluster import Cluster

            workforce, what = (
                Cluster(job, options.scheduler, blender, options.profile),
                f"on the cluster at {options.scheduler}",
            )
        else:
            label = f"{shard.number}-of-{shard.count}"
            logs = job.output / store.STATE_FOLDER / "logs"
            workforce = LocalPool(job, find_worker_command(blender), options.jobs, label, options.profile, logs=logs)
            what = f"in {options.jobs} processes" if options.jobs > 1 else "in one process"
        progress = Progress(len(state.to_do), len(state.notes), is_quiet=options.quiet)
        try:
            hello = workforce.start_first()
            version = f", Blender {hello['blender']}" if hello else ""
            progress.begin(what + version)
            reason = run.run_items(job, state, workforce, shard, progress)
        finally:
            workforce.stop()
            # Of workers that died where nobody could clean up behind them.
            if run_lock.is_alone(job.output, shard):
                store.remove_parts(job.output)
        return finish(options, job, shard, state, reason)


def finish(
    options: argparse.Namespace, job: job_file.Job, shard: plan.Shard, state: run.State, reason: str | None
) -> int:
    """Write the report, print the summary; the exit code."""
    notes = {**{r: n for r, n in all_notes(job, state).items()}, **state.notes}
    entries = report.collect_entries(state.items, notes)
    try:
        path = report.write_report(job.output, shard, entries)
        where = f"report: {path}"
    except OSError as error:
        where = f"no report: {job.output}: {error.strerror}"
    print("\n".join(report.make_summary(state.items, notes)))
    print(where)
    if reason is not None:
        print(f"Ended early: {reason}", file=sys.stderr)
    if any(entry["status"] == "missing" for entry in entries):
        return SOME_FAILED
    if any(entry["status"] == "failed" for entry in entries) and not options.failures_ok:
        return SOME_FAILED
    return ALL_DONE


def all_notes(job: job_file.Job, state: run.State) -> dict:
    """Also of items that failed for the moment and have not been tried again."""
    kept = store.read_journals(job.output)
    wanted = {item.result for item in state.items}
    return {r: n for r, n in kept.items() if r in wanted and n["fingerprint"] == job.fingerprint and not n["saved"]}


def leave(code: int) -> None:
    """End the process with `code`, without the static destructors in which some versions of bpy crash or hang."""
    sys.stdout.flush()
    sys.stderr.flush()
    if threading.active_count() > 1 or "bpy" in sys.modules:
        os._exit(code)
    sys.exit(code)
