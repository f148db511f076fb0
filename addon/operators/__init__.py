# SPDX-License-Identifier: GPL-3.0-or-later
"""The operators, one file each; thin: properties, poll, panel and one call into `session`."""

from . import add_polyline, update_curve

CLASSES = (add_polyline.MESH_OT_smooth_polyline_add, update_curve.CURVE_OT_smooth_polyline_update)
