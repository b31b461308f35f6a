"""What another rounding changes: BLAS threads, compiler target, order of lanes, a nudge of 1e-12.

Every variant runs the same points for the same time in a process of its own and saves the last
three revolutions. A point is chaotic if two runs in one process, which differ by NUDGE in the
initial state, end up further apart than they began by a factor of GROWTH.
"""

import itertools
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from hpcrub.contact import arrays, kernel
from hpcrub.contact.bank import allocate
from hpcrub.contact.lanes import aligned_zeros
from hpcrub.model.mistuning import stiffness_deviation
from hpcrub.model.reduction import mistuned_modes
from hpcrub.response.sweep import cut_revolution
from tests.truth.disk import reference_reduced, reference_scene

NUDGE = 1e-12  # of the modal coordinates [m·√kg], at most
GROWTH = 1e3
TOLERANCE = 1e-6  # of the amplitude, for points that are not chaotic
DURATION = 5.0  # [s]: a nudge must have died away where the motion is periodic
WIDTH = 8
SPEEDS = np.linspace(28.0, 35.5, 16)  # [Hz]
HALF_RANGES = (0.0, 0.04)
DAMPING = (0.005, 0.01, 0.02, 0.05)  # ratios; the first is the reference disk's
VARIANTS = {
    "2 BLAS threads": {"OPENBLAS_NUM_THREADS": "2", "OMP_NUM_THREADS": "2"},
    "generic compiler target": {"NUMBA_CPU_NAME": "generic", "NUMBA_CPU_FEATURES": ""},
}


def motions(reverse=False, nudge=0.0):
    """u_t over the last three revolutions of all points (points, records, N) [m]."""
    reduced, found = reference_reduced(), []
    for damping_ratio, half_range in itertools.product(DAMPING, HALF_RANGES):
        scene = reference_scene(scheme="exact_modal", step=2e-5, damping_ratio=damping_ratio)
        modes = mistuned_modes(reduced, stiffness_deviation(2020, 0, 0, 12, half_range))
        grid = cut_revolution(SPEEDS[0], scene)
        for batch in np.split(SPEEDS, len(SPEEDS) // WIDTH):
            order = batch[::-1] if reverse else batch
            history = _march(modes, scene, grid, order, nudge)
            found.append(history[::-1] if reverse else history)
    return np.concatenate(found)


def _march(modes, scene, grid, speeds, nudge):
    per_turn = grid.blocks_per_revolution
    n_last = 3 * per_turn
    n_first = int(DURATION * speeds.min() * per_turn)
    bank = allocate(modes, scene, grid, WIDTH, speeds)
    n_modes = len(modes.omega)  # not alike: else equal blades would stay equal
    bank.state.position[:n_modes] += nudge * np.cos(np.arange(n_modes))[:, None]
    n_points, n_records = bank.scheme.observed.shape[1], grid.steps_per_block // grid.stride
    record = arrays.Record(
        aligned_zeros((n_last * n_records * n_points, WIDTH)),
        aligned_zeros((n_last * n_points, WIDTH)),
    )
    kernel.integrate((0,) * WIDTH, *bank, n_first, -1, grid.stride)
    kernel.integrate((0,) * WIDTH, *bank._replace(record=record), n_last, 0, grid.stride)
    history = record.history.reshape(n_last * n_records, n_points, WIDTH)
    return np.moveaxis(history, 2, 0)[:, :, : len(modes.observed)]


def compare():
    """Dict of results and a list of faults."""
    reference, nudged = motions(), motions(nudge=NUDGE)
    size = np.abs(reference).max(axis=(1, 2))
    distance = np.abs(nudged - reference).max(axis=(1, 2))
    # u_t of one unit of each mode is below 1, so that distances start below NUDGE times the modes
    chaotic = distance > GROWTH * NUDGE
    faults, changes = [], {}
    if not np.array_equal(motions(reverse=True), reference):
        faults.append("another order of lanes changes a bit")
    for name, environment in VARIANTS.items():
        other = _in_a_process(environment)
        change = np.abs(np.abs(other).max(axis=(1, 2)) / size - 1.0)
        changes[name] = change
        if not (change[~chaotic] <= TOLERANCE).all():
            worst = change[~chaotic].max()
            faults.append(f"{name}: a point that is not chaotic changes by {worst:.2g}")
    return {"chaotic": chaotic, "distance": distance / size, "changes": changes}, faults


def _in_a_process(environment):
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "motions.npy"
        command = [sys.executable, "-m", "evidence.stress.roundoff", str(out)]
        # a rank's own choice, made when the libraries are imported
        subprocess.run(command, check=True, env=os.environ | environment)
        return np.load(out)


if __name__ == "__main__":
    np.save(sys.argv[1], motions())
