"""The contact law of disks that move in three dimensions.

Friction turns with the slip velocity (`friction`), the points of a blade are stiffly coupled
(`blades`, `active_set`), and there are many modes and points (`passes.predict`). The points meet
one of the `surfaces`.
"""

import numpy as np

from hpcrub.contact import lanes as v
from hpcrub.contact.arrays import FLAW, Bank, State
from hpcrub.contact.jit import compiled
from hpcrub.contact.laws.bent import Bent
from hpcrub.contact.laws.blades import solve_blades
from hpcrub.contact.laws.small import Small
from hpcrub.contact.laws.solid_arrays import SolidArrays
from hpcrub.contact.laws.surface_law import SurfaceLaw
from hpcrub.contact.laws.surfaces import surface_of
from hpcrub.contact.lcp import pivoting
from hpcrub.contact.passes import predict
from hpcrub.contact.protocols import Grid, Scene
from hpcrub.contact.status import NONE, UNPROVEN
from hpcrub.contact.tables import columns, delassus
from hpcrub.model.reduction import Rows


@compiled(inner=True)
def count_contacts(lanes: tuple, state: State, law: SolidArrays, n_active: int) -> None:
    """Count this step for the blades that carry a force (law.touched, modified).

    n_active: entries of `State.active` that count, ordered by blade.
    """
    force = v.splat(lanes, 0.0)
    for a in range(n_active):
        force = v.larger(force, v.load(lanes, state.multiplier, state.active[a]))
        blade = law.blade[state.active[a]]
        if a + 1 == n_active or law.blade[state.active[a + 1]] != blade:
            touched = v.select(force > 0.0, 1.0, 0.0) + v.load(lanes, law.touched, blade)
            v.store(law.touched, blade, touched)
            force = v.splat(lanes, 0.0)


@compiled(inner=True)
def turned_forces(lanes: tuple, state: State, law: SolidArrays, n_active: int) -> int:
    """Turn depths x into normal, tangential and axial forces (state, law are modified).

    Returns the number of rows of ``state.multiplier`` with a force in any lane.
    """
    n = 0
    for a in range(n_active):
        i = state.active[a]
        force = v.load(lanes, state.multiplier, i)
        touches = v.load(lanes, law.touching, i)
        held = v.select(v.load(lanes, state.penetration, i) > 0.0, -1.0, 0.0)
        v.store(law.touching, i, v.select(touches > 0.0, touches, held))
        force = force * v.load(lanes, law.stiffness, i)
        force = law.surface.remember_force(lanes, law.surface, i, force)
        v.store(state.multiplier, i, force)
        state.active[n] = i
        n += int(v.any_lane(force > 0.0))
    return law.kinematics.directed(lanes, state, law, n)


