"""Component mode mistuning: blades known by their own frequencies, with the root held.

With u = psi u_root + phi q in a blade, phi its cantilever modes, a blade whose cantilever
eigenvalues differ by delta adds delta q^T Lambda q to the stiffness, and q follows from the motion
of the tuned disk: Lambda q = phi^T K_blade u. Source: Lim, Bladh, Castanier, Pierre (2007), AIAA
Journal 45(9), equations (14) to (20).
"""

import numpy as np

from hpcrub.errors import InputError
from hpcrub.model.imported.assembly import SHARED
from hpcrub.model.imported.craig_bampton import lowest_modes
from hpcrub.model.imported.neutral import NeutralModel


def inner_rows(disk: NeutralModel) -> list[np.ndarray]:
    """Rows of every blade without its root: the rest of the disk has no stiffness in them."""
    K = disk.stiffness[0]
    foreign = abs(K - disk.blade_stiffness).max(axis=1).toarray().ravel()
    own = np.where(foreign < SHARED * abs(K).max(), disk.row_blade, -1)
    return [np.flatnonzero(own == blade) for blade in range(disk.n_blades)]


def cantilever(
    disk: NeutralModel, basis: np.ndarray, n_modes: int
) -> tuple[np.ndarray, np.ndarray]:
    """Cantilever modes of every blade, expressed in the coordinates of a basis.

    disk: assembled, with the blades' stiffness; basis: (n, m); n_modes: modes of each blade.
    Returns frequencies (N, n_modes) of every blade alone, at rest, with its root held [Hz];
    participation (N, n_modes, m), amplitude of each mode per unit coordinate [sqrt(kg)].
    Raises InputError: a blade has fewer rows than modes.
    """
    frequencies, participation = [], []
    for blade, rows in enumerate(inner_rows(disk)):
        if len(rows) < n_modes:
            raise InputError(f"K_blade: blade {blade + 1} has {len(rows)} rows beyond its root")
        K = disk.blade_stiffness[rows]
        values, phi = lowest_modes(K[:, rows].tocsc(), disk.mass[rows][:, rows].tocsc(), n_modes)
        frequencies.append(np.sqrt(values) / (2 * np.pi))
        participation.append(phi.T @ (K @ basis) / values[:, None])
    return np.array(frequencies), np.array(participation)


def modal_stiffness(frequencies: np.ndarray, participation: np.ndarray) -> np.ndarray:
    """Stiffness (N, m, m) of cantilever modes (N, c) [Hz], participation (N, c, m) [sqrt(kg)]."""
    q = 2 * np.pi * frequencies[:, :, None] * participation
    return np.swapaxes(q, 1, 2) @ q
