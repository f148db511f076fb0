# SPDX-License-Identifier: GPL-3.0-or-later
"""Opens the mesh that the first click hits, without making Blender wait: reading it takes moments, and what takes
longer runs in a thread, with progress, and can be left at any time.

Draws nothing, and knows no sketch.
"""

import threading
import time
from typing import Any

import numpy as np

import bpy

from .. import native, session, surface
from ..errors import ObjectError

# Of a triangle: what making a mesh ready takes, until it has been measured here.
FIRST_SECONDS = 4e-7
# How long the first event waits for the thread: nobody notices, and small meshes are open at once.
PATIENCE = 0.03

_seconds_a_triangle = [FIRST_SECONDS]


class Opening:
    """Surfaces being opened one after another, until the one that the ray hits first is known.

    `chosen` is that object's name, or "" where the ray hits nothing; then the rest tells what was opened.
    """

    def __init__(
        self,
        candidates: list[tuple[float, bpy.types.Object]],
        ray: tuple[np.ndarray, np.ndarray] | None,
        source: str = "SEEN",
    ) -> None:
        """Candidates : how far each begins, nearest first; ray : None: the first candidate is the one"""
        # Names, because undo and scripts may take the objects away meanwhile.
        self.waiting = [(distance, mesh_object.name) for distance, mesh_object in candidates]
        self.ray, self.wish = ray, source
        self.chosen, self.source, self.surface = "", "BASE", None
        self.distance = float("inf")
        self.told: Exception | None = None
        self.name, self.name_source = "", ""
        self.reading: surface.Reading | None = None
        self.thread: threading.Thread | None = None
        self.outcome: list[Any] = []
        self.started = 0.0
        self.begun, self.milliseconds = time.perf_counter(), 0.0  # how long it all took

    def go_on(self, context: bpy.types.Context, patience: float = PATIENCE) -> bool:
        """One step, of `patience` seconds at most but for reading a mesh; True when all is done.

        Raises the refusal of the object that was hit, or of the only ones that could have been.
        """
        until = time.perf_counter() + patience
        while True:
            if self.thread is None:
                if not self.waiting or self.waiting[0][0] > self.distance or (self.ray is None and self.chosen):
                    break
                self.begin(context, self.waiting.pop(0)[1])
            if self.thread is not None:
                self.thread.join(max(until - time.perf_counter(), 0.0))
                if self.thread.is_alive():
                    return False
                self.finish()
        self.milliseconds = 1e3 * (time.perf_counter() - self.begun)
        if self.chosen:
            session.check_object(bpy.data.objects.get(self.chosen))
        elif self.told is not None:
            raise self.told
        return True

    def begin(self, context: bpy.types.Context, name: str) -> None:
        """Read an object, and start its thread where it is not at hand already."""
        mesh_object = bpy.data.objects.get(name)
        if mesh_object is None:
            return
        self.name, self.name_source = name, choose_source(context, mesh_object, self.wish)
        try:
            found = surface.find_or_read(context, mesh_object, source=self.name_source)
        except ObjectError as error:
            # Another one may be hit. If none is, this is what the artist must know.
            self.told = error
            return
        if isinstance(found, surface.Surface):
            self.take(found)
            return
        self.reading, self.outcome, self.started = found, [], time.perf_counter()
        outcome = self.outcome

        def work() -> None:
            try:
                outcome.append(surface.make_ready(found, with_tree=True))
            except BaseException as error:
                outcome.append(error)

        self.thread = threading.Thread(target=work, name="smooth polylines: opening", daemon=True)
        self.thread.start()

    def finish(self) -> None:
        """Take what the thread made."""
        reading, self.thread = self.reading, None
        (outcome,) = self.outcome
        if isinstance(outcome, BaseException):
            if not native.is_refusal(outcome):
                raise outcome
            self.told = outcome
            return
        count = max(len(reading.arrays.triangles), 1)
        _seconds_a_triangle[0] = max((time.perf_counter() - self.started) / count, 1e-8)
        self.take(surface.keep_surface(reading, outcome))

    def take(self, opened: surface.Surface) -> None:
        """Choose this one if the ray hits it before the others."""
        distance = 0.0
        if self.ray is not None:
            origin, direction = self.ray
            distance = float(opened.library_mesh.ray_cast(origin[None], direction[None]).distances[0])
        if distance < self.distance or self.ray is None:
            self.distance, self.chosen, self.source, self.surface = distance, self.name, self.name_source, opened

    def describe(self) -> str:
        """How far it is, for the header."""
        if self.reading is None:
            return "Opening"
        count = len(self.reading.arrays.triangles)
        return f"Opening {self.name}: {100 * self.measure_progress():.0f} % of {count:,} triangles. Esc leaves"

    def measure_progress(self) -> float:
        """From 0 to 1, by the time that it takes."""
        if self.reading is None:
            return 0.0
        expected = _seconds_a_triangle[0] * max(len(self.reading.arrays.triangles), 1)
        return min((time.perf_counter() - self.started) / expected, 0.99)


def choose_source(context: bpy.types.Context, mesh_object: bpy.types.Object, wish: str) -> str:
    """What to draw on: SEEN is the mesh after its modifiers and shape keys, where it has any and is not edited."""
    if wish != "SEEN":
        return wish
    has_shape = len(mesh_object.modifiers) > 0 or mesh_object.data.shape_keys is not None
    return "EVALUATED" if has_shape and context.mode == "OBJECT" else "BASE"
