"""Choice of modes by whole families: all nodal diameters of each, and no double mode split.

The lowest modes of all would keep some diameters of a family and leave out others. The reduced disk
would then be stiffer for some travelling waves than for others, a coupling of the blades that the
full disk does not have.
"""

from typing import Any

import numpy as np
from scipy.linalg import LinAlgError, eigh

CLOSE = 1e-6  # relative difference of eigenvalues whose modes an eigensolver may mix


def whole(n_modes: int, n_blades: int) -> int:
    """Number of modes in whole families: ``n_modes``, up to the next multiple of the blades."""
    return -(-n_modes // n_blades) * n_blades


def multiplicity(diameters: Any, n_blades: int) -> Any:
    """Modes of a family at a nodal diameter: two waves, one each way; one at 0 and N/2."""
    return np.where(2 * np.asarray(diameters) % n_blades == 0, 1, 2)


def choose(
    values: np.ndarray, sectors: np.ndarray, n_families: int, are_all: bool = False
) -> np.ndarray | None:
    """Combinations of modes that form the lowest families.

    values: (K,) eigenvalues of the lowest modes, increasing.
    sectors: (N, p, K) displacements of p like points of N sectors, in frames that turn with them.
    are_all: whether the last modes count; else a mode that is not given might be their double.
    Returns (K, n_families N), orthonormal, by increasing eigenvalue; None if the modes are too few.
    """
    n, n_modes = len(sectors), len(values)
    power = np.fft.fft(sectors, axis=0)
    left = n_families * multiplicity(np.arange(n // 2 + 1), n)
    chosen = []
    starts = np.flatnonzero(np.diff(values, prepend=-np.inf) > CLOSE * np.abs(values))
    for first, end in zip(starts, [*starts[1:], n_modes if are_all else 0], strict=True):
        if not end:
            break
        mixed, diameters = _separated(power[:, :, first:end])
        kept = []
        for column, h in enumerate(diameters):
            if left[h]:
                left[h] -= 1
                kept.append(column)
        part = np.zeros((n_modes, len(kept)))
        part[first:end] = np.eye(end - first) if len(kept) == end - first else mixed[:, kept]
        chosen.append(part)
        if not left.any():
            return np.hstack(chosen)
    return None


def _separated(power: Any) -> tuple[Any, Any]:
    """Orthogonal combinations (c, c) of modes, each of one nodal diameter, and the diameters (c,).

    power: (N, p, c) Fourier coefficients of the modes over the sectors.
    """
    n = len(power)
    parts = np.einsum("hpi,hpj->hij", power.conj(), power).real
    h = np.minimum(np.arange(n), n - np.arange(n))
    try:
        _, mixed = eigh(np.tensordot(h, parts, axes=1), parts.sum(axis=0))
    except LinAlgError:  # points that do not move
        mixed = np.eye(power.shape[2])
    mixed, _ = np.linalg.qr(mixed)
    size = np.einsum("hij,ia,ja->ha", parts, mixed, mixed)
    folded = np.zeros((n // 2 + 1, size.shape[1]))
    np.add.at(folded, h, size)
    return mixed, folded.argmax(axis=0)


def share(reduced: Any) -> float:
    """Blades' share of the stiffness in the first family of a ReducedModel [-]."""
    n = len(reduced.modal_blade_stiffness)
    stiffness = reduced.modal_blade_stiffness.sum(axis=0).diagonal()[:n]
    return float(np.mean(stiffness / reduced.tuned_eigenvalues[:n]))


def sentence(
    full_hz: np.ndarray, reduced_hz: np.ndarray, share: float, half_range: float, damping: float
) -> str:
    """Say in words whether coupling, mistuning or damping rules the first family.

    full_hz, reduced_hz: (N,) frequencies of the tuned disk, full and reduced; one may be (0,) [Hz].
    share: result of `share`; half_range: largest deviation of a blade [-]; damping: ratio [-].
    """
    known = {"full": full_hz, "reduced": reduced_hz}
    spreads = {name: np.ptp(hz) / hz.mean() for name, hz in known.items() if len(hz)}
    coupled = ", ".join(f"{100 * spread:.3g} % {name}" for name, spread in spreads.items())
    *_, coupling = spreads.values()
    widths = {"coupling": coupling, "mistuning": half_range * share, "damping": 2 * damping}
    return (
        f"first family: coupling spreads it by {coupled}; blades of ±{100 * half_range:g} % "
        f"stiffness by {100 * widths['mistuning']:.3g} %; resonances are {200 * damping:.3g} % "
        f"wide: {max(widths, key=widths.__getitem__)} rules"
    )
