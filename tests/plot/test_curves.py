"""What the figures draw is what the file holds: the data of their lines, points and pictures.

Words and styles are free; a panel must hold the curves of the data, in the order of the data.
"""

from pathlib import Path

import numpy as np
import pytest
from matplotlib import pyplot as plt

from hpcrub.config.schema import Config
from hpcrub.contact.status import NOT_STEADY, STEADY
from hpcrub.plot import (
    branches,
    casing,
    contact,
    cross,
    damping,
    energy,
    families,
    histories,
    linear,
    modal,
)
from hpcrub.results.layout import DONE
from hpcrub.statistics.percentiles import percentile_interval
from tests.program import TINY

N = 40  # samples of every level
PATTERN = f"mistuning: {{pattern_gpa: {[205.0, 215.0] * 6}}}\n"


class File:
    """Stands for an open result file: a configuration and arrays by name."""

    def __init__(self, text, **values):
        self.config, self.path = Config.from_yaml(text), Path("file.h5")
        self.values = {name.replace("__", "/"): value for name, value in values.items()}

    def read(self, name, where=()):
        return np.asarray(self.values[name])[where]

    def status(self):
        return self.read("samples/status")


@pytest.fixture
def random():
    yield np.random.default_rng(6)
    plt.close("all")


def contact_file(random, text=TINY, shape=(2, N)):
    """Two levels, three speeds; another distribution for everything."""
    status = np.full(shape, DONE)
    status[:, 3:4] = 0  # not there yet: its values must not count
    return File(
        text,
        speeds_hz=np.array([34.0, 34.2, 34.4]),
        half_range=np.array([0.02, 0.04])[: shape[0]],
        sigma=np.array([0.02, 0.04])[: shape[0]] / np.sqrt(3),
        tuned__amplitude_m=random.uniform(0.01, 0.02, 3),
        tuned__localisation=random.uniform(0.0, 0.1, 3),
        tuned__point_status=np.full(3, STEADY),
        tuned__reference_amplitude_m=0.013,
        tuned__run_peaks_m=np.array([0.012, 0.013, 0.015]),
        samples__status=status,
        samples__amplitude_m=random.gamma(9.0, 0.002, (*shape, 3)),
        samples__localisation=random.uniform(0.1, 0.6, (*shape, 3)),
        samples__point_status=np.full((*shape, 3), STEADY),
        samples__peak_amplitude_m=random.gamma(9.0, 0.003, shape),
        samples__amplification=random.gamma(9.0, 0.2, shape),
        samples__linear_amplification=random.gamma(30.0, 0.05, shape),
        statistics__contact__samples_seen=np.arange(1, 9) * 5,
        statistics__contact__mean_of_percentile=random.uniform(1, 2, (2, 3, 8)),
        statistics__contact__convergence_error=random.uniform(1e-3, 1e-2, (2, 3, 8)),
    )


def lines(axes):
    """Data (n, 2) of every line."""
    return [np.column_stack(line.get_data()).astype(float) for line in axes.get_lines()]


def assert_drawn(axes, *curves):
    """The curves, pairs (x, y), are among the lines, one after the other."""
    left = lines(axes)
    for x, y in curves:
        wanted = np.column_stack(np.broadcast_arrays(x, y))
        while left:
            line = left.pop(0)
            if line.shape == wanted.shape and np.allclose(line, wanted, rtol=1e-12, atol=0):
                break
        else:
            pytest.fail(f"not drawn, or not in this order: {wanted}")


def edges(axes, number=0):
    """Points of a shaded band."""
    return axes.collections[number].get_paths()[0].vertices


def done(file, name, level):
    return file.read(name, level)[file.status()[level] == DONE]


def percentiles(file, name):
    """Percentiles of the finished samples, (percentile, level)."""
    at = file.config.convergence.percentiles
    return np.transpose([np.percentile(done(file, name, v), at) for v in range(2)])


