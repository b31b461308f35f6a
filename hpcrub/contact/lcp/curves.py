"""Contact forces that grow along a curve, by projected Gauss–Seidel: x = f(d), d = p − Cx.

x_j = λ_j W_jj is the depth that the force of point j undoes, d_j the depth that all other forces
leave, d_j − x_j the penetration at the end of the step. A law that calls it has the arrays of
`laws.rigid.Rigid` and ``respond(lanes, law, j, depth)``, a compiled static method: the f_j of its
curve of forces, which never falls and is never larger than max(d, 0).

As in `gauss_seidel` a lane that has converged is frozen, and no lane sees another.
"""

from typing import Any

import numpy as np

from hpcrub.contact.arrays import SWEEPS, UNSOLVED, State
from hpcrub.contact.jit import compiled
from hpcrub.contact.lanes import (
    TILE,
    any_lane,
    below,
    larger,
    load,
    positive_part,
    select,
    splat,
    store,
)
from hpcrub.contact.lcp.gauss_seidel import TOLERANCE, solve_many


@compiled(inner=True)
def solve(lanes: tuple, law: Any, state: State, deepest: np.ndarray, n_active: int) -> None:
    """Depths that the forces of the active points undo, in state.multiplier (state is modified).

    On return ``state.depth`` holds the depths d that the others leave.
    """
    limit = positive_part(deepest) * splat(lanes, TOLERANCE)
    changing = below(splat(lanes, 0.0), deepest)
    failed, sweeps = solve_many(lanes, law, state, n_active, limit, changing)
    stuck = select(failed, splat(lanes, 1.0), splat(lanes, 0.0))
    store(state.report, SWEEPS, larger(sweeps, load(lanes, state.report, SWEEPS)))
    store(state.report, UNSOLVED, larger(stuck, load(lanes, state.report, UNSOLVED)))


@compiled(inner=True)
def to_forces(lanes: tuple, law: Any, state: State, n_active: int) -> int:
    """Turn the depths x into forces (state is modified).

    Returns
    -------
    int
        Points left in `State.active`: those that carry a force in any lane.
    """
    last, n = state.penetration.shape[0] - 1, 0
    for a in range(n_active):
        i = state.active[a]
        x = load(lanes, state.multiplier, i)
        if any_lane(below(splat(lanes, 0.0), x)):
            store(state.multiplier, i, x * load(lanes, law.stiffness, i))
            state.active[n] = i
            n += 1
    for a in range(n, n + TILE):
        state.active[a] = last
    return n
