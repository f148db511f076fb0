"""How cost grows: with the mesh, and with the length of the line. Small PNG files; none where matplotlib is absent."""

import importlib.util

from bench import figures

TASKS = ("open", "step B, across", "geodesic, near", "geodesic, across", "30 picks in a ring")
STYLES = {"ours": ("C3", "o", 2.0), "MeshLib": ("C0", "s", 1.2), "potpourri3d": ("C2", "^", 1.2)}


def draw(results, folder):
    """Write the plots; returns their paths."""
    if importlib.util.find_spec("matplotlib") is None:
        print("no plots: matplotlib is not installed")
        return []
    import matplotlib

    matplotlib.use("Agg")
    folder.mkdir(parents=True, exist_ok=True)
    pictures = [draw_by_mesh(results, folder / "cost_by_mesh.png")]
    if results["by_length"]:
        pictures.append(draw_by_length(results["by_length"], folder / "cost_by_length.png"))
    return pictures


def draw_by_mesh(results, path):
    from matplotlib import pyplot
    from matplotlib.ticker import NullFormatter

    figure, axes = pyplot.subplots(1, len(TASKS), figsize=(3 * len(TASKS), 3.2), sharey=True)
    for axis, task in zip(axes, TASKS, strict=True):
        for name, (colour, marker, width) in STYLES.items():
            found = [(rung["triangles"], figures.milliseconds(rung, task, name)) for rung in results["rungs"]]
            found = [(size, quartiles[1]) for size, quartiles in found if quartiles]
            if found:
                axis.loglog(*zip(*found, strict=True), color=colour, marker=marker, linewidth=width, label=name)
        axis.set_title(task, fontsize=10)
        axis.set_xlabel("triangles")
        axis.xaxis.set_minor_formatter(NullFormatter())
        axis.grid(alpha=0.3)
    axes[0].set_ylabel("CPU time, ms")
    axes[0].legend(fontsize=8)
    return save(figure, path)


def draw_by_length(by_length, path):
    from matplotlib import pyplot
    from matplotlib.ticker import NullFormatter

    figure, axis = pyplot.subplots(figsize=(6, 4))
    rows = by_length["rows"]
    for i, name in enumerate(rows[0]["cpu"]):
        is_ours = name.startswith("ours")
        line = {"linewidth": 1.8, "marker": "o"} if is_ours else {"linewidth": 1.2, "marker": "s", "linestyle": "--"}
        points = [(row["crossings"], row["cpu"][name]) for row in rows]
        axis.loglog(*zip(*points, strict=True), color=f"C{i}", markersize=4, label=name, **line)
    axis.set_xlabel("points of the geodesic line")
    axis.xaxis.set_minor_formatter(NullFormatter())
    axis.set_ylabel("CPU time, ms")
    axis.set_title(f"two picks on {by_length['name']}", fontsize=10)
    axis.grid(alpha=0.3)
    axis.legend(fontsize=8)
    return save(figure, path)


def save(figure, path):
    from matplotlib import pyplot

    figure.tight_layout()
    # No date and no version inside: the same figures give the same file.
    figure.savefig(path, dpi=80, metadata={"Software": None})
    pyplot.close(figure)
    return path
