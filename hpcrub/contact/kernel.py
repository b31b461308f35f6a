"""Time steps of the reduced disk with unilateral contact and friction, several speeds at once.

Modal equations of motion  q'' + 2ξω q' + ω² q = Φᵀf,  f the contact forces. With d = q_n − q_{n−1}
all schemes are the same three lines (``docs/theory.md`` derives them):

    predictor   d ← decay·d − ω² gain·q,  q ← q + d     no contact force       → penetrations p
    multipliers λ ≥ 0,  w = p − W λ ≤ 0,  λ w = 0       all contact points at once
    corrector   d ← d + gain·Gλ,  q ← q + gain·Gλ       G = −(R + μT)ᵀ: normal force and friction

decay and gain are numbers per mode and lane (`recurrence.coefficients`); R and T hold the normal
and tangential displacement of every contact point per unit modal coordinate; W = R·gain·(R + μT)ᵀ.

Points of disks with axial motion get their forces from `spatial`, in place of the multipliers here.
The corrector of a step is applied on the way through the next predictor, so that each step reads
and writes the modal state once. What one lane computes never depends on the other lanes.
"""

import numpy as np

from hpcrub.contact.arrays import Contact, Polar, Record, Scheme, Spatial, State
from hpcrub.contact.jit import compiled
from hpcrub.contact.lanes import (
    TILE,
    TIPS,
    any_lane,
    below,
    indices,
    larger,
    load,
    per_lane,
    splat,
    store,
    tile_add,
    tile_dot,
    tile_gather,
    tile_largest,
    tile_splat,
    tile_store,
)
from hpcrub.contact.multipliers import FEW_CONTACTS, MANY_CONTACTS, SOME_CONTACTS, candidates, solve
from hpcrub.contact.polar import displaced_delassus, displaced_depths, displaced_forces
from hpcrub.contact.spatial import find_forces, predict_all
from hpcrub.model import casing

bump_ramp = compiled(casing.ramp)

NO_CONTACTS = ()


@compiled(inline=True)
def predict(
    lanes: tuple,
    contacts: tuple,
    scheme: Scheme,
    state: State,
    step: int,
) -> np.ndarray:
    """Corrector of the step before, predictor of this one (state is modified).

    Parameters
    ----------
    lanes, scheme, state
        As in `integrate`.
    contacts : tuple
        As many zeros as there are first active points to correct.
    step : int
        Row of the bump table.

    Returns
    -------
    ndarray (L,)
        Deepest penetration of the first TILE contact points [m].
    """
    columns = indices(contacts, state.active, 0)
    forces = tile_gather(lanes, state.multiplier, columns)
    depth = tile_splat(TIPS, splat(lanes, 0.0))
    depth = tile_add(depth, scheme.clearance, 0, 0, splat(lanes, -1.0))
    depth = tile_add(depth, scheme.bump, step, 0, load(lanes, state.ramp, 0))
    loaded = scheme.external.shape[0] > 0
    for k in range(state.position.shape[0]):
        gain = load(lanes, scheme.gain, k)
        q = load(lanes, state.position, k)
        d = load(lanes, state.increment, k)
        if len(contacts) > 0:
            kick = tile_dot(scheme.load, k, columns, forces, splat(lanes, 0.0)) * gain
            q = q + kick
            d = d + kick
        d = load(lanes, scheme.decay, k) * d - (gain * per_lane(lanes, scheme.squared, k)) * q
        if loaded:
            d = d + splat(lanes, scheme.external[step, k]) * gain
        q = q + d
        store(state.increment, k, d)
        store(state.position, k, q)
        depth = tile_add(depth, scheme.normal, k, 0, q)
    tile_store(state.penetration, 0, depth)
    return tile_largest(depth)


@compiled
def predict_more(lanes: tuple, first: int, scheme: Scheme, state: State, step: int) -> np.ndarray:
    """Penetrations of one more tile of contact points (state is modified).

    Parameters
    ----------
    lanes, scheme, state
        As in `integrate`.
    first : int
        First contact point of the tile.
    step : int
        Row of the bump table.

    Returns
    -------
    ndarray (L,)
        Deepest of these penetrations [m].
    """
    depth = tile_splat(TIPS, splat(lanes, 0.0))
    depth = tile_add(depth, scheme.clearance, 0, first, splat(lanes, -1.0))
    depth = tile_add(depth, scheme.bump, step, first, load(lanes, state.ramp, 0))
    for k in range(state.position.shape[0]):
        depth = tile_add(depth, scheme.normal, k, first, load(lanes, state.position, k))
    tile_store(state.penetration, first, depth)
    return tile_largest(depth)


