"""Figure of a cross study."""

import matplotlib.pyplot as plt
import numpy as np
from scipy.interpolate import RegularGridInterpolator

from hpcrub.plot.style import BLACK, BLUE, ORANGE

SHARES = (0.25, 0.5, 0.75, 0.95)  # of the samples inside the contours
FEW = 500  # samples up to which they are drawn one by one


def cross(files):
    """Samples in the plane of both amplifications, from dense to sparse, a panel for every σ."""
    (file,) = files
    sigma = 100 * file.read("sigma")
    columns = min(2, len(sigma))
    rows = -(-len(sigma) // columns)
    figure, axes = plt.subplots(
        rows, columns, figsize=(5.8 * columns, 5.2 * rows), squeeze=False, sharex=True, sharey=True
    )
    for level, panel in enumerate(axes.flat[: len(sigma)]):
        image = _draw_level(panel, file, level)
        panel.set_title(_title(file, level), fontsize=11)
        panel.set(xlabel="$A_{lin}$ [-]", ylabel="$A_{nl}$ [-]")
    for panel in axes.flat[len(sigma) :]:
        panel.set_axis_off()
    if image is not None:
        bar = figure.colorbar(image, ax=axes, label="share of the samples in denser regions")
        bar.set_ticks([0, *SHARES])
    figure.legend(*axes.flat[0].get_legend_handles_labels(), loc="outside lower center", ncols=2)
    return figure


def _title(file, level):
    share, r = 100 * file.read("share", level), file.read("rank_correlation", level)
    low, high = 100 * file.read("share_interval", level)
    r_low, r_high = file.read("rank_correlation_interval", level)
    return (
        f"σ = {100 * file.read('sigma', level):.1f} %: contact above linear for {share:.0f} % "
        f"[{low:.0f}, {high:.0f}]\nrank correlation {r:.2f} [{r_low:.2f}, {r_high:.2f}]"
    )


def _draw_level(axes, file, level):
    contact, linear = file.read("contact", level), file.read("linear", level)
    known = np.isfinite(contact) & np.isfinite(linear)
    density, image = file.read("density", level), None
    if np.isfinite(density).all():
        grids = file.read("grid_linear", level), file.read("grid_contact", level)
        image = axes.contourf(
            *grids, cumulative(density), levels=[0, *SHARES], cmap="viridis", alpha=0.85,
        )  # fmt: skip
    if image is None or known.sum() <= FEW:
        axes.plot(linear[known], contact[known], ".", color=BLACK, ms=3)
    else:
        out = known & outside(linear, contact, *grids, density)
        label = f"samples outside {SHARES[-1]:.0%}".replace("%", " %")
        axes.plot(linear[out], contact[out], ".", color="0.55", ms=2, label=label)
    if known.any():
        for values, line, colour, name in (
            (contact, axes.axhline, BLUE, "$A_{nl}$"), (linear, axes.axvline, ORANGE, "$A_{lin}$"),
        ):  # fmt: skip
            label = f"percentile 99 of {name}"
            line(np.percentile(values[known], 99), color=colour, ls="--", label=label)
    edge = np.array([0.95, max(axes.get_xlim()[1], axes.get_ylim()[1])])
    axes.plot(edge, edge, color="0.4", lw=1.2, label="$A_{nl} = A_{lin}$")
    return image


def outside(linear, contact, grid_linear, grid_contact, density):
    """Samples beyond the outermost contour.

    Args:
        linear, contact: both amplifications of the samples [-], (S,).
        grid_linear, grid_contact: values at which the density is known [-], (G,), (H,).
        density: of the samples (H, G).

    Returns:
        bool (S,), True too where a sample is off the grid or not known.
    """
    share = RegularGridInterpolator(
        (grid_contact, grid_linear), cumulative(density), bounds_error=False, fill_value=1.0
    )
    return ~(share(np.column_stack([contact, linear])) <= SHARES[-1])


def cumulative(density):
    """Share of the samples where the density is larger than here, of a density on a grid."""
    flat = density.ravel()
    order = np.argsort(-flat)
    share = np.empty_like(flat)
    share[order] = np.cumsum(flat[order]) / flat.sum()
    return share.reshape(density.shape)
