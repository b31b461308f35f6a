"""How good are tests of the steady state? Compared on the same motions (`histories`)."""

from typing import NamedTuple

import matplotlib.pyplot as plt
import numpy as np

from evidence import page
from evidence.stress.histories import FIRST_CHECK, LEVELS, WINDOWS
from hpcrub.plot.style import BLACK, BLUE, ORANGE, STYLE
from hpcrub.response.steady import SteadyCriteria

PER_TURN = 4  # blocks per revolution
WATCHED = 2.0  # [s] after acceptance
CHANGE = 0.01  # of amplitude that counts as too early
PERCENTILES = (1, 50, 99)
PAPER = SteadyCriteria(max_time=5.0)


class Test(NamedTuple):
    """One way to accept a motion as steady."""

    name: str
    criteria: SteadyCriteria = PAPER


class Verdict(NamedTuple):
    """What a test says of P points."""

    time: np.ndarray  # (P,) simulated [s]
    accepted: np.ndarray  # (P,) bool
    amplitude: np.ndarray  # (P,) [m]
    # of the amplitude over three revolutions in the next WATCHED seconds, relative to the accepted:
    drift: np.ndarray  # (P,) largest change
    bias: np.ndarray  # (P,) of its mean
    trend: np.ndarray  # (P,) mean of the second half over that of the first, less 1


TESTS = (
    Test("paper"),
    Test("2 confirmations", PAPER._replace(confirmations=2)),
    Test("3 confirmations", PAPER._replace(confirmations=3)),
    Test("5 confirmations", PAPER._replace(confirmations=5)),
    Test("windows of 10 revolutions", PAPER._replace(window_revolutions=10)),
    Test("correlation above 0.99", PAPER._replace(min_correlation=0.99)),
    Test("amplitude within 0.2 %", PAPER._replace(max_amplitude_change=0.002)),
    Test("amplitude within 0.05 %", PAPER._replace(max_amplitude_change=0.0005)),
    Test("paper, at most 3 s", PAPER._replace(max_time=3.0)),
    Test("paper, at most 2 s", PAPER._replace(max_time=2.0)),
)


def judge(histories, criteria):
    """Verdict of one test on all points."""
    rows = [_judge(histories, p, criteria) for p in range(len(histories.speed))]
    return Verdict(*(np.array(column) for column in zip(*rows, strict=True)))


def _judge(h, p, criteria):
    window = criteria.window_revolutions * PER_TURN
    w = WINDOWS.index(criteria.window_revolutions)
    per_second = h.speed[p] * PER_TURN
    last_check = int((criteria.max_time - FIRST_CHECK) * h.speed[p])
    passed = 0
    for k in range(0, last_check + 1, criteria.extend_revolutions):
        now = h.first[p] + k * PER_TURN
        if now < 2 * window:
            continue
        before, last = h.peak[p, now - 2 * window : now].reshape(2, window, -1).max(axis=1)
        tip = np.argmax(last)
        change = abs(last[tip] - before[tip])
        steady = change <= criteria.max_amplitude_change * last[tip]
        steady &= h.correlation[p, w, k] > criteria.min_correlation
        passed = passed + 1 if steady else 0
        if passed >= criteria.confirmations:
            break
    end = now + int(WATCHED * per_second)
    later = rolling_amplitude(h.peak[p, now:end]) / last.max()
    half = len(later) // 2
    return (
        now / per_second,
        passed >= criteria.confirmations,
        last.max(),
        np.abs(later - 1.0).max(),
        later.mean() - 1.0,
        later[half:].mean() / later[:half].mean() - 1.0,
    )


def rolling_amplitude(peak):
    """Largest |u_t| over all tips and three revolutions, at every block; peak (B, N)."""
    n = PAPER.window_revolutions * PER_TURN
    return np.lib.stride_tricks.sliding_window_view(peak.max(axis=1), n).max(axis=1)


def amplifications(histories, verdict):
    """A_nl of every sample (levels, n) under one test: its peak over that of the tuned disk."""
    tuned = verdict.amplitude[histories.level < 0].max()
    levels = range(histories.level.max() + 1)
    samples = range(histories.sample.max() + 1)
    return np.array(
        [
            [
                verdict.amplitude[(histories.level == v) & (histories.sample == s)].max() / tuned
                for s in samples
            ]
            for v in levels
        ]
    )


