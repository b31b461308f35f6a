"""What must hold for every case, checked by other means than the sweep's own."""

import time
from typing import NamedTuple

import numpy as np

from evidence.stress import repeats
from evidence.stress.corners import build
from hpcrub.contact import status
from hpcrub.contact.bank import allocate
from hpcrub.contact.integrate import run
from hpcrub.contact.lanes import aligned_zeros
from hpcrub.contact.observers import Record
from hpcrub.contact.status import DIVERGED, NOT_STEADY, STEADY
from hpcrub.model.casing import bump_table
from hpcrub.response.revolution import cut_revolution, speed_bands
from hpcrub.response.sweep import run_sweep

WIDTH = 8
STEPWISE = 300  # time steps that are looked at one by one
AFTER = 10  # revolutions that a steady point is followed
TOO_EARLY = 0.01  # change of amplitude after acceptance that is counted
LARGEST_FINE_STEP = 2e-5  # [s]: a point must not diverge below it if it does not at a quarter of it
COPIES = 32  # of such a point, which together show where a chaotic motion goes
APART = 1e-9  # of the speed, between one copy and the next
NEAR = 0.5  # of the amplitude at which a point diverges
# The solver stops at 1e-12 of the deepest penetration, which may be some hundred units
MOST_ROUND_OFF = 1000.0
EVERY = 8  # cases of which one is audited, and another integrated as a whole history


class Findings(NamedTuple):
    """What one case gave."""

    corner: str
    number: int
    seconds: float
    status: np.ndarray  # (S,)
    reason: np.ndarray  # (S,)
    sweeps: np.ndarray  # (S,)
    followed: int  # steady points that were run on
    early: int  # of these, points whose amplitude changed by more than TOO_EARLY
    penetration: float  # largest after the corrector, in round-off units
    contacts: int  # forces looked at
    unconfirmed: int  # diverged points that do not diverge with a quarter of the step
    audited: int  # points whose energy was
    unbalanced: int  # of these, points whose audit does not close
    histories: int  # speeds integrated as whole histories
    faults: tuple  # texts; empty when all is well


def examine(case):
    """Run a case and check everything; returns Findings."""
    began = time.perf_counter()
    modes, scene, speeds = build(case)
    # amplitudes are those of every step: what is compared with them has to see every step, too
    scene = scene._replace(record_interval=0.0)
    with np.errstate(all="ignore"):
        result = run_sweep(modes, scene, speeds, width=WIDTH)
        seconds = time.perf_counter() - began
        faults = list(consistent(result, scene, speeds))
        followed, early, more = follow(modes, scene, speeds, result)
        faults += more
        penetration, contacts, more = stepwise(modes, scene, speeds, result)
        faults += more
        unconfirmed, more = refine(modes, scene, speeds, result)
        faults += more
        audited, unbalanced, n_histories = 0, 0, 0
        if case.number % EVERY == 0:
            audited, unbalanced, more = repeats.audited(modes, scene, speeds, result, WIDTH)
            faults += more
        if case.number % EVERY == 1:
            n_histories, more = repeats.whole(modes, scene, speeds, result, MOST_ROUND_OFF)
            faults += more
    return Findings(
        case.corner, case.number, seconds, result.point_status, result.point_reason,
        result.max_sweeps, followed, early, penetration, contacts, unconfirmed,
        audited, unbalanced, n_histories, tuple(faults),
    )  # fmt: skip


def consistent(result, scene, speeds):
    """No NaN or infinity in a result, no result without a status, no failure without a reason."""
    numbers = np.stack([result.amplitude, result.localisation])
    failed = result.point_status == DIVERGED
    if not np.isin(result.point_status, (STEADY, NOT_STEADY, DIVERGED)).all():
        yield "a point without a status"
    if not np.isfinite(numbers[:, ~failed]).all() or not np.isfinite(result.time).all():
        yield "NaN or infinity in a result that has not diverged"
    if not np.isnan(numbers[:, failed]).all():
        yield "a diverged point with a result"
    if not np.array_equal(failed, np.isin(result.point_reason, status.FATAL)):
        yield "status and reason contradict each other"
    # a touch at the very end of the windows of six revolutions may pass the time limit
    limit = np.maximum(scene.steady.max_time, scene.steady.first_check) + 7.0 / speeds
    if not (result.time <= limit).all():
        yield "simulated longer than allowed"


def follow(modes, scene, speeds, result):
    """Integrate all points again, at once, nothing skipped, and go on after they were steady.

    Returns the number of steady points, of those whose amplitude still changed, and faults.
    """
    found = [follow_band(modes, scene, speeds[band], band, result) for band in speed_bands(speeds)]
    counts, early, faults = zip(*found, strict=True)
    return sum(counts), sum(early), [fault for part in faults for fault in part]


def follow_band(modes, scene, speeds, band, result):
    """`follow` of the speeds (S,) of one band, which share a grid; band: their places (S,)."""
    amplitude, time = result.amplitude[band], result.time[band]
    grid = cut_revolution(speeds[0], scene)
    per_turn = grid.blocks_per_revolution
    n_blocks = np.round(time * speeds * per_turn).astype(int)
    steady = np.flatnonzero((result.point_status[band] == STEADY) & (n_blocks > 0))
    rows = grid.steps_per_block // grid.stride * (-(-len(modes.observed) // 12) * 12)
    total = n_blocks.max(initial=0) + AFTER * per_turn
    if not len(steady) or total * rows * WIDTH * 8 > 4e8:
        return 0, 0, []
    bank = allocate(modes, scene, grid, WIDTH, speeds)
    record = Record.allocate(bank, total, grid.stride)
    run(bank, total, record)
    history = record.history.reshape(total, -1, bank.scheme.observed.shape[1], WIDTH)
    history = history[:, :, : len(modes.observed)]
    faults, early = [], 0
    for i in steady:
        end, window = n_blocks[i], scene.steady.window_revolutions * per_turn
        both = history[end - 2 * window : end, :, :, i]
        before, last = np.abs(both).reshape(2, -1, both.shape[-1]).max(axis=1)
        tip = np.argmax(last)
        if last[tip] != amplitude[i]:
            faults.append(f"amplitude {amplitude[i]:.17g}, once more {last[tip]:.17g}")
        if not accepted(both[:, :, tip], before[tip], last[tip], scene.steady):
            faults.append("steady against the criteria")
        after = np.abs(history[end : end + AFTER * per_turn, :, :, i]).max()
        if not after < scene.interface.radius.max():
            faults.append(f"steady, then {after:.3g} m")
        early += abs(after - last[tip]) > TOO_EARLY * last[tip]
    return len(steady), early, faults


