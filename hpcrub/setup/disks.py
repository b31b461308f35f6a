"""The disks that an input asks for: how their blades are mistuned, and their modes."""

from typing import NamedTuple

import numpy as np

from hpcrub.config.schema import Config
from hpcrub.errors import InputError
from hpcrub.model.mistuning import stiffness_deviation
from hpcrub.model.reduction import Modes, mistuned_modes
from hpcrub.setup import input_files
from hpcrub.setup.problem import Model, Problem, build_problem

# Relative change of stiffness from run to run of one disk: far too small to matter for a structure,
# enough for another course of a motion that never repeats, before it is judged. (With 1e-6 all runs
# were still the same when they ended.)
APART = 3e-5


class Disks(NamedTuple):
    """What simulations of the disks of an input need."""

    problem: Problem
    modes: list[Modes]  # of every disk


def deviation(config: Config, level: int, sample: int) -> np.ndarray:
    """Relative stiffness change of every blade in one sample of one level of the file.

    The samples of an explicit pattern are runs of it, each a little stiffer than the one before.
    In the file of a part they have the numbers that they have in the whole study.
    level, sample: counted in the file. Returns (N,) [-].
    """
    sample = config.samples[sample]
    if config.pattern_deviation is not None:
        return config.pattern_deviation + APART * sample
    if config.mistuning.pattern_file is not None:
        return input_files.patterns(config)[sample]
    half_range = config.mistuning.half_range[level]
    return stiffness_deviation(
        config.mistuning.seed, level, sample, config.disk.n_blades, half_range, config.mistuning.law
    )


def sigma_of(config: Config) -> np.ndarray:
    """Standard deviation of a blade's stiffness at every level of the file, (V,) [-].

    It is that of the random draws, or of the blades of an explicit pattern.
    Source: Joachim, Nyssen, Batailly 2020, equation (4).
    """
    if config.pattern_deviation is not None:
        return np.array([np.std(config.pattern_deviation)])
    half_range, law = config.mistuning.half_range, config.mistuning.law
    if config.mistuning.pattern_file is not None:
        return np.full(len(half_range), np.std(input_files.patterns(config)))
    return half_range / np.sqrt(3) if law.distribution == "uniform" else half_range * law.sigma


def disks(config: Config) -> np.ndarray:
    """Stiffness deviations (D, N) [-]: the tuned disk, and the pattern when there is one.

    Raises InputError for a file of several measured disks.
    """
    tuned = np.zeros(config.disk.n_blades)
    pattern = config.pattern_deviation
    if config.mistuning.pattern_file is not None:
        if config.mistuning.samples != 1:
            raise InputError(
                f"mistuning.pattern: {config.mistuning.samples} disks, and a study "
                f"{config.study} is of one; mistuning.samples: 1 takes the first"
            )
        pattern = input_files.patterns(config)[0]
    return np.array([tuned] if pattern is None else [tuned, pattern])


def prepare_disks(config: Config) -> Disks:
    """Problem, and modes of the `disks` of an input. Raises InputError as `build_problem`."""
    problem = build_problem(config)
    return Disks(problem, [modes_of(config, problem, found) for found in disks(config)])


def modes_of(config: Config, model: Model | Problem, deviation: np.ndarray) -> Modes:
    """Modes of one disk; deviation: that of the blades' stiffness (N,) [-].

    Raises InputError when the model file does not tell the stiffness of blades that deviate.
    """
    if np.any(deviation) and not model.reduced.modal_blade_stiffness.any():
        raise InputError(f"disk.model: {config.disk.model} has no K_blade, blades are all alike")
    return mistuned_modes(model.reduced, deviation)
