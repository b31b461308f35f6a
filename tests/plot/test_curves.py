"""What the figures draw is what the file holds: the data of their lines, points and pictures.

Words and styles are free; a panel must hold the curves of the data, in the order of the data.
Several files are told from each other by the words that a reader expects, in their order.
"""

import numpy as np
import pytest
from matplotlib.ticker import EngFormatter
from scipy import stats

from hpcrub import plot
from hpcrub.config.schema import load_runs
from hpcrub.contact.status import AVERAGED, DIVERGED, NOT_STEADY
from hpcrub.errors import InputError
from hpcrub.plot.amplifications import CURVE_SHIFT, PERCENTILE_SHIFT, ROW_SHIFT
from hpcrub.plot.families import labels, ordered, reference
from hpcrub.results.layout import DONE, FAILED, PENDING
from hpcrub.results.samples import of_levels
from hpcrub.studies.contact import summary
from hpcrub.studies.contact.layout import AMPLIFICATION
from tests.plot import drawn
from tests.plot.drawn import assert_drawn, assert_intervals, assert_percentiles, done, edges, words
from tests.plot.stored import PATTERN, PHYSICS, File, N, contact_file
from tests.program import TINY

NAMES = "amplification", "linear_amplification"


def of_bumps(random, *numbers):
    return [contact_file(random, f"{TINY}casing: {{n_bumps: {n}}}\n") for n in numbers]


@pytest.mark.parametrize("n", [N, 300])
def test_summary(random, n):
    """With too few samples for percentiles 1 and 99 the band is their range."""
    file = contact_file(random, shape=(2, n))
    left, right = plot.summary(file)
    speeds = file.read("speeds_hz")
    samples = 1e3 * done(file, "samples/amplitude_m", 1)
    low, middle, high = np.percentile(samples, [0, 50, 100] if n == N else [1, 50, 99], axis=0)
    assert_drawn(left, (speeds, middle), (speeds, 1e3 * file.read("tuned/amplitude_m")))
    assert any(("range of 39 samples" if n == N else "1 to 99") in word for word in words(left))
    np.testing.assert_allclose([edges(left, x) for x in speeds], np.transpose([low, high]))
    for name, side in zip(NAMES, (-1, 1), strict=True):
        levels = of_levels(file, name)
        assert_percentiles(right, np.array([2.0, 4.0]) + side * CURVE_SHIFT * 2.0, levels)
    ticks = ["±2 %\nσ = 1.2 %", "±4 %\nσ = 2.3 %"]
    assert [text.get_text() for text in right.get_xticklabels()] == ticks


def test_summary_of_measured_disks_has_a_row_for_each(random):
    text = PHYSICS + "mistuning: {pattern: disks.csv, half_range_percent: [2], samples: 2}\n"
    file = contact_file(random, text, (1, 2), samples__peak_speed_hz=np.array([[34.0, 34.4]]))
    file.values["samples/point_status"][0, 1] = AVERAGED
    file.values["samples/amplitude_error_m"] = np.full((1, 2, 3), 1e-4)
    file.values["tuned/run_peaks_m"] = np.full(3, 0.013)
    left, right = plot.summary(file)
    contact, linear = (file.read(f"samples/{n}", 0) for n in summary.NAMES[:2])
    rows = np.array([1, 2])
    assert_drawn(right, (contact, rows - ROW_SHIFT), (linear, rows + ROW_SHIFT))
    assert [t.get_text() for t in right.get_yticklabels()] == ["disk 1", "disk 2"]
    speeds = file.read("speeds_hz")
    assert_drawn(left, *((speeds, 1e3 * file.read("samples/amplitude_m", (0, i))) for i in (0, 1)))
    steady, averaged = summary.disks(file)
    np.testing.assert_allclose(steady.interval, contact[0])  # no scatter, and one reference
    local = file.read("samples/localisation", 0)
    assert [steady.localisation, averaged.localisation] == [local[0, 0], local[1, 2]]
    part = 1.96 * 1e-4 / file.read("samples/peak_amplitude_m", (0, 1))
    np.testing.assert_allclose(averaged.interval, contact[1] * (1 + part * np.array([-1, 1])), 1e-4)


