# SPDX-License-Identifier: GPL-3.0-or-later
"""A drawn stroke as few picks: as many as the smooth line needs to keep to what was drawn.

Arrays in, numbers out; no Blender in here, and no surface but the line that a caller makes.
"""

import itertools
from collections.abc import Callable, Sequence

import numpy as np

# The first picks are those of a chain of straight pieces this many tolerances off the stroke: a smooth line needs fewer
# than that.
FIRST_TOLERANCES = 6.0
MOST_ROUNDS = 12
# A leg that is longer than this many times its stretch of the stroke has taken another way round.
LONGEST_LEG = 1.5
# Places and pieces whose distances are measured at once.
MOST_PAIRS = 1_000_000


def fit_picks(
    places: np.ndarray,
    tolerances: np.ndarray,
    make_line: Callable[[list[int]], tuple[np.ndarray, np.ndarray]],
    start: Sequence[int] = (),
) -> list[int]:
    """Which of the samples of a stroke become picks: rising, the first and the last among them.

    places : (N, 3) the samples, in order
    tolerances : (N,) how far the line may pass from each, in the same unit
    make_line : for chosen samples the points of the line through them, (M, 3), and for each chosen sample its row there
    start : samples that are chosen in any case

    Where the line leaves the stroke its farthest sample is chosen too, leg by leg, until it keeps to it.
    """
    chosen = sorted({*simplify(places, FIRST_TOLERANCES * tolerances), *start})
    for _ in range(MOST_ROUNDS):
        points, rows = make_line(chosen)
        more = []
        for k, (first, last) in enumerate(itertools.pairwise(chosen)):
            if last - first < 2:
                continue
            leg = points[rows[k] : rows[k + 1] + 1]
            excess = measure_distances(places[first + 1 : last], leg) / tolerances[first + 1 : last]
            worst = int(np.argmax(excess))
            if excess[worst] > 1.0:
                more.append(first + 1 + worst)
            elif measure_length(leg) > LONGEST_LEG * measure_length(places[first : last + 1]) + tolerances[first]:
                more.append((first + last) // 2)
        if not more:
            break
        chosen = sorted({*chosen, *more})
    return chosen


def simplify(places: np.ndarray, tolerances: np.ndarray) -> list[int]:
    """Samples whose chain of straight pieces keeps to the rest (Ramer 1972, Douglas and Peucker 1973)."""
    chosen, waiting = {0, len(places) - 1}, [(0, len(places) - 1)]
    while waiting:
        first, last = waiting.pop()
        if last - first < 2:
            continue
        excess = measure_distances(places[first + 1 : last], places[[first, last]]) / tolerances[first + 1 : last]
        worst = int(np.argmax(excess))
        if excess[worst] > 1.0:
            between = first + 1 + worst
            chosen.add(between)
            waiting += [(first, between), (between, last)]
    return sorted(chosen)


def find_rows(points: np.ndarray, places: np.ndarray) -> list[int]:
    """The rows of the points of a line at which it passes through `places`, which follow one another along it."""
    row, rows = 0, []
    for place in places:
        row += int(np.argmin(np.linalg.norm(points[row:] - place, axis=1)))
        rows.append(row)
    return rows


def measure_distances(places: np.ndarray, chain: np.ndarray) -> np.ndarray:
    """Distance of each place, (N, 3), to a chain of straight pieces, (M, 3)."""
    if len(chain) == 1:
        return np.linalg.norm(places - chain[0], axis=1)
    # In parts, because a long line has as many pieces as would fill the memory.
    parts = np.array_split(places, max(1, len(places) * len(chain) // MOST_PAIRS))
    return np.concatenate([measure_piece_distances(part, chain).min(axis=1) for part in parts])


def measure_piece_distances(places: np.ndarray, chain: np.ndarray) -> np.ndarray:
    """Distance of each place, (N, 3), to each of the straight pieces of a chain, (M, 3): (N, M - 1)."""
    pieces = np.diff(chain, axis=0)
    squares = (pieces**2).sum(axis=1)
    offsets = places[:, None] - chain[:-1]
    parts = np.clip((offsets * pieces).sum(axis=2) / np.where(squares > 0.0, squares, 1.0), 0.0, 1.0)
    return np.linalg.norm(offsets - parts[:, :, None] * pieces, axis=2)


def measure_length(chain: np.ndarray) -> float:
    """Length of a chain of straight pieces."""
    return float(np.linalg.norm(np.diff(chain, axis=0), axis=1).sum())
