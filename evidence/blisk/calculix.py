"""Decks of the blisk."""

from pathlib import Path

import numpy as np

from evidence import calculix as ccx
from evidence.blisk.mesh import BLISK, sector, whole_disk

SPEEDS = 160, 260  # of the prestressed matrices [Hz]
CHECKED = 210  # [Hz] another speed, with frequencies of CalculiX's own
N_MODES = 60  # frequencies that are compared
PER_DIAMETER = 4
MATRICES = "sector", *(f"disk_{s}" for s in (0, *SPEEDS, CHECKED)), "blades"
CHECKS = "frequencies_0", f"frequencies_{CHECKED}", "frequencies_cyclic"


def write_decks(folder: Path) -> None:
    """Write the decks of MATRICES and CHECKS."""
    folder.mkdir(parents=True, exist_ok=True)
    one, n = sector(BLISK), BLISK.n_sectors
    disk = whole_disk(one, n)
    bore = ccx.held(disk.sets["bore"])
    ccx.write(folder / "sector.inp", one, ccx.STEP + ccx.STORE)
    ccx.write(folder / "blades.inp", disk, ccx.STEP + ccx.STORE, blade=True)
    for speed in (0, *SPEEDS, CHECKED):
        ccx.write(folder / f"disk_{speed}.inp", disk, bore + _about(speed) + ccx.STORE)
    for speed in (0, CHECKED):
        steps = bore + _about(speed) + ccx.frequencies_of(N_MODES)
        ccx.write(folder / f"frequencies_{speed}.inp", disk, steps)
    inner = np.setdiff1d(one.sets["bore"], one.sets["low"])  # ties its first surface: no supports
    steps = ccx.held(inner) + ccx.CYCLIC.format(n) + ccx.STEP
    steps += ccx.frequencies_of(PER_DIAMETER, n // 2)
    ccx.write(folder / "frequencies_cyclic.inp", one, steps)


def _about(speed_hz):
    """Steps to the state that a speed loads the disk to, and the head of one about it."""
    if not speed_hz:
        return ccx.STEP
    return ccx.STATIC + ccx.SPINNING.format((2 * np.pi * speed_hz) ** 2) + ccx.END + ccx.PERTURBED
