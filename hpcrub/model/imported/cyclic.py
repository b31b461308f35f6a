"""Natural frequencies by nodal diameter, of one sector, of a whole disk or of a reduced model.

`between_speeds` tests whether matrices at three speeds describe the stiffness between them.
"""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import scipy.sparse as sp
from scipy.linalg import eigh, eigvalsh

from hpcrub.model.families import multiplicity
from hpcrub.model.imported.assembly import assemble, disk_rows
from hpcrub.model.imported.checks import check_frequency
from hpcrub.model.imported.craig_bampton import factorised, frequencies, lowest_modes
from hpcrub.model.imported.frames import node_angle, to_cylindrical
from hpcrub.model.imported.neutral import NeutralModel, contact_rows, stiffness_at
from hpcrub.model.interface import Interface, corresponding
from hpcrub.model.reduction import Modes, ReducedModel

MODES_PER_DIAMETER = 3
MODES_OF_DISK = 4  # modes of a whole disk per blade
DEPENDENT = 1e-12  # smallest eigenvalue over the largest of a basis whose columns are independent


def sector_frequencies(
    model: NeutralModel, n_diameters: int, n_modes: int, speed: float = 0.0
) -> np.ndarray:
    """Frequencies of the modes with n_diameters nodal diameters, from one sector.

    model: of kind "sector"; speed: of rotation [rad/s].
    n_diameters: the next sector's displacements have a factor e^{2 pi i n_diameters / n_sectors}.
    Returns (n_modes,) [Hz]; double frequencies appear once.
    """
    _, K, M = wave_matrices(to_cylindrical(model), n_diameters, speed)
    values, _ = lowest_modes(K, M, n_modes)
    return np.sqrt(np.maximum(values, 0.0)) / (2 * np.pi)


def wave_matrices(
    model: NeutralModel, n_diameters: int, speed: float
) -> tuple[sp.csr_array, sp.csc_array, sp.csc_array]:
    """Basis of a sector's motions with n_diameters (`wave`), and K and M projected on it."""
    P = wave(model, n_diameters)
    K, M = (
        (P.conj().T @ matrix @ P).tocsc()
        for matrix in (stiffness_at(model.stiffness, speed), model.mass)
    )
    if n_diameters in (0, model.n_sectors / 2):
        K, M = K.real.copy(), M.real.copy()
    return P, K, M


def wave(model: NeutralModel, n_diameters: int) -> sp.csr_array:
    """Matrix from free own rows of a cylindrical sector to all rows, in a motion of n_diameters."""
    rows, own = disk_rows(model)
    rows, n_own = rows[0], len(own)
    turn = np.exp(2j * np.pi * n_diameters / model.n_sectors)
    phase = np.where(rows < n_own, 1.0, turn)
    free = np.setdiff1d(np.arange(n_own), rows[model.fixed] % n_own)
    P = sp.csr_array((phase, (np.arange(len(rows)), rows % n_own)), shape=(len(rows), n_own))
    return P[:, free]


def pencils(model: NeutralModel, speeds: Sequence[float]) -> Iterator[tuple[list, np.ndarray]]:
    """Stiffness and mass of each number of nodal diameters, on its lowest modes at some speeds.

    Their natural frequencies are exact at these speeds [rad/s], and nearly so between them.
    Yields [K0, K1, ...], each (k, k), and the mass (k, k), for 0, 1, ... nodal diameters.
    """
    is_sector = model.kind == "sector"
    model = to_cylindrical(model) if is_sector else assemble(model)
    modes = _sector_modes if is_sector else _disk_modes
    for columns in zip(*(modes(model, speed) for speed in speeds), strict=True):
        V = np.hstack(columns)
        M = V.conj().T @ (model.mass @ V)
        values, vectors = np.linalg.eigh(M)
        T = vectors[:, values >= DEPENDENT * values.max(initial=0.0)]
        small = [T.conj().T @ (V.conj().T @ (K @ V)) @ T for K in model.stiffness]
        yield small, T.conj().T @ M @ T


