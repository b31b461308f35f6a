"""Drawing of confidence intervals, alike in all figures: bars, and arrows where an end is open.

With few samples the order statistics do not bound a percentile (`statistics.percentiles`): the open
end is drawn as an arrow, never as the end of a bar.
"""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import ArrayLike

from hpcrub.statistics.percentiles import Z_95, confidence

LEVEL = f"{100 * confidence(Z_95):.0f} %"  # confidence level of all intervals drawn
BARS = f"{LEVEL} confidence interval"
ARROWS = "open end: too few samples"
WORDS = BARS, ARROWS
ARROW = 20  # length [points]


def draw(axes: Axes, x: ArrayLike, found: ArrayLike, colour: Any, sideways: bool = False) -> None:
    """Draw bars through points at x (n,); found: centres and ends (3, n), NaN ends become arrows.

    sideways: the values are horizontal, and x is the height. The legend explains bars and arrows.
    """
    x, (centre, low, high) = np.atleast_1d(x), np.asarray(found)
    known = np.isfinite(centre)
    at, axis = ((centre, x), "xerr") if sideways else ((x, centre), "yerr")
    lengths = np.maximum(np.nan_to_num([centre - low, high - centre]), 0.0)
    look: dict[str, Any] = {axis: lengths, "ecolor": colour}
    axes.errorbar(at[0], at[1], fmt="none", elinewidth=1.2, capsize=3, **look)
    bar, arrow = ("_", r"$\rightarrow$") if sideways else ("|", r"$\uparrow$")
    axes.plot([], [], color="0.4", ls="", marker=bar, ms=14, mew=1.2, label=BARS)
    for end, sign in ((low, -1), (high, 1)):
        for i in np.flatnonzero(known & ~np.isfinite(end)):
            away = (sign * ARROW, 0) if sideways else (0, sign * ARROW)
            axes.annotate(
                "", (at[0][i], at[1][i]), away, "data", "offset points", annotation_clip=False,
                arrowprops={"arrowstyle": "<-", "color": colour, "lw": 1.2, "shrinkB": 0},
            )  # fmt: skip
            axes.plot([], [], color="0.4", ls="", marker=arrow, ms=10, label=ARROWS)