@compiled
def correct(lanes: tuple, scheme: Scheme, state: State, n_active: int) -> None:
    """Corrector by itself, for any number of active points (state is modified).

    Parameters
    ----------
    lanes, scheme, state
        As in `integrate`.
    n_active : int
        Entries of `State.active` that count.
    """
    if n_active == 0:
        return
    for k in range(state.position.shape[0]):
        kick = splat(lanes, 0.0)
        for first in range(0, n_active, TILE):
            columns = indices(MANY_CONTACTS, state.active, first)
            forces = tile_gather(lanes, state.multiplier, columns)
            kick = tile_dot(scheme.load, k, columns, forces, kick)
        kick = kick * load(lanes, scheme.gain, k)
        store(state.position, k, load(lanes, state.position, k) + kick)
        store(state.increment, k, load(lanes, state.increment, k) + kick)


@compiled(inline=True)
def settle(lanes: tuple, contacts: tuple, scheme: Scheme, state: State) -> tuple:
    """Corrector by itself, for a few active points (state is modified).

    Parameters
    ----------
    lanes, scheme, state
        As in `integrate`.
    contacts : tuple
        As many zeros as there are first active points to correct.

    Returns
    -------
    tuple of ndarray (L,)
        First TILE observed displacements [m].
    """
    columns = indices(contacts, state.active, 0)
    forces = tile_gather(lanes, state.multiplier, columns)
    seen = tile_splat(TIPS, splat(lanes, 0.0))
    for k in range(state.position.shape[0]):
        q = load(lanes, state.position, k)
        if len(contacts) > 0:
            kick = tile_dot(scheme.load, k, columns, forces, splat(lanes, 0.0))
            kick = kick * load(lanes, scheme.gain, k)
            q = q + kick
            store(state.position, k, q)
            store(state.increment, k, load(lanes, state.increment, k) + kick)
        seen = tile_add(seen, scheme.observed, k, 0, q)
    return seen


@compiled
def observe(
    lanes: tuple, scheme: Scheme, state: State, record: Record, row: int, block: int, n_active: int
) -> None:
    """Apply the corrector and record all observed displacements (state, record are modified).

    Parameters
    ----------
    lanes, scheme, state, record
        As in `integrate`.
    row : int
        Place of the record in the ring, in records.
    block : int
        Place of its block in the ring.
    n_active : int
        Entries of `State.active` that count.
    """
    n_observed = scheme.observed.shape[1]
    if n_active > len(MANY_CONTACTS):
        correct(lanes, scheme, state, n_active)
        n_active = 0
    if n_active == 0:
        seen = settle(lanes, NO_CONTACTS, scheme, state)
    elif n_active <= len(FEW_CONTACTS):
        seen = settle(lanes, FEW_CONTACTS, scheme, state)
    elif n_active <= len(SOME_CONTACTS):
        seen = settle(lanes, SOME_CONTACTS, scheme, state)
    else:
        seen = settle(lanes, MANY_CONTACTS, scheme, state)
    tile_store(record.history, row * n_observed, seen)
    for first in range(TILE, n_observed, TILE):
        seen = tile_splat(TIPS, splat(lanes, 0.0))
        for k in range(state.position.shape[0]):
            seen = tile_add(seen, scheme.observed, k, first, load(lanes, state.position, k))
        tile_store(record.history, row * n_observed + first, seen)
    for i in range(n_observed):
        u = load(lanes, record.history, row * n_observed + i)
        size = larger(u, splat(lanes, 0.0) - u)
        at = block * n_observed + i
        store(record.peak, at, larger(size, load(lanes, record.peak, at)))


@compiled
def raise_bumps(scheme: Scheme, state: State) -> bool:
    """Factor of the bumps at the coming step (state is modified).

    Parameters
    ----------
    scheme, state
        As in `integrate`.

    Returns
    -------
    bool
        False once the bumps of all lanes have their full height.
    """
    rising = False
    for lane in range(scheme.step.shape[0]):
        t = (state.n_steps[lane] + 1) * scheme.step[lane]
        state.ramp[0, lane] = bump_ramp(t, scheme.ramp_time)
        rising = rising or 0.0 < t < scheme.ramp_time  # an idle lane has no time
    return rising


