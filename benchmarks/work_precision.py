"""Run time of a sample against the error of what a user reads off: percentiles, peaks, amplitudes.

The response at many speeds is quasi-periodic or chaotic: two runs that differ by rounding end in
other amplitudes there, so errors of single points and of single samples have a floor that no step
lowers. Percentiles over samples average it. The reference is therefore all fine runs together, and
the floor is how far these are from each other. What a step does to the percentiles is smaller than
that: `bias` finds it in pairs of the same samples, more of them.
"""

import multiprocessing
import time
from typing import NamedTuple

import numpy as np

from benchmarks import cases
from hpcrub import sweep

N_SAMPLES, MORE_SAMPLES = 64, 256
N_TUNED = 9  # runs of the tuned disk that differ by rounding; A_nl is relative to their median
SPEEDS = cases.SPEEDS[::2]
PERCENTILES = (1, 50, 99)
DECILES = tuple(range(10, 100, 10))
STEPS = (4e-5, 3.3e-5, 2e-5, 1e-5, 5e-6, 1e-6)
N_MODES = (12, 24, 36, 84, 120)
NUDGE = 1e-12  # relative change of the blades' stiffness, as small as rounding
PERIODIC = 1e-4  # amplitudes that a nudge changes by less belong to periodic motions


SCHEMES = ("exact_modal", "central_difference")
TUNED_SPEEDS = np.array([33.25, 33.5, 33.6])  # [Hz] the tuned disk is periodic there


class Setting(NamedTuple):
    """What is varied."""

    scheme: str = "exact_modal"
    step: float = 3.3e-5
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
FINE = [Setting(scheme=scheme, step=step) for scheme in SCHEMES for step in (5e-6, 1e-6)]
DEFAULT = Setting()
NUDGED = Setting(step=1e-5, nudge=NUDGE)
SETTINGS = [
    *[Setting(step=step) for step in STEPS],
    *[Setting(scheme="central_difference", step=step) for step in STEPS[2:]],
    *[Setting(n_modes=n_modes) for n_modes in N_MODES],
    *[Setting(step=step, search="peak") for step in (4e-5, 3.3e-5)],
    *[Setting(step=step, max_time=5.0) for step in (3.3e-5, 2e-5)],
    NUDGED,
]
PAIRED = [Setting(step=step) for step in STEPS[:4]]  # the last, with NUDGED, is their reference


def run_one(task):
    """Amplitudes (S,), wall time and simulated time of one sample with one setting.

    Negative samples are runs of the tuned disk.
    """
    setting, sample = task
    model = cases.problem(setting.n_modes, setting.scheme, setting.step)
    steady = model.scene.steady._replace(max_time=setting.max_time)
    scene = model.scene._replace(steady=steady)
    march = sweep.find_peak if setting.search == "peak" and sample >= 0 else sweep.run_sweep
    nudge = setting.nudge if sample >= 0 else -NUDGE * (sample + 1)
    start = time.perf_counter()
    modes = cases.modes_of(model.reduced, sample if sample >= 0 else None, nudge)
    result = march(modes, scene, SPEEDS)
    return result.amplitude, time.perf_counter() - start, result.time.sum(), result.point_status


def measure(pool, n_samples=N_SAMPLES):
    """{setting: amplitudes (N_TUNED + n, S) with the tuned disk first, seconds per sample, …}."""
    pool.map(run_one, [(DEFAULT, 0)] * 2)  # compile
    out = {}
    for setting in SETTINGS:
        n = MORE_SAMPLES if setting in (*PAIRED, NUDGED) else n_samples
        answers = pool.map(run_one, [(setting, s) for s in range(-N_TUNED, n)], chunksize=1)
        out[setting] = {
            "amplitude": np.array([a[0] for a in answers]),
            "seconds": float(np.mean([a[1] for a in answers[N_TUNED:]])),
            "simulated": float(np.mean([a[2] for a in answers[N_TUNED:]])) / len(SPEEDS),
            "not_steady": float(
                np.mean([np.mean(a[3] == sweep.NOT_STEADY) for a in answers[N_TUNED:]])
            ),
        }
        print(f"  {setting.label}: {out[setting]['seconds']:.3f} s a sample", flush=True)
    return out


def peaks(amplitude):
    """Reference amplitude of the tuned disk, and the largest of N_SAMPLES samples."""
    top = np.nanmax(amplitude, axis=1)
    return np.median(top[:N_TUNED]), top[N_TUNED : N_TUNED + N_SAMPLES]


