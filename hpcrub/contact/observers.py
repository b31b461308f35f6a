"""Observers, which record the steps that `integrate.integrate` takes.

An observer is a NamedTuple with a compiled static method
``observe(lanes, bank, observer, block, step, n_active)``. The method is called once the multipliers
of a step are known and before they are applied. It returns how many active points are left to
correct: 0 if it has applied the corrector itself, as it must to see modal coordinates.
"""

from typing import Any, NamedTuple

import numpy as np

from hpcrub.contact import lanes as v
from hpcrub.contact.arrays import Bank, packed
from hpcrub.contact.groups import passed_by_reference
from hpcrub.contact.jit import compiled
from hpcrub.contact.lanes import PLACES, TILE, TIPS
from hpcrub.contact.passes import pair_of_forces

NO_LANES = np.zeros(0, dtype=np.int64)
# A stress below NEAR_PEAK of its largest so far is computed in every STRESS_STRIDE-th step only.
# This lost no largest stress on 492 points of twelve disks; every second step alone loses up to
# 6 %.
STRESS_STRIDE, NEAR_PEAK = 3, 0.8


@compiled(inner=True)
def settled(lanes: tuple, bank: Bank, n_active: int) -> int:
    """Apply the corrector where it comes before a record (bank is modified).

    It does without `Scheme.observed_per_force`. Returns how many active points are left to correct.
    """
    if bank.scheme.observed_per_force.shape[0] > 0:
        return n_active
    bank.basis.correct(lanes, bank, n_active)
    return 0


@compiled(inner=True)
def further(lanes: tuple, beyond: Any, first: int, seen: Any) -> Any:
    """Displacements of a tile of rows from ``first`` on, with their second order if there is any.

    beyond: `State.beyond`, as only then its type chooses the code.
    """
    if beyond is None:
        return seen
    return v.fma(v.load(lanes, beyond, v.consecutive(TIPS, first)), 1.0, seen)


@compiled(inner=True)
def record_displacements(
    lanes: tuple, bank: Bank, history: np.ndarray, peak: np.ndarray, row: int, block: int,
    n_active: int,
) -> int:  # fmt: skip
    """Record the observed displacements after a step (bank and arrays are modified).

    Returns how many active points are left to correct. Each multiplier adds to the displacements
    before the corrector, unless this comes first (`settled`).

    history, peak: as in `Record`.
    row: place of the record in the ring; negative for a step that only counts for the peak.
    block: place of the block in the ring.
    """
    scheme, state = bank.scheme, bank.state
    n_observed = scheme.observed.shape[1]
    n_active = settled(lanes, bank, n_active)
    bank.basis.look(lanes, bank)
    for first in range(0, n_observed, TILE):
        seen = further(lanes, state.beyond, first, bank.basis.seen(lanes, bank, first))
        for a in range(n_active):
            j = state.active[a]
            rows = v.consecutive(TIPS, j * n_observed + first)
            kick = v.load(lanes, scheme.observed_per_force, rows)
            seen = v.fma(kick, v.load(lanes, state.multiplier, j), seen)
        if row >= 0:
            v.store(history, v.consecutive(TIPS, row * n_observed + first), seen)
        rows = v.consecutive(TIPS, block * n_observed + first)
        v.store(peak, rows, v.larger(v.magnitude(seen), v.load(lanes, peak, rows)))
    return n_active


@compiled(inner=True)
def record_casing(lanes: tuple, bank: Bank, table: np.ndarray, row: int, n_active: int) -> None:
    """Record the coordinates of the casing's pairs after a step (table is modified).

    n_active: active points that the corrector has still to apply; row: of the record.
    """
    scheme, state = bank.scheme, bank.state
    first = state.position.shape[0] - scheme.casing
    for k in range(first, state.position.shape[0], 2):
        at, gain = row * scheme.casing + k - first, v.load(lanes, scheme.gain, k)
        c, s = pair_of_forces(lanes, scheme, state, n_active, k)
        v.store(table, at, v.fma(c, gain, v.load(lanes, state.position, k)))
        v.store(table, at + 1, v.fma(s, gain, v.load(lanes, state.position, k + 1)))


@compiled(inner=True)
def largest_stress(bank: Bank, lane: int, work: np.ndarray) -> float:
    """Largest |stress| of one lane after the corrector of a step [Pa].

    work: (1, PLACES) work space (modified).

    A vector holds stresses of several places, not of several lanes, because most lanes beside a
    watched lane are not watched. Six sums run at once, as each sum waits for its last product.
    """
    stress, position = bank.scheme.stress, bank.state.position
    n_modes = position.shape[0]
    n_vectors = stress.shape[0] // (n_modes + n_modes % 2)
    largest = 0.0
    for first in range(0, n_vectors, 3):
        a = b = c = d = e = f = v.splat(PLACES, 0.0)
        for k in range(0, n_modes, 2):
            row = k * n_vectors + first
            q = position[k, lane]
            a = v.fma(v.load(PLACES, stress, row), q, a)
            b = v.fma(v.load(PLACES, stress, row + 1), q, b)
            c = v.fma(v.load(PLACES, stress, row + 2), q, c)
            row += n_vectors
            q = position[min(k + 1, n_modes - 1), lane]
            d = v.fma(v.load(PLACES, stress, row), q, d)
            e = v.fma(v.load(PLACES, stress, row + 1), q, e)
            f = v.fma(v.load(PLACES, stress, row + 2), q, f)
        place = first * len(PLACES)
        for total in (a + d, b + e, c + f):
            v.store(work, 0, v.magnitude(total))
            for i in range(len(PLACES)):
                size = work[0, i] * bank.scheme.stiffer[place + i, lane]
                if size > largest:  # not where it is NaN
                    largest = size
            place += len(PLACES)
    return largest


