"""Second order of a blade: CalculiX bends it into its modes.

CalculiX: a static step with geometric nonlinearity moves all nodes in proportion to a mode, and the
next one stores the stiffness about it. Any amplitude gives the same, for this stiffness is a
polynomial of second degree in the displacements.
"""

from collections.abc import Callable
from pathlib import Path

import numpy as np

from evidence import calculix
from evidence.calculix import Mesh
from hpcrub.model.imported import assembly, bending
from hpcrub.model.imported.bent_blades import BentBlades
from hpcrub.model.imported.craig_bampton import lowest_modes
from hpcrub.model.imported.frames import to_cartesian
from hpcrub.model.imported.neutral import NeutralModel

N_BENT = 3
LARGEST = 1.0  # displacement [mm]


def by_calculix(
    mesh: Mesh, read: Callable[[Path], NeutralModel], folder: Path
) -> tuple[NeutralModel, BentBlades]:
    """One blade alone by CalculiX, and its second order.

    mesh: its blade elements are the blade, its set root is held; read: function from the path of a
    deck, whose matrices CalculiX has written, to a model of this blade.
    """

    def solved(name, steps):
        path = folder / f"{name}.inp"
        calculix.solve(path, mesh, steps, blade=True)
        return read(path)

    blade = solved("held", calculix.held(mesh.sets["root"]) + calculix.STEP + calculix.STORE)
    shapes = []
    for number, moved in enumerate(modes(blade, N_BENT), 1):
        forwards = solved(f"bent_{number}_forwards", bent(mesh, moved))
        backwards = solved(f"bent_{number}_backwards", bent(mesh, -moved))
        shapes.append(bending.BentShape(1e-3 * moved, forwards, backwards))
    return blade, bending.of_blade(blade, shapes)


def modes(blade: NeutralModel, n_modes: int) -> np.ndarray:
    """First modes of a blade: displacements x, y, z (n_modes, n, 3), LARGEST at most [mm]."""
    alone = assembly.assemble(blade)
    phi = lowest_modes(alone.stiffness[0].tocsc(), alone.mass.tocsc(), n_modes)[1]
    moved = np.where(alone.row[..., None] >= 0, phi[alone.row], 0.0)  # (n, 3, n_modes)
    moved = to_cartesian(np.nan_to_num(alone.nodes), moved).transpose(2, 0, 1)
    return moved * (LARGEST / np.linalg.norm(moved, axis=2).max(axis=1))[:, None, None]


def bent(mesh: Mesh, moved: np.ndarray) -> str:
    """Steps that store the stiffness about displacements of all nodes (n, 3) [mm], root held."""
    root = mesh.sets["root"]
    free = np.setdiff1d(np.unique(mesh.elements[mesh.blade_elements]), root)
    rows = [f"{n + 1}, {d}, {d}, {moved[n, d - 1]:.12e}\n" for n in free for d in (1, 2, 3)]
    state = calculix.held(root) + calculix.STATIC + "*BOUNDARY\n" + "".join(rows) + calculix.END
    return state + calculix.PERTURBED + calculix.held(root, ", OP=NEW") + calculix.STORE
