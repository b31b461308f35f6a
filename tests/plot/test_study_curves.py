"""Figures of the studies other than contact: they draw what the file holds, as in `test_curves`."""

import numpy as np
import pytest

from hpcrub import plot
from hpcrub.config.schema import Config
from hpcrub.contact.status import STEADY
from hpcrub.plot import histories, maps
from hpcrub.plot.casings import EXAGGERATED
from hpcrub.plot.disks import families
from tests.plot.drawn import (
    assert_drawn,
    assert_intervals,
    edges,
    interval_rows,
    lines,
)
from tests.plot.stored import File, modal_file
from tests.program import TINY

N = 40  # samples of every level


def test_linear_percentiles(random):
    amplification = random.gamma(20.0, 0.06, (2, 2, N))
    file = File("study: linear", n_diameters=[2, 5], sigma=[0.01, 0.02])
    file.values["amplification"] = amplification
    for d, panel in enumerate(plot.linear(file)):
        curves = np.percentile(amplification[:, d], [1, 50, 99], axis=1)
        assert_drawn(panel, *(([0.0, 1.0, 2.0], [1.0, *curve]) for curve in curves))
        for x, values in zip((1.0, 2.0), amplification[:, d], strict=True):
            assert_intervals(panel, *interval_rows(x, values, [1, 50, 99]))


@pytest.mark.parametrize("each", [8, 30])
def test_energy(random, each):
    """All samples at their own σ; a range only of levels with enough of them."""
    file = File(
        f"study: energy\nsources: [a.h5]\nenergy: {{samples: {2 * each}}}",
        sigma=np.repeat([0.01, 0.02], each), amplification=random.uniform(1, 2, 2 * each),
        energy_j=random.uniform(1, 9, (2 * each, 3, 12)),
        tuned__energy_j=random.uniform(1, 4, (3, 12)),
    )  # fmt: skip
    panels = np.reshape(plot.energy([file, file]), (2, 2))
    x, by_size = np.repeat([1.0, 2.0], each), file.read("amplification")
    by_energy = file.read("energy_j").max(axis=(1, 2)) / file.read("tuned/energy_j").max()
    for row in panels:
        for panel, y in zip(row, (by_size, by_energy), strict=True):
            parts = y.reshape(2, each)
            edge = [([1, 2], parts.min(axis=1)), ([1, 2], parts.max(axis=1))]
            assert_drawn(panel, (x, y), *(edge if each == 30 else ()))
            drawn = [line for line in lines(panel) if len(line)]
            assert len(drawn) == (3 if each == 30 else 1)


def test_time_response(random):
    """The tip with the largest motion at the end, and the envelope of all."""
    time = np.linspace(0.0, 0.5, 60)
    shape = 2, 60, 12
    file = File(
        "study: time_response\nspeeds: {from_hz: 30, to_hz: 30}",
        time_s=time, deviation=np.zeros((2, 12)), tangential_m=random.uniform(-1e-2, 1e-2, shape),
        radial_m=random.uniform(-1e-3, 1e-3, shape), gap_m=random.uniform(0, 1e-3, shape),
        point_status=np.full(2, STEADY), force_n=random.uniform(0, 1e4, shape),
        check_s=np.array([0.3, 0.5]), window_s=0.1, correlation=np.array([[1, 1], [0.5, 0.99]]),
        amplitude_change=np.zeros((2, 2)), judged_s=np.array([0.3, 0.5]),
    )  # fmt: skip
    file.values["tangential_m"][1, -1, 4] = -0.02
    panels = np.reshape(plot.time(file)[:8], (4, 2))
    close = time > 0.5 - 3 / 30
    rows = ("tangential_m", 1e3), ("radial_m", 1e3), ("gap_m", 1e3), ("force_n", 1e-3)
    for (name, scale), (left, right) in zip(rows, panels, strict=True):
        values = scale * file.read(name, 1)
        assert_drawn(left, (time, values[:, 4]))
        assert_drawn(right, (time[close], values[close, 4]))
        band = edges(right)
        for t, now in zip(time[close], values[close], strict=True):
            found = band[band[:, 0] == t, 1]
            np.testing.assert_allclose([found.min(), found.max()], [now.min(), now.max()])
    spans = [patch.get_extents().transformed(panels[0, 0].transData.inverted())
             for patch in panels[0, 0].patches]  # fmt: skip
    found = np.sort([[span.x0, span.x1] for span in spans], axis=0)
    np.testing.assert_allclose(found, [[0.3, 0.4], [0.4, 0.5]])  # of the second check: it passed


def test_an_envelope_holds_every_value(random):
    time = np.linspace(0, 1, 7001)
    values = random.normal(size=(7001, 3))
    middle, low, high = histories.envelope(time, values)
    assert len(middle) == histories.BINS
    assert low.min() == values.min()
    assert high.max() == values.max()
    part = np.searchsorted((middle[1:] + middle[:-1]) / 2, time)
    assert (low[part] <= values.min(axis=1)).all()
    assert (high[part] >= values.max(axis=1)).all()


def ridge(speeds, frequencies, order, centre, width, size):
    """A spectrum that is large where an engine order passes a speed."""
    near = np.exp(-(((speeds - centre) / width) ** 2))
    return size * near[:, None] * np.exp(-(((frequencies - order * speeds[:, None]) / 1.0) ** 2))