@compiled
def strokes(
    history: np.ndarray, lane: int, n_observed: int, n_rows: int, oldest: int
) -> tuple[float, float]:
    """Largest stroke and largest jump of the recorded displacements of a lane [m].

    history: ring of records as in `Record`; n_observed: rows of a record, of which the first n_rows
    count; oldest: place of the oldest record.
    Returns the largest peak-to-peak displacement of any row in the later half of the ring, and the
    largest change from one record to the next.
    """
    half, stroke, jump = len(history) // n_observed // 2, 0.0, 0.0
    for row in range(n_rows):
        place = oldest * n_observed + row
        last, lowest, highest = history[place, lane], np.inf, -np.inf
        for k in range(2 * half):
            u = history[place, lane]
            jump, last = max(jump, abs(u - last)), u
            if k >= half:
                lowest, highest = min(lowest, u), max(highest, u)
            place += n_observed
            if place >= len(history):
                place = row
        stroke = max(stroke, highest - lowest)
    return stroke, jump


@passed_by_reference
class Record(NamedTuple):
    """Observer of displacements u: a ring of B blocks of M records, and the largest of blocks."""

    history: np.ndarray  # u after every ``stride``-th step (B·M·O, L) [m]
    peak: np.ndarray  # (B·O, L) largest |u| after every ``look``-th step of a block [m]
    watched: np.ndarray  # lanes whose stresses are observed; eight cost a third of a step
    work: np.ndarray  # (1, PLACES) work space
    stress: np.ndarray  # (1, L) largest |stress| where it was last computed [Pa]
    stress_peak: np.ndarray  # (1, L) largest |stress| of all steps since it was set to zero [Pa]
    casing: np.ndarray  # coordinates of the casing's pairs at the records (B·M·2J, L) [m·√kg]
    ends: np.ndarray  # the same at the ends of the blocks of a call, at most E (E·2J, L) [m·√kg]
    begin: int  # place in the ring of the first block; negative to record nothing
    stride: int  # steps from one record to the next
    look: int  # steps from one look at the displacements to the next, a divisor of the stride

    @staticmethod
    @compiled(inner=True)
    def observe(
        lanes: tuple, bank: Bank, record: "Record", block: int, step: int, n_active: int
    ) -> int:
        """Record every ``stride``-th step, look at every ``look``-th; see ``observers``."""
        n_steps, n_observed = bank.scheme.bump.shape[0], bank.scheme.observed.shape[1]
        if bank.scheme.casing > 0 and step == n_steps - 1 and len(record.ends) > 0:
            n_active = settled(lanes, bank, n_active)
            record_casing(lanes, bank, record.ends, block, n_active)
        if record.begin < 0:
            return n_active
        place = (record.begin + block) % (record.peak.shape[0] // n_observed)
        if step == 0:
            record.peak[place * n_observed : (place + 1) * n_observed] = 0.0
        row, last = place * (n_steps // record.stride) + step // record.stride, record.stride - 1
        kept = row if step % record.stride == last else -1
        if (step + 1) % record.look == 0:
            n_active = record_displacements(
                lanes, bank, record.history, record.peak, kept, place, n_active
            )
        if bank.scheme.casing > 0 and kept >= 0:
            record_casing(lanes, bank, record.casing, row, n_active)
        if len(record.watched) > 0:
            bank.basis.correct(lanes, bank, n_active)
            n_active = 0
        for i in range(len(record.watched)):
            lane = record.watched[i]
            now, peak = record.stress[0, lane], record.stress_peak[0, lane]
            if step % STRESS_STRIDE == 0 or now > NEAR_PEAK * peak:
                now = largest_stress(bank, lane, record.work)
                record.stress[0, lane] = now
                record.stress_peak[0, lane] = max(peak, now)
        return n_active

    @staticmethod
    def per_lane() -> tuple[str, ...]:
        """Arrays whose last axis are the lanes."""
        return "history", "peak", "stress_peak", "casing", "ends"

    @classmethod
    def allocate(
        cls, bank: Bank, n_blocks: int, stride: int, look: int = 1, most: int = 0
    ) -> "Record":
        """Record with an empty ring of n_blocks blocks of a bank; most: blocks of a call, E."""
        n_records = len(bank.scheme.bump) // stride
        n_observed = bank.scheme.observed.shape[1]
        record = cls(
            history=np.zeros((n_blocks * n_records * n_observed, bank.width)),
            peak=np.zeros((n_blocks * n_observed, bank.width)),
            watched=NO_LANES,
            work=np.zeros((1, len(PLACES))),
            stress=np.zeros((1, bank.width)),
            stress_peak=np.zeros((1, bank.width)),
            casing=np.zeros((n_blocks * n_records * bank.scheme.casing, bank.width)),
            ends=np.zeros((most * bank.scheme.casing, bank.width)),
            begin=0,
            stride=stride,
            look=look,
        )
        return packed(record)


_NO = np.zeros((0, 1))
NOTHING = Record(_NO, _NO, NO_LANES, _NO, _NO, _NO, _NO, _NO, begin=-1, stride=1, look=1)
