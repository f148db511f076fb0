"""The command: starts the workers, notices hangs and crashes, and writes the tables of docs/hostile.md.

Holds no judgement (judge.py) and no table (page.py). Ends with 1 if any promise was broken.
"""

import argparse
import json
import subprocess
import sys
import time
from pathlib import Path

from hostile import page
from hostile.worker import EVERY


def run_workers(output, processes, every):
    """One file of JSON lines a worker; which worker ended how."""
    output.mkdir(parents=True, exist_ok=True)
    begun = []
    for share in range(processes):
        log = (output / f"share{share}.jsonl").open("w", encoding="utf-8")
        command = [sys.executable, "-m", "hostile.worker", str(share), str(processes), str(every)]
        begun.append((log, subprocess.Popen(command, stdout=log)))
    codes = []
    for log, process in begun:
        codes.append(process.wait())
        log.close()
    return codes


def read_results(output):
    """Every mesh's records, and the mesh at which each unfinished worker was."""
    results, unfinished = [], []
    for path in sorted(output.glob("share*.jsonl")):
        last = None
        for line in path.read_text(encoding="utf-8").splitlines():
            told = json.loads(line)
            if "begun" in told:
                last = told["begun"]
            else:
                results.append(told)
                last = None
        if last:
            unfinished.append(last)
    return results, unfinished


def main():
    parser = argparse.ArgumentParser(prog="hostile", description=__doc__)
    parser.add_argument("--output", type=Path, required=True, help="folder for the records")
    parser.add_argument("--page", type=Path, required=True, help="Markdown file whose measured part is written anew")
    parser.add_argument("--processes", type=int, default=1)
    parser.add_argument("--every", type=int, default=EVERY, help="which part of the 420 lines of a mesh; 1: all")
    parser.add_argument("--again", action="store_true", help="run nothing: use the records that are there")
    arguments = parser.parse_args()
    began = time.perf_counter()
    if not arguments.again:
        codes = run_workers(arguments.output, arguments.processes, arguments.every)
        print(f"{time.perf_counter() - began:.0f} s, exit codes {codes}", flush=True)
    results, unfinished = read_results(arguments.output)
    broken = page.write(results, unfinished, arguments.page)
    for mesh, record in broken[:50]:
        print(f"BROKEN: {mesh}: {record['way']}, {record['kind']} picks, closed {record['closed']}, pinned "
              f"{record['pinned']}: {record['why'][:200]}")  # fmt: skip
    for place in unfinished:
        print(f"HUNG OR CRASHED at {place}")
    print(f"{sum(len(r['records']) for r in results)} lines on {len(results)} meshes: {len(broken)} broken")
    sys.exit(1 if broken or unfinished else 0)


if __name__ == "__main__":
    main()
