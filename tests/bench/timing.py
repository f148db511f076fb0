"""Fair timing: contenders in turns, in one process, CPU time of all threads and wall time. Holds no query."""

import gc
import time
from dataclasses import dataclass

import numpy as np

# A sample repeats what is faster than this, so that the clock's grain does not show.
LEAST_SAMPLE_SECONDS = 0.002
MOST_REPEATS = 500
LEAST_ROUNDS = 3


@dataclass
class Samples:
    """Milliseconds a call of one contender, one a round."""

    cpu: list[float]
    wall: list[float]


def alternate(contenders, rounds, budget_seconds):
    """Samples of each contender (name: function), who takes turns `rounds` times, or fewer, but 3, within the budget.

    The first call of each is not counted: it warms caches and tells how often a sample repeats.
    """
    repeats = {name: repeats_for(run) for name, run in contenders.items()}
    samples = {name: Samples([], []) for name in contenders}
    names = list(contenders)
    began = time.perf_counter()
    gc.collect()
    gc.disable()
    try:
        for turn in range(rounds):
            if turn >= LEAST_ROUNDS and time.perf_counter() - began > budget_seconds:
                break
            shift = turn % len(names)
            for name in names[shift:] + names[:shift]:
                cpu, wall = time_once(contenders[name], repeats[name])
                samples[name].cpu.append(cpu)
                samples[name].wall.append(wall)
    finally:
        gc.enable()
    return samples


def repeats_for(run):
    cpu, _ = time_once(run, 1)
    return int(np.clip(np.ceil(1e3 * LEAST_SAMPLE_SECONDS / max(cpu, 1e-6)), 1, MOST_REPEATS))


def time_once(run, repeats):
    """Milliseconds of CPU and of wall time a call."""
    wall, cpu = time.perf_counter(), time.process_time()
    for _ in range(repeats):
        run()
    cpu, wall = time.process_time() - cpu, time.perf_counter() - wall
    return 1e3 * cpu / repeats, 1e3 * wall / repeats


def summarise(values):
    """Lower quartile, median and upper quartile."""
    return [float(q) for q in np.quantile(values, [0.25, 0.5, 0.75])]
