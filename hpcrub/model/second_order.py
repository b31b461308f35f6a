"""Second order of the motion of blades, for tips that move as far as the clearance is wide.

A few *bent* modes of every blade alone, its root held, have large amplitudes s. What is of second
order in them follows: along the direction e a tip moves by

    u_e = (first order) − ½ sᵀ G_e s,

and the motion of bent mode a has the force −½ Σ C_abc s_b s_c. With the matrix V₃(y) that a
displacement y adds to the tangent stiffness of the blade, and its mass-normalised modes φ,

    C_abc = φ_bᵀ V₃(φ_a) φ_c,    G_e[b, c] = φ_bᵀ V₃(K⁻¹e) φ_c − Σ_a C_abc (φ_a·e)/ω_a².

By reciprocity a force f along e then pushes bent mode a by −f Σ_b G_e[a, b] s_b: position and
force together conserve energy.
"""

from typing import NamedTuple

import numpy as np

RANGE = 0.3  # largest second order over the first in which an expansion to second order is of use
N_BENT = 3  # bent modes of a blade: a fourth makes a bowed blade no better


class SecondOrder(NamedTuple):
    """Second order of C contact points and O observed displacements, by p bent modes of N blades.

    Directions of a contact point are those of `interface.Interface`.
    """

    participation: np.ndarray  # (N, p, m) amplitude s of bent modes per unit coordinate [√kg]
    # (C, 3, p, p) G of normal, tangential and axial motion of the contact points [1/(m·kg)]
    shortening: np.ndarray
    observed: np.ndarray  # (O, p, p) G of the observed displacements [1/(m·kg)]
    coupling: np.ndarray  # (p, p, p) C, symmetric in all three [1/(m·√kg·s²)]
    # (p,) angular frequencies of the bent modes [rad/s]; inf of a turn of the root, an angle as s
    omega: np.ndarray
    curvature: np.ndarray  # (C,) of the casing along its circumference at the points, cos α/R [1/m]
    motion: np.ndarray  # (C, p) tangential motion of the contact points by each mode [1/√kg]
    # (p, p, p, p) D, symmetric in all four [1/(m²·kg·s²)]: the force −⅙ Σ D_abcd s_b s_c s_d on
    # bent mode a is of third order, but without it C softens a bowed blade by more than its damping
    quartic: np.ndarray = np.zeros((0, 0, 0, 0))
    # (q, q, q, q) J_abcd = u_abᵀ M u_cd [1/(m²·kg)] of the first q bent modes; ½ Σ s_a s_b u_ab
    # is the second order of displacements, and its inertia, the force −½ Σ J_abcd s_b (s_c s_d)¨
    # on bent mode a, cancels nearly all that D does to a frequency
    inertia: np.ndarray = np.zeros((0, 0, 0, 0))

    @property
    def size(self) -> tuple[float, float]:
        """Shift and bend of `size_of`."""
        given = self.shortening, self.curvature, self.motion, self.coupling, self.omega
        return size_of(*given)

    @property
    def furthest(self) -> float:
        """Amplitude beyond which the expansion says nothing [m]."""
        return RANGE / self.size[1]


def size_of(
    shortening: np.ndarray,
    curvature: np.ndarray,
    motion: np.ndarray,
    coupling: np.ndarray,
    omega: np.ndarray | None,
) -> tuple[float, float]:
    """Size of the second order in a motion of the first bent mode with the amplitude u [m].

    Arguments: as members of SecondOrder; omega: None where it is not known.
    Returns the shift a: a u² is how much further out the tip is than to first order, where this is
    most [1/m]; the bend b: b u is the second order of a displacement over u, or the change of the
    blade's stiffness over that of its modes, whichever is larger [1/m].
    """
    u = np.abs(motion[:, 0]).max()
    shift = (curvature * motion[:, 0] ** 2 - shortening[:, 0, 0, 0]) / (2.0 * u**2)
    bend = np.abs(shortening[:, :, 0, 0]).max() / u**2
    if omega is not None:
        stiffer = coupling[0] / (2.0 * np.outer(omega, omega)) / u
        bend = max(bend, np.abs(np.linalg.eigvalsh(stiffer)).max())
    return float(shift[np.abs(shift).argmax()]), float(bend)
