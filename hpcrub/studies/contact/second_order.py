"""What small displacements leave out: some disks of a study, once more to second order.

Of a contact study these are the tuned disk and the first samples of the last level, of trials the
first disks at the answer: a choice by what they did would favour disks of rare motions.
"""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from hpcrub.config.schema import Config
from hpcrub.config.text import counted, percent, signed_percent
from hpcrub.model.reduction import Modes
from hpcrub.response.scene import Scene
from hpcrub.results.storage import ResultFile
from hpcrub.results.verdict import FAR_OFF, MOST_LOST, REMARK, SINGLE, USELESS, Finding
from hpcrub.runs import findings
from hpcrub.setup.disks import deviation, rubbing_modes
from hpcrub.setup.problem import Problem, checks_second_order
from hpcrub.statistics.percentiles import finite, mean_and_error
from hpcrub.studies.contact.amplification import Integrated, tuned_run
from hpcrub.studies.contact.limits import limits_of

FURTHER = 2.0  # times as far as its steady motion, or the tuned disk, a disk may move
MOST = 2  # mistuned disks of a contact study that are computed to second order
OF_TRIALS = 6  # disks of a study of trials
COST = 8, 2  # cost of a disk to second order: planar, and of a model file
KEY = "contact.kinematics: second_order"
BEGIN = "to second order, with the shift of a tip by the bending of its blade, "
PEAK, SPEED = "tuned/second_order_peak_m", "tuned/second_order_speed_hz"


def n_disks(config: Config) -> int:
    """Number of disks to second order, 0: of a study that checks none, or knows no second order.

    It is that of every part of the study, and of the study with more samples.
    """
    n = min(config.mistuning.checked_samples, len(_drawn(config).samples), MOST)
    return 1 + n if checks_second_order(config) else 0


def _drawn(config: Config) -> Config:
    """The configuration of the whole study, in which MOST samples can be drawn, if there are."""
    n = config.mistuning.samples
    if config.mistuning.pattern_file is None:
        n = max(n, MOST)
    return config.replace({"part.samples": None, "mistuning.samples": n})


def disk(config: Config, problem: Problem, number: int) -> tuple[Modes, Scene]:
    """Modes and scene of a disk to second order."""
    if number == 0:
        return tuned_run(config, problem, 0)
    blades = deviation(_drawn(config), config.levels[-1], number - 1)
    return rubbing_modes(config, problem, blades), problem.scene


def values_of(config: Config, found: Sequence[Integrated]) -> dict[str, Any]:
    """Values of the disks by the names of their datasets; NaN: not computed, infinite: none."""
    peaks = [disk.peak(config.speeds.values_hz) for disk in found]
    sizes, speeds = np.reshape(peaks, (-1, 2)).T
    return {PEAK: np.nan_to_num(sizes, nan=np.inf), SPEED: speeds} if peaks else {}


def of_displacements(file: ResultFile, sizes: np.ndarray) -> Iterator[Finding]:
    """Findings about the size of motions; sizes: largest amplitudes of the disks [m]."""
    computed = PEAK in file and not np.isnan(file.read(PEAK)[0])
    told = _finding(file, float(np.max(sizes, initial=0.0))) if computed else None
    yield from findings.kinematics(file.config, sizes, told)


