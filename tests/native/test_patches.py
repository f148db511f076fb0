"""Nets as patches: crossings found and avoided, automatic connections, and what the lines part a mesh into."""

from collections import Counter, defaultdict, deque
from itertools import pairwise

import numpy as np
import pytest

import smooth_polylines as sp
from native.cut_checker import CutChecker, count_edges, faces_by_line
from native.invariants import same_line
from native.made_meshes import make_grid, make_sphere, make_torus
from native.surfaces import open_surface


def spread_picks(positions, triangles, count, start=0):
    """Triangles far from each other, each the farthest in space from those before."""
    centres = positions[triangles].mean(axis=1)
    picks = [start]
    far = np.linalg.norm(centres - centres[start], axis=1)
    while len(picks) < count:
        picks.append(int(far.argmax()))
        far = np.minimum(far, np.linalg.norm(centres - centres[picks[-1]], axis=1))
    return picks


def check_patches(net, positions, triangles, faces=None):
    """Assert what can be counted independently; returns the patches."""
    patches = net.patches()
    cut = patches.cut
    lines = [line for line in net if line is not None]
    CutChecker(positions, triangles, faces).check(cut, lines, 1e-3)
    count, labels = faces_by_line(cut.triangles, cut.line_edges)
    assert len(patches) == count
    # The same parts under other numbers.
    assert len(set(zip(labels.tolist(), patches.triangle_patches.tolist(), strict=True))) == count
    assert (np.bincount(patches.triangle_patches) == patches.triangle_counts).all()
    a, b, c = (cut.positions[cut.triangles[:, k]] for k in range(3))
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2
    assert np.allclose(np.bincount(patches.triangle_patches, areas), patches.areas)
    assert (patches.polygon_patches[cut.triangle_polygons] == patches.triangle_patches).all()
    on_lines = set(map(tuple, cut.line_edges.tolist()))
    for patch in range(count):
        own = cut.triangles[patches.triangle_patches == patch]
        edges = count_edges(own)
        # Opened along the lines: an edge of a line with the patch on both sides is there twice.
        opened_edges = sum(count if key in on_lines else 1 for key, count in edges.items())
        vertices = count_fans(own, on_lines)
        assert patches.euler[patch] == vertices - opened_edges + len(own), f"patch {patch}"
    pairs = set()
    by_edge = {}
    for row, corners in enumerate(cut.triangles.tolist()):
        for k in range(3):
            key = tuple(sorted((corners[k], corners[(k + 1) % 3])))
            if key in on_lines:
                by_edge.setdefault(key, []).append(int(patches.triangle_patches[row]))
    for own in by_edge.values():
        if len(own) == 2:
            pairs.add(tuple(sorted(own)))
    assert set(map(tuple, patches.adjacency.tolist())) == pairs
    return patches


def count_fans(triangles, lines):
    """Vertices of a patch opened along lines: for each vertex, how many fans its triangles make."""
    at = {}
    for row, corners in enumerate(triangles.tolist()):
        for v in corners:
            at.setdefault(v, []).append(row)
    total = 0
    for v, rows in at.items():
        root = {row: row for row in rows}

        def find(row, root=root):
            while root[row] != row:
                row = root[row]
            return row

        by_spoke = {}
        for row in rows:
            for w in triangles[row].tolist():
                if w != v and (min(v, w), max(v, w)) not in lines:
                    by_spoke.setdefault(w, []).append(row)
        for joined in by_spoke.values():
            for other in joined[1:]:
                root[find(other)] = find(joined[0])
        total += len({find(row) for row in rows})
    return total


