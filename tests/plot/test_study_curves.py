"""Figures of coatings and of studies other than contact: they draw what the file holds."""

import numpy as np
import pytest

from hpcrub import plot
from hpcrub.config.schema import Config
from hpcrub.contact.status import NOT_STEADY, STEADY
from hpcrub.effects import EFFECTS, casing_motion
from hpcrub.plot import histories
from hpcrub.plot.disks import EXAGGERATED, families
from hpcrub.plot.effects import GROOVE, INNER
from hpcrub.results.layout import DONE
from tests.plot.drawn import assert_drawn, assert_percentiles, edges, lines, words
from tests.plot.stored import PATTERN, PHYSICS, File, N, contact_file, modal_file
from tests.program import TINY


def test_linear_percentiles(random):
    amplification = random.gamma(20.0, 0.06, (2, 2, N))
    file = File("study: linear", n_diameters=[2, 5], sigma=[0.01, 0.02])
    file.values["amplification"] = amplification
    for d, panel in enumerate(plot.linear(file)):
        assert_percentiles(panel, (1.0, 2.0), amplification[:, d], (0.0, 1.0))


def test_energy(random):
    """Each sample at its two amplifications, by level and file, and their square."""
    file = File(
        "study: energy\nsources: [a.h5]\nenergy: {samples: 16}",
        sigma=np.repeat([0.01, 0.02], 8), amplification=random.uniform(1, 2, 16),
        energy_j=random.uniform(1, 9, (16, 3, 12)), tuned__energy_j=random.uniform(1, 4, (3, 12)),
    )  # fmt: skip
    by_energy = file.read("energy_j").max(axis=(1, 2)) / file.read("tuned/energy_j").max()
    axes = plot.energy([file, file])
    halves = slice(8), slice(8, 16)
    levels = [(file.read("amplification")[part], by_energy[part]) for part in halves]
    assert_drawn(axes, *levels, *levels)
    x, square = lines(axes)[-1].T
    np.testing.assert_allclose(square, x**2)
    assert [word for word in words(axes) if "σ" in word] == ["σ = 1.0 %", "σ = 2.0 %"]


