"""`Config` → what a study computes with: disk, reduced model, scene; the modes of any sample."""

from typing import NamedTuple

import numpy as np

from hpcrub.contact.status import NOT_STEADY, STEADY
from hpcrub.errors import InputError
from hpcrub.model.disk import Disk, build_disk
from hpcrub.model.mistuning import stiffness_deviation
from hpcrub.model.reduction import ReducedModel, craig_bampton, mistune, mistuned_modes
from hpcrub.response import sweep
from hpcrub.response.linear import linear_peak
from hpcrub.response.steady import SteadyCriteria


class Model(NamedTuple):
    """The tuned disk, full and reduced."""

    disk: Disk
    reduced: ReducedModel


class Problem(NamedTuple):
    """What every rank needs in order to compute any sample."""

    disk: Disk
    reduced: ReducedModel
    scene: sweep.Scene
    stability_limit: float  # of the time step, for the stiffest sample [s]


def build_model(config):
    """Model of a configuration. Raises InputError for an impossible geometry."""
    try:
        disk = build_disk(config.disk, config.material)
        return Model(disk, craig_bampton(disk, config.reduction.n_modes))
    except (ValueError, np.linalg.LinAlgError) as error:
        raise InputError(f"disk: {error}") from None


def build_problem(config):
    """Tuned disk, reduced model and scene of a configuration.

    Raises InputError for an impossible geometry and for a time step above the stability limit.
    """
    disk, reduced = build_model(config)
    # K = K0 + sum_i d_i K_i <= (1 + max d) K0, hence omega <= omega_tuned sqrt(1 + max d)
    pattern = config.pattern_deviation
    stiffest = max(0.0, np.max(config.mistuning.half_range if pattern is None else pattern))
    limit = 2.0 / np.sqrt(reduced.tuned_eigenvalues[-1] * (1.0 + stiffest))
    if config.time.scheme == "central_difference" and not config.time.step < limit:
        raise InputError(
            f"time.step_s: {config.time.step:g} is not below {limit:.4g} s, the stability limit "
            "of central_difference for this model"
        )
    return Problem(disk, reduced, _scene(config, reduced), float(limit))


def _scene(config, reduced):
    steady = config.steady_state
    return sweep.Scene(
        interface=reduced.interface,
        damping_ratio=config.material.damping_ratio,
        n_bumps=config.casing.n_bumps,
        bump_height=config.casing.bump_height,
        clearance=config.casing.clearance,
        ramp_time=config.casing.growth_time,
        friction=config.contact.friction,
        kinematics=config.contact.kinematics,
        scheme=config.time.scheme,
        step=config.time.step,
        steady=SteadyCriteria(
            first_check=steady.first_check,
            window_revolutions=steady.window_revolutions,
            extend_revolutions=steady.extend_revolutions,
            min_correlation=steady.min_correlation,
            max_amplitude_change=steady.max_amplitude_change,
            max_time=steady.max_time,
            confirmations=steady.confirmations,
        ),
    )


def peak(result, speeds_hz):
    """Largest amplitude of a SweepResult [m] and its speed [Hz]; NaN when all points diverged."""
    usable = np.isin(result.point_status, (STEADY, NOT_STEADY)) & np.isfinite(result.amplitude)
    if not usable.any():
        return np.nan, np.nan
    best = np.argmax(np.where(usable, result.amplitude, -np.inf))
    return float(result.amplitude[best]), float(speeds_hz[best])


def deviation(config, level, sample):
    """Relative stiffness change of every blade (N,) in one sample of one level of the file.

    In the file of a part they have the numbers that they have in the whole study.
    """
    if config.pattern_deviation is not None:
        return config.pattern_deviation
    level, sample = config.levels[level], config.samples[sample]
    half_range = config.mistuning.half_range[level]
    return stiffness_deviation(
        config.mistuning.seed, level, sample, config.disk.n_blades, half_range
    )


def basis_of(config, model, deviation):
    """Reduced model of one disk on the basis that the input asks for.

    model: Model or Problem; deviation: (N,) of the blades [-].
    Returns a ReducedModel and the deviation (N,) that is not yet in it.
    """
    if config.reduction.basis == "per_sample":
        own = craig_bampton(mistune(model.disk, deviation), config.reduction.n_modes)
        return own, np.zeros(len(deviation))
    return model.reduced, deviation


def sigma_of(config):
    """Standard deviation of a blade's stiffness at every level of the file (V,) [-].

    Of the random draws, or of the blades of an explicit pattern.
    Source: Joachim, Nyssen, Batailly 2020, equation (4).
    """
    if config.pattern_deviation is not None:
        return np.array([np.std(config.pattern_deviation)])
    return config.mistuning.half_range[list(config.levels)] / np.sqrt(3)


def modes_of(config, model, deviation):
    """Modes of one disk; arguments as `basis_of`."""
    return mistuned_modes(*basis_of(config, model, deviation))


def linear_amplitude(config, problem, modes):
    """Largest tip displacement under the linear engine-order excitation of a configuration [m]."""
    scene = problem.scene
    load = config.forcing.amplitude, scene.n_bumps, scene.interface
    return linear_peak(modes, scene.damping_ratio, *load, config.disk.n_blades)[0]


def point_values(result):
    """Arrays of a SweepResult by their names in the result file."""
    return {
        "amplitude_m": result.amplitude,
        "time_s": result.time,
        "localisation": result.localisation,
        "point_status": result.point_status,
        "point_reason": result.point_reason,
        "max_sweeps": result.max_sweeps,
    }
