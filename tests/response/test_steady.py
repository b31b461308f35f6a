"""Steady state and localisation on made-up signals (paper, section 3.1, equations 8–10); motions in
permanent contact, of a point on two inclined springs, whose stability is known in closed form.

Stiffness (k_nn, k_nt; k_nt, k_tt) and unit mass. Held at the casing, u_n = 0, the point moves as
u_t'' = -(k_tt - μ k_nt) u_t with λ = k_nt u_t pressing it: it locks itself for μ > k_tt / k_nt.
"""

from types import SimpleNamespace

import numpy as np
import pytest

from evidence.truth.motion import Structure, make_bank, trace, wall
from hpcrub.config import schema as config
from hpcrub.contact import status
from hpcrub.model.coating import Coating, ElasticCasing
from hpcrub.model.reduction import Modes, mistuned_modes
from hpcrub.response.sliding import critical_friction, growth_rate, permanent_contact
from hpcrub.response.steady import (
    SteadyCriteria,
    correlation,
    is_constant,
    is_repeated,
    localisation,
)
from hpcrub.setup import problem as study

CRITERIA = SteadyCriteria()
T = np.linspace(0.0, 6.0, 1200, endpoint=False)  # two windows of three revolutions
PERIODIC = np.sin(2 * np.pi * 3 * T) + 0.3 * np.cos(2 * np.pi * 5 * T)


def verdict(signal, criteria=CRITERIA):
    before, last = np.split(signal, 2)
    sizes = np.abs(before).max(), np.abs(last).max()
    return is_constant(*sizes, criteria) and is_repeated(before, last, criteria)


@pytest.mark.parametrize(
    ("signal", "steady"),
    [
        (PERIODIC, True),
        (np.zeros(1200), True),
        (np.full(1200, 3e-3), True),
        (PERIODIC * np.exp(0.001 * T), True),
        (PERIODIC * np.exp(0.01 * T), False),
        (np.sin(2 * np.pi * 3.1 * T), False),  # 0.3 of a turn between the windows
        (np.where(T < 3, 1.0, PERIODIC / np.abs(PERIODIC).max()), False),
    ],
    ids=["periodic", "zero", "constant", "hardly growing", "growing", "drifting", "starting"],
)
def test_what_repeats_itself_is_steady(signal, steady):
    assert verdict(signal) == steady


@pytest.mark.parametrize("changed", [0.999, 1.001])
def test_the_amplitude_may_change_by_its_share_of_the_last_window(changed):
    last = 3e-3
    before = last * (1.0 - changed * CRITERIA.max_amplitude_change)
    assert is_constant(before, last, CRITERIA) == (changed < 1.0)
    assert is_constant(2.0 * last - before, last, CRITERIA) == (changed < 1.0)


@pytest.mark.parametrize("off", [-0.005, 0.005])
def test_the_motion_must_repeat_itself_as_far_as_asked(off):
    """cos α sin t + sin α cos t has the correlation cos α with sin t."""
    t = np.linspace(0.0, 6.0 * np.pi, 600, endpoint=False)
    cosine = CRITERIA.min_correlation + off
    turned = cosine * np.sin(t) + np.sqrt(1.0 - cosine**2) * np.cos(t)
    assert is_repeated(np.sin(t), turned, CRITERIA) == (off > 0.0)


def test_nan_is_never_steady():
    assert not verdict(np.where(T > 5.9, np.nan, PERIODIC))
    assert not is_constant(np.nan, np.nan, CRITERIA)
    assert not is_repeated(PERIODIC, np.full_like(PERIODIC, np.nan), CRITERIA)


@pytest.mark.parametrize("scale", [1e-310, 1e-200, 1e-165, 1e160, 1e300])
def test_correlation_does_not_depend_on_the_unit(scale):
    a, b = np.random.default_rng(1).uniform(-1.0, 1.0, (2, 500))
    assert abs(correlation(scale * a, scale * b) - correlation(a, b)) < 1e-9
    assert abs(correlation(a, b)) < 0.2


def test_correlation_is_numpys():
    rng = np.random.default_rng(1)
    a, b = rng.normal(size=(2, 500))
    assert abs(correlation(a, b) - np.corrcoef(a, b)[0, 1]) < 1e-14
    assert correlation(a, a + 5.0) == pytest.approx(1.0)
    assert correlation(np.ones(5), np.ones(5)) == 1.0
    assert correlation(np.ones(5), np.arange(5.0)) == 0.0


def test_localisation_limits():
    assert localisation(np.full(12, 2e-3)) == pytest.approx(0.0, abs=1e-15)
    assert localisation(np.eye(12)[3]) == pytest.approx(1.0)
    assert localisation(np.zeros(12)) == 0.0
    assert localisation(np.ones(1)) == 0.0