def test_summary(random):
    file = contact_file(random)
    left, right = contact.summary([file]).axes
    speeds = file.read("speeds_hz")
    samples = 1e3 * done(file, "samples/amplitude_m", 1)
    low, middle, high = np.percentile(samples, [1, 50, 99], axis=0)
    tuned = 1e3 * file.read("tuned/amplitude_m")
    assert_drawn(left, (speeds, middle), (speeds, tuned))
    band = edges(left)
    for x, ends in zip(speeds, np.transpose([low, high]), strict=True):
        found = band[band[:, 0] == x, 1]
        np.testing.assert_allclose([found.min(), found.max()], ends)
    names = "samples/amplification", "samples/linear_amplification"
    assert_drawn(right, *(([2, 4], curve) for n in names for curve in percentiles(file, n)))


def test_summary_of_a_pattern(random):
    file = contact_file(random, TINY[: TINY.index("mistuning")] + PATTERN, (1, 1))
    file.values["samples/point_status"][0, 0, 1] = NOT_STEADY
    panels = contact.summary([file]).axes
    speeds = file.read("speeds_hz")
    for panel, name, scale in zip(panels, ("amplitude_m", "localisation"), (1e3, 1e2), strict=True):
        mistuned, tuned = file.read(f"samples/{name}", (0, 0)), file.read(f"tuned/{name}")
        hollow = speeds[1], scale * mistuned[1]
        assert_drawn(panel, (speeds, scale * mistuned), hollow, (speeds, scale * tuned))


def test_families(random):
    file = contact_file(random)
    speeds = file.read("speeds_hz")
    assert_drawn(families.responses([file]).axes[0], (speeds, 1e3 * file.read("tuned/amplitude_m")))
    names = "samples/amplification", "samples/linear_amplification"
    x = [0.0, *100 * file.read("sigma")]
    expected = [(x, [1.0, *curve]) for n in names for curve in percentiles(file, n)]
    assert_drawn(families.percentiles([file]).axes[0], *expected)
    seen = file.read("statistics/contact/samples_seen")
    for draw, name, scale in (
        (families.running, "mean_of_percentile", 1.0),
        (families.errors, "convergence_error", 100.0),
    ):
        values = scale * file.read(f"statistics/contact/{name}")
        assert_drawn(draw([file]).axes[0], *((seen, y) for level in values for y in level))


def test_amplitudes_over_the_bumps(random):
    """Sorted by n_d; the spread of the tuned runs and the intervals are the error bars."""
    files = [contact_file(random, f"{TINY}casing: {{n_bumps: {n}}}\n") for n in (5, 3)]
    (axes,) = families.amplitudes(files).axes
    files = files[::-1]
    tuned = [1e3 * file.read("tuned/reference_amplitude_m") for file in files]
    peaks = [[1e3 * done(file, "samples/peak_amplitude_m", v) for file in files] for v in range(2)]
    curves = [
        (np.arange(2) + 0.04 * (v + 1), [np.percentile(p, 99) for p in peaks[v]]) for v in range(2)
    ]
    assert_drawn(axes, (np.arange(2), tuned), *curves)
    bars = [np.array(bar.get_segments())[:, :, 1] for bar in axes.collections]
    np.testing.assert_allclose(bars[0], np.full((2, 2), [12.0, 15.0]))
    for v in range(2):
        low, high = np.transpose([np.ravel(percentile_interval(p, [99], 1.96)) for p in peaks[v]])
        top = curves[v][1]
        expected = np.where(np.isnan([low, high]), top, [low, high]).T
        np.testing.assert_allclose(bars[v + 1], expected, rtol=1e-4)


def test_linear_percentiles(random):
    amplification = random.gamma(20.0, 0.06, (2, 2, N))
    file = File("study: linear", n_diameters=[2, 5], sigma=[0.01, 0.02])
    file.values["amplification"] = amplification
    for d, panel in enumerate(linear.percentiles([file]).axes[:2]):
        curves = np.percentile(amplification[:, d], [1, 50, 99], axis=1)
        assert_drawn(panel, *(([0.0, 1.0, 2.0], [1.0, *curve]) for curve in curves))
        ends = [np.array(percentile_interval(v, [50], 1.96)).ravel() for v in amplification[:, d]]
        band = edges(panel, 1)
        for x, (low, high) in zip((1.0, 2.0), ends, strict=True):
            assert {low, high} <= set(band[band[:, 0] == x, 1])


