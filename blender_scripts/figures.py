"""Draws the paper's figures again on real meshes and writes the page that shows them.

    python blender_scripts/figures.py --images docs/images --page docs/figures.md [--only figure_18]

Needs the wheel, bpy and the folder of test meshes. What each shows is in `figure_scenes`, how it looks in
`figure_draw`. Not imported by the add-on or the tests.
"""

import argparse
import os
import sys
from pathlib import Path

REPOSITORY = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(REPOSITORY / "tests"))

import bpy  # noqa: E402, F401  (first, as what lies inside it can be imported only then)

import figure_draw  # noqa: E402
import meshes  # noqa: E402
from figure_scenes import FIGURES  # noqa: E402

HEAD = """# The paper's figures, redone

What G.-P. Bonneau and S. Hahmann show in *Smooth Polylines on Polygon Meshes* (2003), on other meshes: models with ears
and horns, and a scan of the size of the paper's ball joint. `make figures` makes this page and its pictures. Blue:
before smoothing; red: the line; green: picks; yellow: the strip. All panels of a figure have one camera.
"""
TABLE = """
| figure | mesh | triangles | picks | line | rounds | vertex passes | length before | length after | ended with | ms | the paper |
|---|---|---|---|---|---|---|---|---|---|---|---|"""  # noqa: E501
TAIL = """
Lengths are in the units of each mesh; times are those of one run on two busy cores, `report.seconds["total"]`.
Not stated: not among the figures of the paper that this project has.
"""


def table_rows(figure: "figure_scenes.Figure") -> list[str]:  # noqa: F821
    """A row a line."""
    rows = []
    for what, picks, line in figure.rows:
        report = line.report
        rows.append(
            f"| {figure.title.split(' ', 1)[1]} | {figure.mesh.name} | {len(figure.mesh.triangles):,} | {picks} "
            f"| {what} | {report.iterations} | {report.vertex_passes} | {report.start_length:.4g} | {line.length:.4g} "
            f"| {report.stop_reason} | {1e3 * report.seconds['total']:.1f} | {figure.paper} |"
        )
    return rows


def main() -> None:
    """All figures, or some, and the page where all were drawn."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--images", type=Path, required=True, help="folder for the pictures")
    parser.add_argument("--page", type=Path, help="the page to write")
    parser.add_argument("--only", action="append", default=[], help="names of figures, as figure_18")
    arguments = parser.parse_args()
    if not meshes.find_mesh_folder().is_dir():
        sys.exit(f"the figures need the folder of test meshes {meshes.find_mesh_folder()}")
    parts, rows = [], []
    for make in FIGURES:
        figure = make()
        if arguments.only and figure.name not in arguments.only:
            continue
        width, height, columns = figure.size
        path = arguments.images / f"{figure.name}.png"
        figure_draw.draw(figure.panels, figure.view, path, width, height, columns)
        print(f"{figure.title}: {figure.text} {path.stat().st_size // 1000} kB", flush=True)
        parts.append(f"## {figure.title}\n\n![{figure.text}](images/{path.name})\n\n{figure.text}\n")
        rows.extend(table_rows(figure))
    if arguments.page and not arguments.only:
        arguments.page.write_text("\n".join([HEAD, *parts, "## In numbers", TABLE, *rows, TAIL]), encoding="utf-8")


if __name__ == "__main__":
    main()
    sys.stdout.flush()
    # Spares the static destructors of bpy, in which some versions crash or hang.
    os._exit(0)
