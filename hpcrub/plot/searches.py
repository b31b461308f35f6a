"""Figures of the studies that search or check: threshold, rare, patterns, checklist."""

import numpy as np
from matplotlib.axes import Axes

from hpcrub.config.schema import Config
from hpcrub.config.text import name_and_unit, percent
from hpcrub.plot.amplifications import Look, draw_curves, explain
from hpcrub.plot.canvas import Canvas, figure
from hpcrub.plot.style import BLACK, BLUE, DOTTED, GREEN, ORANGE
from hpcrub.results.storage import ResultFile
from hpcrub.statistics.percentiles import Z_95, finite, probability_interval
from hpcrub.statistics.threshold import ABOVE, BELOW, UNKNOWN
from hpcrub.studies.checklist import CHANGES, LEAST_CHANGE, moved
from hpcrub.studies.contact.limits import limits_in_words, severities
from hpcrub.studies.contact.trials import BENT
from hpcrub.studies.patterns import Rounds, in_letters
from hpcrub.studies.rare import last_estimate, probability_in_words
from hpcrub.studies.threshold import crossing_in_words, ends_of_crossing, search_of

FOOT = 1e-4  # least probability at the foot of the figure of a threshold
SIDES = {ABOVE: ("not met", ORANGE), UNKNOWN: ("not known", "0.55"), BELOW: ("met", GREEN)}


@figure("threshold", what="probability of exceeding a limit over a key", main=True)
def threshold(canvas: Canvas, file: ResultFile) -> None:
    """Probability of exceeding the limit at the values looked at, and the amplitudes there.

    Bars are 95 % intervals. Green: the asked probability is met, with 99 % confidence; orange: it
    is not; grey: neither is known. The line is the answer, and the band is where the probability
    crosses the asked one. Values with a single disk are not drawn at the left. Diamonds are what
    the second order makes of the first disks at the crossing.
    """
    chance, size = canvas.panels(1, 2, (13.0, 5.2))[0]
    _draw_probability(chance, file)
    _draw_amplitudes(size, file)
    name, unit = name_and_unit(Config, file.config.threshold.key or "")
    values, (safe, _) = file.read("value"), ends_of_crossing(file)
    for panel in (chance, size):
        for ends in search_of(file).crossings():
            panel.axvspan(*values[list(ends)], color="0.85", lw=0, label="crossing")
        if np.isfinite(safe):
            panel.axvline(safe, color=GREEN, lw=1.5, ls="--", zorder=1, label="answer")
        panel.set_xlabel(f"{name} [{unit.strip() or '-'}]")
    if np.isfinite(safe):
        chance.annotate(
            f"answer: {safe:g}{unit}", (safe, 1.0), xycoords=("data", "axes fraction"),
            xytext=(0, 3), textcoords="offset points", ha="center", color=GREEN,
        )  # fmt: skip
    canvas.note(crossing_in_words(file))


def _draw_probability(axes: Axes, file: ResultFile) -> None:
    """Draw the share of disks beyond the limit, with its interval, at every value computed."""
    n, above, side = (file.read(name) for name in ("n_disks", "n_above", "side"))
    low, high = (file.read(f"probability_{end}") for end in ("low", "high"))
    asked, share = file.config.threshold.probability, above / np.maximum(n, 1)
    seen = n > min(1, n.max() - 1)
    foot = 0.3 * min(asked, share[seen & (share > 0.0)].min(initial=1.0))
    foot = max(FOOT, float(foot))
    for code, (words, color) in SIDES.items():
        these = seen & (side == code)
        if not these.any():  # an empty curve would take room at the corner of the figure
            continue
        size = np.maximum(share[these], foot)  # none of the disks: at the foot
        ends = np.array([size - np.maximum(low[these], foot), high[these] - size])
        axes.errorbar(
            file.read("value")[these], size, ends, fmt="o", ms=6, color=color, capsize=3,
            label=words, clip_on=False, zorder=3,
        )  # fmt: skip
    axes.axhline(asked, label=f"asked: {percent(asked)} %", **DOTTED)
    axes.set(yscale="log", ylim=(foot, 1.2))
    axes.set_ylabel(f"probability of exceeding\n{limits_in_words(file.config)}")
    axes.yaxis.set_major_formatter(lambda share, _: f"{100.0 * share:g} %")


