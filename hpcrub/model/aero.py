"""Air between the blades: damping of every wave of a family of blades, and complex modes.

In wave r = 0 … N−1 of a tuned family blade j moves as e^{i(ωt − 2πrj/N)}: wave r travels with the
rotation, wave N − r against it. Let ψ_r be the waves of the tuned disk, ζ_r their damping ratios,
δ_r their frequency shifts and λ_r = ω_r (−ζ_r + i (1 + δ_r)) the eigenvalues that follow. Then

    D = Σ_r d_r Mψ_r ψ_rᴴM,    d_r = −(λ_r + λ̄_{N−r}),
    K = Σ_r k_r Mψ_r ψ_rᴴM,    k_r = λ_r λ̄_{N−r},

are real matrices of damping and stiffness with exactly these eigenvalues, at every speed with the
ω_r of that speed. On a mistuned disk the N modes of the family become N complex modes (`Waves`);
all others stay, and the antisymmetric part of K is in proportion to the frequency of each blade, as
the forces of D are. `docs/theory.md` says more.

Crawley, in AGARD-AG-298 vol. 1 (1987), derives influence coefficients and waves; Kaza and Kielb,
AIAA J. 20 (1982), show the effect of mistuning.
"""

from typing import Any, NamedTuple

import numpy as np

from hpcrub.model.damping import state_matrix
from hpcrub.model.families import multiplicity

CYCLIC = 1e-3  # tolerance with which waves of a tuned disk repeat themselves from blade to blade


class Curve(NamedTuple):
    """Damping and frequency of the waves of a family: r with the rotation, N − r against it."""

    family: int  # number of the family, from 0
    damping_ratio: np.ndarray  # ζ_r (N,), structure and air together [-]
    frequency_shift: np.ndarray  # δ_r (N,) [-]


class Air(NamedTuple):
    """Air forces on a family of the tuned disk, W the speed of rotation."""

    waves: np.ndarray  # ψ_r on the tuned modes, in columns, orthonormal (m, N) complex
    squared: np.ndarray  # ω_r² at the speed of the tuned modes (N,) [rad²/s²]
    stiffening: np.ndarray  # its slopes over W² and W⁴ (0 or 2, N)
    damping: np.ndarray  # d_r/ω_r (N,) complex [-]
    stiffness: np.ndarray  # k_r/ω_r² − 1 (N,) complex [-]

    def at(self, change: np.ndarray) -> "Air":
        """The same forces at another speed; change: of W² and W⁴ (2,)."""
        if not len(self.stiffening):
            return self
        return self._replace(squared=self.squared + change @ self.stiffening)


class Waves(NamedTuple):
    """Complex modes z' = λ z + l f of a disk in air, in the place of N of its real modes."""

    rows: np.ndarray  # indices of the replaced real modes (N,) int
    eigenvalue: np.ndarray  # λ, by increasing frequency (N,) [1/s]
    right: np.ndarray  # matrix to coordinates of the replaced modes, q = Re(right z) (N, N)
    left: np.ndarray  # matrix from positions and velocities, z = left [q, q'] (N, 2N)
    slopes: np.ndarray  # slopes of ω²/ω² of the disk alone over W² and W⁴ (0 or 2, N)
    damping: np.ndarray  # D on the replaced modes (N, N) [1/s]
    stiffness: np.ndarray  # K on the replaced modes, less their ω² (N, N) [rad²/s²]

    def motion(self, displacement: np.ndarray) -> np.ndarray:
        """Displacements per unit Re z and Im z (..., 2N), from those per coordinate (..., K)."""
        return (displacement[..., self.rows] @ self.right).conj().view(float)

    def force(self, displacement: np.ndarray) -> np.ndarray:
        """Re z' and Im z' (..., 2N) that unit forces along displacements (..., K) add, times Im λ.

        These do not depend on the speed.
        """
        return (displacement[..., self.rows] @ self.pushed.T).view(float)

    @property
    def pushed(self) -> np.ndarray:
        """Im λ times z' by unit forces on the replaced modes (N, N), the same at every speed."""
        return self.eigenvalue.imag[:, None] * self.left[:, len(self.rows) :]

    def growth(self, change: np.ndarray) -> np.ndarray:
        """Factor of all λ at other speeds (..., N); change: of W² and W⁴ (..., 2).

        It is that of the disk's own ω: damping ratio and frequency shift stay as they are.
        """
        if not len(self.slopes):
            return np.ones((*change.shape[:-1], len(self.rows)))
        return np.sqrt(np.maximum(1.0 + change @ self.slopes, 0.0))

    def at(self, change: np.ndarray) -> "Waves":
        """Complex modes at another speed, with the shapes of this one; change: (2,)."""
        n, growth = len(self.rows), self.growth(change)
        left = np.hstack([self.left[:, :n], self.left[:, n:] / growth[:, None]])
        return self._replace(eigenvalue=growth * self.eigenvalue, left=left)

    def coordinates(self, parts: np.ndarray) -> np.ndarray:
        """Real modal coordinates (..., N) from alternating Re z and Im z (..., 2N)."""
        z = parts[..., 0::2] + 1j * parts[..., 1::2]
        return (z @ self.right.T).real

    def parts(self, position: np.ndarray, velocity: np.ndarray) -> np.ndarray:
        """Alternating Re z and Im z (..., 2N), from modal coordinates and velocities (..., N)."""
        return (np.concatenate([position, velocity], axis=-1) @ self.left.T).view(float)

    @property
    def damping_ratio(self) -> np.ndarray:
        """−Re λ/|λ| of every complex mode (N,); a mode with a negative one flutters."""
        return -self.eigenvalue.real / np.abs(self.eigenvalue)


