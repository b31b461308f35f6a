"""What the figures draw is what the file holds: the data of their lines, points and pictures.

Words and styles are free; a panel must hold the curves of the data, in the order of the data.
"""

import numpy as np
import pytest
from scipy import stats

from hpcrub import plot
from hpcrub.contact.status import AVERAGED, NOT_STEADY
from hpcrub.errors import InputError
from hpcrub.plot import densities
from hpcrub.plot.families import finished
from hpcrub.results.layout import DONE
from hpcrub.studies.contact import measured
from tests.plot.drawn import (
    arrows,
    assert_drawn,
    assert_intervals,
    done,
    edges,
    interval_rows,
    lines,
    percentiles,
)
from tests.plot.stored import PATTERN, contact_file
from tests.program import TINY

N = 40  # samples of every level


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
    sides = dict(zip(names, (-0.02, 0.02), strict=True))  # of two levels 2 % apart
    assert_drawn(
        right,
        *(([2 + sides[n], 4 + sides[n]], curve) for n in names for curve in percentiles(file, n)),
    )
    rows = [
        row
        for name in names
        for level, x in enumerate((2.0, 4.0))
        for row in interval_rows(x + sides[name], done(file, name, level), [1, 50, 99])
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


def test_summary_of_one_level_is_a_row(random):
    """Percentiles side by side, contact above linear; they lay on each other at one x."""
    file = contact_file(random, TINY.replace("[2, 4]", "[2]"), (1, N))
    right = plot.summary(file)[1]
    for name, height in (("amplification", -0.12), ("linear_amplification", 0.12)):
        values = np.percentile(done(file, f"samples/{name}", 0), [1, 50, 99])
        assert_drawn(right, *(([value], [height]) for value in values))
    assert [t.get_text() for t in right.get_yticklabels()] == ["±2 %\nσ = 1.2 %"]


def test_summary_of_measured_disks_has_a_row_for_each(random):
    text = (
        TINY[: TINY.index("mistuning")]
        + "mistuning: {pattern: disks.csv, half_range_percent: [2], samples: 2}\n"
    )
    file = contact_file(random, text, (1, 2))
    file.values["samples/peak_speed_hz"] = np.array([[34.0, 34.4]])
    file.values["samples/point_status"][0, 1] = AVERAGED
    file.values["samples/amplitude_error_m"] = np.full((1, 2, 3), 1e-4)
    file.values["tuned/run_peaks_m"] = np.full(3, 0.013)
    left, right = plot.summary(file)
    contact, linear = (file.read(f"samples/{n}", 0) for n in measured.NAMES[:2])
    assert_drawn(right, (contact, [0.88, 1.88]), (linear, [1.12, 2.12]))
    assert [t.get_text() for t in right.get_yticklabels()] == ["disk 1", "disk 2"]
    speeds = file.read("speeds_hz")
    assert_drawn(left, *((speeds, 1e3 * file.read("samples/amplitude_m", (0, i))) for i in (0, 1)))
    steady, averaged = measured.disks(file)
    np.testing.assert_allclose(steady.interval, contact[0])  # no scatter, and one reference
    part = 1.96 * 1e-4 / file.read("samples/peak_amplitude_m", (0, 1))
    np.testing.assert_allclose(averaged.interval, contact[1] * (1 + part * np.array([-1, 1])), 1e-4)


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
    """The finest model is the reference; the grey band is twice the scatter of both disks."""
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
        (band,) = panels[1, column].collections
        widest = band.get_paths()[0].vertices[:, 1].max()
        if group == "tuned":  # of nine runs of each; of the single run of the pattern it is unknown
            scatter = [1e3 * f.read("tuned/run_amplitude_m").std(axis=0, ddof=1) for f in files]
            pairs = [np.hypot(scatter[1], scatter[other]) for other in (0, 2)]
            assert widest == pytest.approx(2 * np.max(pairs))
        else:
            assert widest == 0.0


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
        contact_file(random, f"{TINY}contact: {{friction: 0.2}}\n"),
        contact_file(random, f"{TINY}casing: {{clearance_mm: 0.2}}\n"),
    ]
    assert {line.get_linestyle() for line in plot.amplitudes(files).get_lines()} == {"None"}


