"""Contact forces as a linear complementarity problem: truth by trying every set of contacts.

W is a P-matrix if and only if every principal minor is positive; then exactly one set of contacts
fits any penetration. The cyclic matrix below is one (its minors are 1, 1 and 1 + c³), but
Gauss–Seidel runs in circles on it for c > 1.
"""

import itertools

import numpy as np
import pytest

from hpcrub.contact import lanes as v
from hpcrub.contact import status
from hpcrub.contact.bank import allocate
from hpcrub.contact.jit import compiled
from hpcrub.contact.lcp.gauss_seidel import MAX_SWEEPS
from hpcrub.contact.lcp.pivoting import flaw, is_p_matrix, solve_by_pivoting
from hpcrub.contact.status import DIVERGED, STEADY
from hpcrub.model.casing import CasingShape
from hpcrub.model.interface import planar_interface
from hpcrub.model.reduction import Modes
from hpcrub.response.revolution import cut_revolution
from hpcrub.response.scene import Scene
from hpcrub.response.steady import SteadyCriteria
from hpcrub.response.sweep import run_sweep

CYCLE = np.array([[1.0, 2.0, 0.0], [0.0, 1.0, 2.0], [2.0, 0.0, 1.0]])


def minors(W):
    n = len(W)
    sets = (s for size in range(1, n + 1) for s in itertools.combinations(range(n), size))
    return [np.linalg.det(W[np.ix_(s, s)]) for s in sets]


def every_set(M, p):
    """All solutions of x ≥ 0, Mx − p ≥ 0, x·(Mx − p) = 0."""
    found = []
    for mask in itertools.product([False, True], repeat=len(p)):
        x, chosen = np.zeros(len(p)), np.flatnonzero(mask)
        if len(chosen):
            x[chosen] = np.linalg.solve(M[np.ix_(chosen, chosen)], p[chosen])
        if x.min() >= 0.0 and (M @ x - p).min() >= -1e-12:
            found.append(x)
    return found


def random_matrices(n_matrices):
    """Matrices of 1 to 6 rows, near the edge of the P-matrices."""
    rng = np.random.default_rng(3)
    for i in range(n_matrices):
        n = 1 + i % 6
        yield np.eye(n) + rng.uniform(-1.0, 1.0, (n, n)) * rng.uniform(0.2, 1.2), rng


def test_p_matrices_are_those_of_positive_minors():
    answers = []
    for W, _ in random_matrices(300):
        answers.append(is_p_matrix(W))
        assert answers[-1] == (min(minors(W)) > 0.0)
    assert 50 < sum(answers) < 250


def test_pivoting_finds_the_one_solution_of_p_matrices_and_no_false_one_of_others():
    """Of which some have none, or several."""
    counts = {(is_p, solved): 0 for is_p in (True, False) for solved in (True, False)}
    for W, rng in random_matrices(300):
        p, x = rng.normal(size=len(W)), np.ones(len(W))
        if p.max() <= 0.0:
            continue
        solved = solve_by_pivoting(W, p, x)
        if solved:
            assert min(np.abs(x - one).max() for one in every_set(W, p)) < 1e-9 * np.abs(x).max()
        else:
            assert not x.any()
        counts[is_p_matrix(W), solved] += 1
    assert counts[True, True] > 50
    assert counts[True, False] == 0
    assert min(counts[False, True], counts[False, False]) > 10


@pytest.mark.parametrize("W", [np.eye(3), CYCLE, CYCLE.T])
def test_pivoting_of_equal_and_of_vanishing_penetrations(W):
    """Ties in the ratio test: every penetration of −1, 0 and 1 has its one solution."""
    for p in map(np.array, itertools.product([-1.0, 0.0, 1.0], repeat=3)):
        if p.max() > 0.0:
            x = np.zeros(3)
            assert solve_by_pivoting(W, p, x), p
            assert all(np.abs(x - only).max() < 1e-12 for only in every_set(W, p)), p


@pytest.mark.parametrize(
    ("W", "expected"),
    [
        (np.eye(3), status.NONE),
        (CYCLE, status.NONE),
        (np.array([[1.0, 0.0], [0.0, -1e-9]]), status.JAMMING),
        (np.array([[1.0, 0.0], [0.0, 0.0]]), status.JAMMING),
        (np.array([[1.0, 2.0], [2.0, 1.0]]), status.NOT_UNIQUE),
        (np.array([[1.0, np.nan], [0.0, 1.0]]), status.NOT_FINITE),
        (np.kron(np.eye(8), CYCLE), status.UNPROVEN),
    ],
)
def test_flaws_are_named(W, expected):
    assert flaw(W * 1e-9) == expected


