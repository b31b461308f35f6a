"""Branches of coexisting motions, on made-up windows.

Truth: how the windows were made. Windows of one motion are a first-order autoregression, because
those of the real motions resemble their neighbours. The three promises: no two labels where only
chance tells motions apart, no common label for clearly different motions of one speed, and the
same label along a branch.
"""

import numpy as np
import pytest

from hpcrub.contact.status import DIVERGED, NOT_STEADY, STEADY
from hpcrub.statistics import coexistence

N_WINDOWS = 60
SCATTER = np.array([0.04, 0.02])  # of the windows: amplitude (mean near 1), localisation


def noise(rng, shape, memory):
    """Standard normal windows (..., N_WINDOWS) with a correlation `memory` of neighbours."""
    fresh = rng.standard_normal((*shape, N_WINDOWS))
    found = np.empty_like(fresh)
    found[..., 0] = fresh[..., 0]
    for i in range(1, N_WINDOWS):
        found[..., i] = memory * found[..., i - 1] + np.sqrt(1 - memory**2) * fresh[..., i]
    return found


def labels(amplitude, local, memory=0.3, scatter=SCATTER, status=None, seed=0):
    """Labels of starts with these means (starts, speeds)."""
    rng = np.random.default_rng(seed)
    means = np.stack(np.broadcast_arrays(amplitude, local)).astype(float)
    scatter = np.reshape(scatter, (2, 1, 1, 1))
    windows = means[..., None] + scatter * noise(rng, means.shape, memory)
    status = np.full(means.shape[1:], STEADY) if status is None else status
    return coexistence.label(*windows, status)


@pytest.mark.parametrize(("memory", "seed"), [(0.0, 0), (0.3, 1), (0.7, 2)])
def test_chance_makes_no_branches(memory, seed):
    amplitude = np.tile(1.0 + 0.2 * np.sin(np.linspace(0, 6, 401)), (5, 1))
    found = labels(amplitude, 0.15, memory, [0.08, 0.04], seed=seed)
    assert np.count_nonzero(coexistence.coexisting(found) > 1) <= 2
    assert np.mean(found == 0) > 0.99


def test_every_split_is_by_a_pair_that_differs_and_no_pair_that_differs_is_together():
    rng = np.random.default_rng(1)
    level = 1e-5
    for _ in range(30):
        means = rng.normal([1.0, 0.2], [0.03, 0.03], (6, 2)).T
        motions = means[..., None] + SCATTER[:, None, None] * noise(rng, (2, 6), 0.3)
        part = coexistence.split(motions, level)
        pair = [
            [len(set(coexistence.split(motions[:, [i, j]], level))) == 2 for j in range(6)]
            for i in range(6)
        ]
        together = part[:, None] == part
        assert not np.any(np.array(pair) & together)
        if part.max():
            assert np.any(pair)


def test_different_motions_of_one_speed_never_meet_though_a_chain_connects_them():
    # at the last speed the branches are far apart; they begin together, and on the way every
    # difference from speed to speed is small: single linkage would call all of it one branch
    apart = np.linspace(0, 0.25, 60)
    amplitude = np.array([1 - apart, 1 - apart, 1 + apart, 1 + apart])
    found = labels(amplitude, 0.15)
    assert coexistence.coexisting(found)[0] == 1
    np.testing.assert_array_equal(coexistence.coexisting(found)[-30:], 2)
    np.testing.assert_array_equal(found[0, -30:], found[1, -30:])
    np.testing.assert_array_equal(found[2, -30:], found[3, -30:])
    for start in (0, 2):
        assert len(set(found[start, -30:])) == 1  # and each keeps its label


def test_branches_that_cross_in_amplitude_keep_their_labels():
    slope = np.linspace(-0.2, 0.2, 80)
    amplitude = np.array([1 + slope, 1 + slope, 1 - slope])
    local = np.array([[0.30], [0.30], [0.15]])
    found = labels(amplitude, local)
    np.testing.assert_array_equal(found, np.tile([[0], [0], [1]], 80))