@pytest.mark.parametrize("law", ["rigid", "abradable"])
def test_time_response(random, law):
    """The tip with the largest motion at the end, the envelope of all, and what is worn."""
    time = np.linspace(0.0, 0.5, 60)
    shape = 2, 60, 12
    file = File(
        f"study: time_response\nspeeds: {{from_hz: 30, to_hz: 30}}\ncontact: {{law: {law}}}",
        time_s=time, deviation=np.zeros((2, 12)), tangential_m=random.uniform(-1e-2, 1e-2, shape),
        radial_m=random.uniform(-1e-3, 1e-3, shape), gap_m=random.uniform(0, 1e-3, shape),
        point_status=np.full(2, STEADY), point_reason=np.zeros(2, int),
        force_n=random.uniform(0, 1e4, shape),
        check_s=np.array([0.3, 0.5]), window_s=0.1, correlation=np.array([[1, 1], [0.5, 0.99]]),
        amplitude_change=np.zeros((2, 2)), judged_s=np.array([0.3, 0.5]),
        block_s=np.linspace(0.1, 0.5, 5), worn_depth_m=random.uniform(0, 1e-3, (2, 5)),
        amplitude_m=np.full(2, 1e-2), second_order_amplitude_m=np.full(2, np.nan),
    )  # fmt: skip
    file.values["tangential_m"][1, -1, 4] = -0.02
    panels = np.reshape(plot.time_response(file), (-1, 2))
    assert len(panels) == (4 if law == "rigid" else 5)
    if law == "abradable":
        for panel in panels[4]:
            assert_drawn(panel, (file.read("block_s"), 1e3 * file.read("worn_depth_m", 1)))
    close = time > 0.5 - 3 / 30
    rows = ("tangential_m", 1e3), ("radial_m", 1e3), ("gap_m", 1e3), ("force_n", 1e-3)
    for (name, scale), (left, right) in zip(rows, panels[:4], strict=True):
        values = scale * file.read(name, 1)
        assert_drawn(left, (time, values[:, 4]))
        assert_drawn(right, (time[close], values[close, 4]))
        found = [edges(right, t) for t in time[close]]
        ends = [values[close].min(axis=1), values[close].max(axis=1)]
        np.testing.assert_allclose(found, np.transpose(ends))
    spans = [patch.get_extents().transformed(panels[0, 0].transData.inverted())
             for patch in panels[0, 0].patches]  # fmt: skip
    found = np.sort([[span.x0, span.x1] for span in spans], axis=0)
    np.testing.assert_allclose(found, [[0.3, 0.4], [0.4, 0.5]])  # of the second check: it passed
    last = 1e3 * file.read("tangential_m", 1)[close, 4]  # with its offset, and without
    words_of = f"{np.abs(last).max():.3g} mm,\nhalf of peak to peak {np.ptp(last) / 2:.3g} mm"
    assert words_of in panels[0, 1].get_title()


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
        mean_amplitude_m=spectrum.max(axis=1)[None], amplitude_m=spectrum.max(axis=1)[None],
        second_order_amplitude_m=np.full(1, np.nan),
    )  # fmt: skip
    file.values["point_status"][0, 4:40] = NOT_STEADY
    axes = plot.interaction_map(file)
    below = axes.figure.legends[0].get_title().get_text()  # the verdict, and why
    assert "not usable: 36 of 121 points have not settled" in below
    assert_drawn(axes, ([21.75, 39.75], [1, 1]))  # half a step beyond the first and the last
    np.testing.assert_allclose(axes.collections[0].get_array(), 1e3 * spectrum.T)
    assert_drawn(axes, (speeds, speeds), (speeds, 4 * speeds), (speeds, 0 * speeds + 90))
    assert not any((line[:, 1] == 540).all() for line in lines(axes) if len(line))
    strongest, other = histories.interactions(speeds, frequencies, spectrum)
    assert (strongest.order, strongest.speed_hz, strongest.frequency_hz) == (4, 35.0, 140.0)
    assert (other.order, other.speed_hz) == (2, 68.0)
    # exp(-(x/w)²) is one half at w sqrt(ln 2): 0.83 and 1.67 Hz from the middle
    assert (strongest.first_hz, strongest.last_hz) == (34.5, 35.5)
    assert (other.first_hz, other.last_hz) == (66.5, 69.5)
    assert_drawn(axes, ([0, 1], [140, 140]))
    boxes = [patch.get_bbox() for patch in axes.patches]
    for box, at in zip(boxes, ((35, 140), (68, 136)), strict=True):
        assert box.contains(*at)
    assert axes.get_title().endswith("at 140 Hz, 47 Hz above the family")  # whose top is 93
    assert all(note.get_text().isdigit() for note in axes.texts if not note.arrow_patch)