@pytest.mark.parametrize("count", [4, 6, 10, 16])
def test_automatic_connections_part_a_sphere_into_triangles(count):
    positions, triangles = make_sphere(4)
    mesh = sp.SurfaceMesh(positions, triangles)
    net = mesh.network(spread_picks(positions, triangles, count), "automatic", filter="geodesic")
    assert len(net.crossings) == 0
    patches = check_patches(net, positions, triangles)
    # All discs: V - E + F = 2 with the picks, the lines and the patches.
    assert (patches.euler == 1).all()
    assert count - len(net) + len(patches) == 2
    assert (patches.sides >= 3).all()
    assert patches.three_sided + patches.four_sided >= len(patches) - 1
    assert patches.sides.sum() == 2 * len(net)


@pytest.mark.parametrize(
    ("name", "filter_name"),
    [("spot.obj", "linear"), ("cow.off", "cubic"), ("fertility.off", "geodesic"), ("shark_holes.off", "fair")],
)
def test_automatic_nets_on_real_meshes(name, filter_name):
    surface = open_surface(name)
    picks = spread_picks(surface.positions, surface.triangles, 14)
    net = surface.mesh.network(picks, "automatic", filter=filter_name)
    assert net.errors == [None] * len(net)
    between = net.crossings.lines
    assert (between[:, 0] == between[:, 1]).all(), "lines of an automatic net cross"
    assert len(check_patches(net, surface.positions, surface.triangles)) >= 2


def test_a_torus_without_enough_lines_has_a_patch_that_is_no_disc():
    positions, triangles = make_torus(24, 12)
    mesh = sp.SurfaceMesh(positions, triangles)
    patches = check_patches(mesh.network(spread_picks(positions, triangles, 3), "chain"), positions, triangles)
    assert len(patches) == 1
    # A torus less a path: -1 for the hole that the path leaves.
    assert patches.euler.tolist() == [-1]
    assert patches.loops.tolist() == [1]


def test_all_pairs_of_four_in_a_square_cross_once_and_the_crossing_can_be_a_node():
    positions, triangles = make_grid(12)
    mesh = sp.SurfaceMesh(positions, triangles)
    corners = mesh.closest_points([[0.1, 0.12, 0], [0.9, 0.11, 0], [0.88, 0.9, 0], [0.13, 0.87, 0.0]]).surface_points
    net = mesh.network(corners, "all", filter="geodesic", avoid_crossings=False)
    assert len(net) == 6
    assert len(net.crossings) == 1
    assert set(net.crossings.lines[0].tolist()) == {1, 4}  # the diagonals 0-2 and 1-3
    nodes, connections = net.crossing_nodes()
    assert len(nodes) == 5
    assert sorted(map(sorted, connections.tolist())) == sorted(
        [[0, 1], [0, 3], [1, 2], [2, 3], [0, 4], [2, 4], [1, 4], [3, 4]]
    )
    again = mesh.network(nodes, connections, filter="geodesic")
    assert len(again.crossings) == 0
    patches = check_patches(again, positions, triangles)
    # Four triangles inside the square, and what lies around it, whose outline is a ring.
    assert len(patches) == 5
    assert patches.three_sided == 4
    assert sorted(patches.euler.tolist()) == [0, 1, 1, 1, 1]


