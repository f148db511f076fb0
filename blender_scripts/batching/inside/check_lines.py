"""Lines and nets of a job looked at on an opened file: everything of `make_lines` but the smoothing and the making.

What a line needs is found and joined up, so that whatever is named wrong, hidden, out of range, too far away or apart
is told. Leaves the file and the disk as they were.
"""

from typing import Any

import bpy

from batching.job_file import DEFAULT_OPTIONS

from .fault import FileFault
from .make_lines import LineMaker

UNSMOOTHED = {**DEFAULT_OPTIONS, "filter": "none", "detail_size": None}
# What is not about smoothing.
KEPT_OPTIONS = ("closed", "pinned")


class LineChecker(LineMaker):
    """Finds picks and guides, and ways from one to the next; its entries are what a run would refuse."""

    def __init__(self, package: str, job: dict[str, Any], item_name: str) -> None:
        super().__init__(package, leave_out_smoothing(job), item_name)

    def make_all(self, mesh_object: bpy.types.Object, lines: list[dict[str, Any]], nets: list[dict[str, Any]]) -> None:
        """Look at all lines and nets on one object, and at what is to be done with them."""
        super().make_all(mesh_object, lines, nets)
        needs_map = "svg" in self.job["outputs"]["formats"] and "unwrap" not in self.job["make"]
        if (lines or nets) and needs_map:
            self._try(mesh_object, None, lambda: self._check_uv_map(mesh_object))

    def _keep(self, *_: Any, **_options: Any) -> None:
        """Nothing is kept."""

    def _tell_patches(self, mesh_object: bpy.types.Object, name: str, made: Any) -> None:
        """Lines that are not smoothed part the surface otherwise."""

    def _make_seams(self, mesh_object: bpy.types.Object) -> None:
        edit, make = self._put.edit, self.job["make"]
        edit.check_mode(mesh_object)
        if make["seams"]["method"] != "snap":
            edit.check_changeable(mesh_object, "cut" if make["seams"]["method"] == "cut" else "moved")
        if "unwrap" in make:
            self._unwrap.check_unwrappable(bpy.context, mesh_object)

    def _check_uv_map(self, mesh_object: bpy.types.Object) -> None:
        with self._mesh_read.open_current_mesh(mesh_object, self._source) as mesh:
            if mesh.uv_layers.active is None:
                raise FileFault("NoUVMapError", f"{mesh_object.name} has no UV map")


def leave_out_smoothing(job: dict[str, Any]) -> dict[str, Any]:
    """The job with lines that only lead from pick to pick, and become no curves."""
    return {
        **job,
        "make": {key: value for key, value in job["make"].items() if key != "curves"},
        "lines": [{**line, **UNSMOOTHED, **{k: line[k] for k in KEPT_OPTIONS}} for line in job["lines"]],
        "nets": [
            {**net, **UNSMOOTHED, **{k: net[k] for k in KEPT_OPTIONS}, "avoid_crossings": False} for net in job["nets"]
        ],
    }