class Solid(SurfaceLaw, SolidArrays):
    """The law of disks that move in three dimensions."""

    @staticmethod
    @compiled(inline=True, inner=True)
    def predict(lanes: tuple, bank: Bank, step: int, n_active: int) -> np.ndarray:
        """Corrector, predictor, penetrations by the kinematics, the surface's `advance_clock`."""
        deepest = predict(lanes, bank, step, n_active)
        deepest = bank.law.kinematics.displace(lanes, bank, step, deepest)
        return bank.law.surface.advance_clock(lanes, bank.law.surface, deepest)

    @staticmethod
    @compiled(inline=True, inner=True)
    def forces(lanes: tuple, bank: Bank, step: int, deepest: np.ndarray) -> int:
        """Contact forces of a step (bank is modified); see `protocols.Law`."""
        state, law = bank.state, bank.law
        deepest = law.surface.find_bars(lanes, law.surface, state, deepest)
        if not v.any_lane(deepest > 0.0):
            return 0
        n_active = solve_blades(lanes, state, law, deepest)
        law.surface.wear(lanes, law.surface, state, n_active)
        count_contacts(lanes, state, law, n_active)
        return turned_forces(lanes, state, law, n_active)

    @staticmethod
    def per_lane() -> tuple[str, ...]:
        """Names of arrays whose last axis is the lanes."""
        return (
            "coupling", "stiffness", "across", "jams", "compliance", "cosine", "sine",
            "touching", "deepest", "touched", "surface", "kinematics", "equations", "depths",
            "undone", "wrong",
        )  # fmt: skip

    @classmethod
    def allocate(cls, rows: Rows, scene: Scene, grid: Grid, width: int) -> "Solid":
        """Make the arrays for idle lanes; see `protocols.Law`."""
        interface, axial = scene.interface, columns(rows.axial)
        n_points = axial.shape[1]
        first = np.append(0, np.cumsum(interface.points_per_blade))
        sector, place = np.zeros((2, len(interface.angle)), dtype=np.int64)
        sector[rows.points], place[rows.points] = np.indices(rows.points.shape)
        way = np.zeros(n_points)
        way[: len(interface.radius)] = interface.radius * 2.0 * np.pi / grid.steps_per_revolution
        return cls(
            **v.lane_arrays(
                width, coupling=(n_points + 1) ** 2, stiffness=n_points, across=n_points, jams=1,
                compliance=3 * rows.points.size * rows.points.shape[1],
                cosine=n_points, sine=n_points,
                touching=n_points, deepest=interface.n_blades, touched=interface.n_blades,
                equations=n_points * (n_points + 1), depths=n_points, undone=n_points,
                wrong=n_points,
            ),
            sector=sector,
            place=place,
            n_sectors=len(rows.points),
            n_places=rows.points.shape[1],
            points=np.argsort(interface.blade, kind="stable"),
            blade=interface.blade,
            first=first,
            way=way,
            friction=scene.friction,
            tangential=np.asfortranarray(columns(rows.tangential)),
            axial=np.asfortranarray(axial),
            turned=np.zeros(n_points, dtype=np.int64),
            fresh=np.zeros(n_points + 1, dtype=np.int64),
            chosen=np.zeros(n_points, dtype=np.int64),
            surface=surface_of(scene, grid, n_points, width),
            kinematics=_kinematics(rows, scene, grid, width),
        )  # fmt: skip

    @classmethod
    def loads(cls, rows: Rows, scene: Scene) -> np.ndarray:
        """Modal forces of unit multipliers (K, 3C + N·p): normal, tangential, axial, on bent modes.

        There are no bent modes at small displacements.
        """
        return -np.hstack([*map(columns, rows.forces), rows.bent_forces.T])

    def fill(self, bank: Bank, lane: int, rows: Rows, scene: Scene) -> None:
        """Give a lane its compliances, and report a flaw of the operator (bank is modified)."""
        gain, friction = bank.scheme.gain[:, lane], scene.friction
        # compliances of all points by forces on the first blade (3, N, P, P)
        first = rows.points[0]
        by_first = np.stack([delassus(rows.normal.T, by[first].T, gain) for by in rows.forces])
        by_first = by_first[:, rows.points]
        W = _unfolded(by_first, rows.points)
        self.surface.fill(lane, scene, bank.scheme.step[lane], W[0])
        own, along, across = np.diagonal(W, axis1=1, axis2=2)
        steepest = friction + self.kinematics.STEEPER
        self.jams[0, lane] = (own <= steepest * np.hypot(along, across)).any()
        if isinstance(self.kinematics, Bent):
            self.kinematics.fill(lane, rows, gain, self.blade, bank.scheme.step[lane])
        bank.state.report[FLAW, lane] = flaw = pivoting.flaw(W[0] + friction * W[1])
        if flaw not in (NONE, UNPROVEN):  # the lane gets no forces, and fails once a point touches
            return
        self.compliance[:, lane] = by_first.transpose(1, 3, 2, 0).ravel()
        most = np.abs(W[0]) + friction * np.hypot(W[1], W[2])
        most *= self.blade[:, None] != self.blade
        self.across[: len(most), lane] = most.max(axis=0)

    def forces_on_points(
        self, multiplier: np.ndarray, scene: Scene
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Normal, tangential and axial forces on the points [N] by multipliers (R, F, L)."""
        n_points, n_padded = len(scene.interface.angle), len(self.stiffness)
        normal, tangential, axial = (multiplier[:, k * n_padded :][:, :n_points] for k in range(3))
        return normal, tangential, axial

    def steps_touched(self, lane: int) -> np.ndarray:
        """Number of steps in which each blade carried a force since its lane was filled (N,)."""
        return self.touched[:, lane].copy()


def _kinematics(rows: Rows, scene: Scene, grid: Grid, width: int) -> Small | Bent:
    """Kinematics of the scene, for idle lanes."""
    if scene.interface.second_order is None:
        return Small()
    return Bent.allocate(scene, rows, grid, width)


def _unfolded(by_first: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Compliances (3, C, C) of all points from those by forces on the first blade (3, N, P, P)."""
    n, C = len(points), points.size
    W = np.empty((len(by_first), C, C))
    for blade in range(n):
        moved = points[(blade + np.arange(n)) % n]
        W[:, moved[:, :, None], points[blade]] = by_first
    return W
