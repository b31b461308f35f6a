"""`hpcrub export FILE.h5 --to csv|netcdf|parquet`: tables of samples and of points."""

import argparse
import os
from collections.abc import Sequence
from pathlib import Path

import hpcrub
from hpcrub.config.types import without_suffix
from hpcrub.errors import HpcrubError, InputError, reason
from hpcrub.ranks.progress import console
from hpcrub.studies import open_result

KINDS = "csv", "netcdf", "parquet"
TABLES = "samples", "points"


def main(argv: Sequence[str] | None = None) -> int:
    """Write the tables of every file and name them; returns the exit code."""
    parser = argparse.ArgumentParser(prog="hpcrub export", description=__doc__)
    parser.add_argument("files", nargs="+", metavar="FILE.h5")
    parser.add_argument("--to", choices=KINDS, default=KINDS[0], help="kind of files (csv)")
    parser.add_argument("--out", metavar="FOLDER", help="where to, beside FILE.h5 by default")
    parser.add_argument("--overwrite", action="store_true", help="replace existing files")
    options = parser.parse_args(argv)
    for path in options.files:
        for target in export(path, options.to, options.out, options.overwrite):
            console().print(f"written: {target}", soft_wrap=True)
    return 0


def export(
    path: str | Path, kind: str = "csv", folder: str | Path | None = None, overwrite: bool = False
) -> list[Path]:
    """Write the tables of a result file: NAME.samples.csv and NAME.points.csv, or NAME.nc.

    Parameters
    ----------
    path
        Result file.
    kind
        "csv" or "parquet" for one table of samples and one of points, of studies that have them;
        "netcdf" for all of the file.
    folder
        Where to, beside the file by default.
    overwrite
        Replace existing files.

    Returns
    -------
    list of Path
        The files written.

    Raises
    ------
    InputError
        The study has no such table, a file exists, or a library is not installed.
    HpcrubError
        A file cannot be written.
    """
    stem = without_suffix(path)
    stem = Path(folder) / stem.name if folder else stem
    open_result(path).close()  # raises InputError where it is not as its study needs
    with hpcrub.open(path) as file:
        if kind == "netcdf":
            tree = file.to_xarray()
            writers = {Path(f"{stem}.nc"): lambda part: tree.to_netcdf(part, engine="h5netcdf")}
        else:
            frames = {name: file.to_dataframe(name) for name in TABLES if name in file.tables()}
            if not frames:
                raise InputError(
                    f"{path}: the study {file.config.study} has neither samples nor points; "
                    "--to netcdf writes all of it"
                )
            writers = {
                Path(f"{stem}.{name}.{kind}"): getattr(frame, f"to_{kind}")
                for name, frame in frames.items()
            }
        for target, write in writers.items():
            _write(target, write, overwrite)
    return list(writers)


def _write(target, write, overwrite):
    """Write a file whole or not at all."""
    if os.path.lexists(target) and not overwrite:
        raise InputError(f"{target} exists: --overwrite replaces it")
    part = target.with_name(f"{target.name}.hpcrub-part")
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        write(part)
        os.replace(part, target)
    except ImportError as error:
        raise InputError(f"{reason(error)}: pip install 'hpcrub[tables]'") from None
    except OSError as error:
        raise HpcrubError(f"cannot write {target}: {reason(error)}") from None
    finally:
        part.unlink(missing_ok=True)
