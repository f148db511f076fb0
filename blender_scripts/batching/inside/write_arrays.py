"""The lines of a file as JSON, CSV and NPZ: exact points, and where on the mesh each of them lies.

Equal lines give equal bytes: no times, no dates, keys in order, numbers written so that they are read back to the bit.
"""

import io
import json
import zipfile
from pathlib import Path
from typing import Any

import numpy as np

from .make_lines import MadeLine

# The earliest date that a zip file can hold.
NO_DATE = (1980, 1, 1, 0, 0, 0)
CSV_COLUMNS = "object,line,point,x,y,z,face,vertex_0,vertex_1,vertex_2,weight_0,weight_1,weight_2"


def place_points(made: MadeLine, space: str) -> np.ndarray:
    """The points, (N, 3) float64, in world space or in the object's."""
    line, arrays = made.computed.line, made.computed.arrays
    if space == "world":
        return line.points
    corners = arrays.local_positions[arrays.triangles[line.triangles]]
    return np.einsum("nc,nci->ni", line.barycentric, corners)


def describe(made: MadeLine, space: str) -> dict[str, Any]:
    """All that is written of one line."""
    line, arrays = made.computed.line, made.computed.arrays
    return {
        "points": place_points(made, space),
        "faces": arrays.triangle_faces[line.triangles],
        "vertices": arrays.triangles[line.triangles],
        "weights": line.barycentric,
    }


def write_json(path: Path, lines: list[MadeLine], space: str, input_name: str) -> None:
    """lines.json: one object for each line."""
    written = []
    for made in lines:
        line = made.computed.line
        written.append(
            {
                "object": made.mesh_object.name,
                "line": made.name,
                "curve": None if made.curve_object is None else made.curve_object.name,
                "closed": line.closed,
                "length": line.length,
                "settings": made.settings,
                "report": {
                    "iterations": line.report.iterations,
                    "stop_reason": line.report.stop_reason,
                    "vertex_passes": line.report.vertex_passes,
                },
                "matrix_world": made.computed.arrays.world_matrix.tolist(),
                **{key: value.tolist() for key, value in describe(made, space).items()},
            }
        )
    text = json.dumps({"file": input_name, "space": space, "lines": written}, ensure_ascii=False, allow_nan=False)
    path.write_bytes(text.encode("utf-8", "backslashreplace") + b"\n")


def write_csv(path: Path, lines: list[MadeLine], space: str) -> None:
    """lines.csv: one row for each point."""
    rows = [CSV_COLUMNS]
    for made in lines:
        told = describe(made, space)
        names = f"{quote(made.mesh_object.name)},{quote(made.name)}"
        columns = zip(
            *(told[key].tolist() for key in ("points", "faces", "vertices", "weights")),
            strict=True,
        )
        for index, (point, face, vertices, weights) in enumerate(columns):
            numbers = (*map(repr, point), face, *vertices, *map(repr, weights))
            rows.append(f"{names},{index},{','.join(map(str, numbers))}")
    path.write_bytes(("\n".join(rows) + "\n").encode("utf-8", "backslashreplace"))


def quote(text: str) -> str:
    """A text as a field of a CSV file."""
    return '"' + text.replace('"', '""') + '"' if any(c in text for c in ',"\n\r') else text


def write_npz(path: Path, lines: list[MadeLine], space: str) -> None:
    """lines.npz: all lines behind one another; line k has the points from `starts[k]` to `starts[k + 1]`."""
    told = [describe(made, space) for made in lines]
    counts = [len(each["points"]) for each in told]
    arrays = {
        "objects": np.array([made.mesh_object.name for made in lines], dtype=np.str_),
        "lines": np.array([made.name for made in lines], dtype=np.str_),
        "closed": np.array([made.computed.line.closed for made in lines], dtype=bool),
        "lengths": np.array([made.computed.line.length for made in lines], dtype=np.float64),
        "starts": np.concatenate([[0], np.cumsum(counts)]).astype(np.int64),
        "points": np.concatenate([each["points"] for each in told]).astype(np.float64),
        "faces": np.concatenate([each["faces"] for each in told]).astype(np.int32),
        "vertices": np.concatenate([each["vertices"] for each in told]).astype(np.int32),
        "weights": np.concatenate([each["weights"] for each in told]).astype(np.float64),
    }
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, array in arrays.items():
            buffer = io.BytesIO()
            np.lib.format.write_array(buffer, np.ascontiguousarray(array), version=(1, 0), allow_pickle=False)
            entry = zipfile.ZipInfo(f"{name}.npy", NO_DATE)
            entry.compress_type = zipfile.ZIP_DEFLATED
            archive.writestr(entry, buffer.getvalue())
