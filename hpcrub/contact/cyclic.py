"""Cyclic basis: the modes of a tuned disk by nodal diameters, which lanes of any samples share.

A mode of h nodal diameters moves corresponding rows p of all blades b by E_p cos(2πhb/N) +
O_p sin(2πhb/N) (`model.tuned_basis`). So a step sums E and O over the modes of each h, on one
blade, and a Fourier series gives all blades: K·2P and N²·P/2 products in place of K·N·P. The same
series, the other way, turns forces of the blades into modal forces.

Blades that deviate by δ_b from the modes push along their own modes y_bj in every step, by the
motion at its begin, which the forces of contact in the step before belong to,

    −δ_b (y + s_j (y − y⁻)),    s_j about ξ/(ω_j h),

where y⁻ is y at the begin of the step before. The second part keeps the damping ratios of the
mistuned disk those of the tuned one (`cyclic_arrays.blade_stiffness`).
"""

from typing import Any

import numpy as np

from hpcrub.contact import lanes as v
from hpcrub.contact.arrays import Bank, State
from hpcrub.contact.cyclic_arrays import CyclicArrays, blade_stiffness
from hpcrub.contact.cyclic_series import (
    find_bent,
    find_late_forces,
    gather_forces,
    move_blades,
    on_blade,
    to_blades,
)
from hpcrub.contact.cyclic_tables import multipliers, tables_of
from hpcrub.contact.dense import PER_MODE
from hpcrub.contact.jit import compiled
from hpcrub.contact.lanes import ONE, PAIR, TILE, TIPS
from hpcrub.contact.passes import (
    advance_ring,
    advance_wave,
    project,
    resting,
    turned,
)
from hpcrub.contact.protocols import Scene
from hpcrub.contact.tables import columns
from hpcrub.model.reduction import Blades, Modes, Rows


@compiled(inline=True, inner=True)
def late_forces(lanes: tuple, tile: tuple, basis: CyclicArrays, h: int, first: int) -> tuple:
    """Modal forces of the deviations on a tile of modes with h nodal diameters."""
    modes, total = v.consecutive(tile, first), v.tile_splat(tile, v.splat(lanes, 0.0))
    stride = basis.cosine.shape[1]
    for row in range(basis.push.shape[0]):
        force = v.load(lanes, basis.late, row * stride + h)
        total = v.tile_add(total, basis.push, row, modes, force)
    return total


@compiled(inline=True, inner=True)
def contact_forces(
    lanes: tuple, tile: tuple, basis: CyclicArrays, n_slots: int, h: int, first: int
) -> tuple:
    """Modal forces of the gathered multipliers on a tile of modes with h nodal diameters."""
    modes, total = v.consecutive(tile, first), v.tile_splat(tile, v.splat(lanes, 0.0))
    stride, n_forces = basis.cosine.shape[1], basis.has_force.shape[0]
    for s in range(n_slots):
        row, at = basis.slots[s], 2 * basis.slots[s] * stride + h
        total = v.tile_add(total, basis.load, row, modes, v.load(lanes, basis.force, at))
        odd = v.load(lanes, basis.force, at + stride)
        total = v.tile_add(total, basis.load, n_forces + row, modes, odd)
    return total


@compiled(inline=True, inner=True)
def correct_tiles(
    lanes: tuple, tile: tuple, bank: Bank, n_slots: int, h: int, begin: int, end: int
) -> None:
    """Corrector of whole tiles of real modes (bank is modified)."""
    for first in range(begin, end, len(tile)):
        force = contact_forces(lanes, tile, bank.basis, n_slots, h, first)
        v.tile_advance(force, first, bank.state, bank.scheme, None, None, None, None)


@compiled(inline=True, inner=True)
def correct_pair(lanes: tuple, bank: Bank, n_slots: int, h: int, k: int) -> None:
    """Corrector of the pair in rows k and k + 1 (bank is modified)."""
    c, s = contact_forces(lanes, PAIR, bank.basis, n_slots, h, k)
    force = turned(lanes, bank.scheme, k, c, s)
    v.tile_advance(force, k, bank.state, bank.scheme, None, None, None, None)


