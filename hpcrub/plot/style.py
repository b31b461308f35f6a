"""Style of all figures; the colour-blind can tell its colours apart."""

from typing import Any

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes

BLACK, BLUE, ORANGE = "#000000", "#0072B2", "#D55E00"  # Okabe and Ito
GREEN, SKY, PINK, YELLOW = "#009E73", "#56B4E9", "#CC79A7", "#E69F00"
COLOURS = [BLUE, ORANGE, GREEN, PINK, YELLOW, SKY, BLACK]
MARKERS = ["o", "s", "^", "D", "v", "P", "X", "<", ">", "*"]
DARKEST, PALEST = 0.0, 0.8  # part of the viridis scale that is used; beyond it is pale yellow
DOTTED: dict[str, Any] = {"color": BLACK, "lw": 1.2, "ls": ":"}  # limits, and what to compare with
STYLE: dict[str, Any] = {
    "font.size": 12,
    "axes.grid": True,
    "grid.color": "0.9",
    "axes.axisbelow": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "lines.linewidth": 2,
    "legend.frameon": False,
    "figure.constrained_layout.use": True,
}


def shades(n: int) -> list[tuple[float, float, float, float]]:
    """Return colours of n ordered cases, from dark to light, all of them visible on white."""
    return [tuple(c) for c in colormaps["viridis"](np.linspace(DARKEST, PALEST, n))]


def marker(case: int) -> str:
    """Return the marker of a case; after the last marker the first one comes again."""
    return MARKERS[case % len(MARKERS)]


def polar(radius: Any, angle: Any) -> Any:
    """Return points (2, ...) at radii and angles [rad], which are broadcast."""
    return np.stack([radius * np.cos(angle), radius * np.sin(angle)])


def say(axes: Axes, text: str) -> None:
    """Write a text into the middle of axes that have nothing to show."""
    axes.text(0.5, 0.5, text, transform=axes.transAxes, ha="center", va="center", wrap=True)


def edges(speeds: Any) -> Any:
    """Return the edges (S + 1,) of the stripes of a map around speeds (S,)."""
    if len(speeds) == 1:
        return speeds[0] + np.array([-0.5, 0.5])
    middle = (speeds[1:] + speeds[:-1]) / 2
    return np.array([2 * speeds[0] - middle[0], *middle, 2 * speeds[-1] - middle[-1]])
