"""Beam elements in the plane: frame (blades), spoke and curved ring (disk).

Euler-Bernoulli beams with consistent mass. The matrices of an element are integrals of its two
strains and two displacements, by a Gauss rule that is exact for them:

    K = int EA eps'eps + EI kappa'kappa ds,    M = int rho A (N_u'N_u + N_v'N_v) ds.
"""

from functools import partial
from typing import Any, NamedTuple

import numpy as np

_GAUSS_X, _GAUSS_W = np.polynomial.legendre.leggauss(4)  # exact to degree 7; integrands have 6
_XI, _WEIGHT = (_GAUSS_X + 1) / 2, _GAUSS_W / 2  # on [0, 1]


class Beam(NamedTuple):
    """Stiffness and mass of the cross-section of a beam."""

    axial: float  # EA [N]
    bending: float  # EI [N m2]
    mass: float  # rho A [kg/m]


def rectangular_beam(width: float, thickness: float, young_modulus: float, density: float) -> Beam:
    """Beam with a rectangular section [m] that bends across its thickness."""
    area = width * thickness
    return Beam(young_modulus * area, young_modulus * area * thickness**2 / 12, density * area)


def frame_element(beam: Beam, length: float) -> tuple[np.ndarray, np.ndarray]:
    """Mass and stiffness (6, 6) of a straight frame element: linear axial, cubic transverse.

    Dof (axial, transverse, rotation) at each end; the transverse direction is the axis turned by
    +90 degrees. length [m].
    """
    axial, transverse = [0, 3], [1, 2, 4, 5]
    line = np.stack([1 - _XI, _XI], axis=1)
    slope = np.tile([-1.0, 1.0], (len(_XI), 1)) / length
    n, _, n2 = _hermite(length)
    u, v = _rows(6, axial, line), _rows(6, transverse, n)
    eps, kappa = _rows(6, axial, slope), _rows(6, transverse, n2)
    return _matrices(beam, length, u, v, eps, kappa)


def strains_at_start(length: float) -> tuple[np.ndarray, np.ndarray]:
    """Axial strain and curvature at the first end of a `frame_element`: rows (6,) over its dof."""
    strain = np.array([-1.0, 0.0, 0.0, 1.0, 0.0, 0.0]) / length
    curvature = np.array([0.0, -6.0, -4.0 * length, 0.0, 6.0, -2.0 * length]) / length**2
    return strain, curvature


def spoke_element(beam: Beam, length: float) -> tuple[np.ndarray, np.ndarray]:
    """Mass and stiffness (8, 8) of a straight element, cubic in both directions.

    Dof (u, u', v, v') at each end: u axial, v transverse (the axis turned by +90 degrees), ' the
    derivative along the axis. length [m].
    """
    n, n1, n2 = _hermite(length)
    return _matrices(beam, length, _u(n), _v(n), _u(n1), _v(n2))


def ring_element(beam: Beam, length: float, radius: float) -> tuple[np.ndarray, np.ndarray]:
    """Mass and stiffness (8, 8) of an arc: membrane strain v' + u/R, curvature u'' - v'/R.

    Dof (u, u', v, v') at each end: u radial (outward), v tangential and ' the derivative along the
    arc, both towards +theta. The section turns by v/R - u'. length of the arc, radius [m].
    """
    n, n1, n2 = _hermite(length)
    eps = _v(n1) + _u(n) / radius
    kappa = _u(n2) - _v(n1) / radius
    return _matrices(beam, length, _u(n), _v(n), eps, kappa)


def _matrices(beam: Beam, length: Any, u: Any, v: Any, eps: Any, kappa: Any) -> tuple[Any, Any]:
    """Mass and stiffness from displacement and strain rows (n_gauss, n_dof)."""

    def integral(row: Any) -> Any:
        return length * (row.T * _WEIGHT) @ row

    mass = beam.mass * (integral(u) + integral(v))
    stiffness = beam.axial * integral(eps) + beam.bending * integral(kappa)
    return mass, stiffness


def _hermite(length: Any) -> Any:
    """Cubic Hermite functions at the Gauss points and their two derivatives, (n_gauss, 4) each."""
    x, one = _XI, np.ones_like(_XI)
    n = [1 - 3 * x**2 + 2 * x**3, x - 2 * x**2 + x**3, 3 * x**2 - 2 * x**3, x**3 - x**2]
    n1 = [6 * x**2 - 6 * x, 1 - 4 * x + 3 * x**2, 6 * x - 6 * x**2, 3 * x**2 - 2 * x]
    n2 = [12 * x - 6 * one, 6 * x - 4 * one, 6 * one - 12 * x, 6 * x - 2 * one]
    scale = np.array([1, length, 1, length])
    return (np.stack(f, axis=1) * scale / length**k for k, f in enumerate((n, n1, n2)))


def _rows(n_dof: Any, columns: Any, functions: Any) -> Any:
    """Rows over all dof of an element, from functions of the dof ``columns``."""
    rows = np.zeros((len(functions), n_dof))
    rows[:, columns] = functions
    return rows


# rows over the dof (u, u', v, v') of both ends, from functions of u and from functions of v
_u, _v = partial(_rows, 8, [0, 1, 4, 5]), partial(_rows, 8, [2, 3, 6, 7])
