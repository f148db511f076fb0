# SPDX-License-Identifier: GPL-3.0-or-later
"""The operators, one file each; thin: properties, poll, panel and one call into `session`."""

from . import add_polyline, copy_marks, update_curve

CLASSES = (
    add_polyline.MESH_OT_smooth_polyline_add,
    update_curve.CURVE_OT_smooth_polyline_update,
    copy_marks.MESH_OT_smooth_polyline_copy_marks,
    copy_marks.MESH_OT_smooth_polyline_mirror_marks,
)
