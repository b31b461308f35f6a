"""Decks of CalculiX for the blisk: matrices at rest and at speed, and frequencies."""

from pathlib import Path

import numpy as np

from evidence.blisk.mesh import Mesh
from evidence.calculix import mesh_text

STORE = "*STEP{}\n*FREQUENCY, SOLVER=MATRIXSTORAGE\n10\n*END STEP\n"

SPIN = "*STEP, NLGEOM\n*STATIC\n*DLOAD\nEALL, CENTRIF, {:.12g}, 0., 0., 0., 0., 0., 1.\n*END STEP\n"
DIAMETERS = """\
*STEP
*FREQUENCY
{}
*SELECT CYCLIC SYMMETRY MODES, NMIN=0, NMAX={}
*END STEP
"""


def frequencies(n_modes: int) -> str:
    """A step that prints natural frequencies, for `spinning`."""
    return f"*STEP{{}}\n*FREQUENCY\n{n_modes}\n*END STEP\n"


def spinning(speed: float, step: str) -> str:
    """A step about the state that a speed of rotation [rad/s] loads the disk to."""
    if not speed:
        return step.format("")
    return SPIN.format(speed**2) + step.format(", PERTURBATION")


def write(path: Path, mesh: Mesh, steps: str, held=(), elements=None, head: str = "") -> None:
    """Write a deck NAME.inp.

    held: nodes that are held; elements: numbers of the elements, all by default; head: text before
    the steps.
    """
    chosen = np.arange(len(mesh.elements)) if elements is None else elements
    corners = {int(e): mesh.elements[e] for e in chosen}
    text = mesh_text(mesh.nodes, corners, "C3D8I", mesh.sets)
    if len(held):
        text += "*BOUNDARY\n" + "".join(f"{node + 1}, 1, 3\n" for node in held)
    path.write_text(text + head + steps, "ascii")
