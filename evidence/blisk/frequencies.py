"""Decks of the blisk, and its frequencies after the import beside those that CalculiX prints."""

from collections.abc import Callable
from pathlib import Path

import numpy as np

from evidence import calculix as ccx
from evidence.blisk.mesh import BLISK, sector, whole_disk
from hpcrub.model.imported import assembly, craig_bampton, cyclic, neutral, reduced
from hpcrub.model.imported.readers import calculix
from hpcrub.model.imported.readers.rows import Lists
from hpcrub.model.reduction import mistuned_modes

SPEEDS = 160, 260  # of the prestressed matrices [Hz]
CHECKED = 210  # [Hz] another speed, with frequencies of CalculiX's own
N_MODES = 60  # frequencies that are compared
PER_DIAMETER = 4
MATRICES = "sector", *(f"disk_{s}" for s in (0, *SPEEDS, CHECKED)), "blades"
CHECKS = "frequencies_0", f"frequencies_{CHECKED}", "frequencies_cyclic"
PRINTED = 1e-6  # CalculiX prints seven digits
UNITS = np.array("mm t s")
DISK = Lists("TIP")
SECTOR = Lists("TIP", "LOW", "HIGH", BLISK.n_sectors, "BORE")


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


def model_of(folder: Path, name: str, lists: Lists, **others: dict) -> neutral.NeutralModel:
    """Model of a job; of a whole disk its blades in the order of the mesh."""
    arrays = calculix.read(folder / f"{name}.inp", lists, **others) | {"units": UNITS}
    if not lists.low:
        n_contact = len(arrays["contact_node"])
        arrays["contact_blade"] = np.arange(n_contact) * BLISK.n_sectors // n_contact
    return neutral.from_arrays(arrays)


def blade_alone() -> tuple[ccx.Mesh, Callable[[Path], neutral.NeutralModel]]:
    """Mesh of one sector with the root of its blade, and what reads a deck of its blade alone."""
    one = sector(BLISK)
    rim = np.delete(one.elements, one.blade_elements, axis=0)
    root = np.intersect1d(one.elements[one.blade_elements], rim)

    def read(path):
        return neutral.from_arrays(calculix.read(path, DISK) | {"units": UNITS})

    return one._replace(sets=one.sets | {"root": root}), read


def compare(folder: Path) -> list:
    """Rows (what, largest relative difference, limit) of a table."""
    whole = ccx.frequencies(folder / "frequencies_0.dat", N_MODES)
    spun = ccx.frequencies(folder / f"frequencies_{CHECKED}.dat", N_MODES)
    diameters = ccx.by_diameters(folder / "frequencies_cyclic.dat")
    one = model_of(folder, "sector", SECTOR)
    others = {float(s): folder / f"disk_{s}.inp" for s in SPEEDS}
    disk = assembly.assemble(model_of(folder, "disk_0", DISK, stiffness=others))
    there = assembly.assemble(model_of(folder, f"disk_{CHECKED}", DISK))
    omega, n = 2 * np.pi * CHECKED, N_MODES
    ours = craig_bampton.frequencies(assembly.assemble(one), n)
    rows = [(f"disk of {BLISK.n_sectors} sectors, {n} modes", ours, whole, PRINTED)]
    for h, exact in diameters.items():
        found = cyclic.sector_frequencies(one, h, len(exact))
        rows.append((f"one sector, {h} nodal diameters, {len(exact)} modes", found, exact, PRINTED))
    at = f"{CHECKED} Hz"
    rows.append((f"prestressed disk at {at}, {n} modes", craig_bampton.frequencies(there, n), spun,
                 PRINTED))  # fmt: skip
    between = craig_bampton.frequencies(disk, n, omega)
    speeds = ", ".join(map(str, (0, *SPEEDS)))
    rows.append((f"K(Ω) through {speeds} Hz, at {at}, {n} modes", between, spun, 1e-3))
    rows += _reduced(disk, omega, spun[: BLISK.n_sectors])
    return [(what, abs(a / b - 1).max(), limit) for what, a, b, limit in rows]


def _reduced(disk, omega, exact):
    """First family of the reduced model: all of it, and with mode shapes of another speed."""
    small, _ = reduced.reduce_disk(disk, 60, omega)
    n = BLISK.n_sectors
    here = mistuned_modes(reduced.reduced_model(small, omega), np.zeros(n)).omega[:n]
    yield "reduced model, 60 modes, first family", here / (2 * np.pi), exact, 5e-3
    for share in (0.95, 0.8):
        modes = mistuned_modes(reduced.reduced_model(small, share * omega), np.zeros(n))
        moved = np.sort(modes.omega_at(omega))[:n]
        what = f"the same with mode shapes of {100 * share:.0f} % of the speed, against its own"
        yield what, moved, here, 1e-3
