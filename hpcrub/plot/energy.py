"""Figure of energy studies."""

import matplotlib.pyplot as plt
import numpy as np

from hpcrub.plot.style import BLUE, MARKERS, ORANGE
from hpcrub.studies.energy import amplification

COLOURS = [BLUE, ORANGE, "#009E73", "#CC79A7"]


def energy(files):
    """A_nl by displacement and by strain energy of the selected samples, against σ."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(12, 5.2))
    for i, file in enumerate(files):
        sigma = 100 * file.read("sigma")
        colour, marker = COLOURS[i % len(COLOURS)], MARKERS[i % len(MARKERS)]
        shift = 0.04 * (i - (len(files) - 1) / 2)
        for panel, values in ((left, file.read("amplification")), (right, amplification(file))):
            panel.plot(
                sigma + shift, values, marker, color=colour, alpha=0.5, ms=6,
                label=f"$n_d$ = {file.config.casing.n_bumps}, {len(values)} samples",
            )  # fmt: skip
            known = np.isfinite(values)
            at = np.unique(sigma[known])
            for bound in (np.min, np.max):
                edge = [bound(values[known & (sigma == s)]) for s in at]
                panel.plot(at + shift, edge, color=colour, lw=1)
    left.set(xlabel="mistuning σ [%]", ylabel="$A_{nl}$ by displacement [-]")
    right.set(xlabel="mistuning σ [%]", ylabel="$A_{nl}(E)$ by strain energy [-]")
    left.legend()
    return figure