def test_summary_of_a_pattern(random):
    file = contact_file(random, PHYSICS + PATTERN, (1, 1))
    file.values["samples/point_status"][0, 0, 1] = NOT_STEADY
    panels = plot.summary(file)
    speeds = file.read("speeds_hz")
    for panel, name, scale in zip(panels, ("amplitude_m", "localisation"), (1e3, 1e2), strict=True):
        mistuned, tuned = file.read(f"samples/{name}", (0, 0)), file.read(f"tuned/{name}")
        hollow = speeds[1], scale * mistuned[1]
        assert_drawn(panel, (speeds, scale * mistuned), hollow, (speeds, scale * tuned))
    assert notes(panels[0]).startswith("not usable")  # the verdict was left out


def test_responses_of_a_family_and_their_differences(random):
    """The finest model is the reference; the hatched band is twice the scatter of both disks."""
    texts = [PHYSICS.replace("modes: 12", f"modes: {n}") + PATTERN for n in (36, 84, 60)]
    files = [contact_file(random, text, (1, 1)) for text in texts]
    panels = np.reshape(plot.compare(files), (2, 2))
    speeds = files[0].read("speeds_hz")
    for column, (group, where) in enumerate((("tuned", ()), ("samples", (0, 0)))):
        first, best, middle = (1e3 * f.read(f"{group}/amplitude_m", where) for f in files)
        assert_drawn(panels[0, column], (speeds, first), (speeds, middle), (speeds, best))
        assert_drawn(panels[1, column], (speeds, first - best), (speeds, middle - best))
    scatter = [1e3 * f.read("tuned/run_amplitude_m").std(axis=0, ddof=1) for f in files]
    wide = 2 * np.max([np.hypot(scatter[1], scatter[other]) for other in (0, 2)], axis=0)
    found = [edges(panels[1, 0], x) for x in speeds]
    np.testing.assert_allclose(found, np.transpose([-wide, wide]))
    assert not panels[1, 1].collections  # of the single run of the pattern it is unknown
    assert "not known" in panels[1, 1].get_title()


def test_a_family_of_other_speeds_has_a_panel_for_each(random):
    files = of_bumps(random, 5, 3)
    files[0].values["speeds_hz"] = np.array([27.0, 27.2, 27.4])
    panels = plot.compare(files)
    assert [panel.get_title() for panel in panels] == ["$n_d$ = 3", "$n_d$ = 5"]
    for panel, file in zip(panels, files[::-1], strict=True):
        assert_drawn(panel, (file.read("speeds_hz"), 1e3 * file.read("tuned/amplitude_m")))


def keys_of(axes):
    """What stands in the legend of a figure, by its words."""
    (legend,) = axes.figure.legends
    said = [text.get_text() for text in legend.get_texts()]
    return dict(zip(said, legend.legend_handles, strict=True))


def notes(panel):
    """What stands below a figure: the title of its legend."""
    return panel.figure.legends[0].get_title().get_text()


def test_figures_tell_of_disks_without_a_result(random):
    """They are not in the percentiles, whose figures said nothing of them, nor in the band."""
    file = contact_file(random)
    file.values["samples/status"][1, :2] = FAILED
    file.values["samples/point_status"][1, :2, 1] = DIVERGED
    for draw in (plot.percentiles, plot.amplitudes, plot.contact_over_linear, plot.compare):
        assert "2 of 78 have no result" in notes(np.ravel(draw(file))[0]).replace(" disks", "")
    left, _ = plot.summary(file)
    assert_drawn(left, ([34.2], [0.0]))
    assert "±4 %, lost disks" in words(left)


def test_without_a_finished_disk_there_is_no_percentile_and_nothing_usable(random):
    """Empty axes, "rank correlation nan", and a verdict that called percentiles usable."""
    file = contact_file(random)
    file.values["samples/status"][:] = PENDING
    for draw in (plot.percentiles, plot.amplitudes, plot.contact_over_linear):
        with pytest.raises(InputError, match="no mistuned disk has a result"):
            draw(file)
    left, _ = plot.summary(file)
    assert_drawn(left, (file.read("speeds_hz"), 1e3 * file.read("tuned/amplitude_m")))
    assert notes(left).startswith("not usable: no mistuned disk is finished")


