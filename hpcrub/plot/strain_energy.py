"""Figure of energy studies."""

import numpy as np

from hpcrub.plot.canvas import Canvas, figure
from hpcrub.plot.families import labels, ordered
from hpcrub.plot.style import COLOURS, MARKERS
from hpcrub.studies.energy import amplification

FEW = 20  # samples of a level up to which smallest and largest are no envelope


@figure("energy", paper="14", what="A_nl by displacement and by energy", several=True, main=True)
def energy(canvas: Canvas) -> None:
    """A_nl by displacement and by strain energy of the selected samples, a row for every file.

    Lines join the smallest and the largest of every level where these are enough to tell a range.
    """
    files = ordered(canvas.files)
    axes = canvas.panels(len(files), 2, (12, 1.2 + 4.2 * len(files)), sharex=True, sharey="col")
    few = False
    for i, (file, row, label) in enumerate(zip(files, axes, labels(files), strict=True)):
        sigma, colour = 100 * file.read("sigma"), COLOURS[i % len(COLOURS)]
        by_size, by_energy = file.read("amplification"), amplification(file)
        label = file.config.casing.words if len(files) == 1 else label
        for panel, values, name in zip(
            row, (by_size, by_energy), ("displacement", "strain energy"), strict=True
        ):
            panel.plot(
                sigma, values, MARKERS[i % len(MARKERS)], color=colour, alpha=0.5, ms=6,
            )  # fmt: skip
            at, counts = np.unique(sigma[np.isfinite(values)], return_counts=True)
            well = at[counts >= FEW]
            few |= bool((counts < FEW).any())
            for bound in (np.nanmin, np.nanmax):
                edge = [bound(values[sigma == s]) for s in well]
                panel.plot(well, edge, color=colour, lw=1)
            panel.set_title(f"{label}: {len(values)} samples with the largest $A_{{nl}}$")
            panel.set_ylabel(f"$A_{{nl}}$ by {name} [-]")
    for panel in axes[-1]:
        panel.set_xlabel("mistuning σ [%]")
    if few:
        canvas.note(f"No range is drawn of levels with fewer than {FEW} samples.")
