"""Reads the pictures that batches make, so that tests can look at them. Holds no assertions."""

import struct
import zlib

import numpy as np


def read_png(path):
    """Pixels of an 8-bit RGB picture, (height, width, 3), and the kinds of its pieces."""
    data = path.read_bytes()
    at, pieces, body = 8, [], b""
    while at < len(data):
        (length,) = struct.unpack_from(">I", data, at)
        kind = data[at + 4 : at + 8]
        pieces.append(kind)
        if kind == b"IHDR":
            width, height, depth, colours = struct.unpack_from(">IIBB", data, at + 8)
            assert (depth, colours) == (8, 2)
        elif kind == b"IDAT":
            body += data[at + 8 : at + 8 + length]
        at += 12 + length
    rows = np.frombuffer(zlib.decompress(body), dtype=np.uint8).reshape(height, 1 + 3 * width)
    pixels = np.zeros((height, 3 * width), dtype=np.uint8)
    above = np.zeros(3 * width, dtype=np.uint8)
    for y, row in enumerate(rows):
        above = pixels[y] = unfilter(row[0], row[1:], above)
    return pixels.reshape(height, width, 3), pieces


def unfilter(kind, row, above):
    if kind == 0:
        return row
    if kind == 2:
        return row + above
    out = np.zeros(len(row) + 3, dtype=np.int64)
    up = np.concatenate([np.zeros(3, dtype=np.int64), above.astype(np.int64)])
    for x in range(3, len(out)):
        left, over, corner = out[x - 3], up[x], up[x - 3]
        if kind == 1:
            guess = left
        elif kind == 3:
            guess = (left + over) // 2
        else:
            p = left + over - corner
            guess = min((left, over, corner), key=lambda v, p=p: abs(p - v))
        out[x] = (int(row[x - 3]) + guess) & 255
    return out[3:].astype(np.uint8)


def count_red(pixels):
    """How many pixels show a line."""
    red, green, blue = (pixels[..., k].astype(int) for k in range(3))
    return int(((red > 150) & (green < 90) & (blue < 110)).sum())