def test_damping(random):
    values = {f"{kind}__percentile": random.uniform(1, 2, (2, 3, 3)) for kind in damping.KINDS}
    values |= {f"{kind}__interval": random.uniform(1, 2, (2, 3, 3, 2)) for kind in damping.KINDS}
    sigma = np.array([0.006, 0.012, 0.023])
    file = File("study: damping\nsources: [a.h5, b.h5]", sigma=sigma, **values)
    file.values["damping_ratio"] = np.array([0.005, 0.004])
    for kind, panel in zip(damping.KINDS, damping.damping([file]).axes, strict=True):
        curves = file.read(f"{kind}/percentile")
        x = [0.0, *100 * sigma]
        expected = [(x, [1.0, *curves[case, :, p]]) for case in range(2) for p in range(3)]
        assert_drawn(panel, *expected)
        band = edges(panel, 4)  # of the second case, percentile 50
        assert set(file.read(f"{kind}/interval", (1, slice(None), 1)).ravel()) <= set(band[:, 1])


def test_energy(random):
    file = File(
        "study: energy\nsources: [a.h5]\nenergy: {samples: 6}",
        sigma=np.repeat([0.01, 0.02], 3),
        amplification=random.uniform(1, 2, 6),
        energy_j=random.uniform(1, 9, (6, 3, 12)),
        tuned__energy_j=random.uniform(1, 4, (3, 12)),
    )
    left, right = energy.energy([file]).axes
    x, by_size = np.repeat([1.0, 2.0], 3), file.read("amplification")
    by_energy = file.read("energy_j").max(axis=(1, 2)) / file.read("tuned/energy_j").max()
    for panel, y in ((left, by_size), (right, by_energy)):
        parts = y.reshape(2, 3)
        assert_drawn(panel, (x, y), ([1, 2], parts.min(axis=1)), ([1, 2], parts.max(axis=1)))


def test_cross(random):
    high, low = random.uniform(1.2, 1.6, (1, N)), random.uniform(0.9, 1.4, (1, N))
    x, y = np.linspace(0.9, 1.4, 30), np.linspace(1.2, 1.6, 40)
    file = File(
        "study: cross\nsources: [a.h5]",
        sigma=[0.02], contact=high, linear=low, share=[0.9], share_interval=[[0.8, 1.0]],
        rank_correlation=[0.5], rank_correlation_interval=[[0.4, 0.6]],
        grid_contact=[y], grid_linear=[x],
        density=np.exp(-(((y[:, None] - 1.4) / 0.05) ** 2) - ((x - 1.1) / 0.1) ** 2)[None],
    )  # fmt: skip
    axes = cross.cross([file]).axes[0]
    tops = np.percentile(high, 99), np.percentile(low, 99)
    assert_drawn(axes, (low[0], high[0]), ([0, 1], [tops[0]] * 2), ([tops[1]] * 2, [0, 1]))
    (filled,) = axes.collections
    densest = filled.get_paths()[0].vertices  # the contour that holds a quarter
    reach = np.sqrt(-np.log(1 - 0.25))
    assert np.ptp(densest[:, 0]) / 2 == pytest.approx(0.1 * reach, rel=0.05)
    assert np.ptp(densest[:, 1]) / 2 == pytest.approx(0.05 * reach, rel=0.05)
    assert densest.mean(axis=0) == pytest.approx([1.1, 1.4], abs=0.02)


def test_share_of_a_normal_density_inside_a_contour():
    """1 − exp(−r²/2) of it lies within r standard deviations."""
    x = np.linspace(-6, 6, 601)
    square = x[:, None] ** 2 + x**2
    share = cross.cumulative(np.exp(-square / 2))
    np.testing.assert_allclose(share, 1 - np.exp(-square / 2), atol=2e-3)


