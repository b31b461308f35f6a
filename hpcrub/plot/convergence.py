"""How the percentiles of contact studies converge with the number of samples."""

from typing import Any

import numpy as np
from matplotlib.ticker import LogLocator

from hpcrub.errors import InputError
from hpcrub.plot.canvas import Canvas, figure
from hpcrub.plot.families import labels, ordered
from hpcrub.plot.style import BLACK, shades
from hpcrub.results.storage import ResultFile
from hpcrub.statistics.percentiles import MIN_VALUES, confidence

MOST_COLUMNS = 4  # percentiles with a panel each; of more, the first, the middle and the last


@figure("contact", paper="10", what="running means of the percentiles", several=True, alone=False,
        random=True)  # fmt: skip
def running_means(canvas: Canvas) -> None:
    """Running means of the percentiles of A_nl: a row for every file, a column each percentile."""
    for panel in _draw(canvas, "mean_of_percentile", 1.0)[:, 0]:
        panel.set_ylabel("mean of the\npercentile of $A_{nl}$ [-]")


@figure("contact", paper="11", what="convergence errors", several=True, alone=False, random=True)
def convergence_errors(canvas: Canvas) -> None:
    """Convergence errors, equation (6): a row for every file, a column for each percentile."""
    files = ordered(canvas.files)
    z = sorted({file.config.convergence.z for file in files})
    level = " and ".join(f"{100 * confidence(value):.1f} %" for value in z)
    for file, row in zip(files, _draw(canvas, "convergence_error", 100.0), strict=True):
        for panel in row:
            for line in panel.get_lines():  # the logarithm of 0, of estimates that are all equal
                line.set_ydata(np.ma.masked_less_equal(line.get_ydata(), 0.0))
            target = 100 * file.config.convergence.target_error
            panel.axhline(target, color=BLACK, lw=1.2, ls=":", label="target")
            panel.set_yscale("log")
            panel.yaxis.set_major_locator(LogLocator(subs=(1, 3)))
            panel.yaxis.set_major_formatter("{x:g}")
            panel.yaxis.set_minor_formatter("")
        row[0].set_ylabel("convergence error\nof $A_{nl}$ [%]")
    canvas.title(f"Convergence error by equation (6) of the paper, for {level}")


def _draw(canvas: Canvas, name: str, scale: float) -> Any:
    """A statistic of the contact amplifications; colours tell σ."""
    files = ordered(canvas.files)
    for file in files:
        _require_estimates(file)
    shown = _shown(files)
    sigmas = np.unique(np.concatenate([file.read("sigma") for file in files]))
    colours = dict(zip(sigmas, shades(len(sigmas)), strict=True))
    size = (max(6.0, 4.0 * len(shown)), 2.9 * len(files) + 1.0)
    axes = canvas.panels(len(files), len(shown), size, sharey="row", sharex="row")
    for file, row, label in zip(files, axes, labels(files), strict=True):
        at, values = (
            list(file.config.convergence.percentiles),
            file.read(f"statistics/contact/{name}"),
        )
        seen = file.read("statistics/contact/samples_seen")
        known = seen[np.isfinite(values).any(axis=(0, 1))]
        few = slice(MIN_VALUES - 1)
        for panel, percentile in zip(row, shown, strict=True):
            panel.set_title(f"{label}: percentile {percentile:g}", fontsize=11)
            if percentile not in at:
                panel.set_axis_off()
                continue
            for sigma, of_level in zip(file.read("sigma"), values, strict=True):
                line, colour = scale * of_level[at.index(percentile)], colours[sigma]
                panel.plot(seen, line, color=colour, lw=1.6, label=f"σ = {100 * sigma:.1f} %")
                panel.plot(seen[few], line[few], "o", ms=5, mfc="w", mec=colour)
            panel.set(xscale="log", xlabel="samples" if file is files[-1] else "")
            panel.set_xlim(0.9 * known[0], 1.1 * known[-1])
            panel.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
            panel.xaxis.set_major_formatter("{x:,.0f}")
            panel.xaxis.set_minor_formatter("")
    canvas.note(
        f"Hollow: fewer than {MIN_VALUES} estimates, each of convergence.step more samples; "
        "convergence is not judged on these."
    )
    return axes


def _shown(files: list[ResultFile]) -> list[float]:
    at = sorted({p for file in files for p in file.config.convergence.percentiles})
    return at if len(at) <= MOST_COLUMNS else [at[0], at[len(at) // 2], at[-1]]


def _require_estimates(file: ResultFile) -> None:
    """Raises InputError when no level has two percentile values, which an error needs."""
    if not np.isfinite(file.read("statistics/contact/convergence_error")).any():
        step = file.config.convergence.step
        raise InputError(
            f"{file.path}: convergence needs at least {2 * step} finished samples of a level, two "
            f"steps of convergence.step = {step}"
        )
