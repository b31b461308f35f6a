"""Cost of a time step of rotor 67 against its number of blades (5 min), as a table on the screen.

`python -m evidence.benchmarks.fan_speed`. The fan of `inputs/rotor67` is cyclic: what one sector
feels of the others depends on the phase between neighbours alone. A fan of another number of blades
has other phases; each takes what the nearest phase of rotor 67 has, so that it is a fan of so many
of the same blades, each with the same contact points and modes. (Between the phases nothing is
known: the fixed-interface modes of each number of nodal diameters are others.) The limit is what a
step needs at the speed of large matrix products. The last line is the power with which the cost of
a step grows.
"""

import numpy as np
from scipy.linalg import eigh

from evidence.benchmarks.kernel_speed import Lanes, peak_gflops
from evidence.benchmarks.spatial_speed import Rubbing, needed_flops
from hpcrub.config.schema import load_runs
from hpcrub.model.imported import neutral
from hpcrub.model.imported.stiffness import stiffness_at
from hpcrub.model.reduction import Modes
from hpcrub.results import model_file
from hpcrub.setup.imported import resolved
from hpcrub.setup.problem import build_problem

INPUT = "inputs/rotor67/contact.yaml"
SPEEDS = 258.0, 264.0  # [Hz] where the tips rub
TURNS = 12  # until they do
BLADES = 11, 16, 22, 33, 44
POINTS, MODES = 6, 14  # of each blade
WIDTH = 8
MISTUNING = 0.02  # of the stiffness of a blade's modes, half range
BLOCKS = 2  # timed
LOOKS = 12  # at the points in contact, over a block


def fan(n_blades, n_points=POINTS, n_modes=MODES):
    """Modes and Scene of so many blades, mistuned, with some of their points and modes each."""
    config = resolved(load_runs(INPUT)[0])
    scene = build_problem(config).scene
    model = neutral.from_arrays(model_file.read(config.disk.model))
    N, speed = model.n_blades, 2 * np.pi * np.mean(SPEEDS)
    matrices = stiffness_at(model.stiffness, speed), model.mass
    size = len(model.mass) // N
    own = len(model.contact_node) // N
    chosen = np.linspace(0, own - 1, n_points).round().astype(int)
    face = scene.interface
    rows = np.stack([part[:own, :size] for part in (face.normal, face.tangential, face.axial)])
    rows = rows[:, chosen]  # (directions, points, coordinates of a sector)
    values, shapes = [], []
    sector = np.arange(n_blades)
    for h in range(n_blades // 2 + 1):
        phase = 2 * np.pi * h / n_blades
        nearest = 2 * np.pi * round(h * N / n_blades) / N
        found, vectors = eigh(*(_part(a, size, nearest) for a in matrices),
                              subset_by_index=[0, n_modes - 1])  # fmt: skip
        wave = np.exp(1j * phase * sector) / np.sqrt(n_blades)
        moved = np.einsum("dpm,mk,n->dnpk", rows, vectors, wave).reshape(3, -1, n_modes)
        single = h == 0 or 2 * h == n_blades
        both = [moved.real] if single else [np.sqrt(2) * moved.real, np.sqrt(2) * moved.imag]
        values += [found] * len(both)
        shapes += both
    values, shapes = np.concatenate(values), np.concatenate(shapes, axis=2)
    values *= 1 + MISTUNING * np.random.default_rng(1).uniform(-1, 1, len(values))
    order = np.argsort(values)
    normal, tangential, axial = shapes[:, :, order]
    modes = Modes(np.sqrt(values[order]), normal, tangential, axial, tangential,
                  np.eye(len(values)))  # fmt: skip
    blade = np.repeat(sector, n_points)
    face = face._replace(
        blade=blade,
        angle=np.tile(face.angle[chosen], n_blades) + 2 * np.pi * blade / n_blades,
        radius=np.tile(face.radius[chosen], n_blades),
        axial_position=np.tile(face.axial_position[chosen], n_blades),
        clearance=np.tile(face.clearance[chosen], n_blades),
        normal=normal, tangential=tangential, axial=axial,
        observed=tangential, observed_blade=blade,
    )  # fmt: skip
    return modes, scene._replace(interface=face)


def _part(matrix, size, phase):
    """What one sector feels of all, each turned by a phase against the last one."""
    N = len(matrix) // size
    column = matrix[:, :size].reshape(N, size, size)
    d = (np.arange(N) + (N - 1) // 2) % N - (N - 1) // 2
    weight = np.where(2 * d == N, 0.5, 1.0)
    part = np.tensordot(weight * np.exp(-1j * phase * d), column, axes=1)
    if N % 2 == 0:
        part += 0.5 * np.exp(1j * phase * N / 2) * column[N // 2]
    return (part + part.conj().T) / 2


def step_of(n_blades):
    """Microseconds of a step and lane, those of its limit, points in contact, most sets tried."""
    model = fan(n_blades)
    lanes = Lanes(WIDTH, model=model, speeds=SPEEDS, warm=TURNS * model[1].n_bumps)
    cost, limit = 1e6 / lanes.rate(BLOCKS), peak_gflops()
    contacts = Rubbing.contacts(lanes, LOOKS)
    flops = needed_flops(MODES * n_blades, POINTS * n_blades, contacts)
    return cost, 1e-3 * flops / limit, contacts, int(lanes.bank.state.report[0].max())


def main():
    """Print the table; returns its rows."""
    print("blades  points  modes  us a step and lane  limit [us]  in contact  most sets")
    rows = []
    for n_blades in BLADES:
        cost, limit, contacts, most = step_of(n_blades)
        rows.append((n_blades, cost))
        print(f"{n_blades:6d} {POINTS * n_blades:7d} {MODES * n_blades:6d} {cost:19.2f} "
              f"{limit:11.2f} {contacts:11.1f} {most:10d}", flush=True)  # fmt: skip
    blades, cost = np.log(np.array(rows)).T
    print(f"power of the number of blades: {np.polyfit(blades, cost, 1)[0]:.2f}")
    return rows


if __name__ == "__main__":
    main()
