"""Friction that turns with the slip velocity, and its Delassus operator.

Friction opposes the slip velocity of a contact point, which has a part RΩ + u̇_t along the casing's
circumference and an axial part u̇_a. The direction (cos β, sin β) comes from the step before, so
that the multipliers of a step still solve a linear complementarity problem, with an operator that
changes with β:

    W = N·gain·[N + μ (T cos β + A sin β)]ᵀ.

Only points that may carry a force need a direction and a column of W, which are computed when the
solver of `blades` asks for them.
"""

from hpcrub.contact import lanes as v
from hpcrub.contact.arrays import FLAW, State
from hpcrub.contact.jit import compiled
from hpcrub.contact.lanes import PAIR
from hpcrub.contact.laws.solid_arrays import SolidArrays
from hpcrub.contact.status import JAMMING


@compiled(inner=True)
def turn(lanes: tuple, state: State, law: SolidArrays, n_fresh: int, n_active: int) -> None:
    """Compute directions and columns of the points in ``law.fresh`` (law is modified).

    n_fresh: number of entries of ``law.fresh`` that count, places in `State.active`.
    n_active: rows of a column.
    """
    if n_fresh % 2 == 1:
        law.fresh[n_fresh] = law.fresh[0]
    for first in range(0, n_fresh, 2):
        slip(lanes, state, law, first)
    for b in range(n_fresh):
        find_direction(lanes, state, law, state.active[law.fresh[b]])
        fill_column(lanes, state, law, law.fresh[b], n_active)


@compiled(inner=True)
def slip(lanes: tuple, state: State, law: SolidArrays, first: int) -> None:
    """Sum the tangential and axial motion of two points in the step before (law is modified).

    first: place of the first point in ``law.fresh``.
    """
    here, there = v.indices(PAIR, law.fresh, first)
    points = state.active[here], state.active[there]
    along = across = v.tile_splat(PAIR, v.splat(lanes, 0.0))
    for k in range(law.axial.shape[0]):
        moved = v.load(lanes, state.increment_before, k)
        along = v.tile_add(along, law.tangential, k, points, moved)
        across = v.tile_add(across, law.axial, k, points, moved)
    v.store(law.cosine, points, along)
    v.store(law.sine, points, across)


@compiled(inner=True)
def find_direction(lanes: tuple, state: State, law: SolidArrays, j: int) -> None:
    """Find the direction of friction on a point, and its compliance (state, law are modified).

    ``cosine`` and ``sine`` hold the sums from `slip` on entry.
    """
    along = law.way[j] + v.load(lanes, law.cosine, j)
    across = v.load(lanes, law.sine, j)
    unit = v.inverse(v.length(along, across))
    along, across = along * unit, across * unit
    v.store(law.cosine, j, along)
    v.store(law.sine, j, across)
    law.kinematics.push(lanes, law, j, law.friction * along, law.friction * across)
    own = law.kinematics.compliance(lanes, law, j, j, law.friction * along, law.friction * across)
    # jamming: a force on a point that penetrates would pull its blade further in
    near = v.load(lanes, state.penetration, j) > 0.0
    jamming = v.select(near, own, 1.0) < 1e-300
    code = v.select(jamming, float(JAMMING), v.load(lanes, state.report, FLAW))
    v.store(state.report, FLAW, code)
    v.store(law.stiffness, j, v.inverse(own))
    law.surface.set_gains(lanes, law.surface, j, v.larger(own, 0.0))


@compiled(inner=True)
def fill_column(lanes: tuple, state: State, law: SolidArrays, b: int, n_active: int) -> None:
    """Fill the column of the Delassus operator for one point (law is modified).

    b: place of the point in `State.active`; its direction is known.
    n_active: rows of the column.
    """
    n_rows, j = state.penetration.shape[0], state.active[b]
    along = law.friction * v.load(lanes, law.cosine, j)
    across = law.friction * v.load(lanes, law.sine, j)
    scale = v.load(lanes, law.stiffness, j)
    for a in range(n_active):
        w = law.kinematics.compliance(lanes, law, state.active[a], j, along, across)
        v.store(law.coupling, b * n_rows + a, w * scale)
    law.turned[b] = 1
