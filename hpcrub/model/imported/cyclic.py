"""Natural frequencies by nodal diameter: of one sector, of a whole disk, of a reduced model."""

import numpy as np
import scipy.sparse as sp

from hpcrub.model.imported.assembly import disk_rows
from hpcrub.model.imported.craig_bampton import lowest_modes
from hpcrub.model.imported.frames import to_cylindrical
from hpcrub.model.imported.neutral import NeutralModel, stiffness_at


def sector_frequencies(
    model: NeutralModel, n_diameters: int, n_modes: int, speed: float = 0.0
) -> np.ndarray:
    """Frequencies of the modes with some nodal diameters, from one sector.

    Parameters
    ----------
    model : NeutralModel
        Of kind "sector".
    n_diameters : int
        Nodal diameters: u of the next sector is u e^{2 pi i n_diameters / n_sectors}.
    n_modes : int
    speed : float
        Of rotation [rad/s].

    Returns
    -------
    (n_modes,) [Hz]
        Every double frequency once.
    """
    model = to_cylindrical(model)
    rows, own = disk_rows(model)
    rows, n_own = rows[0], len(own)
    turn = np.exp(2j * np.pi * n_diameters / model.n_sectors)
    phase = np.where(rows < n_own, 1.0, turn)
    held = np.unique(rows[model.fixed] % n_own)
    free = np.setdiff1d(np.arange(n_own), held)
    P = sp.csr_array((phase, (np.arange(len(rows)), rows % n_own)), shape=(len(rows), n_own))
    P = P[:, free]
    K, M = (
        (P.conj().T @ matrix @ P).tocsc()
        for matrix in (stiffness_at(model.stiffness, speed), model.mass)
    )
    if n_diameters in (0, model.n_sectors / 2):
        K, M = K.real.copy(), M.real.copy()
    values, _ = lowest_modes(K, M, n_modes)
    return np.sqrt(np.maximum(values, 0.0)) / (2 * np.pi)


def nodal_diameters(shapes: np.ndarray, angle: np.ndarray, n_blades: int) -> np.ndarray:
    """Nodal diameters of every mode from displacements of like points of all blades.

    Parameters
    ----------
    shapes : (p, N, K)
        p displacements of each of N blades in K modes.
    angle : (N,) [rad]
    n_blades : int

    Returns
    -------
    (K,) int
    """
    orders = np.arange(n_blades // 2 + 1)
    wave = np.exp(-1j * orders[:, None] * angle)  # (orders, N)
    size = (np.abs(np.einsum("hn,pnk->hpk", wave, shapes)) ** 2).sum(axis=1)
    twice = np.where((orders == 0) | (2 * orders == n_blades), 1.0, 2.0)  # and the backward wave
    return (size * twice[:, None]).argmax(axis=0)


def diameters_of(shapes: np.ndarray, blade: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Nodal diameters of every mode from displacements of all contact points.

    Parameters
    ----------
    shapes : (p, C, K)
        p displacements of each of C points in K modes.
    blade : (C,) int
        Of each point, from 0. The first points of every blade are taken to be alike.
    angle : (C,) [rad]

    Returns
    -------
    (K,) int
    """
    count = np.bincount(blade)
    parts = np.split(np.argsort(blade, kind="stable"), np.cumsum(count)[:-1])
    points = np.array([part[: count.min()] for part in parts])  # (N, alike)
    like = shapes[:, points].transpose(0, 2, 1, 3).reshape(-1, *points.T.shape[1:], shapes.shape[2])
    return nodal_diameters(like, angle[points[:, 0]], len(count))
