"""What samples and parts of samples cost here, in seconds of processor time."""

import time
from typing import NamedTuple

import numpy as np

from hpcrub.response import sweep
from hpcrub.setup.disks import deviation, modes_of
from hpcrub.setup.problem import build_problem
from hpcrub.studies.contact import amplification
from hpcrub.studies.contact.tasks import most_parts


class Costs(NamedTuple):
    """Costs of some samples of one case."""

    whole: np.ndarray  # (n,) sweeps [s]
    parts: list  # of every sample: {number of parts: [seconds of each part]}
    speeds: np.ndarray  # (k,) sweeps of single speeds [s]
    finish: float  # eigenproblem and linear peak [s]


def measure(config, n_samples):
    """Costs of the first samples of all levels of a case."""
    problem, speeds = build_problem(config), config.speeds.values_hz
    whole, parts, finish = [], [], []
    n_levels = len(config.mistuning.half_range)
    for number in range(n_samples):
        blades = deviation(config, number % n_levels, number // n_levels)
        start = time.process_time()
        modes = modes_of(config, problem, blades)
        amplification.linear_amplitude(config, problem, modes, blades)
        finish.append(time.process_time() - start)

        def takes(selection, modes=modes):
            start = time.process_time()
            sweep.run_sweep(modes, problem.scene, speeds, lambda: None, selection=selection)
            return time.process_time() - start

        whole.append(takes(None))
        parts.append({n: [takes(range(part, len(speeds), n)) for part in range(n)]
                      for n in range(2, most_parts(len(speeds)) + 1)})  # fmt: skip
    single = [takes([i]) for i in range(0, len(speeds), 4)]
    return Costs(np.array(whole), parts, np.array(single), float(np.median(finish)))
