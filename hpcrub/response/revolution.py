"""Division of a revolution into time steps, blocks and records, from the speed alone.

Speeds share lanes only where they take the same number of steps per revolution. So all speeds lie
on *rungs* of a fixed ladder, and each takes the steps that the lowest speed of its rung needs. The
result at a speed then depends on no other speed of the study.
"""

import math
from typing import Any, NamedTuple

import numpy as np

BAND = 1.08  # ratio of the fastest to the slowest speed of a rung
ANCHOR = 36.0  # a rung ends here [Hz]: the interval 33.5 to 35.5 Hz of the paper lies within one
MIN_BLOCK = 64  # steps


class Grid(NamedTuple):
    """Steps, blocks and records of a revolution, for all speeds of a rung."""

    steps_per_revolution: int
    blocks_per_revolution: int
    stride: int  # steps from one record to the next
    look: int = 1  # steps from one look at the displacements to the next, a divisor of the stride
    kept: int = 1  # steps from one record of a history to the next, a divisor of the stride

    @property
    def steps_per_block(self) -> int:
        """Time steps of a block."""
        return self.steps_per_revolution // self.blocks_per_revolution


def rung(speed_hz: float) -> int:
    """Number of the rung that a speed [Hz] lies on."""
    return math.floor(math.log(speed_hz / ANCHOR) / math.log(BAND))


def slowest(number: int) -> float:
    """Lowest speed of a rung [Hz]."""
    return ANCHOR * BAND**number


def speed_bands(speeds_hz: np.ndarray) -> list[np.ndarray]:
    """Split speeds (S,) [Hz] into index arrays, one for each rung, slowest first."""
    order = np.argsort(speeds_hz, kind="stable")
    rungs = [rung(speed) for speed in speeds_hz[order]]
    starts = [i for i in range(1, len(rungs)) if rungs[i] != rungs[i - 1]]
    return np.split(order, starts) if len(order) else []


def cut_revolution(speed_hz: float, scene: Any) -> Grid:
    """Grid with whole steps per block and whole blocks per revolution, no step longer than asked.

    A block turns the disk by whole bump pitches, or whole periods of casing and load together.

    speed_hz: any speed of a rung [Hz]; the lowest speed of the rung sets the grid.
    scene: a Scene, for `step`, `least_steps`, the intervals, `repeats` and `divisor`.
    """
    lowest = slowest(rung(speed_hz))
    n_steps = math.ceil(max(1.0 / (lowest * scene.step), scene.least_steps) * (1.0 - 1e-12))
    stride = int(scene.record_interval * lowest * n_steps * (1.0 + 1e-12))
    stride = max(1, min(stride, n_steps // scene.repeats))
    divisors = [d for d in range(1, scene.repeats + 1) if scene.repeats % d == 0]
    blocks = max(d for d in divisors if d == 1 or n_steps >= d * MIN_BLOCK)
    least = max(blocks * stride, n_steps // 16)
    while stride > 1 and math.lcm(blocks * stride, scene.divisor) > least:
        stride -= 1
    unit = math.lcm(blocks * stride, scene.divisor)
    n_steps = math.ceil(n_steps / unit) * unit

    def divisor(interval: Any) -> Any:
        most = min(float(stride), max(1.0, interval * lowest * n_steps * (1.0 + 1e-12)))
        return next(d for d in range(int(most), 0, -1) if stride % d == 0)

    look, kept = divisor(scene.look_interval), divisor(scene.history_interval)
    return Grid(n_steps, blocks, stride, look, kept)
