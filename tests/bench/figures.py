"""From samples to figures: medians, ratios with quartiles, means over the ladder, and the targets. Writes nothing."""

import json
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from bench.timing import summarise


def rows_of(rung, task):
    return [row for row in rung["rows"] if row["task"] == task]


def milliseconds(rung, task, contender, kind="cpu"):
    """Quartiles over queries and rounds; None where the contender did not run."""
    values = [v for row in rows_of(rung, task) for v in row["samples"].get(contender, {}).get(kind, [])]
    return summarise(values) if values else None


def ratios(rung, task, ours, theirs, kind="cpu"):
    """Quartiles of ours / theirs, each taken within one turn; None where one of them did not run."""
    values = []
    for row in rows_of(rung, task):
        samples = row["samples"]
        if ours in samples and theirs in samples:
            values += [a / b for a, b in zip(samples[ours][kind], samples[theirs][kind], strict=True)]
    return summarise(values) if values else None


def ladder_mean(results, task, ours, theirs):
    """Geometric mean over the meshes of the median ratios."""
    found = [ratios(rung, task, ours, theirs) for rung in results["rungs"]]
    medians = [quartiles[1] for quartiles in found if quartiles]
    return geometric_mean(medians)


def geometric_mean(values):
    return float(np.exp(np.mean(np.log(values)))) if values else None


def excess_over_shortest(rung):
    """For each library the lengths of its lines over the shortest that any library found, less 1."""
    lengths = {name: np.array(values) for name, values in rung["quality"]["lengths"].items()}
    shortest = np.min(list(lengths.values()), axis=0)
    return {name: values / shortest - 1 for name, values in lengths.items()}


def read_criterion(folder):
    """Median microseconds of each part that cargo bench has timed, by name."""
    parts = {}
    for path in sorted(folder.rglob("new/estimates.json")) if folder and folder.is_dir() else []:
        about = json.loads((path.parent / "benchmark.json").read_text(encoding="utf-8"))
        median = json.loads(path.read_text(encoding="utf-8"))["median"]
        bounds = median["confidence_interval"]
        micro = [1e-3 * ns for ns in (bounds["lower_bound"], median["point_estimate"], bounds["upper_bound"])]
        parts[about["full_id"]] = micro
    return parts


@dataclass(frozen=True)
class Target:
    """A target, what it is compared in, and how the figure is got from results and parts (None: not measured)."""

    task: str
    unit: str
    target: float
    stretch: float
    measure: Callable[[dict, dict], float | None]


def mean_of(task, theirs="MeshLib", ours="ours"):
    return lambda results, parts: ladder_mean(results, task, ours, theirs)


def last_of(task, contender, mesh=None):
    """Milliseconds on one mesh, or on the largest."""

    def measure(results, parts):
        rungs = [rung for rung in results["rungs"] if mesh in (None, rung["name"])]
        found = milliseconds(rungs[-1], task, contender) if rungs else None
        return found and found[1]

    return measure


def twins(results, parts):
    """Our table of twins as criterion timed it over libigl's on the same mesh: two processes, one machine."""
    theirs = last_of("open", "libigl", "igea")(results, parts)
    ours = parts.get("igea/open/adjacency")
    return ours[1] / 1e3 / theirs if ours and theirs else None


def both_rings(results, parts):
    means = [ladder_mean(results, task, "ours", "MeshLib") for task in ("10 picks", "30 picks in a ring")]
    return geometric_mean([mean for mean in means if mean])


def near_and_ring(results, parts):
    means = [ladder_mean(results, f"step B, {task}", "ours", "MeshLib") for task in ("near", "ring")]
    return geometric_mean([mean for mean in means if mean])


def memory(results, parts):
    kept = results["rungs"][-1]["memory"].get("ours") if results["rungs"] else None
    return kept and kept[1]


M, MS = "of MeshLib's", "ms"
COARSE = "cubic, threshold 1e-2"
TARGETS = (
    Target("twins and defects (igea)", "of libigl's", 0.40, 0.25, twins),
    Target("open a mesh, ready to search", M, 0.45, 0.30, mean_of("open")),
    Target("step B, near and ring", f"{M} A*", 0.7, 0.5, near_and_ring),
    Target("step B, across", f"{M} A*", 1.0, 0.8, mean_of("step B, across")),
    Target("step B, across, asked often", f"{M} A*", 0.35, 0.25, mean_of("step B, across, asked often")),
    Target("steps C and D to convergence", f"{M} reducePath", 0.5, 0.25, mean_of("steps C and D, across")),
    Target("geodesic, near", M, 0.6, 0.35, mean_of("geodesic, near")),
    Target("geodesic, across", M, 1.0, 0.3, mean_of("geodesic, across")),
    Target("geodesic, across, asked often", M, 0.4, 0.3, mean_of("geodesic, across, asked often")),
    Target("10 and 30 picks, pinned", M, 0.6, 0.35, both_rings),
    Target("closed, 30 picks, cubic (igea)", MS, 50, 15, last_of("closed, 30 picks", "cubic", "igea")),
    Target("the same with threshold 1e-2", MS, 50, 15, last_of("closed, 30 picks", COARSE, "igea")),
    Target("a dragged pick, fair (largest)", MS, 8, 2, last_of("a dragged pick", "fair")),
    Target("a dragged pick, cubic (largest)", MS, 8, 2, last_of("a dragged pick", "cubic")),
    Target("the same with threshold 1e-2", MS, 8, 2, last_of("a dragged pick", COARSE)),
    Target("a stroke of 2000 points, fair (igea)", MS, 50, 50, last_of("a stroke of 2000 points", "fair", "igea")),
    Target("the same, cubic", MS, 50, 50, last_of("a stroke of 2000 points", "cubic", "igea")),
    Target("the same, cubic with threshold 1e-2", MS, 50, 50, last_of("a stroke of 2000 points", COARSE, "igea")),
    Target("memory (largest)", "B a triangle", 110, 80, memory),
)
