"""The disks that an input asks for: how their blades are mistuned, and their modes."""

from typing import NamedTuple

import numpy as np

from hpcrub.config.schema import Config
from hpcrub.errors import InputError
from hpcrub.model.mistuning import stiffness_deviation
from hpcrub.model.reduction import Modes, ReducedModel, craig_bampton, mistune, mistuned_modes
from hpcrub.studies import measured
from hpcrub.studies.problem import Model, Problem, build_problem


class Disks(NamedTuple):
    """What simulations of the disks of an input need."""

    problem: Problem
    modes: list[Modes]  # of every disk


def deviation(config: Config, level: int, sample: int) -> np.ndarray:
    """Relative stiffness change of every blade in one sample of one level of the file.

    In the file of a part they have the numbers that they have in the whole study.

    Parameters
    ----------
    level, sample
        Counted in the file.

    Returns
    -------
    ndarray
        (N,) [-]
    """
    if config.pattern_deviation is not None:
        return config.pattern_deviation
    level, sample = config.levels[level], config.samples[sample]
    if config.mistuning.patterns_file is not None:
        return measured.patterns(config)[sample]
    half_range = config.mistuning.half_range[level]
    return stiffness_deviation(
        config.mistuning.seed, level, sample, config.disk.n_blades, half_range, config.mistuning.law
    )


def sigma_of(config: Config) -> np.ndarray:
    """Standard deviation of a blade's stiffness at every level of the file, (V,) [-].

    Of the random draws, or of the blades of an explicit pattern.
    Source: Joachim, Nyssen, Batailly 2020, equation (4).
    """
    if config.pattern_deviation is not None:
        return np.array([np.std(config.pattern_deviation)])
    half_range = config.mistuning.half_range[list(config.levels)]
    if config.mistuning.patterns_file is not None:
        return np.full(len(half_range), np.std(measured.patterns(config)))
    law = config.mistuning.law
    if law.distribution == "uniform":
        return half_range / np.sqrt(3)
    return half_range * law.sigma


def disks(config: Config) -> np.ndarray:
    """Stiffness deviations (D, N) [-]: the tuned disk, and the pattern when there is one.

    Raises InputError for a file of several measured disks.
    """
    tuned = np.zeros(config.disk.n_blades)
    pattern = config.pattern_deviation
    if config.mistuning.patterns_file is not None:
        if config.mistuning.samples != 1:
            raise InputError(
                f"mistuning.patterns_file: {config.mistuning.samples} disks, and a study "
                f"{config.study} is of one; mistuning.samples: 1 takes the first"
            )
        pattern = measured.patterns(config)[0]
    return np.array([tuned] if pattern is None else [tuned, pattern])


def prepare_disks(config: Config) -> Disks:
    """Problem, and modes of the `disks` of an input. Raises InputError as `build_problem`."""
    problem = build_problem(config)
    return Disks(problem, [modes_of(config, problem, found) for found in disks(config)])


def basis_of(
    config: Config, model: Model | Problem, deviation: np.ndarray
) -> tuple[ReducedModel, np.ndarray]:
    """Reduced model of one disk on the basis that the input asks for.

    Parameters
    ----------
    model
        The tuned disk.
    deviation
        Of the blades' stiffness (N,) [-].

    Returns
    -------
    ReducedModel
        On the tuned disk's basis, or on its own.
    ndarray
        Deviation (N,) that is not yet in it [-].
    """
    if config.reduction.basis == "per_sample":
        own = craig_bampton(mistune(model.disk, deviation), config.reduction.n_modes)
        return own, np.zeros(len(deviation))
    return model.reduced, deviation


def modes_of(config: Config, model: Model | Problem, deviation: np.ndarray) -> Modes:
    """Modes of one disk; arguments as `basis_of`."""
    return mistuned_modes(*basis_of(config, model, deviation))
