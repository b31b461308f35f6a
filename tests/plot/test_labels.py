"""What figures say and mark, on small data made by hand; that they are drawn is tested elsewhere.

Truth: the words a reader expects, and the quantiles of a normal distribution.
"""

from pathlib import Path
from types import SimpleNamespace

import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.text import Text
from scipy import stats

from hpcrub.config.schema import Config, load_runs
from hpcrub.plot import casing, cross, families, histories, modal
from hpcrub.plot.labels import labels, ordered
from hpcrub.plot.style import STYLE


def family(tmp_path, *sweep):
    """Stand-ins for the result files of a sweep."""
    path = tmp_path / "input.yaml"
    path.write_text("study: contact\nsweep:\n" + "".join(f"  - {{{keys}}}\n" for keys in sweep))
    return [SimpleNamespace(config=run, path=Path(run.output)) for run in load_runs(path)]


@pytest.mark.parametrize(
    ("sweep", "words"),
    [
        (("time.step_s: 1e-5", "time.step_s: 1e-6", "time.step_s: 2e-5", "time.step_s: 2e-6"),
         ("h = 1 µs", "h = 2 µs", "h = 10 µs", "h = 20 µs")),
        (("reduction.n_modes: 120", "reduction.n_modes: 36"), ("η = 36", "η = 120")),
        (("casing.n_bumps: 10", "casing.n_bumps: 3, speeds.from_hz: 9"),
         ("$n_d$ = 3", "$n_d$ = 10")),
        (("casing.clearance_mm: 0.25", "casing.clearance_mm: 0.2, casing.bump_height_mm: 1.2"),
         ("clearance 0.20 mm, bump height 1.20 mm", "clearance 0.25 mm, bump height 1.25 mm")),
        (("material.density_kg_m3: 8e3", "material.density_kg_m3: 7.8e3"),
         ("density 7800.0 kg/m³", "density 8000.0 kg/m³")),
        (("contact.kinematics: polar", "disk.blade.lean_deg: 44", "contact.friction: 0.15",
          "contact.friction: 0.2", "disk.n_blades: 9", "steady_state.min_correlation: 0.9"),
         ("blades 9", "lean 44.00°", "kinematics polar", "min correlation 0.90", "reference",
          "friction 0.20")),
        (("casing.n_bumps: 4",), ("n_bumps=4",)),
    ],
)  # fmt: skip
def test_a_family_is_told_apart_by_quantities_in_the_order_of_their_numbers(tmp_path, sweep, words):
    assert tuple(labels(ordered(family(tmp_path, *sweep)))) == words


class Stored:
    """A result file that holds some datasets only."""

    def __init__(self, config=None, **data):
        self.config, self.data, self.path = config or Config(), data, Path("made_by_hand.h5")

    def read(self, name, where=()):
        return np.asarray(self.data[name.rpartition("/")[2]])[where]


def test_an_error_of_0_leaves_a_gap_on_a_logarithmic_axis():
    errors = np.array([[[0.02, 0.0, 0.01], [0.0, 0.0, 0.003], [0.05, 0.04, 0.03]]])
    file = Stored(samples_seen=[20, 30, 40], convergence_error=errors, sigma=[0.01])
    figure = families.errors([file])
    *curves, target = figure.axes[0].get_lines()
    drawn = [np.ma.filled(curve.get_ydata(), -1.0) for curve in curves]
    np.testing.assert_allclose(drawn, [[2.0, -1.0, 1.0], [-1.0, -1.0, 0.3], [5.0, 4.0, 3.0]])
    np.testing.assert_allclose(target.get_ydata(), 0.5)
    assert "target" in {text.get_text() for text in figure.legends[0].get_texts()}


def test_samples_outside_the_contours_are_the_rare_ones():
    x, y = np.linspace(0.8, 2.2, 201), np.linspace(0.5, 2.5, 301)
    means, spread = (1.5, 1.6), (0.1, 0.2)
    density = np.outer(
        stats.norm(means[1], spread[1]).pdf(y), stats.norm(means[0], spread[0]).pdf(x)
    )
    samples = np.random.default_rng(0).normal(means, spread, (4000, 2)).T
    samples[:, 0] = 3.0, 1.6  # off the grid
    samples[0, 1] = np.nan
    found = cross.outside(*samples, x, y, density)
    distance = (((samples.T - means) / spread) ** 2).sum(axis=1)
    edge = stats.chi2(2).ppf(0.95)
    assert found[:2].all()
    np.testing.assert_array_equal(found[distance > 1.02 * edge], True)
    np.testing.assert_array_equal(found[distance < 0.98 * edge], False)


