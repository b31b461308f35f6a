"""Modes of a tuned disk as a basis that all its mistuned samples share.

A tuned disk repeats itself from blade to blade: a mode with h nodal diameters moves corresponding
points of all blades b by E cos(2πhb/N) + O sin(2πhb/N). A blade that deviates adds forces of its
own. Its stiffness is a sum over *blade modes* j, K_b = Σ_j y_bj y_bjᵀ, so that a relative deviation
δ_b pushes by −δ_b y_bj(q) along each y_bj. All samples of a study then have the same modes, at
every speed, and differ by N numbers.

The reference disk of the modes is at least as stiff as any blade of a sample, δ_b ≤ 0, which keeps
the explicit forces of the deviations stable at every time step (`docs/theory.md` has the proof).
"""

from typing import Any, NamedTuple

import numpy as np
from scipy.linalg import eigh, eigvalsh

from hpcrub.model.aero import complex_modes
from hpcrub.model.casing_modes import NO_PAIRS
from hpcrub.model.families import multiplicity
from hpcrub.model.imported.cyclic import tuned_diameters
from hpcrub.model.interface import Interface, corresponding
from hpcrub.model.reduction import MOTIONS, Blades, Modes, ReducedModel, project

CYCLIC = 1e-4  # of the largest motion: what a mode may move with other nodal diameters
FAMILIES = 6  # families whose frequencies show whether enough of the blades' stiffness is kept
SMALLEST = 2e-5  # share of a strain energy below which a mode of a blade is left out
EXACT = 2e-6  # largest relative error of these frequencies in a mistuned disk
MIXED = 0.1  # cos 2φ below which two families, mixed by an angle φ, have one slope over the speed


class TunedBasis(NamedTuple):
    """Modes that the mistuned disks of a study share."""

    modes: Modes  # of the reference disk, by nodal diameters

    def modes_of(self, deviation: np.ndarray) -> Modes:
        """Modes of a sample; deviation: of each blade's stiffness, up to the reference (N,) [-].

        Raises ValueError: a blade is stiffer than the reference.
        """
        blades: Any = self.modes.blades
        change = np.asarray(deviation) - blades.reference
        if change.max() > 0.0:
            raise ValueError(f"a blade deviates by more than the reference, {blades.reference:g}")
        return self.modes._replace(blades=blades._replace(deviation=change))


def own_modes(modes: Modes) -> Modes:
    """Modes of the mistuned disk that modes of a basis stand for, at their speed, without air."""
    blades: Any = modes.blades
    y = blades.modes.reshape(-1, len(modes.omega))
    stiffness = y.T @ (np.repeat(blades.deviation, blades.modes.shape[1])[:, None] * y)
    np.einsum("ii->i", stiffness)[:] += modes.omega**2
    squared, vectors = eigh(stiffness)
    rows = {name: getattr(modes, name) @ vectors for name in (*MOTIONS, "shapes")}
    return modes._replace(
        omega=np.sqrt(np.maximum(squared, 0.0)),
        blades=None,
        waves=None,
        stiffening=np.zeros((0, 0)),
        **rows,
    )


