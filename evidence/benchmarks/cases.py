"""The cases that all benchmarks share: the reference disk with four bumps, and mistuned samples."""

import numpy as np

from hpcrub.config.schema import Config
from hpcrub.model.mistuning import stiffness_deviation
from hpcrub.model.reduction import mistuned_modes
from hpcrub.setup.problem import build_problem

SPEEDS = np.round(np.arange(33.5, 35.501, 0.05), 10)  # [Hz], as in the paper
HALF_RANGE = 0.03  # mistuning level 1.7 %


def problem(n_modes=60, scheme="exact_modal", step=3.3e-5):
    """Reduced model and scene of the reference disk."""
    keys = {"reduction.n_modes": n_modes, "time.scheme": scheme, "time.step_s": step}
    return build_problem(Config().replace(keys))


def modes_of(reduced, sample, nudge=0.0):
    """Modes of a mistuned sample, of the tuned disk for None; all blades stiffer by ``nudge``."""
    n_blades = len(reduced.blade_stiffness)
    deviation = np.zeros(n_blades)
    if sample is not None:
        deviation = stiffness_deviation(2020, 0, sample, n_blades, HALF_RANGE)
    return mistuned_modes(reduced, deviation + nudge)
