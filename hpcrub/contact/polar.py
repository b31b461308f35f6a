"""Contact in the displaced position: the option beside small-perturbation kinematics.

A tip at (R + u_r, u_t) has the radius ρ and lies at the angle α from its nominal place. It meets
the casing at θ + Ωt + α with its normal along ρ, so the Delassus operator changes at every step.
Radius and normal are linearised where the tip was at the end of the last step: without contact
forces stiff modes would throw a pressed tip far off within one step, and the normal there is not
that of the contact (half of the amplitude of a nearly radial blade was lost). It is for users who
ask what the linear kinematics of the paper leave out: peaks stay within 1 % of their speeds,
amplitudes change by up to 10 %. It takes radius, angle and clearance of each point from the contact
interface as the default does; axial motion alone it does not know, and is refused with. Kept apart
from ``kernel.py`` because it costs several times more and the default needs none of it.
"""

import math

import numpy as np

from hpcrub.contact.arrays import Contact, Polar, Scheme, State
from hpcrub.contact.complementarity import FLAW
from hpcrub.contact.jit import compiled
from hpcrub.contact.lanes import TILE, TIPS, load, splat, store, tile_add, tile_splat, tile_store
from hpcrub.contact.status import JAMMING


@compiled
def displaced_depths(
    lanes: tuple, scheme: Scheme, state: State, polar: Polar, step: int
) -> np.ndarray:
    """Penetrations and normals in the displaced position (state and polar are modified).

    Parameters
    ----------
    lanes, scheme, polar
        As in `kernel.integrate`.
    state : State
        On entry ``penetration`` holds the outward displacements u_r [m].
    step : int
        Row of the bump table.

    Returns
    -------
    ndarray (L,)
        Deepest penetration of each lane [m].
    """
    n_points = state.penetration.shape[0] - 1
    for first in range(0, n_points, TILE):
        turned = tile_splat(TIPS, splat(lanes, 0.0))
        outwards, onwards = turned, turned
        for k in range(state.position.shape[0]):
            d = load(lanes, state.increment, k)
            last = load(lanes, state.position, k) - d
            turned = tile_add(turned, scheme.tangential, k, first, last)
            outwards = tile_add(outwards, scheme.normal, k, first, d)
            onwards = tile_add(onwards, scheme.tangential, k, first, d)
        tile_store(polar.moved, first, turned)
        tile_store(polar.moved, n_points + first, outwards)
        tile_store(polar.moved, 2 * n_points + first, onwards)
    polar.deepest[:] = -np.inf
    for i in range(polar.angle.size):
        for lane in range(len(lanes)):
            outwards = polar.moved[n_points + i, lane]
            onwards = polar.moved[2 * n_points + i, lane]
            free = polar.radius[i] + state.penetration[i, lane]
            r, t = free - outwards, polar.moved[i, lane]
            rho = math.sqrt(r * r + t * t)
            phi = polar.angle[i] + (step + 1) * polar.turn + math.atan2(t + onwards, free)
            phi -= polar.pitch * math.floor(phi / polar.pitch + 0.5)
            bump = polar.height * math.exp(-((phi / (0.1 * polar.pitch)) ** 2))
            depth = rho - polar.radius[i] + state.ramp[0, lane] * bump - polar.clearance[i]
            depth += (r * outwards + t * onwards) / rho
            polar.cosine[i, lane] = r / rho
            polar.sine[i, lane] = t / rho
            state.penetration[i, lane] = depth
            polar.deepest[0, lane] = max(polar.deepest[0, lane], depth)
    return load(lanes, polar.deepest, 0)


@compiled
def displaced_delassus(
    lanes: tuple, contact: Contact, state: State, polar: Polar, n_active: int
) -> None:
    """Delassus operator of the active points for their present normals (modified; state.report).

    Parameters
    ----------
    lanes, contact, state, polar
        As in `kernel.integrate`.
    n_active : int
        Entries of `State.active` that count.
    """
    n_points = state.penetration.shape[0] - 1
    n_pairs = n_points * n_points
    mu = splat(lanes, polar.friction)
    for b in range(n_active):
        j = state.active[b]
        cosine, sine = load(lanes, polar.cosine, j), load(lanes, polar.sine, j)
        e_r, e_t = cosine - mu * sine, sine + mu * cosine
        for a in range(n_active):
            i = state.active[a]
            at = i * n_points + j
            w_r = load(lanes, polar.compliance, at) * e_r
            w_r = w_r + load(lanes, polar.compliance, n_pairs + at) * e_t
            w_t = load(lanes, polar.compliance, 2 * n_pairs + at) * e_r
            w_t = w_t + load(lanes, polar.compliance, 3 * n_pairs + at) * e_t
            w = load(lanes, polar.cosine, i) * w_r + load(lanes, polar.sine, i) * w_t
            store(contact.coupling, i * (n_points + 1) + j, w)
    n_rows = n_points + 1
    for b in range(n_active):
        j = state.active[b]
        for lane in range(len(lanes)):
            w_jj = contact.coupling[j * n_rows + j, lane]
            contact.stiffness[j, lane] = 1.0 / w_jj if w_jj > 0.0 else 0.0
            nearest = -contact.reach[0, lane] * polar.deepest[0, lane]
            # a lane that has diverged before has no normals, and w_jj says nothing
            deep = 0.0 < polar.deepest[0, lane] < np.inf
            if deep and state.penetration[j, lane] > nearest and w_jj <= 0.0:
                state.report[FLAW, lane] = JAMMING
        stiffness = load(lanes, contact.stiffness, j)
        for a in range(n_active):
            at = state.active[a] * n_rows + j
            store(contact.coupling, at, load(lanes, contact.coupling, at) * stiffness)
        store(contact.coupling, j * n_rows + j, splat(lanes, 0.0))


@compiled
def displaced_forces(lanes: tuple, state: State, polar: Polar, n_active: int) -> int:
    """Turn the multipliers into radial and tangential forces (state is modified).

    Parameters
    ----------
    lanes, state, polar
        As in `kernel.integrate`.
    n_active : int
        Entries of `State.active` that count.

    Returns
    -------
    int
        Rows of ``state.multiplier`` that count.
    """
    n_points = state.penetration.shape[0] - 1
    mu = splat(lanes, polar.friction)
    for a in range(n_active):
        i = state.active[a]
        force = load(lanes, state.multiplier, i)
        cosine, sine = load(lanes, polar.cosine, i), load(lanes, polar.sine, i)
        store(state.multiplier, i, force * (cosine - mu * sine))
        store(state.multiplier, n_points + i, force * (sine + mu * cosine))
        state.active[n_active + a] = n_points + i
    for a in range(2 * n_active, 2 * n_active + TILE):
        state.active[a] = 2 * n_points
    return 2 * n_active
