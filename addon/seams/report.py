# SPDX-License-Identifier: GPL-3.0-or-later
"""What is told after lines have been put into a mesh: one sentence, and the islands row by row. Knows no Blender."""

from typing import Any

# Rows in a panel.
MOST_ISLANDS = 12
# Larger stretch says no more.
MOST_STRETCH = 1000.0


def describe(done: Any) -> tuple[str, bool]:
    """One sentence about a `put.PutLines`, and whether it is a warning."""
    parts, is_warning = [], False
    count = len(done.lines)
    parts.append(f"{count} {'line' if count == 1 else 'lines'}, {len(done.edges)} edges")
    if done.method == "CUT":
        parts.append(f"{done.new_vertices} new vertices, {done.new_faces} new faces")
        if done.crossings:
            parts.append(f"{done.crossings} crossings of lines are vertices now")
    elif done.method == "SNAP":
        parts.append(f"at most {done.distance:.4g} from the line")
    else:
        parts.append(f"{len(done.moved)} vertices moved")
        if done.not_moved:
            is_warning = True
            parts.append(f"{len(done.not_moved)} stay where they were, since a face would have turned over")
    if done.islands is not None:
        parts.append(describe_islands(done.islands))
    if done.sharing:
        is_warning = True
        parts.append(f"the mesh has changed for {', '.join(done.sharing)} too")
    return "; ".join(parts), is_warning


def describe_islands(islands: Any) -> str:
    """How many islands, and how far the worst of them is stretched on average."""
    found = islands.islands
    worst_angle = max((i.angle_stretch for i in found), default=1.0)
    worst_area = max((i.area_stretch for i in found), default=1.0)
    count = f"{len(found)} {'island' if len(found) == 1 else 'islands'}"
    return f"{count}, stretch of angles up to {tell(worst_angle)}, of areas up to {tell(worst_area)}"


def tell(stretch: float) -> str:
    """A stretch as it is shown: where parts of an island have no area in the map it has no end."""
    return f"{stretch:.3f}" if stretch < MOST_STRETCH else f"over {MOST_STRETCH:.0f}"


def list_islands(islands: Any) -> list[str]:
    """A row an island, the largest first."""
    if islands is None:
        return []
    rows = [
        f"Island {number}: {i.faces} faces, angles {tell(i.angle_stretch)}, areas {tell(i.area_stretch)}"
        + (f", {i.flipped} flipped" if i.flipped else "")
        for number, i in enumerate(islands.islands[:MOST_ISLANDS], start=1)
    ]
    left = len(islands.islands) - MOST_ISLANDS
    return [*rows, f"... and {left} smaller ones"] if left > 0 else rows


def describe_net(done: Any) -> tuple[str, bool]:
    """One sentence about a `nets.PutNet`, and whether it is a warning."""
    count = len(done.sides)
    parts = [
        f"{len(done.lines.lines)} lines, {count} {'patch' if count == 1 else 'patches'}: "
        f"{done.three_sided} of three sides, {done.four_sided} of four"
    ]
    if done.not_discs:
        is_one = done.not_discs == 1
        parts.append(
            f"{done.not_discs} of them {'is no disc' if is_one else 'are no discs'} (a hole or a handle is inside)"
        )
    if done.crossings_as_nodes:
        parts.append(f"{done.crossings_as_nodes} crossings became picks")
    if done.crossings:
        parts.append(f"lines cross at {done.crossings} places, as the picks force them to")
    if done.errors:
        parts.append(f"{len(done.errors)} lines could not be made ({done.errors[0]})")
    if done.lines.islands is not None:
        parts.append(describe_islands(done.lines.islands))
    if done.lines.sharing:
        parts.append(f"the mesh has changed for {', '.join(done.lines.sharing)} too")
    return "; ".join(parts), bool(done.crossings or done.errors or done.lines.sharing)


def list_sides(sides: Any) -> list[str]:
    """How many patches have how many sides, a row a number of sides."""
    counts: dict[int, int] = {}
    for number in sorted(int(side) for side in sides):
        counts[number] = counts.get(number, 0) + 1
    return [f"Patches of {number} sides: {count}" for number, count in counts.items()]