@pytest.mark.parametrize("n_left", [296, 0])
def test_disks_that_flutter_in_air_have_no_linear_amplification(random, n_left):
    """One of them took the percentiles of all others out of the figures, or ended the program."""
    file = contact_file(random, shape=(2, 300))
    linear = file.values["samples/linear_amplification"]
    linear[:, : 300 - n_left] = np.nan
    axes, x = plot.percentiles(file), 100 * file.read("sigma")
    if n_left:
        assert_percentiles(axes, x + CURVE_SHIFT * x.max(), linear[:, -n_left:], (0.0, 1.0))
    rows = plot.percentiles([file, contact_file(random, TINY.replace("[2, 4]", "[4]"), (1, N))] * 4)
    assert rows.get_title() == "Amplifications at ±4 %"
    panels = plot.contact_over_linear(file)
    assert all(f", {n_left} samples" in panel.get_title() for panel in panels)


@pytest.mark.parametrize("n", [1, 6])
def test_samples_that_are_alike_or_alone_have_no_rank_correlation(random, n):
    file = contact_file(random, shape=(1, n))
    file.values["samples/status"][:] = DONE
    for name in NAMES:
        file.values[f"samples/{name}"][:] = 1.0
    title = plot.contact_over_linear(file).get_title()
    assert f"{n} sample{'s' * (n > 1)}\n" in title
    assert "nan" not in title


def test_percentiles_over_sigma(random):
    file = contact_file(random)
    x, axes = 100 * file.read("sigma"), plot.percentiles(file)
    for name, side in zip(NAMES, (-1, 1), strict=True):
        levels = of_levels(file, name)
        assert_percentiles(axes, x + side * CURVE_SHIFT * x.max(), levels, (0.0, 1.0))
    assert "39 samples" in axes.get_title()
    assert "open end: too few samples" in words(axes)


def test_percentiles_of_one_level_are_rows(random):
    """Contact above linear in every row; the reference's values as lines through all of them."""
    text = TINY.replace("[2, 4]", "[4]")
    laws = [f"contact: {{friction: {friction}}}\n" for friction in (0.3, 0.15)]
    files = [contact_file(random, text + law, (1, N)) for law in laws]
    axes = plot.percentiles(files)
    for row, file in enumerate(files[::-1]):
        for name, height in zip(NAMES, (row - ROW_SHIFT, row + ROW_SHIFT), strict=True):
            found = np.percentile(done(file, f"samples/{name}", 0), [1, 50, 99])
            # so that no interval hides another
            heights = height + PERCENTILE_SHIFT * np.array([-1, 0, 1])
            assert_drawn(axes, *zip(found, heights, strict=True))
    reference = np.percentile(done(files[1], "samples/amplification", 0), 50)
    assert_drawn(axes, ([reference] * 2, [0, 1]))
    keys = keys_of(axes)
    assert keys["contact"].get_linestyle() == keys["linear"].get_linestyle() == "-"  # as the bars
    assert keys["95 % confidence interval"].get_marker() == "_"
    names = [label.get_text() for label in axes.get_yticklabels()]
    assert names == ["friction 0.15\n(lines; 39 samples)", "friction 0.30\n(39 samples)"]


def test_convergence_has_a_panel_for_each_file_and_percentile(random):
    """Errors begin with the tenth estimate, from which on they are judged."""
    files = of_bumps(random, 3, 4)
    seen = files[0].read("statistics/samples_seen")
    for draw, name, scale, left_out in (
        (plot.running_means, "mean_of_percentile", 1.0, 0),
        (plot.convergence_errors, "convergence_error", 100.0, 9),
    ):
        panels = np.reshape(draw(files), (2, 3))
        for row, file in zip(panels, files, strict=True):
            values = scale * file.read(AMPLIFICATION.dataset(name))
            values[..., :left_out] = np.nan
            for p, panel in enumerate(row):
                assert_drawn(panel, *((seen, level[p]) for level in values))


def test_no_convergence_error_is_drawn_of_a_few_estimates(random):
    file = contact_file(random)
    file.values["statistics/contact/convergence_error"][..., 10:] = np.nan
    with pytest.raises(InputError, match="needs at least 11 finished samples of a level, 11 steps"):
        plot.convergence_errors(file)


