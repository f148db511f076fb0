"""How the figures look: one panel is a surface with coloured triangles, mesh edges, lines and marks, from one camera.

Run by `figures`, inside Blender; rendered by Workbench, which needs neither a window nor light. Chooses no picks.
"""

import tempfile
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

import bpy

from mathutils import Matrix, Vector

from demo_render import silence_blender

SURFACE = (0.90, 0.91, 0.93)
STRIP = (0.98, 0.80, 0.35)
EDGES = (0.30, 0.32, 0.36)
LINE = (0.80, 0.04, 0.07)
START = (0.05, 0.20, 0.70)
PICK = (0.10, 0.55, 0.15)
# The patches of a net, far apart in hue.
PATCHES = [
    (0.90, 0.45, 0.42), (0.98, 0.76, 0.42), (0.96, 0.93, 0.55), (0.62, 0.84, 0.52), (0.45, 0.78, 0.75),
    (0.48, 0.66, 0.90), (0.68, 0.58, 0.88), (0.92, 0.66, 0.84), (0.75, 0.62, 0.48), (0.66, 0.70, 0.30),
]  # fmt: skip


@dataclass
class View:
    """Where the camera is: it looks along `-direction` at `centre`, `width` units across, `up` upwards."""

    direction: tuple[float, float, float]
    centre: np.ndarray
    width: float
    up: tuple[float, float, float] = (0.0, 1.0, 0.0)

    def of_points(self, points: np.ndarray, margin: float = 1.25, aspect: float = 4 / 3) -> "View":
        """The same direction, just wide enough for the points."""
        right, above, _ = self.axes()
        p = np.asarray(points, float)
        spans = [np.ptp(p @ right), np.ptp(p @ above) * aspect]
        middle = (p.max(axis=0) + p.min(axis=0)) / 2
        return View(self.direction, middle, max(spans) * margin, self.up)

    def axes(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Rightwards, upwards, and towards the camera."""
        back = np.asarray(self.direction, float) / np.linalg.norm(self.direction)
        right = np.cross(self.up, back)
        right /= np.linalg.norm(right)
        return right, np.cross(back, right), back


@dataclass
class Panel:
    """What one picture shows. Lines: (points, closed, colour, radius as a share of the view); balls likewise."""

    positions: np.ndarray
    triangles: np.ndarray
    coloured: list[tuple[tuple[float, float, float], np.ndarray]] = field(default_factory=list)
    lines: list[tuple[np.ndarray, bool, tuple[float, float, float], float]] = field(default_factory=list)
    balls: list[tuple[np.ndarray, tuple[float, float, float], float]] = field(default_factory=list)
    with_edges: bool = False


def material(colour: tuple[float, float, float]) -> bpy.types.Material:
    """A plain colour."""
    made = bpy.data.materials.new("Colour")
    made.diffuse_color = (*colour, 1.0)
    made.roughness = 0.8
    return made


def add_object(name: str, data: bpy.types.ID) -> bpy.types.Object:
    """An object of this data in the scene."""
    made = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(made)
    return made


def add_surface(panel: Panel) -> None:
    """The mesh, each triangle in its colour."""
    mesh = bpy.data.meshes.new("Surface")
    mesh.from_pydata(panel.positions.tolist(), [], panel.triangles.tolist())
    mesh.materials.append(material(SURFACE))
    index = np.zeros(len(panel.triangles), np.int32)
    for colour, triangles in panel.coloured:
        mesh.materials.append(material(colour))
        index[np.asarray(triangles, int)] = len(mesh.materials) - 1
    mesh.polygons.foreach_set("material_index", index)
    mesh.polygons.foreach_set("use_smooth", np.full(len(index), not panel.with_edges))
    mesh.update()
    add_object("Surface", mesh)


def add_edges(panel: Panel, view: View) -> None:
    """Fine tubes along the mesh's edges, those in the view alone."""
    right, above, _ = view.axes()
    offset = panel.positions - view.centre
    is_near = (np.abs(offset @ right) < 0.6 * view.width) & (np.abs(offset @ above) < 0.5 * view.width)
    sides = panel.triangles[is_near[panel.triangles].all(axis=1)][:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    edges = np.unique(np.sort(sides, axis=1), axis=0)
    curve = bpy.data.curves.new("Edges", "CURVE")
    curve.dimensions, curve.bevel_depth, curve.bevel_resolution = "3D", 0.0007 * view.width, 0
    curve.materials.append(material(EDGES))
    for a, b in panel.positions[edges]:
        spline = curve.splines.new("POLY")
        spline.points.add(1)
        spline.points.foreach_set("co", [*a, 1.0, *b, 1.0])
    add_object("Edges", curve)


def add_line(points: np.ndarray, closed: bool, colour: tuple[float, float, float], radius: float) -> None:
    """A tube along the points."""
    curve = bpy.data.curves.new("Line", "CURVE")
    curve.dimensions, curve.bevel_depth, curve.bevel_resolution = "3D", radius, 3
    curve.materials.append(material(colour))
    spline = curve.splines.new("POLY")
    spline.points.add(len(points) - 1)
    spline.points.foreach_set("co", np.column_stack([points, np.ones(len(points))]).ravel())
    spline.use_cyclic_u = closed
    add_object("Line", curve)


def add_ball(place: np.ndarray, colour: tuple[float, float, float], radius: float) -> None:
    """A small ball."""
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=3, radius=radius, location=tuple(place))
    ball = bpy.context.object
    bpy.ops.object.shade_smooth()
    ball.data.materials.append(material(colour))


def set_camera(view: View, depth: float) -> None:
    """An orthographic camera, so that lengths can be compared between panels."""
    right, above, back = view.axes()
    camera = add_object("Camera", bpy.data.cameras.new("Camera"))
    camera.data.type, camera.data.ortho_scale = "ORTHO", view.width
    camera.data.clip_start, camera.data.clip_end = 0.001 * depth, 10 * depth
    rotation = Matrix([right, above, back]).transposed().to_4x4()
    place = Vector(np.asarray(view.centre, float) + 4 * depth * back)
    camera.matrix_world = Matrix.Translation(place) @ rotation
    bpy.context.scene.camera = camera


def render(panel: Panel, view: View, path: Path, width: int, height: int) -> None:
    """Draw one panel into a PNG."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    depth = float(np.linalg.norm(np.ptp(panel.positions, axis=0)))
    add_surface(panel)
    if panel.with_edges:
        add_edges(panel, view)
    for points, closed, colour, radius in panel.lines:
        add_line(np.asarray(points), closed, colour, radius * view.width)
    for place, colour, radius in panel.balls:
        add_ball(np.asarray(place), colour, radius * view.width)
    set_camera(view, depth)
    scene = bpy.context.scene
    scene.render.engine = "BLENDER_WORKBENCH"
    scene.display.render_aa = "8"
    shading = scene.display.shading
    shading.light, shading.color_type = "STUDIO", "MATERIAL"
    shading.show_cavity = False
    shading.show_specular_highlight = False
    scene.world = bpy.data.worlds.new("World")
    scene.world.color = (1, 1, 1)
    shading.background_type, shading.background_color = "VIEWPORT", (1, 1, 1)
    scene.view_settings.view_transform = "Standard"
    scene.render.film_transparent = False
    scene.render.resolution_x, scene.render.resolution_y = width, height
    scene.render.image_settings.file_format = "PNG"
    scene.render.image_settings.color_mode = "RGB"
    scene.render.image_settings.compression = 90
    scene.render.dither_intensity = 0.0
    scene.render.filepath = str(path)
    with silence_blender():
        bpy.ops.render.render(write_still=True)


def draw(panels: list[Panel], view: View, path: Path, width: int = 520, height: int = 400, columns: int = 2) -> None:
    """All panels from the same camera, in rows, as one PNG."""
    with tempfile.TemporaryDirectory() as folder:
        pictures = []
        for i, panel in enumerate(panels):
            part = Path(folder, f"{i}.png")
            render(panel, view, part, width, height)
            pictures.append(read_pixels(part))
        rows = [np.hstack(pictures[i : i + columns]) for i in range(0, len(pictures), columns)]
        widest = max(row.shape[1] for row in rows)
        white = [np.ones((row.shape[0], widest - row.shape[1], 4), np.float32) for row in rows]
        whole = np.vstack([np.hstack([row, rest]) for row, rest in zip(rows, white, strict=True)][::-1])
        write_pixels(whole, path)


def read_pixels(path: Path) -> np.ndarray:
    """Rows from the bottom, (height, width, 4)."""
    image = bpy.data.images.load(str(path))
    width, height = image.size
    pixels = np.empty(width * height * 4, np.float32)
    image.pixels.foreach_get(pixels)
    bpy.data.images.remove(image)
    return pixels.reshape(height, width, 4)


def write_pixels(pixels: np.ndarray, path: Path) -> None:
    """As a PNG."""
    height, width, _ = pixels.shape
    image = bpy.data.images.new("Whole", width, height)
    image.pixels.foreach_set(np.ascontiguousarray(pixels).ravel())
    image.file_format = "PNG"
    bpy.context.scene.render.image_settings.color_mode = "RGB"
    image.filepath_raw = str(path.resolve())
    image.save()
