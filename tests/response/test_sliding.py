"""Sliding contact of a point on two inclined springs, whose stability is known in closed form.

Stiffness (k_nn, k_nt; k_nt, k_tt) and unit mass. Held at the casing, u_n = 0, the point moves as
u_t'' = -(k_tt - μ k_nt) u_t with λ = k_nt u_t pressing it: it locks itself for μ > k_tt / k_nt.
"""

import numpy as np
import pytest

from hpcrub.model.reduction import Modes
from hpcrub.response.sliding import critical_friction, growth_rate

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
