"""Saves the file that Blender has open as a .blend whose bytes depend on nothing but what is in it."""

from pathlib import Path

import bpy

from batching import stable_blend
from batching.blend_layout import UnknownLayoutError

from .fault import FileFault
from .open_input import clean


def write_blend(path: Path, *, is_imported: bool) -> None:
    """Save a copy; FileFault when Blender cannot.

    is_imported : the meshes were made by an importer in this run, and not read from a .blend file
    """
    try:
        # A copy: the open file keeps its own name, which is written into the file.
        bpy.ops.wm.save_as_mainfile(filepath=str(path), copy=True, compress=False, relative_remap=True)
    except RuntimeError as error:
        raise FileFault("OutputError", f"Blender cannot save the .blend file: {clean(error)}") from error
    try:
        stable_blend.stabilise_blend(path, is_imported=is_imported)
    except UnknownLayoutError as error:
        # As Blender wrote it: right, but other bytes at each run.
        print(f"{path}: bytes are not repeatable: {error}", flush=True)
