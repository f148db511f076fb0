# SPDX-License-Identifier: GPL-3.0-or-later
"""The one door to the wheel `smooth_polylines`: found, of the right version, or a clear refusal.

The wheel is imported when first needed, so that the add-on can be enabled, and can say what is wrong, without it.
Holds no geometry and no Blender.
"""

import functools
import importlib
import sys
import tomllib
from pathlib import Path
from types import ModuleType

from .errors import LibraryError

MODULE = "smooth_polylines"


@functools.cache
def read_extension_version() -> str:
    """The version in the extension's own manifest: the wheel beside it has the same."""
    manifest = Path(__file__).with_name("blender_manifest.toml")
    return tomllib.loads(manifest.read_text(encoding="utf-8"))["version"]


def load_library() -> ModuleType:
    """The module `smooth_polylines`; LibraryError when it is missing, broken or of another version."""
    try:
        library = importlib.import_module(MODULE)
    except ImportError as error:
        raise LibraryError(
            f"The library {MODULE} that does the geometry cannot be loaded ({error}). "
            "Install the extension again from its zip file for this platform, then restart Blender"
        ) from error
    expected = read_extension_version()
    found = getattr(library, "__version__", "unknown")
    if found != expected:
        # A loaded native module stays loaded: after an upgrade only a new process gets the new one.
        raise LibraryError(
            f"The add-on is version {expected}, but the library {MODULE} that is loaded is version {found}. "
            "Restart Blender; if that does not help, remove the extension, restart and install it again"
        )
    return library


def is_refusal(error: BaseException) -> bool:
    """Whether `error` is the library's answer to a request that it cannot meet, and no defect of its own."""
    library = sys.modules.get(MODULE)
    return library is not None and isinstance(error, library.Error) and not isinstance(error, library.InternalError)
