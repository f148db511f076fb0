"""Hostile meshes by formula and by chance: twenty kinds, each from a seed. Holds no test and no mesh of anybody's."""

import numpy as np

from native.made_meshes import make_fan, make_grid, make_irregular_square, make_sphere, make_terrain, make_torus


def plane(rng):
    return make_irregular_square(int(rng.integers(5, 700)), int(rng.integers(2**31)))


def terrain(rng):
    return make_terrain(int(rng.integers(20, 900)), int(rng.integers(2**31)), height=10 ** rng.uniform(-3, 1))


def _shaken(mesh, rng, by):
    positions, triangles = mesh
    return positions + by * rng.standard_normal(positions.shape), triangles


def _anywhere(mesh, rng):
    """At a size of 1e-6 to 1e6, in half of the cases up to a hundred million of its sizes from the origin."""
    positions, triangles = mesh
    size = 10 ** rng.uniform(-6, 6)
    away = size * 10 ** rng.uniform(0, 8) * rng.standard_normal(3) * rng.integers(0, 2)
    return positions * size + away, triangles


def sphere(rng):
    return _anywhere(_shaken(make_sphere(int(rng.integers(0, 4))), rng, 0.02), rng)


def torus(rng):
    shape = make_torus(int(rng.integers(3, 40)), int(rng.integers(3, 20)), tube=rng.uniform(0.05, 0.9))
    return _anywhere(_shaken(shape, rng, 0.01), rng)


def needles(rng):
    """Angles down to a millionth of a degree: 1.7e-8 of the triangles' length."""
    positions, triangles = plane(rng)
    return positions * [1, 10 ** rng.uniform(-8, -2), 1], triangles


def needle_surface(rng):
    """The same on a curved surface, in a direction that is no axis."""
    positions, triangles = _shaken(make_sphere(3), rng, 0.03)
    axis = rng.standard_normal(3)
    axis /= np.linalg.norm(axis)
    along = positions @ axis
    return positions - np.outer(along, axis) * (1 - 10 ** rng.uniform(-8, -1)), triangles


def fan(rng):
    """A vertex of valence 3 to 2000: flat, pointed, or open."""
    valence = round(3 * 10 ** rng.uniform(0, np.log10(2000 / 3)))
    return make_fan(valence, closed=bool(rng.integers(2)), height=float(rng.choice([0.0, 0.3, 3.0])))


def saddle_fan(rng):
    """A vertex with more than a full turn of angle round it, between rings of triangles."""
    positions, triangles = make_fan(int(rng.integers(2, 60)) * 2)
    positions[1::2, 2], positions[2::2, 2] = 1.0, -1.0
    return positions, triangles


def folded_sheet(rng):
    """A square folded like a letter: sheets that lie on each other, joined at the folds."""
    positions, triangles = make_grid(int(rng.integers(2, 16)) * 2)
    folds = int(rng.integers(2, 6))
    wave = np.abs((positions[:, 0] * folds + 1) % 2 - 1)
    gap = float(rng.choice([0.0, 1e-9, 1e-3]))
    return np.column_stack([wave / folds, positions[:, 1], gap * positions[:, 0]]), triangles


def doubled_sheet(rng):
    """Two squares at the same place, joined along one side: barycentres coincide."""
    positions, triangles = make_grid(int(rng.integers(1, 16)))
    left = positions[:, 0] == 0
    copy = np.arange(len(positions)) + len(positions)
    copy[left] = np.flatnonzero(left)
    return np.vstack([positions, positions]), np.vstack([triangles, copy[triangles[:, ::-1]]])


def coincident_vertices(rng):
    """Some vertices moved onto a neighbour: edges of length 0 and triangles without area."""
    bases = [terrain, lambda r: make_sphere(int(r.integers(1, 4))), lambda r: make_grid(int(r.integers(2, 20)))]
    positions, triangles = bases[int(rng.integers(3))](rng)
    positions = positions.copy()
    count = int(len(triangles) * rng.uniform(0.01, 0.5))
    for a, b, _ in triangles[rng.choice(len(triangles), count, replace=False)]:
        positions[a] = positions[b]
    return positions, triangles


def zero_area_fan(rng):
    """Fans whose rims lie in one line, or in one point; a ring of sound triangles outside."""
    valence = int(rng.integers(3, 60))
    inner, triangles = make_fan(valence)
    outer = inner[1:] * 2
    inner = inner * [1, float(rng.choice([0.0, 1e-300, 1e-17])), 0] if rng.integers(3) else inner * 0
    i = np.arange(valence)
    after = (i + 1) % valence
    ring = np.concatenate(
        [
            np.column_stack([1 + i, 1 + valence + i, 1 + valence + after]),
            np.column_stack([1 + i, 1 + valence + after, 1 + after]),
        ]
    )
    return np.vstack([inner, outer]), np.vstack([triangles, ring])


