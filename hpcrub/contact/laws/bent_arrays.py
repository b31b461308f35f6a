"""Arrays of the kinematics to second order (`bent`), and the coefficients that they are made of."""

from itertools import combinations_with_replacement, permutations
from typing import Any, NamedTuple

import numpy as np


class BentArrays(NamedTuple):
    """Arrays for C contact points (padded), N blades with p bent modes, L lanes.

    M = p (p + 1)/2 products of two bent modes are in the order of `numpy.triu_indices`. Where the
    fourth order of the energy is known, T = M (p + 2)/3 products of three follow, else T = 0.
    """

    along: np.ndarray  # u_t (C, L) [m] (modified)
    bent: np.ndarray  # s of all blades (≥ N·p, L) [m·√kg] (modified)
    # s_a s_c, then s_a s_c s_d of all blades (N·(M + T), L) [m²·kg, m³·kg^1.5] (modified)
    products: np.ndarray
    raised: np.ndarray  # what the casing is higher at the displaced point (C, L) [m] (modified)
    slope: np.ndarray  # b′/R under it, of bumps of full height (C, L) [-] (modified)
    tilt: np.ndarray  # t (C, L) [-] (modified)
    # ṡ, then s¨ of q bent modes of a blade, then ½ (s_a s_c)¨ (2·q + q (q + 1)/2, L) (modified)
    moving: np.ndarray
    seen: np.ndarray  # −(G_n + t G_t) s of every point (C·p, L) [1/√kg] (modified)
    pushed: np.ndarray  # −Σ f_d G_d s of every point, f of N = 1 (C·p, L) [1/√kg] (modified)
    # motion of the point in place i of a blade by a force on that in place j: row
    # ((j·P + i)·(2 + p) + o)·(3 + p) + f from ``begin`` on, where o is the normal, tangential
    # motion and s, and f the normal, tangential, axial force and the push of a bent mode
    own: np.ndarray
    begin: (
        np.ndarray
    )  # first row of every point's blade in ``own``, which blades may share (C,) int
    place: np.ndarray  # place of every point on its blade (C,) int
    n_places: int  # P, most points of a blade
    shortening: np.ndarray  # G_n, G_t, G_a of every point (C, 3·p·p) [1/(m·kg)]
    # what each product adds to normal and tangential displacements of a point (C, 2·M) [1/(m·kg)]
    displacement: np.ndarray
    # force of each product on every bent mode (M + T, p) [1/(m·√kg·s²), then 1/(m²·kg·s²)]
    force: np.ndarray
    n_bent: int  # p
    inertia: np.ndarray  # J of each two of q bent modes by each product of two (m, m) [1/(m²·kg)]
    squares: np.ndarray  # ω² of q bent modes alone (q,) [rad²/s²]
    step: np.ndarray  # 1/h, then h/2 (2, L) [1/s, s]
    observed: np.ndarray  # what each product adds to an observed displacement (O, M) [1/(m·kg)]
    observed_blade: np.ndarray  # blade of every observed displacement (O,) int
    curvature: np.ndarray  # κ (C,) [1/m]
    steps: np.ndarray  # time steps in which the disk turns by a metre at the point (C,) [1/m]
    # largest height of the casing at most ``reach`` steps from every step, like `Scheme.bump`
    crest: np.ndarray
    reach: int
    highest: float  # largest height of the casing [m]


def places(blade: np.ndarray, counts: np.ndarray) -> np.ndarray:
    """Place of every point on its blade; blade: of the points (n,); counts: of the blades (N,)."""
    order, first = np.argsort(blade, kind="stable"), np.cumsum(counts) - counts
    return (np.arange(len(blade)) - first[blade[order]])[np.argsort(order)]


def folded(G: np.ndarray) -> np.ndarray:
    """Coefficients (..., M) of the products s_a s_c, a ≤ c, in −½ sᵀG s; G: (..., p, p)."""
    a, c = np.triu_indices(G.shape[-1])
    return -np.where(a == c, 0.5, 1.0) * G[..., a, c]


def forces_of_products(second: Any) -> np.ndarray:
    """Force of each product on every bent mode (M + T, p); second: a SecondOrder.

    Each product of three stands once, with all its orders in −⅙ Σ D_abcd s_b s_c s_d.
    """
    D, p = second.quartic, len(second.coupling)
    triples = list(combinations_with_replacement(range(len(D)), 3))
    orders = [len(set(permutations(triple))) for triple in triples]
    thrice = -D[(slice(None), *np.transpose(triples))] * orders / 6.0
    return np.concatenate([folded(second.coupling).T, thrice.reshape(p, -1).T])


def pairs_of_pairs(J: np.ndarray) -> np.ndarray:
    """Coefficients J_abcd of pairs a ≤ b by products c ≤ d, which stand once; J: (q, q, q, q)."""
    a, c = np.triu_indices(len(J))
    return J[a, c][:, a, c] * np.where(a == c, 1.0, 2.0)


def crests(bump: np.ndarray, reach: int) -> np.ndarray:
    """Highest bump within `reach` angles of each; bump: on all angles of a revolution (T, n)."""
    from scipy.ndimage import maximum_filter1d  # slow to import, needed to second order only

    return maximum_filter1d(bump, 2 * reach + 1, axis=0, mode="wrap")