def compare(results, setting, n_boot=400):
    """Errors of a setting against the fine runs together, as relative numbers."""
    tuned, mistuned = peaks(results[setting]["amplitude"])
    fine = [peaks(results[s]["amplitude"]) for s in FINE if s != setting]
    reference = np.percentile(np.concatenate([samples for _, samples in fine]), PERCENTILES)
    tuned_fine = np.mean([tuned for tuned, _ in fine])
    draws = np.random.default_rng(0).integers(0, len(mistuned), (n_boot, len(mistuned)))
    boot = np.percentile(mistuned[draws], PERCENTILES, axis=1).T / reference - 1.0
    error = np.percentile(mistuned, PERCENTILES) / reference - 1.0
    each = peaks(results[REFERENCE]["amplitude"])[1]
    return {
        "amplitude_percentiles": error,
        "interval": np.percentile(boot, (2.5, 97.5), axis=0),
        "amplification_percentiles": (1.0 + error) * tuned_fine / tuned - 1.0,
        "tuned": tuned / tuned_fine - 1.0,
        "sample_median": np.median(np.abs(mistuned / each - 1.0)),
    }


def score(results, setting):
    """Mean magnitude of the errors of the deciles 10 to 90 of A_nl, the tuned disk's included.

    So few samples know these five times better than percentiles 1 and 99, which are single samples.
    """
    fine = [peaks(results[s]["amplitude"]) for s in FINE if s != setting]
    reference = np.concatenate([mistuned for _, mistuned in fine]) / np.mean([t for t, _ in fine])
    tuned, mistuned = peaks(results[setting]["amplitude"])
    error = np.percentile(mistuned / tuned, DECILES) / np.percentile(reference, DECILES) - 1.0
    return float(np.mean(np.abs(error)))


def floor(results):
    """Largest score of the fine runs against each other: what scatter alone gives."""
    return max(score(results, setting) for setting in FINE)


def bias(results, n_boot=1000):
    """{step: errors of A_nl's deciles (mean), of percentiles 1, 50, 99, and their standard errors}.

    Against the runs with a step of 10 µs, sample by sample, so that what the samples have in common
    cancels. (4, 2) each.
    """
    reference = PAIRED[-1], NUDGED
    top = {s: np.nanmax(results[s]["amplitude"], axis=1) for s in (*PAIRED, NUDGED)}
    draws = np.random.default_rng(0).integers(0, MORE_SAMPLES, (n_boot, MORE_SAMPLES))
    draws[0] = np.arange(MORE_SAMPLES)
    tuned_draws = np.random.default_rng(1).integers(0, N_TUNED, (n_boot, N_TUNED))
    tuned_draws[0] = np.arange(N_TUNED)

    def percentiles(settings):
        samples = np.concatenate([top[s][N_TUNED:][draws] for s in settings], axis=1)
        tuned = np.concatenate([top[s][:N_TUNED][tuned_draws] for s in settings], axis=1)
        found = np.percentile(samples, (*DECILES, *PERCENTILES), axis=1)
        return found / np.median(tuned, axis=1)

    known, out = percentiles(reference), {}
    for setting in PAIRED[:-1]:
        error = percentiles([setting]) / known - 1.0
        error = np.vstack([error[: len(DECILES)].mean(axis=0), error[len(DECILES) :]])
        out[setting.step] = np.stack([error[:, 0], error[:, 1:].std(axis=1)], axis=1)
    return out


def missed_peaks(results, setting):
    """Share of samples whose peak the search misses, and the mean of found over true peak."""
    full = peaks(results[setting._replace(search="full")]["amplitude"])[1]
    ratio = peaks(results[setting]["amplitude"])[1] / full
    return np.mean(ratio < 1.0), ratio.mean()


def periodic(results):
    """Mask of the points (n, S) of the mistuned samples that do not depend on rounding."""
    both = NUDGED._replace(nudge=0.0), NUDGED
    a, b = (results[setting]["amplitude"][N_TUNED:] for setting in both)
    return np.abs(a / b - 1.0) < PERIODIC


def periodic_errors():
    """{scheme: (steps, mean amplitude error, fitted order)} of the tuned disk where periodic.

    Against the finest step of exact_modal.
    """
    finest, amplitude = 5e-7, {}
    for scheme in SCHEMES:
        for step in (*STEPS[2 * (scheme == "central_difference") :], finest):
            model = cases.problem(60, scheme, step)
            result = sweep.run_sweep(cases.modes_of(model.reduced, None), model.scene, TUNED_SPEEDS)
            amplitude[scheme, step] = result.amplitude
    exact, out = amplitude["exact_modal", finest], {}
    for scheme in SCHEMES:
        steps = [step for name, step in amplitude if name == scheme and step > finest]
        errors = [np.mean(np.abs(amplitude[scheme, step] / exact - 1.0)) for step in steps]
        out[scheme] = steps, errors, float(np.polyfit(np.log(steps), np.log(errors), 1)[0])
    return out


def pool_of_two():
    return multiprocessing.get_context("spawn").Pool(2)
