"""Campbell diagram of any disk: its families over the speed, and engine orders."""

import numpy as np
from matplotlib.axes import Axes

from hpcrub.model import crossings
from hpcrub.model.imported import cyclic
from hpcrub.model.reduction import ReducedModel
from hpcrub.plot.canvas import Canvas, figure
from hpcrub.plot.responses import SPEED
from hpcrub.plot.style import BLACK, BLUE, ORANGE
from hpcrub.results.storage import ResultFile
from hpcrub.setup.problem import build_model

SHOWN = 3  # families
BEYOND = 1.3  # highest speed of the diagram, in parts of the highest speed of the study
N_SPEEDS = 60
MOST_ORDERS = 12  # engine orders whose lines are drawn beside that of the casing


@figure("modal", what="Campbell diagram", alone=False, computed=False)
def campbell(canvas: Canvas, file: ResultFile) -> None:
    """Frequencies of the tuned disk over the speed of rotation, in Hz and in rpm.

    Bands are families of blade modes, from their lowest to their highest nodal diameter; the line
    is the nodal diameter that the casing's order excites, and the mark where they meet. Of the
    input alone: instead of a result file it takes a `hpcrub.Config`, too.
    """
    axes, config = canvas.panels(1, 1, (9.0, 6.2))[0, 0], file.config
    reduced, order = build_model(config).reduced, config.casing.main_order
    speeds = np.linspace(0.0, BEYOND * config.speeds.to_hz, N_SPEEDS)
    diameters = cyclic.tuned_diameters(reduced)
    highest = 1.15 * _draw_families(axes, reduced, diameters, order, speeds)
    _draw_orders(axes, order, speeds[-1], highest)
    if np.isfinite(met := crossings.of_disk(reduced, diameters, order)) and met < speeds[-1]:
        label = f"order {order} meets family 1 at {met:.4g} Hz, {60.0 * met:,.0f} rpm"
        axes.plot(met, order * met, "o", color=ORANGE, ms=8, label=label, zorder=4)
    studied = config.speeds.from_hz, config.speeds.to_hz
    axes.axvspan(*studied, color="0.93", zorder=0, label="speeds of the study")
    axes.set(xlabel=SPEED, ylabel="frequency [Hz]", xlim=(0.0, speeds[-1]), ylim=(0.0, highest))
    rpm = axes.secondary_xaxis("top", functions=(lambda hz: 60.0 * hz, lambda rpm: rpm / 60.0))
    rpm.set_xlabel("speed of rotation [rpm]")


def _draw_families(
    axes: Axes, reduced: ReducedModel, diameters: np.ndarray, order: int, speeds: np.ndarray
) -> float:
    """Draw families of modes with nodal diameters (m,) over speeds [Hz]; returns the highest.

    Families far above what the order reaches are left out.
    """
    mine, highest = crossings.folded(order, reduced.interface.n_blades), 0.0
    for family in range(SHOWN):
        curves = {}
        for diameter in sorted(set(diameters)):
            of_speed = crossings.family_frequency(reduced, diameters, int(diameter), family)
            if of_speed is not None:
                rates = [of_speed(2.0 * np.pi * speed) for speed in speeds]
                curves[diameter] = np.array(rates) / (2.0 * np.pi)
        known = np.array(list(curves.values()))
        if not known.size or (family and known.min() > BEYOND * order * speeds[-1]):
            break
        shade, label = f"{0.6 + 0.12 * family}", f"family {family + 1}, all nodal diameters"
        axes.fill_between(speeds, known.min(axis=0), known.max(axis=0), color=shade, label=label)
        if mine in curves:
            axes.plot(speeds, curves[mine], color=BLUE, lw=1.4, label=f"{mine} nodal diameters")
        highest = max(highest, float(known.max()))
    return highest


def _draw_orders(axes: Axes, main: int, fastest: float, highest: float) -> None:
    """Draw the lines of engine orders up to a speed and a frequency [Hz], with their numbers."""
    for order in {*range(1, MOST_ORDERS + 1), main}:
        is_main = order == main
        axes.plot(
            [0.0, fastest], [0.0, order * fastest], color=ORANGE if is_main else BLACK,
            lw=1.6 if is_main else 0.5, label=f"order {order} of the casing" if is_main else None,
        )  # fmt: skip
        speed = min(fastest, highest / order)
        axes.annotate(
            f"{order}", (speed, order * speed), xytext=(-4, -4), textcoords="offset points",
            ha="right", va="top", fontsize=9, color=ORANGE if is_main else "0.3",
        )  # fmt: skip
