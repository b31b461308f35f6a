"""`hpcrub export FILE.h5`: tables of samples and of points as CSV files."""

import argparse
import os
from collections.abc import Sequence
from pathlib import Path

import hpcrub
from hpcrub.config.types import without_suffix
from hpcrub.errors import HpcrubError, InputError, reason
from hpcrub.ranks.progress import console
from hpcrub.studies import open_result

TABLES = "samples", "points"


def main(argv: Sequence[str] | None = None) -> int:
    """Write the tables of every file and name them; returns the exit code."""
    parser = argparse.ArgumentParser(prog="hpcrub export", description=__doc__)
    parser.add_argument("files", nargs="+", metavar="FILE.h5")
    parser.add_argument("--out", metavar="FOLDER", help="where to, beside FILE.h5 by default")
    parser.add_argument("--overwrite", action="store_true", help="replace existing files")
    options = parser.parse_args(argv)
    for path in options.files:
        for target in export(path, options.out, options.overwrite):
            console().print(f"written: {target}", soft_wrap=True)
    return 0


def export(
    path: str | Path, folder: str | Path | None = None, overwrite: bool = False
) -> list[Path]:
    """Write the tables of a result file: NAME.samples.csv and NAME.points.csv.

    folder: where to, beside the file by default; overwrite: replace existing files.
    Returns the files written. Raises InputError when the study has no such table, a file exists, or
    pandas is not installed, and HpcrubError when a file cannot be written.
    """
    stem = without_suffix(path)
    stem = Path(folder) / stem.name if folder else stem
    open_result(path).close()  # raises InputError where it is not as its study needs
    with hpcrub.open(path) as file:
        frames = {name: file.to_dataframe(name) for name in TABLES if name in file.tables()}
        if not frames:
            raise InputError(
                f"{path}: the study {file.config.study} has neither samples nor points; the file "
                "itself opens in xarray, netCDF4 and h5py"
            )
    written = {Path(f"{stem}.{name}.csv"): frame for name, frame in frames.items()}
    for target, frame in written.items():
        _write(target, frame.to_csv, overwrite)
    return list(written)


def _write(target, write, overwrite):
    """Write a file whole or not at all."""
    if os.path.lexists(target) and not overwrite:
        raise InputError(f"{target} exists: --overwrite replaces it")
    part = target.with_name(f"{target.name}.hpcrub-part")
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        write(part)
        os.replace(part, target)
    except OSError as error:
        raise HpcrubError(f"cannot write {target}: {reason(error)}") from None
    finally:
        part.unlink(missing_ok=True)
