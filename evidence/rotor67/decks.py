"""Decks of CalculiX for one sector of the fan.

Stiffness at speed is that of a *free* sector about the state of the whole
disk: a first job with cyclic symmetry gives the displacements; a second one, without, moves the
sides by them, and lets them go in its last step, which stores the matrices. CalculiX would
eliminate the rows of the sides if that step had cyclic symmetry itself.
"""

from pathlib import Path

import numpy as np

from evidence import calculix as ccx
from evidence.rotor67.mesh import Mesh


def _loaded(speed):
    return ccx.SPINNING.format(speed**2) + "*NODE PRINT, NSET=NALL\nU\n" + ccx.END


def at_rest(mesh: Mesh) -> str:
    """Step that stores the matrices of the free sector at rest."""
    return ccx.held(mesh.sets["bore"]) + ccx.STEP + ccx.STORE


def cyclic_state(mesh: Mesh, n_sectors: int, speed: float) -> str:
    """Step that prints the displacements of the whole disk at a speed [rad/s]."""
    inner = np.setdiff1d(mesh.sets["bore"], mesh.sets["low"])  # the tie moves its first surface
    return ccx.CYCLIC.format(n_sectors) + ccx.held(inner) + ccx.STATIC + _loaded(speed)


def about_state(mesh: Mesh, speed: float, moved: np.ndarray) -> str:
    """Steps that store the matrices of the free sector about the state at a speed [rad/s].

    moved: displacements of all nodes in that state (n, 3) [mm].
    """
    bore = mesh.sets["bore"]
    sides = np.setdiff1d(np.concatenate([mesh.sets["low"], mesh.sets["high"]]), bore)
    rows = [
        f"{node + 1}, {d + 1}, {d + 1}, {moved[node, d]:.12e}\n" for node in sides for d in range(3)
    ]
    state = ccx.STATIC + "*BOUNDARY\n" + "".join(rows) + _loaded(speed)
    return ccx.held(bore) + state + ccx.PERTURBED + ccx.held(bore, ", OP=NEW") + ccx.STORE


def cyclic_frequencies(mesh: Mesh, n_sectors: int, speed: float, n_modes: int) -> str:
    """Steps that print frequencies of the whole disk at a speed [rad/s], 0 to 3 diameters."""
    return cyclic_state(mesh, n_sectors, speed) + ccx.PERTURBED + ccx.frequencies_of(n_modes, 3)


def alone(mesh: Mesh, n_modes: int) -> str:
    """Step that prints frequencies of the blade alone, its root held, at rest."""
    return ccx.held(mesh.sets["root"]) + ccx.STEP + ccx.frequencies_of(n_modes)


def write(path: Path, mesh: Mesh, steps: str, blade: bool = False) -> None:
    """Write a deck of a mesh, or of its blade's elements alone, and the steps after it."""
    ccx.write(path, mesh, "C3D20R", steps, range(mesh.n_blade_elements) if blade else None)
