"""What must hold for every case, checked by other means than the sweep's own.

A check takes modes, Scene, speeds and their SweepResult, and returns what it has counted and faults
as texts.
"""

import functools
from collections import Counter
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from evidence.stress.corners import build
from evidence.truth.energy import audit
from hpcrub.contact import status
from hpcrub.contact.bank import allocate
from hpcrub.contact.integrate import run
from hpcrub.contact.observers import Record
from hpcrub.contact.status import DIVERGED, NOT_STEADY, STEADY
from hpcrub.response import history
from hpcrub.response.revolution import cut_revolution, speed_bands
from hpcrub.response.sweep import run_sweep
from hpcrub.studies.time_response import gap

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
STEEPEST = np.sqrt(2.0 / np.e) / (0.2 * np.pi)  # slope of a bump, of its height and their number


class Findings(NamedTuple):
    """What one case gave."""

    corner: str
    status: np.ndarray  # (S,)
    reason: np.ndarray  # (S,)
    sweeps: np.ndarray  # (S,)
    counts: Counter  # what the checks have counted, and the largest penetration in round-off units
    faults: list  # texts; empty when all is well


def examine(case):
    """Run a case and check everything; returns Findings."""
    modes, scene, speeds = build(case)
    # amplitudes are those of every step: what is compared with them has to see every step, too
    scene = scene._replace(record_interval=0.0)
    checks = [follow, stepwise, refine]
    checks += {0: [audited], 1: [histories]}.get(case.number % EVERY, [])
    counts = Counter()
    with np.errstate(all="ignore"):
        result = run_sweep(modes, scene, speeds, width=WIDTH)
        faults = list(inconsistent(scene, speeds, result))
        for check in checks:
            found, more = check(modes, scene, speeds, result)
            counts.update(found)
            faults += more
    return Findings(
        case.corner, result.point_status, result.point_reason, result.max_sweeps, counts, faults
    )


def by_band(check):
    """The check of all speeds that checks those of each band, which share a grid."""

    @functools.wraps(check)
    def checked(modes, scene, speeds, result):
        counts, faults = Counter(), []
        for band in speed_bands(speeds):
            names = "time", "point_status", "amplitude"
            part = replace(result, **{name: getattr(result, name)[band] for name in names})
            found, more = check(modes, scene, speeds[band], part)
            counts.update(found)
            faults += more
        return counts, faults

    return checked


def inconsistent(scene, speeds, result):
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


