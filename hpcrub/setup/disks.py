"""The disks of an input: stiffness deviations of their blades, and their modes."""

from typing import NamedTuple

import numpy as np

from hpcrub.config.schema import Config
from hpcrub.errors import InputError
from hpcrub.model.mistuning import RUNS, stiffness_deviation, uniform
from hpcrub.model.reduction import Modes, mistuned_modes
from hpcrub.setup import input_files
from hpcrub.setup.problem import FURTHEST, Model, Problem

# Relative change of stiffness from run to run of one disk. It is far too small to matter for a
# structure, and large enough for a chaotic motion to take another course before it is judged. (With
# 1e-6 all runs were still the same when they ended by the rule of the paper.)
BETWEEN_RUNS = 3e-5
# Largest deviation of single blades in the runs of one disk. From it a wave that breaks the
# symmetry takes 9 time constants of its growth to show, from rounding 37.
BETWEEN_BLADES = 1e-4
GOLDEN = 0.5 * (5.0**0.5 - 1.0)  # its multiples fill a range evenly, however many there are


class Disks(NamedTuple):
    """Problem and modes for simulations of the disks of an input."""

    problem: Problem
    modes: list[Modes]  # of every disk, as `rubbing_modes`


def run_deviation(config: Config, run: int) -> np.ndarray:
    """Relative change of the blades' stiffness in a run of one disk (N,) [-].

    By `mistuning.reference` the blades differ by up to BETWEEN_BLADES, or all are stiffer by one
    share, from 0 up to FURTHEST. Then the first ten runs are BETWEEN_RUNS from each other, and all
    later ones lie between them: with stiffer and stiffer disks the amplitude of a motion that
    repeats itself would follow the stiffness.
    """
    n_blades = config.disk.n_blades
    if config.mistuning.reference == "staying":
        return BETWEEN_BLADES * uniform(config.mistuning.seed, RUNS, 0, run, n_blades)
    block, place = divmod(run, round(FURTHEST / BETWEEN_RUNS))
    return np.full(n_blades, BETWEEN_RUNS * (place + GOLDEN * block % 1.0))


def deviation(config: Config, level: int, sample: int) -> np.ndarray:
    """Relative stiffness deviation of every blade in a sample on a level.

    The samples of an explicit pattern are runs of one disk (`run_deviation`).
    A part of a study draws a sample as the whole study does.
    level, sample: indices in the result file. Returns (N,) [-].
    """
    sample = config.samples[sample]
    if config.pattern_deviation is not None:
        return config.pattern_deviation + run_deviation(config, sample)
    if config.mistuning.pattern_file is not None:
        return input_files.patterns(config)[sample]
    half_range = config.mistuning.half_range[level]
    return stiffness_deviation(
        config.mistuning.seed, level, sample, config.disk.n_blades, half_range, config.mistuning.law
    )


def sigma_of(config: Config) -> np.ndarray:
    """Standard deviation of a blade's stiffness on every level of the file, (V,) [-].

    An explicit pattern has the standard deviation of its blades, and an intentional one beneath
    random deviations adds its own variance to theirs.
    Source: Joachim, Nyssen, Batailly 2020, equation (4).
    """
    if config.pattern_deviation is not None:
        return np.array([np.std(config.pattern_deviation)])
    half_range, law = config.mistuning.half_range, config.mistuning.law
    beneath = float(np.std(law.intentional or (0.0,)))  # the blades hold whole repetitions
    if config.mistuning.pattern_file is not None:
        return np.full(len(half_range), np.std(input_files.patterns(config)))
    return np.hypot(half_range * law.sigma, beneath)


def fixed_disks(config: Config) -> np.ndarray:
    """Stiffness deviations (D, N) [-] of the tuned disk and, if given, of the pattern.

    Both are the first of their runs (`run_deviation`).
    Raises InputError for a file of several measured disks.
    """
    tuned, pattern = run_deviation(config, 0), config.pattern_deviation
    if config.mistuning.pattern_file is not None:
        if config.mistuning.samples != 1:
            raise InputError(
                f"mistuning.pattern: {config.mistuning.samples} disks, and a study "
                f"{config.study} is of one; mistuning.samples: 1 takes the first"
            )
        return np.array([tuned, input_files.patterns(config)[0]])
    return np.array([tuned] if pattern is None else [tuned, pattern + tuned])


def modes_of(
    config: Config, model: Model | Problem, deviation: np.ndarray, speed: float | None = None
) -> Modes:
    """Modes of one disk; deviation: relative, of the blades' stiffness (N,) [-].

    speed: of rotation, for frequencies and shapes [rad/s]; None: that of the reduced model.
    Raises InputError when blades deviate and the model file lacks their stiffness.
    """
    _require_blades(config, model, deviation)
    return mistuned_modes(model.reduced, deviation, speed)


def rubbing_modes(config: Config, problem: Problem, deviation: np.ndarray) -> Modes:
    """Modes with which one disk is integrated in time: of its own, or those that samples share.

    deviation: as in `modes_of`. Raises InputError likewise.
    """
    if problem.basis is None:
        return modes_of(config, problem, deviation)
    _require_blades(config, problem, deviation)
    return problem.basis.modes_of(deviation)


def own_modes_of(
    config: Config, problem: Problem, rubbing: Modes | None, deviation: np.ndarray
) -> Modes:
    """Modes of one disk itself, which its `rubbing_modes` are unless these are shared.

    rubbing: these, or None where they are not at hand; deviation: as in `modes_of`.
    """
    at_hand = rubbing is not None and rubbing.blades is None
    return rubbing if rubbing and at_hand else modes_of(config, problem, deviation)


def _require_blades(config: Config, model: Model | Problem, deviation: np.ndarray) -> None:
    if np.abs(deviation).max() > FURTHEST and not model.reduced.modal_blade_stiffness.any():
        raise InputError(f"disk.model: {config.disk.model} has no K_blade, blades are all alike")