def of_influence(
    n_blades: int, distance: np.ndarray, damping: np.ndarray, shift: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Damping ratios and frequency shifts of all waves from influence coefficients.

    distance: to the blade that moves, positive in the direction of rotation (k,) int; damping,
    shift: what its motion adds to a blade's own, δ + iζ (k,).
    Returns ζ_r and δ_r (N,), the sums of (δ + iζ)_k e^{−2πi r k/N}.
    """
    r = np.arange(n_blades)[:, None]
    waves = np.exp(-2j * np.pi * r * distance / n_blades) @ (shift + 1j * damping)
    return waves.imag, waves.real


def largest_amplification(decay: np.ndarray, tips: np.ndarray, diameters: int) -> float:
    """Whitehead's limit of the linear amplification of velocities in a family of blades [-].

    decay: rates of all waves (N,), positive [1/s]; tips: displacements of observed points in the
    mass-normalised waves (O, N); diameters: nodal diameters of the load, forward.
    Source: Whitehead, J. Mech. Eng. Sci. 8 (1966), for equal waves; `docs/theory.md` derives it.
    """
    own, size = diameters % len(decay), np.abs(tips)
    reach = np.sqrt(decay[own] * (size**2 / decay).sum(axis=1))
    return float((0.5 * (size[:, own] + reach)).max() / size[:, own].max())


def eigenvalues(omega: np.ndarray, curve: Curve) -> np.ndarray:
    """Eigenvalues λ_r (N,) [1/s] that a curve asks of waves with frequencies (N,) [rad/s]."""
    return omega * (-curve.damping_ratio + 1j * (1.0 + curve.frequency_shift))


def coefficients(wanted: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Coefficients d_r [1/s] and k_r [rad²/s²] that give waves the eigenvalues λ_r (N,)."""
    opposite = np.roll(wanted[::-1], 1).conj()  # λ̄ of N − r
    return -(wanted + opposite), wanted * opposite


def family_columns(diameters: np.ndarray, family: int, n_blades: int) -> np.ndarray:
    """Tuned modes (N,) int of a family, from 0; diameters: (m,) of all tuned modes.

    Raises ValueError: if the model lacks modes of the family.
    """
    columns: list[int] = []
    for h in range(n_blades // 2 + 1):
        each = multiplicity(h, n_blades)
        mine = np.flatnonzero(diameters == h)[family * each : (family + 1) * each]
        if len(mine) < each:
            raise ValueError(f"the reduced model has no family {family + 1} of {h} nodal diameters")
        columns += mine.tolist()
    return np.sort(columns)


def air_of(curve: Curve, squared: np.ndarray, diameters: np.ndarray, blades: np.ndarray) -> Air:
    """Air forces on the tuned disk, with waves on the modes given and without stiffening.

    squared, diameters: ω² of the tuned modes (m,) [rad²/s²], and their nodal diameters [-].
    blades: displacements (p, N, m) of p like points of all blades, in the direction of rotation.
    Raises ValueError: if the model lacks the family, or does not repeat itself from blade to blade.
    """
    n_blades, n_modes = blades.shape[1:]
    columns = family_columns(diameters, curve.family, n_blades)
    here = blades[:, :, columns]
    following = np.roll(here, -1, axis=1)
    shift = np.linalg.lstsq(here.reshape(-1, n_blades), following.reshape(-1, n_blades))[0]
    turns, waves = np.linalg.eig(shift)  # factor e^{−2πi r/N} of the following blade
    r = -np.angle(turns) * n_blades / (2.0 * np.pi)
    wave = np.round(r) % n_blades
    order = np.argsort(wave)
    if np.abs(r - np.round(r)).max() > CYCLIC * n_blades or len(set(wave)) < n_blades:
        raise ValueError("the tuned disk does not repeat itself from blade to blade")
    on_all = np.zeros((n_modes, n_blades), dtype=complex)
    on_all[columns] = waves[:, order] / np.linalg.norm(waves[:, order], axis=0)
    own = np.einsum("kr,k,kr->r", on_all.conj(), squared, on_all).real
    damping, stiffness = coefficients(eigenvalues(np.ones(n_blades), curve))
    return Air(on_all, own, np.zeros((0, n_blades)), damping, stiffness - 1.0)


def complex_modes(
    air: Air,
    vectors: np.ndarray,
    squared: np.ndarray,
    stiffening: np.ndarray,
    diameters: np.ndarray | None = None,
) -> Waves:
    """Complex modes of a mistuned disk in the subspace of the family, all of one speed.

    - vectors: real modes of this disk on the tuned modes (m, K).
    - squared: their ω² (K,) [rad²/s²].
    - stiffening: slopes of ω² over W² and W⁴ (0 or 2, K).
    - diameters: numbers of nodal diameters of the real modes (K,), in their order, where each
      complex mode shall have one; None: the blades are not alike.
    """
    n = air.waves.shape[1]
    part = vectors.T @ air.waves
    rows = np.sort(np.argsort((np.abs(part) ** 2).sum(axis=1))[-n:])
    seen, own, omega = part[rows], squared[rows], np.sqrt(air.squared)

    def matrix(values: Any) -> Any:
        return ((seen * values) @ seen.conj().T).real

    # at the frequency of a blade circulation has the size that it has to damping in a tuned wave
    blades = own if diameters is None else (np.abs(seen) ** 2) @ air.squared
    root = blades**0.25
    circulation = np.outer(root, root) * matrix(1j * air.stiffness.imag * omega)
    damping, stiffness = matrix(air.damping * omega), matrix(air.stiffness.real * air.squared)
    stiffness += circulation
    values, right, left = (np.zeros(shape, complex) for shape in (n, (n, n), (n, 2 * n)))
    one = np.zeros(n) if diameters is None else diameters[rows]
    for mine in np.split(np.arange(n), np.flatnonzero(np.diff(one)) + 1):
        block = np.ix_(mine, mine)
        found = eigen(damping[block], (stiffness + np.diag(own))[block])
        values[mine], right[block] = found[:2]
        left[np.ix_(mine, np.append(mine, n + mine))] = found[2]
    scale = np.einsum("nk,k,kn->n", left[:, n:], own, right)
    slopes = np.einsum("nk,sk,kn->sn", left[:, n:], stiffening[:, rows], right)
    return Waves(rows, values, right, left, (slopes / scale).real, damping, stiffness)


def eigen(damping: np.ndarray, stiffness: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Complex modes of q'' + D q' + K q = f, matrices (N, N), with no mode overdamped.

    Returns λ of positive frequency (N,), right (N, N) and left (N, 2N), as in `Waves`.
    """
    n = len(damping)
    scale = np.sqrt(np.abs(stiffness).max())  # a frequency that balances the blocks
    values, vectors = np.linalg.eig(state_matrix(damping, stiffness, scale))
    left = np.linalg.inv(vectors)
    left[:, n:] /= scale
    forward = np.flatnonzero(values.imag > 0.0)
    forward = forward[np.argsort(values[forward].imag)]
    return scale * values[forward], 2.0 * vectors[:n, forward], left[forward]