def _draw_amplitudes(axes: Axes, file: ResultFile) -> None:
    """Draw percentiles of the largest amplitudes of the disks computed at every value."""
    peaks, n = 1e3 * file.read("peak_amplitude_m"), file.read("n_disks")
    at, look = file.config.convergence.percentiles, Look("largest amplitude", BLUE)
    explain(axes, [look], at)
    values, seen = file.read("value"), n > min(1, n.max() - 1)
    axes.plot(values, peaks[:, 0], ".-", ms=4, lw=1.0, color="0.6", label="the first disk")
    computed = [finite(row[:disks]) for row, disks in zip(peaks[seen], n[seen], strict=True)]
    draw_curves(axes, values[seen], computed, at, look, from_one=False)
    bent = 1e3 * file.read(BENT)
    for row, disk in np.argwhere(np.isfinite(bent)):
        ends = peaks[row, disk], bent[row, disk]
        axes.plot(
            [values[row]] * 2, ends, "-D", markevery=[1], ms=5, lw=1.0, color=ORANGE, zorder=4,
            label="to second order",
        )  # fmt: skip
    limit = file.config.limits.amplitude_mm
    if limit is not None:  # one of stress may decide as well
        axes.axhline(limit, label=f"limit of {limit:g} mm", **DOTTED)
    axes.set(ylabel="largest amplitude [mm]", ylim=(0.0, None))


@figure("rare", what="a small probability of exceeding a limit", main=True)
def rare(canvas: Canvas, file: ResultFile) -> None:
    """Probability of exceeding parts of the limit, with 95 % intervals."""
    axes = canvas.panels(1, 1, (8.5, 5.2))[0, 0]
    canvas.note(probability_in_words(file))
    size = severities(file)[: last_estimate(file)[0]]  # in parts of the limit; NaN: beyond all
    n, known = len(size), finite(size)
    if not len(known):
        return
    low, high = min(1.0, np.quantile(known, 0.3)), max(1.0, known.max())
    at = np.linspace(low, high + 0.1 * (high - low), 40)
    above = n - np.searchsorted(np.sort(known), at, side="right")
    some = above > 0
    chance = above[some] / n
    bars = np.abs(probability_interval(above[some], n, Z_95) - chance)
    axes.errorbar(at[some], chance, bars, fmt="o", ms=4, color=BLUE, capsize=2, label="disks")
    axes.axvline(1.0, label="limit", **DOTTED)
    axes.set(yscale="log", ylim=(0.1 / n, 1.3))
    axes.set(xlabel="part of the limit", ylabel="probability of exceeding it")


@figure("patterns", what="patterns of blade types, ranked", main=True)
def patterns(canvas: Canvas, file: ResultFile) -> None:
    """Percentile of the linear amplification of all patterns, and of those left beside contact.

    Every pattern is drawn with the disks that it had when it was dropped; the dotted line is the
    disk without a pattern.
    """
    rounds = Rounds(file)
    in_contact = np.isfinite(file.read("contact_amplitude_m")).any()
    panels = canvas.panels(1, 3 if in_contact else 2, (17.0 if in_contact else 12.0, 5.2))[0]
    _draw_all(panels[0], file, rounds)
    rows = [*rounds.left, 0]
    for panel in panels[1:]:
        _rows(panel, [""] * len(rows))
        panel.locator_params(axis="x", nbins=6)
    panels[1].set_yticklabels([in_letters(rounds.words[p]) for p in rows], family="monospace")
    _draw_left(panels[1], file, rounds, rows)
    for panel in panels[2:]:
        panel.plot([], [], ".", color="0.6", label="a disk")
        panel.set(xlabel="largest amplitude in contact [mm]", title="the same in contact")
        for place, p in enumerate(rows):
            size = finite(1e3 * file.read("contact_amplitude_m", p))
            panel.plot(size, np.full(len(size), place), ".", color="0.6", ms=4)
            if size.size:
                look = {"color": ORANGE, "ms": 6, "label": "median in contact"}
                panel.plot(np.median(size), place, "o", **look)