def test_amplitudes_over_the_bumps(random):
    """Sorted by n_d; the spread of the tuned runs and the intervals are the error bars."""
    files = of_bumps(random, 5, 3)
    axes = plot.amplitudes(files)
    files = files[::-1]
    tuned = [1e3 * file.read("tuned/reference_amplitude_m") for file in files]
    assert_drawn(axes, (np.arange(2), tuned))
    for v in range(2):
        x = np.arange(2) + 0.06 * (v + 1)
        peaks = [1e3 * done(file, "samples/peak_amplitude_m", v) for file in files]
        for at, values in zip(x, peaks, strict=True):
            assert_drawn(axes, (at, np.percentile(values, 99)))
            assert_intervals(axes, at, values, [99])
    spread = np.array(axes.collections[0].get_segments())[:, :, 1]
    np.testing.assert_allclose(spread, np.full((2, 2), [12.0, 15.0]))
    assert len(drawn.arrows(axes)) == 4  # percentile 99 of 39 samples has no upper end


def coated_family(random):
    """The same disks before a rigid casing and on two coatings; all amplitudes differ."""
    contact = ("law: rigid", "law: abradable, coating: {yield_mpa: 0.2}",
               "law: abradable, coating: {yield_mpa: 2}")  # fmt: skip
    files = []
    for law in contact:
        files.append(contact_file(random, f"{TINY}contact: {{{law}}}\n"))
        for group in ("tuned", "samples"):
            size = files[-1].read(f"{group}/amplitude_m")
            files[-1].values[f"{group}/largest_amplitude_m"] = random.uniform(1.5, 3.0) * size
    return files


def test_steady_amplitudes_are_not_compared_with_the_largest_at_any_time(random):
    """Two panels with a quantity each; the differences are of steady amplitudes alone."""
    rigid, *coated = files = coated_family(random)
    panels = np.ravel(plot.compare(files))
    speeds = rigid.read("speeds_hz")
    assert [" ".join(p.get_ylabel().split()).replace("the ", "") for p in panels] == [
        "steady amplitude, max $|u_t|$ [mm]", "largest amplitude at any time, max $|u_t|$ [mm]",
        "difference to reference [mm]", "difference to reference [mm]",
    ]  # fmt: skip
    steady = [1e3 * file.read("tuned/amplitude_m") for file in (*coated, rigid)]
    assert_drawn(panels[0], *((speeds, values) for values in steady))
    largest = [1e3 * file.read("tuned/largest_amplitude_m") for file in coated]
    assert_drawn(panels[1], *((speeds, values) for values in largest))
    assert len(drawn.lines(panels[1])) == 2
    assert_drawn(panels[2], *((speeds, values - steady[2]) for values in steady[:2]))
    assert not panels[3].axison
    stiff = contact_file(random, f"{TINY}disk: {{n_blades: 12}}\ncontact: {{friction: 0.3}}\n")
    for pair in ([stiff, coated[0]], [rigid, coated[0]]):  # whichever is the reference
        assert len(plot.compare(pair)) == 4


@pytest.mark.parametrize("n", [40, 2000])
def test_contact_over_linear(random, n):
    """A hundred samples or fewer are dots, without density or percentile 99.

    The density of many normal pairs is the normal one, wider by the kernel.
    """
    linear, contact = random.normal(1.1, 0.1, (1, n)), random.normal(1.5, 0.05, (1, n))
    file = contact_file(random, TINY.replace("[2, 4]", "[2]"), (1, n))
    values = {"linear_amplification": linear, "amplification": contact, "status": [[DONE] * n]}
    file.values |= {f"samples/{name}": np.array(value) for name, value in values.items()}
    axes = plot.contact_over_linear(file)
    above = int(np.count_nonzero(contact > linear))
    low, high = 100 * np.array(stats.binomtest(above, n).proportion_ci(method="wilson"))
    assert f"for {100 * above / n:.0f} % [{low:.0f}, {high:.0f}]" in axes.get_title()
    rank = stats.spearmanr(contact[0], linear[0]).statistic
    assert f"rank correlation {rank:.2f} [" in axes.get_title()
    if n == 40:
        assert_drawn(axes, (linear[0], contact[0]))
        assert not axes.collections
        assert len(drawn.lines(axes)) == 2  # with the diagonal
        return
    tops = np.percentile(contact, 99), np.percentile(linear, 99)
    assert_drawn(axes, ([0, 1], [tops[0]] * 2), ([tops[1]] * 2, [0, 1]))
    (filled,) = axes.collections
    densest = filled.get_paths()[0].vertices  # the contour that holds a quarter
    reach = np.sqrt(-2 * np.log(1 - 0.25) * (1 + n ** (-1 / 3)))
    assert np.ptp(densest[:, 0]) / 2 == pytest.approx(0.1 * reach, rel=0.15)
    assert np.ptp(densest[:, 1]) / 2 == pytest.approx(0.05 * reach, rel=0.15)
    assert densest.mean(axis=0) == pytest.approx([1.1, 1.5], abs=0.02)