def checkerboard(rng):
    """Squares with holes between: whole rows and columns stay, or fields that touch at corners alone."""
    side = int(rng.integers(3, 20))
    positions, triangles = make_grid(side)
    cell = np.repeat(np.arange(side * side), 2)
    row, column = cell // side, cell % side
    keep = (row + column) % 2 == 0 if rng.integers(3) == 0 else ~((row % 3 == 1) & (column % 3 == 1))
    return positions, triangles[keep]


def single_triangle(rng):
    """One triangle, or the same one more than once."""
    positions = rng.standard_normal((3, 3)) * 10 ** rng.uniform(-6, 6)
    return positions, np.array([[0, 1, 2], [2, 1, 0], [0, 1, 2]])[: int(rng.integers(1, 4))]


def strip(rng):
    """One triangle wide: straight, wound round, or closed to a ring."""
    count = int(rng.integers(2, 300))
    angle = np.repeat(np.arange(count), 2) * (2 * np.pi / count)
    side = np.tile([0.0, 1.0], count)
    form = int(rng.integers(3))
    if form == 0:
        positions = np.column_stack([angle * 10, side, 0.1 * rng.standard_normal(2 * count)])
    else:
        positions = np.column_stack([(3 + side) * np.cos(angle), (3 + side) * np.sin(angle), side * rng.uniform(0, 3)])
    first = np.arange(2 * count if form == 2 else 2 * count - 2)
    return positions, np.column_stack([first, first + 1, first + 2]) % (2 * count)


def twisted(rng):
    """A Moebius strip, or a Klein bottle."""
    around, across = int(rng.integers(5, 40)), int(rng.integers(1 if rng.integers(2) else 4, 9))
    is_klein = across >= 4
    u, v = np.meshgrid(np.arange(around), np.arange(across + (not is_klein)), indexing="ij")
    a = 2 * np.pi * u / around
    if is_klein:
        b = 2 * np.pi * v / across
        ring = 2 + np.cos(a / 2) * np.sin(b) - np.sin(a / 2) * np.sin(2 * b)
        height = np.sin(a / 2) * np.sin(b) + np.cos(a / 2) * np.sin(2 * b)
    else:
        b = v / across - 0.5
        ring, height = 1 + b * np.cos(a / 2), b * np.sin(a / 2)
    positions = np.stack([ring * np.cos(a), ring * np.sin(a), height], axis=-1).reshape(-1, 3)
    rows = v.shape[1]

    def at(i, j):
        over = i >= around
        if is_klein:
            return (i % around) * rows + (-j if over else j) % rows
        return (i % around) * rows + (rows - 1 - j if over else j)

    triangles = []
    for i in range(around):
        for j in range(across):
            p, q, r, s = at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)
            triangles += [[p, q, r], [p, r, s]]
    return _shaken((positions, np.array(triangles)), rng, 0.005)


def fifty_parts(rng):
    """Fifty pieces that are not connected, some inside each other."""
    pieces = [make_sphere(int(rng.integers(0, 2))) for _ in range(25)] + [
        make_grid(int(rng.integers(1, 5))) for _ in range(25)
    ]
    positions, triangles, first = [], [], 0
    for p, t in pieces:
        positions.append(p * rng.uniform(0.1, 1) + rng.uniform(-3, 3, 3))
        triangles.append(t + first)
        first += len(p)
    return np.vstack(positions), np.vstack(triangles)


def soup(rng):
    """Random triangles on few vertices: walls, pinches, repeated and overlapping triangles everywhere."""
    count = int(rng.integers(4, 40))
    triangles = np.array([rng.choice(count, 3, replace=False) for _ in range(int(rng.integers(1, 2 * count)))])
    return np.round(rng.standard_normal((count, 3)), int(rng.integers(0, 3))), triangles


def lattice(rng):
    """A regular grid, or a cube's surface of one: costs that tie everywhere, vertices in one line."""
    positions, triangles = make_grid(int(rng.integers(1, 25)), int(rng.integers(1, 25)))
    return np.round(positions * 1000) / 8, triangles


KINDS = {
    made.__name__.replace("_", " "): made
    for made in (
        plane, terrain, sphere, torus, needles, needle_surface, fan, saddle_fan, folded_sheet, doubled_sheet,
        coincident_vertices, zero_area_fan, checkerboard, single_triangle, strip, twisted, fifty_parts, soup, lattice,
    )
}  # fmt: skip
# The kinds that have most to vary come more often, so that there are five hundred.
COUNTS = {kind: 26 for kind in KINDS} | {"terrain": 29, "sphere": 29, "torus": 29, "coincident vertices": 29}
COUNTS["single triangle"] = 20


def make(kind, seed):
    """The mesh number `seed` of a kind: positions (V, 3) float64, triangles (F, 3); the same on every machine."""
    positions, triangles = KINDS[kind](np.random.default_rng([seed, list(KINDS).index(kind)]))
    return np.ascontiguousarray(positions, float), np.ascontiguousarray(triangles, np.int32)
