"""Findings against the results of any study, by which its verdict is given."""

from collections.abc import Iterable, Iterator
from operator import attrgetter

import numpy as np
import numpy.typing as npt

from hpcrub import effects
from hpcrub.config.schema import Config
from hpcrub.contact import status
from hpcrub.contact.status import DIVERGED, NO_POINT, NOT_STEADY
from hpcrub.results.verdict import MOST_LOST, REMARK, SINGLE, USELESS, Finding
from hpcrub.setup.aero import curve_of
from hpcrub.setup.problem import allows_second_order, left_out, second_order_size
from hpcrub.statistics.percentiles import Z_95, confidence

# first words of warnings of `setup.plausibility` that a verdict repeats
DOUBTFUL = "not resolved", "flutter without contact", "steep casing"
FAR = 0.2  # of the tip radius: larger displacements are beyond a linear model of blades
TIME_KEY = "steady_state.max_time_s"  # of the longest time of a motion, but for histories
BEYOND = "count as beyond the limit"  # meaning of a disk without a result
# third order of a displacement over the displacement, above which tips with exact rotations may do
# otherwise: the reference disk at 41 mm (docs/questions.md)
THIRD = 0.03
SMALL = 0.1  # of the casing's reach: largest radial error by small displacements


def not_resolved(warnings: list[str]) -> Iterator[Finding]:
    """Findings from warnings of a result file that single numbers may be wrong."""
    for line in warnings:
        if (why := line.partition(":")[0]) in DOUBTFUL:
            yield Finding(SINGLE, why, line)


def kinematics(
    config: Config, sizes: npt.ArrayLike, computed: Finding | None = None
) -> Iterator[Finding]:
    """Findings about motions too large for small displacements; sizes: of the tips' motions [m].

    computed: what a run to second order says, which takes the place of an estimate.
    """
    largest, radius = float(np.max(np.nan_to_num(sizes), initial=0.0)), config.disk.tip_radius
    if largest > FAR * radius:
        yield Finding(
            USELESS,
            f"outside small displacements, {1e3 * largest:.3g} mm",
            f"tips of {1e3 * radius:.4g} mm radius move by {1e3 * largest:.3g} mm, more than a "
            "linear model of the blades can describe: more clearance, damping or a lower casing",
        )
        return
    if config.contact.bends:
        yield from _third_order(config, largest)
    elif computed:
        yield computed
    else:
        yield from _estimate(config, largest)


def is_far(config: Config, size: float) -> bool:
    """Whether small displacements leave out much of a motion of a size [m]."""
    shift, reach = left_out(config, size)
    return abs(shift) >= SMALL * reach > 0.0


def _estimate(config: Config, largest: float) -> Iterator[Finding]:
    """Finding about what small displacements leave out of a motion of a size [m], by a formula."""
    if not is_far(config, largest):
        return
    shift, reach = left_out(config, largest)
    way = "outwards" if shift > 0.0 else "inwards"
    known = f"a tip off its circle stands {way} by {1e3 * abs(shift):.2g} mm, as the blade is bent"
    change = "contact.kinematics: second_order computes with that, and a checklist what it changes"
    if second_order_size(config) is None:
        known = f"a tip leaves its circle, {way} by u²/2R = {1e3 * shift:.2g} mm, and a bent blade "
        known += "is shorter, by as much or more"
        change = "the model file does not tell how its blades bend (hpcrub import --second-order)"
    elif not allows_second_order(config):
        change = "no second order goes with a casing that vibrates or a law of one's own"
    yield Finding(
        SINGLE,
        "large displacements",
        f"small displacements leave out that {known}: {abs(shift) / reach:.2g} times as much as "
        f"the casing reaches into the tips' path; {change}: sign no millimetres or MPa without "
        "that, nor ratios of disks",
    )