def accepted(signal, before, last, steady):
    """The paper's criteria once more, by NumPy's own correlation."""
    a, b = signal.reshape(2, -1)
    if np.ptp(a) == 0.0 and np.ptp(b) == 0.0:
        return before == last
    with np.errstate(all="ignore"):
        size = max(np.abs(a).max(), np.abs(b).max())  # corrcoef squares
        correlation = np.corrcoef(a / size, b / size)[0, 1]
    change = abs(last - before) - steady.max_amplitude_change * last
    return correlation > steady.min_correlation - 1e-6 and change <= 1e-12 * last


def stepwise(modes, scene, speeds, result):
    """λ ≥ 0, no penetration and λ·gap = 0 after every single step of a part of the run.

    Returns the largest penetration, or gap at a force, in units of round-off; the number of contact
    forces seen; and faults. Points that diverged are left out.
    """
    fine = np.flatnonzero(result.point_status != DIVERGED)
    if not len(fine):
        return 0.0, 0, []
    grid = cut_revolution(speeds[speed_bands(speeds)[0][0]], scene)
    bank = allocate(modes, scene, grid, WIDTH, speeds)
    run(bank, 1)
    table = bank.scheme.bump
    shown = bump_table(
        scene.interface.angle,
        scene.n_bumps,
        scene.bump_height,
        grid.steps_per_revolution,
        len(table),
    )
    row = aligned_zeros((1, table.shape[1]))
    one = bank._replace(scheme=bank.scheme._replace(bump=row))
    worst, contacts, faults = 0.0, 0, set()
    for step in _busiest(shown, STEPWISE):
        row[0] = table[step]
        bank.state.multiplier[:] = 0.0
        run(one, 1)
        depth, size, force = (v[:, fine] for v in _contacts(bank, scene, shown[step]))
        # p and Wλ are sums over the modes; the solver stops at 1e-12 of the deepest penetration
        unit = (len(modes.omega) + 1) * np.finfo(float).eps * size.max(axis=0) + 5e-324
        gap = np.where(force > 0.0, np.abs(depth), depth)
        worst = np.max([worst, (gap / unit).max()])  # NaN stays
        contacts += int((force > 0.0).sum())
        if not force.min() >= 0.0:
            faults.add("tension in a contact")
    if not worst <= MOST_ROUND_OFF:
        faults.add(f"penetration or gap at a contact of {worst:.3g} units of round-off")
    return float(worst), contacts, sorted(faults)


def _contacts(bank, scene, bump):
    """After a step, of every tip and lane (n, L): depth [m], the magnitudes it is the sum of, and
    normal force."""
    n = len(bump)
    radial, wall = bank.scheme.normal[:, :n].T, bank.state.ramp * bump[:, None]
    depth = radial @ bank.state.position + wall - scene.clearance
    size = np.abs(radial) @ np.abs(bank.state.position) + wall + scene.clearance
    return depth, size, bank.state.multiplier[:n].copy()


def _busiest(table, n):
    """Consecutive rows of the bump table that end a little after a bump has passed a blade."""
    last = min(len(table), int(np.argmax(table.max(axis=1))) + n // 2)
    return range(max(0, last - n), last)


def refine(modes, scene, speeds, result):
    """Points that diverged, with a quarter of the step: it must then diverge too, or be coarse.

    A chaotic motion as large as the disk passes the limit at one step and stays below at another.
    Copies of it at speeds next to each other tell: at a quarter of the step, too, some of them
    must come near the limit.

    Returns how many points do not diverge with a quarter of the step, and a fault for each of
    these whose copies stay away from the limit, at a fine step within the limit of stability.
    """
    failed = np.flatnonzero(
        np.isin(result.point_reason, (status.NOT_FINITE, status.TOO_LARGE, status.UNSOLVED))
    )
    if not len(failed):
        return 0, []
    finer = scene._replace(step=scene.step / 4.0)
    again = run_sweep(modes, finer, speeds, width=WIDTH, selection=failed)
    well = failed[again.point_status[failed] != DIVERGED]
    stable = scene.scheme == "exact_modal" or scene.step * modes.omega.max() < 2.0
    if not stable or scene.step > LARGEST_FINE_STEP:
        return len(well), []
    alone = [i for i in well if not _comes_near(modes, finer, speeds[i])]
    words = sorted({status.WORDS[r] for r in result.point_reason[alone]})
    return len(well), [f"{w}, but not with a quarter of the step" for w in words]


def _comes_near(modes, scene, speed):
    """Whether one of the copies diverges or has an amplitude near the limit."""
    copies = run_sweep(modes, scene, speed * (1.0 + APART * np.arange(COPIES)), width=WIDTH)
    limit = scene.interface.radius.max()
    return bool((copies.point_status == DIVERGED).any() or copies.amplitude.max() > NEAR * limit)
