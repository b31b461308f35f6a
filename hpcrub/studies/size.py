"""What a study takes of disk and memory; refuses what this machine has not."""

import os
import shutil
import tempfile
from pathlib import Path
from typing import NamedTuple

from hpcrub import studies
from hpcrub.config.schema import Config
from hpcrub.errors import InputError
from hpcrub.response import history
from hpcrub.response.sweep import WIDTH, cut_revolution
from hpcrub.studies import files, imported
from hpcrub.studies.problem import time_grid

DENSE = 8  # matrices of the full model in memory at once
SAMPLE = 64  # bytes of rank 0 for every sample
NUMBER = 8  # bytes


class Size(NamedTuple):
    """What a study takes."""

    disk: int  # of its result file [bytes]
    memory: int  # of the rank that needs most [bytes]


def size(config: Config) -> Size:
    """Size of a study, estimated without any work.

    Raises InputError for unusable `sources`, and for numbers of steps that overflow.
    """
    try:
        return Size(files.file_size(config), _memory(config))
    except OverflowError:
        raise InputError(
            f"time.step_s: {config.time.step_s:g} is too short for a revolution at "
            f"{config.speeds.from_hz:g} Hz: no memory or disk would suffice"
        ) from None


def check(config: Config, path: str | Path | None = None) -> None:
    """Refuse a study that this machine cannot hold.

    Parameters
    ----------
    config
        Configuration of the study.
    path
        Where its result file will be made; None when it is there already.

    Raises
    ------
    InputError
        Says what it takes of disk and memory.
    """
    disk, memory = size(config)
    there = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    free = _free(path) if path is not None else disk
    if memory <= there and disk <= free:
        return
    what = "disk" if disk > free else "memory"
    raise InputError(
        f"not enough {what}: this study needs {_amount(disk / 1e9)} GB of disk"
        + (f" ({_amount(free / 1e9)} GB are free)" if path is not None else "")
        + f" and {_amount(memory / 1e9)} GB of memory ({_amount(there / 1e9)} GB are there)"
    )


def _amount(x):
    return f"{x:,.0f}" if 100 <= x < 1e15 else f"{x:.3g}"


def _free(path):
    """Bytes that are free where a file will be made."""
    folder = Path(os.path.realpath(path)).parent
    try:
        while not os.path.lexists(folder):
            folder = folder.parent
        tempfile.TemporaryFile(dir=folder).close()  # /proc and the like have no free bytes either
        return shutil.disk_usage(folder).free
    except OSError as error:
        raise InputError(f"cannot write {path}: {error.strerror}") from None


def _memory(config):
    study = studies.find(config)
    steady = config.steady_state
    if config.disk.model is None:
        model = DENSE * NUMBER * config.disk.n_dof**2
    else:
        model = imported.memory(config)
    rows = NUMBER * study.n_tasks(config) if study.compute else SAMPLE * _n_samples(config)
    integration = 0
    if study.integrates:
        grid = cut_revolution(config.speeds.from_hz, time_grid(config))
        records = grid.steps_per_revolution // grid.stride * steady.window_revolutions
        n_points = config.disk.n_points
        integration = NUMBER * (grid.steps_per_block + 2 * records * n_points * WIDTH)
        if config.disk.model is not None:  # of every point on every other, in each direction
            integration += NUMBER * 4 * n_points**2 * WIDTH
    if study.histories:
        records = history.n_records(
            config.speeds.from_hz, config.history.duration_s, time_grid(config)
        )
        integration += NUMBER * records * config.n_coordinates * len(history.LANES)
    return model + rows + integration


def _n_samples(config):
    return len(config.levels) * len(config.samples)
