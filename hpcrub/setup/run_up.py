"""What is asked of a run-up, by the limits and intervals of an input."""

import numpy as np

from hpcrub.config import run_up
from hpcrub.config.schema import Config
from hpcrub.response.run_up import Asked


def asked_of(config: Config, spectra: bool = False) -> Asked:
    """What is recorded of a run; spectra: whether spectra of the first repetition, too."""
    limits = config.limits
    amplitude = np.inf if limits.amplitude_mm is None else limits.amplitude
    stress = np.inf
    if limits.stress is not None and limits.stress_mpa_per_mm is not None:
        amplitude = min(amplitude, limits.stress / limits.stress_per_metre)
    elif limits.stress is not None:
        stress = limits.stress
    frequencies = config.spectrum.step_hz * np.arange(config.spectrum.n_frequencies)
    return Asked(
        run_up.intervals(config), config.run_up.repeats, amplitude, stress,
        frequencies if spectra else np.zeros(0),
    )  # fmt: skip