@compiled(inline=True)
def apply_and_predict(
    lanes: tuple,
    scheme: Scheme,
    state: State,
    spatial: Spatial | tuple[()],
    step: int,
    n_active: int,
) -> np.ndarray:
    """Choose the narrowest pass that holds the active points (state is modified).

    Parameters
    ----------
    lanes, scheme, state, spatial
        As in `integrate`.
    step : int
        Row of the bump table.
    n_active : int
        Entries of `State.active` that count.

    Returns
    -------
    ndarray (L,)
        Deepest penetration of all contact points [m].
    """
    if len(spatial) > 0:
        return predict_all(lanes, scheme, state, spatial, step, n_active)
    if n_active > len(MANY_CONTACTS):
        correct(lanes, scheme, state, n_active)
        n_active = 0
    if n_active == 0:
        deepest = predict(lanes, NO_CONTACTS, scheme, state, step)
    elif n_active <= len(FEW_CONTACTS):
        deepest = predict(lanes, FEW_CONTACTS, scheme, state, step)
    elif n_active <= len(SOME_CONTACTS):
        deepest = predict(lanes, SOME_CONTACTS, scheme, state, step)
    else:
        deepest = predict(lanes, MANY_CONTACTS, scheme, state, step)
    for first in range(TILE, state.penetration.shape[0] - 1, TILE):
        deepest = larger(predict_more(lanes, first, scheme, state, step), deepest)
    return deepest


@compiled(inline=True)
def advance(
    lanes: tuple,
    scheme: Scheme,
    contact: Contact,
    state: State,
    polar: Polar,
    spatial: Spatial | tuple[()],
    step: int,
    n_active: int,
) -> int:
    """Predictor and multipliers of one step (state is modified).

    Parameters
    ----------
    lanes, scheme, contact, state, polar, spatial
        As in `integrate`.
    step : int
        Row of the bump table.
    n_active : int
        Active points that are still to be corrected for the step before.

    Returns
    -------
    int
        Active points of this step, which its own corrector still needs.
    """
    deepest = apply_and_predict(lanes, scheme, state, spatial, step, n_active)
    if polar.enabled:
        deepest = displaced_depths(lanes, scheme, state, polar, step)
    if scheme.shortcuts.no_contact and not any_lane(below(splat(lanes, 0.0), deepest)):
        return 0
    if len(spatial) > 0:
        return find_forces(lanes, scheme, contact, state, spatial, deepest)
    n_active = candidates(lanes, contact, state, deepest, scheme.shortcuts.candidates)
    if polar.enabled:
        displaced_delassus(lanes, contact, state, polar, n_active)
    solve(lanes, contact, state, deepest, n_active)
    if polar.enabled:
        n_active = displaced_forces(lanes, state, polar, n_active)
    return n_active


@compiled
def integrate(
    lanes: tuple,
    scheme: Scheme,
    contact: Contact,
    state: State,
    record: Record,
    polar: Polar,
    spatial: Spatial | tuple[()],
    n_blocks: int,
    block: int,
    stride: int,
) -> None:
    """Take every lane over some blocks of the bump table.

    Parameters
    ----------
    lanes : tuple
        As many zeros as there are lanes, which tells the compiler the width.
    scheme : Scheme
        What the steps read.
    contact : Contact
        Delassus operator of every lane (modified by polar and spatial contact).
    state : State
        Motion of every lane (modified).
    record : Record
        Where observed displacements go (modified).
    polar : Polar
        Contact in the displaced position (modified where it is enabled).
    spatial : Spatial or ()
        Contact with axial motion (modified); empty for disks without.
    n_blocks : int
        Blocks to integrate.
    block : int
        Place in the ring of the first block to record; negative to record nothing.
    stride : int
        Steps from one record to the next.

    Notes
    -----
    The forces of the last step are applied before it returns. Joachim, Nyssen, Batailly (2020),
    section 2.2.2, gives the scheme; ``docs/theory.md`` derives this form of it.
    """
    n_observed = scheme.observed.shape[1]
    n_steps = scheme.bump.shape[0]
    n_active = 0
    rising = True
    for b in range(n_blocks):
        place = (block + b) % (record.peak.shape[0] // n_observed)
        if block >= 0:
            record.peak[place * n_observed : (place + 1) * n_observed] = 0.0
        for step in range(n_steps):
            if rising:
                rising = raise_bumps(scheme, state) or not scheme.shortcuts.ramped
            for lane in range(len(lanes)):
                state.n_steps[lane] += 1
            n_active = advance(lanes, scheme, contact, state, polar, spatial, step, n_active)
            if block >= 0 and (step + 1) % stride == 0:
                row = place * (n_steps // stride) + step // stride
                observe(lanes, scheme, state, record, row, place, n_active)
                n_active = 0
    correct(lanes, scheme, state, n_active)
