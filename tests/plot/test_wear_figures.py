"""Figures of a coating draw what the file holds: depths around the casing, of disks, in time."""

import numpy as np
import pytest

from hpcrub import plot
from hpcrub.errors import InputError
from hpcrub.plot.wear import GROOVE, INNER
from tests.plot.drawn import assert_drawn
from tests.plot.stored import File, contact_file
from tests.program import TINY

COATED = f"{TINY}contact: {{law: abradable}}\n"


@pytest.fixture
def random():
    return np.random.default_rng(3)


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


def test_amplitudes_on_a_coating_are_the_largest_of_any_time(file):
    left, _ = plot.summary(file)
    assert_drawn(left, (file.read("speeds_hz"), 1e3 * file.read("tuned/largest_amplitude_m")))


def test_motion_and_depth_over_time(random):
    motion = random.normal(size=(1, 600, 12)) * 1e-3
    depth = np.sort(random.uniform(0.0, 2e-3, (1, 40)), axis=1)
    file = File(
        "study: time_response\ncontact: {law: abradable}", time_s=np.arange(600) / 600.0,
        deviation=np.zeros((1, 12)), tangential_m=motion, block_s=np.arange(1, 41) / 40.0,
        worn_depth_m=depth,
    )  # fmt: skip
    top, bottom = plot.cutting(file)
    assert_drawn(bottom, (np.arange(1, 41) / 40.0, 1e3 * depth[0]))
    band = top.collections[0].get_paths()[0].vertices
    assert np.isclose(band[:, 1].max(), 1e3 * motion.max())
    size = 1e3 * np.abs(motion).max()
    assert f"largest: {size:.1f} mm" in top.get_legend_handles_labels()[1][0]


def test_a_bare_casing_has_no_such_figure(random):
    with pytest.raises(InputError, match="wear is for a coating that wears"):
        plot.wear(contact_file(random))
