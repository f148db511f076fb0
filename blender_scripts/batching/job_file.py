"""A job: read from its file, checked, and with every default filled in. Looks at no input and starts nothing."""

import hashlib
import json
import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from . import schema_check, strict_json
from .errors import JobError

HERE = Path(__file__).parent
SCHEMA_FILE = HERE / "job.schema.json"
EXAMPLE_FILE = HERE / "example.json"
MANIFEST_FILE = HERE.parents[1] / "addon" / "blender_manifest.toml"

# Raised when the same job would leave other bytes than before: results of an older one are then made again.
RESULTS_VERSION = 1

DEFAULT_OPTIONS = {
    "filter": "linear",
    "closed": False,
    "pinned": "ends",
    "solver": "auto",
    "knots": "centripetal",
    "support": 2,
    "threshold": 1e-4,
    "max_iterations": None,
    "detail_size": None,
}
DEFAULT_LIMITS = {"seconds": 3600, "attempts": 2, "files_a_process": 200}
DEFAULT_PREVIEW = {"size": [640, 480], "engine": "cycles"}
# What an input's bytes and these keys say decides the results; inputs and limits do not.
DECISIVE = ("import", "objects", "source", "search_radius", "lines", "nets", "make", "outputs")


@dataclass(frozen=True)
class Job:
    """A checked job."""

    path: Path
    folder: Path  # that relative paths start from
    output: Path  # folder of the results, absolute
    values: dict[str, Any]  # the job with all defaults; what the worker processes get
    inputs: list[str] | None  # files and patterns as written; None: the file that Blender has open
    fingerprint: str

    @property
    def setup(self) -> dict[str, Any]:
        """What a worker must know before its first file."""
        return {"job": self.values, "output": str(self.output), "fingerprint": self.fingerprint}


def load_job(path: Path) -> Job:
    """The job in the file at `path`; JobError with a line for each fault."""
    value = strict_json.read_json(path)
    return make_job(value, path)


def make_job(value: Any, path: Path) -> Job:
    """The job that `value` describes, as if it stood in the file at `path`."""
    faults = schema_check.list_faults(value, read_schema())
    if not faults:
        faults = [*list_name_faults(value), *list_reference_faults(value)]
    if faults:
        raise JobError(*(f"{path.name}: {fault}" for fault in faults))
    values = fill_in(value)
    folder = path.absolute().parent
    decisive = {key: values[key] for key in DECISIVE}
    decisive["outputs"] = {key: v for key, v in values["outputs"].items() if key != "folder"}
    text = json.dumps([RESULTS_VERSION, read_version(), decisive], sort_keys=True)
    return Job(
        path=path,
        folder=folder,
        output=folder / value["outputs"]["folder"],
        values=values,
        inputs=value.get("inputs"),
        fingerprint=hashlib.sha256(text.encode()).hexdigest()[:32],
    )


def read_schema() -> dict[str, Any]:
    """The schema of a job."""
    return json.loads(SCHEMA_FILE.read_text(encoding="utf-8"))


def read_version() -> str:
    """The version of these scripts, which the extension and its library must have too."""
    return tomllib.loads(MANIFEST_FILE.read_text(encoding="utf-8"))["version"]


def list_name_faults(value: dict[str, Any]) -> list[str]:
    """Two lines or nets of one name could not be told apart in the report."""
    seen: dict[str, str] = {}
    faults = []
    for kind in ("lines", "nets"):
        for index, line in enumerate(value.get(kind, [])):
            place = f"{kind}[{index}]"
            if line["name"] in seen:
                faults.append(f"{place}.name: {seen[line['name']]} has the name {json.dumps(line['name'])} too")
            seen.setdefault(line["name"], place)
    return faults


def list_reference_faults(value: dict[str, Any]) -> list[str]:
    """What the schema cannot say: indices into the job itself, and settings that exclude each other."""
    faults = []
    if not value.get("lines") and not value.get("nets"):
        faults.append('the job: has neither "lines" nor "nets"; there is nothing to make')
    for index, net in enumerate(value.get("nets", [])):
        connections = net.get("connections", "all")
        if isinstance(connections, str):
            continue
        for k, pair in enumerate(connections):
            place = f"nets[{index}].connections[{k}]"
            if max(pair) >= len(net["picks"]):
                faults.append(
                    f"{place}: pick {max(pair)} is out of range; the net has {len(net['picks'])} picks, from 0"
                )
            elif pair[0] == pair[1]:
                faults.append(f"{place}: joins pick {pair[0]} to itself")
    for place, line in (("options", value.get("options", {})), *_list_lines(value)):
        chosen = {**value.get("options", {}), **line}.get("filter", "linear")
        if "detail_size" in line and chosen != "fair":
            faults.append(f'{place}.detail_size: is of the filter "fair", but the filter is "{chosen}"')
    for index, line in enumerate(value.get("lines", [])):
        closed = {**value.get("options", {}), **line}.get("closed", False)
        if closed and "picks" in line and len(line["picks"]) < 3:
            faults.append(f"lines[{index}].picks: a closed line needs 3 picks or more, found {len(line['picks'])}")
    axes = {key: value.get("import", {}).get(key) for key in ("forward", "up")}
    if (axes["forward"] is None) != (axes["up"] is None):
        faults.append("import: forward and up belong together; give both or neither")
    elif axes["up"] is not None and axes["up"][-1] == axes["forward"][-1]:
        faults.append(f"import: forward {axes['forward']} and up {axes['up']} lie on one axis")
    if "seams" in value.get("make", {}) and value.get("source") == "evaluated":
        faults.append('make.seams: lines on what modifiers make cannot be put into the mesh; leave out "source"')
    if value.get("make", {}).get("unwrap") is not None and "seams" not in value["make"]:
        faults.append('make.unwrap: needs seams to unwrap along; add "seams"')
    return faults


def _list_lines(value: dict[str, Any]) -> list[tuple[str, dict[str, Any]]]:
    return [(f"{kind}[{k}]", line) for kind in ("lines", "nets") for k, line in enumerate(value.get(kind, []))]


def fill_in(value: dict[str, Any]) -> dict[str, Any]:
    """The job with all defaults; lines and nets with all their options."""
    options = {**DEFAULT_OPTIONS, **value.get("options", {})}
    objects = value.get("objects", ["*"])
    outputs = {"space": "world", **value["outputs"]}
    outputs["preview"] = {**DEFAULT_PREVIEW, **outputs.get("preview", {})}

    def complete(line: dict[str, Any]) -> dict[str, Any]:
        filled = {"objects": objects, **options, **line}
        if filled["filter"] != "fair":
            filled["detail_size"] = None
        return filled

    return {
        "import": value.get("import", {}),
        "objects": objects,
        "source": value.get("source", "base"),
        "search_radius": value.get("search_radius"),
        "lines": [complete(line) for line in value.get("lines", [])],
        "nets": [
            {"connections": "all", "avoid_crossings": None, **complete(net), "closed": False}
            for net in value.get("nets", [])
        ],
        "make": value.get("make", {"curves": {}}),
        "outputs": outputs,
        "limits": {**DEFAULT_LIMITS, **value.get("limits", {})},
    }
