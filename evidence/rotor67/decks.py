"""Decks of CalculiX for one sector of the fan.

Stiffness at speed is that of a *free* sector about the state of the whole
disk: a first job with cyclic symmetry gives the displacements; a second one, without, moves the
sides by them, and lets them go in its last step, which stores the matrices. CalculiX would
eliminate the rows of the sides if that step had cyclic symmetry itself.
"""

import numpy as np

from evidence import calculix as ccx
from evidence.calculix import Mesh


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
    rows = [f"{n + 1}, {d}, {d}, {moved[n, d - 1]:.12e}\n" for n in sides for d in (1, 2, 3)]
    state = ccx.STATIC + "*BOUNDARY\n" + "".join(rows) + _loaded(speed)
    return ccx.held(bore) + state + ccx.PERTURBED + ccx.held(bore, ", OP=NEW") + ccx.STORE
