"""Results of a run_up study as tables, lines and findings."""

from collections.abc import Iterator
from typing import Any

import numpy as np
from rich.table import Table

from hpcrub.config.run_up import ends_of, rates
from hpcrub.config.schema import Config
from hpcrub.config.text import counted, percent
from hpcrub.contact import status
from hpcrub.effects.coating import cut_through
from hpcrub.ranks import progress
from hpcrub.results.storage import ResultFile
from hpcrub.results.verdict import REMARK, SINGLE, USELESS, Finding
from hpcrub.runs import findings as common
from hpcrub.statistics.percentiles import finite, interval_in_words, with_interval
from hpcrub.studies.contact import second_order
from hpcrub.studies.contact.limits import limits_in_words

STEP_ERROR = 0.05  # effect of half the time step on a peak from which on it is told
GRAVITY = 9.81  # [m/s²]
CANTILEVER = 1.57  # participation of the first mode of a clamped beam in an even load, at its tip
FAINT = 1e-2  # of the largest peak: smaller ones are no vibrations
HARDLY = 0.1  # of a tuned disk's peak in another leg: no reference of an amplification
STRAY = 0.02  # of the casing's reach: a deflection by the Euler force that is told
BENT_STATUS = "tuned/second_order_status"
LOST = 0.01  # share of runs without a result, above which no percentile is usable


def of_disks(file: ResultFile, name: str = "peak_amplitude_m") -> np.ndarray:
    """Median of the repetitions of every run of every sample (V, n, rate, leg)."""
    return _median(file.read(f"samples/{name}"))


def of_tuned(file: ResultFile, name: str = "peak_amplitude_m") -> np.ndarray:
    """Median of the repetitions of the tuned disk (rate, leg)."""
    return _median(file.read(f"tuned/{name}"))


def _median(values: np.ndarray) -> Any:
    """Median over the repetitions, the last axis but one; NaN where one has no result."""
    return np.median(values, axis=-2)


def amplifications(file: ResultFile) -> np.ndarray:
    """Peak of every sample over that of the tuned disk in the same leg (V, n, rate, leg) [-].

    NaN in legs in which the tuned disk hardly moves.
    """
    return np.where(_hardly_moves(file), np.nan, _over(of_disks(file), of_tuned(file)))


def _hardly_moves(file: ResultFile) -> np.ndarray:
    """Legs in which the tuned disk moves little, beside its other legs at the rate (rate, leg)."""
    sizes = of_tuned(file)
    return sizes < HARDLY * np.fmax.reduce(sizes, axis=1, keepdims=True)


