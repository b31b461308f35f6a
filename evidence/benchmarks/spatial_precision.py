"""Run time against error of the rubbing blisk: which step its amplitudes need."""

import time

import numpy as np

from hpcrub.config.schema import load_runs
from hpcrub.response.sweep import run_sweep
from hpcrub.setup.disks import modes_of
from hpcrub.setup.imported import resolved
from hpcrub.setup.problem import build_problem

INPUT = "inputs/blisk/contact.yaml"
SPEEDS = np.arange(207.0, 219.1, 2.0)  # [Hz] around the peak
STEPS = (1.6e-5, 1.2e-5, 8e-6, 4e-6, 2e-6, 1e-6)  # [s], the last is the reference
SAMPLES = 3  # the first is tuned, the others mistuned by HALF_RANGE
HALF_RANGE = 0.02
NUDGE = 1e-12  # relative change of the blades' stiffness, as small as rounding
PERIODIC = 1e-4  # amplitudes that a nudge changes by less do not depend on rounding


def measure():
    """{step: (seconds a sample, amplitudes (SAMPLES, S))}, the default step, and what is periodic.

    The default is the step that the keys of the section `time` give, when the input sets none, at
    the middle of the speeds.
    """
    given = load_runs(INPUT)[0]
    keys = type(given.time)().model_dump(mode="json")
    scene = build_problem(resolved(given.replace({"time": keys}))).scene
    config = resolved(given)
    default = min(scene.step, 1.0 / (float(SPEEDS.mean()) * scene.least_steps))
    problem = build_problem(config)
    rng = np.random.default_rng(3)
    deviations = HALF_RANGE * rng.uniform(-1.0, 1.0, (SAMPLES, config.disk.n_blades))
    deviations[0] = 0.0

    def amplitudes(step, nudge=0.0):
        scene = problem.scene._replace(step=step, least_steps=0.0)
        start = time.process_time()
        found = [run_sweep(modes_of(config, problem, deviation + nudge), scene, SPEEDS).amplitude
                 for deviation in deviations]  # fmt: skip
        return (time.process_time() - start) / SAMPLES, np.array(found)

    amplitudes(STEPS[0])  # compile
    found = {step: amplitudes(step) for step in sorted({*STEPS, default}, reverse=True)}
    fine = STEPS[-2]
    nudged = amplitudes(fine, NUDGE)[1]
    periodic = np.abs(nudged / found[fine][1] - 1.0) < PERIODIC
    return found, default, periodic


def errors(measured):
    """{step: median and largest error of an amplitude where periodic, median error of the peaks}.

    Against the finest step.
    """
    found, _, periodic = measured
    known = found[min(found)][1]
    out = {}
    for step, (_, amplitude) in found.items():
        off = np.abs(amplitude / known - 1.0)
        peaks = np.abs(np.nanmax(amplitude, axis=1) / np.nanmax(known, axis=1) - 1.0)
        here = off[periodic]
        worst = (np.median(here), here.max()) if here.size else (np.nan, np.nan)
        out[step] = *worst, np.median(peaks)
    return out
