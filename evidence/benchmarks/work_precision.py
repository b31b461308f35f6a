"""Run time of a sample against the error of what a user reads off: percentiles, peaks, amplitudes.

The response at many speeds is quasi-periodic or chaotic: two runs that differ by rounding end in
other amplitudes there, so errors of single points and of single samples have a floor that no step
lowers. Percentiles over samples average it. The reference is therefore all fine runs together, and
the floor is how far these are from each other. What a step does to the percentiles is smaller than
that: `bias` finds it in pairs of the same samples, more of them.
"""

import itertools
import multiprocessing
import time
from typing import NamedTuple

import numpy as np

from evidence.benchmarks import cases
from hpcrub.contact.status import NOT_STEADY
from hpcrub.errors import InputError
from hpcrub.response import sweep

N_SAMPLES, MORE_SAMPLES = 64, 256
N_TUNED, MORE_TUNED = 9, 65  # runs of the tuned disk that differ by rounding: A_nl is relative to
# their median
SPEEDS = cases.SPEEDS[::2]
PERCENTILES = (1, 50, 99)
DECILES = tuple(range(10, 100, 10))
STEPS = (4e-5, 3.3e-5, 2e-5, 1e-5, 5e-6, 1e-6)
N_MODES = (12, 24, 36, 60, 84, 120)
CROSSED = (4e-5, 3.3e-5)  # steps that are combined with all N_MODES
NUDGE = 1e-12  # relative change of the blades' stiffness, as small as rounding
PERIODIC = 1e-4  # amplitudes that a nudge changes by less do not depend on rounding
OTHER = 0.05  # amplitudes that differ by more belong to another of several motions
SCHEMES = ("exact_modal", "central_difference")
SETTLED = 4.0  # [s] until transients are over, and amplitudes of periodic motions are compared
SETTLED_SPEEDS = np.arange(36.3, 37.301, 0.0625)  # [Hz] where some motions are periodic
SETTLED_SAMPLES = range(2)
FINEST = 1e-6  # [s]


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
PAIRED = [Setting(step=step) for step in STEPS[:4]]  # the last, with NUDGED, is their reference


def is_stable(setting):
    """Whether the step is below the limit of the scheme for this model."""
    try:
        cases.problem(setting.n_modes, setting.scheme, setting.step)
    except InputError:
        return False
    return True


def plain_settings():
    """Both schemes with all steps that are stable, 60 modes."""
    return list(filter(is_stable, (Setting(scheme, step) for scheme in SCHEMES for step in STEPS)))


def crossed_settings():
    """Both schemes with long steps and other numbers of modes, where stable."""
    return list(filter(is_stable, itertools.starmap(
        Setting, itertools.product(SCHEMES, CROSSED, (n for n in N_MODES if n != 60))
    )))  # fmt: skip


def other_settings():
    """Peak search, and a longer longest time."""
    return [
        *[Setting(step=step, search="peak") for step in (4e-5, 3.3e-5)],
        *[Setting(step=step, max_time=5.0) for step in (3.3e-5, 2e-5)],
    ]


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
    for setting in (*plain_settings(), *crossed_settings(), *other_settings(), NUDGED):
        paired = setting in (*PAIRED, NUDGED)
        n, n_tuned = (MORE_SAMPLES, MORE_TUNED) if paired else (n_samples, N_TUNED)
        tasks = [(setting, s) for s in (*range(-n_tuned, 0), *range(n))]
        answers = pool.map(run_one, tasks, chunksize=1)
        samples = answers[n_tuned:]
        out[setting] = {
            "tuned": np.array([a[0] for a in answers[:n_tuned]]),
            "amplitude": np.array([a[0] for a in samples]),
            "seconds": float(np.mean([a[1] for a in samples])),
            "simulated": float(np.mean([a[2] for a in samples])) / len(SPEEDS),
            "not_steady": float(np.mean([np.mean(a[3] == NOT_STEADY) for a in samples])),
        }
        print(f"  {setting.label}: {out[setting]['seconds']:.3f} s a sample", flush=True)
    return out


def tops(result):
    """Largest amplitudes of N_TUNED runs of the tuned disk, and of N_SAMPLES samples."""
    tuned, samples = (np.nanmax(result[name], axis=1) for name in ("tuned", "amplitude"))
    return tuned[:N_TUNED], samples[:N_SAMPLES]


def peaks(result):
    """Reference amplitude of the tuned disk, and the largest of N_SAMPLES samples."""
    tuned, samples = tops(result)
    return np.median(tuned), samples


def compare(results, setting, n_boot=400):
    """Errors of a setting against the fine runs together, as relative numbers."""
    tuned, mistuned = tops(results[setting])
    fine = [peaks(results[s]) for s in FINE if s != setting]
    tuned_fine = np.mean([tuned for tuned, _ in fine])
    known = np.percentile(np.concatenate([samples for _, samples in fine]), PERCENTILES)
    rng = np.random.default_rng(0)
    draws, tuned_draws = (rng.integers(0, len(a), (n_boot, len(a))) for a in (mistuned, tuned))
    boot = np.percentile(mistuned[draws], PERCENTILES, axis=1).T / known
    boot = boot * (tuned_fine / np.median(tuned[tuned_draws], axis=1))[:, None] - 1.0
    ratio = tuned_fine / np.median(tuned)
    each = peaks(results[REFERENCE])[1]
    return {
        "percentiles": np.percentile(mistuned, PERCENTILES) / known * ratio - 1.0,
        "interval": np.percentile(boot, (2.5, 97.5), axis=0),
        "tuned": 1.0 / ratio - 1.0,
        "sample_median": np.median(np.abs(mistuned / each - 1.0)),
    }


