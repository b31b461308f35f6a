"""Estimate of the memory of a run, and refusal of a run that this machine cannot hold.

The layout of the result file reserves the space on the disk.
"""

import math
import os

from hpcrub import effects
from hpcrub.contact.lanes import WIDTH
from hpcrub.errors import InputError
from hpcrub.response import history
from hpcrub.response.revolution import cut_revolution
from hpcrub.runs.study import Run
from hpcrub.setup.problem import scene_of

DENSE = 8  # matrices of the full model in memory at once
FILL = 60  # bytes of a factorisation for each byte of the file of an unreduced model
SAMPLE = 64  # bytes on rank 0 for every sample, or disk at a value of a key, or of a pattern
NUMBER = 8  # bytes
# measured memory of a process that has just started, and of one that compiles [bytes]
INTERPRETER, COMPILING = 160_000_000, 400_000_000
PIECE = 500  # measured memory of the arrays of one block of a history, beside their numbers [bytes]


def estimate(run: Run) -> int:
    """Estimate the memory of the rank that needs most [bytes]."""
    study, config = run
    model, path = DENSE * NUMBER * config.disk.n_dof**2, config.disk.model
    if path is not None:
        model = (2 * config.disk.n_blades + 12) * NUMBER * config.n_coordinates**2
        model += FILL * os.path.getsize(path) if os.path.exists(path) else 0
    (status,) = (line for line in run.datasets() if line.name.rpartition("/")[2] == "status")
    n_parts = math.prod(run.known_sizes()[dimension] for dimension in status.dimensions)
    rows = (NUMBER if study.of_tasks else SAMPLE) * n_parts
    integration = 0
    if study.integrates:
        speed, scene = config.speeds.from_hz, scene_of(config)
        grid = cut_revolution(speed, scene)
        per_revolution = grid.steps_per_revolution // grid.stride
        records = per_revolution * config.steady_state.window_revolutions
        n_points = config.disk.n_points
        integration = NUMBER * (grid.steps_per_block + 2 * records * n_points * WIDTH)
        if config.disk.model is not None:  # Delassus operators of all points
            integration += NUMBER * 4 * n_points**2 * WIDTH
        integration += NUMBER * sum(e.n_numbers(config, grid) for e in effects.of(config))
        if study.histories:
            records = history.n_records(speed, config.history.duration_s, scene)
            kept = config.n_coordinates + 4 * n_points  # forces, displacements, gaps
            one_speed = config.speeds.n_values == 1  # in pieces, and joined
            integration += NUMBER * records * kept * (2 if one_speed else len(history.LANES))
            integration += PIECE * history.n_blocks(speed, config.history.duration_s, grid)
    return max(INTERPRETER + model + rows + integration, COMPILING * study.integrates)


def check(run: Run) -> None:
    """Raise InputError when a run needs more memory than this machine has."""
    needed = estimate(run)
    there = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    if needed > there:
        raise InputError(
            f"not enough memory: this study needs {needed / 1e9:,.1f} GB "
            f"({there / 1e9:,.1f} GB are there): longer steps (time), fewer samples "
            "(mistuning.samples) or shorter histories (history) need less"
        )
