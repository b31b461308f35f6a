"""What samples, parts of samples and messages cost here, in seconds of processor time."""

import pickle
import time
from typing import NamedTuple

import numpy as np

from hpcrub.config.schema import Config
from hpcrub.ranks.parallel import Team
from hpcrub.ranks.schedule import Sample, most_parts
from hpcrub.response import sweep
from hpcrub.results.layout import DONE
from hpcrub.studies import contact
from hpcrub.studies.problem import build_problem
from hpcrub.studies.samples import deviation, modes_of

CASES = {  # n_d: speeds, as in the paper
    3: {"from_hz": 44.5, "to_hz": 47.5, "step_hz": 0.05},
    4: {"from_hz": 33.5, "to_hz": 35.5, "step_hz": 0.05},
    5: {"from_hz": 26.7, "to_hz": 28.2, "step_hz": 0.05},
    6: {"from_hz": 22.0, "to_hz": 23.0, "step_hz": 0.05},
}


class Costs(NamedTuple):
    """Costs of some samples of one case."""

    whole: np.ndarray  # (n,) sweeps [s]
    parts: list  # of every sample: {number of parts: [seconds of each part]}
    polls: np.ndarray  # (m,) time from one poll to the next [s]
    speeds: np.ndarray  # (k,) sweeps of single speeds [s]
    steps: int  # time steps of all samples
    finish: float  # eigenproblem and linear peak [s]


def configuration(n_bumps, samples=5000):
    """Config of one case of the paper's study."""
    return Config.model_validate(
        {
            "casing": {"n_bumps": n_bumps},
            "speeds": CASES[n_bumps],
            "mistuning": {"half_range_percent": [1, 2, 3, 4], "samples": samples},
        }
    )


def measure(n_bumps, n_samples):
    """Costs of the first samples of all levels of a case."""
    config = configuration(n_bumps)
    problem, speeds = build_problem(config), config.speeds.values_hz
    whole, parts, polls, n_steps, finish = [], [], [], 0, []
    for number in range(n_samples):
        blades = deviation(config, number % 4, number // 4)
        start = time.process_time()
        modes = modes_of(config, problem, blades)
        contact.linear_amplitude(config, problem, modes)
        finish.append(time.process_time() - start)
        ticks = [time.process_time()]

        def poll(ticks=ticks):
            ticks.append(time.process_time())

        n_steps += sweep.run_sweep(modes, problem.scene, speeds, poll).n_steps
        whole.append(time.process_time() - ticks[0])
        polls.extend(np.diff(ticks))
        most = most_parts(len(speeds))
        parts.append({n: _cut(modes, problem.scene, speeds, n) for n in range(2, most + 1)})
    single = [_seconds(modes, problem.scene, speeds, [i]) for i in range(0, len(speeds), 4)]
    found = map(np.array, (whole, polls, single))
    whole, polls, single = found
    return Costs(whole, parts, polls, single, n_steps, float(np.median(finish)))


def _cut(modes, scene, speeds, n):
    return [_seconds(modes, scene, speeds, range(part, len(speeds), n)) for part in range(n)]


def _seconds(modes, scene, speeds, selection):
    start = time.process_time()
    sweep.run_sweep(modes, scene, speeds, lambda: None, selection=selection)
    return time.process_time() - start


def noting(n=4000):
    """Seconds that rank 0 needs to take note of one finished sample."""
    study = contact.MonteCarlo(contact.STUDY, Team(), configuration(4), None, None)
    study.status = np.zeros(study.shape, np.uint8)
    study.amplification = np.full((2, *study.shape), np.nan)
    outcome = contact.Outcome(DONE, 1.0, 1.0, 10**6, 0.3, 1e-3)
    start = time.process_time()
    for number in range(n):
        study._collect(Sample(number % 4, number // 4), outcome)
    return (time.process_time() - start) / n


def sizes():
    """Bytes of a message with one task, and with one result."""
    outcome = contact.Outcome(DONE, 1.0, 1.0, 10**6, 0.3, 1e-3)
    messages = ("tasks", [Sample(1, 1000)]), (500, "ask", [outcome])
    return [len(pickle.dumps(message)) for message in messages]
