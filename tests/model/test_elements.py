"""Elements against closed forms, with fitted orders of convergence.

Cantilever of length L:  omega = (beta L)^2 sqrt(EI / (rho A L^4)) in bending, beta L = 1.8751,
4.6941 (cos cosh = -1), and omega = (2k - 1) pi/2 sqrt(EA / (rho A L^2)) along its axis. For
interpolation of degree p the error of omega falls as h^(2(p + 1 - m)), m the order of the strain:
4 for cubic bending (m = 2), 2 for a linear and 6 for a cubic bar (m = 1). In the ring bending
meets this last: on coarse meshes the sixth-order error of the much stiffer membrane hides it.

Free ring: u = U cos(n phi), v = V sin(n phi) in the element's own strains, eps = v' + u/R and
kappa = u'' - v'/R, gives the 2 x 2 eigenproblem

    [ EA/R^2 [1  n ]  +  EI/R^4 [n^4 n^3] ] [U]  =  rho A omega^2 [U]
    [        [n n^2]            [n^3 n^2] ] [V]                   [V]

whose lower root is the bending mode.
"""

import numpy as np
import pytest
from scipy.linalg import eigh
from scipy.optimize import brentq

from evidence.truth.chain import assemble
from evidence.validation.report import fitted_order
from hpcrub.model.elements import frame_element, rectangular_beam, ring_element, spoke_element

BEAM = rectangular_beam(width=0.1, thickness=0.013, young_modulus=2.1e11, density=7800.0)
LENGTH, RADIUS = 0.3, 0.2


def frequencies(mass, stiffness):
    return np.sqrt(np.maximum(eigh(stiffness, mass, eigvals_only=True), 0))


def errors(frequencies_of, exact, *meshes):
    """Error of the frequency nearest to the exact one, for every number of elements."""
    return np.array([np.abs(frequencies_of(n) / exact - 1).min() for n in meshes])


def assert_converges(frequencies_of, exact, meshes, order, within):
    found = fitted_order(1.0 / np.array(meshes), errors(frequencies_of, exact, *meshes))
    assert found == pytest.approx(order, abs=within)


def cantilever(element, n_elements, held):
    """held: dof of the first node that are clamped."""
    mass, stiffness = assemble(element(BEAM, LENGTH / n_elements), n_elements)
    free = np.setdiff1d(np.arange(len(mass)), held)
    return frequencies(mass[np.ix_(free, free)], stiffness[np.ix_(free, free)])


CANTILEVERS = {
    "frame": lambda n: cantilever(frame_element, n, held=[0, 1, 2]),
    "spoke": lambda n: cantilever(spoke_element, n, held=[0, 2, 3]),  # u' is its strain: free
}


@pytest.mark.parametrize("mode", [0, 2])
@pytest.mark.parametrize("name", CANTILEVERS)
def test_cantilever_bending_converges_with_order_four(name, mode):
    beta = brentq(lambda x: np.cos(x) + 1 / np.cosh(x), mode * np.pi + 0.1, (mode + 1) * np.pi)
    exact = beta**2 * np.sqrt(BEAM.bending / (BEAM.mass * LENGTH**4))
    assert errors(CANTILEVERS[name], exact, 24) < 1e-5
    assert_converges(CANTILEVERS[name], exact, [6, 12, 24], 4, within=0.15)


@pytest.mark.parametrize(("name", "order"), [("frame", 2), ("spoke", 6)])
def test_cantilever_axial_order_is_that_of_the_interpolation(name, order):
    exact = 0.5 * np.pi * np.sqrt(BEAM.axial / (BEAM.mass * LENGTH**2))
    assert_converges(CANTILEVERS[name], exact, [4, 8, 16], order, within=0.25)


def ring_closed_form(n, beam):
    """Bending and extensional frequency of n waves on a free ring."""
    membrane = beam.axial / RADIUS**2 * np.array([[1, n], [n, n**2]])
    bending = beam.bending / RADIUS**4 * np.array([[n**4, n**3], [n**3, n**2]])
    return np.sqrt(np.linalg.eigvalsh(membrane + bending) / beam.mass)


def free_ring(n_elements):
    arc = 2 * np.pi * RADIUS / n_elements
    return frequencies(*assemble(ring_element(BEAM, arc, RADIUS), n_elements, closed=True))


@pytest.mark.parametrize("n_waves", [2, 3, 4])
def test_free_ring_bending_converges_with_order_four(n_waves):
    exact, _ = ring_closed_form(n_waves, BEAM)
    assert errors(free_ring, exact, 128) < 1e-5
    assert_converges(free_ring, exact, [64, 96, 128], 4, within=0.25)


def test_free_ring_extension():
    _, exact = ring_closed_form(2, BEAM)
    assert errors(free_ring, exact, 48) < 1e-6