def test_crossings_are_told_from_touches():
    positions, triangles = make_grid(4)
    mesh = sp.SurfaceMesh(positions, triangles)
    at = lambda *points: mesh.closest_points([[*p, 0.0] for p in points]).surface_points  # noqa: E731
    line = lambda *points: mesh.polyline(at(*points), filter="geodesic", pinned="all")  # noqa: E731
    across, up = line((0.05, 0.4), (0.95, 0.45)), line((0.4, 0.05), (0.45, 0.95))
    found = sp.find_crossings([across, up])
    assert found.is_transversal.tolist() == [True]
    assert found.lines.tolist() == [[0, 1]]
    # Both parameters give the place.
    for k, one in enumerate((across, up)):
        s = found.parameters[0, k]
        i = int(s)
        assert np.allclose((1 - s + i) * one.points[i] + (s - i) * one.points[i + 1], found.points[0], atol=1e-9)
    corners = positions[triangles[found.triangles[0]]]
    assert np.allclose(found.barycentric[0] @ corners, found.points[0])
    # Down to a point of the other and up again: they touch there; or on to the other side.
    for there, expected in (((0.9, 0.9), False), ((0.9, 0.1), True)):
        one = mesh.polyline([*at((0.1, 0.9)), (10, [0.25, 0.25, 0.5]), *at(there)], filter="geodesic", pinned="all")
        other = mesh.polyline([*at((0.05, 0.3)), (10, [0.25, 0.25, 0.5]), *at((0.95, 0.3))], pinned="all")
        found = sp.find_crossings([one, other])
        assert found.is_transversal.tolist() == [expected]
    # The same line twice runs along together; a shared end is nothing.
    assert sp.find_crossings([across, across]).is_transversal.tolist() == [False]
    assert len(sp.find_crossings([line((0.1, 0.1), (0.9, 0.2)), line((0.1, 0.1), (0.2, 0.9))])) == 0
    assert len(sp.find_crossings([])) == 0
    eight = line((0.2, 0.2), (0.8, 0.8), (0.8, 0.2), (0.2, 0.8))
    assert eight.self_crossings().is_transversal.tolist() == [True]
    assert eight.self_crossings().lines.tolist() == [[0, 0]]


def test_lines_that_run_along_together_cross_if_they_part_to_the_other_side():
    positions, triangles = make_grid(4)
    mesh = sp.SurfaceMesh(positions, triangles)
    at = lambda *points: mesh.closest_points([[*p, 0.0] for p in points]).surface_points  # noqa: E731
    # Both run along y = 0.5 from x = 0.25 to 0.75.
    vertices = at((0.25, 0.5), (0.75, 0.5))
    for last, expected in (((0.95, 0.2), True), ((0.95, 0.8), False)):
        one = mesh.polyline([*at((0.05, 0.2)), *vertices, *at((0.95, 0.35))], filter="geodesic", pinned="all")
        other = mesh.polyline([*at((0.05, 0.8)), *vertices, *at(last)], filter="geodesic", pinned="all")
        for lines in ([one, other], [other, one]):
            found = sp.find_crossings(lines)
            assert found.is_transversal.tolist() == [expected], last


def test_lines_that_need_not_cross_are_parted():
    """Of many random nets on a bumpy surface: no two lines that share a pick cross, and none crosses itself."""
    surface = open_surface("terrain")
    forced = before = 0
    for seed in range(6):
        picks = surface.random_picks(8, seed)
        rng = np.random.default_rng(seed)
        pairs = np.array([sorted(rng.choice(8, 2, replace=False)) for _ in range(14)])
        pairs = np.unique(pairs, axis=0)
        plain = surface.mesh.network(picks, pairs, filter="linear")
        parted = surface.mesh.network(picks, pairs, filter="linear", avoid_crossings=True)
        before += len(plain.crossings)
        assert len(parted.crossings) <= len(plain.crossings)
        assert (parted.connections == pairs).all()
        for a, b in parted.crossings.lines.tolist():
            assert a != b
            forced += not set(pairs[a]) & set(pairs[b])
            assert not set(pairs[a]) & set(pairs[b]), "lines that share a pick cross"
    assert forced > 0
    assert before >= forced


