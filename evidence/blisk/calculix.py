"""Decks of the blisk, and CalculiX on them."""

from pathlib import Path

import numpy as np

from evidence import calculix
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
    head = calculix.CYCLIC.format(n)
    decks.write(folder / "frequencies_cyclic.inp", one, steps, held=held, head=head)


def run(folder: Path, names: tuple = MATRICES + CHECKS) -> None:
    """Run CalculiX on decks of a folder. Raises SystemExit when it is missing or fails."""
    for name in names:
        calculix.run(folder / f"{name}.inp")