def _sector_modes(model: Any, speed: Any) -> Iterator[Any]:
    """Yield the lowest modes of 0, 1, ... nodal diameters, on all rows of a cylindrical sector."""
    for diameters in range(model.n_blades // 2 + 1):
        P, K, M = wave_matrices(model, diameters, speed)
        yield P @ lowest_modes(K, M, MODES_PER_DIAMETER)[1]


def _disk_modes(model: Any, speed: Any) -> Iterator[Any]:
    """Yield the lowest modes of a whole disk with 0, 1, ... nodal diameters."""
    n_modes = MODES_OF_DISK * model.n_blades
    K, M = stiffness_at(model.stiffness, speed), model.mass
    if model.kind == "disk":
        _, vectors = lowest_modes(K.tocsc(), M.tocsc(), min(n_modes, M.shape[0]))
    else:
        vectors = eigh(K, M)[1][:, :n_modes]
    angle = node_angle(model.nodes[model.contact_node])
    diameters = diameters_of(vectors[contact_rows(model)], model.contact_blade, angle)
    for h in range(model.n_blades // 2 + 1):
        n_kept = multiplicity(h, model.n_blades) * MODES_PER_DIAMETER
        yield vectors[:, diameters == h][:, :n_kept]


def frequencies_by_diameter(model: NeutralModel, speed: float) -> np.ndarray:
    """First frequencies of each number of nodal diameters (H, MODES_PER_DIAMETER) [Hz].

    speed: of rotation [rad/s]. NaN where fewer frequencies are known.
    Raises InputError when no disk can have the lowest frequency.
    """
    table = np.full((model.n_blades // 2 + 1, MODES_PER_DIAMETER), np.nan)
    for h, (K, M) in enumerate(pencils(model, [speed])):
        values = eigvalsh(stiffness_at(K, speed), M)
        each = 1 if model.kind == "sector" else multiplicity(h, model.n_blades)
        mine = values[::each][:MODES_PER_DIAMETER]
        table[h, : len(mine)] = np.sqrt(np.maximum(mine, 0.0)) / (2 * np.pi)
    radius = np.hypot(*model.nodes[model.contact_node, :2].T).max()
    check_frequency(float(np.nanmin(table)), float(radius))
    return table


def friction_lift(model: NeutralModel, speed: float = 0.0) -> float:
    """Outward over backward displacement of the tips under equal friction forces on all tips [-].

    Positive: friction presses the tips against the casing. speed: of rotation [rad/s].
    """
    model = to_cylindrical(model)
    n = len(model.dof)
    if model.kind == "sector":
        P = wave(model, 0).real
    else:
        P = sp.eye_array(n, format="csr")[:, np.setdiff1d(np.arange(n), model.fixed)]
    rows = model.row[model.contact_node]
    K = sp.csr_array(stiffness_at(model.stiffness, speed))
    back = np.zeros(n)
    back[rows[:, 1]] = -1.0
    u = P @ factorised(P.T @ K @ P).solve(P.T @ back)
    parts = u[np.maximum(rows, 0)] * (rows >= 0)
    return float((parts * model.contact_normal).sum() / np.abs(parts[:, 1]).sum())


def nodal_diameters(shapes: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Nodal diameters of every mode from displacements of corresponding points of all blades.

    shapes: (p, N, K) p displacements of N blades in K modes; angle: (N,) [rad]. Returns (K,) int.
    """
    n_blades = len(angle)
    orders = np.arange(n_blades // 2 + 1)
    wave = np.exp(-1j * orders[:, None] * angle)  # (orders, N)
    size = (np.abs(np.einsum("hn,pnk->hpk", wave, shapes)) ** 2).sum(axis=1)
    return (size * multiplicity(orders, n_blades)[:, None]).argmax(axis=0)


def diameters_of(shapes: np.ndarray, blade: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Nodal diameters of every mode (K,) int from displacements of all contact points."""
    return nodal_diameters(*of_blades(shapes, blade, angle))


def of_blades(
    shapes: np.ndarray, blade: np.ndarray, angle: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Displacements of corresponding points of all blades, and the angles of the blades.

    shapes: (p, C, K) p displacements of each of C points in K modes; blade, angle: (C,) [rad] of
        each point. Points of two blades correspond when they have the same place in their order.
    Returns (q, N, K) and (N,) [rad].
    """
    points = corresponding(blade)
    like = shapes[:, points].transpose(0, 2, 1, 3).reshape(-1, *points.T.shape[1:], shapes.shape[2])
    return like, angle[points[:, 0]]


def tips(modes: Modes, face: Interface) -> tuple[np.ndarray, np.ndarray]:
    """Motion of corresponding contact points in modes, as `of_blades` returns it."""
    rows = [part for part in (modes.normal, modes.tangential, modes.axial) if len(part)]
    return of_blades(np.array(rows), face.blade, face.angle)


def tuned_diameters(reduced: ReducedModel) -> np.ndarray:
    """Nodal diameters of the tuned modes (m,) int, from the motion of the contact points."""
    face = reduced.interface
    rows = [part for part in (face.normal, face.tangential, face.axial) if len(part)]
    return diameters_of(np.array(rows) @ reduced.tuned_modes, face.blade, face.angle)


def between_speeds(model: NeutralModel, speeds: np.ndarray) -> tuple[float, np.ndarray]:
    """Look at the first frequency at, and half-way between, the speeds of a model's matrices.

    Rotation changes the square of a frequency smoothly with the square of the speed. Where blades
    turn by degrees, the entries of the matrices change less smoothly: a parabola through each entry
    then describes no real blade. The parabola through the squares of the frequencies judges it.

    model: of kind "sector" or "disk", with stiffness fitted through three speeds.
    speeds: (3,) of the matrices, one of them 0 [rad/s].
    Returns the larger relative error of the frequency half-way between two speeds; the rises (2,)
    of its square between them, as shares of that of the speed.
    """
    square = np.sort(speeds) ** 2
    middles = (square[1:] + square[:-1]) / 2
    places = np.sqrt(np.concatenate([square, middles]))
    if model.kind == "sector":
        first = [sector_frequencies(model, model.n_sectors // 2, 1, s)[0] for s in places]
    else:
        disk = assemble(model)
        first = [frequencies(disk, 1, s)[0] for s in places]
    parabola = np.polyfit(square / square[-1], np.square(first[:3]), 2)
    errors = np.array(first[3:]) / np.sqrt(np.polyval(parabola, middles / square[-1])) - 1.0
    rises = np.diff(np.square(np.multiply(2 * np.pi, first[:3]))) / np.diff(square)
    return float(errors[np.abs(errors).argmax()]), rises
