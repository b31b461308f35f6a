"""Run time against error of the planar disk: tables and figure, from what was measured."""

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt
import numpy as np

from evidence.benchmarks import work_precision as wp
from evidence.page import table

COLOURS = {"exact_modal": "#0072B2", "central_difference": "#D55E00"}


def precision(results):
    """Parts of the page: all settings, and what rounding alone changes."""
    rows = [
        (setting.label + (" (default)" if setting == wp.DEFAULT else ""), f"{r['seconds']:.3f}",
         f"{100 * r['not_steady']:.0f}", f"{100 * wp.score(results, setting):.1f}",
         f"{100 * wp.sample_error(results, setting):.1f}")
        for setting, r in results.items()
    ]  # fmt: skip
    heads = "setting", "s/sample", "not steady %", "deciles of A_nl, %", "sample peak, %"
    facts = [
        [f"points that keep their amplitude to {100 * wp.PERIODIC:g} %",
         f"{100 * wp.share_periodic(results):.0f} %"],
        ["floor of the deciles", f"{100 * wp.floor(results):.1f} %"],
    ]  # fmt: skip
    return {
        "settings": table(heads, rows),
        "chance": table(["what rounding alone changes", "value"], facts),
    }


def precision_figure(results, path):
    """Cost against the error of deciles and of single peaks."""
    figure, (left, middle) = plt.subplots(1, 2, figsize=(11, 5.5), layout="constrained")
    for axis, error in ((left, wp.score), (middle, wp.sample_error)):
        for scheme, style in zip(wp.SCHEMES, ("o-", "s-"), strict=True):
            chosen = [s for s in results if s.scheme == scheme and not s.nudge]
            cost = [results[s]["seconds"] for s in chosen]
            errors = [100 * error(results, s) or np.nan for s in chosen]  # none of the reference
            axis.plot(cost, errors, style, color=COLOURS[scheme], label=f"{scheme}, step in µs")
            for s, x, y in zip(chosen, cost, errors, strict=True):
                if np.isfinite(y):
                    axis.annotate(f"{1e6 * s.step:g}", (x, y), xytext=(3, 6), fontsize=8,
                                  textcoords="offset points")  # fmt: skip
        axis.set(xscale="log", yscale="log", xlabel="seconds per sample and core")
        axis.grid(alpha=0.3)
    left.axhspan(0.0, 100 * wp.floor(results), color="0.93", zorder=-1,
                 label="floor: fine runs among themselves")  # fmt: skip
    left.set(ylabel="mean error of the deciles 10 … 90 of A_nl [%]")
    middle.set(ylabel="median error of the peak of a sample [%]")
    left.legend(frameon=False, fontsize=9)
    figure.savefig(path, dpi=120)
    plt.close(figure)
