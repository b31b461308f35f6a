"""Sliding contact of a point on two inclined springs, whose stability is known in closed form.

Stiffness (k_nn, k_nt; k_nt, k_tt) and unit mass. Held at the casing, u_n = 0, the point moves as
u_t'' = -(k_tt - μ k_nt) u_t with λ = k_nt u_t pressing it: it locks itself for μ > k_tt / k_nt.
"""

from types import SimpleNamespace

import numpy as np
import pytest

from hpcrub.contact import status
from hpcrub.model.coating import Coating, ElasticCasing
from hpcrub.model.reduction import Modes
from hpcrub.response.sliding import critical_friction, growth_rate, permanent_contact

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
    assert permanent_contact(np.array(share), point(1.6e4), scene) == found