def test_damping(random):
    """Percentiles and intervals of both files in the panel of each amplification."""
    ratios = 0.005, 0.004
    files = [contact_file(random, f"{TINY}material: {{damping_ratio: {x}}}\n") for x in ratios]
    x = [0.0, *100 * files[0].read("sigma")]
    names = "amplification", "linear_amplification"
    for name, panel in zip(names, plot.damping(files[::-1]), strict=True):
        found = [finished(file, name) for file in files]
        curves = [np.percentile(f, [1, 50, 99], axis=1) for f in found]
        assert_drawn(panel, *((x, [1.0, *curve]) for both in curves for curve in both))
        rows = [
            row
            for both in found
            for at, values in zip(x[1:], both, strict=True)
            for row in interval_rows(at, values, [1, 50, 99])
        ]
        assert_intervals(panel, *rows)


@pytest.mark.parametrize(
    "keys",
    ["casing: {n_bumps: 6}", "mistuning: {half_range_percent: [3, 4]}", "time: {step_s: 3e-5}"],
)
def test_dampings_are_compared_of_the_same_disks_only(random, keys):
    """Other samples are no matter, other physics are."""
    section = keys.partition(":")[0]
    text = "".join(line for line in TINY.splitlines(True) if not line.startswith(section))
    more = "material: {damping_ratio: 0.004}\n"
    files = [contact_file(random), contact_file(random, f"{text}{keys}\n{more}")]
    with pytest.raises(InputError, match=f"only material.damping_ratio may differ, not {section}"):
        plot.damping(files)
    seeded = TINY.replace("samples: 2", "samples: 3, seed: 7")
    plot.damping([files[0], contact_file(random, seeded + more)])


@pytest.mark.parametrize("n", [40, 2000])
def test_cross(random, n):
    """A hundred samples or fewer are dots, without density or percentile 99.

    The density of many normal pairs is the normal one, wider by the kernel.
    """
    linear, contact = random.normal(1.1, 0.1, (1, n)), random.normal(1.5, 0.05, (1, n))
    file = contact_file(random, TINY.replace("[2, 4]", "[2]"), (1, n))
    values = {"linear_amplification": linear, "amplification": contact, "status": [[DONE] * n]}
    file.values |= {f"samples/{name}": np.array(value) for name, value in values.items()}
    axes = plot.cross(file)
    assert f"{n} samples" in axes.get_title()
    above = int(np.count_nonzero(contact > linear))
    low, high = 100 * np.array(stats.binomtest(above, n).proportion_ci(method="wilson"))
    assert f"for {100 * above / n:.0f} % [{low:.0f}, {high:.0f}]" in axes.get_title()
    rank = stats.spearmanr(contact[0], linear[0]).statistic
    assert f"rank correlation {rank:.2f} [" in axes.get_title()
    if n == 40:
        assert_drawn(axes, (linear[0], contact[0]))
        assert not axes.collections
        assert len(lines(axes)) == 2  # with the diagonal
        return
    tops = np.percentile(contact, 99), np.percentile(linear, 99)
    assert_drawn(axes, ([0, 1], [tops[0]] * 2), ([tops[1]] * 2, [0, 1]))
    (filled,) = axes.collections
    densest = filled.get_paths()[0].vertices  # the contour that holds a quarter
    reach = np.sqrt(-2 * np.log(1 - 0.25) * (1 + n ** (-1 / 3)))
    assert np.ptp(densest[:, 0]) / 2 == pytest.approx(0.1 * reach, rel=0.15)
    assert np.ptp(densest[:, 1]) / 2 == pytest.approx(0.05 * reach, rel=0.15)
    assert densest.mean(axis=0) == pytest.approx([1.1, 1.5], abs=0.02)


def test_share_of_a_normal_density_inside_a_contour():
    """1 − exp(−r²/2) of it lies within r standard deviations."""
    x = np.linspace(-6, 6, 601)
    square = x[:, None] ** 2 + x**2
    share = densities.cumulative(np.exp(-square / 2))
    np.testing.assert_allclose(share, 1 - np.exp(-square / 2), atol=2e-3)
