"""Verdicts on made-up windows: periodic, averaged, growing and decaying motions."""

import numpy as np
import pytest

from hpcrub.contact.status import AVERAGED, NOT_STEADY, STEADY
from hpcrub.response.ensemble import ALIKE, AT_LAST, FEWEST, LastWindow, Recent, Windows
from hpcrub.response.growth import MEMORY
from hpcrub.response.steady import SteadyCriteria

CRITERIA = SteadyCriteria(rule="ensemble", first_check=0.0)
T = np.linspace(0.0, 1.0, 200, endpoint=False)
WAVE = np.sin(2.0 * np.pi * 3.0 * T)
WINDOW = 0.1  # [s]
DECAY = MEMORY / WINDOW  # windows are just independent


def unchanged(window):
    """Waves that are the same in both windows."""
    return np.zeros((1, 2, 2))


def watched(amplitudes, decay=DECAY, alike=False, begin=0.5, kind=Windows, criteria=CRITERIA):
    """Verdict on windows of given amplitudes, and the number of those that were looked at.

    Their motions are all alike, or in quadrature one by one.
    """
    watch, n = kind(criteria, decay, WINDOW), len(amplitudes)
    for k in range(1, n):
        sizes = np.array([[a / 2, a] for a in amplitudes[k - 1 : k + 1]])

        def signals(tip, k=k):
            assert tip == 1
            return WAVE, WAVE if alike else np.cos(2.0 * np.pi * 3.0 * T) + 0.1 * k

        recent = Recent(sizes, signals, unchanged)
        found = watch.look(recent, begin + k * WINDOW, over=k == n - 1)
        if found:
            return found, k + 1
    raise AssertionError("no verdict when the time is over")


def test_a_periodic_motion_is_steady_after_three_windows():
    found, n = watched(np.full(20, 2e-3), alike=True)
    assert n == ALIKE
    assert found.status == STEADY
    assert found.amplitude == pytest.approx(2e-3)
    # not better known than what a steady motion may still change
    assert found.error == pytest.approx(CRITERIA.max_amplitude_change * 2e-3)


def test_a_blade_that_was_larger_before_keeps_a_motion_from_being_steady():
    """In the first window the start throws one blade far out; the largest one later is another."""
    sizes = [np.array([8.0, 4.0]), *[np.array([3.0, 4.0])] * 5]
    watch = Windows(CRITERIA, DECAY, WINDOW)
    for k, pair in enumerate(zip(sizes, sizes[1:], strict=False), 1):
        recent = Recent(np.array(pair), lambda tip: (WAVE, WAVE), unchanged)
        found = watch.look(recent, k * WINDOW, over=k == 5)
        if found:
            break
    assert (found.status, found.amplitude) == (STEADY, pytest.approx(4.0))


def test_equal_amplitudes_of_motions_that_differ_are_not_steady():
    found, n = watched(np.full(20, 2e-3))
    assert found.status == AVERAGED
    assert n == FEWEST


def test_the_first_window_which_holds_the_start_counts_for_no_mean():
    """At slow speeds five windows are most of the time that a motion has."""
    found, n = watched(np.append(3.0, np.tile([0.98, 1.02], 10)), begin=WINDOW)
    assert (found.status, n) == (AVERAGED, 1 + FEWEST)
    assert found.amplitude == pytest.approx(1.0, abs=0.01)
    # where no more windows fit into the time, one less is enough
    found, n = watched(np.array([3.0, 0.98, 1.02, 0.98, 1.02]), begin=WINDOW)
    assert (found.status, n) == (AVERAGED, 1 + AT_LAST)
    assert found.amplitude == pytest.approx(1.0, abs=0.01)
    found, _ = watched(np.array([3.0, 0.98, 1.02, 1.0]), begin=WINDOW)
    assert found.status == NOT_STEADY


def forgetful(random, n, decay):
    """n windows of an AR(1) process of mean 1 that forgets as a transient decays."""
    rho, noise = np.exp(-decay * WINDOW), random.standard_normal(n)
    for k in range(1, n):
        noise[k] = rho * noise[k - 1] + np.sqrt(1.0 - rho**2) * noise[k]
    return 1.0 + 0.08 * noise


@pytest.mark.parametrize("decay", [DECAY / 8.0, DECAY, 3.0 * DECAY])
@pytest.mark.parametrize(
    ("max_error", "least"),
    [(CRITERIA.max_error, 0.9), pytest.param(0.03, 0.8, marks=pytest.mark.long)],
)
def test_two_standard_errors_hold_the_mean_of_a_process_that_is_known(decay, max_error, least):
    """95 %, correlated windows too, less what it costs to stop when the error happens to be small.

    Five windows are enough for the usual error, ten times as many are needed for the small one.
    """
    random, criteria = np.random.default_rng(3), CRITERIA._replace(max_error=max_error)
    series = (forgetful(random, 200, decay) for _ in range(300))
    found = [watched(sizes, decay, criteria=criteria)[0] for sizes in series]
    assert {one.status for one in found} == {AVERAGED}
    assert max(one.error / one.amplitude for one in found) <= max_error
    off = np.array([abs(one.amplitude - 1.0) / one.error for one in found])
    assert 0.5 < np.mean(off < 1.0) < 0.85
    assert least < np.mean(off < 2.0) < 0.99


@pytest.mark.parametrize("change", [-0.6, -0.1, 0.3])
@pytest.mark.parametrize("alike", [True, False])
@pytest.mark.parametrize("n", [6, 30, 100])
def test_a_lightly_damped_transient_is_right_or_marked(change, alike, n):
    """It is 1 in the end, and ``change`` off when the windows begin; each takes 2 % of it."""
    decay = -np.log(0.98) / WINDOW
    amplitudes = 1.0 + change * np.exp(-decay * WINDOW * np.arange(n))
    found, _ = watched(amplitudes, decay, alike)
    if found.status != NOT_STEADY:
        assert found.amplitude == pytest.approx(1.0, abs=0.03)


def test_a_transient_that_never_ends_is_not_steady():
    found, n = watched(np.geomspace(1.0, 4.0, 40), decay=0.05, alike=True)
    assert (found.status, n) == (NOT_STEADY, 40)
    assert found.amplitude > 2.0  # of the later half


def test_the_papers_rule_takes_the_largest_of_the_last_window():
    amplitudes = np.array([1.0, 1.2, 1.5, 1.505, 3.0])
    found, n = watched(amplitudes, alike=True, kind=LastWindow, criteria=SteadyCriteria())
    assert (found.status, found.amplitude, n) == (STEADY, 1.505, 4)
    assert np.isnan([found.error, found.scatter]).all()
    found, n = watched(amplitudes, kind=LastWindow, criteria=SteadyCriteria())
    assert (found.status, found.amplitude, n) == (NOT_STEADY, 3.0, 5)


def test_a_check_that_fails_takes_back_those_passed_before():
    """Passed, failed, passed, passed: two in succession only at the fourth check."""
    amplitudes = np.array([1.0, 1.001, 1.2, 1.201, 1.202, 1.203])
    twice = SteadyCriteria(confirmations=2)
    found, n = watched(amplitudes, alike=True, kind=LastWindow, criteria=twice)
    assert (found.status, found.amplitude, n) == (STEADY, 1.202, 5)
