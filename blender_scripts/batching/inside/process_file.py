"""One input file from the opening to its results on the disk, and what became of it.

Nothing of a file may end the process but a crash of Blender itself: all else is an entry of the outcome.
"""

import shutil
import time
import traceback
from pathlib import Path
from typing import Any

import bpy

from batching import input_check, store
from batching.outcome import TRANSIENT, make_entry
from batching.plan import Item

from . import choose_objects, open_input, write_arrays, write_blend, write_picture, write_uv_layout
from .addon_door import get_module
from .check_lines import LineChecker
from .fault import FileFault
from .make_lines import LineMaker, MadeLine

# With less room than this on the output's disk, whatever failed is taken to have failed for it.
LEAST_ROOM = 1_000_000


class FileProcessor:
    """Does one file after another by one job."""

    def __init__(self, package: str, setup: dict[str, Any]) -> None:
        """`setup` is what the run tells a worker first."""
        self._package = package
        self._job = setup["job"]
        self._output = Path(setup["output"])
        self._fingerprint = setup["fingerprint"]
        self._token = setup["token"]

    def process(self, item: Item, *, is_check: bool = False) -> dict[str, Any]:
        """The outcome of one file.

        is_check : only look whether it will do: make nothing; the entries are what is wrong
        """
        clock = Clock()
        try:
            entries, is_saved = (self._check if is_check else self._process)(item, clock)
        except FileFault as fault:
            entries, is_saved = [make_entry(item.name, fault.error, str(fault))], False
        except OSError as error:
            entries, is_saved = [self._judge_os_error(item, error)], False
        except MemoryError:
            entries, is_saved = [make_entry(item.name, "WorkerDiedError", "there was not enough memory for it")], False
        except Exception as error:
            traceback.print_exc()
            entries, is_saved = [make_entry(item.name, "InternalError", f"{type(error).__name__}: {error}")], False
        finally:
            get_module(self._package, "surface").forget_surfaces()
        for entry in entries:
            if entry["status"] == "failed":
                # Blender names files by their whole path, which is another on each machine.
                entry["message"] = entry["message"].replace(item.input, item.name)
        stop = None
        if any(entry["status"] == "failed" and entry["error"] == "DiskFullError" for entry in entries):
            stop = f"{self._output}: no space left on the disk; make room, then start the same command again to go on"
        is_transient = any(entry["status"] == "failed" and entry["error"] in TRANSIENT for entry in entries)
        return {
            "entries": entries,
            "saved": is_saved,
            "transient": is_transient,
            "stop": stop,
            "seconds": {name: round(seconds, 4) for name, seconds in clock.seconds.items()},
        }

    def _judge_os_error(self, item: Item, error: OSError) -> dict[str, Any]:
        text = error.strerror or str(error)
        if error.errno in store.FULL_ERRORS:
            return make_entry(item.name, "DiskFullError", text)
        return make_entry(item.name, "OutputError", f"{text}; see to it that the results' folder can be written")

    def _check(self, item: Item, clock: "Clock") -> tuple[list[dict[str, Any]], bool]:
        self._open(item, clock)
        with clock.measure("lines"):
            return self._make_lines(item, LineChecker).entries, False

    def _open(self, item: Item, clock: "Clock") -> None:
        fault = input_check.find_fault(item)
        if fault is not None:
            raise FileFault(*fault)
        with clock.measure("opening"):
            open_input.open_input(item.input, self._job["import"])

    def _process(self, item: Item, clock: "Clock") -> tuple[list[dict[str, Any]], bool]:
        self._open(item, clock)
        with clock.measure("reading"):
            size, digest = store.hash_file(item.input)
        with clock.measure("lines"):
            maker = self._make_lines(item, LineMaker)
        if not maker.made:
            return maker.entries, False
        record = {
            "fingerprint": self._fingerprint,
            "input": {"name": item.name, "bytes": size, "sha256": digest},
            "blender": bpy.app.version_string,
        }
        try:
            with store.open_part(self._output, item.result, self._token) as part:
                self._write(part, maker, item, clock)
                entries = maker.entries
                (part / store.RECORD_NAME).write_bytes(store.dump_json({**record, "entries": entries}))
        except (FileFault, OSError) as error:
            # Blender tells of a full disk in words alone.
            is_full = shutil.disk_usage(self._output).free < LEAST_ROOM or "space left" in str(error)
            if is_full and not (isinstance(error, OSError) and error.errno in store.FULL_ERRORS):
                raise FileFault("DiskFullError", str(error).partition(";")[0]) from error
            raise
        return entries, True

    def _make_lines(self, item: Item, kind_of_maker: type[LineMaker]) -> LineMaker:
        """All lines and nets on all objects that they are for, object by object: one mesh is opened at a time."""
        meshes = choose_objects.list_meshes()
        maker = kind_of_maker(self._package, self._job, item.name)
        job = maker.job
        wanted: dict[str, tuple[list[dict], list[dict]]] = {o.name: ([], []) for o in meshes}
        for kind, lines in enumerate((job["lines"], job["nets"])):
            for line in lines:
                try:
                    for mesh_object in choose_objects.choose_objects(meshes, line["objects"]):
                        wanted[mesh_object.name][kind].append(line)
                except FileFault as fault:
                    if not meshes:
                        raise
                    maker.entries.append(make_entry(item.name, fault.error, str(fault), line=line["name"]))
        for mesh_object in meshes:
            maker.make_all(mesh_object, *wanted[mesh_object.name])
        return maker

    def _write(self, part: Path, maker: LineMaker, item: Item, clock: "Clock") -> None:
        """All outputs of the job into the folder `part`; the pictures last, since they change what is open."""
        outputs, made = self._job["outputs"], maker.made
        space = outputs["space"]
        with clock.measure("writing"):
            if "json" in outputs["formats"]:
                write_arrays.write_json(part / "lines.json", made, space, item.name)
            if "csv" in outputs["formats"]:
                write_arrays.write_csv(part / "lines.csv", made, space)
            if "npz" in outputs["formats"]:
                write_arrays.write_npz(part / "lines.npz", made, space)
            if "svg" in outputs["formats"]:
                maker.entries.extend(self._write_uv_layouts(part, made, item))
            if "blend" in outputs["formats"]:
                is_imported = not item.input.lower().endswith(".blend")
                write_blend.write_blend(part / "result.blend", is_imported=is_imported)
        if "png" in outputs["formats"]:
            with clock.measure("picture"):
                write_picture.write_picture(part / "preview.png", made, outputs["preview"])

    def _write_uv_layouts(self, part: Path, made: list[MadeLine], item: Item) -> list[dict[str, Any]]:
        """One SVG for each object with lines; the entries of those that have no UV map."""
        entries = []
        for mesh_object in dict.fromkeys(each.mesh_object for each in made):
            lines = [each for each in made if each.mesh_object == mesh_object]
            path = part / f"uv-{write_uv_layout.make_file_name(mesh_object.name)}.svg"
            try:
                write_uv_layout.write_uv_layout(path, mesh_object, lines, self._job["source"] == "evaluated")
            except FileFault as fault:
                entries.append(make_entry(item.name, fault.error, str(fault), object_name=mesh_object.name))
        return entries


class Clock:
    """Seconds of each part of the work."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}

    def measure(self, name: str) -> "Clock":
        """Used in a `with`: adds what it took."""
        self._name = name
        return self

    def __enter__(self) -> None:
        self._begin = time.perf_counter()

    def __exit__(self, *_: object) -> None:
        self.seconds[self._name] = self.seconds.get(self._name, 0.0) + time.perf_counter() - self._begin
