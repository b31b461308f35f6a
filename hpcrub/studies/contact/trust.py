"""How far the results of a contact study can be trusted, in lines for people.

They stand in the summary and in the file, and what is to be careful with under its figures.
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from hpcrub.config.schema import Config
from hpcrub.contact import status
from hpcrub.contact.status import AVERAGED, DIVERGED, NOT_STEADY, STEADY
from hpcrub.model.coating import Coating
from hpcrub.model.disk import root_stress
from hpcrub.results.layout import DONE
from hpcrub.results.storage import ResultFile
from hpcrub.statistics.percentiles import Z_95, percentile_interval, probability_interval
from hpcrub.studies.contact import layout

ROWS = 1000  # samples read at once
ALONE = 0.9  # of a peak: where both neighbouring speeds are below, the step may miss a higher one
FEW = 0.05  # of the peaks: a larger share at an edge, or alone, is worth a word
REACHED = 1.0 - 1e-9  # of the depth of a coating that is worn through: rounding
SMALL = 0.1  # of the casing's reach: radius that small kinematics may leave out
OF_MEANS = "amplitude_error_m", "amplitude_scatter_m", "time_s"  # the first two by the peak [-]
KNOWN = STEADY, AVERAGED, NOT_STEADY


class Survey(NamedTuple):
    """What the points and peaks of all samples that count are like."""

    points: np.ndarray  # of each status, of every level (V, 5)
    peaks: np.ndarray  # of each status (5,)
    lowest: int  # peaks at the lowest speed
    highest: int  # and at the highest
    alone: int  # peaks whose neighbours are both below ALONE of them
    averaged: np.ndarray  # medians of averaged peaks (3,), see OF_MEANS; NaN: none
    largest: float  # amplitude [m]
    n_points: int  # the tuned disk's included
    reasons: np.ndarray  # how many of these have each reason
    sweeps: int  # most sweeps of the solver


def survey(file: ResultFile) -> Survey:
    """Look at all points of a file, a few samples at a time."""
    points = np.zeros((len(file.config.levels), 5), dtype=np.int64)
    peaks, averaged = np.zeros(5, dtype=np.int64), [np.zeros((4, 0))]
    lowest = highest = alone = 0
    reasons = status.count(file.read("tuned/point_reason"))
    sweeps, largest = int(file.read("tuned/max_sweeps").max()), 0.0
    wears = file.config.contact.wears
    name = layout.amplitude(file.config)
    for level, part in pieces(file):
        where = level, part
        states = file.read("samples/point_status", where)
        points[level] += np.bincount(states.ravel(), minlength=5)[:5]
        reasons = reasons + status.count(file.read("samples/point_reason", where))
        sweeps = max(sweeps, int(file.read("samples/max_sweeps", where).max(initial=0)))
        done = file.read("samples/status", where) == DONE
        amplitude = np.nan_to_num(file.read(f"samples/{name}", where)[done])
        if not len(amplitude):
            continue
        row, best = np.arange(len(amplitude)), amplitude.argmax(axis=1)
        peak = amplitude[row, best]
        state, last = states[done][row, best], amplitude.shape[1] - 1
        peaks += np.bincount(state, minlength=5)[:5]
        inner = (best > 0) & (best < last)
        beside = np.maximum(amplitude[row, best - 1], amplitude[row, np.minimum(best + 1, last)])
        if last:
            lowest += int(np.count_nonzero(best == 0))
            highest += int(np.count_nonzero(best == last))
            alone += int(np.count_nonzero(inner & (beside < ALONE * peak)))
        if not wears:
            found = [file.read(f"samples/{one}", where)[done][row, best] for one in OF_MEANS]
            averaged.append(np.array([*found, peak])[:, state == AVERAGED])
        largest = max(largest, float(peak.max()))
    error, scatter, time, peak = np.concatenate(averaged, axis=1)
    known = np.array([error / peak, scatter / peak, time])
    means = np.median(known, axis=1) if len(peak) else np.full(3, np.nan)
    n_points = int(points[:, 1:].sum() + np.count_nonzero(file.read("tuned/point_status")))
    return Survey(points, peaks, lowest, highest, alone, means, largest, n_points, reasons, sweeps)


def pieces(file: ResultFile) -> Iterator[tuple[int, slice]]:
    """Places of all samples that count, level by level, a few at a time."""
    n = n_counted(file)
    for level in range(len(file.config.levels)):
        for first in range(0, n, ROWS):
            yield level, slice(first, min(n, first + ROWS))


def n_counted(file: ResultFile) -> int:
    """Number of samples of each level that the tables are about.

    All; of a study that stops when it has converged, those up to where it did: how many more there
    are depends on the number of ranks.
    """
    n_all = len(file.config.samples)
    if not file.config.convergence.stop_when_converged:
        return n_all
    known = np.isfinite(file.read("statistics/contact/percentile")).any(axis=1)  # (V, K)
    blocks = np.flatnonzero(known.all(axis=0))
    return int(file.read("statistics/contact/samples_seen", blocks[-1])) if len(blocks) else n_all


def finished(file: ResultFile, level: int, name: str) -> np.ndarray:
    """Known numbers of the disks of a level that are finished, of those that count."""
    where = level, slice(n_counted(file))
    values = file.read(f"samples/{name}", where)[file.read("samples/status", where) == DONE]
    return values[np.isfinite(values)]


def shared_uncertainty(file: ResultFile) -> np.ndarray:
    """By how much all amplifications may be lower, and higher, with another reference (2,) [-].

    The ends of the 95 % interval of the median of the tuned runs. Zero where these agree, NaN where
    they are too few.
    """
    runs = file.read("tuned/run_peaks_m")
    if len(runs) == 1 or np.ptp(runs) < 1e-3 * runs.min():
        return np.zeros(2)
    low, high = np.ravel(percentile_interval(runs, [50.0], Z_95))
    reference = file.read("tuned/reference_amplitude_m")
    return np.array([1.0 - reference / high, reference / low - 1.0])


def lines(file: ResultFile, found: Survey | None = None) -> Iterator[str]:
    """What may be signed, and what may not."""
    found = found or survey(file)
    yield from _steady_lines(file, found)
    yield from _reference_lines(file)
    yield from cautions(file, found)
    yield from _validity_lines(file.config, found.largest)
    yield from _limit_lines(file)


def short(file: ResultFile) -> Iterator[str]:
    """What belongs below a figure: what kind of amplitudes its peaks are, and the cautions."""
    found = survey(file)
    n = max(1, int(found.peaks.sum()))
    averaged, lost = (100 * found.peaks[s] / n for s in (AVERAGED, NOT_STEADY))
    if file.config.contact.wears:
        yield _ended(found.points.sum(axis=0), found.peaks, file.config.steady_state.max_time_s)
    elif averaged or lost:
        yield (
            f"{averaged:.0f} % of the peaks are averaged, means known to "
            f"{100 * np.nan_to_num(found.averaged[0]):.1f} %; {lost:.0f} % are not steady"
        )
    yield from cautions(file, found)


def _steady_lines(file, found):
    points, n_peaks = found.points.sum(axis=0), max(1, found.peaks.sum())
    if file.config.contact.wears:
        yield _ended(points, found.peaks, file.config.steady_state.max_time_s)
    else:
        known = max(1, points[1:].sum())
        shares = [
            f"{100 * points[s] / known:.0f} % of the points and "
            f"{100 * found.peaks[s] / n_peaks:.0f} % of the peaks {word}"
            for s, word in zip(KNOWN, ("steady", "averaged", "not steady"), strict=True)
        ]
        yield ", ".join(shares)
    if found.points[:, DIVERGED].any():
        yield f"{points[DIVERGED]} points have no result"
    error, scatter, time = found.averaged
    if np.isfinite(error):
        yield (
            f"averaged: followed until the mean of its windows is known ({time:.2g} s), and not "
            "until it repeats itself, which it may do later or never"
        )
        yield (
            f"averaged peaks have a standard error of {100 * error:.1f} %, windows that scatter by "
            f"{100 * scatter:.1f} % (medians); other motions that exist at the same speed are not "
            "in it"
        )


def _ended(points, peaks, max_time_s):
    """Whether wear and motion have ended; a coating has no other amplitude than the largest."""
    left, lost = (100 * n[NOT_STEADY] / max(1, n[1:].sum()) for n in (points, peaks))
    return (
        f"{100 - left:.0f} % of the points have ended and wear no more; {left:.0f} % of the points "
        f"and {lost:.0f} % of the peaks have not within {max_time_s:g} s, and may cut deeper"
    )


def _reference_lines(file):
    runs = file.read("tuned/run_peaks_m")
    runs = runs[np.isfinite(runs)]
    if len(runs) < 2:
        yield "the tuned disk was run once: what another run of it would give is not known"
        return
    scatter = runs.std(ddof=1) / runs.mean()
    text = (
        f"{len(runs)} runs of the tuned disk, which differ by 3e-5 in stiffness, repeat their peak "
        f"to {100 * scatter:.1f} %"
    )
    below, above = shared_uncertainty(file)
    if np.isfinite(above):
        text += f"; by their median all A_nl are uncertain by -{100 * below:.1f} to +"
        text += f"{100 * above:.1f} %, which the intervals contain"
    yield text


def cautions(file: ResultFile, found: Survey | None = None) -> Iterator[str]:
    """What is wrong with the speeds: peaks at their edge, peaks between them."""
    found = found or survey(file)
    n, speeds = max(1, int(found.peaks.sum())), file.config.speeds
    for count, word, end in (
        (found.lowest, "lowest", f"speeds.from_hz below {speeds.from_hz:g}"),
        (found.highest, "highest", f"speeds.to_hz above {speeds.to_hz:g}"),
    ):
        if count:
            yield (
                f"{count} of {n} peaks lie at the {word} speed, and may be higher beyond it: {end}"
            )
    if speeds.n_values > 1 and file.read("tuned/peak_speed_hz") in (speeds.from_hz, speeds.to_hz):
        yield "the peak of the tuned disk lies at the edge of the speeds: A_nl may be too high"
    if found.alone > FEW * n:
        yield (
            f"at {found.alone} of {n} peaks both neighbouring speeds are more than 10 % lower: a "
            f"speeds.step_hz below {speeds.step_hz:g} may find higher ones"
        )


def _validity_lines(config: Config, largest: float) -> Iterator[str]:
    """Stress at the largest amplitude; of a planar disk, what small displacements leave out."""
    per_metre = stress_per_metre(config)
    if not largest > 0.0:
        return
    if per_metre is None:
        yield (
            f"the stress at the largest amplitude, {1e3 * largest:.3g} mm, is not known: a model "
            "file tells no stresses; with limits.stress_mpa_per_mm of its first family it is"
        )
    else:
        yield (
            f"the largest amplitude, {1e3 * largest:.3g} mm, stresses a blade by "
            f"{1e-6 * per_metre * largest:,.0f} MPa, if it moves in its first bending mode"
        )
    if config.disk.model is not None:
        return
    left_out = largest**2 / (2.0 * config.disk.tip_radius)
    reach = config.casing.outline.highest - config.clearance
    if reach > 0.0 and left_out > SMALL * reach:
        yield (
            f"small displacements leave out u²/2R = {1e3 * left_out:.2g} mm of its radius, "
            f"{left_out / reach:.2g} times as much as the casing reaches into the tips' path"
        )


def stress_per_metre(config: Config) -> float | None:
    """Stress for a tangential displacement of a tip [Pa/m]; None: not known of a model file."""
    if config.limits.stress_mpa_per_mm is not None:
        return config.limits.stress_per_metre
    if config.disk.model is not None:
        return None
    return root_stress(config.disk, config.material)


def _limit_lines(file: ResultFile) -> Iterator[str]:
    """Probability of exceeding the limits, by level."""
    config, allowed = file.config, []
    if config.limits.amplitude_mm is not None:
        allowed.append((config.limits.amplitude, f"{config.limits.amplitude_mm:g} mm"))
    if config.limits.stress_mpa is not None:
        per_metre = stress_per_metre(config)
        allowed.append((config.limits.stress / per_metre, f"{config.limits.stress_mpa:g} MPa"))
    for limit, words in allowed:
        for level, half_range in enumerate(file.read("half_range")):
            peaks = finished(file, level, "peak_amplitude_m")
            above = int(np.count_nonzero(peaks > limit))
            low, high = probability_interval(above, len(peaks), Z_95)
            yield (
                f"±{100 * half_range:.3g} %: {above} of {len(peaks)} disks exceed {words}, a "
                f"probability of {100 * low:.2g} to {100 * high:.2g} % (95 % interval)"
            )


def depth_lines(file: ResultFile) -> Iterator[str]:
    """How much deeper the worst disk of every level cuts than the tuned one.

    Nothing of a casing without a coating.
    """
    if "tuned/run_deepest_m" not in file:
        return
    runs = 1e3 * file.read("tuned/run_deepest_m")
    tuned = float(np.median(runs[np.isfinite(runs)])) if np.isfinite(runs).any() else np.nan
    c, through, n_disks = file.config.contact.coating, 0, 0
    depth_of_all = Coating(c.thickness, c.young, c.yield_stress, c.hardening, area=0.0).worn_through
    extent = f"{np.nanmin(runs):.3g} to {np.nanmax(runs):.3g} mm in {len(runs)} runs of it"
    yield f"the tuned disk cuts {tuned:.3g} mm deep ({extent})"
    for level, half_range in enumerate(file.read("half_range")):
        depth = 1e3 * finished(file, level, "deepest_m")
        n_disks += len(depth)
        through += int(np.count_nonzero(depth >= 1e3 * REACHED * depth_of_all))
        if not len(depth) or not tuned > 0.0:
            continue
        beyond = probability_interval(0, len(depth), Z_95)[1]
        yield (
            f"±{100 * half_range:.3g} %: the worst of {len(depth)} disks cuts {depth.max():.3g} mm "
            f"deep, {depth.max() / tuned:.2f} times the tuned one; another disk cuts deeper with a "
            f"probability below {100 * beyond:.2g} % (95 % confidence)"
        )
    if through:
        yield (
            f"{through} of {n_disks} disks cut through the coating, {1e3 * depth_of_all:.3g} mm, "
            "at some speed: their tips reach the casing behind it, and depths say no more"
        )
