"""Run time of a sample against the error of what a user reads off: percentiles, peaks, amplitudes.

The response at many speeds is quasi-periodic or chaotic: two runs that differ by rounding end in
other amplitudes there, so errors of single points and of single samples have a floor that no step
lowers. Percentiles over samples average it. The reference is therefore all fine runs together, and
the floor is how far these are from each other.
"""

import itertools
import multiprocessing
import time
from typing import NamedTuple

import numpy as np

from evidence.benchmarks import kernel_speed
from evidence.page import table
from evidence.progress import followed
from hpcrub.contact.status import NOT_STEADY
from hpcrub.response import sweep

N_SAMPLES = 64
N_TUNED = 9  # runs of the tuned disk that differ by rounding: A_nl is relative to their median
SPEEDS = kernel_speed.SPEEDS[::2]
DECILES = tuple(range(10, 100, 10))
FINEST, COARSEST = 1e-6, 4e-5  # [s]; central differences are not stable with the coarsest step
STEPS = (COARSEST, 3.3e-5, 2e-5, 1e-5, 5e-6, FINEST)
NUDGE = 1e-12  # relative change of the blades' stiffness, as small as rounding
PERIODIC = 1e-4  # amplitudes that a nudge changes by less do not depend on rounding
SCHEMES = ("exact_modal", "central_difference")


class Setting(NamedTuple):
    """What is varied."""

    scheme: str = "exact_modal"
    step: float = 3.3e-5
    nudge: float = 0.0

    @property
    def label(self):
        return f"{self.scheme}, {self.step:g} s" + (", nudged" if self.nudge else "")


REFERENCE = Setting(step=FINEST)
FINE = [Setting(scheme=scheme, step=step) for scheme in SCHEMES for step in (5e-6, FINEST)]
DEFAULT = Setting()
NUDGED = Setting(step=1e-5, nudge=NUDGE)


def run_one(task):
    """Amplitudes (S,), wall time and point status of one sample with one setting.

    Negative samples are runs of the tuned disk.
    """
    setting, sample = task
    model = kernel_speed.problem(60, setting.scheme, setting.step)
    nudge = setting.nudge if sample >= 0 else -NUDGE * (sample + 1)
    start = time.perf_counter()
    modes = kernel_speed.modes_of(model.reduced, sample if sample >= 0 else None, nudge)
    result = sweep.run_sweep(modes, model.scene, SPEEDS)
    return result.amplitude, time.perf_counter() - start, result.point_status


def measure():
    """{setting: amplitudes of tuned runs (N_TUNED, S) and samples (N_SAMPLES, S), seconds, ...}."""
    out = {}
    with multiprocessing.get_context("spawn").Pool(2) as pool:
        pool.map(run_one, [(DEFAULT, 0)] * 2)  # compile
        settings = [*itertools.starmap(Setting, itertools.product(SCHEMES, STEPS)), NUDGED]
        settings.remove(Setting("central_difference", COARSEST))
        for setting in followed(settings, "settings", names=[s.label for s in settings]):
            tasks = [(setting, sample) for sample in range(-N_TUNED, N_SAMPLES)]
            answers = pool.map(run_one, tasks, chunksize=1)
            samples = answers[N_TUNED:]
            out[setting] = {
                "tuned": np.array([a[0] for a in answers[:N_TUNED]]),
                "amplitude": np.array([a[0] for a in samples]),
                "seconds": float(np.mean([a[1] for a in samples])),
                "not_steady": float(np.mean([np.mean(a[2] == NOT_STEADY) for a in samples])),
            }
    return out


def peaks(result):
    """Reference amplitude of the tuned disk, and the largest of every sample (n,)."""
    tuned, samples = (np.nanmax(result[name], axis=1) for name in ("tuned", "amplitude"))
    return np.median(tuned), samples


def score(results, setting):
    """Mean magnitude of the errors of the deciles 10 to 90 of A_nl, the tuned disk's included.

    So few samples know these five times better than percentiles 1 and 99, which are single samples.
    """
    fine = [peaks(results[s]) for s in FINE if s != setting]
    reference = np.concatenate([mistuned for _, mistuned in fine]) / np.mean([t for t, _ in fine])
    tuned, mistuned = peaks(results[setting])
    error = np.percentile(mistuned / tuned, DECILES) / np.percentile(reference, DECILES) - 1.0
    return float(np.mean(np.abs(error)))


def section():
    """Parts of the page: all settings, and what rounding alone changes."""
    results = measure()
    exact = peaks(results[REFERENCE])[1]  # of the finest step
    rows = [
        (setting.label + (" (default)" if setting == DEFAULT else ""), f"{r['seconds']:.3f}",
         f"{100 * r['not_steady']:.0f}", f"{100 * score(results, setting):.1f}",
         f"{100 * np.median(np.abs(peaks(r)[1] / exact - 1.0)):.1f}")
        for setting, r in results.items()
    ]  # fmt: skip
    heads = "setting", "s/sample", "not steady %", "deciles of A_nl, %", "sample peak, %"
    as_is, nudged = (results[s]["amplitude"] for s in (NUDGED._replace(nudge=0.0), NUDGED))
    keep = np.mean(np.abs(as_is / nudged - 1.0) < PERIODIC)
    floor = max(score(results, setting) for setting in FINE)  # what scatter alone gives
    facts = [
        [f"points that keep their amplitude to {100 * PERIODIC:g} %", f"{100 * keep:.0f} %"],
        ["floor of the deciles", f"{100 * floor:.1f} %"],
    ]
    return {
        "settings": table(heads, rows),
        "chance": table(["what rounding alone changes", "value"], facts),
    }
