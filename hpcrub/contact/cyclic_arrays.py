"""The arrays of `cyclic.Cyclic`, and what deviations of the blades are to a time step."""

from typing import Any, NamedTuple

import numpy as np

from hpcrub.contact.recurrence import LARGEST_PHASE
from hpcrub.model.damping import Damping, ratios_of
from hpcrub.model.reduction import Modes


class CyclicArrays(NamedTuple):
    """Arrays for N blades, H = N // 2 + 1 nodal diameters, P points and J modes of each blade."""

    # E, then O of the points' normal displacement, to second order also of the tangential one
    normal: np.ndarray  # (R, ≥ 2P or 4P) [1/√kg]
    blade: np.ndarray  # E, then O of the blade modes (R, ≥ 2J) [1/s]
    observed: np.ndarray  # E, then O of the observed displacements (R, ≥ 2Q) [1/√kg]
    push: np.ndarray  # modal forces by E, then O of forces along the blade modes (2J, ≥ R) [1/s]
    # modal forces by E, then O of the F multipliers of a blade (2F, ≥ R): i·P + p in place p along
    # direction i, then those on its bent modes
    load: np.ndarray
    bent: np.ndarray  # amplitudes of p bent modes by the modes of a blade (p, J) [s]
    cosine: np.ndarray  # cos(2πhb/N) of h and b up to N/2 (H, ≥ H)
    sine: np.ndarray  # sin(2πhb/N) (H, ≥ H)
    begins: np.ndarray  # first real mode of each h, then the end (H + 1,) int
    ends: np.ndarray  # end of the real modes of each h that blade modes move (H,) int
    waves: np.ndarray  # first row of the complex modes of each h, then the end (H + 1,) int
    diameters: np.ndarray  # h of every row (R,) int
    points: np.ndarray  # contact point p of blade b, place p·N + b (P·N,) int
    seen_rows: np.ndarray  # observed displacement q of blade b, place q·N + b (Q·N,) int
    blade_of: np.ndarray  # blade of every multiplier of the bank (3C + N·p,) int
    row_of: np.ndarray  # its multiplier among the F of the blade, likewise
    deviation: np.ndarray  # −δ of mode j of blade b, row j·N + b (J·N, L) [-]
    lag: np.ndarray  # s of mode j of blade b, row j·N + b (J·N, L) [-]
    series: np.ndarray  # E and O of points or of observed displacements, work space (H·n, L)
    blade_series: np.ndarray  # E and O of the blade modes, work space (H·n, L)
    even: np.ndarray  # part of a row that is even in b, work space (≥ H, L)
    odd: np.ndarray  # part of a row that is odd in b, work space (≥ H, L)
    local: np.ndarray  # y of mode j of blade b, row j·N + b (J·N, L) [m·√kg/s] (modified)
    before: np.ndarray  # y at the begin of the step before (J·N, L) [m·√kg/s] (modified)
    late: np.ndarray  # E, then O of the forces of the deviations, row j·n + h (2J·n, L) (modified)
    force: np.ndarray  # E, then O of multiplier m of a blade, from row 2m·n on (2F·n, L) (modified)
    has_force: np.ndarray  # 1 where multiplier m has a force on any blade, else 0 (F,) (modified)
    slots: np.ndarray  # these multipliers, in their order (F + 1,) int (modified)
    seen_at: np.ndarray  # observed displacements (≥ O, L) [m] (modified)
    n_blades: int


def blade_stiffness(
    modes: Modes, damping: float | Damping, h: float, is_exact: bool
) -> tuple[np.ndarray, np.ndarray]:
    """Relative deviations δ and their lags s (N, J) for a step h [s] (`docs/theory.md`).

    With them a mode of a blade has its frequency and damping ratio, as far as it is one of a family
    alone. Modes in air keep the damping of the tuned disk (`model.aero`).

    damping: of the real modes; is_exact: whether the scheme is `exact_modal`.
    """
    blades: Any = modes.blades
    energies, of_disk = blades.energies(modes.omega), ratios_of(damping, modes.omega)
    if modes.waves:
        of_disk[modes.waves.rows] = 0.0
    share = energies.sum(axis=1)  # of the blade in the strain energy of its mode
    theta = h * np.sqrt(energies @ modes.omega**2 / share)
    given = np.repeat(blades.deviation[:, None], len(share), axis=1)
    changed = share * given
    with np.errstate(divide="ignore", invalid="ignore"):
        root = np.sqrt(1.0 + changed)
        lag = energies @ (of_disk / modes.omega) / share / h
        lag = lag * np.where(changed == 0.0, 1.0, 2.0 * (root - 1.0) / changed)
        sine = np.sin(theta / 2.0 * root) / np.sin(theta / 2.0)
        ratio = (sine**2 - 1.0) / changed / (1.0 + lag * theta**2 / 2.0)
    slow = (changed != 0.0) & (theta > 1e-4) & (theta < LARGEST_PHASE)
    return np.where(slow & is_exact, given * ratio, given), lag
