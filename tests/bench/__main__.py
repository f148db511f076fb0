"""The command: times us and the installed peers on a ladder of meshes, judges the lines, writes the page and plots.

Holds the order of things and the options; what is timed is in tasks.py, what is written in page.py.
"""

import argparse
import json
import time
from pathlib import Path

from bench import ladder, machine, page, plots
from bench.memory import bytes_a_triangle
from bench.peers import Ours, find_installed, version_of
from bench.quality import MOST_TRIANGLES, judge_lines
from bench.tasks import Timer, time_by_length

# Names of meshes, rounds, seconds that one query may take, and triangles from which memory is measured: on fewer only
# the process's own grain shows.
SIZES = {
    "full": (ladder.SHARED, 7, 4.0, 50_000),
    "quick": (ladder.SHARED[:3], 3, 1.0, 50_000),
    "tiny": (("ball of 3 cuts",), 3, 0.1, 0),
}
# Without the shared meshes.
MADE = tuple(f"ball of {cuts} cuts" for cuts in (5, 6, 7, 8))


def measure(size, only=()):
    """Everything, as plain lists and dicts."""
    names, rounds, budget, least_triangles = SIZES[size]
    if size != "tiny" and not ladder.has_shared_meshes():
        tell("no shared test meshes here: made ones are used")
        names = MADE[: len(names)]
    peers, absent = find_installed()
    results = {
        "machine": machine.describe(),
        "versions": {peer.name: version_of(peer) for peer in peers},
        "absent": absent,
        "rungs": [],
        "by_length": None,
    }
    for name in names:
        if only and name not in only:
            continue
        began = time.perf_counter()
        rung = ladder.load_rung(name)
        timer = Timer(rung, peers, rounds, budget)
        measured = {
            "name": rung.short_name,
            "triangles": len(rung.triangles),
            "rows": timer.run(),
            "closed": timer.closed_outcomes(),
        }
        if len(rung.triangles) <= MOST_TRIANGLES:
            measured["quality"] = judge_lines(rung, timer.opened)
            # Of the meshes whose lines are judged the largest: the last one stays.
            results["by_length"] = {"name": rung.short_name, "rows": time_by_length(timer)}
        del timer
        openers = [peer for peer in peers if hasattr(peer, "path") and len(rung.triangles) >= least_triangles]
        memory = {peer.name: bytes_a_triangle(peer, rung) for peer in openers if is_for(peer, rung)}
        measured["memory"] = {name: kept for name, kept in memory.items() if kept is not None}
        results["rungs"].append(measured)
        tell(f"{rung.short_name}: {len(rung.triangles)} triangles, {time.perf_counter() - began:.0f} s")
    return results


def is_for(peer, rung):
    return len(rung.triangles) <= getattr(peer, "most_triangles", len(rung.triangles))


def tell(message):
    print(message, flush=True)


def main():
    parser = argparse.ArgumentParser(prog="bench", description=__doc__)
    parser.add_argument("--size", choices=SIZES, default="full")
    parser.add_argument("--only", action="append", default=[], metavar="MESH", help="leave the other meshes out")
    parser.add_argument("--output", type=Path, required=True, help="folder for results.json")
    parser.add_argument("--page", type=Path, required=True, help="Markdown file whose measured part is written anew")
    parser.add_argument("--images", type=Path, required=True, help="folder for the plots")
    parser.add_argument("--criterion", type=Path, help="folder in which cargo bench has left its results")
    parser.add_argument("--again", action="store_true", help="measure nothing: use the results.json that is there")
    arguments = parser.parse_args()
    arguments.output.mkdir(parents=True, exist_ok=True)
    stored = arguments.output / "results.json"
    if arguments.again:
        results = json.loads(stored.read_text(encoding="utf-8"))
    else:
        results = measure(arguments.size, arguments.only)
        stored.write_text(json.dumps(results, indent=1), encoding="utf-8")
    pictures = plots.draw(results, arguments.images)
    page.write(results, arguments.page, pictures, arguments.criterion)
    tell(
        f"{Ours.name} {results['versions'][Ours.name]}: {arguments.page}; not installed: {results['absent'] or 'none'}"
    )


if __name__ == "__main__":
    main()