def test_all_pairs_of_four_need_not_cross_and_of_five_must():
    """The complete graph of four can be drawn in the plane, that of five only with a crossing (Kuratowski 1930)."""
    positions, triangles = make_grid(16)
    mesh = sp.SurfaceMesh(positions, triangles)
    five = [[0.3, 0.32, 0], [0.7, 0.31, 0], [0.68, 0.7, 0], [0.33, 0.67, 0], [0.52, 0.85, 0]]
    picks = mesh.closest_points(five).surface_points
    for count, least in ((4, 0), (5, 1)):
        net = mesh.network(picks[:count], "all", filter="geodesic")
        assert len(net.crossings) == least
        check_patches(net, positions, triangles)
        # Every line is there.
        assert net.errors == [None] * (count * (count - 1) // 2)


def cross_in_square(mesh, ends):
    """The net of two lines over a square, which would cross when straight."""
    picks = mesh.closest_points([[*end, 0.0] for end in ends]).surface_points
    return picks, np.array([[0, 1], [2, 3]])


@pytest.mark.parametrize("filter_name", ["linear", "cubic", "geodesic", "fair", "none"])
def test_a_single_crossing_is_gone_round_where_there_is_a_way(filter_name):
    """Two lines that share no pick: one goes round the other's end."""
    positions, triangles = make_grid(24)
    mesh = sp.SurfaceMesh(positions, triangles)
    picks, pairs = cross_in_square(mesh, [(0.1, 0.52), (0.9, 0.47), (0.51, 0.2), (0.48, 0.8)])
    plain = mesh.network(picks, pairs, filter=filter_name)
    assert len(plain.crossings) == 1
    net = mesh.network(picks, pairs, filter=filter_name, avoid_crossings=True)
    assert len(net.crossings) == 0
    assert (net.connections == pairs).all()
    for line, (start, goal) in zip(net, pairs, strict=True):
        for end, pick in ((0, start), (-1, goal)):
            corners = positions[triangles[picks[pick].triangle]]
            assert np.allclose(line.points[end], np.asarray(picks[pick].barycentric) @ corners)
    assert len(check_patches(net, positions, triangles)) == 1
    # One has stayed as it was, the other goes round it and no farther than round the square.
    changed = [i for i in range(2) if not same_line(plain[i], net[i])]
    assert len(changed) == 1
    assert plain[changed[0]].length < net[changed[0]].length < 2.5


def test_a_crossing_is_forced_where_the_other_line_parts_the_surface():
    positions, triangles = make_grid(24)
    mesh = sp.SurfaceMesh(positions, triangles)
    # Both from border to border: neither has a way to the other side.
    picks, pairs = cross_in_square(mesh, [(0.0, 0.52), (1.0, 0.47), (0.5, 0.0), (0.5, 1.0)])
    net = mesh.network(picks, pairs, filter="geodesic", avoid_crossings=True)
    assert len(net.crossings) == 1
    # Two lines more in the way, which can be gone round: one crossing remains.
    ends = [(0.0, 0.52), (1.0, 0.47), (0.5, 0.0), (0.5, 1.0), (0.3, 0.3), (0.8, 0.33), (0.2, 0.7), (0.7, 0.72)]
    picks = mesh.closest_points([[*end, 0.0] for end in ends]).surface_points
    pairs = np.arange(8).reshape(4, 2)
    assert len(mesh.network(picks, pairs, filter="geodesic").crossings) == 3
    net = mesh.network(picks, pairs, filter="geodesic", avoid_crossings=True)
    assert net.crossings.lines.tolist() == [[0, 1]]


def count_reachable_crossings(net, mesh, line):
    """The fewest lines that a way between the ends of `line` has to step over: a search of its own on the cut mesh."""
    made = [one for one in net if one is not None]
    cut = mesh.cut(made, 1e-6)
    over = Counter()
    for number, chain in enumerate(cut.line_vertices):
        if number != line:
            over.update({tuple(sorted(pair)) for pair in pairwise(chain.tolist())})
    at, by_edge = defaultdict(list), defaultdict(list)
    for row, corners in enumerate(cut.triangles.tolist()):
        for k in range(3):
            at[corners[k]].append(row)
            by_edge[tuple(sorted((corners[k], corners[(k + 1) % 3])))].append(row)
    start, goal = cut.line_vertices[line][[0, -1]].tolist()
    best = dict.fromkeys(at[start], 0)
    front = deque(best)
    neighbours = defaultdict(list)
    for edge, rows in by_edge.items():
        if len(rows) == 2:
            neighbours[rows[0]].append((rows[1], over[edge]))
            neighbours[rows[1]].append((rows[0], over[edge]))
    while front:
        row = front.popleft()
        for other, cost in neighbours[row]:
            if best[row] + cost < best.get(other, 1 << 30):
                best[other] = best[row] + cost
                front.appendleft(other) if cost == 0 else front.append(other)
    return min(best[row] for row in at[goal] if row in best)


@pytest.mark.parametrize("filter_name", ["linear", "fair"])
def test_what_still_crosses_is_forced(filter_name):
    """No way between the picks of a line that still crosses others crosses fewer, as the others lie."""
    surface = open_surface("terrain")
    remaining = avoided = 0
    for seed in range(4):
        picks = surface.random_picks(10, seed)
        rng = np.random.default_rng(seed)
        pairs = np.unique(np.array([sorted(rng.choice(10, 2, replace=False)) for _ in range(14)]), axis=0)
        plain = surface.mesh.network(picks, pairs, filter=filter_name)
        net = surface.mesh.network(picks, pairs, filter=filter_name, avoid_crossings=True)
        avoided += len(plain.crossings) - len(net.crossings)
        remaining += len(net.crossings)
        counts = Counter(net.crossings.lines.ravel().tolist())
        for line, count in counts.items():
            assert count_reachable_crossings(net, surface.mesh, line) == count
    assert avoided > 0
    # Of fourteen lines on ten picks some nets cannot be drawn in the plane.
    assert remaining >= 0


@pytest.mark.parametrize("filter_name", ["linear", "geodesic"])
@pytest.mark.parametrize("name", ["bunny00.off", "spot.obj", "fertility.off", "cow.off", "igea.ply"])
def test_discs_of_automatic_nets_have_four_sides_at_most(name, filter_name):
    surface = open_surface(name)
    picks = spread_picks(surface.positions, surface.triangles, 20)
    net = surface.mesh.network(picks, "automatic", filter=filter_name)
    assert len(net.crossings) == 0
    patches = net.patches()
    discs = patches.euler == 1
    assert patches.sides[discs].max() <= 4
    assert patches.not_discs == np.count_nonzero(~discs)
    # A line stands for two sides.
    assert patches.sides.sum() >= 2 * len(net)


@pytest.mark.parametrize("name", ["bunny00.off", "igea.ply"])
def test_the_net_of_the_papers_figure_18_on_a_real_mesh(name):
    """Ten picks, nineteen lines, the linear filter: the mesh is parted as Euler says."""
    surface = open_surface(name)
    picks = spread_picks(surface.positions, surface.triangles, 10)
    full = surface.mesh.network(picks, "automatic", filter="linear")
    assert len(full.crossings) == 0
    # Neighbours all of them, less the longest: nineteen.
    lengths = [line.length for line in full]
    kept = np.sort(np.argsort(lengths, kind="stable")[:19])
    net = surface.mesh.network(picks, full.connections[kept], filter="linear", avoid_crossings=True)
    assert (len(net), len(net.crossings)) == (19, 0)
    patches = net.patches()
    cut = patches.cut
    count, labels = faces_by_line(cut.triangles, cut.line_edges)
    assert len(patches) == count
    assert len(set(zip(labels.tolist(), patches.triangle_patches.tolist(), strict=True))) == count
    # V - E + F = 2, all patches discs: of the net, and of the cut mesh.
    assert 10 - 19 + count == 2
    assert (patches.euler == 1).all()
    assert patches.sides.sum() == 2 * 19
    edges = np.unique(np.sort(cut.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1), axis=0)
    assert len(cut.positions) - len(edges) + len(cut.triangles) == 2
    a, b, c = (surface.positions[surface.triangles[:, k]] for k in range(3))
    assert patches.areas.sum() == pytest.approx(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2, rel=1e-9)
