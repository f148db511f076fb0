# SPDX-License-Identifier: GPL-3.0-or-later
"""Lines put into the mesh: as marked edges, by moved vertices, or cut in; nets as patches; marks copied and mirrored.

The way in for scripts is `put.put_lines_into_mesh`. Holds nothing itself.
"""
