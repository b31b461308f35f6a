"""Fourier series over the blades of a disk: of motions, and of forces of blades and of contact."""

from typing import Any

import numpy as np

from hpcrub.contact import lanes as v
from hpcrub.contact.arrays import State
from hpcrub.contact.cyclic_arrays import CyclicArrays
from hpcrub.contact.jit import compiled
from hpcrub.contact.lanes import TILE, TIPS


@compiled(inner=True)
def to_blades(
    lanes: tuple, basis: CyclicArrays, table: np.ndarray, even: int, odd: int, stride: int
) -> None:
    """Fourier series of a row: its even and odd parts over the blades (basis is modified).

    even, odd: row of E and O in the table for h = 0; stride: rows from one h to the next.
    """
    n_waves = basis.cosine.shape[0]
    for first in range(0, n_waves, TILE):
        places = v.consecutive(TIPS, first)
        e = o = v.tile_splat(TIPS, v.splat(lanes, 0.0))
        for h in range(n_waves):
            e = v.tile_add(e, basis.cosine, h, places, v.load(lanes, table, even + h * stride))
            o = v.tile_add(o, basis.sine, h, places, v.load(lanes, table, odd + h * stride))
        v.store(basis.even, places, e)
        v.store(basis.odd, places, o)


@compiled(inline=True, inner=True)
def on_blade(lanes: tuple, basis: CyclicArrays, b: int) -> np.ndarray:
    """Value (L,) of the row of `to_blades` on a blade."""
    other = basis.n_blades - b
    if b <= other:
        return v.load(lanes, basis.even, b) + v.load(lanes, basis.odd, b)
    return v.load(lanes, basis.even, other) - v.load(lanes, basis.odd, other)


@compiled(inline=True, inner=True)
def blade_force(lanes: tuple, basis: CyclicArrays, late: Any, j: int, b: int) -> np.ndarray:
    """Force (L,) on mode j of blade b by its deviation, and by bent modes (`State.late`)."""
    at = j * basis.n_blades + b
    y = v.load(lanes, basis.local, at)
    y = v.fma(v.load(lanes, basis.lag, at), y - v.load(lanes, basis.before, at), y)
    force = v.load(lanes, basis.deviation, at) * y
    if late is not None:
        for a in range(basis.bent.shape[0]):
            pushed = v.load(lanes, late, b * basis.bent.shape[0] + a)
            force = v.fma(pushed, basis.bent[a, j], force)
    return force


@compiled(inline=True, inner=True)
def find_late_forces(lanes: tuple, basis: CyclicArrays, late: Any) -> None:
    """Series over the blades of the forces on their modes (basis is modified).

    late: `State.late`, an argument because only then its type chooses the code.
    """
    (n_waves, stride), n_blades = basis.cosine.shape, basis.n_blades
    n_each = basis.local.shape[0] // n_blades
    for j in range(n_each):
        for first in range(0, n_waves, TILE):
            places = v.consecutive(TIPS, first)
            e = o = v.tile_splat(TIPS, v.splat(lanes, 0.0))
            for b in range(n_waves):
                both = less = blade_force(lanes, basis, late, j, b)
                if 0 < b < n_blades - b:
                    other = blade_force(lanes, basis, late, j, n_blades - b)
                    both, less = both + other, less - other
                e = v.tile_add(e, basis.cosine, b, places, both)
                o = v.tile_add(o, basis.sine, b, places, less)
            v.store(basis.late, v.consecutive(TIPS, j * stride + first), e)
            v.store(basis.late, v.consecutive(TIPS, (j + n_each) * stride + first), o)


@compiled(inline=True, inner=True)
def move_blades(lanes: tuple, basis: CyclicArrays) -> None:
    """Take the motion of the blade modes from their series (basis is modified)."""
    n, n_each = basis.blade.shape[1], basis.local.shape[0] // basis.n_blades
    for j in range(n_each):
        to_blades(lanes, basis, basis.blade_series, j, n_each + j, n)
        for b in range(basis.n_blades):
            at = j * basis.n_blades + b
            v.store(basis.before, at, v.load(lanes, basis.local, at))
            v.store(basis.local, at, on_blade(lanes, basis, b))


@compiled(inline=True, inner=True)
def find_bent(lanes: tuple, basis: CyclicArrays, bent: np.ndarray) -> None:
    """Bent modes at the end of the step, by their motion in the step before (bent, modified)."""
    p, n_each = basis.bent.shape
    for b in range(basis.n_blades):
        for a in range(p):
            total = v.splat(lanes, 0.0)
            for j in range(n_each):
                y = v.load(lanes, basis.local, j * basis.n_blades + b)
                y = y + (y - v.load(lanes, basis.before, j * basis.n_blades + b))
                total = v.fma(y, basis.bent[a, j], total)
            v.store(bent, b * p + a, total)


@compiled(inner=True)
def gather_forces(lanes: tuple, basis: CyclicArrays, state: State, n_active: int) -> int:
    """Series over the blades of the multipliers of the active points (basis is modified).

    Returns the number of ``basis.slots`` that count.
    """
    n, stride = 0, basis.cosine.shape[1]
    basis.has_force[:] = 0
    for a in range(n_active):
        row, b = basis.row_of[state.active[a]], basis.blade_of[state.active[a]]
        is_new, odd = basis.has_force[row] == 0, v.load(lanes, state.multiplier, state.active[a])
        even = odd
        if 2 * b > basis.n_blades:
            b, odd = basis.n_blades - b, 0.0 - odd
        basis.has_force[row] = 1
        begin = 2 * row * stride
        for first in range(0, basis.cosine.shape[0], TILE):
            h = v.consecutive(TIPS, first)
            at = v.consecutive(TIPS, begin + first)
            beside = v.consecutive(TIPS, begin + stride + first)
            e = o = v.tile_splat(TIPS, v.splat(lanes, 0.0))
            if not is_new:
                e, o = v.load(lanes, basis.force, at), v.load(lanes, basis.force, beside)
            v.store(basis.force, at, v.tile_add(e, basis.cosine, b, h, even))
            v.store(basis.force, beside, v.tile_add(o, basis.sine, b, h, odd))
    for row in range(basis.has_force.shape[0]):  # in their order, whatever other lanes list
        basis.slots[n] = row
        n += basis.has_force[row]
    return n