def _rows(axes: Axes, names: list[str]) -> None:
    """Give the axis of heights a row for each name, from the top."""
    axes.set_yticks(range(len(names)), names)
    axes.set_ylim(len(names) - 0.4, -0.6)
    axes.grid(visible=False, axis="y")


def _draw_all(axes: Axes, file: ResultFile, rounds: Rounds) -> None:
    """Draw the percentile of every pattern, sorted; the shade tells the number of its disks."""
    order = 1 + np.argsort(rounds.percentile[1:])
    place = np.arange(1, len(order) + 1)
    for n in sorted(set(rounds.n_disks[1:])):
        these = rounds.n_disks[order] == n
        shade = 0.25 + 0.75 * np.log(max(n, 2)) / np.log(max(rounds.most, 2))
        axes.plot(place[these], rounds.percentile[order][these], ".", ms=5, color=BLUE, alpha=shade)
    axes.axhline(rounds.percentile[0], label="no pattern", **DOTTED)
    axes.plot([], [], ".", ms=7, color=BLUE, label="patterns; the darker, the more disks")
    at = file.config.patterns.percentile
    axes.set(xlabel="rank", ylabel=f"percentile {at:g} of the linear amplification")


def _draw_left(axes: Axes, file: ResultFile, rounds: Rounds, rows: list[int]) -> None:
    """Draw linear amplifications of the last patterns: median, and the percentile that ranks."""
    at = 50.0, file.config.patterns.percentile
    for place, p in enumerate(rows):
        values = file.read("amplification", p)[: rounds.n_disks[p]]
        values = np.where(np.isfinite(values), values, np.inf)  # flutter ranks as the worst
        middle, high = np.percentile(values, at, method="higher")
        axes.plot([middle, high], [place, place], "-", color=BLUE, lw=1.0)
        axes.plot(middle, place, "o", color=BLUE, ms=5, label="median")
        axes.plot(high, place, "^", color=BLUE, ms=7, label=f"percentile {at[1]:g}")
    axes.set(xlabel="linear amplification", title="patterns left")


@figure("checklist", what="changes of the amplitude with one thing changed", main=True)
def checklist(canvas: Canvas, file: ResultFile) -> None:
    """Mean change of the largest amplitudes of a few disks, and every disk as a dot.

    Bars are 95 % intervals of the mean. Blue: of the computation; orange: of an input.
    """
    size = file.read("peak_amplitude_m")
    size[np.isinf(size)] = np.nan  # disks without a result
    changes = moved(size)
    rows = [n for n, change in enumerate(changes, 1) if np.isfinite(change[0])]
    axes = canvas.panels(1, 1, (9.5, 1.6 + 0.42 * len(rows)))[0, 0]
    axes.axvspan(-100 * LEAST_CHANGE, 100 * LEAST_CHANGE, color="0.92", zorder=0, label="below 1 %")
    axes.axvline(0.0, color=BLACK, lw=1.0)
    for place, n in enumerate(rows):
        mean, error, _ = changes[n - 1]
        colour = BLUE if CHANGES[n].is_error else ORANGE
        single = 100 * (size[n] / size[0] - 1.0)
        axes.plot(single, np.full(len(single), place), ".", color="0.6", ms=5, zorder=1)
        axes.errorbar(100 * mean, place, xerr=100 * error, fmt="o", color=colour, capsize=4, ms=7)
    axes.plot([], [], "o", color=BLUE, label="of the computation")
    axes.plot([], [], "o", color=ORANGE, label="of an input")
    axes.plot([], [], ".", color="0.6", label="a disk")
    _rows(axes, [CHANGES[n].what for n in rows])
    axes.set_xlabel("change of the largest amplitude [%]")