def test_branches(random):
    """Means of windows, their scatter and localisation; where two motions differ, it is grey."""
    mean = np.array([[10.0, 10.0, 10.0], [10.0, 10.0, 5.0], [10.0] * 3, [10.0] * 3])
    local = random.uniform(0.1, 0.1001, (4, 3, 1)) + [-1e-5, 1e-5] * 30
    file = File(
        f"study: branches\nbranches: {{perturbed: 1}}\n{TINY}",
        speeds_hz=np.array([34.0, 34.2, 34.4]), amplitude_m=1e-3 * mean,
        window_amplitude_m=1e-3 * mean[..., None] + [-1e-5, 1e-5] * 30,
        window_localisation=local, point_status=np.full((4, 3), STEADY),
        point_reason=np.zeros((4, 3), int), second_order_amplitude_m=np.full(4, np.nan),
    )  # fmt: skip
    file.values["point_status"][2, 0] = NOT_STEADY
    axes = plot.branches(file)
    speeds = file.read("speeds_hz")
    drawn = [one for one in axes.collections if len(one.get_offsets()) > 1]
    for start, points in enumerate(drawn):
        steady = file.read("point_status", start) == STEADY
        expected = np.column_stack([speeds, mean[start]])[steady]
        np.testing.assert_allclose(points.get_offsets(), expected)
        np.testing.assert_allclose(points.get_array(), 100 * local[start, steady].mean(axis=-1))
    assert_drawn(axes, ([34.0], [10.0]))  # not steady
    bars = np.array(axes.collections[0].get_segments())[:, :, 1]
    scatter = 0.01 * np.sqrt(60 / 59)
    np.testing.assert_allclose(bars, mean[:1].T + [[-scatter, scatter]])
    (grey,) = [patch.get_extents().transformed(axes.transData.inverted()) for patch in axes.patches]
    assert (grey.x0, grey.x1) == pytest.approx((34.3, 34.5))
    assert "motions differ by more than 3 %" in axes.figure.legends[0].get_title().get_text()


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
    panels = plot.safe_diagram(file)
    for panel in panels:
        assert_drawn(panel, *((np.arange(7), family) for family in expected), modes, modes)
    met = panels[1].get_lines()[-1]  # the family's line at its crossing with order 4
    assert np.interp(4.0, *met.get_data()) == pytest.approx(93.0)
    assert "order 4 at 23.25 Hz" in met.get_label()


(CASING,) = (effect for effect in EFFECTS if effect.name == "waves")


def ring_file(random, text=TINY, shape=(2, N)):
    """A contact study in a casing that vibrates."""
    file = contact_file(random, f"{text}casing: {{ring: {{thickness_mm: 20}}}}\n", shape)
    names = "casing_motion_m", "casing_energy_share", "casing_growth_per_s", "casing_waves"
    for group, of in (("tuned", (3,)), ("samples", (*shape, 3))):
        file.values |= {f"{group}/{name}": random.uniform(1.0, 2.0, of) for name in names}
    file.values[casing_motion.PERMANENT.name] = np.zeros((2, 3))
    return file


def test_the_disk_of_a_pattern_is_in_every_panel_of_a_casing_that_vibrates(random):
    """The upper panels left it out, and it was the median of the samples, with percentiles."""
    file = ring_file(random, PHYSICS + PATTERN, (1, 1))
    panels = np.ravel(plot.casing_motion(file))
    names = "amplitude_m", "casing_motion_m", "casing_energy_share", "casing_growth_per_s"
    for panel, name, scale in zip(panels, names, (1e3, 1e3, 1e2, 1.0), strict=True):
        both = [file.read(f"tuned/{name}"), file.read(f"samples/{name}", (0, 0))]
        for values in both:
            assert_drawn(panel, (file.read("speeds_hz"), scale * values))
    said = " ".join(words(panels[0]))
    assert "mistuned disk" in said
    assert "samples" not in said
    assert "share" not in said
    assert "percentiles" not in " ".join(CASING.lines(file, 0))


@pytest.mark.parametrize(("n_speeds", "width"), [(3, 0.2), (1, 1.0)])
def test_disks_that_run_away_are_bars_as_wide_as_the_speeds_are_apart(random, n_speeds, width):
    """At a single speed, too, which was an IndexError."""
    file = ring_file(random)
    file.values["samples/casing_growth_per_s"][-1, ::2] = np.nan
    for name, values in file.values.items():
        file.values[name] = values[..., :n_speeds] if np.shape(values)[-1:] == (3,) else values
    last = float(file.read("speeds_hz")[-1])
    file.config = file.config.replace({"speeds.to_hz": last})
    *_, bars = plot.casing_motion(file)[3].figure.axes
    at = [(bar.get_x() + bar.get_width() / 2, bar.get_width()) for bar in bars.patches]
    np.testing.assert_allclose(at, [(speed, 0.8 * width) for speed in file.read("speeds_hz")])
    share = np.mean(np.flatnonzero(file.status[-1] == DONE) % 2)
    np.testing.assert_allclose([bar.get_height() for bar in bars.patches], 100 * share)


COATED = f"{TINY}contact: {{law: abradable}}\n"


