"""Decks of the blisk, CalculiX on them, and the frequencies that it prints."""

import shutil
import subprocess
from pathlib import Path

import numpy as np

from evidence.blisk import decks
from evidence.blisk.mesh import BLISK, sector, whole_disk

SPEEDS = 160, 260  # of the prestressed matrices [Hz]
CHECKED = 210  # [Hz] another speed, with frequencies of CalculiX's own
N_MODES = 60  # frequencies that are compared
PER_DIAMETER = 4
MATRICES = (
    "sector",
    "sector_blade",
    "disk_0",
    *(f"disk_{s}" for s in (*SPEEDS, CHECKED)),
    "blades",
)
CHECKS = "frequencies_0", f"frequencies_{CHECKED}", "frequencies_cyclic"


def write_decks(folder: Path) -> None:
    """Write the decks of MATRICES and CHECKS."""
    folder.mkdir(parents=True, exist_ok=True)
    one, n = sector(BLISK), BLISK.n_sectors
    disk = whole_disk(one, n)
    bore = disk.sets["bore"]
    at_rest = decks.spinning(0, decks.STORE)
    decks.write(folder / "sector.inp", one, at_rest)
    decks.write(folder / "sector_blade.inp", one, at_rest, elements=one.blade_elements)
    decks.write(folder / "blades.inp", disk, at_rest, elements=disk.blade_elements)
    for speed in (0, *SPEEDS, CHECKED):
        steps = decks.spinning(2 * np.pi * speed, decks.STORE)
        decks.write(folder / f"disk_{speed}.inp", disk, steps, held=bore)
    for speed in (0, CHECKED):
        steps = decks.spinning(2 * np.pi * speed, decks.frequencies(N_MODES))
        decks.write(folder / f"frequencies_{speed}.inp", disk, steps, held=bore)
    held = np.setdiff1d(one.sets["bore"], one.sets["low"])  # ties its first surface: no supports
    steps = decks.DIAMETERS.format(PER_DIAMETER, n // 2)
    head = decks.CYCLIC.format(n)
    decks.write(folder / "frequencies_cyclic.inp", one, steps, held=held, head=head)


def run(folder: Path, names: tuple = MATRICES + CHECKS) -> None:
    """Run CalculiX on decks of a folder. Raises SystemExit when it is missing or fails."""
    if not shutil.which("ccx"):
        raise SystemExit("blisk: CalculiX (ccx) is missing: apt-get install calculix-ccx")
    for name in names:
        print(f"ccx -i {name}", flush=True)
        done = subprocess.run(["ccx", "-i", name], cwd=folder, capture_output=True, text=True)
        if "Job finished" not in done.stdout:
            raise SystemExit(f"blisk: ccx -i {name} failed:\n{done.stdout[-1000:]}")


def disk_frequencies(path: Path) -> np.ndarray:
    """Frequencies of a .dat file of a whole disk (N_MODES,) [Hz]."""
    rows = [row for row in _rows(path) if len(row) == 5]
    return np.array([row[3] for row in rows[:N_MODES]])


def cyclic_frequencies(path: Path) -> dict:
    """Frequencies [Hz] by nodal diameters of a .dat file of one sector; double ones once."""
    found: dict = {}
    for row in _rows(path):
        if len(row) == 6:
            found.setdefault(int(row[0]), []).append(row[4])
    return {diameters: np.array(f)[::2] for diameters, f in found.items()}


def _rows(path):
    """Lines of a .dat file that are numbers, the first one whole."""
    for line in path.read_text("ascii").splitlines():
        words = line.split()
        if words and words[0].isdigit():
            try:
                yield [float(word) for word in words]
            except ValueError:
                continue
