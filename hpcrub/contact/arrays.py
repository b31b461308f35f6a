"""The arrays of a bank of lanes: what the kernel reads and modifies.

K modes, L lanes, C contact points, O observed displacements; C and O are padded to multiples of
`lanes.TILE`, F is the number of multipliers. The state of the contact law has a class of its own in
its module under `laws`.
"""

from typing import Any, NamedTuple

import numpy as np

from hpcrub.contact.lanes import aligned


class Scheme(NamedTuple):
    """What the steps read."""

    normal: np.ndarray  # R (K, C) [1/√kg]
    observed: np.ndarray  # displacements that are recorded (K, O) [1/√kg]
    stress: np.ndarray  # those whose largest is recorded, see `tables.vectors` [Pa/(m·√kg)]
    load: np.ndarray  # Gᵀ (F + 1, K), last row zero; K padded by a tile
    decay: np.ndarray  # (K, L) [-]
    gain: np.ndarray  # (K, L) [s²]
    # ω² [rad²/s²]: (K,), or (K, L) where it depends on the speed of rotation of a lane
    squared: np.ndarray
    clearance: np.ndarray  # of the casing, at the speed of each lane (1, L) [m]
    own: np.ndarray  # clearance of each point beyond that (1, C) [m]; infinite for padding
    step: np.ndarray  # h (L,) [s]; zero for an idle lane
    bump: np.ndarray  # (P, C) [m]
    external: np.ndarray  # (P, K) modal forces that act anyway [N/√kg]; (0, K) for none
    # cosine and sine of the angle by which each pair of rows turns in a step (n, L): complex modes
    # of a disk in air, then pairs of a casing that vibrates; the pairs are the last n rows
    turn: np.ndarray
    casing: int  # rows of the casing among these
    ramp_time: float  # [s]


class State(NamedTuple):
    """What the steps modify, whatever the law."""

    position: np.ndarray  # q (K, L) [m·√kg]
    increment: np.ndarray  # d (K, L)
    before: np.ndarray  # d at the end of the step before (K, L), where friction turns, else (0, L)
    force: (
        np.ndarray
    )  # modal forces of the active points on a block of modes (BLOCK, L), work space
    penetration: np.ndarray  # p (C + 1, L) [m]; the last row stays zero
    multiplier: np.ndarray  # λ (F + 1, L) [N]; the last row stays zero
    depth: np.ndarray  # (C + 1, L) [m], work space of the multiplier solver
    active: np.ndarray  # rows of `multiplier` that count, then the number of the last row
    ramp: np.ndarray  # (1, L) factor of the bumps, s(t) [-]
    n_steps: np.ndarray  # (L,) steps done since the start of each lane
    # of the multiplier solver (4, L): SWEEPS, the most of a step, 0 before any contact; STUCK, 1
    # where those of this step did not converge; UNSOLVED, 1 where multipliers were not found; FLAW
    # of the Delassus operator, code of ``status``. One array: the kernel's calls pay for each.
    report: np.ndarray


SWEEPS, STUCK, UNSOLVED, FLAW = range(4)  # rows of `State.report`

# Members that have one column (or one number) per lane; laws and records name their own
PER_LANE = {
    Scheme: ("decay", "gain", "clearance", "step", "turn"),
    State: tuple(name for name in State._fields if name != "active"),
}


class Bank(NamedTuple):
    """The lanes that run together: everything that `integrate` works on but its observer."""

    scheme: Scheme
    state: State
    law: Any  # a `protocols.Law`: what else it has, its own module knows

    @property
    def width(self) -> int:
        """Number of lanes."""
        return len(self.scheme.step)

    def take(self, lanes: slice | np.ndarray) -> "Bank":
        """A Bank with copies of some of the lanes only."""
        return Bank(*(take_lanes(group, lanes) for group in self))


def take_lanes(group: Any, lanes: slice | np.ndarray) -> Any:
    """A group of arrays with copies of some of its lanes only."""
    members = set(PER_LANE.get(type(group)) or group.per_lane())
    if isinstance(group, Scheme) and group.squared.ndim == 2:  # else all lanes share it
        members.add("squared")
    taken = {}
    for name in members:
        member = getattr(group, name)
        inner = isinstance(member, tuple)
        taken[name] = take_lanes(member, lanes) if inner else aligned(member[..., lanes])
    return group._replace(**taken)


def clear_lane(group: Any, lane: int) -> None:
    """Set all that a group of arrays has of a lane to zero (modified)."""
    for name in group.per_lane():
        member = getattr(group, name)
        if isinstance(member, tuple):
            clear_lane(member, lane)
        else:
            member[..., lane] = 0.0
