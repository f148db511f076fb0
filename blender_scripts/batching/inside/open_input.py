"""Opens one input file in Blender, into an otherwise empty scene, as Blender's own importers do it."""

import os
from collections.abc import Callable
from typing import Any

import bpy

import addon_utils

from .fault import FileFault

AXES = {"x": "X", "y": "Y", "z": "Z", "-x": "NEGATIVE_X", "-y": "NEGATIVE_Y", "-z": "NEGATIVE_Z"}


def empty_blender() -> None:
    """Throw away everything of the file before."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)


def open_input(path: str, settings: dict[str, Any]) -> None:
    """Open the .blend file, or import the mesh file; FileFault when Blender cannot.

    settings : "scale", "forward" and "up" of the job's "import", for .obj, .ply and .stl
    """
    suffix = os.path.splitext(path)[1].lower()
    # Also before a .blend file: it is opened without its windows, and those that are there are saved with the result.
    empty_blender()
    if suffix == ".blend":
        open_blend(path)
    else:
        run_importer(path, suffix, settings)


def open_blend(path: str) -> None:
    """Open without its user interface and without running scripts that lie in it."""
    try:
        bpy.ops.wm.open_mainfile(filepath=path, load_ui=False, use_scripts=False)
    except RuntimeError as error:
        text = clean(error)
        if "newer" in text.lower():
            raise FileFault("NewerBlenderError", f"Blender {bpy.app.version_string} says: {text}") from error
        raise FileFault("ImportFailedError", f"Blender says: {text}") from error
    saved, here = tuple(bpy.data.version), bpy.app.version
    if saved[:2] > here[:2]:
        # Blender opens it, but drops what it does not know: the copy would lose data without a word.
        raise FileFault(
            "NewerBlenderError",
            f"was saved by Blender {saved[0]}.{saved[1]}, but this is Blender {here[0]}.{here[1]}, which loses data",
        )


def run_importer(path: str, suffix: str, settings: dict[str, Any]) -> None:
    """Run Blender's importer for the suffix."""
    importer, options = choose_importer(suffix, settings)
    try:
        result = importer(filepath=path, **options)
    except RuntimeError as error:
        raise FileFault("ImportFailedError", f"Blender's importer says: {clean(error)}") from error
    except Exception as error:  # importers written in Python let their own errors through
        raise FileFault(
            "ImportFailedError", f"Blender's importer failed with {type(error).__name__}: {error}"
        ) from error
    if "FINISHED" not in result:
        raise FileFault("ImportFailedError", "Blender's importer gave up on it; its messages are in the log")


def choose_importer(suffix: str, settings: dict[str, Any]) -> tuple[Callable[..., set[str]], dict[str, Any]]:
    """The operator that this Blender has for the suffix, and its options."""
    axes = {}
    if "up" in settings:
        axes = {"forward_axis": AXES[settings["forward"]], "up_axis": AXES[settings["up"]]}
    scale = {"global_scale": settings["scale"]} if "scale" in settings else {}
    if suffix == ".obj":
        return bpy.ops.wm.obj_import, {**axes, **scale}
    if suffix == ".ply":
        return bpy.ops.wm.ply_import, {**axes, **scale}
    if suffix == ".stl":
        return bpy.ops.wm.stl_import, {**axes, **scale}
    if suffix.startswith(".usd"):
        return bpy.ops.wm.usd_import, {}
    if suffix in (".gltf", ".glb"):
        enable("io_scene_gltf2")
        return bpy.ops.import_scene.gltf, {}
    if hasattr(bpy.types, "WM_OT_fbx_import"):
        return bpy.ops.wm.fbx_import, {}
    enable("io_scene_fbx")
    return bpy.ops.import_scene.fbx, {}


def enable(name: str) -> None:
    """One of the importers that come with Blender as add-ons, which a user may have turned off."""
    if addon_utils.enable(name, default_set=False) is None:
        raise FileFault("ImportFailedError", f"this Blender has no importer {name} for it")


def clean(error: Exception) -> str:
    """Blender's message in one line."""
    lines = [line.removeprefix("Error:").strip() for line in str(error).splitlines()]
    return " ".join(line for line in lines if line) or type(error).__name__
