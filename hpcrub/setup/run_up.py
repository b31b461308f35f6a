"""What is asked of a run-up, by the limits and intervals of an input."""

import numpy as np

from hpcrub.config import run_up
from hpcrub.config.schema import Config
from hpcrub.response.revolution import cut_revolution
from hpcrub.response.run_up import Asked
from hpcrub.setup.problem import scene_of


def steps_of_disk(config: Config) -> float:
    """Time steps of all runs of a disk, of all lanes together."""
    scene = scene_of(config)
    per_turn = cut_revolution(min(run_up.ends_of(config)), scene).steps_per_revolution
    turns = sum(run.turned[-1] for run in run_up.schedules(config))
    return float(turns * per_turn * scene.lanes[0])


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
