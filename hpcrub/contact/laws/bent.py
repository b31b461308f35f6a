"""Kinematics of contact to second order, for tips that move far (`model.second_order`).

With the amplitudes s of the bent modes of its blade, a contact point i penetrates the casing by

    p = u_n + ½ κ u_t² − ½ sᵀG_n s + b(θ + u_t/R) − clearance,

where u_n is the normal displacement to first order, u_t the tangential one to second order, and κ
the curvature of the casing along its circumference. Normal force and friction act along the
gradient of p and along the displaced tangent. With t = κ u_t + b′/R, a force that pushes the point
inwards by N has the parts

    N (1 − μ t cos β),    N (t + μ cos β),    N μ sin β

along the normal, tangential and axial direction at rest. By reciprocity, parts f_d push the bent
modes by −Σ_d f_d G_d s, too. The Delassus operator has all of it for points of one blade, and for
points of two blades the motion of the first along its normal at rest.
"""

from typing import Any

import numpy as np

from hpcrub.contact import lanes as v
from hpcrub.contact.arrays import Bank, State
from hpcrub.contact.jit import compiled
from hpcrub.contact.lanes import ONE, PAIR
from hpcrub.contact.laws.bent_arrays import (
    BentArrays,
    crests,
    folded,
    forces_of_products,
    pairs_of_pairs,
    places,
)
from hpcrub.contact.laws.small import list_directions, row_of_pair
from hpcrub.contact.protocols import Grid, Scene
from hpcrub.contact.tables import columns
from hpcrub.model.reduction import Rows

REACH = 0.1  # angle of a displacement up to which the casing's crests nearby are known [rad]


