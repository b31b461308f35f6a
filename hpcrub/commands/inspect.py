"""`hpcrub inspect FILE.h5 ...`: what result files hold, how complete, and computed by whom."""

import argparse
import math
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

AT_ONCE = 2**20  # values read at once
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
        for name, value in sorted(file.attributes().items()):
            if name != "config":
                yield f"  {printable(name)}: {printable(value)}"
        yield "  keys that differ from their defaults:"
        here, default = (
            flatten(c.model_dump(mode="json")) for c in (config, configuration.Config())
        )
        changed = (key for key in here if here[key] != default[key])
        yield from (f"    {key}: {printable(show(here[key]))}" for key in changed)
        status = file.status()
        n_done, n_failed = (int(np.count_nonzero(status == s)) for s in (DONE, FAILED))
        run = run_of(config)
        what = run.study.unit
        failed = f", {n_failed} failed" if n_failed else ""
        yield f"  done: {n_done} of {status.size} {what}{failed}"
        yield "  computed by:"
        yield from (f"    {printable(program)}" for program in file.programs())
        if wear := list(depths.lines(file)):
            yield "  wear of the coating:"
            yield from (f"    {line}" for line in wear)
        if found := contact_file.read_trust(file):
            yield "  how far this can be trusted:"
            yield from (f"    {printable(line)}" for line in found)
        yield "  datasets (length, unit, known values, smallest to largest):"
        for line in run.datasets():
            if line.since <= file.layout:
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
        n_known, smallest, largest = _known(file, line.name, shape)
        if n_known:
            text += f" {n_known / math.prod(shape):.0%}, {smallest:.6g} to {largest:.6g}"
    return text + f": {line.description}"


def _known(file, name, shape):
    """Number of finite values of a dataset, the smallest and the largest of them."""
    n_known, smallest, largest = 0, np.inf, -np.inf
    for values in _pieces(file, name, shape):
        known = values[np.isfinite(values)]
        n_known += known.size
        smallest, largest = known.min(initial=smallest), known.max(initial=largest)
    return n_known, smallest, largest


def _pieces(file, name, shape):
    """Values of a dataset, a few at a time, so that memory does not grow with the samples."""
    if len(shape) < 2:
        yield np.asarray(file.read(name), dtype=float)
        return
    rows = max(1, AT_ONCE // max(1, math.prod(shape[2:])))
    for level in range(shape[0]):
        for first in range(0, shape[1], rows):
            yield file.read(name, (level, slice(first, first + rows))).astype(float)
