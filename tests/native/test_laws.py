"""Laws of `geodesic`: where step B's route is the same, the line is a matter of the surface and not of its triangles; a
line through points of its own is itself. Tolerances follow from the rounding of coordinates."""

import numpy as np
import pytest

import smooth_polylines as sp
from native.made_meshes import make_sphere, make_terrain, make_torus

EPS = np.finfo(float).eps
SURFACES = {
    "terrain": lambda: make_terrain(300, 4),
    "sphere": lambda: make_sphere(3),
    "torus": lambda: make_torus(24, 12),
}


def crossing_slack(mesh, line):
    """How far rounding may move each crossing: its line lies right to 64 roundings of the coordinates, and a shift of
    the line moves the crossing by that over the sine of the angle between line and edge."""
    size = np.abs(mesh.positions).max()
    points = line.points
    slack = np.full(len(points), 64 * EPS * size)
    for i in range(1, len(points) - 1):
        ends = mesh.triangles[line.triangles[i]][line.barycentric[i] != 0]
        if len(ends) == 2:
            edge = mesh.positions[ends[1]] - mesh.positions[ends[0]]
            way = points[i + 1] - points[i - 1]
            sine = np.linalg.norm(np.cross(edge, way)) / (np.linalg.norm(edge) * np.linalg.norm(way))
            slack[i] /= max(sine, EPS)
    return slack


def distances_to_line(points, line):
    """Distance of each point from a polyline in space."""
    a, b = line.points[:-1], line.points[1:]
    along = b - a
    share = np.einsum("psk,sk->ps", points[:, None] - a, along) / np.einsum("sk,sk->s", along, along)
    foot = a + np.clip(share, 0, 1)[..., None] * along
    return np.linalg.norm(points[:, None] - foot, axis=2).min(axis=1)


def without_repeats(ids):
    return ids[np.r_[True, ids[1:] != ids[:-1]]]


@pytest.mark.parametrize("name", SURFACES)
def test_a_geodesic_through_points_of_its_own_is_itself(name):
    positions, triangles = SURFACES[name]()
    mesh = sp.SurfaceMesh(positions, triangles)
    rng = np.random.default_rng(31)
    for _ in range(10):
        line = mesh.polyline(rng.choice(len(triangles), 2, replace=False).tolist(), filter="geodesic")
        own = range(0, len(line.points), 3)
        picks = [(int(line.triangles[i]), tuple(line.barycentric[i])) for i in (*own, len(line.points) - 1)]
        through = mesh.polyline(picks, filter="geodesic", pinned="all")
        assert (distances_to_line(line.points, through) <= crossing_slack(mesh, line)).all()
        assert abs(through.length - line.length) <= 64 * EPS * len(line.points) * np.abs(positions).max()


def split_at_midpoints(positions, triangles):
    """Each triangle as four; the surface is the same to the rounding of the midpoints."""
    edges = np.sort(np.vstack([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1)
    unique, inverse = np.unique(edges, axis=0, return_inverse=True)
    middle = len(positions) + inverse.reshape(3, -1).T
    a, b, c = triangles.T
    ab, bc, ca = middle.T
    fine = np.stack([np.stack(t, axis=1) for t in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))], axis=1)
    return np.vstack([positions, positions[unique].mean(axis=1)]), fine.reshape(-1, 3)


@pytest.mark.parametrize("name", SURFACES)
def test_triangles_split_in_four_carry_the_same_geodesic(name):
    positions, triangles = SURFACES[name]()
    coarse = sp.SurfaceMesh(positions, triangles)
    fine = sp.SurfaceMesh(*split_at_midpoints(positions, triangles))
    rng = np.random.default_rng(32)
    same = 0
    for _ in range(20):
        picks = rng.choice(len(triangles), 2, replace=False)
        line = coarse.polyline(picks.tolist(), filter="geodesic")
        # The middle one of the four has the same barycentre.
        other = fine.polyline((4 * picks + 3).tolist(), filter="geodesic")
        if line.report.stop_reason != "converged" or not np.array_equal(
            without_repeats(other.strip // 4), without_repeats(line.strip)
        ):
            continue
        same += 1
        assert (distances_to_line(line.points, other) <= 4 * crossing_slack(coarse, line)).all()
    assert same >= 5


@pytest.mark.parametrize("flipped", ["all", "every other"])
def test_other_diagonals_of_planar_quads_carry_the_same_geodesic(flipped):
    """A sheet bent along lines, so that all its quads are planar."""
    n = 12
    x, y = np.meshgrid(np.linspace(0, 3, n + 1), np.linspace(0, 1, n + 1))
    positions = np.stack([x, y, np.sin(2 * x)], axis=-1).reshape(-1, 3)
    corner = (np.arange(n)[:, None] * (n + 1) + np.arange(n)).ravel()
    a, b, c, d = corner, corner + 1, corner + n + 2, corner + n + 1
    one = np.stack([a, b, c, a, c, d], axis=1).reshape(-1, 3)
    two = np.stack([a, b, d, b, c, d], axis=1).reshape(-1, 3)
    if flipped == "every other":
        keep = np.repeat(np.arange(n * n) % 2 == 0, 2)
        two[keep] = one[keep]
    faces = np.repeat(np.arange(n * n), 2)
    meshes = [sp.SurfaceMesh(positions, triangles) for triangles in (one, two)]
    rng = np.random.default_rng(33)
    for _ in range(20):
        ends = rng.choice((n + 1) ** 2, 2, replace=False)
        lines = []
        for mesh in meshes:
            at = [np.argwhere(mesh.triangles == v)[0] for v in ends]
            picks = [(int(t), tuple(np.eye(3)[k])) for t, k in at]
            lines.append(mesh.polyline(picks, filter="geodesic"))
        line, other = lines
        assert abs(line.length - other.length) <= 64 * EPS * 3 * len(line.points)
        quads = [without_repeats(faces[made.segment_triangles]) for made in lines]
        if np.array_equal(*quads):
            assert (distances_to_line(line.points, other) <= 4 * crossing_slack(meshes[0], line)).all()
