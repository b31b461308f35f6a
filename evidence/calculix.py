"""CalculiX: the mesh of a deck, running it, and what it prints.

Units of decks: mm, t, s, N, MPa.
"""

import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np

YOUNG, POISSON, DENSITY = 113_800.0, 0.33, 4.43e-9  # Ti-6Al-4V [MPa, -, t/mm3]
CYCLIC = """\
*SURFACE, NAME=SLOW, TYPE=NODE
LOW
*SURFACE, NAME=SHIGH, TYPE=NODE
HIGH
*TIE, NAME=SIDES, CYCLIC SYMMETRY
SLOW, SHIGH
*CYCLIC SYMMETRY MODEL, N={}, NGRAPH=1, TIE=SIDES
0., 0., 0., 0., 0., 1.
"""
STEP, PERTURBED, STATIC = "*STEP\n", "*STEP, PERTURBATION\n", "*STEP, NLGEOM\n*STATIC\n"
SPINNING = "*DLOAD\nEALL, CENTRIF, {:.12g}, 0., 0., 0., 0., 0., 1.\n"  # speed squared [rad2/s2]
END = "*END STEP\n"
STORE = f"*FREQUENCY, SOLVER=MATRIXSTORAGE\n10\n{END}"  # of the matrices
KINDS = {8: "C3D8I", 20: "C3D20R"}  # elements by their nodes


class Mesh(NamedTuple):
    """Nodes, elements and sets, counted from 0."""

    nodes: np.ndarray  # (n, 3) [mm]
    elements: np.ndarray  # (e, 8 or 20) in the order of CalculiX
    sets: dict  # names to nodes: low, high, bore, tip, root
    blade_elements: np.ndarray  # elements of the blades


def frequencies_of(n_modes: int, diameters: int | None = None) -> str:
    """The rest of a step that prints frequencies, of a cyclic sector up to so many diameters."""
    select = "*SELECT CYCLIC SYMMETRY MODES, NMIN=0, NMAX={}\n".format
    return f"*FREQUENCY\n{n_modes}\n{'' if diameters is None else select(diameters)}{END}"


def held(nodes: np.ndarray, options: str = "") -> str:
    """Nodes that are held, counted from 0."""
    return f"*BOUNDARY{options}\n" + "".join(f"{node + 1}, 1, 3\n" for node in nodes)


def write(path: Path, mesh: Mesh, steps: str, blade: bool = False) -> None:
    """Write a deck of titanium, or of its blades' elements alone, and the steps after it."""
    lines = ["*NODE, NSET=NALL"]
    lines += [f"{n}, {x:.14g}, {y:.14g}, {z:.14g}" for n, (x, y, z) in enumerate(mesh.nodes, 1)]
    lines += [f"*ELEMENT, TYPE={KINDS[mesh.elements.shape[1]]}, ELSET=EALL"]
    for number in mesh.blade_elements if blade else range(len(mesh.elements)):
        words = [str(n + 1) for n in (number, *mesh.elements[number])]
        lines += [", ".join(words[:11]) + "," * (len(words) > 11)]
        lines += [", ".join(words[11:])] * (len(words) > 11)
    for name, members in mesh.sets.items():
        lines += [f"*NSET, NSET={name.upper()}"]
        lines += [", ".join(map(str, members[k : k + 10] + 1)) for k in range(0, len(members), 10)]
    lines += ["*MATERIAL, NAME=TI64", "*ELASTIC", f"{YOUNG}, {POISSON}", "*DENSITY", f"{DENSITY}"]
    lines += ["*SOLID SECTION, ELSET=EALL, MATERIAL=TI64", steps]
    path.write_text("\n".join(lines), "ascii")


def run(path: Path) -> None:
    """Run CalculiX on a deck. Raises SystemExit when it is missing or fails."""
    if not shutil.which("ccx"):
        raise SystemExit("CalculiX (ccx) is missing: apt-get install calculix-ccx")
    print(f"ccx -i {path.stem}", flush=True)
    command = ["ccx", "-i", path.stem]
    done = subprocess.run(command, cwd=path.parent, capture_output=True, text=True)
    if "Job finished" not in done.stdout:
        raise SystemExit(f"ccx -i {path.stem} failed:\n{done.stdout[-1000:]}")


def solve(path: Path, mesh: Mesh, steps: str, blade: bool = False) -> Path:
    """`write` and `run`; returns the path of the .dat file."""
    write(path, mesh, steps, blade)
    run(path)
    return path.with_suffix(".dat")


def frequencies(path: Path, n_modes: int) -> np.ndarray:
    """Frequencies of a .dat file (n_modes,) [Hz]."""
    return np.array([row[3] for row in _rows(path) if len(row) == 5][:n_modes])


def by_diameters(path: Path) -> dict:
    """Frequencies [Hz] by nodal diameters of a .dat file of one sector; double ones once."""
    printed: dict = {}
    for row in _rows(path):
        if len(row) == 6:
            printed.setdefault(int(row[0]), []).append(row[4])
    return {diameters: np.array(f)[::2] for diameters, f in printed.items()}


def displacements(path: Path, n_nodes: int) -> np.ndarray:
    """Displacements printed last in a .dat file (n_nodes, 3) [mm]."""
    moved = np.zeros((n_nodes, 3))
    for row in _rows(path):
        if len(row) == 4:
            moved[int(row[0]) - 1] = row[1:]
    return moved


def _rows(path: Path) -> Iterator[list[float]]:
    """Lines of a .dat file that are numbers, the first one whole."""
    for line in path.read_text("ascii").splitlines():
        words = line.split()
        if words and words[0].isdigit():
            try:
                yield [float(word) for word in words]
            except ValueError:
                continue
