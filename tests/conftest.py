"""What every Python test shares: the head of the run says what it runs on, and what it must leave out.

Holds no fixtures that need Blender (tests/addon has them).
"""

from importlib import metadata

import numpy as np

import meshes


def pytest_report_header() -> list[str]:
    folder = meshes.find_mesh_folder()
    state = "found" if folder.is_dir() else "NOT FOUND: tests that need its meshes are skipped"
    try:
        library = f"smooth_polylines {metadata.version('smooth-polylines')}"
    except metadata.PackageNotFoundError:
        library = "smooth_polylines not installed here (the extension brings its own)"
    return [
        f"{library}, numpy {np.__version__}",
        f"test meshes: {folder} ({state})",
    ]
