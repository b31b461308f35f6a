"""Figure of energy studies."""

import numpy as np

from hpcrub.plot.canvas import Canvas, figure
from hpcrub.plot.families import labels, ordered
from hpcrub.plot.style import COLOURS, MARKERS
from hpcrub.studies.energy import amplification, worn

FEW = 20  # samples of a level up to which smallest and largest are no envelope
BESIDE = 0.03  # standard deviation of the mistuning [%]: files to the right of each other


@figure("energy", paper="14", what="A_nl by displacement and by energy", several=True, main=True)
def energy(canvas: Canvas) -> None:
    """A_nl by displacement and by strain energy of the selected samples, a colour for every file.

    On a coating that wears: the energy that its wear took, too, the largest of all speeds.
    Lines join the smallest and the largest of every level where these are enough to tell a range.
    """
    files = ordered(canvas.files)
    values = {
        "$A_{nl}$ by displacement [-]": [file.read("amplification") for file in files],
        "$A_{nl}$ by strain energy [-]": [amplification(file) for file in files],
    }
    if all("wear_energy_j" in file for file in files):
        values["energy that wear took [J]"] = [worn(file) for file in files]
    axes = canvas.panels(1, len(values), (6.0 * len(values), 4.8))[0]
    words = labels(files) if len(files) > 1 else [files[0].config.casing.words]
    for panel, (name, of_files) in zip(axes, values.items(), strict=True):
        for i, (file, of_file) in enumerate(zip(files, of_files, strict=True)):
            sigma, colour = 100 * file.read("sigma") + BESIDE * i, COLOURS[i % len(COLOURS)]
            panel.plot(
                sigma, of_file, MARKERS[i % len(MARKERS)], color=colour, alpha=0.5, ms=6,
                label=f"{words[i]}: the {len(of_file)} samples with the largest $A_{{nl}}$",
            )  # fmt: skip
            at, counts = np.unique(sigma[np.isfinite(of_file)], return_counts=True)
            well = at[counts >= FEW]
            for bound in (np.nanmin, np.nanmax):
                panel.plot(well, [bound(of_file[sigma == s]) for s in well], color=colour, lw=1)
        panel.set(xlabel="mistuning σ [%]", ylabel=name)
