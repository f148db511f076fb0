"""The measured part of docs/benchmarks.md: tables from results. What the rest of the page says is written by hand.

The part between the two marks is replaced; a page that is not there yet is made. Holds no arithmetic (figures.py).
"""

import os

import numpy as np

from bench import figures
from bench.tasks import NETWORK_BY, NETWORK_PICKS, SMOOTH_BY

BEGIN = "<!-- measured: what follows is written by `make bench` -->"
END = "<!-- /measured -->"
TASKS = (
    "open", "step B, near", "step B, ring", "step B, across", "step B, across, asked often", "steps C and D, across",
    "geodesic, near", "geodesic, across", "geodesic, across, asked often", "10 picks", "30 picks in a ring",
)  # fmt: skip
PEERS = ("MeshLib", "potpourri3d", "libigl")
OUR_TASKS = (
    ("closed, 30 picks", tuple(SMOOTH_BY)),
    ("a dragged pick", (*SMOOTH_BY, "MeshLib, geodesic, two segments")),
    ("a stroke of 2000 points", ("none", *(name for name in SMOOTH_BY if name != "geodesic"))),
)


def write(results, path, pictures, criterion=None):
    """Put the tables and pictures into the page."""
    parts = figures.read_criterion(criterion)
    sections = [
        tell_machine(results),
        "### Targets\n\n" + targets_table(results, parts),
        "### Ours over MeshLib, potpourri3d, libigl: CPU time\n\n" + ratio_tables(results),
        "### Milliseconds of CPU time\n\n" + milliseconds_table(results),
        "### What only this library does\n\n" + own_table(results),
        "### Every core\n\n" + cores_table(results),
        "### Beside exact and edge-bound ones\n\n" + slow_table(results),
        "### Quality of the lines that were timed\n\n" + quality_table(results),
        "### Memory\n\n" + memory_table(results),
    ]
    if parts:
        sections.append("### The parts, by criterion\n\n" + parts_table(parts))
    # Links always have forward slashes.
    images = [os.path.relpath(picture, path.parent).replace(os.sep, "/") for picture in pictures]
    sections += [f"![{alt_text(image)}]({image})" for image in images]
    measured = f"{BEGIN}\n\n" + "\n\n".join(sections) + f"\n\n{END}"
    text = path.read_text(encoding="utf-8") if path.is_file() else f"# Benchmarks\n\n{BEGIN}\n{END}\n"
    before, rest = text.split(BEGIN)
    after = rest.split(END)[1]
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(before + measured + after, encoding="utf-8")


def alt_text(image):
    return "CPU time against the number of " + ("triangles" if "mesh" in image else "crossings")


def table(head, rows):
    """A Markdown table; all columns but the first are numbers."""
    lines = ["| " + " | ".join(head) + " |", "|---|" + "---:|" * (len(head) - 1)]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows])


def number(value):
    """Three digits, no exponent."""
    if value is None:
        return ""
    if value == 0 or abs(value) >= 100:
        return f"{value:.0f}"
    return f"{value:.{max(0, 2 - int(np.floor(np.log10(abs(value)))))}f}"


def spread(quartiles):
    return f"{number(quartiles[1])} ({number(quartiles[0])} to {number(quartiles[2])})" if quartiles else ""


def tell_machine(results):
    machine, versions = results["machine"], results["versions"]
    versions = ", ".join(f"{name} {version}" for name, version in versions.items())
    absent = f" Not installed: {', '.join(results['absent'])}." if results["absent"] else ""
    return (
        f"Measured on: {machine['processor']}, {machine['cores']} cores, {machine['memory']}; {machine['system']}; "
        f"Python {machine['Python']}, numpy {machine['numpy']}. {versions}.{absent}"
    )


def targets_table(results, parts):
    rows = []
    for target in figures.TARGETS:
        measured = target.measure(results, parts)
        state = verdict(measured, target)
        shown = "not measured" if measured is None else number(measured)
        rows.append([f"{target.task}, {target.unit}", f"{target.target:g}", f"{target.stretch:g}", shown, state])
    return table(["task", "target", "stretch", "measured", ""], rows)


def verdict(measured, target):
    if measured is None:
        return ""
    if measured <= target.stretch:
        return "met, stretch too"
    return "met" if measured <= target.target else f"**missed**, {number(measured / target.target)} times the target"


def ratio_tables(results):
    rungs = results["rungs"]
    rows = []
    for peer in PEERS:
        for task in TASKS:
            cells = [spread(figures.ratios(rung, task, "ours", peer)) for rung in rungs]
            if any(cells):
                rows.append([f"{task} / {peer}", *cells, number(figures.ladder_mean(results, task, "ours", peer))])
    head = ["task / peer", *[f"{r['name']}, {r['triangles'] / 1000:.0f}k" for r in rungs], "mean"]
    note = (
        "Median of the ratios within one turn, quartiles in brackets; the mean is geometric. Steps C and D: wall time, "
        "ours by its own clock. Asked often: after so many far lines that a large mesh has chosen its landmarks."
    )
    return note + "\n\n" + table(head, rows)


