"""Figures of studies that keep whole histories."""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import LogNorm

from hpcrub import reasons
from hpcrub.layout import DIVERGED
from hpcrub.plot.style import BLACK, BLUE, GREEN, ORANGE, PINK, say
from hpcrub.studies.time_response import first_steady

CLOSE_REVOLUTIONS = 3  # shown at the end, next to the whole history
DISKS = ("tuned disk", "mistuned disk")


def time(files):
    """Displacements, gaps and contact forces of all tips: everything, and the last revolutions."""
    (file,) = files
    disk = len(file.read("deviation")) - 1
    t, config = file.read("time_s"), file.config
    figure, axes = plt.subplots(
        3, 2, figsize=(12, 9), sharex="col", sharey="row", width_ratios=(1.6, 1)
    )
    colours = plt.get_cmap("viridis")(np.linspace(0, 0.95, config.disk.n_blades))
    close = t > t[-1] - CLOSE_REVOLUTIONS / config.speeds.from_hz
    rows = (("tangential_m", 1e3, "$u_t$ of the tips [mm]"), ("gap_m", 1e3, "gap [mm]"))
    rows += (("force_n", 1e-3, "radial contact force [kN]"),)
    largest = int(np.abs(file.read("tangential_m", disk)[close]).max(axis=0).argmax())
    for (name, scale, label), (left, right) in zip(rows, axes, strict=True):
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
            say(panel, reasons.words(file.read("point_reason", disk)))
    else:
        _draw_windows(axes[0, 0], file, disk)
        title += f" (black: blade {largest + 1})"
    axes[0, 1].set_title(title)
    for panel, shown in zip(axes[2], (t, t[close]), strict=True):
        panel.set(xlabel="time [s]", xlim=(shown[0], shown[-1]))
    figure.suptitle(f"{DISKS[disk]}, {config.casing.n_bumps} bumps, {config.speeds.from_hz:g} Hz")
    return figure


def _draw_windows(axes, file, disk):
    """The two windows of the first check that was passed, or of the last one."""
    checks, window = file.read("check_s"), float(file.read("window_s"))
    if not len(checks):
        return
    passed = first_steady(file, disk)
    check = len(checks) - 1 if passed is None else passed
    end, word = checks[check], "not steady" if passed is None else "steady"
    for k, colour in ((2, ORANGE), (1, GREEN)):
        axes.axvspan(end - k * window, end - (k - 1) * window, color=colour, alpha=0.35, lw=0)
    for other in checks:
        axes.axvline(other, color="0.6", lw=0.8, ls=":")
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
    lost = reasons.are_fatal(file.read("point_reason"))
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
                panel.annotate(f"{order}", (end, order * end), color=ORANGE, fontsize=10,
                               xytext=(2, 2), textcoords="offset points")  # fmt: skip
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
