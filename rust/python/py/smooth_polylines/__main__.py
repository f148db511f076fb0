"""A quick look without a script: `python -m smooth_polylines MESH --picks 12,845,99 --filter cubic -o line.obj`.

Exit codes: 0: the line is written; 1: the mesh or the picks give no line; 2: arguments or files that will not do.
Reading files is `mesh_files`, writing `line_files`; holds no geometry.
"""

import argparse
import sys
from pathlib import Path

import smooth_polylines as sp

from . import line_files, mesh_files

WRITTEN, NO_LINE, BAD_ARGUMENTS = 0, 1, 2


def read_picks(text: str) -> list[int]:
    """Face ids from "12,845,99"."""
    try:
        return [int(word) for word in text.split(",")]
    except ValueError:
        raise argparse.ArgumentTypeError(f"expected face numbers with commas, as 12,845,99, found {text!r}") from None


def parse(arguments: list[str] | None) -> argparse.Namespace:
    """What the arguments say; SystemExit(2) where they are wrong."""
    parser = argparse.ArgumentParser(
        prog="python -m smooth_polylines", description="A smooth line through picked faces of a mesh file."
    )
    parser.add_argument(
        "mesh", type=Path, metavar="MESH", help=".obj, or what meshio or trimesh can read: .ply .stl .off ..."
    )
    parser.add_argument("--picks", type=read_picks, required=True, help="numbers of faces in order, from 0: 12,845,99")
    parser.add_argument("--filter", choices=("linear", "cubic", "geodesic", "fair", "none"), default="linear")
    parser.add_argument("--closed", action="store_true", help="join the last pick to the first")
    parser.add_argument("--pinned", choices=("ends", "all"), default="ends", help="picks that are passed exactly")
    parser.add_argument("--knots", choices=("centripetal", "uniform", "chordal"), default="centripetal")
    parser.add_argument("--support", type=int, default=2, help="of cubic: crossings looked at on each side")
    parser.add_argument("--threshold", type=float, default=1e-4, help="of cubic: where sliding stops")
    parser.add_argument("--detail-size", type=float, help="of fair: a length; shorter wiggles go")
    parser.add_argument("-o", "--output", type=Path, help=f"the line's file: {' '.join(line_files.WRITERS)}")
    parser.add_argument("--version", action="version", version=sp.__version__)
    options = parser.parse_args(arguments)
    if options.output is not None and options.output.suffix.lower() not in line_files.WRITERS:
        parser.error(f"--output {options.output}: the name must end in one of {' '.join(line_files.WRITERS)}")
    return options


def main(arguments: list[str] | None = None) -> int:
    """Run the command; the exit code."""
    options = parse(arguments)
    try:
        read = mesh_files.read_mesh(options.mesh)
    except mesh_files.MeshFileError as error:
        print(f"{options.mesh}: {error}", file=sys.stderr)
        return BAD_ARGUMENTS
    try:
        mesh = sp.SurfaceMesh(read.positions, read.triangles, read.triangle_faces)
        line = mesh.polyline(
            options.picks,
            closed=options.closed,
            filter=options.filter,
            pinned=options.pinned,
            threshold=options.threshold,
            detail_size=options.detail_size,
            knots=options.knots,
            support=options.support,
        )
    except sp.Error as error:
        print(f"{type(error).__name__}: {error}", file=sys.stderr)
        return NO_LINE
    report = line.report
    print(f"{options.mesh}: {mesh.report.faces} faces, read by {read.reader}")
    print(
        f"{options.filter} line: length {line.length:.6g}, {len(line.points)} points, "
        f"{report.iterations} rounds, {report.stop_reason}"
    )
    if options.output is not None:
        try:
            line_files.write_line(options.output, line)
        except OSError as error:
            print(f"{options.output}: cannot be written: {error.strerror}", file=sys.stderr)
            return BAD_ARGUMENTS
        print(f"wrote {options.output}")
    return WRITTEN


if __name__ == "__main__":
    sys.exit(main())
