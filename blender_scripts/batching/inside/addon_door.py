"""The add-on as the batch uses it: the installed extension in a Blender program, the sources with the bpy module."""

import importlib
import importlib.util
import sys
from pathlib import Path
from types import ModuleType

import bpy

import addon_utils

from batching.job_file import read_version

SOURCE = Path(__file__).resolve().parents[3] / "addon"
SOURCE_NAME = "smooth_polylines_addon"
EXTENSION_END = ".smooth_polylines"


class NoAddonError(Exception):
    """There is no add-on to work with; the message says what to do."""


def load_addon(*, is_installed: bool) -> str:
    """The name of the add-on's package, enabled and with its library loaded; NoAddonError otherwise.

    is_installed : it is the extension installed in this Blender, and not the sources beside these scripts
    """
    name = enable_extension() if is_installed else register_source()
    native = importlib.import_module(f"{name}.native")
    try:
        library = native.load_library()
        print(f"library {library.__version__} from {library.__file__}", flush=True)
    except Exception as error:
        raise NoAddonError(str(error)) from error
    found = native.read_extension_version()
    if found != read_version():
        raise NoAddonError(
            f"found the extension in version {found}, but these scripts are version {read_version()}; use equal ones"
        )
    return name


def get_module(package: str, name: str) -> ModuleType:
    """A module of the add-on; ImportError where this version has none of that name."""
    return importlib.import_module(f"{package}.{name}")


def enable_extension() -> str:
    """The installed extension, enabled for this process if it is not."""
    names = [module.__name__ for module in addon_utils.modules(refresh=False)]
    found = [name for name in names if name.startswith("bl_ext.") and name.endswith(EXTENSION_END)]
    enabled = [name for name in found if name in bpy.context.preferences.addons]
    if not found:
        raise NoAddonError(
            "found no extension smooth_polylines in this Blender; install its zip file first: blender --command "
            "extension install-file -r user_default -e FILE.zip"
        )
    name = (enabled or found)[0]
    if addon_utils.enable(name, default_set=False) is None:
        raise NoAddonError(f"found the extension {name}, but Blender cannot enable it; see the log")
    return name


def register_source() -> str:
    """The add-on of this repository; its library is the one installed in this Python."""
    if SOURCE_NAME not in sys.modules:
        spec = importlib.util.spec_from_file_location(
            SOURCE_NAME, SOURCE / "__init__.py", submodule_search_locations=[str(SOURCE)]
        )
        module = importlib.util.module_from_spec(spec)
        sys.modules[SOURCE_NAME] = module
        spec.loader.exec_module(module)
        module.register()
    return SOURCE_NAME
