"""Change of the speed of rotation in the middle of a motion: coefficients of lanes over the speed.

All coefficients of a lane are smooth functions of its speed. They are computed as for any speed
(`bank.fill_lane`) at the speeds of a geometric ladder, and a lane takes the cubic through the four
rungs around its speed. The error is below 1e-7 of a coefficient: a phase drifts with it.
"""

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from hpcrub.contact.arrays import Bank, State, members_of_lanes
from hpcrub.contact.jit import compiled

STEP = 0.008  # from one rung of the ladder to the next, over the speed
N_RUNGS = 64  # most rungs in memory at once, of lanes that are not further apart
N_PROBES = 3  # speeds that show which coefficients depend on the speed
BESIDE = np.array([[-1], [0], [1], [2]])
SET_APART = "step", "clearance"  # which are known without an interpolation


@compiled
def blend(
    to: np.ndarray, rows: np.ndarray, table: np.ndarray, place: np.ndarray, weight: np.ndarray
) -> None:
    """Interpolate rows of a lane array (to is modified).

    to: (n, L); rows: those that change (r,) int.
    table: the same array with a column for every rung (n, R).
    place, weight: the rung below a speed (≤ L,) int, and the weights of the four (4, ≤ L) [-].
    """
    for row in rows:
        for lane in range(place.shape[0]):
            k = place[lane]
            value = (
                weight[0, lane] * table[row, k - 1]
                + weight[1, lane] * table[row, k]
                + weight[2, lane] * table[row, k + 1]
                + weight[3, lane] * table[row, k + 2]
            )
            # a bound may be infinite at some speeds
            to[row, lane] = value if value == value else table[row, k]


def _lane_arrays(group: Any, path: tuple = ()) -> Iterator[tuple[tuple, np.ndarray]]:
    """Arrays of a group with a column for each lane, and the path to each of them."""
    if isinstance(group, State):
        return
    for name in members_of_lanes(group):
        member = getattr(group, name)
        if isinstance(member, tuple):
            yield from _lane_arrays(member, (*path, name))
        elif name not in SET_APART and member is not None and member.ndim == 2:
            yield (*path, name), member


class Speeds:
    """The coefficients of the lanes of a bank over a range of speeds."""

    def __init__(
        self,
        bank: Bank,
        bank_at: Callable[[np.ndarray], Bank],
        first_hz: float,
        ends: tuple[float, float],
    ) -> None:
        """Find out which coefficients depend on the speed.

        bank: its first lanes are at ``first_hz`` [Hz], a rung of the ladder.
        bank_at: makes a bank whose lanes are at rest at speeds [Hz].
        ends: lowest and highest speed [Hz].
        """
        self.bank, self.bank_at, self.first_hz, self.ends = bank, bank_at, first_hz, ends
        self.rungs: np.ndarray = np.zeros(0)  # speeds of the rungs in memory [Hz]
        low, high = ends
        some, mine = of_lanes(bank_at(np.linspace(low, high, N_PROBES))), of_lanes(bank)
        rows = {path: np.flatnonzero((a != a[:, :1]).any(axis=1)) for path, a in some.items()}
        # of every array that changes: itself, rows that change, and its values at the rungs
        self.changing = {path: [mine[path], rows[path]] for path in some if len(rows[path])}
        self.tables: dict[tuple, np.ndarray] = {}

    def set(self, speeds_hz: np.ndarray, steps: np.ndarray) -> None:
        """Give the first lanes other speeds, in the middle of their motion (bank is modified).

        speeds_hz: (S,) [Hz]; steps: their time steps (S,) [s].
        """
        n, scheme = len(speeds_hz), self.bank.scheme
        longer = steps / scheme.step[:n]
        if (longer == 1.0).all():
            return
        _rescale(self.bank, longer)
        scheme.step[:n] = steps
        if self.changing:
            place, weight = self._around(speeds_hz)
            for path, (array, rows) in self.changing.items():
                blend(array, rows, self.tables[path], place, weight)
        self.bank.basis.start(self.bank, np.arange(n))

    def _around(self, speeds_hz: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The rung below each speed (S,), and Lagrange's weights of the four around it (4, S)."""
        place = np.searchsorted(self.rungs, speeds_hz, side="right") - 1
        if not self.tables or place.min() < 1 or place.max() > len(self.rungs) - 3:
            self._fill(speeds_hz)
            place = np.searchsorted(self.rungs, speeds_hz, side="right") - 1
        x = self.rungs[place + BESIDE]
        off, (a, b, c, d) = speeds_hz - x, x
        low, high = off[0] * off[1], off[2] * off[3]
        weight = (
            off[1] * high / ((a - b) * ((a - c) * (a - d))),
            off[0] * high / ((b - a) * ((b - c) * (b - d))),
            low * off[3] / (((c - a) * (c - b)) * (c - d)),
            low * off[2] / (((d - a) * (d - b)) * (d - c)),
        )
        return place, np.array(weight)

    def _fill(self, speeds_hz: np.ndarray) -> None:
        """Compute the rungs from speeds on, in the direction in which these have left the last."""
        falls = len(self.rungs) > 0 and speeds_hz.min() < self.rungs[len(self.rungs) // 2]
        speeds = speeds_hz.min(), speeds_hz.max(), *self.ends
        below = np.floor(np.log(np.divide(speeds, self.first_hz)) / np.log1p(STEP) + 1e-9)
        low, high, lowest, highest = below.astype(int).tolist()
        bottom, top = (high + 4 - N_RUNGS, high + 4) if falls else (low - 2, low - 2 + N_RUNGS)
        bottom, top = max(bottom, lowest - 2), min(top, highest + 4)
        # lanes of a rotor that gains speed fast are further apart
        bottom, top = min(bottom, low - 2), max(top, high + 4)
        self.rungs = self.first_hz * (1.0 + STEP) ** np.arange(bottom, top)
        there = of_lanes(self.bank_at(self.rungs))
        self.tables = {path: there[path] for path in self.changing}


def of_lanes(bank: Bank) -> dict[tuple, np.ndarray]:
    """Arrays of a bank with a column for each lane, by their place in it."""
    return {at: array for i, group in enumerate(bank) for at, array in _lane_arrays(group, (i,))}


def _rescale(bank: Bank, longer: np.ndarray) -> None:
    """Give increments the length of the coming steps (bank is modified).

    longer: coming steps over those before, one for each of the first lanes.

    The increment d of a step is h times the velocity in its middle, which for another length lies
    at another time: d' = r d − ω² h² q r (1 − r)/2, with the restoring force at its end.
    """
    scheme, state, n = bank.scheme, bank.state, len(longer)
    gain = scheme.gain[:, :n]
    restoring = (scheme.omega2 if scheme.omega2.ndim == 2 else scheme.omega2[:, None])[:, :n] * gain
    n_waves = scheme.turn.shape[0] - scheme.casing
    first = len(gain) - scheme.turn.shape[0]
    restoring[first : first + n_waves] = 0.0  # complex modes, whose steps have no increment
    d, q = state.increment[:, :n], state.position[:, :n]
    d *= longer
    d -= restoring * q * (longer * (1.0 - longer) / 2.0)
    if state.increment_before is not None:
        state.increment_before[:, :n] *= longer
