"""The mesh of the demo and the faces to pick on it. Run by `demo`, inside Blender; draws and writes nothing."""

from pathlib import Path

import numpy as np

import bpy

from mathutils import Matrix

RING_PICK_COUNT = 24
TOUR_PICK_COUNT = 10
# Hits further out than this many times the middle one are on an arm or a leg that the ring is not about.
RING_OUTLIER = 1.5
# How far the ring leans over: a part of the shortest axis added to the longest.
RING_TILT = 0.45

# Places on Suzanne near which faces are picked, in order: from an ear under the eye, between the eyes, over the
# other brow and across the forehead.
SUZANNE_PLACES = [
    (-1.15, 0.3, 0.25),
    (-0.65, -0.4, -0.05),
    (-0.25, -0.7, -0.1),
    (0.05, -0.77, 0.3),
    (0.35, -0.75, 0.65),
    (0.35, -0.35, 0.88),
    (0.28, 0.0, 0.95),
]
# From her towards the viewer.
SUZANNE_VIEW = (-0.4, -1.0, 0.32)
SUZANNE_SUBDIVISIONS = 2


class MeshFileError(Exception):
    """Why a file gives no mesh to draw on."""


def add_suzanne() -> bpy.types.Object:
    """Suzanne, her eyes taken out (separate parts), subdivided so that a line has something to follow."""
    bpy.ops.mesh.primitive_monkey_add()
    mesh_object = bpy.context.object
    subdivision = mesh_object.modifiers.new("Subdivision", "SUBSURF")
    subdivision.levels = SUZANNE_SUBDIVISIONS
    bpy.ops.object.modifier_apply(modifier=subdivision.name)
    return mesh_object


def choose_suzanne_picks(mesh_object: bpy.types.Object) -> list[int]:
    """The faces of her head nearest to SUZANNE_PLACES."""
    centres, faces = read_main_part(mesh_object)
    nearest = [np.linalg.norm(centres[faces] - place, axis=1).argmin() for place in SUZANNE_PLACES]
    return faces[nearest].tolist()


def load_mesh(path: Path) -> bpy.types.Object:
    """Read an .obj, .ply, .stl (by Blender's importers) or .off file; the active object."""
    if not path.is_file():
        raise MeshFileError(f"there is no file {path}")
    suffix = path.suffix.lower()
    if suffix == ".off":
        mesh_object = load_off(path)
    elif suffix in {".obj", ".ply", ".stl"}:
        importer = getattr(bpy.ops.wm, f"{suffix[1:]}_import")
        # Scans and models stand along Y, as in OBJ; what is printed stands along Z.
        options = {} if suffix == ".stl" else {"up_axis": "Y", "forward_axis": "NEGATIVE_Z"}
        importer(filepath=str(path.resolve()), **options)
        meshes = [o for o in bpy.data.objects if o.type == "MESH"]
        if not meshes:
            raise MeshFileError(f"Blender found no mesh in {path}")
        mesh_object = max(meshes, key=lambda o: len(o.data.polygons))
    else:
        raise MeshFileError(f"{path.name}: the demo reads .obj, .ply, .stl and .off files")
    if len(mesh_object.data.polygons) < TOUR_PICK_COUNT:
        raise MeshFileError(f"{path.name} has too few faces to pick {TOUR_PICK_COUNT} of them")
    mesh_object.name = path.stem
    return mesh_object


def load_off(path: Path) -> bpy.types.Object:
    """Read an OFF file, which Blender has no importer for."""
    lines = (line.split("#")[0].split() for line in path.read_text(encoding="utf-8").splitlines())
    rows = iter([words for words in lines if words])
    try:
        header = next(rows)
        if header[0] != "OFF":
            raise MeshFileError(f"{path.name} does not begin with OFF")
        vertex_count, face_count = map(int, (header[1:] or next(rows))[:2])
        positions = [tuple(map(float, next(rows)[:3])) for _ in range(vertex_count)]
        polygons = [tuple(map(int, row[1 : 1 + int(row[0])])) for row in (next(rows) for _ in range(face_count))]
    except (ValueError, StopIteration, RuntimeError) as error:
        raise MeshFileError(f"{path.name} is not a whole OFF file ({error})") from error
    mesh = bpy.data.meshes.new(path.stem)
    mesh.from_pydata(positions, [], polygons)
    mesh_object = bpy.data.objects.new(path.stem, mesh)
    mesh_object.matrix_world = Matrix.Rotation(np.pi / 2, 4, "X")
    bpy.context.scene.collection.objects.link(mesh_object)
    return mesh_object


def measure_diagonal(mesh_object: bpy.types.Object) -> float:
    """Diagonal of the bounding box, in the object's units."""
    return float(np.linalg.norm(np.ptp(np.array(mesh_object.bound_box), axis=0)))


