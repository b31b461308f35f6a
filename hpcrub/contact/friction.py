"""Friction that turns with the slip velocity, and the Delassus operator that goes with it.

Friction opposes the slip velocity of a contact point, which has a part along the casing's
circumference, RΩ + u̇_t, and an axial part u̇_a. Its direction (cos β, sin β) is that of the step
before, so the multipliers of a step still solve a linear problem, whose operator changes with β:

    W = N·gain·[N + μ (T cos β + A sin β)]ᵀ.

Both are needed only of points that may carry a force: the column of a point is computed when the
solver of `blades` asks for it.
"""

from hpcrub.contact.arrays import Contact, Scheme, Spatial, State
from hpcrub.contact.complementarity import FLAW
from hpcrub.contact.jit import compiled
from hpcrub.contact.lanes import (
    TILE,
    any_lane,
    below,
    fma,
    indices,
    inverse,
    larger,
    length,
    load,
    select,
    splat,
    store,
    tile_add_at,
    tile_scatter,
    tile_splat,
)
from hpcrub.contact.multipliers import FEW_CONTACTS, MANY_CONTACTS, SOME_CONTACTS
from hpcrub.contact.status import JAMMING


@compiled(allocates=False)
def turn_penetrating(
    lanes: tuple, scheme: Scheme, contact: Contact, state: State, spatial: Spatial, n_active: int
) -> None:
    """Columns of all listed points that penetrate or touch (contact, spatial are modified).

    Parameters
    ----------
    lanes, scheme, contact, state, spatial
        As in `kernel.integrate`.
    n_active : int
        Entries of `State.active` that count.
    """
    zero, n = splat(lanes, 0.0), 0
    for a in range(n_active):
        i = state.active[a]
        spatial.turned[a] = False
        near = larger(load(lanes, state.penetration, i), load(lanes, spatial.touching, i))
        if any_lane(below(zero, near)):
            spatial.fresh[n] = a
            n += 1
    turn(lanes, scheme, contact, state, spatial, n, n_active)


@compiled(allocates=False)
def turn(
    lanes: tuple,
    scheme: Scheme,
    contact: Contact,
    state: State,
    spatial: Spatial,
    n_fresh: int,
    n_active: int,
) -> None:
    """Directions and columns of the points in ``spatial.fresh`` (contact, spatial are modified).

    Parameters
    ----------
    lanes, scheme, contact, state, spatial
        As in `kernel.integrate`.
    n_fresh : int
        Entries of ``spatial.fresh`` that count, places in `State.active`.
    n_active : int
        Entries of `State.active` that count: rows of a column.
    """
    for a in range(n_fresh, n_fresh + TILE):
        spatial.fresh[a] = spatial.fresh[0]
    for first in range(0, n_fresh, TILE):
        if n_fresh - first <= len(FEW_CONTACTS):
            slip(lanes, FEW_CONTACTS, scheme, state, spatial, first)
        elif n_fresh - first <= len(SOME_CONTACTS):
            slip(lanes, SOME_CONTACTS, scheme, state, spatial, first)
        else:
            slip(lanes, MANY_CONTACTS, scheme, state, spatial, first)
    for b in range(n_fresh):
        fill_column(lanes, contact, state, spatial, spatial.fresh[b], n_active)


@compiled(allocates=False)
def slip(
    lanes: tuple, slots: tuple, scheme: Scheme, state: State, spatial: Spatial, first: int
) -> None:
    """Directions of slip of a few points in the step before (spatial is modified).

    Parameters
    ----------
    lanes, scheme, state, spatial
        As in `kernel.integrate`.
    slots : tuple
        As many zeros as there are points.
    first : int
        Place of the first one in ``spatial.fresh``.
    """
    for a in range(len(slots)):
        spatial.slipping[a] = state.active[spatial.fresh[first + a]]
    points = indices(slots, spatial.slipping, 0)
    way = tile_splat(slots, splat(lanes, 0.0))
    for k in range(spatial.before.shape[0]):
        way = tile_add_at(way, scheme.tangential, k, points, load(lanes, spatial.before, k))
    tile_scatter(spatial.cosine, points, way)
    way = tile_splat(slots, splat(lanes, 0.0))
    for k in range(spatial.before.shape[0]):
        way = tile_add_at(way, spatial.axial, k, points, load(lanes, spatial.before, k))
    tile_scatter(spatial.sine, points, way)


@compiled(allocates=False)
def fill_column(
    lanes: tuple, contact: Contact, state: State, spatial: Spatial, b: int, n_active: int
) -> None:
    """Column of the Delassus operator of one point (contact, state and spatial are modified).

    Parameters
    ----------
    lanes, contact, state, spatial
        As in `kernel.integrate`.
    b : int
        Place of the point in `State.active`; its slip velocity is in ``cosine`` and ``sine``.
    n_active : int
        Rows of the column.
    """
    n_rows = state.penetration.shape[0]
    j = state.active[b]
    along = splat(lanes, spatial.way[j]) + load(lanes, spatial.cosine, j)
    across = load(lanes, spatial.sine, j)
    unit = inverse(length(along, across))
    along, across = along * unit, across * unit
    store(spatial.cosine, j, along)
    store(spatial.sine, j, across)
    mu = splat(lanes, spatial.friction)
    along, across = mu * along, mu * across
    first = 3 * j * (n_rows - 1)
    own = load(lanes, spatial.compliance, first + 3 * j)
    own = fma(along, load(lanes, spatial.compliance, first + 3 * j + 1), own)
    own = fma(across, load(lanes, spatial.compliance, first + 3 * j + 2), own)
    # where the point penetrates: a force there would pull its blade further in
    near = below(splat(lanes, 0.0), load(lanes, state.penetration, j))
    jamming = below(select(near, own, splat(lanes, 1.0)), splat(lanes, 1e-300))
    code = select(jamming, splat(lanes, float(JAMMING)), load(lanes, state.report, FLAW))
    store(state.report, FLAW, code)
    scale = inverse(own)
    store(contact.stiffness, j, scale)
    for a in range(n_active):
        at = first + 3 * state.active[a]
        w = load(lanes, spatial.compliance, at)
        w = fma(along, load(lanes, spatial.compliance, at + 1), w)
        w = fma(across, load(lanes, spatial.compliance, at + 2), w)
        store(contact.coupling, b * n_rows + a, w * scale)
    spatial.turned[b] = True
