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
from hpcrub.contact.lanes import TILE
from hpcrub.contact.laws.solid_arrays import SolidArrays
from hpcrub.contact.status import JAMMING

FEW = (0,) * min(4, TILE)  # size of a pass over slip velocities, which few points need


@compiled(inner=True)
def turn_penetrating(lanes: tuple, state: State, law: SolidArrays, n_active: int) -> None:
    """Fill the columns of all listed points that penetrate or touch (law is modified)."""
    n = 0
    for a in range(n_active):
        i = state.active[a]
        law.turned[a] = False
        near = v.larger(v.load(lanes, state.penetration, i), v.load(lanes, law.touching, i))
        near = law.surface.near(lanes, law.surface, i, law.stiffness, near)
        if v.any_lane(near > 0.0):
            law.work.fresh[n] = a
            n += 1
    turn(lanes, state, law, n, n_active)


@compiled(inner=True)
def turn(lanes: tuple, state: State, law: SolidArrays, n_fresh: int, n_active: int) -> None:
    """Compute directions and columns of the points in ``law.work.fresh`` (law is modified).

    n_fresh: number of entries of ``law.work.fresh`` that count, places in `State.active`.
    n_active: rows of a column.
    """
    for a in range(n_fresh, n_fresh + len(FEW)):
        law.work.fresh[a] = law.work.fresh[0]
    for first in range(0, n_fresh, len(FEW)):
        slip(lanes, state, law, first)
    for b in range(n_fresh):
        fill_column(lanes, state, law, law.work.fresh[b], n_active)


@compiled(inner=True)
def slip(lanes: tuple, state: State, law: SolidArrays, first: int) -> None:
    """Sum the tangential and axial motion of a few points in the step before (law is modified).

    first: place of the first point in ``law.work.fresh``.
    """
    for a in range(len(FEW)):
        law.work.slipping[a] = state.active[law.work.fresh[first + a]]
    points = v.indices(FEW, law.work.slipping, 0)
    way = v.tile_splat(FEW, v.splat(lanes, 0.0))
    for k in range(state.before.shape[0]):
        way = v.tile_add(way, law.tangential, k, points, v.load(lanes, state.before, k))
    v.tile_store(law.cosine, points, way)
    way = v.tile_splat(FEW, v.splat(lanes, 0.0))
    for k in range(state.before.shape[0]):
        way = v.tile_add(way, law.axial, k, points, v.load(lanes, state.before, k))
    v.tile_store(law.sine, points, way)


@compiled(inner=True)
def fill_column(lanes: tuple, state: State, law: SolidArrays, b: int, n_active: int) -> None:
    """Fill the column of the Delassus operator for one point (state and law are modified).

    b: place of the point in `State.active`; ``cosine`` and ``sine`` hold its sums from `slip`.
    n_active: rows of the column.
    """
    n_rows = state.penetration.shape[0]
    j = state.active[b]
    along = law.way[j] + v.load(lanes, law.cosine, j)
    across = v.load(lanes, law.sine, j)
    unit = v.inverse(v.length(along, across))
    along, across = along * unit, across * unit
    v.store(law.cosine, j, along)
    v.store(law.sine, j, across)
    along, across = law.friction * along, law.friction * across
    first = 3 * j * (n_rows - 1)
    own = v.load(lanes, law.compliance, first + 3 * j)
    own = v.fma(along, v.load(lanes, law.compliance, first + 3 * j + 1), own)
    own = v.fma(across, v.load(lanes, law.compliance, first + 3 * j + 2), own)
    # jamming: a force on a point that penetrates would pull its blade further in
    near = v.load(lanes, state.penetration, j) > 0.0
    jamming = v.select(near, own, 1.0) < 1e-300
    code = v.select(jamming, float(JAMMING), v.load(lanes, state.report, FLAW))
    v.store(state.report, FLAW, code)
    scale = v.inverse(own)
    v.store(law.stiffness, j, scale)
    law.surface.comply(lanes, law.surface, j, v.larger(own, 0.0))
    for a in range(n_active):
        at = first + 3 * state.active[a]
        w = v.load(lanes, law.compliance, at)
        w = v.fma(along, v.load(lanes, law.compliance, at + 1), w)
        w = v.fma(across, v.load(lanes, law.compliance, at + 2), w)
        v.store(law.coupling, b * n_rows + a, w * scale)
    law.turned[b] = True
