"""Forces on planar disks before a casing that gives, or a coating that wears.

Projected Gauss–Seidel computes the contact forces as before a rigid casing, but with the line of
`surfaces` that each point is on in place of max(d, 0). As slopes are below one, it converges no
slower.
"""

from typing import Any

import numpy as np

from hpcrub.contact import lanes as v
from hpcrub.contact.arrays import SWEEPS, UNSOLVED, State
from hpcrub.contact.jit import compiled
from hpcrub.contact.lcp import gauss_seidel


@compiled(inner=True)
def subtract_earlier(lanes: tuple, law: Any, state: State) -> np.ndarray:
    """Reduce all penetrations by the effect of forces of earlier steps (state, law are modified).

    Returns the deepest penetration (L,) [m].
    """
    last, zero = state.penetration.shape[0] - 1, v.splat(lanes, 0.0)
    for j in range(last):
        less = 0.0 - law.surface.effective_depth(lanes, law.surface, j, zero)
        v.store(state.multiplier, j, zero)
        if v.any_lane(less < 0.0):
            for i in range(last):
                effect = v.load(lanes, law.coupling, i * (last + 1) + j)
                left = v.fma(effect, less, v.load(lanes, state.penetration, i))
                v.store(state.penetration, i, left + less if i == j else left)
    deepest = v.load(lanes, state.penetration, 0)
    for i in range(last):
        p = v.load(lanes, state.penetration, i)
        v.store(law.surface.reached, i, p + v.load(lanes, law.surface.worn, law.surface.bar[i]))
        deepest = v.larger(p, deepest)
    return deepest


@compiled(inner=True)
def to_forces(lanes: tuple, law: Any, state: State, n_active: int) -> int:
    """Turn the depths x into forces, and wear the coating (state, law are modified).

    Returns the number of points that carry a force in any lane, which `State.active` lists.
    """
    surface, n = law.surface, 0
    for a in range(n_active):
        i = state.active[a]
        x, worn = v.load(lanes, state.multiplier, i), v.load(lanes, surface.worn, surface.bar[i])
        v.store(surface.reached, i, v.load(lanes, state.depth, i) - x + worn)
    surface.wear(lanes, surface, state, n_active)
    for i in range(state.penetration.shape[0] - 1):
        force = v.load(lanes, state.multiplier, i) * v.load(lanes, law.stiffness, i)
        force = surface.remember_force(lanes, surface, i, force)
        v.store(state.multiplier, i, force)
        if v.any_lane(force > 0.0):
            state.active[n] = i
            n += 1
    return n


@compiled(inner=True)
def solve_planar(lanes: tuple, law: Any, state: State, deepest: np.ndarray) -> int:
    """Contact forces of a step (state, law are modified); see `protocols.Law.forces`."""
    deepest = law.surface.find_bars(lanes, law.surface, state, deepest)
    if not v.any_lane(deepest > 0.0):
        return 0
    deepest = subtract_earlier(lanes, law, state)
    n_active = gauss_seidel.candidates(lanes, law, state, deepest)
    limit = v.larger(deepest, 0.0) * gauss_seidel.TOLERANCE
    failed, sweeps = gauss_seidel.solve_many(lanes, law, state, n_active, 1, limit, deepest)
    stuck = v.select(failed, 1.0, 0.0)
    v.store(state.report, SWEEPS, v.larger(sweeps, v.load(lanes, state.report, SWEEPS)))
    v.store(state.report, UNSOLVED, v.larger(stuck, v.load(lanes, state.report, UNSOLVED)))
    return to_forces(lanes, law, state, n_active)
