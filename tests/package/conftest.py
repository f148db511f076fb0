"""What the tests of the package share: the zip that is shipped, and an environment without our library."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

REPOSITORY = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="session")
def packages_without_ours(tmp_path_factory):
    """A folder with all that is installed beside bpy, less our library: there is only what the zip brings."""
    folder = tmp_path_factory.mktemp("packages")
    for path in Path(np.__file__).parents[1].iterdir():
        if not path.name.startswith(("smooth_polylines", "__pycache__")):
            (folder / path.name).symlink_to(path)
    return folder


@pytest.fixture(scope="session")
def shipped_zip():
    """The extension that `make extension` has left for this platform."""
    found = sorted((REPOSITORY / "dist").glob("smooth_polylines-*.zip"))
    assert len(found) == 1, f"dist holds {len(found)} zips of the extension; run make extension"
    return found[0]


@pytest.fixture(scope="session")
def run_without_ours(packages_without_ours):
    """Runs Python, with bpy but without our library."""

    def run(*arguments, **environment):
        return subprocess.run(
            [sys.executable, "-S", *map(str, arguments)],
            capture_output=True,
            text=True,
            timeout=300,
            env={**os.environ, "PYTHONPATH": str(packages_without_ours), **environment},
        )

    return run
