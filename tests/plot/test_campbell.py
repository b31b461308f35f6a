"""Campbell diagram: its lines are those of the modes, and meet where the study says."""

import numpy as np
import pytest

from hpcrub import plot
from hpcrub.config.schema import Config
from hpcrub.studies import open_result
from tests.program import TINY, computed


def line(axes, label):
    """Points (2, n) of the line with a label that begins so."""
    (found,) = (line for line in axes.lines if str(line.get_label()).startswith(label))
    return np.array(found.get_data())


def test_lines_and_crossing_are_those_of_a_modal_study(folder):
    path = computed(folder, f"{TINY}study: modal\n")
    axes = plot.campbell(path)
    with open_result(path) as file:
        frequencies, diameters = (
            file.read(f"reduced/{name}") for name in ("frequencies_hz", "nodal_diameters")
        )
        met = float(file.read("crossing_hz"))
    own = frequencies[diameters == 4][0]
    np.testing.assert_allclose(line(axes, "4 nodal diameters")[1], own, rtol=1e-6)
    mark = line(axes, f"order 4 meets family 1 at {met:.4g} Hz, {60 * met:,.0f} rpm")
    np.testing.assert_allclose(mark.ravel(), (met, own), rtol=1e-6)
    assert met == pytest.approx(own / 4, rel=1e-6)  # a disk that rotation does not stiffen


def test_of_an_input_alone_it_is_drawn_too():
    axes = plot.campbell(Config(study="modal", casing={"n_bumps": 3}))
    at_end = line(axes, "order 3 of the casing")[:, -1]
    assert at_end[1] == pytest.approx(3 * at_end[0])
