"""The arrays of a bank of lanes, which the kernel reads and modifies.

Shapes: K modes, L lanes, C contact points and O observed displacements, both padded to multiples of
`lanes.TILE`, F multipliers. Every contact law has its arrays in a class of its own, under `laws`.
"""

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from hpcrub.contact.groups import passed_by_reference

LINE = 64  # bytes of a cache line


class Scheme(NamedTuple):
    """Arrays that the steps only read."""

    # R, normal displacement of the contact points (K, C) [1/√kg]; (0, C) in the cyclic basis
    normal: np.ndarray
    observed: np.ndarray  # displacements that are recorded (K, O) [1/√kg]; (0, O) likewise
    stress: np.ndarray  # stresses whose largest is recorded, by `tables.vectors` [Pa/(m·√kg)]
    stiffer: np.ndarray  # factor of each stress (≥ 1, L) [-]
    load: np.ndarray  # Gᵀ, modal forces of unit multipliers (F + 1, ≥ K + TILE), last row zero
    decay: np.ndarray  # (K, L) [-]
    gain: np.ndarray  # (K, L) [s²]
    # ω² [rad²/s²]: (K,), or (K, L) where it depends on the speed of rotation of a lane
    omega2: np.ndarray
    # observed displacements that unit multipliers add in their step ((F + 1)·O, L) [m/N]; (0, L)
    # where the corrector comes before the record
    observed_per_force: np.ndarray
    clearance: np.ndarray  # clearance of the casing at the speed of each lane (1, L) [m]
    point_clearance: np.ndarray  # clearance that each point adds (1, C) [m]; infinite for padding
    step: np.ndarray  # time step h (L,) [s]; zero for an idle lane
    bump: np.ndarray  # heights of the casing at each step of a block (P, C) [m]
    external: Any  # modal forces of the load (P, K) [N/√kg]; None without a load
    bent: np.ndarray  # amplitudes of bent modes (K, ≥ N·p) [-]; (0, n) in the cyclic basis
    # modal forces by unit forces along these (N·p, ≥ K + TILE); None at small displacements
    push: Any
    # cosine and sine of the angle by which each pair of rows turns in a step (n, L): complex modes
    # of a disk in air, then pairs of a casing that vibrates, which are the last n rows of a motion
    turn: np.ndarray
    casing: int  # number of rows of the casing among these n
    ramp_time: float  # duration of the bump ramp [s]


class State(NamedTuple):
    """Arrays that the steps modify under every contact law."""

    position: np.ndarray  # modal coordinates q (K, L) [m·√kg]
    increment: np.ndarray  # increments d of q in the last step (K, L) [m·√kg]
    # d at the end of the step before (K, L) [m·√kg]; None where friction never turns
    increment_before: Any
    penetration: np.ndarray  # p (C + 1, L) [m]; the last row stays zero
    multiplier: np.ndarray  # λ (F + 1, L) [N]; the last row stays zero
    depth: np.ndarray  # (C + 1, L) [m], work space of the multiplier solver
    active: np.ndarray  # active set: rows of `multiplier` that count, padded with the last row
    ramp: np.ndarray  # (1, L) factor of the bumps, s(t) [-]
    n_steps: np.ndarray  # (L,) steps done since the start of each lane
    # report of the multiplier solver (4, L): SWEEPS, the most in a step, 0 before any contact;
    # STUCK, 1 where the sweeps of this step did not converge; UNSOLVED, 1 where a step has no
    # solution; FLAW, a code of ``status``. They are one array because each array costs in a call.
    report: np.ndarray
    # second order: forces on the bent modes that the coming predictor adds (N·p, L) [m·√kg/s²], and
    # what the observed displacements have beyond their rows (≥ O, L) [m]; None at small ones
    late: Any
    beyond: Any
    # s of the bent modes in the step before (N·p, L) [m·√kg]; None unless their inertia is known
    before: Any


SWEEPS, STUCK, UNSOLVED, FLAW = range(4)  # rows of `State.report`

# Arrays with one column (or one number) per lane; laws and records name theirs in `per_lane`
PER_LANE = {
    Scheme: ("stiffer", "decay", "gain", "observed_per_force", "clearance", "step", "turn"),
    State: tuple(name for name in State._fields if name != "active"),
}


@passed_by_reference
class Bank(NamedTuple):
    """The lanes that run together: all arrays of `integrate` except those of its observer."""

    scheme: Scheme
    state: State
    law: Any  # a `protocols.Law`, whose other members only its own module uses
    basis: Any  # a `dense.Dense` or a `cyclic.Cyclic`

    @property
    def width(self) -> int:
        """Number of lanes."""
        return len(self.scheme.step)

    def take(self, lanes: Sequence[int]) -> "Bank":
        """Bank with copies of some of the lanes."""
        return packed(Bank(*(take_lanes(group, lanes) for group in self)))


class NoArrays(NamedTuple):
    """A group of no arrays, for laws, surfaces and bases that have none of their own."""

    @staticmethod
    def per_lane() -> tuple[str, ...]:
        """Names of arrays: none."""
        return ()


def members_of_lanes(group: Any) -> list[str]:
    """Names of the members of a group with a column (or a number) for each lane, in order."""
    members = set(PER_LANE.get(type(group)) or group.per_lane())
    if isinstance(group, Scheme) and group.omega2.ndim == 2:  # else all lanes share it
        members.add("omega2")
    return sorted(members)


def take_lanes(group: Any, lanes: Sequence[int]) -> Any:
    """Group of arrays with copies of some of its lanes."""
    taken = {}
    for name in members_of_lanes(group):
        member = getattr(group, name)
        if isinstance(member, tuple):
            taken[name] = take_lanes(member, lanes)
        elif member is not None:
            taken[name] = member.take(lanes, -1)
    return group._replace(**taken)


def packed(group: Any) -> Any:
    """Copy of a tuple of arrays, of tuples of arrays and of numbers, in one piece of memory.

    Every array begins with a cache line, so that no vector straddles two. When every array lay by
    itself, one process in 25 took 1.2 to 1.9 times as long for its whole life, by the addresses
    that it had got (Zen 4).
    """
    places = np.cumsum([0, *(-(-array.nbytes // LINE) * LINE for array in arrays_of(group))])
    memory = np.zeros(places[-1] + LINE, dtype=np.uint8)
    place = iter(places + -memory.ctypes.data % LINE)

    def copied(member: Any) -> Any:
        if isinstance(member, tuple):
            return getattr(type(member), "_make", tuple)(map(copied, member))
        if not isinstance(member, np.ndarray):
            return member
        strides = np.empty_like(member).strides
        copy = np.ndarray(member.shape, member.dtype, memory, next(place), strides)
        copy[...] = member
        return copy

    return copied(group)


def arrays_of(group: Any) -> Iterator[np.ndarray]:
    """All arrays of a tuple, in order."""
    for member in group:
        if isinstance(member, tuple):
            yield from arrays_of(member)
        elif isinstance(member, np.ndarray):
            yield member


def clear_lane(group: Any, lane: int) -> None:
    """Set the column of a lane to zero in all arrays of a group (modified)."""
    for name in group.per_lane():
        member = getattr(group, name)
        if isinstance(member, tuple):
            clear_lane(member, lane)
        else:
            member[..., lane] = 0.0
