"""Decks of CalculiX for the blisk: matrices at rest and at speed, of the blades, and frequencies.

Units: mm, t, s, N, MPa.
"""

from pathlib import Path

import numpy as np

from evidence.blisk.mesh import Mesh

YOUNG, POISSON, DENSITY = 113_800.0, 0.33, 4.43e-9  # Ti-6Al-4V [MPa, -, t/mm3]
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
    """Write a deck.

    Parameters
    ----------
    path : NAME.inp
    mesh : Mesh
    steps : text of the steps
    held : nodes that are held
    elements : numbers of the elements, all by default
    head : text before the steps
    """
    chosen = np.arange(len(mesh.elements)) if elements is None else elements
    lines = ["*NODE, NSET=NALL"]
    lines += [f"{n}, {x:.14g}, {y:.14g}, {z:.14g}" for n, (x, y, z) in enumerate(mesh.nodes, 1)]
    lines += ["*ELEMENT, TYPE=C3D8I, ELSET=EALL"]
    lines += [f"{e + 1}, " + ", ".join(map(str, mesh.elements[e] + 1)) for e in chosen]
    for name, nodes in mesh.sets.items():
        lines += [f"*NSET, NSET={name.upper()}"]
        lines += [", ".join(map(str, nodes[k : k + 10] + 1)) for k in range(0, len(nodes), 10)]
    lines += ["*MATERIAL, NAME=TI64", "*ELASTIC", f"{YOUNG}, {POISSON}", "*DENSITY", f"{DENSITY}"]
    lines += ["*SOLID SECTION, ELSET=EALL, MATERIAL=TI64"]
    if len(held):
        lines += ["*BOUNDARY", *(f"{node + 1}, 1, 3" for node in held)]
    path.write_text("\n".join(lines) + "\n" + head + steps, "ascii")
