"""The lines and nets of a job on one mesh object: computed, and put into the file as curves where the job wants them.

One bad line is an entry and the others go on. Holds no geometry (the library's) and no files.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

import bpy

from batching.outcome import make_entry

from . import find_strokes
from .addon_door import get_module
from .fault import FileFault
from .find_picks import PickFinder

OPTION_NAMES = (
    "closed",
    "filter",
    "pinned",
    "solver",
    "knots",
    "support",
    "threshold",
    "max_iterations",
    "detail_size",
)


@dataclass(frozen=True)
class MadeLine:
    """One line on one object."""

    name: str
    mesh_object: bpy.types.Object
    computed: Any  # the add-on's ComputedPolyline: line, picks, arrays
    curve_object: bpy.types.Object | None
    settings: dict[str, Any]


class LineMaker:
    """Makes lines on one object after another for one file, and keeps the entries of the report."""

    def __init__(self, package: str, job: dict[str, Any], item_name: str) -> None:
        self._session = get_module(package, "session")
        self._surface = get_module(package, "surface")
        self._mesh_read = get_module(package, "mesh_read")
        self._line_picks = get_module(package, "line_picks")
        self._put = get_module(package, "seams.put")
        self._unwrap = get_module(package, "seams.unwrap")
        self._library = get_module(package, "native").load_library()
        self._errors = get_module(package, "errors")
        self.job = job
        self._item_name = item_name
        self._source = job["source"].upper()
        self.made: list[MadeLine] = []
        self.entries: list[dict[str, Any]] = []

    def make_all(self, mesh_object: bpy.types.Object, lines: list[dict[str, Any]], nets: list[dict[str, Any]]) -> None:
        """All lines and nets on one object."""
        for line in lines:
            if "picks" in line:
                self._try(mesh_object, line["name"], lambda line=line: self._make_from_picks(mesh_object, line))
            else:
                self._try(mesh_object, line["name"], lambda line=line: self._make_along(mesh_object, line))
        for net in nets:
            self._try(mesh_object, net["name"], lambda net=net: self._make_net(mesh_object, net))
        if "seams" in self.job["make"]:
            self._try(mesh_object, None, lambda: self._make_seams(mesh_object))

    def _make_seams(self, mesh_object: bpy.types.Object) -> None:
        """All lines of the object into its mesh, and unwrapped by them where the job says so."""
        lines = [made.computed.line for made in self.made if made.mesh_object == mesh_object]
        if not lines:
            return
        seams = self.job["make"]["seams"]
        done = self._put.put_lines_into_mesh(
            bpy.context,
            mesh_object,
            lines,
            method=seams["method"].upper(),
            marks=[mark.upper() for mark in seams.get("marks", ["seam"])],
        )
        told = {
            "file": self._item_name,
            "object": mesh_object.name,
            "line": None,
            "status": "done",
            "seams": seams["method"],
            "edges": len(done.edges),
            "new_vertices": done.new_vertices,
            "moved": len(done.moved),
            "not_moved": len(done.not_moved),
        }
        unwrap = self.job["make"].get("unwrap")
        if unwrap is not None:
            method = unwrap.get("method", "angle_based").upper()
            islands = self._unwrap.unwrap_and_measure(bpy.context, mesh_object, method=method, write=False).islands
            told |= {"islands": len(islands), "flipped": sum(island.flipped for island in islands)}
        self.entries.append(told)

    def _try(self, mesh_object: bpy.types.Object, name: str | None, work: Callable[[], None]) -> None:
        """Do `work`; what it refuses becomes an entry."""
        try:
            work()
        except FileFault as fault:
            self._fail(mesh_object, name, fault.error, str(fault))
        except self._errors.AddonError as error:
            self._fail(mesh_object, name, type(error).__name__, str(error))
        except self._library.Error as error:
            self._fail(mesh_object, name, type(error).__name__, str(error))

    def _fail(self, mesh_object: bpy.types.Object, name: str | None, error: str, message: str) -> None:
        self.entries.append(make_entry(self._item_name, error, message, object_name=mesh_object.name, line=name))

    def _open(self, mesh_object: bpy.types.Object) -> Any:
        self._session.check_object(mesh_object)
        return self._surface.open_surface(
            bpy.context, mesh_object, source=self._source, with_normals=self._curves().get("offset", 0.0) != 0.0
        )

    def _curves(self) -> dict[str, Any]:
        return self.job["make"].get("curves", {})

    def _find_picks(self, mesh_object: bpy.types.Object, picks: list[Any]) -> tuple[list[Any], list[bool] | None]:
        finder = PickFinder(
            self._library,
            self._mesh_read,
            mesh_object,
            self._source,
            self._open(mesh_object),
            self.job["search_radius"],
        )
        return finder.find_all(picks)

    def _make_from_picks(self, mesh_object: bpy.types.Object, line: dict[str, Any]) -> None:
        picks, flags = self._find_picks(mesh_object, line["picks"])
        options = {name: line[name] for name in OPTION_NAMES}
        if flags is not None:
            options["pinned"] = self._choose_flags(flags, line)
        self._compute_and_keep(mesh_object, line["name"], picks, options)

    @staticmethod
    def _choose_flags(flags: list[bool], line: dict[str, Any]) -> list[bool]:
        """One a pick; the ends of an open line are pinned always, and "all" cannot be taken back by leaving it out."""
        chosen = [flag or line["pinned"] == "all" for flag in flags]
        if not line["closed"]:
            chosen[0] = chosen[-1] = True
        return chosen

    def _compute_and_keep(self, mesh_object: bpy.types.Object, name: str, picks: list[Any], options: dict) -> None:
        computed = self._session.compute_polyline(
            bpy.context,
            mesh_object,
            picks,
            source=self._source,
            with_normals=self._curves().get("offset", 0.0) != 0.0,
            **options,
        )
        self._keep(mesh_object, name, computed, options)

    def _make_along(self, mesh_object: bpy.types.Object, line: dict[str, Any]) -> None:
        strokes = find_strokes.find_strokes(line["along"])
        options = {name: line[name] for name in OPTION_NAMES}
        opened = self._open(mesh_object)
        finder = PickFinder(
            self._library, self._mesh_read, mesh_object, self._source, opened, self.job["search_radius"]
        )
        radius = finder.choose_radius(line["along"].get("radius"))
        for number, (points, is_closed) in enumerate(strokes):
            name = line["name"] if len(strokes) == 1 else f"{line['name']}.{number}"
            self._try(
                mesh_object,
                name,
                lambda points=points, is_closed=is_closed, name=name: self._make_stroke(
                    mesh_object, name, opened, points, {**options, "closed": is_closed or options["closed"]}, radius
                ),
            )

    def _make_stroke(
        self, mesh_object: bpy.types.Object, name: str, opened: Any, points: np.ndarray, options: dict, radius: float
    ) -> None:
        distances = opened.library_mesh.closest_points(points).distances
        farthest = int(np.argmax(distances))
        if distances[farthest] > radius:
            raise FileFault(
                "GuideError",
                f"point {farthest} of the guide is {distances[farthest]:.6g} away from the surface, more than the "
                f"search radius {radius:.6g}",
            )
        wishes = self._in_world_units(options, opened)
        line = opened.library_mesh.stroke(points, **wishes)
        picks = []
        if "curves" in self.job["make"]:
            # What the curve is made from again when it is edited: no guide, but picks as of a stroke of the draw tool.
            picks = self._line_picks.choose_picks(opened, line, **wishes)
        computed = self._session.ComputedPolyline(line, picks, opened.arrays)
        self._keep(mesh_object, name, computed, options, pinned="all")

    def _make_net(self, mesh_object: bpy.types.Object, net: dict[str, Any]) -> None:
        picks, _ = self._find_picks(mesh_object, net["picks"])
        options = {name: net[name] for name in OPTION_NAMES}
        opened = self._open(mesh_object)
        connections = net["connections"]
        if not isinstance(connections, str):
            connections = np.array(connections, dtype=np.int64)
        wishes = self._in_world_units(options, opened)
        made = opened.library_mesh.network(picks, connections, avoid_crossings=net["avoid_crossings"], **wishes)
        names: dict[str, int] = {}
        for ends, line, error in zip(made.connections.tolist(), made.lines, made.errors, strict=True):
            name = f"{net['name']}[{ends[0]}-{ends[1]}]"
            # A diagonal of a patch may join two picks a second time.
            names[name] = names.get(name, 0) + 1
            if names[name] > 1:
                name += f".{names[name]}"
            if error is not None:
                self._fail(mesh_object, name, type(error).__name__, str(error))
                continue
            own = [picks[end] for end in ends]
            remembered = {}
            if "curves" in self.job["make"] and not self._is_made_by(opened, own, line, wishes):
                # Led round others: its two picks alone would give another line.
                own, remembered = self._line_picks.choose_picks(opened, line, **wishes), {"pinned": "all"}
            computed = self._session.ComputedPolyline(line, own, opened.arrays)
            self._keep(mesh_object, name, computed, options, **remembered)
        self._tell_patches(mesh_object, net["name"], made)

    def _is_made_by(self, opened: Any, picks: list[Any], line: Any, wishes: dict[str, Any]) -> bool:
        """Whether a line of a net is the one that its picks alone give."""
        return opened.library_mesh.polyline(picks, **wishes).to_bytes() == line.to_bytes()

    def _tell_patches(self, mesh_object: bpy.types.Object, name: str, made: Any) -> None:
        """An entry on the net as a whole: into what it parts the surface."""
        told = {"crossings": len(made.crossings)}
        if all(error is None for error in made.errors):
            try:
                patches = made.patches()
                told |= {"patches": len(patches), "three_sided": patches.three_sided, "four_sided": patches.four_sided}
            except self._library.Error as error:
                self._fail(mesh_object, name, type(error).__name__, str(error))
                return
        told |= {"file": self._item_name, "object": mesh_object.name, "line": None, "net": name, "status": "done"}
        self.entries.append(told)

    def _in_world_units(self, options: dict[str, Any], opened: Any) -> dict[str, Any]:
        """Options for the library, whose mesh is in world space; the job's detail size is in the object's units."""
        wishes = dict(options)
        if wishes["detail_size"] is not None:
            wishes["detail_size"] *= self._mesh_read.measure_mean_scale(opened.arrays.world_matrix)
        return wishes

    def _keep(
        self, mesh_object: bpy.types.Object, name: str, computed: Any, options: dict[str, Any], **remembered: Any
    ) -> None:
        """Make the curve object where the job wants one, and the entry.

        remembered : options that the curve is made by again where they are others than those of the line
        """
        curve_object = None
        if "curves" in self.job["make"]:
            wishes = {**self._curves(), **options, **remembered}
            added = self._session.add_computed_polyline(
                bpy.context, mesh_object, computed, name=name, source=self._source, **wishes
            )
            curve_object = added.curve_object
        self.made.append(MadeLine(name, mesh_object, computed, curve_object, options))
        line = computed.line
        self.entries.append(
            {
                "file": self._item_name,
                "object": mesh_object.name,
                "line": name,
                "status": "done",
                "filter": options["filter"],
                "closed": line.closed,
                "points": len(line.points),
                "length": line.length,
                "iterations": line.report.iterations,
                "stop_reason": line.report.stop_reason,
            }
        )
