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
from hpcrub.model.imported.cyclic import wave
from hpcrub.model.imported.frames import to_cylindrical
from hpcrub.model.imported.neutral import NeutralModel


class Part(NamedTuple):
    """The reduced fan's motions with one number of nodal diameters, m coordinates of a sector."""

    mass: np.ndarray  # (m, m), Hermitian
    stiffness: np.ndarray  # (m, m) at the design speed
    basis: np.ndarray  # (n, m) on the rows of the sector


class Cyclic:
    """A free sector whose neighbours move alike, turned by one number of nodal diameters."""

    def __init__(self, model: NeutralModel, diameters: int):
        phases = wave(model, diameters)
        self.phases = phases.real if diameters in (0, model.n_sectors / 2) else phases
        self.K, self.M = (
            (self.phases.conj().T @ a @ self.phases).tocsc()
            for a in (model.stiffness[0], model.mass)
        )
        contact = model.row[model.contact_node]
        # node by node, three directions: the one column of each row
        self.boundary = self.phases.indices[self.phases.indptr[contact.ravel()]]

    def modes(self, n_modes: int) -> tuple[np.ndarray, np.ndarray]:
        """Lowest eigenvalues [rad2/s2] and mass-normalised modes."""
        return lowest_modes(self.K, self.M, n_modes)

    def reduced(self, n_modes: int) -> Part:
        """Craig-Bampton: contact nodes, then fixed-interface modes."""
        inside = np.setdiff1d(np.arange(self.K.shape[0]), self.boundary)
        inner = self.K[inside][:, inside]
        factor = factorised(inner)
        n_static = len(self.boundary)
        V = np.zeros((self.K.shape[0], n_static + n_modes), dtype=self.K.dtype)
        V[self.boundary, np.arange(n_static)] = 1.0
        V[inside, :n_static] = -factor.solve(self.K[inside][:, self.boundary].toarray())
        V[inside, n_static:] = lowest_modes(inner, self.M[inside][:, inside], n_modes, factor)[1]
        mass, stiffness = (V.conj().T @ (a @ V) for a in (self.M, self.K))
        return Part(_hermitian(mass), _hermitian(stiffness), self.phases @ V)


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
    parts, stiffness = [], []
    for diameters in range(models[0].n_sectors // 2 + 1):
        own = Cyclic(models[design], diameters)
        part = own.reduced(n_modes)
        squares, shapes = own.modes(n_followed)
        followed = own.M @ shapes
        values, modes = eigh(part.stiffness, part.mass)
        momentum = part.mass @ modes[:, :n_followed]
        at_speeds = []
        for model in models:
            there, others = Cyclic(model, diameters).modes(2 * n_followed)
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