def test_motions_that_differ_by_many_standard_errors_are_told_apart():
    """A mean of 60 windows that do not resemble each other has the error scatter/√60."""
    rng = np.random.default_rng(5)
    scatter, n_apart = 0.3, 0
    means = np.array([[1.0, 1.0 + 14.0 * scatter / np.sqrt(N_WINDOWS)], [0.15, 0.15]])
    for _ in range(50):
        spread = np.reshape([scatter, 0.02], (2, 1, 1)) * noise(rng, (2, 2), 0.0)
        n_apart += coexistence.split(means[..., None] + spread, 1e-3).max()
    assert n_apart >= 48


def test_a_branch_that_ends_leaves_the_label_of_the_other():
    amplitude = np.ones((3, 50))
    amplitude[2, :20] = 1.3  # the third start falls to the branch of the others
    found = labels(amplitude, 0.15)
    np.testing.assert_array_equal(found[:2], 0)
    np.testing.assert_array_equal(found[2], [1] * 20 + [0] * 30)


def test_a_jump_of_all_motions_is_a_new_branch():
    amplitude = np.ones((3, 50))
    amplitude[:, 30:] = 1.5
    found = labels(amplitude, 0.15)
    np.testing.assert_array_equal(found, np.tile([0] * 30 + [1] * 20, (3, 1)))


def test_a_branch_that_is_missed_for_a_while_goes_on():
    amplitude = np.ones((3, 60))
    back = 20 + coexistence.REACH // 2
    amplitude[2, :20] = amplitude[2, back:] = 1.3
    found = labels(amplitude, 0.15)
    assert set(found[2, :20]) == set(found[2, back:]) == {1}
    amplitude[2] = 1.0
    amplitude[2, :20] = amplitude[2, 22 + coexistence.REACH :] = 1.3  # too long
    assert set(labels(amplitude, 0.15)[2]) == {0, 1, 2}


def test_a_motion_that_jumps_is_no_branch():
    amplitude = np.array([1.0, 1.0, 1.3, 1.3])[:, None] * np.ones(20)
    windows = amplitude[..., None] + 0.02 * noise(np.random.default_rng(0), (4, 20), 0.3)
    windows[0, :, 30:] += 0.3  # half way from the lower to the upper one
    local = 0.2 + 0.01 * noise(np.random.default_rng(1), (4, 20), 0.3)
    found = coexistence.label(windows, local, np.full((4, 20), STEADY))
    np.testing.assert_array_equal(coexistence.coexisting(found), 2)
    assert found.max() == 1


def test_what_does_not_matter_is_no_difference():
    amplitude = np.array([[1.0], [1.02]]) * np.ones(10)  # not by chance, but within 3 %
    found = labels(amplitude, 0.15, scatter=[1e-6, 1e-6])
    np.testing.assert_array_equal(found, 0)
    found = labels(amplitude**2, 0.15, scatter=[1e-6, 1e-6])
    np.testing.assert_array_equal(found, [[0] * 10, [1] * 10])


def test_only_steady_points_have_labels():
    status = np.full((3, 10), STEADY)
    status[2, 0], status[:, 4], status[1, 7] = NOT_STEADY, NOT_STEADY, DIVERGED
    found = labels(np.ones((3, 10)), 0.15, status=status)
    np.testing.assert_array_equal(found >= 0, status == STEADY)
    assert found.max() == 0
    np.testing.assert_array_equal(coexistence.coexisting(found), [1, 1, 1, 1, 0, 1, 1, 1, 1, 1])
    nothing = labels(np.ones((3, 10)), 0.15, status=np.full((3, 10), NOT_STEADY))
    assert (nothing == -1).all()


def test_disks_at_rest_are_one_branch():
    """The casing out of reach: zeros everywhere are alike, and differ from what moves."""
    still, moving = np.zeros((3, 2, 100)), np.full((1, 2, 100), 1e-6)
    amplitude, local = np.concatenate([still, moving]), np.zeros((4, 2, 100))
    found = coexistence.label(amplitude, local, np.full((4, 2), STEADY))
    np.testing.assert_array_equal(found, [[0, 0], [0, 0], [0, 0], [1, 1]])