def test_localisation_is_the_papers_formula():
    U = np.array([38.9, 12.0, 7.0, 20.0, 3.0, 9.0])
    zeta = U.max() / np.sqrt(np.mean(U**2))
    assert localisation(U * 1e-3) == pytest.approx((zeta - 1.0) / (np.sqrt(6) - 1.0))


def test_the_criteria_are_those_of_the_input():
    assert study.build_problem(config.Config()).scene.steady == SteadyCriteria(rule="ensemble")


K_NN, K_TT = 5.0e4, 2.0e4


def point(coupling):
    """Modes of the point; the casing pushes towards -n, friction towards -t."""
    squared, shape = np.linalg.eigh(np.array([[K_NN, coupling], [coupling, K_TT]]))
    return Modes.planar(np.sqrt(squared), shape[:1], shape[1:])


def test_a_point_locks_itself_beyond_the_ratio_of_stiffnesses():
    modes, coupling = point(1.6e4), 1.6e4
    critical = K_TT / coupling
    assert critical_friction(modes) == pytest.approx(critical, rel=1e-9)
    assert growth_rate(modes, 0.0, 0.9 * critical) == 0.0
    rate = growth_rate(modes, 0.0, 1.5 * critical)
    assert rate == pytest.approx(np.sqrt(0.5 * K_TT), rel=1e-6)


def test_friction_the_other_way_never_locks():
    assert critical_friction(point(-1.6e4)) == np.inf
    assert growth_rate(point(-1.6e4), 0.01, 5.0) == 0.0


def test_a_casing_that_gives_locks_later():
    """N = k u_n makes the stiffness (k_nn + k, k_nt; k_nt + μ k, k_tt), singular at this μ."""
    coupling, k = 1.6e4, 3e4
    critical = ((K_NN + k) * K_TT - coupling**2) / (k * coupling)
    assert critical_friction(point(coupling), ElasticCasing(k)) == pytest.approx(critical, rel=1e-9)


@pytest.mark.parametrize(
    ("share", "friction", "coating", "found"),
    [
        ([0.2, 0.98, 0.2], 2.0, None, status.NONE),  # heavy rubbing
        ([0.2, 1.00, 0.2], 1.0, None, status.PERMANENT),
        ([1.0, 1.00, 1.0], 2.0, None, status.FLUTTER),
        ([1.0, 1.00, 1.0], 2.0, Coating(1e-3, 1e9, 1e6, 1e8, 1e-4), status.NONE),  # not cut yet
        ([], 2.0, None, status.NONE),  # contacts that are not counted
    ],
)
def test_motions_in_permanent_contact_are_told_from_rubbing(share, friction, coating, found):
    scene = SimpleNamespace(friction=friction, coating=coating, elastic_casing=None)
    assert permanent_contact(np.array(share), point(1.6e4), scene, 50.0) == found


def test_permanent_contact_is_judged_with_the_stiffness_of_its_own_speed():
    """Rotation adds W^2 to both squares of frequency, as to k_nn and k_tt of a unit mass."""
    coupling, middle, speed = 1.6e4, 20.0, 40.0
    change = (2 * np.pi) ** 2 * (speed**2 - middle**2)
    stiffening = np.array([[1.0, 1.0], [0.0, 0.0]])
    modes = point(coupling)._replace(speed=2 * np.pi * middle, stiffening=stiffening)
    critical = [k / coupling for k in (K_TT, K_TT + change)]
    scene = SimpleNamespace(friction=np.mean(critical), coating=None, elastic_casing=None)
    found = [permanent_contact(np.ones(1), modes, scene, s) for s in (middle, speed)]
    assert found == [status.FLUTTER, status.PERMANENT]


LEANING = {"disk.blade.lean_deg": 43.74, "disk.blade.bow": -0.07924}  # with the rotation


def test_beyond_the_critical_friction_a_tip_moves_on_as_fast_as_is_said():
    """In time, pressed onto the casing by 0.1 mm: by static compliances and the disk held there."""
    problem = study.build_problem(config.Config().replace(LEANING))
    modes = mistuned_modes(problem.reduced, np.zeros(12))
    critical, ratio, step, n = critical_friction(modes), 5e-3, 1e-5, 10_000
    for part in (0.5, 0.99, 1.01, 1.3):
        tip = Structure(modes.omega, modes.normal[0], modes.tangential[0], ratio, part * critical)
        bank = make_bank(tip, wall(tip, -1e-4), [step])
        moved = trace(bank, n, tip.tangential[None]).displacement[1:, 0, 0]
        # of the largest so far: a motion that oscillates and decays has no rate
        size = np.log(np.maximum.accumulate(np.abs(moved)))[n // 2 :]
        said = growth_rate(modes, ratio, part * critical)
        assert (said > 0.0) == (part > 1.0)
        found, _ = np.polyfit(step * np.arange(len(size)), size, 1)
        assert found == pytest.approx(said, rel=1e-4, abs=1e-6)
