"""Decks of CalculiX for one sector of the fan.

Stiffness at speed is that of a *free* sector about the state of the whole
disk: a first job with cyclic symmetry gives the displacements; a second one, without, moves the
sides by them, and lets them go in its last step, which stores the matrices. CalculiX would
eliminate the rows of the sides if that step had cyclic symmetry itself.
"""

from pathlib import Path

import numpy as np

from evidence.calculix import CYCLIC, mesh_text
from evidence.rotor67.mesh import Mesh

ELEMENT = "C3D20R"
STORE = "*FREQUENCY, SOLVER=MATRIXSTORAGE\n10\n*END STEP\n"
PERTURBED = "*STEP, PERTURBATION\n"
LOADED = """\
*DLOAD
EALL, CENTRIF, {:.12g}, 0., 0., 0., 0., 0., 1.
*NODE PRINT, NSET=NALL
U
*END STEP
"""


def at_rest(mesh: Mesh) -> str:
    """Step that stores the matrices of the free sector at rest."""
    return _held(mesh.sets["bore"]) + "*STEP\n" + STORE


def cyclic_state(mesh: Mesh, n_sectors: int, speed: float) -> str:
    """Step that prints the displacements of the whole disk at a speed [rad/s]."""
    held = np.setdiff1d(mesh.sets["bore"], mesh.sets["low"])  # the tie moves its first surface
    step = "*STEP, NLGEOM\n*STATIC\n" + LOADED.format(speed**2)
    return CYCLIC.format(n_sectors) + _held(held) + step


def about_state(mesh: Mesh, speed: float, moved: np.ndarray) -> str:
    """Steps that store the matrices of the free sector about the state at a speed [rad/s].

    moved: displacements of all nodes in that state (n, 3) [mm].
    """
    bore = mesh.sets["bore"]
    sides = np.setdiff1d(np.concatenate([mesh.sets["low"], mesh.sets["high"]]), bore)
    rows = [
        f"{node + 1}, {d + 1}, {d + 1}, {moved[node, d]:.12e}\n" for node in sides for d in range(3)
    ]
    return (
        _held(bore) + "*STEP, NLGEOM\n*STATIC\n*BOUNDARY\n" + "".join(rows)
        + LOADED.format(speed**2)
        + PERTURBED + _held(bore, ", OP=NEW") + STORE
    )  # fmt: skip


def cyclic_frequencies(mesh: Mesh, n_sectors: int, speed: float, n_modes: int) -> str:
    """Steps that print frequencies of the whole disk at a speed [rad/s], 0 to 3 diameters."""
    step = f"*FREQUENCY\n{n_modes}\n*SELECT CYCLIC SYMMETRY MODES, NMIN=0, NMAX=3\n*END STEP\n"
    return cyclic_state(mesh, n_sectors, speed) + PERTURBED + step


def alone(mesh: Mesh, n_modes: int) -> str:
    """Step that prints frequencies of the blade alone, its root held, at rest."""
    return _held(mesh.sets["root"]) + f"*STEP\n*FREQUENCY\n{n_modes}\n*END STEP\n"


def _held(nodes, options=""):
    return f"*BOUNDARY{options}\n" + "".join(f"{node + 1}, 1, 3\n" for node in nodes)


def write(path: Path, mesh: Mesh, steps: str, blade: bool = False, element: str = ELEMENT) -> None:
    """Write a deck of a mesh, or of its blade's elements alone, and the steps after it."""
    elements = mesh.elements[: mesh.n_blade_elements] if blade else mesh.elements
    text = mesh_text(mesh.nodes, dict(enumerate(elements)), element, mesh.sets)
    path.write_text(text + steps, "ascii")
