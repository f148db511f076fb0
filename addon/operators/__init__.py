# SPDX-License-Identifier: GPL-3.0-or-later
"""The operators, one file each; thin: properties, poll, panel and one call into `session`."""

from . import add_polyline, change_line, copy_marks, put_lines, put_net

CLASSES = (
    add_polyline.MESH_OT_smooth_polyline_add,
    change_line.CURVE_OT_smooth_polyline_update,
    change_line.OBJECT_OT_smooth_polyline_change_output,
    put_lines.MESH_OT_smooth_polyline_seam,
    put_net.MESH_OT_smooth_polyline_net,
    copy_marks.MESH_OT_smooth_polyline_copy_marks,
    copy_marks.MESH_OT_smooth_polyline_mirror_marks,
)
