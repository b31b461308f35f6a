"""Figures of single samples: contact over linear amplification, energy over displacement."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from hpcrub.config.text import counted
from hpcrub.effects.effect import peaks_of_disks
from hpcrub.plot.canvas import Canvas, figure
from hpcrub.plot.families import labels, level_colours
from hpcrub.plot.intervals import LEVEL
from hpcrub.plot.style import BLACK, BLUE, ORANGE, marker
from hpcrub.results.layout import DONE
from hpcrub.results.samples import n_counted
from hpcrub.results.storage import ResultFile
from hpcrub.statistics import pairs
from hpcrub.statistics.percentiles import Z_95, probability_interval
from hpcrub.studies.energy import amplification

SHARES = (0.25, 0.5, 0.75, 0.95)  # shares of the samples that lie inside the contours
FEW_SAMPLES = 100  # number of samples up to which neither density nor percentile 99 is drawn
Array = NDArray[np.float64]


@figure("contact", paper="15", what="densities of (A_lin, A_nl)", alone=False, needs="random")
def contact_over_linear(canvas: Canvas, file: ResultFile) -> None:
    """Samples in the plane of both amplifications, from dense to sparse, a panel for every σ.

    Fewer than a hundred samples are dots only. The paper's load travels over the disk the other way
    than its casing (`forcing.travels`): single disks differ for that reason, too.
    """
    sigma = 100 * file.read("sigma")
    axes = canvas.grid(len(sigma), 2, (5.8, 5.0), sharex=True, sharey=True)
    n, names = n_counted(file), ("linear_amplification", "amplification")
    both = np.array([file.read(f"samples/{name}")[:, :n] for name in names])
    known = (file.status[:, :n] == DONE) & np.isfinite(both).all(axis=0)  # NaN: flutter in air
    image = None
    for level, panel in enumerate(axes):
        linear, contact = both[:, level, known[level]]
        image = _draw_level(panel, linear, contact) or image
        panel.set_title(_title(sigma[level], linear, contact), fontsize=11)
        panel.set(xlabel="$A_{lin}$ [-]", ylabel="$A_{nl}$ [-]")
    if image is not None:
        canvas.figure.colorbar(image, ax=axes, label="share of the samples in denser regions")
    canvas.note(f"In brackets: {LEVEL} confidence intervals of share and rank correlation.")


def _title(sigma: float, linear: Array, contact: Array) -> str:
    n = len(linear)
    above = int(np.count_nonzero(contact > linear))
    text = f"σ = {sigma:.1f} %, {counted(n, 'sample')}"
    if not n:
        return text
    low, high = 100 * probability_interval(above, n, Z_95)
    text += f"\ncontact above linear for {100 * above / n:.0f} % [{low:.0f}, {high:.0f}]"
    r, r_low, r_high = pairs.rank_correlation(contact, linear)
    if np.isnan(r):
        return f"{text}\nno rank correlation of so few or equal samples"
    return f"{text}\nrank correlation {r:.2f} [{r_low:.2f}, {r_high:.2f}]"


def _draw_level(axes: Axes, linear: Array, contact: Array) -> Any:
    """Draw the samples of one level; if they are many, draw their density and return its image."""
    image, are_many = None, len(linear) > FEW_SAMPLES
    look: dict[str, Any] = {"color": "0.55", "ms": 2} if are_many else {"color": BLACK, "ms": 6}
    axes.plot(linear, contact, ".", zorder=0.5, rasterized=are_many, label="samples", **look)
    if are_many:
        *grid, density = pairs.density(linear, contact)
        if density is not None:
            flat = density.ravel()
            order = np.argsort(-flat)  # shares of the samples in denser regions
            flat[order] = np.cumsum(flat[order]) / flat.sum()
            share = flat.reshape(density.shape).T
            image = axes.contourf(*grid, share, levels=[0, *SHARES], cmap="viridis")
        for values, line, colour, name in (
            (contact, axes.axhline, BLUE, "$A_{nl}$"), (linear, axes.axvline, ORANGE, "$A_{lin}$"),
        ):  # fmt: skip
            label = f"percentile 99 of {name}"
            line(np.percentile(values, 99), color=colour, ls="--", label=label)
    axes.update_datalim([(0.95, 0.95)])
    axes.autoscale_view()
    axes.axline((1.0, 1.0), slope=1.0, color="0.4", lw=1.2, label="$A_{nl} = A_{lin}$")
    return image


@figure("energy", paper="14", what="A_nl by energy over displacement", several=True, main=True)
def energy(canvas: Canvas, files: list[ResultFile]) -> None:
    """A_nl by strain energy over A_nl by displacement of the selected samples.

    A colour for every mistuning level, a marker for every file. On the line the energy grows as
    the square of the displacement, as it does where a blade keeps its deflected shape. On a coating
    that wears: the energy that its wear took, too, the largest of all speeds.
    """
    values = {"$A_{nl}$ by strain energy [-]": [amplification(file) for file in files]}
    if all("wear_energy_j" in file for file in files):
        values["energy that wear took [J]"] = [
            peaks_of_disks(file, "wear_energy_j")[0] for file in files
        ]
    axes = canvas.panels(1, len(values), (1.5 + 6.0 * len(values), 5.4))[0]
    words = labels(files) if len(files) > 1 else [files[0].config.casing.words]
    by_displacement = [file.read("amplification") for file in files]
    colours = level_colours(files)
    for panel, (name, of_files) in zip(axes, values.items(), strict=True):
        for i, (file, y) in enumerate(zip(files, of_files, strict=True)):
            sigma = file.read("sigma")
            label = f"{words[i]}: the {len(y)} samples with the largest $A_{{nl}}$"
            panel.plot([], [], marker(i), color="0.4", label=label)
            for level, colour in colours.items():
                mine = by_displacement[i][sigma == level], y[sigma == level]
                panel.plot(*mine, marker(i), color=colour, alpha=0.7, ms=7)
        panel.set(xlabel="$A_{nl}$ by displacement [-]", ylabel=name)
    for level, colour in colours.items():
        axes[0].plot([], [], "s", color=colour, label=f"σ = {100 * level:.1f} %")
    left, right = axes[0].get_xlim()
    x = np.linspace(left, right, 100)
    axes[0].plot(x, x**2, color="0.4", lw=1.2, zorder=1, label="square of the displacement's")
    axes[0].set_xlim(left, right)
