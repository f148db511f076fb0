# SPDX-License-Identifier: GPL-3.0-or-later
"""The refusals that the add-on itself can give: what is wrong, and what to do next.

Holds no handling: `guard` turns these, and the library's own errors, into messages.
"""


class AddonError(Exception):
    """Base of all refusals of the add-on; its text is shown to the artist as it is."""


class LibraryError(AddonError):
    """The wheel `smooth_polylines` is missing, broken or of another version."""


class LimitError(AddonError):
    """It took longer than the preferences allow."""


class ObjectError(AddonError):
    """The object cannot be used: not a mesh, linked, flattened, without visible faces."""


class SelectionError(AddonError):
    """The selected faces do not say where the line should go."""