def score(results, setting):
    """Mean magnitude of the errors of the deciles 10 to 90 of A_nl, the tuned disk's included.

    So few samples know these five times better than percentiles 1 and 99, which are single samples.
    """
    fine = [peaks(results[s]) for s in FINE if s != setting]
    reference = np.concatenate([mistuned for _, mistuned in fine]) / np.mean([t for t, _ in fine])
    tuned, mistuned = peaks(results[setting])
    error = np.percentile(mistuned / tuned, DECILES) / np.percentile(reference, DECILES) - 1.0
    return float(np.mean(np.abs(error)))


def floor(results):
    """Largest score of the fine runs against each other: what scatter alone gives."""
    return max(score(results, setting) for setting in FINE)


def bias(results, n_boot=1000):
    """{step: errors of A_nl's deciles (mean), of percentiles 1, 50, 99, and their standard errors}.

    Against the runs with a step of 10 µs, sample by sample, so that what the samples have in common
    cancels; bootstrap over the samples and over the runs of the tuned disk. (4, 2) each.
    """
    reference = PAIRED[-1], NUDGED
    draws = np.random.default_rng(0).integers(0, MORE_SAMPLES, (n_boot, MORE_SAMPLES))
    draws[0] = np.arange(MORE_SAMPLES)
    rng = np.random.default_rng(1)  # runs of the tuned disk are not pairs: each setting its own

    def top(setting, name):
        return np.nanmax(results[setting][name], axis=1)

    def percentiles(settings):
        samples = np.concatenate([top(s, "amplitude")[draws] for s in settings], axis=1)
        again = rng.integers(0, MORE_TUNED, (len(settings), n_boot, MORE_TUNED))
        again[:, 0] = np.arange(MORE_TUNED)
        runs = zip(settings, again, strict=True)
        tuned = np.concatenate([top(s, "tuned")[picked] for s, picked in runs], axis=1)
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
    ratio = peaks(results[setting])[1] / peaks(results[setting._replace(search="full")])[1]
    return np.mean(ratio < 1.0), ratio.mean()


def share_periodic(results):
    """Share of the points of the samples that do not depend on rounding."""
    both = NUDGED._replace(nudge=0.0), NUDGED
    a, b = (results[setting]["amplitude"] for setting in both)
    return np.mean(np.abs(a / b - 1.0) < PERIODIC)


def settled(task):
    """Amplitudes (S,) of one sample after SETTLED seconds, steady or not."""
    scheme, step, sample, nudge = task
    model = cases.problem(60, scheme, step)
    steady = model.scene.steady._replace(first_check=SETTLED, max_time=SETTLED)
    modes = cases.modes_of(model.reduced, sample, nudge)
    return sweep.run_sweep(modes, model.scene._replace(steady=steady), SETTLED_SPEEDS).amplitude


def periodic_errors(pool):
    """Errors of the amplitude on points that are periodic, against the finest step of exact_modal.

    Periodic: with either scheme and a step of 5 µs, a nudge has changed the amplitude by less than
    a tenth of PERIODIC after SETTLED seconds.

    Returns:
        {scheme: (steps, median errors, shares of points that are off by more than OTHER, fitted
        order of the medians)}, number of periodic points, and of all.
    """
    runs = [
        (scheme, step, nudge)
        for scheme in SCHEMES
        for step, nudge in (*((step, 0.0) for step in STEPS), (5e-6, NUDGE))
    ]
    stable = pool.map(is_stable, [Setting(scheme, step) for scheme, step, _ in runs])
    runs = list(itertools.compress(runs, stable))
    tasks = [(s, h, sample, nudge) for s, h, nudge in runs for sample in SETTLED_SAMPLES]
    found = np.reshape(pool.map(settled, tasks, chunksize=1), (len(runs), -1))
    amplitude = dict(zip(runs, found, strict=True))
    pairs = [(amplitude[s, 5e-6, 0.0], amplitude[s, 5e-6, NUDGE]) for s in SCHEMES]
    here = np.all([np.abs(a / b - 1.0) < 0.1 * PERIODIC for a, b in pairs], axis=0)
    exact, out = amplitude["exact_modal", FINEST, 0.0], {}
    for scheme in SCHEMES:
        steps = [h for s, h, nudge in runs if s == scheme and not nudge]
        steps = [h for h in steps if (scheme, h) != ("exact_modal", FINEST)]
        errors = np.array([np.abs(amplitude[scheme, h, 0.0] / exact - 1.0)[here] for h in steps])
        median, other = np.median(errors, axis=1), np.mean(errors > OTHER, axis=1)
        # another disk may have no periodic point at these speeds
        order = float(np.polyfit(np.log(steps), np.log(median), 1)[0]) if here.any() else np.nan
        out[scheme] = steps, median, other, order
    return out, int(here.sum()), here.size


def pool_of_two(disk=None):
    """Two processes; disk: an input file with another disk than the reference."""
    spawn = multiprocessing.get_context("spawn")
    return spawn.Pool(2, cases.take_disk_of, (disk,))
