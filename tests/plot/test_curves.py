"""What the figures draw is what the file holds: the data of their lines, points and pictures.

Words and styles are free; a panel must hold the curves of the data, in the order of the data.
"""

import numpy as np
import pytest
from matplotlib import pyplot as plt

from hpcrub import plot
from hpcrub.contact.status import NOT_STEADY, STEADY
from hpcrub.errors import InputError
from hpcrub.plot import densities, histories, maps
from hpcrub.plot.casings import EXAGGERATED
from hpcrub.plot.disks import families
from hpcrub.results.layout import DONE
from hpcrub.statistics.percentiles import Z_95, percentile_interval
from hpcrub.studies.damping import KINDS
from tests.plot.stored import PATTERN, File, contact_file, modal_file
from tests.program import TINY

N = 40  # samples of every level


@pytest.fixture
def random():
    yield np.random.default_rng(6)
    plt.close("all")


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


def bars(axes):
    """Confidence intervals of an axes, {(x, centre): [low, high]}; infinite where an arrow is."""
    found = {}
    for bar in axes.collections:
        if hasattr(bar, "get_segments"):
            for (x0, y0), (_, y1) in bar.get_segments():
                ends = found.setdefault(x0, [])
                ends.append((y0, y1))
    return found


def arrows(axes):
    """Points (x, y, direction up or down) at which an open end is drawn."""
    return sorted(
        (*note.xy, int(np.sign(note.xyann[1]))) for note in axes.texts if note.arrow_patch
    )


def assert_intervals(axes, *rows):
    """Every (x, centre, low, high) is drawn: a bar to each finite end, an arrow at the others."""
    drawn, open_ends = bars(axes), arrows(axes)
    for x, centre, low, high in rows:
        for end, sign in ((low, -1), (high, 1)):
            pair = sorted((centre, end)) if np.isfinite(end) else None
            if pair:
                assert any(np.allclose(sorted(b), pair, rtol=1e-9) for b in drawn[x]), (x, pair)
            else:
                assert any(np.allclose((x, centre, sign), a) for a in open_ends), (x, centre, sign)


def interval_rows(x, values, at):
    """Rows for `assert_intervals` of the percentiles of values."""
    low, high = percentile_interval(values, at, Z_95)
    return [(x, *row) for row in zip(np.percentile(values, at), low, high, strict=True)]


def test_summary(random):
    file = contact_file(random)
    left, right = plot.summary(file)
    speeds = file.read("speeds_hz")
    samples = 1e3 * done(file, "samples/amplitude_m", 1)
    low, middle, high = np.percentile(samples, [0, 50, 100], axis=0)  # too few for 1 and 99
    tuned = 1e3 * file.read("tuned/amplitude_m")
    assert_drawn(left, (speeds, middle), (speeds, tuned))
    assert "range of 39 samples" in str([t.get_text() for t in left.get_legend().get_texts()])
    band = edges(left)
    for x, ends in zip(speeds, np.transpose([low, high]), strict=True):
        found = band[band[:, 0] == x, 1]
        np.testing.assert_allclose([found.min(), found.max()], ends)
    names = "samples/amplification", "samples/linear_amplification"
    assert_drawn(right, *(([2, 4], curve) for n in names for curve in percentiles(file, n)))
    rows = [
        row
        for name in names
        for level, x in enumerate((2.0, 4.0))
        for row in interval_rows(x, done(file, name, level), [1, 50, 99])
    ]
    assert any(np.isnan(row).any() for row in rows)
    assert_intervals(right, *rows)
    assert len(arrows(right)) == sum(np.isnan(row).sum() for row in rows)
    assert [t.get_text() for t in right.get_xticklabels()] == [
        "±2 %\nσ = 1.2 %", "±4 %\nσ = 2.3 %",
    ]  # fmt: skip


def test_a_band_of_many_samples_is_of_percentiles(random):
    file = contact_file(random, shape=(2, 300))
    axes = plot.summary(file)[0]
    samples = 1e3 * done(file, "samples/amplitude_m", 1)
    wanted = np.percentile(samples[:, 0], [1, 99])
    band = edges(axes)
    found = band[band[:, 0] == 34.0, 1]
    np.testing.assert_allclose([found.min(), found.max()], wanted)


def test_summary_of_a_pattern(random):
    file = contact_file(random, TINY[: TINY.index("mistuning")] + PATTERN, (1, 1))
    file.values["samples/point_status"][0, 0, 1] = NOT_STEADY
    panels = plot.summary(file)
    speeds = file.read("speeds_hz")
    for panel, name, scale in zip(panels, ("amplitude_m", "localisation"), (1e3, 1e2), strict=True):
        mistuned, tuned = file.read(f"samples/{name}", (0, 0)), file.read(f"tuned/{name}")
        hollow = speeds[1], scale * mistuned[1]
        assert_drawn(panel, (speeds, scale * mistuned), hollow, (speeds, scale * tuned))