@pytest.fixture
def drawn():
    """Function that draws one of the program's figures of one file, laid out as on paper."""

    def draw(function, file):
        with plt.rc_context(STYLE):
            figure = function([file])
            figure.draw_without_rendering()
        return figure

    yield draw
    plt.close("all")


def words(legend):
    return [text.get_text() for text in legend.get_texts()]


def test_the_legend_of_the_gap_leaves_the_bumps_free(drawn):
    angle = np.linspace(0, 2 * np.pi, 361)
    gap = 0.25e-3 - 1.25e-3 * np.abs(np.cos(2 * angle)) ** 9
    file = Stored(angle_rad=angle, gap_m=gap, inward_m=0.25e-3 - gap,
                  growth_time_s=[0.0, 0.01], growth=[0.0, 1.0])  # fmt: skip
    panel = next(p for p in drawn(casing.casing, file).axes if "gap" in p.get_ylabel())
    assert not panel.get_legend().get_window_extent().overlaps(panel.get_window_extent())


def test_the_excited_point_of_a_safe_diagram_is_named_beside_the_modes(drawn):
    frequencies = np.repeat([91.0, 560.0, 1600.0], 7)
    file = Stored(nodal_diameters=np.tile(np.arange(7), 3), frequencies_hz=frequencies)
    panel = drawn(modal.safe, file).axes[0]
    (note,) = panel.texts
    assert note.get_text() == "4 bumps: 138 Hz"
    assert note.xy == (4, 138.0)
    box = Text.get_window_extent(note)  # of the words, without the arrow
    modes = panel.transData.transform(np.column_stack([np.tile(np.arange(7), 3), frequencies]))
    assert not any(box.contains(*mode) for mode in modes)
    assert not any(line.get_marker() == "*" for line in panel.get_lines())


def test_the_engine_orders_stand_at_their_own_lines(drawn):
    speeds, frequencies = np.linspace(10, 80, 15), np.linspace(0, 200, 21)
    file = Stored(speeds_hz=speeds, frequencies_hz=frequencies, deviation=np.zeros((1, 12)),
                  spectrum_m=np.full((1, 15, 21), 1e-3),
                  natural_frequencies_hz=np.full((1, 12), 91.0),
                  point_reason=np.zeros((1, 15), dtype=int))  # fmt: skip
    panel = drawn(histories.interaction, file).axes[0]
    ends = {n: panel.transData.transform((200 / n, 200)) for n in range(3, 13)}
    boxes = {int(note.get_text()): note.get_window_extent() for note in panel.texts}
    assert sorted(boxes) == [1, 2, 3, 4, 8, 12]
    for n in (3, 4, 8, 12):
        assert not any(boxes[n].x0 < ends[m][0] < boxes[n].x1 for m in ends if m != n)


def test_a_time_response_has_a_key_for_blades_and_windows(drawn):
    t = np.linspace(0, 1, 201)
    wave = 0.01 * np.sin(t)[None, :, None] * np.ones((1, 1, 12))
    file = Stored(
        deviation=np.zeros((1, 12)), time_s=t, tangential_m=wave, radial_m=wave, gap_m=wave,
        force_n=wave, check_s=[0.5, 0.8], window_s=0.09, correlation=[[0.9, 0.99]],
        amplitude_change=[[0.1, 0.001]], point_status=[1], point_reason=[0],
    )  # fmt: skip
    figure = drawn(histories.time, file)
    labels_y = [panel.get_ylabel() for panel in figure.axes]
    assert "$u_r$ of the tips [mm]" in labels_y
    assert "blade" in labels_y
    assert words(figure.legends[0]) == [
        "first window compared", "second window", "checks of the steady state",
    ]  # fmt: skip
