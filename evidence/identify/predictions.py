"""What the search never saw: more samples of one disk at the program's usual settings.

The speeds are those of table 3, 0.05 Hz apart, and motions have 2 s to become steady.
"""

import numpy as np

from evidence.identify import disks, stages
from hpcrub.model.mistuning import stiffness_deviation
from hpcrub.model.reduction import mistuned_modes
from hpcrub.response.sweep import run_sweep
from hpcrub.studies.contact.amplification import peak

RANGES = {3: (44.5, 47.5), 4: (33.5, 35.5), 6: (22.0, 23.0)}  # [Hz], table 3
N_SAMPLES = {3: 12, 4: 30, 6: 12}
N_TUNED = 9
LONGEST = 2.0  # [s]
SECOND = np.arange(62.0, 75.1, 0.25)  # [Hz] around the second interaction of figure 6


def measure(dimensions, draw):
    """Numbers of the statements that took no part in the search: some minutes.

    Parameters
    ----------
    dimensions : Dimensions
    draw : int

    Returns
    -------
    dict
    """
    reduced = disks.reduced(dimensions)
    reference = _tuned(reduced, draw)
    found, times = {}, []
    for n in RANGES:
        for level, half_range in (("06", 0.01), ("23", 0.04)):
            mm, at, simulated = _samples(reduced, n, half_range, draw, N_SAMPLES[n])
            times += simulated
            found[f"edge_{n}_{level}"] = 100 * np.mean(np.isin(at, np.array(RANGES[n])))
            found[f"mm_{n}_{level}"] = np.percentile(mm, 99)
            if n == 4:
                found[f"a_nl_50_{level}"] = np.median(mm) / reference
                found[f"a_nl_99_{level}"] = np.percentile(mm, 99) / reference
    low = _samples(reduced, 4, 0.04, draw, N_SAMPLES[4], stages.LESS_DAMPING)[0]
    low_reference = _tuned(reduced, draw, stages.LESS_DAMPING)
    found["a_nl_99_less_damping"] = np.percentile(low, 99) / low_reference
    found["time_s"] = np.mean(times)
    response = run_sweep(
        mistuned_modes(reduced, np.zeros(stages.N_BLADES)), stages.scene_of(4), SECOND
    )
    found["second_hz"] = peak(response, SECOND)[1]
    return found


def _samples(reduced, n, half_range, draw, n_samples, damping_ratio=None):
    """Peaks [mm] and their speeds [Hz] of random samples, and mean simulated times [s]."""
    deviations = (
        stiffness_deviation(stages.SEED + draw, n, sample, stages.N_BLADES, half_range)
        for sample in range(n_samples)
    )
    return _responses(reduced, n, deviations, damping_ratio)


def _tuned(reduced, draw, damping_ratio=None):
    """Median peak of the tuned disk's perturbed runs, n_d = 4 [mm]."""
    runs = (
        np.full(stages.N_BLADES, stages.perturbation(draw, run, N_TUNED)) for run in range(N_TUNED)
    )
    return np.median(_responses(reduced, 4, runs, damping_ratio)[0])


def _responses(reduced, n, deviations, damping_ratio):
    scene = stages.scene_of(n, damping_ratio, LONGEST)
    low, high = RANGES[n]
    speeds = np.round(np.arange(low, high + 0.01, 0.05), 10)
    mm, at, times = [], [], []
    for deviation in deviations:
        response = run_sweep(mistuned_modes(reduced, deviation), scene, speeds)
        amplitude, speed = peak(response, speeds)
        mm.append(1e3 * amplitude)
        at.append(speed)
        times.append(response.time.mean())
    return mm, at, times
