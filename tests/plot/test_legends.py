"""Legends in the user's own axes cover no data."""

import numpy as np
import pytest
from matplotlib import pyplot

from hpcrub import plot
from tests.program import ROOT

EXAMPLES = ROOT / "docs" / "examples"


@pytest.mark.parametrize("inches", [2.5, 3.0, 4.5])
@pytest.mark.parametrize(
    ("figure", "name"),
    [
        (plot.percentiles, "n_d_3.h5"),
        (plot.summary, "quickstart.h5"),
        (plot.contact_over_linear, "quickstart.h5"),
        (plot.convergence_errors, "design.h5"),
    ],
)
def test_no_point_lies_below_a_legend(figure, name, inches):
    """They lay over half of the curves in axes of 3 inches."""
    whole, axes = pyplot.subplots(figsize=(1.3 * inches, inches), layout="constrained")
    figure(EXAMPLES / name, ax=axes)
    whole.canvas.draw()
    legend = axes.get_legend()
    pyplot.close(whole)
    if legend is None:
        assert inches <= 3.0  # too small for a legend and the note of a verdict
        return
    box = legend.get_window_extent()
    for line in axes.lines:
        points = axes.transData.transform(np.transpose(line.get_data()).astype(float))
        points = points[np.isfinite(points).all(axis=1)]
        assert not any(box.contains(x, y) for x, y in points), line.get_label()