def _third_order(config: Config, largest: float) -> Iterator[Finding]:
    """Finding about what the second order leaves out in a motion of a size [m]."""
    third = third_order(config, largest)
    text = f"displacements of {1e3 * largest:.3g} mm are of second order; the third would change "
    text += f"them by {100.0 * third:.1g} % or so"
    if third > THIRD:
        text += ", and which motion they settle in: sign none, and ratios only with care"
    yield Finding(SINGLE if third > THIRD else REMARK, "large displacements", text)


def third_order(config: Config, size: float) -> float:
    """Third order of a motion of a size [m] over the motion; NaN: the model file does not tell."""
    told = second_order_size(config)
    return (size * told[1]) ** 2 if told else np.nan


def points_without_result(reasons: np.ndarray, n_lost: int, n_points: int) -> Iterator[Finding]:
    """Finding about points without a result; reasons: number of points by reason of ``status``."""
    if not n_lost:
        return
    fatal = np.where(status.are_fatal(np.arange(len(reasons))), reasons, 0)
    word = "flutter" if fatal.argmax() == status.FLUTTER else "no result"
    points = f"{n_lost} of {n_points} points"
    change = "contact.friction, casing or damping"
    if fatal.argmax() == status.RUNAWAY:
        change = "the casing: a stiffer or better damped one, or fewer of its waves"
    elif fatal.argmax() == status.NOT_FED:
        change = "time.step_s first, then contact.friction"
    yield Finding(
        USELESS if n_lost > MOST_LOST * n_points else REMARK,
        f"{word} at {points}",
        f'{points} have no result, mostly by "{status.words(int(fatal.argmax()))}": leave these '
        f"speeds out, or change {change}",
    )


def disks_without_result(n_lost: int, n: int, meaning: str) -> Iterator[Finding]:
    """Finding about n_lost of n disks without a result; meaning: what the study makes of them."""
    if n_lost:
        words = f"{n_lost} of {n} disks have no result"
        severity = USELESS if n_lost > MOST_LOST * n else REMARK
        yield Finding(severity, words, f"{words} at any speed, and {meaning}")


def of_disks(
    config: Config,
    sizes: np.ndarray,
    states: np.ndarray,
    meaning: str = BEYOND,
    to_second_order: Finding | None = None,
) -> Iterator[Finding]:
    """Findings against the largest amplitudes of the disks that were computed, of any shape.

    sizes [m]: not finite without a result; states: codes of ``status`` of their points; meaning:
    of a disk without a result; to_second_order: as `computed` of `kinematics`.
    """
    n_lost = int(np.count_nonzero(~np.isfinite(sizes)))
    yield from disks_without_result(n_lost, sizes.size, meaning)
    lost, n = (int(np.count_nonzero(there)) for there in (states == NOT_STEADY, states != NO_POINT))
    yield from not_settled(config, lost, n, "peaks")
    yield from kinematics(config, sizes[np.isfinite(sizes)], to_second_order)


def not_settled(
    config: Config, n_lost: int, n: int, of: str, key: str = TIME_KEY
) -> Iterator[Finding]:
    """Finding about n_lost of n peaks or points (`of`) whose motion has not settled in its time.

    key: of the longest time of a motion.
    """
    if not n_lost:
        return
    may = [effect.unsettled for effect in effects.of(config) if effect.unsettled]
    what = " and ".join(may) or "may still grow or decay"
    why = f"{n_lost} of {n} {of} have not settled"
    advice = f"{why} within their time and {what}: {_longer(config, key)}"
    yield Finding(USELESS if n_lost > MOST_LOST * n else SINGLE, why, advice)


def growing(
    config: Config, n_peaks: int, n: int, n_points: int, latest: float = np.nan, key: str = TIME_KEY
) -> Iterator[Finding]:
    """Finding about n of n_points points, n_peaks peaks among them, at which a wave still grows.

    latest: time at which all of these waves have shown [s], NaN if not known; key: as for
    `not_settled`.
    """
    if not n:
        return
    why = f"still growing at {n} of {n_points} points"
    until = f" after up to {latest:.2g} s" if np.isfinite(latest) else ""
    peaks = f", {n_peaks} of them peaks" if n_peaks else ""
    yield Finding(
        USELESS if n > MOST_LOST * n_points and n_peaks else SINGLE if n_peaks else REMARK,
        why,
        f"{why}{peaks}: a wave of the disk grows when the time is over, and the motion becomes "
        f"another one{until}: {_longer(config, key)}",
    )