def read_main_part(mesh_object: bpy.types.Object) -> tuple[np.ndarray, np.ndarray]:
    """Centres of all faces (F, 3), and the ids of the faces of the largest connected part."""
    mesh = mesh_object.data
    centres = np.empty(len(mesh.polygons) * 3, dtype=np.float32)
    mesh.polygons.foreach_get("center", centres)
    faces_of_corners = np.repeat(np.arange(len(mesh.polygons)), read_ints(mesh.polygons, "loop_total"))
    edges_of_corners = read_ints(mesh.loops, "edge_index")
    order = np.argsort(edges_of_corners, kind="stable")
    edges, faces = edges_of_corners[order], faces_of_corners[order]
    # A line crosses only edges between exactly two faces.
    corner_counts = np.bincount(edges)
    first = np.flatnonzero(np.diff(edges, prepend=-1))
    first = first[corner_counts[edges[first]] == 2]
    labels = label_parts(len(mesh.polygons), faces[first], faces[first + 1])
    return centres.reshape(-1, 3).astype(np.float64), np.flatnonzero(labels == np.bincount(labels).argmax())


def read_ints(rows: bpy.types.bpy_prop_collection, name: str) -> np.ndarray:
    """An integer property of all rows."""
    values = np.empty(len(rows), dtype=np.int32)
    rows.foreach_get(name, values)
    return values


def label_parts(count: int, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """One number a node, equal where the links between `a` and `b` connect: the least node of the part."""
    labels = np.arange(count)
    while True:
        least = np.minimum(labels[a], labels[b])
        previous = labels.copy()
        np.minimum.at(labels, labels[a], least)
        np.minimum.at(labels, labels[b], least)
        labels = labels[labels]
        if np.array_equal(labels, previous):
            return labels


def choose_picks(mesh_object: bpy.types.Object) -> list[int]:
    """Faces for a closed line on any mesh: a ring round a body, a round tour where there is no round to go."""
    centres, faces = read_main_part(mesh_object)
    ring = choose_ring(mesh_object, centres, faces) if is_closed(mesh_object, faces) else []
    return ring if len(ring) > RING_PICK_COUNT // 2 else choose_tour(centres, faces)


def is_closed(mesh_object: bpy.types.Object, faces: np.ndarray) -> bool:
    """Whether hardly any edge of these faces is an edge of the surface: a sheet has no round to go."""
    mesh = mesh_object.data
    face_counts = np.bincount(read_ints(mesh.loops, "edge_index"), minlength=len(mesh.edges))
    return (face_counts == 1).sum() < 0.002 * len(faces)


def choose_ring(mesh_object: bpy.types.Object, centres: np.ndarray, faces: np.ndarray) -> list[int]:
    """Faces that rays hit which come from all around, towards the middle, in a plane across the longest axis."""
    middle = centres[faces].mean(axis=0)
    # Rows: the axes of the part, the longest first.
    axes = np.linalg.svd(centres[faces] - middle, full_matrices=False)[2]
    side, normal = axes[1], axes[0] + RING_TILT * axes[2]
    across = np.cross(normal / np.linalg.norm(normal), side)
    reach = np.linalg.norm(centres[faces] - middle, axis=1).max() * 2
    is_main = np.zeros(len(centres), dtype=bool)
    is_main[faces] = True
    ring: list[int] = []
    for angle in np.arange(RING_PICK_COUNT) * 2 * np.pi / RING_PICK_COUNT:
        outwards = np.cos(angle) * side + np.sin(angle) * across
        is_hit, _, _, face = mesh_object.ray_cast(middle + reach * outwards, -outwards)
        if is_hit and is_main[face] and face not in ring:
            ring.append(face)
    radii = np.linalg.norm(centres[ring] - middle, axis=1)
    return [face for face, radius in zip(ring, radii, strict=True) if radius < RING_OUTLIER * np.median(radii)]


def choose_tour(centres: np.ndarray, faces: np.ndarray) -> list[int]:
    """Faces spread over the part, each as far as can be from those before, in the order of a short round."""
    points = centres[faces]
    middle = points.mean(axis=0)
    picked = [int(np.linalg.norm(points - middle, axis=1).argmax())]
    distances = np.full(len(points), np.inf)
    while len(picked) < TOUR_PICK_COUNT:
        distances = np.minimum(distances, np.linalg.norm(points - points[picked[-1]], axis=1))
        picked.append(int(distances.argmax()))
    tour = shorten_tour(points[picked])
    return faces[[picked[i] for i in tour]].tolist()


def shorten_tour(points: np.ndarray) -> list[int]:
    """An order of the points whose closed round no reversal of a stretch makes shorter."""
    lengths = np.linalg.norm(points[:, None] - points[None], axis=2)
    tour = list(range(len(points)))

    def measure(order: list[int]) -> float:
        return sum(lengths[order[i - 1], order[i]] for i in range(len(order)))

    is_shorter = True
    while is_shorter:
        is_shorter = False
        for i in range(1, len(tour) - 1):
            for j in range(i + 1, len(tour)):
                reversed_stretch = tour[:i] + tour[i : j + 1][::-1] + tour[j + 1 :]
                if measure(reversed_stretch) < measure(tour) - 1e-12:
                    tour, is_shorter = reversed_stretch, True
    return tour
