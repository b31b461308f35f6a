"""Run time of a sample against the error of what a user reads off: percentiles, peaks, amplitudes.

The response at many speeds is quasi-periodic or chaotic: two runs that differ by rounding end in
other amplitudes there, so errors of single points and of single samples have a floor that no step
lowers. Percentiles over samples average it. The floor is measured by `FLOOR`: the finest step once
more with the other scheme.
"""

import multiprocessing
import time
from typing import NamedTuple

import numpy as np

from benchmarks import cases
from hpcrub import sweep

N_SAMPLES = 64
SPEEDS = cases.SPEEDS[::2]
PERCENTILES = (1, 50, 99)
STEPS = (4e-5, 2e-5, 1e-5, 5e-6, 1e-6)
N_MODES = (12, 24, 36, 84, 120)
NUDGE = 1e-12  # relative change of the blades' stiffness, as small as rounding
PERIODIC = 1e-4  # amplitudes that a nudge changes by less belong to periodic motions


class Setting(NamedTuple):
    """What is varied."""

    scheme: str = "exact_modal"
    step: float = 2e-5
    n_modes: int = 60
    search: str = "full"
    max_time: float = 2.0
    nudge: float = 0.0

    @property
    def label(self):
        changed = [self.search] if self.search != "full" else []
        changed += [f"η = {self.n_modes}"] if self.n_modes != 60 else []
        changed += [f"cap {self.max_time:g} s"] if self.max_time != 2.0 else []
        changed += ["nudged"] if self.nudge else []
        return ", ".join([self.scheme, f"{self.step:g} s", *changed])


REFERENCE = Setting(step=1e-6)
FLOOR = Setting(scheme="central_difference", step=1e-6)
DEFAULT = Setting()
NUDGED = Setting(step=1e-5, nudge=NUDGE)
SETTINGS = [
    *[Setting(step=step) for step in STEPS],
    *[Setting(scheme="central_difference", step=step) for step in STEPS[1:]],
    *[Setting(n_modes=n_modes) for n_modes in N_MODES],
    *[Setting(step=step, search="peak") for step in (4e-5, 2e-5)],
    *[Setting(step=step, max_time=5.0) for step in (4e-5, 2e-5)],
    NUDGED,
]


def run_one(task):
    """Amplitudes (S,), wall time and simulated time of one sample with one setting."""
    setting, sample = task
    model = cases.problem(setting.n_modes, setting.scheme, setting.step)
    steady = model.scene.steady._replace(max_time=setting.max_time)
    scene = model.scene._replace(steady=steady)
    march = sweep.find_peak if setting.search == "peak" and sample is not None else sweep.run_sweep
    start = time.perf_counter()
    result = march(cases.modes_of(model.reduced, sample, setting.nudge), scene, SPEEDS)
    return result.amplitude, time.perf_counter() - start, result.time.sum(), result.point_status


def measure(pool, n_samples=N_SAMPLES):
    """{setting: amplitudes (1 + n, S) with the tuned disk first, seconds per sample, …}."""
    pool.map(run_one, [(DEFAULT, None)] * 2)  # compile
    out = {}
    for setting in SETTINGS:
        answers = pool.map(run_one, [(setting, s) for s in (None, *range(n_samples))], chunksize=1)
        out[setting] = {
            "amplitude": np.array([a[0] for a in answers]),
            "seconds": float(np.mean([a[1] for a in answers[1:]])),
            "simulated": float(np.mean([a[2] for a in answers[1:]])) / len(SPEEDS),
            "not_steady": float(np.mean([np.mean(a[3] == sweep.NOT_STEADY) for a in answers[1:]])),
        }
        print(f"  {setting.label}: {out[setting]['seconds']:.3f} s a sample", flush=True)
    return out


def peaks(amplitude):
    """Largest amplitude of the tuned disk and of every sample."""
    top = np.nanmax(amplitude, axis=1)
    return top[0], top[1:]


def compare(results, setting, n_boot=400):
    """Errors of a setting against the reference, as relative numbers."""
    tuned, mistuned = peaks(results[setting]["amplitude"])
    tuned_ref, mistuned_ref = peaks(results[REFERENCE]["amplitude"])
    rng = np.random.default_rng(0)
    draws = rng.integers(0, len(mistuned), (n_boot, len(mistuned)))

    def ratio(a, b):
        return np.percentile(a, PERCENTILES, axis=-1) / np.percentile(b, PERCENTILES, axis=-1) - 1.0

    boot = ratio(mistuned[draws], mistuned_ref[draws])
    points = results[setting]["amplitude"] / results[REFERENCE]["amplitude"] - 1.0
    return {
        "amplitude_percentiles": ratio(mistuned, mistuned_ref),
        "interval": np.percentile(boot, (2.5, 97.5), axis=1),
        "amplification_percentiles": ratio(mistuned / tuned, mistuned_ref / tuned_ref),
        "tuned": tuned / tuned_ref - 1.0,
        "sample_median": np.median(np.abs(mistuned / mistuned_ref - 1.0)),
        "missed": np.mean(np.isnan(results[setting]["amplitude"][1:]))
        if setting.search == "peak"
        else 0.0,
        "periodic": np.median(np.abs(points[1:][periodic(results)])),
    }


def periodic(results):
    """Mask of the points (n, S) of the mistuned samples that do not depend on rounding."""
    both = NUDGED._replace(nudge=0.0), NUDGED
    a, b = (results[setting]["amplitude"][1:] for setting in both)
    return np.abs(a / b - 1.0) < PERIODIC


def order(results, scheme):
    """Fitted order of the amplitude error at periodic points, finest step left out."""
    steps = list(STEPS[1:-1])
    errors = [compare(results, Setting(scheme=scheme, step=step))["periodic"] for step in steps]
    return float(np.polyfit(np.log(steps), np.log(errors), 1)[0])


def pool_of_two():
    return multiprocessing.get_context("spawn").Pool(2)