def test_responses_of_a_family_and_their_differences(random):
    """The finest model is the reference; the grey band is the range of its tuned runs."""
    text = TINY[: TINY.index("mistuning")].replace("reduction: {n_modes: 12}\n", "") + PATTERN
    files = [
        contact_file(random, f"{text}reduction: {{n_modes: {n}}}\n", (1, 1)) for n in (36, 84, 60)
    ]
    panels = np.reshape(plot.family(files), (2, 2))
    speeds = files[0].read("speeds_hz")
    for column, (group, where) in enumerate((("tuned", ()), ("samples", (0, 0)))):
        first, best, middle = (1e3 * f.read(f"{group}/amplitude_m", where) for f in files)
        assert_drawn(panels[0, column], (speeds, first), (speeds, middle), (speeds, best))
        assert_drawn(panels[1, column], (speeds, first - best), (speeds, middle - best))
        (band,) = panels[1, column].patches
        np.testing.assert_allclose(band.get_extents().transformed(
            panels[1, column].transData.inverted()).intervaly, [-1.0, 2.0])  # fmt: skip


def test_a_family_of_other_speeds_has_a_panel_for_each(random):
    files = [contact_file(random, f"{TINY}casing: {{n_bumps: {n}}}\n") for n in (5, 3)]
    files[0].values["speeds_hz"] = np.array([27.0, 27.2, 27.4])
    panels = plot.family(files)
    assert [panel.get_title() for panel in panels] == ["$n_d$ = 3", "$n_d$ = 5"]
    for panel, file in zip(panels, files[::-1], strict=True):
        assert_drawn(panel, (file.read("speeds_hz"), 1e3 * file.read("tuned/amplitude_m")))


def test_percentiles_over_sigma(random):
    file = contact_file(random)
    names = "samples/amplification", "samples/linear_amplification"
    x = [0.0, *100 * file.read("sigma")]
    axes = plot.percentiles(file)
    assert_drawn(axes, *((x, [1.0, *curve]) for n in names for curve in percentiles(file, n)))
    rows = [
        row
        for name in names
        for level in range(2)
        for row in interval_rows(x[level + 1], done(file, name, level), [1, 50, 99])
    ]
    assert_intervals(axes, *rows)
    assert "39 samples" in axes.get_title()


def test_percentiles_of_one_level_are_rows(random):
    """Contact above linear in every row; the reference's values as lines through all of them."""
    text = TINY.replace("[2, 4]", "[4]")
    files = [
        contact_file(random, f"{text}contact: {{friction: {mu}}}\n", (1, N)) for mu in (0.3, 0.15)
    ]
    axes = plot.percentiles(files)
    for row, file in enumerate(files[::-1]):
        for name, height in (("amplification", row - 0.12), ("linear_amplification", row + 0.12)):
            found = np.percentile(done(file, f"samples/{name}", 0), [1, 50, 99])
            assert_drawn(axes, *((value, height) for value in found))
    reference = np.percentile(done(files[1], "samples/amplification", 0), 50)
    assert_drawn(axes, ([reference] * 2, [0, 1]))
    names = [label.get_text() for label in axes.get_yticklabels()]
    assert names == ["friction 0.15\n(lines; 39 samples)", "friction 0.30\n(39 samples)"]


def test_convergence_has_a_panel_for_each_file_and_percentile(random):
    files = [contact_file(random, f"{TINY}casing: {{n_bumps: {n}}}\n") for n in (3, 4)]
    seen = files[0].read("statistics/contact/samples_seen")
    for draw, name, scale in (
        (plot.running, "mean_of_percentile", 1.0), (plot.errors, "convergence_error", 100.0),
    ):  # fmt: skip
        panels = np.reshape(draw(files), (2, 3))
        for row, file in zip(panels, files, strict=True):
            values = scale * file.read(f"statistics/contact/{name}")
            for p, panel in enumerate(row):
                assert_drawn(panel, *((seen, level[p]) for level in values))


def test_amplitudes_over_the_bumps(random):
    """Sorted by n_d; the spread of the tuned runs and the intervals are the error bars."""
    files = [contact_file(random, f"{TINY}casing: {{n_bumps: {n}}}\n") for n in (5, 3)]
    axes = plot.amplitudes(files)
    files = files[::-1]
    tuned = [1e3 * file.read("tuned/reference_amplitude_m") for file in files]
    peaks = [[1e3 * done(file, "samples/peak_amplitude_m", v) for file in files] for v in range(2)]
    curves = [
        (np.arange(2) + 0.06 * (v + 1), [np.percentile(p, 99) for p in peaks[v]]) for v in range(2)
    ]
    assert_drawn(axes, (np.arange(2), tuned), *curves)
    spread = np.array(axes.collections[0].get_segments())[:, :, 1]
    np.testing.assert_allclose(spread, np.full((2, 2), [12.0, 15.0]))
    for v, (x, _) in enumerate(curves):
        for i in range(2):
            assert_intervals(axes, *interval_rows(x[i], peaks[v][i], [99]))
    assert all(up == 1 for *_, up in arrows(axes))
    assert len(arrows(axes)) == 4  # percentile 99 of 39 samples has no upper end
    assert axes.get_lines()[0].get_linestyle() == "-"


