"""Figures of studies that keep whole histories."""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import BoundaryNorm, ListedColormap, LogNorm

from hpcrub.contact import status
from hpcrub.contact.status import DIVERGED
from hpcrub.plot.style import BLACK, BLUE, GREEN, ORANGE, PINK, say
from hpcrub.studies.time_response import first_steady

CLOSE_REVOLUTIONS = 3  # shown at the end, next to the whole history
MOST_TICKS = 12  # of the key of the blades
DISKS = ("tuned disk", "mistuned disk")
ROWS = (
    ("tangential_m", 1e3, "$u_t$ of the tips [mm]"),
    ("radial_m", 1e3, "$u_r$ of the tips [mm]"),
    ("gap_m", 1e3, "gap [mm]"),
    ("force_n", 1e-3, "radial contact force [kN]"),
)


def time(files):
    """Motions, gaps and contact forces of all tips: everything, and the last revolutions."""
    (file,) = files
    disk = len(file.read("deviation")) - 1
    t, config = file.read("time_s"), file.config
    figure, axes = plt.subplots(
        len(ROWS), 2, figsize=(13, 11), sharex="col", sharey="row", width_ratios=(1.6, 1)
    )
    colours = plt.get_cmap("viridis")(np.linspace(0, 0.95, config.disk.n_blades))
    close = t > t[-1] - CLOSE_REVOLUTIONS / config.speeds.from_hz
    largest = int(np.abs(file.read("tangential_m", disk)[close]).max(axis=0).argmax())
    for (name, scale, label), (left, right) in zip(ROWS, axes, strict=True):
        values = scale * file.read(name, disk)
        for panel, part in ((left, slice(None)), (right, close)):
            for blade in np.roll(np.arange(values.shape[1]), -largest - 1):  # the largest last
                top = blade == largest
                colour, width = (BLACK, 1.4) if top and panel is right else (colours[blade], 0.7)
                panel.plot(t[part], values[part, blade], color=colour, lw=width, rasterized=True)
        left.set_ylabel(label)
    title = f"last {CLOSE_REVOLUTIONS} revolutions"
    if file.read("point_status", disk) == DIVERGED:
        for panel in axes[:, 0]:
            say(panel, status.words(file.read("point_reason", disk)))
    else:
        _draw_windows(axes[0, 0], file, disk)
        title += f" (black: blade {largest + 1})"
    axes[0, 1].set_title(title)
    for panel, shown in zip(axes[-1], (t, t[close]), strict=True):
        panel.set(xlabel="time [s]", xlim=(shown[0], shown[-1]))
    _add_blade_key(figure, axes, colours)
    figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=3)
    figure.suptitle(f"{DISKS[disk]}, {config.casing.n_bumps} bumps, {config.speeds.from_hz:g} Hz")
    return figure


def _add_blade_key(figure, axes, colours):
    n_blades = len(colours)
    norm = BoundaryNorm(np.arange(n_blades + 1) + 0.5, n_blades)
    ticks = np.arange(1, n_blades + 1, -(-n_blades // MOST_TICKS))
    mappable = ScalarMappable(norm, ListedColormap(colours))
    figure.colorbar(mappable, ax=axes, label="blade", ticks=ticks, aspect=50, pad=0.01)


def _draw_windows(axes, file, disk):
    """The two windows of the first check that was passed, or of the last one."""
    checks, window = file.read("check_s"), float(file.read("window_s"))
    if not len(checks):
        return
    passed = first_steady(file, disk)
    check = len(checks) - 1 if passed is None else passed
    end, word = checks[check], "not steady" if passed is None else "steady"
    for k, colour, name in ((2, ORANGE, "first window compared"), (1, GREEN, "second window")):
        begin = end - k * window
        axes.axvspan(begin, begin + window, color=colour, alpha=0.35, lw=0, label=name)
    for i, other in enumerate(checks):
        label = None if i else "checks of the steady state"
        axes.axvline(other, color="0.4", lw=1, ls=":", label=label)
    axes.set_title(
        f"{word} at {end:.3f} s: correlation {file.read('correlation', disk)[check]:.3f}, "
        f"amplitude change {100 * file.read('amplitude_change', disk)[check]:.2g} %",
        fontsize=11,
    )


def interaction(files):
    """Spectra over the speeds with engine orders and natural frequencies; one panel per disk."""
    (file,) = files
    config = file.config
    speeds, frequencies = file.read("speeds_hz"), file.read("frequencies_hz")
    n_disks = len(file.read("deviation"))
    figure, axes = plt.subplots(1, n_disks, figsize=(6.5 * n_disks, 6), sharey=True, squeeze=False)
    spectra = 1e3 * file.read("spectrum_m")
    # with a scale that has a top even where nothing moves
    top = np.max(spectra, where=np.isfinite(spectra), initial=0.0) or 1.0
    lost = status.are_fatal(file.read("point_reason"))
    for disk, panel in enumerate(axes[0]):
        image = panel.pcolormesh(
            speeds, frequencies, spectra[disk].T, norm=LogNorm(top / 3000, top), cmap="Greys",
            shading="nearest", rasterized=True,
        )  # fmt: skip
        for speed in speeds[lost[disk]]:
            panel.axvline(speed, color=PINK, lw=2)
        for order in range(1, 3 * config.casing.n_bumps + 1):
            main = order % config.casing.n_bumps == 0
            style = {"color": ORANGE, "lw": 1.2} if main else {"color": ORANGE, "lw": 0.4}
            panel.plot(speeds, order * speeds, **style)
            end = min(speeds[-1], frequencies[-1] / order)
            if order <= 4 or main:
                above = order * speeds[-1] > frequencies[-1]
                panel.annotate(
                    f"{order}", (end, order * end), color=ORANGE, fontsize=10,
                    xytext=(0, 3) if above else (3, 0), textcoords="offset points",
                    ha="center" if above else "left", va="bottom" if above else "center",
                )  # fmt: skip
        natural = file.read("natural_frequencies_hz", disk)
        for frequency in natural[natural < frequencies[-1]]:
            panel.axhline(frequency, color=BLUE, lw=0.8)
        panel.margins(x=0)
        panel.set(ylim=(0, frequencies[-1]))
        panel.set(xlabel="speed of rotation [Hz]")
        panel.set_title(DISKS[disk], pad=20)
        panel.grid(False)
    axes[0, 0].set_ylabel("frequency [Hz]")
    axes[0, 0].plot([], [], color=ORANGE, label="engine orders")
    axes[0, 0].plot([], [], color=BLUE, label="natural frequencies")
    if lost.any():
        axes[0, 0].plot([], [], color=PINK, label="diverged")
    figure.legend(loc="outside lower center", ncols=3)
    figure.colorbar(image, ax=axes, label="tangential amplitude, largest of all tips [mm]")
    return figure
