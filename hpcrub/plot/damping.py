"""Figure of a damping study."""

import matplotlib.pyplot as plt
import numpy as np

from hpcrub.plot.style import BLUE, MARKERS, ORANGE
from hpcrub.studies.damping import KINDS


def damping(files):
    """Percentiles over σ at every damping, contact and linear; 95 % bands."""
    (file,) = files
    sigma, cases = 100 * file.read("sigma"), file.read("damping_ratio")
    at = file.config.convergence.percentiles
    figure, axes = plt.subplots(1, 2, figsize=(12, 5.4), sharey=True)
    for kind, panel in zip(KINDS, axes, strict=True):
        values, interval = file.read(f"{kind}/percentile"), file.read(f"{kind}/interval")
        for case, (ratio, colour, style) in enumerate(
            zip(cases, (BLUE, ORANGE), ("-", "--"), strict=False)
        ):
            for p, percentile in enumerate(at):
                x = np.concatenate([[0.0], sigma])
                curve = np.concatenate([[1.0], values[case, :, p]])
                band = np.vstack([[1.0, 1.0], interval[case, :, p]])
                panel.fill_between(x, *band.T, color=colour, alpha=0.15, lw=0)
                panel.plot(
                    x, curve, style, color=colour, marker=MARKERS[p % len(MARKERS)],
                    label=f"ξ = {1e3 * ratio:g}·10⁻³, percentile {percentile:g}",
                )  # fmt: skip
        panel.set(xlabel="mistuning σ [%]", title=f"{kind} amplification")
    axes[0].set_ylabel("amplification [-]")
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=2)
    return figure