def test_time_response(random):
    time = np.linspace(0.0, 0.5, 60)
    shape = 2, 60, 12
    file = File(
        "study: time_response\nspeeds: {from_hz: 30, to_hz: 30}",
        time_s=time, deviation=np.zeros((2, 12)), tangential_m=random.uniform(-1e-2, 1e-2, shape),
        radial_m=random.uniform(-1e-3, 1e-3, shape), gap_m=random.uniform(0, 1e-3, shape),
        point_status=np.full(2, STEADY), force_n=random.uniform(0, 1e4, shape),
        check_s=np.array([0.3, 0.5]), window_s=0.1, correlation=np.array([[1, 1], [0.5, 0.99]]),
        amplitude_change=np.zeros((2, 2)),
    )  # fmt: skip
    panels = np.reshape(histories.time([file]).axes[:8], (4, 2))
    close = time > 0.5 - 3 / 30
    rows = ("tangential_m", 1e3), ("radial_m", 1e3), ("gap_m", 1e3), ("force_n", 1e-3)
    for (name, scale), (left, right) in zip(rows, panels, strict=True):
        values = scale * file.read(name, 1)
        for blade in range(12):
            assert_drawn(left, (time, values[:, blade]))
            assert_drawn(right, (time[close], values[close, blade]))
    spans = [patch.get_extents().transformed(panels[0, 0].transData.inverted())
             for patch in panels[0, 0].patches]  # fmt: skip
    found = np.sort([[span.x0, span.x1] for span in spans], axis=0)
    np.testing.assert_allclose(found, [[0.3, 0.4], [0.4, 0.5]])  # of the second check: it passed


def test_interaction_map(random):
    speeds, frequencies = np.array([30.0, 31.0, 32.0]), np.arange(0.0, 140.0, 20.0)
    spectrum = random.uniform(1e-6, 1e-3, (1, 3, 7))
    natural = np.array([[90.0, 92.0, 540.0]])
    file = File(
        "study: interaction_map", speeds_hz=speeds, frequencies_hz=frequencies,
        deviation=np.zeros((1, 12)), spectrum_m=spectrum, natural_frequencies_hz=natural,
        point_reason=np.zeros((1, 3), np.uint8),
    )  # fmt: skip
    axes = histories.interaction([file]).axes[0]
    np.testing.assert_allclose(axes.collections[0].get_array(), 1e3 * spectrum[0].T)
    assert_drawn(axes, (speeds, speeds), (speeds, 4 * speeds), ([0, 1], [90, 90]))
    assert not any((line[:, 1] == 540).all() for line in lines(axes) if len(line))


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
    top, bottom = branches.branches([file]).axes[:2]
    speeds = file.read("speeds_hz")
    for start, points in enumerate(top.collections):
        np.testing.assert_allclose(
            points.get_offsets(), np.column_stack([speeds, 1e3 * amplitude[start]])
        )
        np.testing.assert_allclose(points.get_array(), 100 * file.read("localisation", start))
    assert_drawn(bottom, (np.tile(speeds, n_starts), 900 * amplitude.ravel()))
    bars = np.array(bottom.collections[0].get_segments())[:, :, 1]
    np.testing.assert_allclose(bars, 1e3 * amplitude.reshape(-1, 1) * [0.89, 0.91])


def test_casing(random):
    angle, time = np.linspace(0, 2 * np.pi, 50), np.linspace(0, 0.02, 9)
    file = File(
        "study: casing", angle_rad=angle, gap_m=random.uniform(-1e-3, 1e-3, 50),
        inward_m=random.uniform(0, 1e-3, 50), growth_time_s=time, growth=random.uniform(0, 1, 9),
    )  # fmt: skip
    around, gap, growth = casing.casing([file]).axes
    assert_drawn(gap, (np.degrees(angle), 1e3 * file.read("gap_m")))
    assert_drawn(growth, (1e3 * time, file.read("growth")))
    radius = 500 + casing.EXAGGERATED * (0.25 - 1e3 * file.read("inward_m"))
    assert_drawn(around, (radius * np.cos(angle), radius * np.sin(angle)))


def test_safe(random):
    file = File("study: modal")
    for kind, n in (("full", 30), ("reduced", 20)):
        file.values[f"{kind}/nodal_diameters"] = np.arange(n) % 7
        file.values[f"{kind}/frequencies_hz"] = np.sort(random.uniform(90, 2000, n))
    models = [
        [file.read(f"{kind}/{name}") for name in ("nodal_diameters", "frequencies_hz")]
        for kind in ("full", "reduced")
    ]
    for panel in modal.safe([file]).axes:
        assert_drawn(panel, *models)