class Bent(BentArrays):
    """Kinematics to second order of a bank; `small.Small` has the same methods."""

    STEEPER = 0.3  # the largest t of thin bumps and of tips that move far

    @staticmethod
    def per_lane() -> tuple[str, ...]:
        """Names of arrays whose last axis is the lanes."""
        return (
            "along", "bent", "products", "raised", "slope", "tilt", "moving", "step",
            "seen", "pushed", "own",
        )  # fmt: skip

    @classmethod
    def allocate(cls, scene: Scene, rows: Rows, grid: Grid, width: int) -> "Bent":
        """Make the arrays for idle lanes; scene: with `Interface.second_order`."""
        interface = scene.interface
        second: Any = interface.second_order
        n_blades, p = second.participation.shape[:2]
        n, C = len(interface.angle), columns(rows.normal).shape[1]
        counts, padding = interface.points_per_blade, (0, C - n)
        # blades of the cyclic basis, whose points are known to correspond, share one table
        table = interface.blade if len(rows.points) == 1 else np.zeros(n, dtype=np.int64)
        size = counts.max() ** 2 * (2 + p) * (3 + p)
        force, q = forces_of_products(second), len(second.inertia)
        n_steps = grid.steps_per_revolution
        bump = scene.casing.table(interface.angle, n_steps, grid.steps_per_block)
        reach = min(int(REACH * n_steps / (2.0 * np.pi)), grid.steps_per_block // 2)
        way = interface.radius * 2.0 * np.pi / n_steps
        return cls(
            **v.lane_arrays(
                width, along=C, bent=columns(rows.bent).shape[1],
                products=n_blades * len(force),
                raised=C, slope=C, tilt=C, seen=C * p, pushed=C * p, own=(table.max() + 1) * size,
                moving=2 * q + q * (q + 1) // 2, step=2,
            ),
            begin=table * size,
            place=places(interface.blade, counts),
            n_places=int(counts.max()),
            shortening=np.pad(second.shortening.reshape(n, -1), (padding, (0, 0))),
            displacement=np.pad(folded(second.shortening[:, :2]).reshape(n, -1), (padding, (0, 0))),
            force=force,
            n_bent=p,
            inertia=pairs_of_pairs(second.inertia),
            squares=second.omega[:q] ** 2,
            observed=folded(second.observed),
            observed_blade=interface.observed_blade,
            curvature=np.pad(second.curvature, padding),
            steps=np.pad(1.0 / way, padding),
            crest=columns(crests(bump, reach).T),
            reach=reach,
            highest=scene.casing.highest,
        )  # fmt: skip

    def fill(self, lane: int, rows: Rows, gain: np.ndarray, blade: np.ndarray, h: float) -> None:
        """Give a lane the motions of blades by forces on them (modified).

        gain: (R,) factor of a modal force [s²]; blade: of every contact point (n,); h: time
        step [s].
        """
        p = self.n_bent
        self.step[:, lane] = 1.0 / h, h / 2.0
        shape = -1, self.n_places, self.n_places, 2 + p, 3 + p
        for b, own in enumerate(self.own[:, lane].reshape(shape)):  # views
            points, bent = np.flatnonzero(blade == b), np.s_[b * p : (b + 1) * p]

            def beside(rows: Any, bent_rows: np.ndarray, n: int = len(points)) -> np.ndarray:
                both = [np.stack(rows, axis=1), np.repeat(bent_rows[None], n, axis=0)]
                return np.concatenate(both, axis=1)

            seen = beside([rows.normal[points], rows.tangential[points]], rows.bent[bent])
            push = beside([by[points] for by in rows.forces], rows.bent_forces[bent])
            found = np.einsum("iok,k,jfk->jiof", seen, gain, push, optimize=True)
            own[: len(points), : len(points)] = found

    @staticmethod
    @compiled(inline=True, inner=True)
    def displace(lanes: tuple, bank: Bank, step: int, deepest: np.ndarray) -> np.ndarray:
        """Penetrations of the displaced points (bank is modified).

        Also finds the forces of the bent modes on each other, `State.late`, and what the second
        order adds to the observed displacements, `State.beyond`.
        Returns the deepest penetration (L,) [m].
        """
        bent, state, law = bank.law.kinematics, bank.state, bank.law
        bank.basis.displace(lanes, bank, bent)
        multiply(lanes, bent, state)
        n_products, n_pairs = bent.force.shape[0], bent.displacement.shape[1] // 2
        deepest = v.splat(lanes, -np.inf)
        ramp, zero = v.load(lanes, state.ramp, 0), v.splat(lanes, 0.0)
        highest, reach = v.splat(lanes, bent.highest), v.splat(lanes, float(bent.reach))
        for i in law.points:
            first = law.blade[i] * n_products
            depth, u = v.load(lanes, state.penetration, i), v.load(lanes, bent.along, i)
            for m in range(n_pairs):
                product = v.load(lanes, bent.products, first + m)
                depth = v.fma(product, bent.displacement[i, m], depth)
                u = v.fma(product, bent.displacement[i, n_pairs + m], u)
            v.store(bent.along, i, u)
            depth = v.fma(0.5 * bent.curvature[i] * u, u, depth)
            is_close = v.magnitude(u) * bent.steps[i] < reach
            crest = v.select(is_close, bent.crest[step, i], highest)
            most = v.fma(ramp, crest - bank.scheme.bump[step, i], depth)
            v.store(bent.slope, i, zero)
            if v.any_lane(most > 0.0):
                v.store(bent.raised, i, most)
                at = bent.along, bent.raised, bent.slope
                read_casing(*at, bank.scheme.bump, step, i, bent.steps[i], len(lanes))
                depth = v.fma(ramp, v.load(lanes, bent.raised, i), depth)
                v.store(bent.slope, i, ramp * v.load(lanes, bent.slope, i))
            v.store(state.penetration, i, depth)
            deepest = v.larger(depth, deepest)
        return deepest

    @staticmethod
    @compiled(inline=True, inner=True)
    def see(lanes: tuple, law: Any, i: int) -> None:
        """Find the gradient of the penetration of a point (law is modified)."""
        bent = law.kinematics
        p = bent.n_bent
        tilt = bent.curvature[i] * v.load(lanes, bent.along, i) + v.load(lanes, bent.slope, i)
        v.store(bent.tilt, i, tilt)
        for a in range(p):
            less = v.splat(lanes, 0.0)
            for c in range(p):
                s = v.load(lanes, bent.bent, law.blade[i] * p + c)
                by_normal = bent.shortening[i, a * p + c]
                by_tangential = bent.shortening[i, (p + a) * p + c]
                less = v.fma(v.fma(tilt, by_tangential, by_normal), s, less)
            v.store(bent.seen, i * p + a, 0.0 - less)

    @staticmethod
    @compiled(inline=True, inner=True)
    def push(lanes: tuple, law: Any, j: int, along: np.ndarray, across: np.ndarray) -> None:
        """Find how a unit normal force on a point pushes the bent modes (law is modified).

        along, across: coefficient of friction times cos β and sin β of the point (L,).
        """
        bent = law.kinematics
        p = bent.n_bent
        tilt = v.load(lanes, bent.tilt, j)
        normal, tangential = 1.0 - along * tilt, along + tilt
        for a in range(p):
            less = v.splat(lanes, 0.0)
            for c in range(p):
                s = v.load(lanes, bent.bent, law.blade[j] * p + c)
                part = normal * bent.shortening[j, a * p + c]
                part = v.fma(tangential, bent.shortening[j, (p + a) * p + c], part)
                part = v.fma(across, bent.shortening[j, (2 * p + a) * p + c], part)
                less = v.fma(part, s, less)
            v.store(bent.pushed, j * p + a, 0.0 - less)

    @staticmethod
    @compiled(inline=True, inner=True)
    def compliance(
        lanes: tuple, law: Any, i: int, j: int, along: np.ndarray, across: np.ndarray
    ) -> np.ndarray:
        """Change of the penetration of point i by a force on point j (L,) [m/N].

        along, across: as in `push`. The force is one unit along the normal, with its friction.
        """
        bent = law.kinematics
        tilt = v.load(lanes, bent.tilt, j)
        normal, tangential = 1.0 - along * tilt, along + tilt
        if law.blade[i] != law.blade[j]:
            at = row_of_pair(law, i, j)
            w = normal * v.load(lanes, law.compliance, at)
            w = v.fma(tangential, v.load(lanes, law.compliance, at + 1), w)
            return v.fma(across, v.load(lanes, law.compliance, at + 2), w)
        p = bent.n_bent
        at = bent.place[j] * bent.n_places + bent.place[i]
        at = bent.begin[j] + at * (2 + p) * (3 + p)
        total = v.splat(lanes, 0.0)
        for o in range(2 + p):
            w = normal * v.load(lanes, bent.own, at)
            w = v.fma(tangential, v.load(lanes, bent.own, at + 1), w)
            w = v.fma(across, v.load(lanes, bent.own, at + 2), w)
            for a in range(p):
                pushed = v.load(lanes, bent.pushed, j * p + a)
                w = v.fma(pushed, v.load(lanes, bent.own, at + 3 + a), w)
            weight = v.splat(lanes, 1.0)
            if o == 1:
                weight = v.load(lanes, bent.tilt, i)
            if o > 1:
                weight = v.load(lanes, bent.seen, i * p + o - 2)
            total = v.fma(weight, w, total)
            at += 3 + p
        return total

    @staticmethod
    @compiled(inline=True, inner=True)
    def directed(lanes: tuple, state: State, law: Any, n: int) -> int:
        """Forces of the n listed points along their directions at rest (state is modified).

        Returns the number of listed multipliers, the last of which push the bent modes.
        """
        bent, n_points = law.kinematics, state.penetration.shape[0] - 1
        p, blade, end = bent.n_bent, -1, 3 * n
        for b in range(n):
            j = state.active[b]
            force, tilt = v.load(lanes, state.multiplier, j), v.load(lanes, bent.tilt, j)
            along = law.friction * v.load(lanes, law.cosine, j)
            across = law.friction * v.load(lanes, law.sine, j)
            v.store(state.multiplier, j, force * (1.0 - along * tilt))
            v.store(state.multiplier, n_points + j, force * (along + tilt))
            v.store(state.multiplier, 2 * n_points + j, force * across)
            for a in range(p):
                row, before = 3 * n_points + law.blade[j] * p + a, v.splat(lanes, 0.0)
                if law.blade[j] == blade:
                    before = v.load(lanes, state.multiplier, row)
                else:
                    state.active[end] = row
                    end += 1
                pushed = v.load(lanes, bent.pushed, j * p + a)
                v.store(state.multiplier, row, v.fma(force, pushed, before))
            blade = law.blade[j]
        list_directions(state, n)
        return end


@compiled(inline=True, inner=True)
def multiply(lanes: tuple, bent: BentArrays, state: State) -> None:
    """Products of the bent modes, and what they push and show (bent, state are modified)."""
    p, n_products, n_pairs = bent.n_bent, bent.force.shape[0], bent.displacement.shape[1] // 2
    for b in range(bent.products.shape[0] // n_products):
        begin = m = b * n_products
        for a in range(p):
            s = v.load(lanes, bent.bent, b * p + a)
            for c in range(a, p):
                v.store(bent.products, m, s * v.load(lanes, bent.bent, b * p + c))
                m += 1
        for a in range(p if n_products > n_pairs else 0):
            s = v.load(lanes, bent.bent, b * p + a)
            for pair in range(n_pairs - (p - a) * (p - a + 1) // 2, n_pairs):
                v.store(bent.products, m, s * v.load(lanes, bent.products, begin + pair))
                m += 1
        for a in range(0, p - 1, 2):
            push_bent(lanes, PAIR, bent, state, b, a)
        if p % 2 == 1:
            push_bent(lanes, ONE, bent, state, b, p - 1)
        resist(lanes, bent, state, state.before, b)
    for o in range(bent.observed.shape[0]):
        total, begin = v.splat(lanes, 0.0), bent.observed_blade[o] * n_products
        for m in range(n_pairs):
            product = v.load(lanes, bent.products, begin + m)
            total = v.fma(product, bent.observed[o, m], total)
        v.store(state.beyond, o, total)


@compiled(inline=True, inner=True)
def push_bent(
    lanes: tuple, tile: tuple, bent: BentArrays, state: State, b: int, first: int
) -> None:
    """Force of the products of blade b on a tile of its bent modes (state is modified)."""
    n_products, modes = bent.force.shape[0], v.consecutive(tile, first)
    total = v.tile_splat(tile, v.splat(lanes, 0.0))
    for m in range(n_products):
        product = v.load(lanes, bent.products, b * n_products + m)
        total = v.tile_add(total, bent.force, m, modes, product)
    v.store(state.late, v.consecutive(tile, b * bent.n_bent + first), total)


@compiled(inline=True, inner=True)
def resist(lanes: tuple, bent: BentArrays, state: State, before: Any, b: int) -> None:
    """Inertia −½ Σ J_abcd s_b (s_c s_d)¨ on the bent modes of blade b, without contact (modified).

    before: `State.before`, an argument because only then its type chooses the code. A bent mode
    has the velocity (s − before)/h in the middle of a step, and accelerates until its end.
    """
    if before is not None:
        p, q, n_pairs = bent.n_bent, bent.squares.shape[0], bent.inertia.shape[0]
        rate, half = v.load(lanes, bent.step, 0), v.load(lanes, bent.step, 1)
        for a in range(q):
            s = v.load(lanes, bent.bent, b * p + a)
            faster = v.load(lanes, state.late, b * p + a) - bent.squares[a] * s
            slow = (s - v.load(lanes, before, b * p + a)) * rate
            v.store(bent.moving, a, v.fma(half, faster, slow))
            v.store(bent.moving, q + a, faster)
        m = 2 * q
        for a in range(q):
            for c in range(a, q):
                s, other = v.load(lanes, bent.bent, b * p + a), v.load(lanes, bent.bent, b * p + c)
                faster = 0.5 * s * v.load(lanes, bent.moving, q + c)
                faster = v.fma(0.5 * other, v.load(lanes, bent.moving, q + a), faster)
                speed = v.load(lanes, bent.moving, a)
                v.store(bent.moving, m, v.fma(speed, v.load(lanes, bent.moving, c), faster))
                m += 1
        pair = 0
        for a in range(q):
            for c in range(a, q):
                total, i, j = v.splat(lanes, 0.0), b * p + a, b * p + c
                for m in range(n_pairs):
                    moving = v.load(lanes, bent.moving, 2 * q + m)
                    total = v.fma(moving, bent.inertia[pair, m], total)
                late = v.load(lanes, state.late, i)
                v.store(state.late, i, late - total * v.load(lanes, bent.bent, j))
                if c > a:
                    late = v.load(lanes, state.late, j)
                    v.store(state.late, j, late - total * v.load(lanes, bent.bent, i))
                pair += 1
        for a in range(p):
            v.store(before, b * p + a, v.load(lanes, bent.bent, b * p + a))


@compiled(inner=True)
def read_casing(
    along: np.ndarray, raised: np.ndarray, slope: np.ndarray, bump: np.ndarray, step: int, i: int,
    steps: float, n_lanes: int,
) -> None:  # fmt: skip
    """Read how much higher the casing is at a displaced point, and its slope (modified).

    along: (C, L) tangential displacements [m]; raised: on entry positive in lanes that count.
    bump: heights at the steps of a block (P, C) [m], straight between them.
    steps: time steps in which the disk turns by a metre at point i [1/m].
    """
    n_steps = bump.shape[0]
    for lane in range(n_lanes):
        at = along[i, lane] * steps
        if raised[i, lane] > 0.0 and abs(at) < n_steps:  # not a motion that diverges
            whole = int(np.floor(at))
            here = bump[(step + whole) % n_steps, i]
            rise = bump[(step + whole + 1) % n_steps, i] - here
            raised[i, lane] = here + (at - whole) * rise - bump[step, i]
            slope[i, lane] = rise * steps
        else:
            raised[i, lane] = 0.0