@pytest.fixture
def file(random):
    """Two levels of 40 disks at three speeds, the tuned one with a groove of four lobes."""
    found = contact_file(random, COATED)
    angle = np.arange(360.0)
    worn = np.array([[1e-3], [3e-3], [2e-3]]) * (1.0 + 0.5 * np.cos(np.radians(4 * angle)))
    shape = found.read("samples/amplitude_m").shape
    depth = random.uniform(1e-3, 4e-3, shape)
    found.values |= {
        "angle_deg": angle, "tuned/worn_m": np.stack([0.5 * worn, worn], axis=1),
        "tuned/worn_depth_m": worn.max(axis=1),
        "tuned/lobes": [4.0, 4.0, 4.0], "tuned/run_deepest_m": [4.4e-3, 4.5e-3, 4.6e-3],
        "samples/worn_depth_m": depth, "samples/deepest_m": depth.max(axis=2),
        "samples/largest_amplitude_m": 2.0 * found.read("samples/amplitude_m"),
        "tuned/largest_amplitude_m": 2.0 * found.read("tuned/amplitude_m"),
    }  # fmt: skip
    return found


def test_the_groove_is_drawn_around_the_casing_and_over_the_speeds(file):
    around, over, depths, _ = plot.wear(file)[:4]
    worn = file.read("tuned/worn_m")[:, 1]  # the strip that is worn deepest
    corners = around.patches[0].get_xy()[:361]
    radius = INNER + GROOVE * np.append(worn[1], worn[1, 0]) / worn[1].max()  # at the deepest speed
    assert np.allclose(np.hypot(*corners.T), radius)
    assert "34.2 Hz" in around.get_title()
    assert np.allclose(over.collections[0].get_array(), 1e3 * worn)
    assert_drawn(depths, (file.read("speeds_hz"), 1e3 * worn.max(axis=1)))


def test_every_level_has_the_share_of_disks_that_cut_at_most_so_deep(file):
    disks = plot.wear(file)[3]
    for level in range(2):
        done = file.status[level] == 1
        depth = 1e3 * np.sort(file.read("samples/deepest_m", level)[done])
        share = 100.0 * np.arange(1, len(depth) + 1) / len(depth)
        assert_drawn(disks, (depth, share))
    assert_drawn(disks, ([4.5, 4.5], [0.0, 1.0]))  # the median of the tuned runs


def test_of_depths_that_are_equal_that_of_the_peak_is_drawn(file):
    """So where nothing is worn, and where all is: the colours then begin at no depth."""
    thickness = file.config.contact.coating.thickness_mm
    file.values["tuned/largest_amplitude_m"][:] = [0.01, 0.02, 0.03]
    for depth in (0.0, 1e-3):
        file.values["tuned/worn_m"][:] = depth
        around, over, *_ = plot.wear(file)
        assert ("nothing is worn" in around.get_title()) == (depth == 0.0)
        assert "34.4 Hz" in around.get_title()
        assert over.collections[0].get_clim() == (0.0, 1e3 * depth or thickness)


def test_a_coating_that_is_worn_through_says_what_became_of_the_rest(file):
    """Of 5 mm 15 MPa/1 GPa are elastic, and E/(E + H) of the rest can be cut: 4.10 mm."""
    file.values["samples/worn_depth_m"][..., 1] = through = 4.925e-3 / 1.2
    file.values["samples/deepest_m"][:] = through
    _, _, depths, disks = plot.wear(file)
    assert_drawn(depths, ([0, 1], [1e3 * through] * 2))
    assert "worn through: 4.1 mm, the rest of 5 mm is compacted" in words(depths)
    assert disks.get_title() == "39 disks per level, worn through by 78 of all 78"
    assert disks.get_xlim()[0] == 0.0


def test_amplitudes_on_a_coating_are_the_largest_of_any_time(file):
    left, _ = plot.summary(file)
    assert_drawn(left, (file.read("speeds_hz"), 1e3 * file.read("tuned/largest_amplitude_m")))
