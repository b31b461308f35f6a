"""Long contact runs of mistuned samples, reduced to what any steady-state test looks at.

Every point runs for ``DURATION`` seconds whatever a test would say, so that tests can be compared
on the same motion and what they accepted can be followed for two more seconds.
"""

import time
from typing import NamedTuple

import numpy as np

from evidence.truth.disk import reference_reduced, reference_scene
from hpcrub.contact.bank import allocate
from hpcrub.contact.integrate import run
from hpcrub.contact.observers import Record
from hpcrub.model.mistuning import stiffness_deviation
from hpcrub.model.reduction import mistuned_modes
from hpcrub.response.revolution import cut_revolution
from hpcrub.response.steady import SteadyCriteria, correlation

DURATION = 7.0  # [s]: the longest max_time of the comparison and two seconds more
SPEEDS = np.linspace(33.5, 35.5, 32)  # [Hz], the interaction with four bumps
LEVELS = (0.02, 0.04)  # half ranges of stiffness
WIDTH = 16
SEED = 2020
FIRST_CHECK = SteadyCriteria().first_check


class Histories(NamedTuple):
    """P points; check k happens FIRST_CHECK seconds and k revolutions after the start."""

    level: np.ndarray  # (P,) index
    sample: np.ndarray  # (P,)
    speed: np.ndarray  # (P,) [Hz]
    first: np.ndarray  # (P,) blocks (quarter revolutions) before check 0
    peak: np.ndarray  # (P, B, N) largest |u_t| of every block and tip [m]
    correlation: np.ndarray  # (P, windows, checks) of the two last windows, at the largest tip


WINDOWS = (3, 10)  # [revolutions]


def simulate(n_samples, report=lambda text: None):
    """Histories of the first samples of every level and of the tuned disk (level −1)."""
    reduced, scene = reference_reduced(), reference_scene(scheme="exact_modal", step=2e-5)
    grid = cut_revolution(SPEEDS[0], scene)
    parts, began = [], time.monotonic()
    cases = [(-1, 0), *((v, s) for s in range(n_samples) for v in range(len(LEVELS)))]
    for done, (level, sample) in enumerate(cases):
        half_range = LEVELS[level] if level >= 0 else 0.0
        deviation = stiffness_deviation(SEED, max(level, 0), sample, 12, half_range)
        modes = mistuned_modes(reduced, deviation)
        batches = np.split(SPEEDS, len(SPEEDS) // WIDTH)
        parts += [of_speeds(modes, scene, grid, batch, level, sample) for batch in batches]
        report(f"{done + 1} of {len(cases)} disks, {time.monotonic() - began:.0f} s")
    return Histories(*(np.concatenate(members) for members in zip(*parts, strict=True)))


def of_speeds(modes, scene, grid, speeds, level, sample):
    """Members of Histories for WIDTH speeds of one disk."""
    per_revolution = grid.blocks_per_revolution
    n_blocks = int(DURATION * speeds.min() * per_revolution)
    bank = allocate(modes, scene, grid, WIDTH, speeds)
    n_points, n_records = bank.scheme.observed.shape[1], grid.steps_per_block // grid.stride
    record = Record.allocate(bank, n_blocks, grid.stride)
    run(bank, n_blocks, record)
    peak = record.peak.reshape(n_blocks, n_points, WIDTH)
    history = record.history.reshape(n_blocks, n_records, n_points, WIDTH)
    first = np.ceil(FIRST_CHECK * speeds * per_revolution).astype(int)
    n_checks = (n_blocks - first.max()) // per_revolution
    found = np.full((WIDTH, len(WINDOWS), n_checks), np.nan)
    for lane in range(WIDTH):
        for w, revolutions in enumerate(WINDOWS):
            for k in range(n_checks):
                now, length = first[lane] + k * per_revolution, revolutions * per_revolution
                if now >= 2 * length:
                    tip = np.argmax(peak[now - length : now, :, lane].max(axis=0))
                    both = history[now - 2 * length : now, :, tip, lane].reshape(2, -1)
                    found[lane, w, k] = correlation(*both)
    n_most = int(DURATION * SPEEDS.min() * per_revolution)  # the same for all batches
    ones = np.ones(WIDTH, dtype=int)
    n_kept = (n_most - int(np.ceil(FIRST_CHECK * SPEEDS.max() * per_revolution))) // per_revolution
    return (
        level * ones,
        sample * ones,
        speeds,
        first,
        np.moveaxis(peak[:n_most], 2, 0)[:, :, : len(modes.observed)].astype(np.float32),
        found[:, :, :n_kept].astype(np.float32),
    )