def milliseconds_table(results):
    rows = []
    for task in TASKS:
        for name in ("ours", *PEERS):
            cells = [cpu_and_wall(rung, task, name) for rung in results["rungs"]]
            if any(cells):
                rows.append([f"{task}: {name}", *cells])
    return "Medians; in brackets the wall time where it differs by a fifth.\n\n" + table(rung_head(results), rows)


def cpu_and_wall(rung, task, name):
    cpu, wall = (figures.milliseconds(rung, task, name, kind) for kind in ("cpu", "wall"))
    if cpu is None:
        return ""
    differs = not 0.8 < wall[1] / cpu[1] < 1.2
    return number(cpu[1]) + (f" ({number(wall[1])})" if differs else "")


def rung_head(results):
    return ["", *[rung["name"] for rung in results["rungs"]]]


def own_table(results):
    rows = []
    for task, contenders in OUR_TASKS:
        for name in contenders:
            cells = [spread(figures.milliseconds(rung, task, name)) for rung in results["rungs"]]
            if any(cells):
                rows.append([f"{task}: {name}", *cells])
    ends = {name: [rung["closed"][name] for rung in results["rungs"]] for name in OUR_TASKS[0][1]}
    for name, outcomes in ends.items():
        told = [x if isinstance(x, str) else f"{x[0].replace('_', ' ')}, {x[1]} points" for x in outcomes]
        rows.append([f"closed, 30 picks: {name} ended", *told])
    note = (
        "Milliseconds of CPU time, quartiles in brackets. A dragged pick: one of 10 pinned picks moves, and "
        "the line is made from the one before."
    )
    return note + "\n\n" + table(rung_head(results), rows)


def cores_table(results):
    rows = []
    for name in NETWORK_BY:
        task, ways = f"network, {name}", ("in one call", "one by one")
        walls = {way: [figures.milliseconds(rung, task, way, "wall") for rung in results["rungs"]] for way in ways}
        rows += [[f"{task}: {way}, ms", *[spread(wall) for wall in walls[way]]] for way in ways]
        rows.append([f"{task}: share", *[spread(figures.ratios(r, task, *ways, "wall")) for r in results["rungs"]]])
    note = (
        f"Wall time of a line between every two of {NETWORK_PICKS} picks, quartiles in brackets: `network`, on "
        f"{results['machine']['cores']} cores, beside the same lines one after the other, which are equal to the byte."
    )
    return note + "\n\n" + table(rung_head(results), rows)


def slow_table(results):
    rows = []
    for name in ("ours", "pygeodesic", "pyvista"):
        cells = [spread(figures.milliseconds(rung, "geodesic, beside slow ones", name)) for rung in results["rungs"]]
        if any(cells):
            rows.append([name, *cells])
    if not rows:
        return "Neither pygeodesic nor pyvista was installed."
    return "Across, milliseconds; pygeodesic on small meshes alone.\n\n" + table(rung_head(results), rows)


def quality_table(results):
    rows = []
    for rung in (r for r in results["rungs"] if "quality" in r):
        turns = rung["quality"]["turns"]
        for name, excess in figures.excess_over_shortest(rung).items():
            has_turns = turns[name]["unplaced"] < len(excess)
            degrees = [f"{turns[name][kind]:.2g}" if has_turns else "" for kind in ("edge", "vertex")]
            same = np.mean(excess < 1e-5)
            means = [f"{100 * value:.3f} %" for value in (excess.mean(), excess.max())]
            rows.append(
                [f"{rung['name']}: {name}", *means, f"{100 * same:.0f} %", *degrees, str(turns[name]["unplaced"])]
            )
    note = (
        "Lines near, across and between random vertices. Excess: over the shortest line that any library found (exact "
        "where pygeodesic ran). Shortest: as short to 1e-5. Turns: the largest at a crossing, and by which the smaller "
        "side at a mesh vertex lacks to 180 degrees, beyond what rounding of the library's own numbers explains. Not "
        "judged: lines whose points could not be placed on the mesh."
    )
    head = ["", "mean excess", "largest", "shortest", "turn at a crossing, degrees", "at a vertex", "not judged"]
    return note + "\n\n" + table(head, rows)


def memory_table(results):
    rungs = [rung for rung in results["rungs"] if rung["memory"]]
    names = [name for name in ("ours", *PEERS, "pygeodesic", "pyvista") if any(name in r["memory"] for r in rungs)]
    rows = []
    for name in names:
        kept = [rung["memory"].get(name) for rung in rungs]
        rows.append([name, *[f"{number(k[0])}, {number(k[1])}" if k else "" for k in kept]])
    note = (
        "Growth of a fresh process, bytes a triangle: after opening the mesh, and after one geodesic line across too. "
        "The caller's own arrays are not counted; small meshes are left out: there only the process's own grain shows."
    )
    return note + "\n\n" + table(["", *[rung["name"] for rung in rungs]], rows)


def parts_table(parts):
    rows = [[name, *[number(micro) for micro in values]] for name, values in parts.items()]
    return "Microseconds a call: median and its 95 % bounds.\n\n" + table(["part", "low", "median", "high"], rows)