def _finding(file: ResultFile, largest: float) -> Finding:
    """What the disks to second order say; largest: motion of all disks [m]."""
    before, after = float(file.read("tuned/peak_amplitude_m")), file.read(PEAK)
    if beyond := _beyond_range(file.config, "the tuned disk", before, after[0]):
        return beyond
    change = after[0] / before - 1.0
    speeds = float(file.read("tuned/peak_speed_hz")), float(file.read(SPEED)[0])
    was, now = (
        f"{1e3 * size:.3g} mm at {speed:.5g} Hz"
        for size, speed in zip((before, after[0]), speeds, strict=True)
    )
    advice = f"{BEGIN}the peak of the tuned disk is {now}, not {was} ({signed_percent(change)} %)"
    if speeds[1] in file.config.speeds.values_hz[[0, -1]]:
        advice += ", and may be higher beyond that speed"
    numbers = np.array(file.config.samples)
    there = numbers[numbers < len(after) - 1]
    small = file.read("samples/peak_amplitude_m", (-1, slice(len(there)))) / before
    ratios = finite(after[1 + there] / after[0] / small - 1.0)
    if len(ratios):
        advice += f", and A_nl of {counted(len(ratios), 'disk')} changes by {_range(ratios)} %"
    if np.abs(ratios).max(initial=0.0) > FAR_OFF:
        why = f"second order moves A_nl by {_range(ratios)} %"
        return Finding(USELESS, why, f"{advice}: {KEY}")
    why = f"second order moves the tuned peak by {signed_percent(change)} %"
    if abs(change) * max(largest / before, 1.0) ** 2 > MOST_LOST:
        too = ", and probabilities of limits" if limits_of(file.config) else ""
        return Finding(SINGLE, why, f"{advice}: {KEY} for millimetres and MPa{too}")
    return Finding(REMARK, why, advice)


def _beyond_range(config: Config, which: str, before: float, after: float) -> Finding | None:
    """Finding about disks without a result to second order, or beyond what this order can tell.

    which: the disks are; before, after: their (median) peak at small displacements and to second
    order, infinite without a result [m].
    """
    if not np.isfinite(after):
        advice = f"{BEGIN}there is no result of {which} at any speed: {KEY} says why"
        return Finding(USELESS, "outside small displacements", advice)
    third = findings.third_order(config, after)
    if third <= findings.THIRD:
        return None
    most = after * np.sqrt(findings.THIRD / third)
    advice = (
        f"{BEGIN}the peak of {which} is {1e3 * after:.3g} mm, where small displacements say "
        f"{1e3 * before:.3g} mm; the second order can tell motions of up to {1e3 * most:.3g} mm: "
        "sign no millimetres or MPa, and take ratios only with care"
    )
    return Finding(SINGLE, "tips move further than second order can tell", advice)


def matters(config: Config, size: float) -> bool:
    """Whether a disk that moves by a size [m] is to be computed to second order, too."""
    return checks_second_order(config) and findings.is_far(config, size)


def cost(config: Config, n: int = OF_TRIALS) -> int:
    """Cost of n disks to second order, in disks at small displacements; 0 where none is asked."""
    return COST[config.disk.model is not None] * n * checks_second_order(config)


def of_others(
    file: ResultFile, which: str, before: np.ndarray, after: np.ndarray
) -> Finding | None:
    """What disks of other studies say to second order; None: none was computed.

    which: the disks are; before, after: their largest amplitudes at small displacements and to
    second order, NaN where not computed, infinite without a result, of one shape [m].
    A disk alone says little, as motions to either order are not alike: their mean change counts.
    """
    known = ~np.isnan(after) & (before > 0.0)
    if not known.any():
        return None
    was, now = np.median(before[known]), np.median(after[known])
    middle = ", at the median," if np.count_nonzero(known) > 1 else ""
    if beyond := _beyond_range(file.config, f"{which}{middle}", was, now):
        return beyond
    mean, error = mean_and_error(finite(after[known] / before[known] - 1.0))
    within = "" if np.isnan(error) else f" ± {percent(error)}"
    change = f"{signed_percent(mean)}{within} %"
    ends = f"to {1e3 * now:.3g} mm from {1e3 * was:.3g} mm"
    advice = f"{BEGIN}peaks of {which} change by {change}{middle or ','} {ends}"
    why = f"second order moves peaks of {which} by {change}"
    least, most = abs(mean) - np.nan_to_num(error), abs(mean) + np.nan_to_num(error)
    if most > MOST_LOST:
        return Finding(USELESS if least > FAR_OFF else SINGLE, why, f"{advice}: {KEY}")
    return Finding(REMARK, why, advice)


def _range(shares: np.ndarray) -> str:
    """The least and the largest of some shares in per cent, each with its sign."""
    return " to ".join(dict.fromkeys(signed_percent(end) for end in (shares.min(), shares.max())))
