"""`hpcrub inspect FILE.h5 ...`: what result files hold, how complete, and computed by whom."""

import argparse
import sys
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from hpcrub.config import schema as configuration
from hpcrub.config.text import flatten, show
from hpcrub.errors import InputError
from hpcrub.ranks.progress import console
from hpcrub.results.layout import DONE, FAILED, Dataset
from hpcrub.results.storage import ResultFile
from hpcrub.studies import open_result, run_of
from hpcrub.studies.contact import depths
from hpcrub.studies.contact import file as contact_file

MOST_CHARACTERS = 200  # of an attribute


def main(argv: Sequence[str] | None = None) -> int:
    """Print the description of every file; returns the exit code."""
    parser = argparse.ArgumentParser(prog="hpcrub inspect", description=__doc__)
    parser.add_argument("files", nargs="+", metavar="FILE.h5")
    code = 0
    for path in parser.parse_args(argv).files:
        try:
            console().print("\n".join(description(path)), soft_wrap=True)
        except InputError as error:
            print(f"hpcrub: error: {error}", file=sys.stderr)
            code = error.exit_code
    return code


def description(path: str) -> Iterator[str]:
    """Lines about one result file. Raises InputError when it is not sound."""
    with open_result(path) as file:
        config = file.config
        megabytes = file.path.stat().st_size / 1e6
        yield f"{printable(path)}: sound, study {config.study}, {megabytes:.4g} MB"
        for name, value in sorted(file.attributes.items()):
            if name != "config":
                yield f"  {printable(name)}: {printable(value)}"
        yield "  keys that differ from their defaults:"
        here, default = (
            flatten(c.model_dump(mode="json")) for c in (config, configuration.Config())
        )
        changed = (key for key in here if here[key] != default[key])
        yield from (f"    {key}: {printable(show(here[key]))}" for key in changed)
        status = file.status
        n_done, n_failed = (int(np.count_nonzero(status == s)) for s in (DONE, FAILED))
        run = run_of(config)
        what = run.study.unit
        failed = f", {n_failed} failed" if n_failed else ""
        yield f"  done: {n_done} of {status.size} {what}{failed}"
        if wear := list(depths.lines(file)):
            yield "  wear of the coating:"
            yield from (f"    {line}" for line in wear)
        if found := contact_file.read_trust(file):
            yield "  how far this can be trusted:"
            yield from (f"    {printable(line)}" for line in found)
        yield "  datasets (length, unit, known values, smallest to largest):"
        for line in run.datasets():
            yield "    " + _dataset_line(file, line)


def printable(value: Any) -> str:
    """A value of a file on one line, without what a terminal would take for commands."""
    text = "".join(c if c.isprintable() else repr(c)[1:-1] for c in str(value)[:MOST_CHARACTERS])
    return text + ("..." if len(str(value)) > MOST_CHARACTERS else "")


def _dataset_line(file: ResultFile, line: Dataset) -> str:
    shape = file.shape(line.name)
    sizes = " x ".join(f"{d} {n}" for d, n in zip(line.dimensions, shape, strict=True))
    text = f"{line.name} ({sizes or 'one value'}) [{line.units}]"
    if file.dtype(line.name).kind != "S":
        values = np.asarray(file.read(line.name))
        known = values[np.isfinite(values)]
        if known.size:
            text += f" {known.size / values.size:.0%}, {known.min():.6g} to {known.max():.6g}"
    return text + f": {line.description}"