def _over(values: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Ratio of two sizes; NaN where the second one is 0, as nothing touched."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(others > 0.0, values / others, np.nan)


def _of_all(file: ResultFile, name: str) -> np.ndarray:
    """Values of the tuned disk, then of all samples, in one row."""
    return np.concatenate([file.read(f"{group}/{name}").ravel() for group in ("tuned", "samples")])


def _moves(sizes: np.ndarray) -> np.ndarray:
    """Which sizes are of disks that vibrate; others are of motions that die away."""
    return sizes > FAINT * np.nanmax(sizes, initial=0.0)


def leg_names(file: ResultFile) -> list[str]:
    """Names of the legs: up, down, with their number where there are several."""
    rises = file.read("rises").astype(bool)
    names, counts = [], {True: 0, False: 0}
    for rise in rises.tolist():
        counts[rise] += 1
        several = int(np.count_nonzero(rises == rise) > 1)
        names.append(("up" if rise else "down") + f" {counts[rise]}" * several)
    return names


def report(file: ResultFile) -> Iterator[str]:
    """A line for each rate: peaks of the tuned disk, and the medians of the last level's disks."""
    legs, sizes, tuned = leg_names(file), 1e3 * of_disks(file)[-1], 1e3 * of_tuned(file)
    steady = _steady_words(file)
    for k, rate in enumerate(file.read("hz_per_s")):
        parts = ", ".join(f"{leg} {peak:.3g} mm" for leg, peak in zip(legs, tuned[k], strict=True))
        text = f"tuned disk at {rate:g} Hz/s: {parts}{steady}"
        if len(seen := sizes[np.isfinite(sizes[:, k]).all(axis=1), k]):
            medians = ", ".join(f"{peak:.3g}" for peak in np.median(seen, axis=0))
            text += f"; median of {counted(len(seen), 'mistuned disk')} {medians} mm"
        yield text


def _steady_words(file: ResultFile) -> str:
    if "tuned/steady_reference_m" not in file:
        return ""
    return f"; steady {1e3 * float(file.read('tuned/steady_reference_m')):.3g} mm"


def answer(file: ResultFile, usable: bool) -> Iterator[str | Table]:
    """Tables of all runs and of the percentiles of all disks, and a line about chance.

    The first tables have a row for each rate and leg: sizes, and the disks beside a steady study.
    """
    for title, columns in (
        (f"Tuned disk, and most of all disks{_steady_words(file)}", _sizes(file)),
        ("Mistuned disks, all repetitions, over their steady peaks", beside_steady(file)),
    ):
        if not columns:
            continue
        found = progress.table(title, ("Hz/s", "leg", *columns))
        for rate, hz_per_s in enumerate(file.read("hz_per_s")):
            for leg, name in enumerate(leg_names(file)):
                cells = (f"{values[rate, leg]:.4g}" for values in columns.values())
                found.add_row(f"{hz_per_s:g}", name, *cells)
        yield found
    yield from limit_lines(file)
    if file.config.pattern_deviation is None and np.isfinite(of_disks(file)).any():
        yield percentile_table(file)
    yield chance_line(file)


def _sizes(file: ResultFile) -> dict[str, np.ndarray]:
    """Medians of the repetitions at every rate and leg, by their headings."""
    config = file.config
    shown = [("peak_amplitude_m", 1e3, "peak", "mm")]
    if config.observes_stress:
        shown.append(("peak_stress_pa", 1e-6, "stress", "MPa"))
    if config.contact.wears:
        shown.append(("worn_depth_m", 1e3, "worn", "mm"))
    columns = {}
    for name, factor, what, unit in shown:
        columns[f"{what}\ntuned [{unit}]"] = factor * of_tuned(file, name)
        most = factor * np.fmax.reduce(of_disks(file, name), axis=(0, 1))
        columns[f"{what}\nmost [{unit}]"] = most
    return columns


def percentile_table(file: ResultFile) -> Table:
    """A row for each level, rate, leg and percentile: peak and amplification with intervals."""
    at, config = file.config.convergence.percentiles, file.config
    has_steady = "samples/steady_peak_m" in file
    headings = ["level", "Hz/s", "leg", "percentile", "peak [mm]", "interval", "A", "interval"]
    found = progress.table(
        "Run-up: percentiles of the disks and their 95 % intervals; A over the tuned disk's run",
        (*headings, *(["over steady"] if has_steady else [])),
    )
    sizes, ratios = of_disks(file), file.read("samples/amplification")
    steady = file.read("samples/steady_peak_m") if has_steady else None
    for level, half_range in enumerate(config.mistuning.half_range[list(config.levels)]):
        for rate, hz_per_s in enumerate(file.read("hz_per_s")):
            for leg, name in enumerate(leg_names(file)):
                size, ratio = finite(sizes[level, :, rate, leg]), ratios[level, :, rate, leg]
                columns = with_interval(1e3 * size, at).T, with_interval(finite(ratio), at).T
                more: list[str] = []
                if steady is not None:
                    over = finite(_over(sizes[level, :, rate, leg], steady[level]))
                    more = [f"{p:.3f}" for p in np.percentile(over, at)] if over.size else []
                for k, percentile in enumerate(at):
                    cells = (
                        interval_in_words(*part, form=form)
                        for column, form in zip(columns, (".3g", ".3f"), strict=True)
                        for part in ([column[k][0]], column[k][1:])
                    )
                    first = f"±{100 * half_range:.3g} %", f"{hz_per_s:g}", name, f"{percentile:g}"
                    found.add_row(*first, *cells, *more[k : k + 1])
    return found


def beside_steady(file: ResultFile) -> dict[str, np.ndarray]:
    """Run-ups of many disks beside the steady peaks of `sources`, at each rate and in each leg.

    Numbers of disks, of those of which all repetitions are below or above their steady peak, and
    ratios of all repetitions [-], by their headings; nothing without sources, or without a result.
    """
    if "samples/steady_peak_m" not in file:
        return {}
    peaks, steady = file.read("samples/peak_amplitude_m"), file.read("samples/steady_peak_m")
    over = _over(peaks, np.broadcast_to(steady[:, :, None, None, None], peaks.shape))
    over = np.moveaxis(over, 3, -1).reshape(-1, *peaks.shape[2::2], peaks.shape[3])
    known = np.isfinite(over).all(axis=-1)  # (disks, rate, leg)
    if not known.any(axis=0).all():
        return {}
    over[~known] = np.nan
    return {
        "disks": np.count_nonzero(known, axis=0),
        "all below": np.count_nonzero(over.max(axis=-1) < 1.0, axis=0),
        "all above": np.count_nonzero(over.min(axis=-1) > 1.0, axis=0),
        "median ratio": np.nanmedian(over, axis=(0, -1)),
        "largest ratio": np.nanmax(over, axis=(0, -1)),
    }


def limit_lines(file: ResultFile) -> Iterator[str]:
    """Time and cycles above the limits, the most of all disks and repetitions."""
    limits = file.config.limits
    if limits.amplitude_mm is None and limits.stress is None:
        return
    seconds, cycles = (
        np.concatenate([file.read(f"{group}/{name}").reshape(-1, *file.shape(f"tuned/{name}"))
                        for group in ("tuned", "samples")])
        for name in ("seconds_above_s", "cycles_above")
    )  # fmt: skip
    words = limits_in_words(file.config)
    for rate, hz_per_s in enumerate(file.read("hz_per_s")):
        whole = seconds[:, rate].sum(axis=-1), cycles[:, rate].sum(axis=-1)
        known = np.isfinite(whole[0])
        beyond = (whole[0][known] > 0.0).mean() if known.any() else np.nan
        yield (
            f"{hz_per_s:g} Hz/s: {100.0 * beyond:.3g} % of all runs exceed {words}, for up to "
            f"{np.nanmax(whole[0]):.3g} s and {np.nanmax(whole[1]):.0f} cycles"
        )


def chance_line(file: ResultFile) -> str:
    """What the repetitions scatter, and how far a peak is known."""
    spread = []
    for group in ("tuned", "samples"):
        peaks = file.read(f"{group}/peak_amplitude_m")
        middle = _median(peaks)
        spread.append(finite(_over(np.ptp(peaks, axis=-2), middle)[_moves(middle)]))
    width = np.diff(file.read("interval_hz")).max(initial=0.0)
    n = file.config.run_up.repeats
    both = ", ".join(
        f"{name} {percent(np.median(part))} %"
        for name, part in zip(("tuned disk", "mistuned disks"), spread, strict=True)
        if part.size
    )
    step = _step_effect(file)
    parts = []
    if n > 1:
        parts.append(f"from the least to the largest of {n} repetitions a peak differs by: {both}")
    if np.isfinite(step):
        effect = f"{percent(step)} %"
        parts.append(f"half the time step changes the tuned disk's peak by {effect}")
    return "; ".join([*parts, f"peaks lie within intervals of {width:.3g} Hz"])


def _step_effect(file: ResultFile) -> float:
    """Largest change of the tuned disk's median peaks with half the time step [-]."""
    full, half = of_tuned(file), of_tuned(file, "half_step_peak_m")
    change = finite(np.abs(_over(half, full) - 1.0)[_moves(full)])
    return float(change.max()) if change.size else np.nan


def euler_line(config: Config, problem: Any) -> Iterator[str]:
    """Warning about the force by the gain of speed, which is left out, where it is not small."""
    fastest, radius = float(rates(config).max()), config.disk.tip_radius
    along = 2.0 * np.pi * fastest * radius
    first = float(np.sqrt(problem.reduced.tuned_eigenvalues[0]))
    moved = CANTILEVER * along / first**2
    reach = config.casing.outline.highest - config.clearance
    if reach > 0.0 and moved > STRAY * reach:
        yield (
            f"gain of speed: {fastest:g} Hz/s pull blades back by {along / GRAVITY:.2g} g at the "
            f"tips (Euler force), which would bend them by about {1e3 * moved:.2g} mm; the model "
            "leaves this out"
        )


def findings(file: ResultFile) -> Iterator[Finding]:
    """Findings against the runs of a file."""
    config, reasons = file.config, _of_all(file, "run_reason")
    lost = reasons[status.are_fatal(reasons)]
    if lost.size:
        words = f"no result in {len(lost)} of {len(reasons)} runs"
        most = status.words(int(status.count(lost).argmax()))
        severity = USELESS if len(lost) > LOST * len(reasons) else SINGLE
        yield Finding(severity, words, f'{words}, mostly by "{most}"')
    step = _step_effect(file)
    if step > STEP_ERROR:
        yield Finding(
            SINGLE, "time step",
            f"half the time step changes the tuned disk's peaks by {percent(step)} %: a smaller "
            "time.step_s, or more run_up.repeats where the motion is irregular",
        )  # fmt: skip
    if config.contact.wears:
        last = file.read("tuned/worn_depth_m")[..., -1], file.read("samples/worn_depth_m")[..., -1]
        yield from cut_through(config, np.concatenate([part.ravel() for part in last]), "runs")
    yield from _without_reference(file)
    yield from _of_other_speeds(file)
    yield from _above_steady(file)
    yield from _at_the_ends(file)
    if config.run_up.repeats < 4:
        yield Finding(
            REMARK, "few repetitions",
            "what chance does to a peak shows little in "
            f"{counted(config.run_up.repeats, 'repetition')}: run_up.repeats up to 8",
        )  # fmt: skip
    yield from common.kinematics(config, _of_all(file, "peak_amplitude_m"), _second_order(file))
    if config.pattern_deviation is None:
        yield from common.too_few_samples(config.convergence.percentiles, len(config.samples))


def pending_to_second_order(file: ResultFile) -> list[int]:
    """Rate of the tuned disk's largest peak, if it is still to be computed to second order."""
    largest = np.fmax.reduce(np.nan_to_num(of_tuned(file)), axis=1)
    rate = int(largest.argmax())
    due = second_order.matters(file.config, float(largest[rate]))
    return [rate] if due and not file.read(BENT_STATUS, rate) else []


def _second_order(file: ResultFile) -> Finding | None:
    """What the tuned disk says to second order, in the leg in which it moves most."""
    small, bent = of_tuned(file), of_tuned(file, "second_order_peak_m")
    known = np.where(np.isnan(bent), 0.0, np.nan_to_num(small)).ravel()
    most = [int(known.argmax())]
    return second_order.of_others(file, "the tuned disk", small.ravel()[most], bent.ravel()[most])


def _without_reference(file: ResultFile) -> Iterator[Finding]:
    """Finding about legs in which the tuned disk is no reference of an amplification."""
    still, sizes, legs = _hardly_moves(file), of_tuned(file), leg_names(file)
    for rate, leg in np.argwhere(still)[:1]:
        where = f"{legs[leg]} at {file.read('hz_per_s')[rate]:g} Hz/s"
        yield Finding(
            REMARK, "no reference",
            f"{where} the tuned disk moves by {1e3 * sizes[rate, leg]:.2g} mm only, and by "
            f"{1e3 * np.nanmax(sizes[rate]):.3g} mm in another leg: no A is told there, nor in "
            f"other such legs, {still.sum()} in all",
        )  # fmt: skip


def _of_other_speeds(file: ResultFile) -> Iterator[Finding]:
    """Finding about a steady study whose range of speeds is another one than that of the runs."""
    if "steady_speed_hz" not in file:
        return
    speeds, mine = file.read("steady_speed_hz"), sorted(ends_of(file.config))
    ends = [speeds[0], speeds[-1]]
    if not np.allclose(ends, mine, rtol=0.0, atol=np.ptp(speeds[:2]) + 1e-9):
        peak = speeds[np.nan_to_num(file.read("tuned/steady_amplitude_m")).argmax()]
        yield Finding(
            REMARK if mine[0] <= peak <= mine[1] else SINGLE, "a steady study of other speeds",
            f"runs from {mine[0]:g} to {mine[1]:g} Hz stand beside a steady study (sources) from "
            f"{ends[0]:g} to {ends[1]:g} Hz, tuned peak at {peak:g} Hz: ratios are of these peaks",
        )  # fmt: skip


def _above_steady(file: ResultFile) -> Iterator[Finding]:
    """Finding about disks whose run-up is above their steady answer."""
    beside = beside_steady(file)
    if not beside or not beside["all above"].any():
        return
    n, above, largest = (beside[name] for name in ("disks", "all above", "largest ratio"))
    rate, leg = np.unravel_index((above / n).argmax(), n.shape)
    yield Finding(
        REMARK, "run-ups above the steady answer",
        f"in all repetitions {above[rate, leg]} of {n[rate, leg]} disks go above "
        f"their steady peak ({file.read('hz_per_s')[rate]:g} Hz/s, {leg_names(file)[leg]}), single "
        f"runs by up to {percent(float(largest[rate, leg]) - 1.0)} %: motions of another "
        "branch, or that have not settled; the steady study is no upper bound",
    )  # fmt: skip


def _at_the_ends(file: ResultFile) -> Iterator[Finding]:
    """Finding about peaks in the first or last interval of speed."""
    middles, speeds = file.read("interval_hz"), sorted(ends_of(file.config))
    at = _of_all(file, "peak_speed_hz")[_moves(_of_all(file, "peak_amplitude_m"))]
    for end, word, key in ((0, "lowest", "below"), (-1, "highest", "above")):
        n = int(np.count_nonzero(at == middles[end]))
        if n > 0.05 * max(len(at), 1) and len(middles) > 1:
            where, verb = f"at the {word} speed", "lie" if n > 1 else "lies"
            peaks = f"{n} of {len(at)} peaks"
            yield Finding(
                SINGLE, f"{peaks} {where}", f"{peaks} {verb} {where}, and may be higher beyond "
                f"it: run_up with speeds {key} {speeds[end]:g} Hz",
            )  # fmt: skip
