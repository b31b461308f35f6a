"""Step of fans of more of rotor 67's blades: ``python -m evidence.benchmarks.blades``.

The harmonics of another number of blades are those of rotor 67 at the nearest phase, split by 0.4 %
of their stiffness at most, so that no two are alike.
"""

import os
import tempfile
import time
from pathlib import Path
from unittest import mock

import numpy as np

from hpcrub.config.schema import load_runs
from hpcrub.contact.arrays import arrays_of
from hpcrub.contact.bank import allocate
from hpcrub.contact.integrate import run
from hpcrub.model.imported.arrays import symmetric
from hpcrub.response.revolution import cut_revolution
from hpcrub.results import model_file
from hpcrub.setup.disks import deviation, rubbing_modes
from hpcrub.setup.imported import resolved
from hpcrub.setup.problem import build_problem

INPUT = "inputs/rotor67/percentiles.yaml"
SPEEDS = np.linspace(256.0, 262.0, 8)  # [Hz], of the lanes
KNOWN, SPLIT = 22, 4e-3  # blades of rotor 67; part of the stiffness
STIFFNESS = "K0", "K1", "K2"
NO_STRESS = ("limits.stress_mpa=null", "limits.strength_mpa=null")


def spread(matrix, n_blades, split=0.0):
    """Matrix (n·m, n·k) of a disk of n alike blades, by one (22·m, 22·k) of rotor 67."""
    m, k = (length // KNOWN for length in matrix.shape)
    column, h = matrix[:, :k].reshape(KNOWN, m, k), np.arange(n_blades)
    apart = (np.arange(KNOWN) + KNOWN // 2) % KNOWN - KNOWN // 2
    folded = np.where(h <= n_blades // 2, h, h - n_blades)
    nearest = 2.0 * np.pi * np.round(folded * KNOWN / n_blades) / KNOWN
    parts = np.tensordot(np.exp(-1j * np.outer(nearest, apart)), column, axes=1)
    parts[2 * np.abs(folded) == n_blades] = parts[2 * np.abs(folded) == n_blades].real
    parts *= (1.0 + split * np.abs(folded) / n_blades)[:, None, None]
    blocks = np.fft.ifft(parts, axis=0).real
    rows = blocks[(h[:, None] - h) % n_blades]  # (n, n, m, k)
    return rows.transpose(0, 2, 1, 3).reshape(n_blades * m, n_blades * k)


def fan(n_blades, path):
    """Write the model file of a fan."""
    known = model_file.read("inputs/rotor67/rotor67.h5")
    left_out = ("stress", "second_order")
    made = {name: array for name, array in known.items() if not name.startswith(left_out)}
    split = SPLIT if n_blades != KNOWN else 0.0
    for name in (*STIFFNESS, "M"):
        found = spread(symmetric(name, known[name]), n_blades, split * (name in STIFFNESS))
        made[name] = (found + found.T) / 2.0
    modes = known["blade_participation"]
    flat = spread(modes.reshape(-1, modes.shape[2]), n_blades)
    made["blade_participation"] = flat.reshape(n_blades, modes.shape[1], -1)
    made["blade_frequencies_hz"] = np.tile(known["blade_frequencies_hz"][:1], (n_blades, 1))
    n = len(known["nodes"]) // KNOWN
    blade = np.repeat(np.arange(n_blades), n)
    (x, y, z), turn = np.tile(known["nodes"][:n].T, n_blades), 2.0 * np.pi * blade / n_blades
    around = (x + 1j * y) * np.exp(1j * turn)
    made["nodes"] = np.stack([around.real, around.imag, z], axis=1)
    dof = np.tile(known["dof"][: len(known["dof"]) // KNOWN], (n_blades, 1, 1))
    dof[..., 0] += np.where(dof[..., 1] > 0, n * np.arange(n_blades)[:, None], 0)
    made["dof"] = dof.reshape(-1, 2)
    made["contact_node"], made["contact_blade"] = np.arange(n * n_blades), blade
    made["contact_clearance"] = np.tile(known["contact_clearance"][:n], n_blades)
    made["contact_normal"] = np.tile(known["contact_normal"][:n], (n_blades, 1))
    model_file.write(path, made)


def step_of(path, basis):
    """Microseconds of a step of all lanes in contact, and MiB of a bank."""
    config = resolved(load_runs(INPUT, [f"disk.model={path}", *NO_STRESS])[0])
    with mock.patch.dict(os.environ, HPCRUB_BASIS=basis):
        problem = build_problem(config)
    modes = rubbing_modes(config, problem, deviation(config, 0, 0))
    grid = cut_revolution(SPEEDS[0], problem.scene)
    bank = allocate(modes, problem.scene, grid, len(SPEEDS), SPEEDS)
    run(bank, 40)
    taken = []
    for _ in range(8):
        began = time.process_time()
        run(bank, 2)
        taken.append((time.process_time() - began) / (2 * grid.steps_per_block))
    return 1e6 * min(taken), sum(array.nbytes for array in arrays_of(bank)) / 2**20


def main():
    """Print the table."""
    with tempfile.TemporaryDirectory() as folder:
        for n_blades in (22, 36, 72):
            path = Path(folder) / f"{n_blades}.h5"
            fan(n_blades, path)
            for basis in ("cyclic", "dense"):
                print(n_blades, basis, *(f"{x:.1f}" for x in step_of(path, basis)), flush=True)


if __name__ == "__main__":
    main()
