"""Blender for the tests: the bpy module with a profile of its own, and the add-on enabled from its source folder.

The library is the wheel installed in the environment. One process is one Blender; each test gets a new file.
"""

import os
import shutil
import sys
import tempfile
from pathlib import Path
from types import SimpleNamespace

import pytest

REPOSITORY = Path(__file__).resolve().parents[2]
EXTENSION = "bl_ext.user_default.smooth_polylines"

# Before bpy is imported: nothing of a developer's own Blender is read or written.
PROFILE = Path(tempfile.mkdtemp(prefix="smooth-polylines-profile-"))
os.environ["BLENDER_USER_RESOURCES"] = str(PROFILE)
LOCAL_EXTENSIONS = PROFILE / "extensions" / "user_default"
LOCAL_EXTENSIONS.mkdir(parents=True)
(LOCAL_EXTENSIONS / "smooth_polylines").symlink_to(REPOSITORY / "addon")

import bpy  # noqa: E402

import addon_utils  # noqa: E402  (lies inside bpy)

exit_status = 0


def pytest_report_header() -> str:
    return f"Blender {bpy.app.version_string}, Python {sys.version.split()[0]}"


@pytest.fixture(scope="session")
def extension():
    """The add-on's package, enabled by Blender's own machinery."""
    module = addon_utils.enable(EXTENSION, default_set=True)
    assert module is not None, "Blender could not enable the add-on; its message is above"
    yield module
    addon_utils.disable(EXTENSION, default_set=True)
    assert not hasattr(bpy.types, "MESH_OT_smooth_polyline_add")


@pytest.fixture
def scene(extension):
    """An empty file; the add-on stays enabled."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    return bpy.context.scene


@pytest.fixture
def seams(extension):
    """The modules that put lines into meshes, and those that they stand on."""
    from bl_ext.user_default.smooth_polylines import seams, session, surface
    from bl_ext.user_default.smooth_polylines.seams import align, edit, put, slide

    return SimpleNamespace(
        align=align, edit=edit, package=seams, put=put, session=session, slide=slide, surface=surface
    )


@pytest.fixture
def suzanne(scene):
    """Suzanne in Edit Mode, in face select mode, nothing selected."""
    bpy.ops.mesh.primitive_monkey_add()
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_mode(type="FACE")
    bpy.ops.mesh.select_all(action="DESELECT")
    return bpy.context.edit_object


def pytest_sessionfinish(session, exitstatus):
    global exit_status
    exit_status = int(exitstatus)


@pytest.hookimpl(trylast=True)
def pytest_unconfigure(config):
    """End without the static destructors of bpy, in which some versions crash or hang after register_class."""
    shutil.rmtree(PROFILE, ignore_errors=True)
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(exit_status)