@compiled(inner=True)
def correct_diameters(lanes: tuple, bank: Bank, n_slots: int, h: int, begin: int, end: int) -> None:
    """Corrector of real modes from begin to end, of h nodal diameters, and of complex ones.

    The complex modes have their turn with the first of the real modes (bank is modified).
    """
    basis = bank.basis
    whole = end - (end - begin) % TILE
    correct_tiles(lanes, TIPS, bank, n_slots, h, begin, whole)
    correct_tiles(lanes, ONE, bank, n_slots, h, whole, end)
    if begin == basis.begins[h]:
        for k in range(basis.waves[h], basis.waves[h + 1], 2):
            correct_pair(lanes, bank, n_slots, h, k)


@compiled(inline=True, inner=True)
def advance_tiles(
    lanes: tuple, tile: tuple, bank: Bank, step: int, n_slots: int, h: int, begin: int, end: int,
    is_pushed: Any,
) -> None:  # fmt: skip
    """Predictor of whole tiles of real modes (bank is modified).

    is_pushed: a tuple for modes that the deviations push, which have had their corrector; None for
    modes that have not, and that no deviation pushes.
    """
    scheme, state = bank.scheme, bank.state
    for first in range(begin, end, len(tile)):
        before, external = state.increment_before, scheme.external
        if is_pushed is not None:
            force = v.tile_splat(tile, v.splat(lanes, 0.0))
            late = late_forces(lanes, tile, bank.basis, h, first)
            v.tile_advance(force, first, state, scheme, before, external, step, late)
        else:
            force = contact_forces(lanes, tile, bank.basis, n_slots, h, first)
            v.tile_advance(force, first, state, scheme, before, external, step, None)


@compiled(inline=True, inner=True)
def advance_real(lanes: tuple, bank: Bank, step: int, n_slots: int, h: int) -> None:
    """Predictor of the real modes with h nodal diameters, and corrector of some (modified)."""
    begin, middle, end = bank.basis.begins[h], bank.basis.ends[h], bank.basis.begins[h + 1]
    whole = middle - (middle - begin) % TILE
    advance_tiles(lanes, TIPS, bank, step, n_slots, h, begin, whole, ONE)
    advance_tiles(lanes, ONE, bank, step, n_slots, h, whole, middle, ONE)
    whole = end - (end - middle) % TILE
    advance_tiles(lanes, TIPS, bank, step, n_slots, h, middle, whole, None)
    advance_tiles(lanes, ONE, bank, step, n_slots, h, whole, end, None)


@compiled(inline=True, inner=True)
def advance_waves(lanes: tuple, bank: Bank, step: int, h: int) -> None:
    """Predictor of the complex modes with h nodal diameters (bank is modified)."""
    zero = v.splat(lanes, 0.0)
    for k in range(bank.basis.waves[h], bank.basis.waves[h + 1], 2):
        late = late_forces(lanes, PAIR, bank.basis, h, k)
        external = bank.scheme.external
        advance_wave(lanes, bank.scheme, bank.state, (zero, zero), external, step, k, late)


@compiled(inner=True)
def sum_up(
    lanes: tuple, basis: CyclicArrays, state: State, table: np.ndarray, sums: np.ndarray, h: int,
    end: int,
) -> None:  # fmt: skip
    """Sum E and O of all modes with h nodal diameters (sums are modified).

    table: (R, n) of E and O; sums: (H·n, L); end: end of the real modes that count.
    """
    n = table.shape[1]
    for first in range(0, n, TILE):
        tile = v.tile_splat(TIPS, v.splat(lanes, 0.0))
        tile = project(lanes, table, state.position, first, basis.begins[h], end, tile)
        start, stop = basis.waves[h], basis.waves[h + 1]
        tile = project(lanes, table, state.position, first, start, stop, tile)
        v.store(sums, v.consecutive(TIPS, h * n + first), tile)


@compiled(inner=True)
def add_rings(lanes: tuple, bank: Bank, step: int, n_slots: int) -> None:
    """Advance the casing, and add its motion to the series of the points (bank is modified)."""
    basis, n = bank.basis, bank.basis.normal.shape[1]
    for k in range(basis.waves[-1], basis.diameters.shape[0], 2):
        h = basis.diameters[k]
        c, s = contact_forces(lanes, PAIR, basis, n_slots, h, k)
        force = turned(lanes, bank.scheme, k, c, s)
        advance_ring(lanes, bank.scheme, bank.state, force, step, k)
        for first in range(0, n, TILE):
            places = v.consecutive(TIPS, h * n + first)
            tile = v.load(lanes, basis.series, places)
            tile = project(lanes, basis.normal, bank.state.position, first, k, k + 2, tile)
            v.store(basis.series, places, tile)


