"""Confidence intervals as they are drawn in every figure: bars, and arrows where an end is open.

With few samples the order statistics do not bound a percentile (`statistics.percentiles`): such an
end is drawn as an arrow, never as the end of a bar.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from numpy.typing import ArrayLike

from hpcrub.statistics.percentiles import Z_95, confidence, percentile_interval, widened

LEVEL = f"{100 * confidence(Z_95):.0f} %"  # of all intervals drawn
BARS = f"{LEVEL} confidence interval"
ARROWS = "open end: too few samples"
ARROW = 20  # length [points]
Array = np.ndarray[Any, np.dtype[np.float64]]


def interval(
    values: Array, percentiles: Sequence[float], shared: ArrayLike = (0.0, 0.0)
) -> tuple[Array, Array]:
    """Ends (P,) of the intervals of percentiles of values; NaN where an end is open.

    shared: uncertainty that all values have in common, as for `widened`.
    """
    low, high = percentile_interval(values, percentiles, Z_95)
    if not len(values):
        return low, high
    return widened(np.percentile(values, percentiles), low, high, np.asarray(shared))


def draw(
    axes: Axes, x: ArrayLike, centre: ArrayLike, low: ArrayLike, high: ArrayLike, colour: Any,
    sideways: bool = False,
) -> bool:  # fmt: skip
    """Bars from low to high through points (x, centre), (n,) each; NaN ends become arrows.

    sideways: the values are horizontal, and x is the height. Returns whether an end is open.
    """
    x, centre = np.atleast_1d(x).astype(float), np.atleast_1d(centre).astype(float)
    open_end = False
    for end, sign in ((np.atleast_1d(low), -1), (np.atleast_1d(high), 1)):
        closed = np.isfinite(end) & np.isfinite(centre)
        reach = np.abs(np.where(closed, end - centre, 0.0))[closed]
        bars = [reach, 0 * reach] if sign < 0 else [0 * reach, reach]
        at = (centre[closed], x[closed]) if sideways else (x[closed], centre[closed])
        if closed.any():
            look: dict[str, Any] = {"ecolor": colour, "elinewidth": 1.2, "capsize": 3}
            look["xerr" if sideways else "yerr"] = bars
            axes.errorbar(*at, fmt="none", **look)
        for i in np.flatnonzero(np.isfinite(centre) & ~closed):
            open_end = True
            at_point = (centre[i], x[i]) if sideways else (x[i], centre[i])
            away = (sign * ARROW, 0) if sideways else (0, sign * ARROW)
            axes.annotate(
                "", at_point, away, "data", "offset points", annotation_clip=False,
                arrowprops={"arrowstyle": "<-", "color": colour, "lw": 1.2, "shrinkB": 0},
            )  # fmt: skip
    return open_end


def handles(open_end: bool) -> list[Line2D]:
    """Legend entries that say what bars and arrows are."""
    bar = Line2D([], [], color="0.4", ls="", marker="|", ms=14, mew=1.2, label=BARS)
    arrow = Line2D([], [], color="0.4", ls="", marker=r"$\uparrow$", ms=10, label=ARROWS)
    return [bar, arrow] if open_end else [bar]