def test_cases_without_an_order_are_not_joined(random):
    files = [
        contact_file(random, f"{TINY}contact: {{kinematics: {k}}}\n") for k in ("small", "polar")
    ]
    assert {line.get_linestyle() for line in plot.amplitudes(files).get_lines()} == {"None"}


def test_linear_percentiles(random):
    amplification = random.gamma(20.0, 0.06, (2, 2, N))
    file = File("study: linear", n_diameters=[2, 5], sigma=[0.01, 0.02])
    file.values["amplification"] = amplification
    for d, panel in enumerate(plot.linear(file)):
        curves = np.percentile(amplification[:, d], [1, 50, 99], axis=1)
        assert_drawn(panel, *(([0.0, 1.0, 2.0], [1.0, *curve]) for curve in curves))
        for x, values in zip((1.0, 2.0), amplification[:, d], strict=True):
            assert_intervals(panel, *interval_rows(x, values, [1, 50, 99]))


def test_damping(random):
    """Centres, ends and open ends are those of the file."""
    centre = random.uniform(1, 2, (2, 2, 3, 3))
    ends = centre[..., None] + np.array([-0.1, 0.2])
    ends[:, 1, 2, 2, 1] = np.nan
    values = {f"{kind}__percentile": v for kind, v in zip(KINDS, centre, strict=True)}
    values |= {f"{kind}__interval": v for kind, v in zip(KINDS, ends, strict=True)}
    sigma = np.array([0.006, 0.012, 0.023])
    file = File("study: damping\nsources: [a.h5, b.h5]", sigma=sigma, **values)
    file.values["damping_ratio"] = np.array([0.005, 0.004])
    for k, panel in enumerate(plot.damping(file)):
        x = [0.0, *100 * sigma]
        assert_drawn(panel, *((x, [1.0, *centre[k, c, :, p]]) for c in range(2) for p in range(3)))
        rows = [
            (x[level + 1], centre[k, c, level, p], *ends[k, c, level, p])
            for c in range(2) for level in range(3) for p in range(3)
        ]  # fmt: skip
        assert_intervals(panel, *rows)
        np.testing.assert_allclose(arrows(panel), [(100 * sigma[2], centre[k, 1, 2, 2], 1)])


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


@pytest.mark.parametrize("n", [40, 400])
def test_cross(random, n):
    """A hundred samples or fewer are dots, without density or percentile 99."""
    high, low = random.uniform(1.2, 1.6, (1, n)), random.uniform(0.9, 1.4, (1, n))
    x, y = np.linspace(0.9, 1.4, 30), np.linspace(1.2, 1.6, 40)
    file = File(
        "study: cross\nsources: [a.h5]",
        sigma=[0.02], contact=high, linear=low, share=[0.9], share_interval=[[0.8, 1.0]],
        rank_correlation=[0.5], rank_correlation_interval=[[0.4, 0.6]],
        grid_contact=[y], grid_linear=[x],
        density=np.exp(-(((y[:, None] - 1.4) / 0.05) ** 2) - ((x - 1.1) / 0.1) ** 2)[None],
    )  # fmt: skip
    axes = plot.cross(file)
    assert_drawn(axes, (low[0], high[0]))
    assert f"{n} samples" in axes.get_title()
    if n == 40:
        assert not axes.collections
        assert len(lines(axes)) == 2  # with the diagonal
        return
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
    share = densities.cumulative(np.exp(-square / 2))
    np.testing.assert_allclose(share, 1 - np.exp(-square / 2), atol=2e-3)


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
        amplitude_change=np.zeros((2, 2)),
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


def test_casing(random):
    angle, time = np.linspace(0, 2 * np.pi, 50), np.linspace(0, 0.02, 9)
    file = File(
        "study: casing", angle_rad=angle, gap_m=random.uniform(-1e-3, 1e-3, 50),
        inward_m=random.uniform(0, 1e-3, 50), growth_time_s=time, growth=random.uniform(0, 1, 9),
    )  # fmt: skip
    around, gap, growth = plot.casing(file)
    assert_drawn(gap, (np.degrees(angle), 1e3 * file.read("gap_m")))
    assert_drawn(growth, (1e3 * time, file.read("growth")))
    radius = 500 + EXAGGERATED * (0.25 - 1e3 * file.read("inward_m"))
    assert_drawn(around, (radius * np.cos(angle), radius * np.sin(angle)))


@pytest.mark.parametrize("odd", [10**18, -1])
def test_nodal_diameters_of_a_damaged_file_are_not_drawn(odd):
    file = modal_file()
    file.values["full/nodal_diameters"] = np.array(file.read("full/nodal_diameters"))
    file.values["full/nodal_diameters"][0] = odd
    with pytest.raises(InputError, match="is damaged"):
        plot.safe(file)


def test_safe():
    """Families joined over the nodal diameters, the modes of both models on them."""
    file = modal_file()
    modes = [file.read(f"full/{name}") for name in ("nodal_diameters", "frequencies_hz")]
    expected = [base + 2.0 * np.arange(7) for base in (85.0, 500.0, 1500.0)]
    np.testing.assert_allclose(families(*modes), expected)
    for panel in plot.safe(file):
        assert_drawn(panel, *((np.arange(7), family) for family in expected), modes, modes)
