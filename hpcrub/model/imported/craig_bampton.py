"""Sparse Craig-Bampton reduction of an imported disk to its contact nodes and inner modes."""

from typing import Any

import numpy as np
import scipy.sparse.linalg as sla
from scipy.linalg import cholesky, eigh, solve_triangular

from hpcrub.errors import InputError
from hpcrub.model import families
from hpcrub.model.imported.assembly import PAIRING, turned
from hpcrub.model.imported.neutral import NeutralModel, contact_rows, stiffness_at

AT_ONCE = 64  # right-hand sides of one solution
BLOCK = 12  # vectors of the Lanczos iteration
SMALLEST = 200  # rows below which matrices are treated as dense
TOLERANCE = 1e-8  # largest residual of modes; errors of eigenvalues are about its square


def basis(disk: NeutralModel, n_modes: int, speed: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """Craig-Bampton basis of an assembled disk at one speed of rotation.

    n_modes: fixed-interface modes kept, by whole families; speed: of rotation [rad/s].
    Returns basis (n, m), first a column for each of the `contact_rows`, then the modes; these rows.
    Raises InputError: the disk is not held, or has fewer modes.
    """
    boundary = contact_rows(disk).ravel()
    n = disk.mass.shape[0]
    inside = np.setdiff1d(np.arange(n), boundary)
    n_modes = families.whole(n_modes, disk.n_blades)
    if not 0 <= n_modes < len(inside):
        raise InputError(f"reduction.n_modes: {n_modes} is not below the {len(inside)} inner dof")
    K = stiffness_at(disk.stiffness, speed).tocsc()
    K_ii, K_ib = K[inside][:, inside], K[inside][:, boundary]
    factor = factorised(K_ii)
    out = np.zeros((n, len(boundary) + n_modes))
    out[boundary, np.arange(len(boundary))] = 1.0
    for first in range(0, len(boundary), AT_ONCE):
        columns = slice(first, min(first + AT_ONCE, len(boundary)))
        out[inside, columns] = -factor.solve(K_ib[:, columns].toarray())
    if n_modes:
        M_ii = disk.mass[inside][:, inside].tocsc()
        place = np.full(n + 1, -1)
        place[inside] = np.arange(len(inside))
        modes = _families(K_ii, M_ii, n_modes, factor, place[like_rows(disk)])
        out[inside, len(boundary) :] = modes
    return out, boundary


def like_rows(disk: NeutralModel) -> np.ndarray:
    """Rows of corresponding nodes in all sectors (N, p); p is 0 unless the mesh is cyclic."""
    from scipy.spatial import cKDTree  # slow to import, and needed by imports only

    N = disk.n_blades
    placed = np.flatnonzero(np.isfinite(disk.nodes).all(axis=1) & (disk.row >= 0).all(axis=1))
    at = disk.nodes[placed]
    tree, orbit = cKDTree(at), [np.arange(len(at))]
    for sector in range(1, N):
        apart, nearest = tree.query(turned(at, sector * (2 * np.pi / N)))
        if not len(at) or apart.max() > PAIRING * np.abs(at).max():
            return np.zeros((N, 0), dtype=int)
        orbit.append(nearest)
    first = np.min(orbit, axis=0) == orbit[0]  # one of each set of corresponding nodes
    return disk.row[placed[np.array(orbit)[:, first]]].reshape(N, -1)


def _families(K: Any, M: Any, n_modes: int, factor: Any, like: Any) -> Any:
    """Lowest modes by whole families; by frequency alone where the mesh is not cyclic."""
    like = like[:, (like >= 0).all(axis=0)]
    if not like.size:
        return lowest_modes(K, M, n_modes, factor)[1]
    n_tried = n_modes
    while n_tried < K.shape[0]:
        n_tried = min(n_tried + 2 * len(like), K.shape[0])
        values, modes = lowest_modes(K, M, n_tried, factor)
        chosen = families.choose(values, modes[like], n_modes // len(like), n_tried == K.shape[0])
        if chosen is not None:
            return modes @ chosen
    raise InputError("K, M: the modes of the disk have no whole families of nodal diameters")


def factorised(K: Any) -> sla.SuperLU:
    """LU factors of a sparse symmetric matrix. Raises InputError when it is singular."""
    options = {"SymmetricMode": True}
    try:
        return sla.splu(
            K.tocsc(), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=options
        )
    except RuntimeError:
        raise InputError(
            "the stiffness is singular with the contact nodes held: rows without stiffness, or "
            "no supports (fixed)"
        ) from None


def lowest_modes(
    K: Any, M: Any, n_modes: int, factor: sla.SuperLU | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """Lowest modes of two sparse matrices, real or Hermitian, by block Lanczos iteration on K^-1 M.

    A block finds the double modes of a cyclic disk, which an iteration of one vector can miss. The
    first block holds fixed random numbers, so that every call returns the same bits.

    K, M: (n, n), K positive definite; M may have rows of zeros; factor: `factorised` K.
    Returns eigenvalues (n_modes,) increasing [rad2/s2]; modes (n, n_modes) mass-normalised.
    Raises InputError when there are none: the disk is not held, or M is no mass matrix.
    """
    try:
        values, modes = _lowest_modes(K, M, n_modes, factor)
    except (ValueError, np.linalg.LinAlgError):  # not finite, not positive definite
        values = np.zeros(0)
    if not np.isfinite(values).sum() == n_modes:
        raise InputError(
            "K, M: no modes can be found: the disk is not held (fixed), or the units are not "
            "those of the file"
        )
    return values, modes


def _lowest_modes(K: Any, M: Any, n_modes: int, factor: Any) -> tuple[Any, Any]:
    n = K.shape[0]
    if n < SMALLEST or n_modes > n // 6:
        # the inverse problem, M y = K y / w^2: inner nodes of elements may have no mass
        inverse, y = eigh(M.toarray(), K.toarray(), subset_by_index=[n - n_modes, n - 1])
        inverse, y = inverse[::-1], y[:, ::-1]
        return 1.0 / inverse, y / np.sqrt(inverse)
    factor = factor or factorised(K)
    draw = np.random.Generator(np.random.Philox(key=0)).random((n, BLOCK)) - 0.5
    V, _ = _orthonormal(draw.astype(K.dtype), M)
    T = np.zeros((0, 0), dtype=K.dtype)
    while True:
        W = factor.solve(M @ V[:, -BLOCK:])
        C = V.conj().T @ (M @ W)
        W -= V @ C
        W -= V @ (V.conj().T @ (M @ W))  # removes what rounding left
        T = np.pad(T, ((0, BLOCK), (0, BLOCK)))
        T[:, -BLOCK:], T[-BLOCK:] = C, C.conj().T
        V_next, R = _orthonormal(W, M)
        inverse, y = eigh(T)
        y = y[:, ::-1][:, :n_modes]
        residual = np.linalg.norm(R @ y[-BLOCK:], axis=0) / inverse[::-1][:n_modes]
        if len(T) > n_modes + BLOCK and residual.max() < TOLERANCE:
            return 1.0 / inverse[::-1][:n_modes], V @ y
        V = np.hstack([V, V_next])


def _orthonormal(W: Any, M: Any) -> tuple[Any, Any]:
    """Return Q, orthonormal in M, and the upper triangle R of W = Q R."""
    R = cholesky(W.conj().T @ (M @ W))
    return solve_triangular(R, W.T, trans="T").T, R


def frequencies(disk: NeutralModel, n_modes: int, speed: float = 0.0) -> np.ndarray:
    """First natural frequencies of an assembled disk at a speed [rad/s]; (n_modes,) [Hz]."""
    values, _ = lowest_modes(stiffness_at(disk.stiffness, speed), disk.mass.tocsc(), n_modes)
    return np.sqrt(np.maximum(values, 0.0)) / (2 * np.pi)