def summary(histories, verdict):
    """Numbers of one test: shares of points, mean time, percentiles of A_nl (levels, 3)."""
    points = histories.level >= 0
    accepted = verdict.accepted[points]
    drift, bias, trend = (x[points][accepted] for x in (verdict.drift, verdict.bias, verdict.trend))
    return {
        "not_steady": 1.0 - accepted.mean(),
        "drift_1": (drift > CHANGE).mean(),
        "drift_5": (drift > 5.0 * CHANGE).mean(),
        "trend_1": (np.abs(trend) > CHANGE).mean(),
        "trend_5": (np.abs(trend) > 5.0 * CHANGE).mean(),
        "bias": bias.mean(),
        "scatter": bias.std(),
        "time": verdict.time[points].mean(),
        "tuned": verdict.amplitude[~points].max(),
        "percentiles": np.percentile(amplifications(histories, verdict), PERCENTILES, axis=1).T,
    }


def table(histories):
    """Markdown table of all tests, one row each."""
    percentiles = [f"A_nl ±{100 * level:g} %" for level in LEVELS]
    heads = ["test", "not steady", "> 1 % later", "> 5 % later", "trend > 1 %", "trend > 5 %"]
    heads += ["mean offset", "scatter", "mean time [s]", "tuned peak [mm]", *percentiles]
    rows = []
    for test in TESTS:
        s = summary(histories, judge(histories, test.criteria))
        shares = [f"{100 * s[k]:.1f} %" for k in ("not_steady", "drift_1", "drift_5")]
        shares += [f"{100 * s[k]:.1f} %" for k in ("trend_1", "trend_5")]
        rest = [f"{100 * s['bias']:+.2f} %", f"{100 * s['scatter']:.1f} %", f"{s['time']:.2f}"]
        rest += [f"{1e3 * s['tuned']:.1f}"]
        rest += [" / ".join(f"{p:.2f}" for p in row) for row in s["percentiles"]]
        rows.append([test.name, *shares, *rest])
    return page.table(heads, rows)


def draw(histories, path):
    """Figure: amplitudes over time of three points, and where they are after acceptance."""
    verdict = judge(histories, PAPER)
    with plt.rc_context(STYLE):
        figure, (left, right) = plt.subplots(1, 2, figsize=(12, 4.8), layout="constrained")
        points = np.flatnonzero((histories.level >= 0) & verdict.accepted)
        order = points[np.argsort(verdict.drift[points])]
        shown = order[[0, len(order) // 2, -len(order) // 50]]
        for p, colour, style in zip(shown, (BLACK, BLUE, ORANGE), ("--", "-", "-."), strict=True):
            rolling = 1e3 * rolling_amplitude(histories.peak[p])
            n = PAPER.window_revolutions * PER_TURN
            t = (np.arange(len(rolling)) + n) / (PER_TURN * histories.speed[p])
            label = f"±{100 * LEVELS[histories.level[p]]:g} %, {histories.speed[p]:.2f} Hz"
            left.plot(t, rolling, style, color=colour, lw=1.5, label=label)
            left.plot(verdict.time[p], 1e3 * verdict.amplitude[p], "o", color=colour, ms=9)
        left.set(xlabel="time [s]", ylabel="amplitude over three revolutions [mm]", ylim=(0, None))
        left.set_title("Dots: accepted by the paper's test")
        left.legend(loc="lower right")
        edges = np.linspace(-25, 25, 51)
        for name, colour, filled in (("paper", BLUE, True), ("3 confirmations", ORANGE, False)):
            criteria = next(test.criteria for test in TESTS if test.name == name)
            v = judge(histories, criteria)
            bias = 100 * v.bias[v.accepted & (histories.level >= 0)]
            label = f"{name}: {len(bias)} points, {bias.mean():+.1f} ± {bias.std():.1f} %"
            kind = "stepfilled" if filled else "step"
            right.hist(bias, edges, density=True, histtype=kind, color=colour, lw=2, label=label,
                       alpha=0.5 if filled else 1.0)  # fmt: skip
        right.set(xlabel="next 2 s over accepted amplitude [%]")
        right.set(ylabel="density [1/%]", title="No bias, but scatter")
        right.legend(loc="upper center", bbox_to_anchor=(0.5, -0.15))
        figure.savefig(path, dpi=150)
        plt.close(figure)