def test_interaction_map():
    """Two ridges made by hand: their speeds, frequencies and Δ1B are drawn where they are."""
    speeds, frequencies = np.arange(20.0, 80.5, 0.5), np.arange(0.0, 200.0, 1.0)
    spectrum = 1e-6 + ridge(speeds, frequencies, 4, 35.0, 1.0, 0.03)
    spectrum += ridge(speeds, frequencies, 2, 68.0, 2.0, 0.02)
    natural = np.array([[*np.linspace(90.0, 93.0, 12), 540.0]])
    file = File(
        "study: interaction_map", speeds_hz=speeds, frequencies_hz=frequencies,
        deviation=np.zeros((1, 12)), spectrum_m=spectrum[None], natural_frequencies_hz=natural,
        point_reason=np.zeros((1, len(speeds)), np.uint8),
        point_status=np.full((1, len(speeds)), STEADY), mean_error_m=np.zeros((1, len(speeds))),
        mean_amplitude_m=spectrum.max(axis=1)[None],
    )  # fmt: skip
    axes = plot.interaction_map(file)
    np.testing.assert_allclose(axes.collections[0].get_array(), 1e3 * spectrum.T)
    assert_drawn(axes, (speeds, speeds), (speeds, 4 * speeds), ([0, 1], [90, 90]))
    assert not any((line[:, 1] == 540).all() for line in lines(axes) if len(line))
    strongest, other = maps.interactions(speeds, frequencies, spectrum)
    assert (strongest.order, strongest.speed_hz, strongest.frequency_hz) == (4, 35.0, 140.0)
    assert (other.order, other.speed_hz) == (2, 68.0)
    # exp(-(x/w)²) is one half at w sqrt(ln 2): 0.83 and 1.67 Hz from the middle
    assert (strongest.first_hz, strongest.last_hz) == (34.5, 35.5)
    assert (other.first_hz, other.last_hz) == (66.5, 69.5)
    assert_drawn(axes, ([0, 1], [140, 140]))
    boxes = [patch.get_bbox() for patch in axes.patches]
    assert [box.contains(*at) for box, at in zip(boxes, ((35, 140), (68, 136)), strict=True)] == [
        True, True,
    ]  # fmt: skip
    assert "$\\Delta_{1B}$ = 47 Hz" in [note.get_text() for note in axes.texts]


def test_branches(random):
    n_starts = 4
    amplitude = np.full((n_starts, 3), 0.01) + random.uniform(0, 1e-5, (n_starts, 3))
    file = File(
        f"study: branches\nbranches: {{perturbed: 1}}\n{TINY}",
        speeds_hz=np.array([34.0, 34.2, 34.4]), amplitude_m=amplitude,
        window_amplitude_m=amplitude[..., None] * (0.9 + 0.01 / np.sqrt(2) * np.array([-1.0, 1.0])),
        localisation=random.uniform(0.1, 0.2, (n_starts, 3)),
        window_localisation=np.full((n_starts, 3, 2), 0.15) + [-0.1, 0.1],
        point_status=np.full((n_starts, 3), STEADY),
    )  # fmt: skip
    top, bottom = plot.branches(file)
    speeds = file.read("speeds_hz")
    for start, points in enumerate(top.collections):
        np.testing.assert_allclose(
            points.get_offsets(), np.column_stack([speeds, 1e3 * amplitude[start]])
        )
        np.testing.assert_allclose(points.get_array(), 100 * file.read("localisation", start))
    scatter, points = bottom.collections
    np.testing.assert_allclose(
        points.get_offsets(), np.column_stack([np.tile(speeds, n_starts), 900 * amplitude.ravel()])
    )
    np.testing.assert_allclose(points.get_array(), 15.0)  # colours are the localisation
    assert points.norm.vmin == top.collections[0].norm.vmin  # on one scale
    ends = np.array(scatter.get_segments())[:, :, 1]
    np.testing.assert_allclose(ends, 1e3 * amplitude.reshape(-1, 1) * [0.89, 0.91])


def test_casing():
    """Three bumps, where they are highest the tips would be 1 mm deep; the growth ends at 1."""
    config = Config(casing={"n_bumps": 3})
    around, gap, growth = plot.casing(config)
    (line, *_) = gap.get_lines()
    angle, found = line.get_data()
    assert found.min() == pytest.approx(0.25 - 1.25)
    assert angle[found < found.min() + 1e-9] == pytest.approx(np.arange(4) * 120)
    radius = 500 + EXAGGERATED * found
    x, y = radius * np.cos(np.radians(angle)), radius * np.sin(np.radians(angle))
    np.testing.assert_allclose(lines(around)[0], np.column_stack([x, y]), atol=1e-9)
    (ramp,) = growth.get_lines()
    assert ramp.get_ydata()[[0, -1]] == pytest.approx([0.0, 1.0])


def test_safe():
    """Families joined over the nodal diameters, the modes of both models on them."""
    file = modal_file()
    modes = [file.read(f"full/{name}") for name in ("nodal_diameters", "frequencies_hz")]
    expected = [base + 2.0 * np.arange(7) for base in (85.0, 500.0, 1500.0)]
    np.testing.assert_allclose(families(*modes), expected)
    for panel in plot.safe(file):
        assert_drawn(panel, *((np.arange(7), family) for family in expected), modes, modes)
