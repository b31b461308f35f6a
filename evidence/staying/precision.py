"""Error of the percentiles of A_nl against the time of a sample, by rule of the steady state."""

import time

import numpy as np
from matplotlib import rc_context
from matplotlib.figure import Figure

from evidence import pictures
from evidence.progress import followed
from evidence.staying.follow import follow
from evidence.staying.scenes import TUNED, Scenes
from hpcrub.plot.style import BLACK, BLUE, ORANGE, STYLE
from hpcrub.response.sweep import run_sweep

N_SAMPLES, N_TUNED = 48, 9
DECILES = tuple(range(10, 100, 10))
PAPER = "the paper's rule: two windows alike"
BLIND = "means of windows, growth not looked at"
NOW = "means of windows, growth looked at"
TICKS = 0.5, 1, 2, 5, 10, 20
COLOURS = {PAPER: BLACK, BLIND: ORANGE, NOW: BLUE}
EQUAL = {"mistuning.reference": "symmetric"}
# (rule, label, changes of the input, changes of the criteria)
RULES = (
    *((PAPER, f"{n}×", EQUAL, {"rule": "last_window", "confirmations": n}) for n in (1, 2, 3)),
    *((BLIND, f"{100 * e:g} %", EQUAL, {"watches_growth": False, "max_error": e})
      for e in (0.3, 0.15, 0.05)),
    *((NOW, f"{100 * e:g} %", {}, {"max_error": e}) for e in (0.3, 0.15, 0.05)),
)  # fmt: skip
PLACES = {
    "four bumps, damping 0.005 (quick start)": {"mistuning.half_range_percent": [4]},
    "six bumps, damping 0.03": TUNED[6, 0.03] | {"mistuning.half_range_percent": [4]},
}


def deciles(tuned, samples):
    """Deciles of A_nl from the peaks of tuned runs and samples [m]."""
    return np.percentile(samples, DECILES) / np.median(tuned)


def measure(changes):
    """Rows (rule, label, seconds a sample, mean error of the deciles) of one place."""
    disks = [*((None, run) for run in range(N_TUNED)), *((0, n) for n in range(N_SAMPLES))]
    changes = changes | {"mistuning.samples": N_SAMPLES}
    scenes = Scenes("quickstart", changes)
    parts = [
        follow(scenes.modes(*disk), scenes.scene(), scenes.speeds, 6.0)
        for disk in followed(disks, "truth")
    ]
    late = np.array([np.nanmax(part.truth) for part in parts])
    exact = deciles(late[:N_TUNED], late[N_TUNED:])
    for rule, label, keys, criteria in followed(RULES, "rules"):
        own = Scenes("quickstart", changes | keys)
        scene, peaks, began = own.scene(**criteria), [], time.process_time()
        for disk in disks:
            result = run_sweep(own.modes(*disk), scene, own.speeds)
            peaks.append(np.nanmax(result.amplitude))
        cost = (time.process_time() - began) / len(disks)
        found = deciles(np.array(peaks[:N_TUNED]), np.array(peaks[N_TUNED:]))
        yield rule, label, cost, float(np.mean(np.abs(found / exact - 1.0)))


@rc_context(STYLE)
def draw(results, path):
    """Draw the error over the time of a sample; results: {place: rows}."""
    figure = Figure(figsize=(5.6 * len(results), 4.6))
    axes = figure.subplots(1, len(results), sharey=True)
    for panel, (place, rows) in zip(axes, results.items(), strict=True):
        for rule, colour in COLOURS.items():
            of_rule = [row[1:] for row in rows if row[0] == rule]
            labels, seconds, error = zip(*of_rule, strict=True)
            panel.plot(seconds, 100 * np.array(error), color=colour, marker="o", label=rule)
            up = -14 if rule == BLIND else 6
            order = np.argsort(seconds)
            for one, side in zip(order, ("right", "center", "left"), strict=True):
                at, look = (seconds[one], 100 * error[one]), {"fontsize": 9, "ha": side}
                panel.annotate(labels[one], at, (0, up), textcoords="offset points", **look)
        panel.set(xlabel="core seconds a sample", yscale="log", yticks=TICKS, yticklabels=TICKS)
        panel.minorticks_off()
        panel.margins(x=0.08)
        panel.set_title(place, fontsize="medium")
    axes[0].set_ylabel("mean error of the deciles of A_nl [%]")
    axes[0].legend(fontsize="small")
    pictures.save(figure, path, dpi=130)