@compiled(inner=True)
def find_gaps(lanes: tuple, bank: Bank, step: int) -> np.ndarray:
    """Penetrations of all points from their series (bank is modified).

    Returns the deepest penetration (L,) [m].
    """
    basis, n, deepest = bank.basis, bank.basis.normal.shape[1], v.splat(lanes, -np.inf)
    n_each = basis.points.shape[0] // basis.n_blades
    for p in range(n_each):
        to_blades(lanes, basis, basis.series, p, n_each + p, n)
        for b in range(basis.n_blades):
            i = basis.points[p * basis.n_blades + b]
            rest = resting(lanes, ONE, bank.scheme, bank.state, step, v.consecutive(ONE, i))
            depth = rest[0] + on_blade(lanes, basis, b)
            v.store(bank.state.penetration, i, depth)
            deepest = v.larger(depth, deepest)
    return deepest


TABLES = "normal", "observed", "blade"  # of E and O


class Cyclic(CyclicArrays):
    """The cyclic basis of a bank."""

    @staticmethod
    def per_lane() -> tuple[str, ...]:
        """Names of arrays whose last axis is the lanes."""
        return (
            "deviation", "lag", "series", "blade_series", "even", "odd", "local",
            "before", "late", "force", "seen_at",
        )  # fmt: skip

    @classmethod
    def allocate(cls, rows: Rows, blades: Blades, width: int) -> "Cyclic":
        """Basis for idle lanes."""
        (n_blades, n_points), n_modes = blades.points.shape, blades.modes.shape[1]
        tables, n_forces = tables_of(rows, blades), 3 * n_points + len(rows.bent) // n_blades
        blade_of, row_of = multipliers(rows, blades)
        (n_waves, padded), widths = tables["cosine"].shape, (tables[k].shape[1] for k in TABLES)
        n_motion, n_seen, n_blade = widths
        return cls(
            **tables,
            slots=np.zeros(n_forces + 1, dtype=np.int64),
            has_force=np.zeros(n_forces, dtype=np.int64),
            diameters=rows.diameters,
            points=blades.points.T.ravel(), seen_rows=blades.observed.T.ravel(),
            blade_of=blade_of, row_of=row_of,
            **v.lane_arrays(
                width, deviation=n_modes * n_blades, lag=n_modes * n_blades,
                series=n_waves * max(n_motion, n_seen), blade_series=n_waves * n_blade,
                even=padded, odd=padded, local=n_modes * n_blades, before=n_modes * n_blades,
                late=2 * n_modes * padded, force=2 * n_forces * padded,
                seen_at=columns(rows.observed).shape[1],
            ),
            n_blades=n_blades,
        )  # fmt: skip

    @staticmethod
    def cost(modes: Modes) -> float:
        """Products of a step of one lane without contact, as `Dense.cost`."""
        blades: Any = modes.blades
        (n_blades, n_each), (_, n_points) = blades.modes.shape[:2], blades.points.shape
        moved, n_waves = np.count_nonzero(blades.modes[0].any(axis=0)), n_blades // 2 + 1
        point, blade, wave = (-(-n // TILE) * TILE for n in (2 * n_points, 2 * n_each, n_waves))
        series = 2.0 * n_waves * wave * (n_points + 2 * n_each)
        own = 3.0 * n_blades * (n_points + 3 * n_each)
        return len(modes.omega) * (PER_MODE + point) + moved * (blade + 2 * n_each) + series + own

    def fill(self, bank: Bank, lane: int, modes: Modes, scene: Scene) -> None:
        """Give a lane the deviations of its blades (basis and bank are modified).

        modes: at the speed of the lane; bank: with the step of the lane.
        """
        blades: Any = modes.blades
        h, stiffer = bank.scheme.step[lane], blades.stiffer[: len(bank.scheme.stiffer)]
        bank.scheme.stiffer[: len(stiffer), lane] = stiffer
        is_exact = scene.scheme == "exact_modal"
        deviation, lag = blade_stiffness(modes, scene.damping_ratio, h, is_exact)
        self.deviation[:, lane], self.lag[:, lane] = -deviation.T.ravel(), lag.T.ravel()

    def start(self, bank: Bank, lanes: Any) -> None:
        """Find the motion of the blade modes of lanes that do not start at rest (modified).

        lanes: index of some of the lanes.
        """
        before = (bank.state.position - bank.state.increment)[:, lanes]
        n_modes, n_waves = len(self.local) // self.n_blades, len(self.cosine)
        of_waves = (self.diameters == np.arange(n_waves)[:, None]).astype(float)  # (H, R)
        angle = 2.0 * np.pi / self.n_blades * np.outer(np.arange(n_waves), np.arange(self.n_blades))
        for j in range(n_modes):
            even, odd = (of_waves * self.blade[:, k] @ before for k in (j, n_modes + j))  # (H, L)
            moved = np.cos(angle).T @ even + np.sin(angle).T @ odd
            self.local[j * self.n_blades : (j + 1) * self.n_blades, lanes] = moved

    @staticmethod
    @compiled(inline=True, inner=True)
    def predict(lanes: tuple, bank: Bank, step: int, n_active: int) -> np.ndarray:
        """Corrector of the step before, predictor and penetrations of this step (bank is modified).

        Returns the deepest penetration of all contact points (L,) [m].
        """
        basis, state, n_waves = bank.basis, bank.state, bank.basis.cosine.shape[0]
        n_slots = gather_forces(lanes, basis, state, n_active)
        for h in range(n_waves):
            if n_slots > 0:
                correct_diameters(lanes, bank, n_slots, h, basis.begins[h], basis.ends[h])
            sum_up(lanes, basis, state, basis.blade, basis.blade_series, h, basis.ends[h])
        move_blades(lanes, basis)
        find_late_forces(lanes, basis, state.late)
        for h in range(n_waves):
            advance_real(lanes, bank, step, n_slots, h)
            advance_waves(lanes, bank, step, h)
            sum_up(lanes, basis, state, basis.normal, basis.series, h, basis.begins[h + 1])
        add_rings(lanes, bank, step, n_slots)
        return find_gaps(lanes, bank, step)

    @staticmethod
    @compiled(inline=True, inner=True)
    def correct(lanes: tuple, bank: Bank, n_active: int) -> None:
        """Corrector of all modes without a predictor (bank is modified)."""
        basis = bank.basis
        n_slots = gather_forces(lanes, basis, bank.state, n_active)
        if n_slots > 0:
            for h in range(basis.cosine.shape[0]):
                correct_diameters(lanes, bank, n_slots, h, basis.begins[h], basis.begins[h + 1])
            for k in range(basis.waves[-1], basis.diameters.shape[0], 2):
                correct_pair(lanes, bank, n_slots, basis.diameters[k], k)

    @staticmethod
    @compiled(inline=True, inner=True)
    def displace(lanes: tuple, bank: Bank, bent: Any) -> None:
        """Find the tangential motion of all points, and the bent modes, as `Dense.displace`."""
        basis, n = bank.basis, bank.basis.normal.shape[1]
        n_each = basis.points.shape[0] // basis.n_blades
        for p in range(n_each):
            to_blades(lanes, basis, basis.series, 2 * n_each + p, 3 * n_each + p, n)
            for b in range(basis.n_blades):
                i = basis.points[p * basis.n_blades + b]
                v.store(bent.along, i, on_blade(lanes, basis, b))
        find_bent(lanes, basis, bent.bent)

    @staticmethod
    @compiled(inner=True)
    def look(lanes: tuple, bank: Bank) -> None:
        """Find all observed displacements, `seen` (bank is modified)."""
        basis, n = bank.basis, bank.basis.observed.shape[1]
        n_each = basis.seen_rows.shape[0] // basis.n_blades
        for h in range(basis.cosine.shape[0]):
            end = basis.begins[h + 1]
            sum_up(lanes, basis, bank.state, basis.observed, basis.series, h, end)
        for q in range(n_each):
            to_blades(lanes, basis, basis.series, q, n_each + q, n)
            for b in range(basis.n_blades):
                row = basis.seen_rows[q * basis.n_blades + b]
                v.store(basis.seen_at, row, on_blade(lanes, basis, b))

    @staticmethod
    @compiled(inline=True, inner=True)
    def seen(lanes: tuple, bank: Bank, first: int) -> tuple:
        """Observed displacements of a tile of rows from ``first`` on [m], after `look`."""
        return v.load(lanes, bank.basis.seen_at, v.consecutive(TIPS, first))
