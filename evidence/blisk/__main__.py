"""Make the blisk of the tutorial anew: mesh, CalculiX, import, checks (1 min).

Writes build/blisk/blisk.h5, of which inputs/blisk/blisk.h5 is a copy. Ends with 1 when a frequency
is not that of CalculiX.
"""

import argparse
from pathlib import Path

from evidence import calculix as ccx
from evidence import second_order
from evidence.blisk import frequencies
from hpcrub.commands import import_model
from hpcrub.model.imported import bending, neutral
from hpcrub.results import model_file

N_MODES = 36  # fixed-interface modes of the model file
SPEED = 210.0  # of its mode shapes [Hz]


def main(argv=None):
    """Run all steps, or only write the decks; returns the exit code."""
    parser = argparse.ArgumentParser(prog="python -m evidence.blisk", description=__doc__)
    parser.add_argument("--folder", type=Path, default=Path("build/blisk"), help="of the decks")
    parser.add_argument("--decks", action="store_true", help="only write the decks")
    options = parser.parse_args(argv)
    folder = options.folder
    frequencies.write_decks(folder)
    if options.decks:
        return 0
    for name in frequencies.MATRICES + frequencies.CHECKS:
        ccx.run(folder / f"{name}.inp")
    for command in imports(folder):
        print("hpcrub import " + " ".join(command), flush=True)
        if code := import_model.main(command):
            return code
    with_second_order(folder)
    failed = False
    for what, difference, limit in frequencies.compare(folder):
        failed |= not difference <= limit
        print(f"{what}: {difference:.1e} (at most {limit:.0e})")
    return int(failed)


def with_second_order(folder):
    """Add the second order of the blades to the model file."""
    path, (mesh, read) = folder / "blisk.h5", frequencies.blade_alone()
    model = neutral.from_arrays(model_file.read(path))
    whole = bending.onto(model, *second_order.by_calculix(mesh, read, folder))
    model_file.write(path, neutral.to_arrays(whole), overwrite=True)


def imports(folder):
    """Arguments of `hpcrub import` that make the model file: the whole disk, then reduced."""
    disk = str(folder / "blisk_disk.h5")
    speeds = [f"--stiffness={s}={folder / f'disk_{s}.inp'}" for s in frequencies.SPEEDS]
    at = ["--speed-hz", f"{SPEED:g}"]
    source = ["calculix", str(folder / "disk_0.inp"), "--units", "mm t s", "--contact", "TIP"]
    blades = ["--blade", str(folder / "blades.inp")]
    yield [*source, *blades, *speeds, *at, "--output", disk, "--overwrite"]
    small = ["--reduce", str(N_MODES), *at, "--output", str(folder / "blisk.h5"), "--overwrite"]
    yield ["model", disk, *small]


if __name__ == "__main__":
    raise SystemExit(main())