def masses(W, friction=0.5):
    """Free masses (one contact point each) whose Delassus operator is h²·W, and a bump for each."""
    n = len(W)
    eye = np.eye(n)
    modes = Modes.planar(np.full(n, 2 * np.pi * 20.0), eye, (W - eye) / friction)
    scene = Scene(
        planar_interface(np.zeros(n), 1.0), 0.05, CasingShape(1, 2e-3), 1e-3, 0.01, friction,
        scheme="exact_modal", step=1e-4, steady=SteadyCriteria(first_check=0.3, max_time=0.8),
    )  # fmt: skip
    return modes, scene


def test_forces_are_found_where_gauss_seidel_runs_in_circles():
    """By symmetry all three carry λ = p/3 h²; each then moves just as a mass of weight 1 alone."""
    modes, scene = masses(CYCLE)
    speeds = np.array([12.0, 12.5, 13.0])
    result = run_sweep(modes, scene, speeds, width=8)
    assert (result.max_sweeps == MAX_SWEEPS).all()
    assert (result.point_status == STEADY).all()
    assert (result.point_reason == status.NONE).all()
    one, one_scene = masses(np.eye(1))
    one = Modes.planar(one.omega, one.normal, np.full((1, 1), modes.tangential[0].sum()))
    alone = run_sweep(one, one_scene._replace(friction=0.0), speeds, width=8)
    assert alone.amplitude.min() > 1e-3
    np.testing.assert_allclose(result.amplitude, alone.amplitude, rtol=1e-6)
    by_itself = run_sweep(modes, scene, speeds[:1], width=4)
    assert by_itself.amplitude[0] == run_sweep(modes, scene, speeds[:1], width=8).amplitude[0]


@compiled
def press(lanes, law, state, deepest):
    """Contact forces of all lanes at the penetrations of a state (state is modified)."""
    law.surface.solve_planar(lanes, law, state, v.load(lanes, deepest, 0))


def test_a_lane_has_the_same_bits_beside_one_with_more_points_than_registers_hold():
    """Few points are solved in registers and many in memory; both forces fulfil p − Wλ = 0."""
    n = 16
    rng = np.random.default_rng(1)
    W = np.eye(n) + rng.uniform(-0.06, 0.06, (n, n))
    modes, scene = masses(W)
    bank = allocate(modes, scene, cut_revolution(12.0, scene), 4, np.full(4, 12.0))
    found = {}
    for name, beside in (("few", -1.0), ("many", 1e-3)):
        depth = np.full((n, 4), -1.0)
        depth[3:8, 0] = 1e-3 * np.array([1.0, 0.2, 0.7, 0.01, 0.4])
        depth[:, 1] = beside
        bank.state.penetration[:n], bank.state.penetration[n:-1] = depth, -1.0
        press((0,) * 4, bank.law, bank.state, depth.max(axis=0, keepdims=True))
        found[name] = bank.state.multiplier[:n].copy()
    np.testing.assert_array_equal(found["few"][:, 0], found["many"][:, 0])
    assert (found["many"][:, 1] > 0.0).all()
    x, n_rows = found["many"][:, 1] / bank.law.stiffness[:n, 1], len(bank.state.penetration)
    coupling = bank.law.coupling[:, 1].reshape(n_rows, n_rows)[:n, :n]
    np.testing.assert_allclose(x + coupling @ x, 1e-3, rtol=1e-11)


@pytest.mark.parametrize(
    ("W", "reason"),
    [
        (np.array([[1.0, 0.0], [0.0, -0.5]]), status.JAMMING),
        (np.array([[1.0, 2.0], [2.0, 1.0]]), status.NOT_UNIQUE),
        # too many to prove anything; no forces exist, and Gauss–Seidel grows until it overflows
        (3.0 * np.eye(8) - 2.0, status.NOT_UNIQUE),
        (3.0 * np.eye(15) - 2.0, status.UNSOLVED),
    ],
)
def test_a_flaw_is_the_reason_of_a_diverged_point_that_touches(W, reason):
    modes, scene = masses(W)
    speeds = np.array([12.0, 13.0])
    result = run_sweep(modes, scene, speeds, width=8)
    assert (result.point_status == DIVERGED).all()
    assert (result.point_reason == reason).all()
    assert np.isnan(result.amplitude).all()
    far = run_sweep(modes, scene._replace(clearance=2.1e-3), speeds, width=8)
    assert (far.point_status == STEADY).all()
    assert (far.point_reason == status.NONE).all()
    assert (far.max_sweeps == 0).all()


def test_an_operator_that_is_not_finite_is_the_reason_too():
    modes, scene = masses(np.eye(2))
    huge = modes._replace(normal=1e200 * modes.normal, tangential=1e200 * modes.tangential)
    with np.errstate(all="ignore"):
        result = run_sweep(huge, scene, np.array([12.0]), width=8)
    assert result.point_status[0] == DIVERGED
    assert result.point_reason[0] in (status.NOT_FINITE, status.JAMMING)


def test_no_point_to_look_at_is_no_exception():
    """Where all penetrations have become infinite, in the kernel."""
    assert not solve_by_pivoting(np.zeros((0, 0)), np.zeros(0), np.zeros(0))