def _longer(config: Config, key: str) -> str:
    """Advice to give motions more time, unless the air excites a wave of the tuned disk."""
    if config.aero.exists and curve_of(config).damping_ratio.min() <= 0.0:
        return "the air excites the tuned disk, and no time is long enough: aero, or more mistuning"
    return f"{key} above {attrgetter(key)(config):g}"


def of_points(
    config: Config, amplitude: np.ndarray, states: np.ndarray, reasons: np.ndarray, key: str
) -> Iterator[Finding]:
    """Findings against the points of some disks, or starts, at some speeds.

    - amplitude: (D, S) displacements or energies, whose peak over the speeds counts.
    - states, reasons: (D, S) codes of ``status``.
    - key: see `not_settled`.
    """
    n = int(np.count_nonzero(states != NO_POINT))
    known = (np.nan_to_num(amplitude) > 0.0).any(axis=1)
    best = np.nanargmax(amplitude[known], axis=1) if known.any() else np.zeros(0, dtype=int)
    grows = reasons == status.GROWING
    n_peaks = int(np.count_nonzero(grows[known, best]))
    yield from points_without_result(
        status.count(reasons), int(np.count_nonzero(states == DIVERGED)), n
    )
    yield from growing(config, n_peaks, int(np.count_nonzero(grows)), n, key=key)
    others = int(np.count_nonzero((states == NOT_STEADY) & ~grows))
    yield from not_settled(config, others, n, "points", key)
    if best.size and amplitude.shape[1] > 1:
        yield from of_peaks(config, best)


def of_peaks(config: Config, best: np.ndarray) -> Iterator[Finding]:
    """Findings about peaks at the first or last speed; best: speed index of every peak (D,)."""
    last = config.speeds.n_values - 1
    lowest, highest = (int(np.count_nonzero(best == end)) for end in (0, last))
    yield from at_the_ends(config, lowest, highest, len(best))


def at_the_ends(
    config: Config, lowest: int, highest: int, n: int, most: float = 1.0
) -> Iterator[Finding]:
    """Findings about how many of n peaks lie at the ends; most: their share in a usable result."""
    speeds = config.speeds
    for count, word, key in (
        (lowest, "lowest", f"speeds.from_hz below {speeds.from_hz:g}"),
        (highest, "highest", f"speeds.to_hz above {speeds.to_hz:g}"),
    ):
        if count:
            of, verb = f"{count} of {n} peaks", "lie" if count > 1 else "lies"
            yield Finding(
                USELESS if count > most * n else SINGLE,
                f"{of if n > 1 else 'peak'} at the {word} speed",
                f"{of} {verb} at the {word} speed, and may be higher beyond it: {key}",
            )


def too_few_samples(percentiles: Iterable[float], n: int) -> Iterator[Finding]:
    """Finding about extreme percentiles for which n samples are too few."""
    tail = (1.0 - confidence(Z_95)) / 2.0
    ends = {p: min(p, 100.0 - p) / 100.0 for p in percentiles}
    unknown = [p for p, end in ends.items() if (1.0 - end) ** n > tail]
    if n > 1 and unknown:
        advice = []
        if least := min((ends[p] for p in unknown if ends[p] > 0.0), default=0.0):
            needed = int(np.ceil(np.log(tail) / np.log1p(-least)))
            advice.append(f"mistuning.samples of {needed} and more")
        if 0.0 in ends.values():  # no number of samples bounds the extremes of all disks
            advice.append("convergence.percentiles without 0 and 100")
        yield Finding(
            REMARK,
            "few samples",
            f"percentiles {', '.join(f'{p:g}' for p in unknown)} have no 95 % interval with "
            f"{n} samples: {', '.join(advice)}",
        )
