"""Second order of the motion against blades with exact rotations that rub on a circular casing.

One clamped blade of the reference disk, straight and bowed, meets a bump of the casing; bump and
clearance are scaled, and with them the motion of the tip. `evidence.truth.exact_rubbing` has exact
geometry, `evidence.truth.second_order` the equations of the kernel in plain NumPy, to which
`tests/contact` holds the kernel.
"""

import numpy as np

from evidence import pictures
from evidence.page import table
from evidence.truth import second_order
from evidence.truth.bent_blade import clamped
from evidence.truth.exact_rubbing import rub
from evidence.truth.ring import Wall
from evidence.validation import report
from evidence.validation.report import plt

HZ, STEP, SECONDS = 40.0, 2e-6, 0.010
SCALES = np.array([0.25, 0.5, 1.0, 2.0])  # of bumps of 1.25 mm and a clearance of 0.25 mm
BLADES = {"straight": 0.0, "bowed": 0.07924}
NAMES = {"first": "small displacements", "polar": "displaced tip alone", "second": "second order"}
# largest error at 7 mm, over the motion, and how much larger it is at first order
ALLOWED = {"straight": (0.003, 20.0), "bowed": (0.008, 5.0)}
COLOURS = dict(zip(second_order.ORDERS, (report.COLOURS[i] for i in (1, 3, 0)), strict=True))
SHOWN = "straight", 2.0  # blade and scale of the figure


def meetings(bow, scale):
    """Motion of the tip (n, 2) [m] past a bump: exact, and at every order."""
    beams, structure = clamped(bow)
    wall, n = Wall(4, scale * 1.25e-3, scale * 0.25e-3, 0.15, 0.02), round(SECONDS / STEP)
    how = wall.clearance, wall.friction, HZ, STEP, n
    casing, found = second_order.casing_of(wall), {"exact": rub(beams, wall, HZ, STEP, n)[0]}
    for order in second_order.ORDERS:
        found[order] = second_order.integrate(structure, casing, *how, order).place[..., :2]
    return {name: motion[:, 0] for name, motion in found.items()}


def errors(runs):
    """Largest motion of the tip [m], and the largest error of every order over it [-]."""
    exact = runs["exact"]
    peak = np.hypot(*exact.T).max()
    apart = [np.hypot(*(runs[order] - exact).T).max() / peak for order in second_order.ORDERS]
    return peak, apart


def section(folder):
    """Parts of the page, verdicts and the figure."""
    rows, verdicts, curves, shown = [], [], {}, {}
    for name, bow in BLADES.items():
        runs = {scale: meetings(bow, scale) for scale in SCALES}
        found = [errors(run) for run in runs.values()]
        peaks, apart = np.array([peak for peak, _ in found]), np.array([e for _, e in found])
        curves[name] = peaks, apart
        rows += [
            [name, f"{1e3 * peak:.1f}", *(f"{100 * e:.2f}" for e in both)] for peak, both in found
        ]
        if name == SHOWN[0]:
            shown = runs[SHOWN[1]]
        at, better = ALLOWED[name]
        i = int(np.abs(peaks - 7e-3).argmin())
        verdicts.append(report.at_most(f"{name}, at {1e3 * peaks[i]:.1f} mm", apart[i, 2], at))
        times = (apart[:, 0] / apart[:, 2]).min()
        verdicts.append(report.Verdict(f"{name}, times better", times, better, np.inf))
    draw(shown, curves, folder)
    heads = ["blade", "tip moves [mm]", *(f"{NAMES[o]} [%]" for o in second_order.ORDERS)]
    return {"errors": table(heads, rows)}, verdicts


def draw(runs, curves, folder):
    """The tip past a bump, and errors over the motion."""
    figure, (left, right) = report.axes(2)
    t = 1e3 * STEP * np.arange(1, len(runs["exact"]) + 1)
    left.plot(t, 1e3 * runs["exact"][:, 1], color="0.75", lw=6.0, label="exact rotations")
    for name, colour in COLOURS.items():
        left.plot(t, 1e3 * runs[name][:, 1], color=colour, lw=1.6, label=NAMES[name])
    left.set(xlim=(5.0, 1e3 * SECONDS), xlabel="time [ms]")
    left.set(ylabel="tangential motion of the tip [mm]", title="straight blade past a bump")
    for blade, line in zip(BLADES, ("o-", "s--"), strict=True):
        peaks, apart = curves[blade]
        for k, colour in enumerate(COLOURS.values()):
            right.loglog(1e3 * peaks, 100 * apart[:, k], line, color=colour)
        right.plot([], [], line, color="0.4", label=f"{blade} blade")
    right.set(xlabel="largest motion of the tip [mm]", ylabel="largest error [% of the motion]")
    for axis, ticks in ((right.xaxis, (1, 2, 5, 10)), (right.yaxis, (0.03, 0.1, 0.3, 1, 3, 10))):
        axis.set_ticks(ticks, [f"{tick:g}" for tick in ticks])
        axis.set_minor_formatter("")
    right.legend(loc="lower right")
    figure.legend(*left.get_legend_handles_labels(), ncols=4, loc="outside upper center")
    pictures.save(figure, folder / "second_order.png", dpi=130)
    plt.close(figure)
