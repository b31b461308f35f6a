"""The arrays of a bank of lanes: what the kernel reads and modifies.

K modes, L lanes, C contact points and O observed displacements; C and O are padded to multiples of
`lanes.TILE`.
"""

from typing import NamedTuple

import numpy as np

from hpcrub.contact.lanes import aligned


class Shortcuts(NamedTuple):
    """Work that is left out where it cannot matter; none of them changes a bit of the result."""

    nothing_touches: bool = True  # no run where no bump reaches the tips: its time is 0
    no_contact: bool = True  # no multipliers where nothing penetrates
    candidates: bool = True  # only the points that may carry a force
    ramped: bool = True  # no bump ramp after its time
    windows: bool = True  # nothing observed outside the windows that are compared
    narrow: bool = True  # half the lanes when a sweep runs dry


class Scheme(NamedTuple):
    """What the steps read."""

    normal: np.ndarray  # R (K, C) [1/√kg]
    tangential: np.ndarray  # T (K, C)
    observed: np.ndarray  # displacements that are recorded (K, O) [1/√kg]
    load: np.ndarray  # G (K, C + 1), last column zero; polar: (K, 2C + 1), spatial: (K, 3C + 1)
    decay: np.ndarray  # (K, L) [-]
    gain: np.ndarray  # (K, L) [s²]
    # ω² [rad²/s²]: (K,), or (K, L) where it depends on the speed of rotation of a lane
    squared: np.ndarray
    clearance: np.ndarray  # (1, C) [m]; infinite for padding; polar: else zero
    step: np.ndarray  # h (L,) [s]; zero for an idle lane
    bump: np.ndarray  # (P, C) [m]; polar: zero
    external: np.ndarray  # (P, K) modal forces that act anyway [N/√kg]; (0, K) for none
    ramp_time: float  # [s]
    shortcuts: Shortcuts


class Contact(NamedTuple):
    """The Delassus operator W; constant for small kinematics, renewed at each step for polar."""

    coupling: np.ndarray  # W_ij / W_jj ((C + 1)², L), row i·(C + 1) + j; zero where i = j or last
    stiffness: np.ndarray  # 1 / W_jj (C, L) [N/m]
    # (1, L) how far a contact is felt by others: see `candidates` [-]; spatial: largest motion of a
    # point by a unit force on another blade [m/N]
    reach: np.ndarray


class State(NamedTuple):
    """What the steps modify."""

    position: np.ndarray  # q (K, L) [m·√kg]
    increment: np.ndarray  # d (K, L)
    penetration: np.ndarray  # p (C + 1, L) [m]; the last row stays zero
    multiplier: np.ndarray  # λ (C + 1, L) [N]; the last row stays zero; (2C + 1, L), (3C + 1, L)
    depth: np.ndarray  # (C + 1, L) [m], work space of the multiplier solver
    active: np.ndarray  # rows of `multiplier` that count, then the number of the last row
    ramp: np.ndarray  # (1, L) factor of the bumps, s(t) [-]
    n_steps: np.ndarray  # (L,) steps done since the start of each lane
    # of the multiplier solver (4, L): SWEEPS, the most of a step, 0 before any contact; STUCK, 1
    # where those of this step did not converge; UNSOLVED, 1 where multipliers were not found; FLAW
    # of the Delassus operator, code of ``status``. One array: the kernel's calls pay for each.
    report: np.ndarray


class Record(NamedTuple):
    """Where observed displacements u go: a ring of B blocks, each of M records."""

    history: np.ndarray  # (B·M·O, L) [m]
    peak: np.ndarray  # (B·O, L) largest |u| of a block [m]


class Polar(NamedTuple):
    """Casing and compliance for displaced contact points; C of them (padded), L lanes."""

    enabled: bool
    angle: np.ndarray  # θ, of the real points only [rad]
    radius: np.ndarray  # R, of the real points only [m]
    pitch: float  # angle between bumps [rad]
    height: float  # of the bumps [m]
    clearance: np.ndarray  # of the real points only [m]
    friction: float
    turn: float  # rotation in one step [rad]
    compliance: np.ndarray  # (4·C·C, L) motion a of i by force b on j, row (2a + b)·C² + i·C + j
    moved: np.ndarray  # (3·C, L) last u_t, ways of u_r and u_t since [m] (modified)
    cosine: np.ndarray  # cos α (C, L) (modified)
    sine: np.ndarray  # sin α (C, L) (modified)
    deepest: np.ndarray  # (1, L) [m] (modified)


class Spatial(NamedTuple):
    """What contact in three dimensions works on; N blades in G groups of at most P points."""

    points: np.ndarray  # contact points, blade by blade (n,) int
    blade: np.ndarray  # of every contact point (n,) int
    starts: np.ndarray  # place in ``points`` of the first one of every group of blades (G + 1,) int
    way: np.ndarray  # of a point along the casing in a step, R 2π/n (C,) [m]
    friction: float
    axial: np.ndarray  # A (K, C) [1/√kg]
    compliance: np.ndarray  # (3·C·C, L) normal motion of i by force b on j, row 3(j·C + i) + b
    before: np.ndarray  # increment d at the end of the step before (K, L) (modified)
    cosine: np.ndarray  # cos β (C, L) (modified)
    sine: np.ndarray  # sin β (C, L) (modified)
    # (C, L): 1 where a point carried a force in its lane's last contact, -1 where others kept it
    # from the casing, else 0 (modified)
    touching: np.ndarray
    groups: np.ndarray  # starts of the groups in ``state.active`` (G + 1,) int (modified)
    turned: np.ndarray  # whether a listed point has its column of W (C,) bool (modified)
    deepest: np.ndarray  # penetration of every blade (N, L) [m] (modified)
    fresh: np.ndarray  # work space of `friction.turn`: (C + TILE,) int
    slipping: np.ndarray  # (TILE,) int
    chosen: np.ndarray  # work space of `groups.solve_group`: (P,) int
    factor: np.ndarray  # (P·P, L)
    right: np.ndarray  # (P, L)
    wrong: np.ndarray  # (P, L)
    steps_touched: np.ndarray  # steps in which a blade carried a force (N, L) (modified)


class Bank(NamedTuple):
    """The lanes that run together: everything `kernel.integrate` works on."""

    scheme: Scheme
    contact: Contact
    state: State
    record: Record
    polar: Polar
    spatial: Spatial | tuple[()]  # empty for a disk without axial motion

    def take(self, lanes: slice | np.ndarray) -> "Bank":
        """A Bank with copies of some of the lanes only."""
        return Bank(*(_take(group, lanes) for group in self))


# Members that have one column (or one number) per lane
LANE_MEMBERS = {
    Scheme: ("decay", "gain", "squared", "step"),
    Contact: Contact._fields,
    State: tuple(name for name in State._fields if name != "active"),
    Record: Record._fields,
    Spatial: (
        "compliance", "before", "cosine", "sine", "touching", "deepest", "factor", "right",
        "wrong", "steps_touched",
    ),
    Polar: ("compliance", "moved", "cosine", "sine", "deepest"),
}  # fmt: skip


def _take(group, lanes):
    if not group:
        return group
    members = set(LANE_MEMBERS[type(group)])
    if isinstance(group, Scheme) and group.squared.ndim == 1:  # all lanes share it
        members.remove("squared")
    taken = {name: aligned(getattr(group, name)[..., lanes]) for name in members}
    return group._replace(**taken)
