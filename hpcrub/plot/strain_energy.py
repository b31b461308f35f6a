"""Figure of energy studies."""

import numpy as np

from hpcrub.plot.canvas import Canvas, figure
from hpcrub.plot.families import labels, ordered
from hpcrub.plot.style import COLOURS, MARKERS
from hpcrub.studies.energy import amplification, worn

FEW = 20  # samples of a level up to which smallest and largest are no envelope


@figure("energy", paper="14", what="A_nl by displacement and by energy", several=True, main=True)
def energy(canvas: Canvas) -> None:
    """A_nl by displacement and by strain energy of the selected samples, a row for every file.

    On a coating that wears: the energy that its wear took, too, the largest of all speeds.
    Lines join the smallest and the largest of every level where these are enough to tell a range.
    """
    files = ordered(canvas.files)
    n_columns = 2 + any("wear_energy_j" in file for file in files)
    size = 6.0 * n_columns, 1.2 + 4.2 * len(files)
    axes = canvas.panels(len(files), n_columns, size, sharex=True, sharey="col")
    few = False
    for i, (file, row, label) in enumerate(zip(files, axes, labels(files), strict=True)):
        sigma, colour = 100 * file.read("sigma"), COLOURS[i % len(COLOURS)]
        drawn = {
            "$A_{nl}$ by displacement [-]": file.read("amplification"),
            "$A_{nl}$ by strain energy [-]": amplification(file),
        }
        if "wear_energy_j" in file:
            drawn["energy that wear took [J]"] = worn(file)
        label = file.config.casing.words if len(files) == 1 else label
        for panel, (name, values) in zip(row, drawn.items(), strict=False):
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
            panel.set_ylabel(name)
    for panel in axes[-1]:
        panel.set_xlabel("mistuning σ [%]")
    if few:
        canvas.note(f"No range is drawn of levels with fewer than {FEW} samples.")
