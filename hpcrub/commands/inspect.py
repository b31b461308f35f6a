"""`hpcrub inspect FILE.h5 ...`: what result files hold, how complete, and computed by whom."""

import argparse
import math
import sys
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from hpcrub import studies
from hpcrub.config import schema as configuration
from hpcrub.config.text import flatten, show
from hpcrub.errors import InputError
from hpcrub.ranks.progress import console
from hpcrub.results import contact_file
from hpcrub.results.layout import DONE, FAILED, PENDING, Dataset
from hpcrub.results.storage import ResultFile
from hpcrub.studies.files import open_result

AT_ONCE = 2**20  # values read at once
MOST_RANGES = 8  # ranges of samples that are named
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
        what = studies.find(config).unit
        failed = f", {n_failed} failed" if n_failed else ""
        yield f"  done: {n_done} of {status.size} {what}{failed}"
        yield from _program_lines(file, status)
        yield "  datasets (length, unit, known values, smallest to largest):"
        for line in studies.find(config).lines(config):
            if line.since <= file.layout:
                yield "    " + _dataset_line(file, line)


def printable(value: Any) -> str:
    """A value of a file on one line, without what a terminal would take for commands."""
    text = "".join(c if c.isprintable() else repr(c)[1:-1] for c in str(value)[:MOST_CHARACTERS])
    return text + ("..." if len(str(value)) > MOST_CHARACTERS else "")


def _program_lines(file: ResultFile, status: np.ndarray) -> Iterator[str]:
    """The program that has computed this file, or each of several with what it has computed."""
    programs = file.programs()
    yield "  computed by:"
    if len(programs) == 1:
        yield f"    {printable(programs[0])}"
        return
    tasks = studies.find(file.config).unit == "tasks"
    row = np.atleast_2d(file.read("computed_by" if tasks else "samples/computed_by"))
    done = np.atleast_2d(status) != PENDING
    for number, program in enumerate(programs):
        yield f"    {printable(program)}"
        if not tasks and contact_file.read_tuned(file) and file.read("tuned/computed_by") == number:
            yield "      the tuned disk"
        for level, mine in enumerate(done & (row == number)):
            if mine.any():
                where = "tasks" if tasks else f"level {file.config.levels[level]}, samples"
                first = 0 if tasks else file.config.samples.start
                yield f"      {where} {_ranges(mine, first)}"


def _ranges(flags, first):
    """Words such as "0 to 539, 600" for the true values, counted from `first`."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], flags, [0]]))).reshape(-1, 2) + first
    words = [f"{a}" if b == a + 1 else f"{a} to {b - 1}" for a, b in edges[:MOST_RANGES]]
    more = len(edges) - MOST_RANGES
    return ", ".join(words) + (f" and {more} more ranges" if more > 0 else "")


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
