"""Bumpy spheres and lines that each of them can carry: for measuring the batch, and for its tests.

Needs numpy alone. Not imported by the batch.
"""

from pathlib import Path

import numpy as np

# Near places on the unit sphere.
LINES = [
    {
        "name": "across",
        "filter": "geodesic",
        "picks": [{"point": [-1, 0, 0]}, {"point": [0, 0, 1]}, {"point": [1, 0, 0]}],
    },
    {
        "name": "ring",
        "filter": "fair",
        "closed": True,
        "pinned": "all",
        "picks": [{"point": [1, 0, 0]}, {"point": [0, 1, 0]}, {"point": [-1, -0.2, 0]}, {"point": [0, -1, 0.1]}],
    },
]


def make_bumpy(size: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """A closed bumpy sphere about the unit sphere: positions and triangles, 2 * size * (size - 1) of them."""
    rng = np.random.default_rng(seed)
    a, b, c = rng.integers(2, 6, 3)
    theta = np.pi * np.arange(1, size) / size
    phi = 2 * np.pi * np.arange(size) / size
    t, p = np.meshgrid(theta, phi, indexing="ij")
    radius = 1 + 0.05 * np.sin(a * t) * np.cos(b * p) + 0.03 * np.sin(c * p)
    rows = np.stack([radius * np.sin(t) * np.cos(p), radius * np.sin(t) * np.sin(p), radius * np.cos(t)], axis=-1)
    positions = np.vstack([rows.reshape(-1, 3), [[0, 0, 1.0], [0, 0, -1.0]]])
    top, bottom = len(positions) - 2, len(positions) - 1
    around = np.arange(size)
    beside = (around + 1) % size
    last = (size - 2) * size
    upper = size * np.arange(size - 2)[:, None]
    parts = [
        (top, around, beside),
        (bottom, last + beside, last + around),
        (upper + around, upper + size + around, upper + size + beside),
        (upper + around, upper + size + beside, upper + beside),
    ]
    return positions, np.concatenate([np.stack(np.broadcast_arrays(*part), axis=-1).reshape(-1, 3) for part in parts])


def write_binary_ply(path: Path, positions: np.ndarray, triangles: np.ndarray) -> None:
    """A binary .ply file, with 32-bit positions."""
    path.parent.mkdir(parents=True, exist_ok=True)
    table = np.zeros(len(triangles), dtype=[("count", "u1"), ("corners", "<i4", 3)])
    table["count"], table["corners"] = 3, triangles
    head = (
        f"ply\nformat binary_little_endian 1.0\nelement vertex {len(positions)}\nproperty float x\nproperty float y\n"
        f"property float z\nelement face {len(table)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    path.write_bytes(head.encode() + positions.astype("<f4").tobytes() + table.tobytes())


def write_stl(path: Path, positions: np.ndarray, triangles: np.ndarray) -> None:
    """A binary .stl file."""
    path.parent.mkdir(parents=True, exist_ok=True)
    table = np.zeros(len(triangles), dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    table["corners"] = positions[triangles]
    path.write_bytes(b"".ljust(80) + np.array([len(triangles)], dtype="<u4").tobytes() + table.tobytes())