def family(tmp_path, *sweep):
    """Stand-ins for the result files of a sweep."""
    path = tmp_path / "input.yaml"
    path.write_text("study: contact\nruns:\n" + "".join(f"  - {{{keys}}}\n" for keys in sweep))
    return [File(config.to_yaml(), path=config.output) for config in load_runs(path)]


@pytest.mark.parametrize(
    ("sweep", "words"),
    [
        (("time.step_s: 1e-5", "time.step_s: 1e-6", "time.step_s: 2e-5", "time.step_s: 2e-6"),
         ("step 1 µs", "step 2 µs", "step 10 µs", "step 20 µs")),
        (("reduction.n_modes: 120", "reduction.n_modes: 36"), ("modes 36", "modes 120")),
        (("casing.n_bumps: 10", "casing.n_bumps: 3, speeds.from_hz: 9"),
         ("$n_d$ = 3", "$n_d$ = 10")),
        (("casing.clearance_mm: 0.25", "casing.clearance_mm: 0.2, casing.bump_height_mm: 1.2"),
         ("clearance 0.20 mm, bump height 1.20 mm", "clearance 0.25 mm, bump height 1.25 mm")),
        (("material.density_kg_m3: 8e3", "material.density_kg_m3: 7.8e3"),
         ("density 7800.0 kg/m³", "density 8000.0 kg/m³")),
        (("time.scheme: central_difference", "disk.blade.lean_deg: -50", "contact.friction: 0.15",
          "contact.friction: 0.2", "disk.n_blades: 9", "steady_state.min_correlation: 0.9"),
         ("blades 9", "lean -50.00°", "scheme central difference", "min correlation 0.90",
          "reference", "friction 0.20")),
        (("casing.n_bumps: 4",), ("n_bumps=4",)),
        (("casing.ring: {thickness_mm: 20}, output: ring.h5", "output: rigid.h5"),
         ("thickness 20.0 mm", "rigid")),
        (("contact.law: rigid", "contact: {law: elastic, casing_stiffness_n_per_m: 2.4e8}",
          "contact.law: abradable"),
         ("law abradable", "law elastic, casing stiffness 240 MN/m", "law rigid")),
        (("contact.law: rigid", "contact: {law: abradable, coating: {yield_mpa: 0.2}}",
          "contact: {law: abradable, coating: {yield_mpa: 2}}"),
         ("law abradable, yield 0.2 MPa", "law abradable, yield 2.0 MPa", "law rigid")),
    ],
)  # fmt: skip
def test_a_family_is_told_apart_by_quantities_in_the_order_of_their_numbers(tmp_path, sweep, words):
    assert tuple(labels(ordered(family(tmp_path, *sweep)))) == words


@pytest.mark.parametrize(
    ("sweep", "number"),
    [
        (("time.step_s: 1e-5", "time.step_s: 2e-6"), 1),
        (("reduction.n_modes: 120", "reduction.n_modes: 60"), 0),
        (("casing.clearance_mm: 0.2", "casing.clearance_mm: 0.25"), 1),
        (("time.scheme: central_difference", "disk.ring_thickness_mm: 12", "seed: 1"), None),
    ],
)
def test_the_reference_is_the_finest_or_the_default(tmp_path, sweep, number):
    sweep = sweep if number is not None else (*sweep[:2], "mistuning.seed: 2020")
    files = family(tmp_path, *sweep)
    assert reference(files) is files[2 if number is None else number]


def test_a_step_that_is_only_a_bound_does_not_tell_files_apart(tmp_path):
    """Bumps allow 44 µs: both files are computed with that, and one with less."""
    sweep = "time.step_s: 1e-4", "time.step_s: 5e-5", "time.step_s: 2e-5"
    files = family(tmp_path, *sweep)
    used = "step " + EngFormatter("s")(files[0].config.step)
    assert labels(files) == [used, used, "step 20 µs"]
