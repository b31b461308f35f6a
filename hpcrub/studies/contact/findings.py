"""Verdict on the results of a contact study: findings that speak against them, and advice.

The verdict stands in the summary and in the file; its first lines stand below the figures.
"""

from collections.abc import Iterator
from typing import Any

import numpy as np

from hpcrub import effects
from hpcrub.config.text import counted, percent
from hpcrub.contact.status import AVERAGED, DIVERGED, GROWING, NOT_STEADY
from hpcrub.results import samples
from hpcrub.results.layout import PENDING
from hpcrub.results.storage import ResultFile
from hpcrub.results.verdict import FAR_OFF, MOST_LOST, REMARK, SINGLE, USELESS, Finding, Verdict
from hpcrub.runs import findings
from hpcrub.statistics.percentiles import finite
from hpcrub.studies.contact import layout, second_order, summary, survey

NO_CONTACT = (
    "no contact: the casing reaches the blades at no speed, so that no disk moves and no limit is "
    "exceeded (casing.clearance_mm beside bump_height_mm, harmonics and profile)"
)
HALF_STEP = (  # heading, what it does, and the keys
    "half the step moves peaks",
    "half the time step, which may also lead to another motion at the same speed, moves",
    "time.step_s",
)
FOLLOWED = (
    "four times the time moves peaks",
    "four times the time, in which a motion may be left for another one, moves",
    "steady_state.first_check_s and max_time_s",
)


def verdict(file: ResultFile) -> Verdict:
    """Verdict on a study."""
    every = _findings(file, survey.survey(file))
    return Verdict.of(every, of_many=len(file.config.samples) > 1 and not summary.are_few(file))


def _findings(file: ResultFile, counts: Any) -> Iterator[Any]:
    if layout.is_untouched(file):
        yield Finding(REMARK, "no contact", NO_CONTACT)
        return
    config, n_unsteady = file.config, int(counts.peaks[NOT_STEADY]) - counts.growing
    yield from findings.points_without_result(
        counts.reasons, int(counts.points[:, DIVERGED].sum()), counts.n_points
    )
    lost = sum(samples.n_failed(file, level) for level in config.levels)
    n, missing = samples.n_counted(file), "are missing in all percentiles"
    if not (file.status != PENDING).any():
        advice = "no mistuned disk is finished; the same input with --resume goes on"
        yield Finding(USELESS, "no mistuned disk is finished", advice)
    yield from findings.disks_without_result(lost, n * len(config.levels), missing)
    yield from second_order.of_displacements(file, counts.largest)
    growth = counts.growing, int(counts.reasons[GROWING]), counts.n_points, counts.shows
    yield from findings.growing(config, *growth)
    yield from effects.findings(file)
    yield from findings.not_settled(config, n_unsteady, counts.n_peaks, "peaks")
    yield from _speeds(file, counts)
    yield from findings.not_resolved(file.warnings)
    yield from _checks(file)
    yield from _errors(file, counts)
    if not summary.are_few(file):
        yield from findings.too_few_samples(config.convergence.percentiles, n)
    yield from _reference(file)


def _speeds(file: ResultFile, counts: Any) -> Iterator[Any]:
    """Peaks at an end of the speeds, and peaks that the steps between speeds may miss."""
    n, speeds = counts.n_peaks, file.config.speeds
    yield from findings.at_the_ends(file.config, counts.lowest, counts.highest, n, most=MOST_LOST)
    ends = speeds.values_hz[[0, -1]]  # the last may lie below to_hz
    if speeds.n_values > 1 and file.read("tuned/peak_speed_hz") in ends:
        yield Finding(
            USELESS,
            "tuned peak at the edge of the speeds",
            "the peak of the tuned disk lies at the edge of the speeds, so that A_nl may be too "
            "high: wider speeds.from_hz, to_hz",
        )
    if counts.alone > MOST_LOST * n:
        yield Finding(
            SINGLE,
            "a coarse grid of speeds",
            f"at {counts.alone} of {n} peaks both neighbouring speeds are more than 10 % lower: a "
            f"speeds.step_hz below {speeds.step_hz:g} may find higher ones",
        )


