"""The fan reduced by cyclic symmetry at its design speed, with frequencies of other speeds.

A fan blade untwists by degrees. Its stiffness matrices at two speeds differ by more than any
polynomial between them tells, and the mode shapes of one speed stretch the blade of another. So
the shapes of the model are those of the design speed, and what is interpolated between speeds are
the eigenvalues of its modes, followed from speed to speed by their shapes.

Coordinates belong to sectors: displacements of its contact nodes, and as many modal ones for each
number of nodal diameters, so that no family is cut and the reduced fan is cyclic to rounding.
"""

from typing import NamedTuple

import numpy as np
from scipy.linalg import eigh
from scipy.optimize import linear_sum_assignment

from hpcrub.model.imported.craig_bampton import factorised, lowest_modes
from hpcrub.model.imported.cyclic import wave_matrices
from hpcrub.model.imported.frames import to_cylindrical
from hpcrub.model.imported.neutral import NeutralModel


class Part(NamedTuple):
    """The reduced fan's motions with one number of nodal diameters, m coordinates of a sector."""

    mass: np.ndarray  # (m, m), Hermitian
    stiffness: np.ndarray  # (m, m) at the design speed
    basis: np.ndarray  # (n, m) on the rows of the sector


def _reduced(wave, K, M, boundary, n_modes):
    """The Part of a sector by Craig-Bampton: boundary, then fixed-interface modes."""
    inside = np.setdiff1d(np.arange(K.shape[0]), boundary)
    inner = K[inside][:, inside]
    factor = factorised(inner)
    n_static = len(boundary)
    V = np.zeros((K.shape[0], n_static + n_modes), dtype=K.dtype)
    V[boundary, np.arange(n_static)] = 1.0
    V[inside, :n_static] = -factor.solve(K[inside][:, boundary].toarray())
    V[inside, n_static:] = lowest_modes(inner, M[inside][:, inside], n_modes, factor)[1]
    mass, stiffness = (V.conj().T @ (a @ V) for a in (M, K))
    return Part(_hermitian(mass), _hermitian(stiffness), wave @ V)


def reduce(
    sectors: list[NeutralModel], design: int, n_modes: int, n_followed: int
) -> tuple[list[Part], list[np.ndarray]]:
    """The fan at its design speed, and its stiffness at all speeds, by nodal diameters.

    sectors: free ones at several speeds, with the same rows and contact nodes; design: number of
    that at the design speed; n_modes: fixed-interface modes for each number of nodal diameters;
    n_followed: of these modes whose eigenvalues depend on the speed. Returns a Part for each number
    of nodal diameters, and its stiffness at all speeds, each (speeds, m, m).
    """
    models = [to_cylindrical(sector) for sector in sectors]
    contact = models[design].row[models[design].contact_node].ravel()
    parts, stiffness = [], []
    for diameters in range(models[0].n_sectors // 2 + 1):
        wave, K, M = wave_matrices(models[design], diameters, 0.0)
        # node by node, three directions: the one column of each row
        part = _reduced(wave, K, M, wave.indices[wave.indptr[contact]], n_modes)
        squares, shapes = lowest_modes(K, M, n_followed)
        followed = M @ shapes
        values, modes = eigh(part.stiffness, part.mass)
        momentum = part.mass @ modes[:, :n_followed]
        at_speeds = []
        for model in models:
            _, K, M = wave_matrices(model, diameters, 0.0)
            there, others = lowest_modes(K, M, 2 * n_followed)
            likeness = np.abs(followed.conj().T @ others)
            # of the other modes that each of ours is most like, no one twice
            found = there[linear_sum_assignment(likeness, maximize=True)[1]]
            change = values[:n_followed] * (found / squares - 1.0)
            at_speeds.append(part.stiffness + _hermitian((momentum * change) @ momentum.conj().T))
        parts.append(part)
        stiffness.append(np.array(at_speeds))
    return parts, stiffness


def _hermitian(a):
    return (a + a.conj().T) / 2


def whole(parts: list[np.ndarray], n_sectors: int) -> np.ndarray:
    """The real cyclic matrix (N, p, N, m) of its parts (p, m) by nodal diameters."""
    # block d is that between the rows of sector j + d and the columns of sector j
    blocks, n = np.zeros((n_sectors, *parts[0].shape)), np.arange(n_sectors)
    for diameters, part in enumerate(parts):
        twice = 1.0 if diameters in (0, n_sectors / 2) else 2.0
        turned = np.exp(2j * np.pi * diameters * n[:, None, None] / n_sectors) * part
        blocks += twice / n_sectors * turned.real
    return blocks[(n[:, None] - n) % n_sectors].transpose(0, 2, 1, 3)