@by_band
def follow(modes, scene, speeds, result):
    """Integrate all points again, at once, nothing skipped, and go on after they were steady.

    Counts the steady points ("followed") and those whose amplitude still changed ("early").
    """
    grid = cut_revolution(speeds[0], scene)
    per_turn = grid.blocks_per_revolution
    n_blocks = np.round(result.time * speeds * per_turn).astype(int)
    steady = np.flatnonzero((result.point_status == STEADY) & (n_blocks > 0))
    rows = grid.steps_per_block // grid.stride * (-(-len(modes.observed) // 12) * 12)
    total = n_blocks.max(initial=0) + AFTER * per_turn
    if not len(steady) or total * rows * WIDTH * 8 > 4e8:
        return {}, []
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
        if last[tip] != result.amplitude[i]:
            faults.append(f"amplitude {result.amplitude[i]:.17g}, once more {last[tip]:.17g}")
        if not accepted(both[:, :, tip], before[tip], last[tip], scene.steady):
            faults.append("steady against the criteria")
        after = np.abs(history[end : end + AFTER * per_turn, :, :, i]).max()
        if not after < scene.interface.radius.max():
            faults.append(f"steady, then {after:.3g} m")
        early += abs(after - last[tip]) > TOO_EARLY * last[tip]
    return {"followed": len(steady), "early": early}, faults


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

    Counts the contact forces seen; "penetration" is the largest one, or gap at a force, in units of
    round-off. Points that diverged are left out.
    """
    fine = np.flatnonzero(result.point_status != DIVERGED)
    if not len(fine):
        return {}, []
    grid = cut_revolution(speeds[speed_bands(speeds)[0][0]], scene)
    bank = allocate(modes, scene, grid, WIDTH, speeds)
    run(bank, 1)
    table = bank.scheme.bump
    shown = scene.casing.table(scene.interface.angle, grid.steps_per_revolution, len(table))
    row, radial = np.zeros((1, table.shape[1])), bank.scheme.normal[:, : shown.shape[1]].T
    one = bank._replace(scheme=bank.scheme._replace(bump=row))
    worst, contacts, faults = 0.0, 0, set()
    # steps that end a little after a bump has passed a blade
    last = min(len(shown), int(np.argmax(shown.max(axis=1))) + STEPWISE // 2)
    for step in range(max(0, last - STEPWISE), last):
        row[0] = table[step]
        bank.state.multiplier[:] = 0.0
        run(one, 1)
        wall = bank.state.ramp * shown[step][:, None]
        force = bank.state.multiplier[: len(radial), fine]
        depth = (radial @ bank.state.position + wall - scene.clearance)[:, fine]
        size = (np.abs(radial) @ np.abs(bank.state.position) + wall + scene.clearance)[:, fine]
        # p and Wλ are sums over the modes; the solver stops at 1e-12 of the deepest penetration
        unit = (len(modes.omega) + 1) * np.finfo(float).eps * size.max(axis=0) + 5e-324
        gap = np.where(force > 0.0, np.abs(depth), depth)
        worst = np.max([worst, (gap / unit).max()])  # NaN stays
        contacts += int((force > 0.0).sum())
        if not force.min() >= 0.0:
            faults.add("tension in a contact")
    if not worst <= MOST_ROUND_OFF:
        faults.add(f"penetration or gap at a contact of {worst:.3g} units of round-off")
    return {"penetration": float(worst), "contacts": contacts}, sorted(faults)


def refine(modes, scene, speeds, result):
    """Points that diverged, with a quarter of the step: it must then diverge too, or be coarse.

    A chaotic motion as large as the disk passes the limit at one step and stays below at another.
    Copies of it at speeds next to each other tell: at a quarter of the step, too, some of them
    must come near the limit.

    Counts points that do not diverge with a quarter of the step ("unconfirmed"); a fault is each of
    these whose copies stay away from the limit, at a fine step within the limit of stability.
    """
    failed = np.flatnonzero(
        np.isin(result.point_reason, (status.NOT_FINITE, status.TOO_LARGE, status.UNSOLVED))
    )
    if not len(failed):
        return {}, []
    finer = scene._replace(step=scene.step / 4.0)
    again = run_sweep(modes, finer, speeds, width=WIDTH, selection=failed)
    well = failed[again.point_status[failed] != DIVERGED]
    stable = scene.scheme == "exact_modal" or scene.step * modes.omega.max() < 2.0
    if not stable or scene.step > LARGEST_FINE_STEP:
        return {"unconfirmed": len(well)}, []
    copies = 1.0 + APART * np.arange(COPIES)
    near = NEAR * scene.interface.radius.max()

    def comes_near(speed):
        found = run_sweep(modes, finer, speed * copies, width=WIDTH)
        return (found.point_status == DIVERGED).any() or found.amplitude.max() > near

    alone = [i for i in well if not comes_near(speeds[i])]
    words = sorted({status.WORDS[r] for r in result.point_reason[alone]})
    return {"unconfirmed": len(well)}, [f"{w}, but not with a quarter of the step" for w in words]


def audited(modes, scene, speeds, result):
    """All speeds with their energy audited, as long as the longest: no energy from nowhere.

    Counts the points that touched ("audited"), and those whose audit does not close ("unbalanced").
    """
    grid = cut_revolution(speeds.min(), scene)
    n_blocks = int(np.round(result.time * speeds * grid.blocks_per_revolution).max())
    if not n_blocks:
        return {}, []  # no bump reaches a tip: nothing was integrated
    lanes = allocate(modes, scene, grid, WIDTH, speeds)
    balanced = audit(lanes, n_blocks * len(lanes.scheme.bump)).is_balanced()[: len(speeds)]
    n_open = np.count_nonzero(~balanced & (result.point_status != DIVERGED))
    faults = ["the energy audit does not close"] if n_open else []
    return {"audited": np.count_nonzero(result.max_sweeps), "unbalanced": n_open}, faults


@by_band
def histories(modes, scene, speeds, result):
    """All speeds as histories, each as long as in the sweep.

    No NaN, tension or penetration without a fatal reason, a reason where the sweep has one and
    nowhere else, and the sweep's amplitude.
    """
    grid, faults = cut_revolution(speeds.min(), scene), set()
    per_turn = grid.blocks_per_revolution
    ends = np.round(result.time * speeds * per_turn).astype(int)
    if not ends.any():
        return {}, []  # no bump reaches a tip: nothing was integrated
    window = scene.steady.window_revolutions * per_turn
    amplitude, failed = np.zeros(len(speeds)), np.zeros(len(speeds), dtype=bool)
    duration = (ends.max() - 0.5) / (speeds.max() * per_turn)
    for block, piece in enumerate(history.integrate(modes, scene, speeds, duration), 1):
        lost = status.are_fatal(piece.reason)
        failed[block == ends] = lost[block == ends]
        last = (block <= ends) & (block > ends - window) & ~lost
        amplitude[last] = np.maximum(amplitude[last], piece.peak[:, last].max(axis=0))
        for values in (piece.time, piece.position, piece.normal_force, piece.tangential_force):
            if not np.isfinite(values[..., ~lost]).all():
                faults.add("NaN or infinity in a history without a reason")
        faults |= set(_depth(modes, scene, speeds, piece, np.flatnonzero(last)))
    if not np.array_equal(failed, result.point_status == DIVERGED):
        faults.add("a history fails where its sweep does not, or the other way round")
    well = ~failed & (result.point_status != DIVERGED)
    if not np.allclose(amplitude[well], result.amplitude[well], rtol=1e-9, atol=0.0):
        faults.add("a history has another amplitude than its sweep")
    return {"histories": len(speeds)}, sorted(faults)


def _depth(modes, scene, speeds, piece, lanes):
    """Contact law at the records of some lanes."""
    for lane in lanes:
        q = piece.position[:, :, lane]
        time, radial = piece.time[:, lane], q @ modes.normal.T
        depth = -gap(scene, speeds[lane], time, radial)
        size = np.abs(q) @ np.abs(modes.normal.T) + scene.casing.bump_height + scene.clearance
        unit = (len(modes.omega) + 1) * np.finfo(float).eps * size.max() + 5e-324
        # the casing's own angle is rounded, too
        turns = 2.0 * np.pi * (speeds[lane] * time[-1] + 1.0) * np.finfo(float).eps
        unit += turns * STEEPEST * scene.casing.n_bumps * scene.casing.bump_height
        if not depth.max() <= MOST_ROUND_OFF * unit:
            yield "a history goes through the casing without a reason"
        if not piece.normal_force[..., lane].min() >= 0.0:
            yield "tension in a contact of a history"