def _checks(file: ResultFile) -> Iterator[Any]:
    """Change of the peaks of the disks that were integrated once more, in other ways."""
    if "tuned/half_step_peak_m" not in file:
        advice = "no disk was run with another step, or for longer (mistuning.checked_samples)"
        yield Finding(REMARK, "unchecked step and time", advice)
        return
    for name, (heading, does, keys) in (("half_step", HALF_STEP), ("followed", FOLLOWED)):
        moved = check_moves(file, name)
        if not len(moved):
            continue
        low, high, n = 100 * moved.min(), 100 * moved.max(), len(moved) - 1
        largest = np.abs(moved).max()
        whose = f"the peaks of the tuned disk and {counted(n, 'sample')}" if n else "the tuned peak"
        yield Finding(
            USELESS if largest > FAR_OFF else SINGLE if largest > MOST_LOST else REMARK,
            f"{heading} by up to {percent(largest)} %",
            f"{does} {whose} by {low:+.1f} to {high:+.1f} %; where that is too much: {keys}",
        )


def check_moves(file: ResultFile, name: str) -> np.ndarray:
    """Relative change of the checked disks' peaks in a check, the tuned one first (n,)."""
    where = -1, slice(samples.n_counted(file))
    other, own = (
        np.append(file.read(f"tuned/{of}"), file.read(f"samples/{of}", where))
        for of in (f"{name}_peak_m", "peak_amplitude_m")
    )
    return finite(other / own - 1.0)


def _errors(file: ResultFile, counts: Any) -> Iterator[Any]:
    """Standard errors of peaks that are means; they hold for the same motion continued."""
    error, share = 2.0 * counts.error, counts.peaks[AVERAGED] / counts.n_peaks
    if np.isfinite(error):
        yield Finding(
            SINGLE if error > MOST_LOST else REMARK,
            f"peaks known to ±{percent(error)} %",
            f"{100 * share:.0f} % of the peaks are means, known to "
            f"±{percent(error)} % (two standard errors of the same motion continued): "
            f"steady_state.max_error below {file.config.steady_state.max_error:g}",
        )


def _reference(file: ResultFile) -> Iterator[Any]:
    """Uncertainty of the tuned disk, to which all amplifications are relative."""
    runs, equal = finite(file.read("tuned/run_peaks_m")), survey.unstable_peak(file)
    if np.isfinite(equal):
        yield Finding(
            REMARK,
            "a symmetric motion that does not stay",
            f"the symmetric motion of equal blades, {1e3 * equal:.3g} mm, does not stay: "
            f"amplitudes are relative to {1e3 * file.read('tuned/reference_amplitude_m'):.3g} mm, "
            "that of a disk whose blades hardly differ (mistuning.reference)",
        )
    if len(runs) < 2:
        advice = "the tuned disk was run once; mistuning.tuned_runs say how much A_nl owes to that"
        yield Finding(REMARK, "one tuned run", advice)
        return
    below, above = survey.shared_uncertainty(file)
    if np.isnan(below) or np.isnan(above):
        words = f"{len(runs)} tuned runs are too few for a 95 % interval of their median"
        yield Finding(REMARK, "few tuned runs", f"{words}: mistuning.tuned_runs of 6 and more")
    elif max(below, above) > 0.0:
        yield Finding(
            SINGLE if max(below, above) > FAR_OFF / 2 else REMARK,
            f"tuned peak known to -{percent(below)} +{percent(above)} %",
            f"{len(runs)} runs of the tuned disk, which hardly differ in stiffness, leave all "
            f"A_nl uncertain by -{100 * below:.1f} to +{100 * above:.1f} %, which the intervals "
            "contain: more mistuning.tuned_runs",
        )
