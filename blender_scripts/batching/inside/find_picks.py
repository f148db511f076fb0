"""Picks of a job on an opened mesh: faces, points in space, vertex groups and attribute values, found on the surface.

Reads only; what it gives are picks as the library takes them.
"""

from typing import Any

import numpy as np

import bpy

from .fault import FileFault

# Where a job gives no search radius: a part of the mesh's bounding-box diagonal.
DEFAULT_RADIUS_PART = 0.05
MOST_NAMES = 8


class PickFinder:
    """Finds picks on one mesh object, whose faces have been opened as `surface` in world space."""

    def __init__(
        self,
        library: Any,
        mesh_read: Any,
        mesh_object: bpy.types.Object,
        source: str,
        surface: Any,
        radius: float | None,
    ) -> None:
        self._library = library
        self._mesh_read = mesh_read
        self._object = mesh_object
        self._source = source
        self._surface = surface
        self._radius = radius

    def choose_radius(self, wish: float | None) -> float:
        """The search radius in world units: the pick's own, the job's, or one by the size of the mesh."""
        if wish is not None or self._radius is not None:
            return self._radius if wish is None else wish
        positions = self._surface.arrays.world_positions[np.unique(self._surface.arrays.triangles)]
        return DEFAULT_RADIUS_PART * float(np.linalg.norm(np.ptp(positions, axis=0)))

    def find_all(self, picks: list[Any]) -> tuple[list[Any], list[bool] | None]:
        """The picks as the library takes them, and which are pinned; None when no pick says so itself."""
        found = [self._find(index, pick) for index, pick in enumerate(picks)]
        flags = [isinstance(pick, dict) and pick.get("pinned", False) for pick in picks]
        says = any(isinstance(pick, dict) and "pinned" in pick for pick in picks)
        return found, flags if says else None

    def _find(self, index: int, pick: Any) -> Any:
        try:
            if not isinstance(pick, dict):
                return int(pick)
            if "face" in pick:
                return int(pick["face"])
            if "point" in pick:
                return self._find_point(pick)
            if "vertex_group" in pick:
                return self._find_vertex_group(pick["vertex_group"])
            return self._find_attribute(pick["attribute"], pick["value"])
        except FileFault as fault:
            raise FileFault(fault.error, f"pick {index}: {fault}") from fault

    def _find_point(self, pick: dict[str, Any]) -> Any:
        place = np.array(pick["point"], dtype=np.float64)
        if pick.get("space", "world") == "object":
            matrix = self._surface.arrays.world_matrix
            place = matrix[:3, :3] @ place + matrix[:3, 3]
        nearest = self._surface.library_mesh.closest_points(place[None])
        radius = self.choose_radius(pick.get("radius"))
        if nearest.distances[0] > radius:
            raise FileFault(
                "PickError",
                f"the surface is {nearest.distances[0]:.6g} away from the point, more than the search radius "
                f"{radius:.6g}",
            )
        return nearest.surface_points[0]

    def _find_vertex_group(self, name: str) -> Any:
        group = self._object.vertex_groups.get(name)
        if group is None:
            there = ", ".join(g.name for g in list(self._object.vertex_groups)[:MOST_NAMES]) or "none"
            raise FileFault("PickError", f"there is no vertex group {name} (there are: {there})")
        weights = np.zeros(len(self._surface.arrays.world_positions))
        with self._mesh_read.open_current_mesh(self._object, self._source) as mesh:
            for vertex in mesh.vertices:
                for member in vertex.groups:
                    if member.group == group.index:
                        weights[vertex.index] = member.weight
        if not (weights > 0).any():
            raise FileFault("PickError", f"no vertex has a weight in the vertex group {name}")
        return self._find_middle(weights, f"the vertex group {name}")

    def _find_attribute(self, name: str, value: float | bool) -> Any:
        arrays = self._surface.arrays
        with self._mesh_read.open_current_mesh(self._object, self._source) as mesh:
            attribute = mesh.attributes.get(name)
            if attribute is None:
                there = ", ".join(a.name for a in list(mesh.attributes)[:MOST_NAMES]) or "none"
                raise FileFault("PickError", f"there is no attribute {name} (there are: {there})")
            if attribute.domain not in ("POINT", "FACE") or attribute.data_type not in DTYPES:
                raise FileFault(
                    "PickError",
                    f"the attribute {name} is of the kind {attribute.data_type} on {attribute.domain}; use numbers or "
                    "true and false, on vertices or faces",
                )
            values = np.empty(len(attribute.data), dtype=DTYPES[attribute.data_type])
            attribute.data.foreach_get("value", values)
            is_on_faces = attribute.domain == "FACE"
        is_meant = np.isclose(values, value, rtol=1e-6, atol=0.0) if values.dtype == np.float32 else values == value
        if not is_meant.any():
            raise FileFault("PickError", f"the attribute {name} has the value {value} nowhere")
        what = f"the attribute {name} = {value}"
        if is_on_faces:
            return self._find_middle_of_triangles(is_meant[arrays.triangle_faces], None, what)
        return self._find_middle(is_meant.astype(np.float64), what)

    def _find_middle(self, weights: np.ndarray, what: str) -> Any:
        """The point of the whole faces of a set of vertices that is nearest to the set's weighted centre."""
        arrays = self._surface.arrays
        centre = (weights[:, None] * arrays.world_positions).sum(axis=0) / weights.sum()
        is_whole = (weights > 0)[arrays.triangles].all(axis=1)
        if not is_whole.any():
            # Scattered vertices: the triangles round them, at the vertices.
            members = np.flatnonzero(weights > 0)
            distances = np.linalg.norm(arrays.world_positions[members] - centre, axis=1)
            vertex = members[int(np.argmin(distances))]
            rows = np.flatnonzero((arrays.triangles == vertex).any(axis=1))
            if len(rows) == 0:
                raise FileFault("PickError", f"{what} lies on no visible face")
            corner = int(np.flatnonzero(arrays.triangles[rows[0]] == vertex)[0])
            return self._library.SurfacePoint(int(rows[0]), np.eye(3)[corner])
        return self._find_middle_of_triangles(is_whole, centre, what)

    def _find_middle_of_triangles(self, is_meant: np.ndarray, centre: np.ndarray | None, what: str) -> Any:
        """The point of these triangles that is nearest to `centre`; None: to the centre of their area."""
        arrays = self._surface.arrays
        rows = np.flatnonzero(is_meant)
        if len(rows) == 0:
            raise FileFault("PickError", f"{what} lies on no visible face")
        corners = arrays.world_positions[arrays.triangles[rows]]
        if centre is None:
            areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
            areas = areas if areas.sum() > 0 else np.ones(len(areas))
            centre = (areas[:, None] * corners.mean(axis=1)).sum(axis=0) / areas.sum()
        part = self._library.SurfaceMesh(arrays.world_positions, arrays.triangles[rows])
        point = part.closest_points(centre[None]).surface_points[0]
        return self._library.SurfacePoint(int(rows[point.triangle]), point.barycentric)


DTYPES = {"INT": np.int32, "INT8": np.int8, "BOOLEAN": bool, "FLOAT": np.float32}