def series(rows: np.ndarray, diameters: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Coefficients E and O (P, K) of corresponding rows (N, P, K) of modes with diameters (K,)."""
    power = np.fft.fft(rows, axis=0)[diameters, :, np.arange(rows.shape[2])].T
    power = power * (multiplicity(diameters, len(rows)) / len(rows))
    return power.real, -power.imag


def unfolded(even: np.ndarray, odd: np.ndarray, diameters: np.ndarray, n_blades: int) -> np.ndarray:
    """Corresponding rows of all blades (N, P, K) from their coefficients E and O (P, K)."""
    angle = 2.0 * np.pi / n_blades * np.outer(np.arange(n_blades), diameters)
    return even * np.cos(angle)[:, None] + odd * np.sin(angle)[:, None]


class _Waves(NamedTuple):
    """Modes in the order of their diameters, the two of a double mode after each other."""

    diameters: np.ndarray  # (K,) int
    n_blades: int

    @property
    def family(self) -> np.ndarray:
        """Family of every mode (K,) int, from 0."""
        each = multiplicity(self.diameters, self.n_blades)
        first = np.searchsorted(self.diameters, self.diameters)
        return (np.arange(len(self.diameters)) - first) // each

    @property
    def pairs(self) -> tuple[np.ndarray, np.ndarray]:
        """First and second members of all double modes (p,) int each."""
        first = np.arange(len(self.diameters)) - np.searchsorted(self.diameters, self.diameters)
        double = multiplicity(self.diameters, self.n_blades) == 2
        second = np.flatnonzero(double & (first % 2 == 1))
        return second - 1, second

    def signs(self, rows: np.ndarray) -> np.ndarray:
        """Signs (K,) by which the first member moves rows (N, P, K) as Re f e^{iφ}, the second Im.

        Any two orthogonal members of a double mode are such waves of some f, up to this sign.
        """
        (even, odd), (first, second) = series(rows, self.diameters), self.pairs
        size = even[:, first] * odd[:, second] - odd[:, first] * even[:, second]
        signs = np.ones(len(self.diameters))
        signs[second[size.sum(axis=0) < 0.0]] = -1.0
        return signs

    def cleaned(self, rows: np.ndarray) -> np.ndarray:
        """Rows (N, P, K) next to those given that repeat themselves exactly from blade to blade."""
        (even, odd), (first, second) = series(rows, self.diameters), self.pairs
        re = (even[:, first] + odd[:, second]) / 2.0
        im = (even[:, second] - odd[:, first]) / 2.0
        even[:, first], odd[:, first], even[:, second], odd[:, second] = re, -im, im, re
        return unfolded(even, odd, self.diameters, self.n_blades)

    def of_first_blade(self, rows: np.ndarray) -> np.ndarray:
        """Corresponding rows of all blades (N, P, K) from those of the first blade (P, K)."""
        even, odd, (first, second) = rows.copy(), np.zeros_like(rows), self.pairs
        odd[:, first], odd[:, second] = -rows[:, second], rows[:, first]
        return unfolded(even, odd, self.diameters, self.n_blades)


def tuned_basis(reduced: ReducedModel, reference: float) -> TunedBasis | None:
    """Basis of a disk in which every blade deviates by ``reference``, for all its samples.

    None where the disk does not repeat itself from blade to blade, as that of a file of a whole
    disk may not, or where its modes have no whole families.
    """
    face, diameters = reduced.interface, tuned_diameters(reduced)
    waves = _Waves(np.sort(diameters), face.n_blades)
    points, observed = corresponding(face.blade), corresponding(face.observed_blade)
    n_each = multiplicity(np.arange(face.n_blades // 2 + 1), face.n_blades)
    counts = np.bincount(diameters, minlength=len(n_each))
    are_whole = (counts * face.n_blades == n_each * counts.sum()).all()
    if points.size < len(face.blade) or observed.size < len(face.observed_blade) or not are_whole:
        return None
    order = np.argsort(diameters, kind="stable")
    motion = np.concatenate([rows @ reduced.tuned_modes for rows in (face.normal, face.tangential)])
    places = np.concatenate([points, points + len(face.normal)], axis=1)
    vectors = np.eye(len(order))[:, order]
    vectors = vectors * waves.signs((motion @ vectors)[places])
    own = project(reduced.modal_blade_stiffness[0], vectors)
    squared = reduced.tuned_eigenvalues[order]
    every = waves.of_first_blade(_blade_modes(own, squared, waves))
    squared, stiffer = _stiffer(squared, every, reference, waves.diameters)
    stiffer = stiffer * waves.signs((motion @ vectors @ stiffer)[places])
    vectors, every = vectors @ stiffer, every @ stiffer
    rows = _repeated(face, reduced.tuned_modes @ vectors, waves, points, observed)
    blades = Blades(
        waves.diameters, points, observed, every, _families(every[0], squared, waves),
        face.stress_blade, np.zeros(len(points)), reference,
    )  # fmt: skip
    return None if rows is None else TunedBasis(_modes(reduced, vectors, squared, blades, rows))


def _modes(
    reduced: ReducedModel, vectors: np.ndarray, squared: np.ndarray, blades: Blades, rows: Any
) -> Modes:
    """Modes (m, K) on the tuned ones with ω² (K,), which blades and rows are of."""
    # such that the tuned modes, of which the rows of `vectors` are, have the slopes of their shapes
    slopes = [np.linalg.lstsq(vectors**2, np.diag(k), rcond=MIXED)[0] for k in reduced.stiffening]
    stiffening, air = np.array(slopes).reshape(-1, len(squared)), reduced.air
    return Modes(
        omega=np.sqrt(squared),
        shapes=reduced.tuned_modes @ vectors,
        speed=reduced.speed,
        stiffening=stiffening,
        pairs=reduced.casing.seen_from(reduced.interface.angle) if reduced.casing else NO_PAIRS,
        waves=air and complex_modes(air, vectors, squared, stiffening, blades.diameters),
        blades=blades,
        **rows,
    )


def _families(first: np.ndarray, squared: np.ndarray, waves: _Waves) -> np.ndarray:
    """Whether a mode of the disk (K,) is of the family that moves blade mode j most (J, K)."""
    energy, family = first**2 / squared, waves.family
    of_families = np.stack([energy[:, family == f].sum(axis=1) for f in range(family.max() + 1)])
    return family == of_families.argmax(axis=0)[:, None]


def _stiffer(
    squared: np.ndarray, every: np.ndarray, reference: float, diameters: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """ω² (K,) [rad²/s²] of a disk with stiffer blades, and its modes on the tuned ones (K, K).

    every: `Blades.modes`. Modes that these do not move stay as they are.
    """
    result, vectors = squared.copy(), np.eye(len(squared))
    moved = np.abs(every[0]).max(axis=0, initial=0.0) > 0.0
    for h in range(diameters.max() + 1):
        mine = np.flatnonzero((diameters == h) & moved)
        if len(mine):
            y = every[:, :, mine].reshape(-1, len(mine))
            found = eigh(np.diag(squared[mine]) + reference * y.T @ y)
            result[mine], vectors[np.ix_(mine, mine)] = found
    return result, vectors


def _repeated(
    face: Interface, shapes: np.ndarray, waves: _Waves, points: np.ndarray, observed: np.ndarray
) -> dict[str, np.ndarray] | None:
    """Rows of `Modes` that repeat themselves from blade to blade; None where a disk does not."""
    bent = np.arange(len(face.bent)).reshape(len(points), -1)
    places = dict.fromkeys(MOTIONS, points) | {"observed": observed, "bent": bent}
    rows = {}
    for name, place in (places | {"stress": corresponding(face.stress_blade)}).items():
        if not len(known := getattr(face, name)):
            rows[name] = np.zeros((0, shapes.shape[1]))
            continue
        if place.size < len(known):
            return None
        seen = (known @ shapes)[place]
        clean = waves.cleaned(seen)
        if np.abs(clean - seen).max() > CYCLIC * np.abs(seen).max():
            return None
        rows[name] = np.empty((len(known), shapes.shape[1]))
        rows[name][place.ravel()] = clean.reshape(len(known), -1)
    return rows


def _blade_modes(own: np.ndarray, squared: np.ndarray, waves: _Waves) -> np.ndarray:
    """Modes y of the first blade (J, K), on as few families as keep the frequencies EXACT.

    own: stiffness of the blade in the modes (K, K); squared: ω² of the modes (K,) [rad²/s²].
    """
    family, n_blades = waves.family, waves.n_blades
    pattern = -0.05 * ((7 * np.arange(n_blades)) % n_blades) / n_blades  # any that breaks symmetry

    def frequencies(rows: np.ndarray) -> np.ndarray:
        every = waves.of_first_blade(rows)
        change = np.einsum("b,bjk,bjl->kl", pattern, every, every, optimize=True)
        n = min(FAMILIES * n_blades, len(squared)) - 1
        return np.sqrt(eigvalsh(np.diag(squared) + change, subset_by_index=[0, n]))

    exact, n_all = frequencies(_factors(own, squared, 0.0)), family.max() + 1
    for n_families in range(min(FAMILIES, n_all), n_all + 1):
        low = family < n_families
        found = _factors(own[np.ix_(low, low)], squared[low], SMALLEST)
        rows = np.zeros((len(found), len(squared)))
        rows[:, low] = found
        if np.abs(frequencies(rows) / exact - 1.0).max() < EXACT:
            break
    return rows


def _factors(own: np.ndarray, squared: np.ndarray, least: float) -> np.ndarray:
    """Rows y (J, K) with Σ y yᵀ = own, each as near as possible to a mode of its own frequency.

    least: share of the strain energy below which a row is left out.
    """
    omega = np.sqrt(squared)
    share, vectors = eigh(own / np.outer(omega, omega))
    kept = share > max(least, 1e-14)
    y = (vectors[:, kept] * np.sqrt(share[kept])).T
    _, turned = eigh((y / squared) @ y.T)  # by ω⁻², of which modes of a blade have different ones
    return turned.T[::-1] @ y * omega
