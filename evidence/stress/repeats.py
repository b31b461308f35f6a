"""The same case once more: step by step with its energy audited, and as a whole history."""

import numpy as np

from evidence.truth.energy import audit
from hpcrub.contact import status
from hpcrub.contact.bank import allocate
from hpcrub.contact.status import DIVERGED
from hpcrub.response import history
from hpcrub.response.revolution import cut_revolution, speed_bands
from hpcrub.studies.time_response import gap

STEEPEST = np.sqrt(2.0 / np.e) / (0.2 * np.pi)  # slope of a bump, of its height and their number


def audited(modes, scene, speeds, result, width):
    """All speeds with their energy audited, as long as the longest: no energy from nowhere.

    Returns the number of points that touched, those whose audit does not close, and faults.
    """
    grid = cut_revolution(speeds.min(), scene)
    n_blocks = int(np.round(result.time * speeds * grid.blocks_per_revolution).max())
    if not n_blocks:
        return 0, 0, []  # no bump reaches a tip: nothing was integrated
    lanes = allocate(modes, scene, grid, width, speeds)
    balanced = audit(lanes, n_blocks * len(lanes.scheme.bump)).is_balanced()[: len(speeds)]
    n_open = np.count_nonzero(~balanced & (result.point_status != DIVERGED))
    faults = ["the energy audit does not close"] if n_open else []
    return int(np.count_nonzero(result.max_sweeps)), n_open, faults


def whole(modes, scene, speeds, result, allowed):
    """All speeds as histories, band by band as in the sweep, each as long as there.

    No NaN, tension or penetration without a fatal reason, a reason where the sweep has one and
    nowhere else, and the sweep's amplitude. `allowed`: penetration, in units of
    round-off. Returns the number of histories, and faults.
    """
    found = [
        _whole_band(modes, scene, speeds[band], _of_band(result, band), allowed)
        for band in speed_bands(speeds)
    ]
    return sum(n for n, _ in found), sorted({fault for _, faults in found for fault in faults})


def _of_band(result, band):
    names = "time", "point_status", "amplitude"
    return result._replace(**{name: getattr(result, name)[band] for name in names})


def _whole_band(modes, scene, speeds, result, allowed):
    """`whole` of the speeds of one band, which share a grid."""
    grid, faults = cut_revolution(speeds.min(), scene), set()
    per_turn = grid.blocks_per_revolution
    ends = np.round(result.time * speeds * per_turn).astype(int)
    if not ends.any():
        return 0, []  # no bump reaches a tip: nothing was integrated
    window = scene.steady.window_revolutions * per_turn
    amplitude, failed = np.zeros(len(speeds)), np.zeros(len(speeds), dtype=bool)
    duration = (ends.max() - 0.5) / (speeds.max() * per_turn)
    for block, piece in enumerate(history.integrate(modes, scene, speeds, duration), 1):
        lost = status.are_fatal(piece.reason)
        failed[block == ends] = lost[block == ends]
        last = (block <= ends) & (block > ends - window) & ~lost
        amplitude[last] = np.maximum(amplitude[last], piece.peak[:, last].max(axis=0))
        faults |= set(_odd(piece, ~lost))
        faults |= set(_depth(modes, scene, speeds, piece, np.flatnonzero(last), allowed))
    if not np.array_equal(failed, result.point_status == DIVERGED):
        faults.add("a history fails where its sweep does not, or the other way round")
    well = ~failed & (result.point_status != DIVERGED)
    if not np.allclose(amplitude[well], result.amplitude[well], rtol=1e-9, atol=0.0):
        faults.add("a history has another amplitude than its sweep")
    return len(speeds), faults


def _odd(piece, well):
    forces = piece.normal_force, piece.tangential_force
    if not all(np.isfinite(v[..., well]).all() for v in (piece.time, piece.position, *forces)):
        yield "NaN or infinity in a history without a reason"


def _depth(modes, scene, speeds, piece, lanes, allowed):
    """Contact law at the records of some lanes."""
    for lane in lanes:
        q = piece.position[:, :, lane]
        time, radial = piece.time[:, lane], q @ modes.normal.T
        depth = -gap(scene, speeds[lane], time, radial)
        size = np.abs(q) @ np.abs(modes.normal.T) + scene.bump_height + scene.clearance
        unit = (len(modes.omega) + 1) * np.finfo(float).eps * size.max() + 5e-324
        # the casing's own angle is rounded, too
        turns = 2.0 * np.pi * (speeds[lane] * time[-1] + 1.0) * np.finfo(float).eps
        unit += turns * STEEPEST * scene.n_bumps * scene.bump_height
        if not depth.max() <= allowed * unit:
            yield "a history goes through the casing without a reason"
        if not piece.normal_force[..., lane].min() >= 0.0:
            yield "tension in a contact of a history"
