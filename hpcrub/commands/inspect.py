"""`python -m hpcrub inspect FILE.h5`: what a result file holds, how far it is, if it is sound."""

import argparse
import math
import sys

import numpy as np

from hpcrub import studies
from hpcrub.config import schema as configuration
from hpcrub.config.text import flatten, show
from hpcrub.errors import HpcrubError
from hpcrub.results import storage
from hpcrub.results.layout import DONE, FAILED
from hpcrub.run.progress import console

AT_ONCE = 2**20  # values read at once


def main(argv=None):
    """Print the description of every file; returns the exit code."""
    parser = argparse.ArgumentParser(prog="python -m hpcrub inspect", description=__doc__)
    parser.add_argument("files", nargs="+", metavar="FILE.h5")
    code = 0
    for path in parser.parse_args(argv).files:
        try:
            console().print("\n".join(description(path)), soft_wrap=True)
        except HpcrubError as error:
            print(f"hpcrub: error: {error}", file=sys.stderr)
            code = error.exit_code
    return code


def description(path):
    """Lines about one result file. Raises InputError when it is not sound."""
    file = storage.ResultFile.open(path)
    config = file.config
    yield f"{path}: sound, study {config.study}, {file.path.stat().st_size / 1e6:.4g} MB"
    for name, value in sorted(file.attributes().items()):
        if name != "config":
            yield f"  {name}: {value}"
    yield "  keys that differ from their defaults:"
    here, default = (flatten(c.model_dump(mode="json")) for c in (config, configuration.Config()))
    yield from (f"    {key}: {show(here[key])}" for key in here if here[key] != default[key])
    status = file.status()
    n_done, n_failed = (int(np.count_nonzero(status == s)) for s in (DONE, FAILED))
    what = "tasks" if studies.is_tasks(config) else "samples"
    yield f"  done: {n_done} of {status.size} {what}" + (f", {n_failed} failed" if n_failed else "")
    yield "  datasets (length, unit, known values, smallest to largest):"
    for line in studies.layout(config):
        yield "    " + _dataset_line(file, line)
    file.close()


def _dataset_line(file, line):
    shape = file.shape(line.name)
    n_known, smallest, largest = 0, np.inf, -np.inf
    for values in _pieces(file, line.name, shape):
        known = values[np.isfinite(values)]
        n_known += known.size
        smallest, largest = known.min(initial=smallest), known.max(initial=largest)
    sizes = " x ".join(f"{d} {n}" for d, n in zip(line.dimensions, shape, strict=True))
    text = f"{line.name} ({sizes or 'one value'}) [{line.units}] "
    if n_known:
        text += f"{n_known / math.prod(shape):.0%}, {smallest:.6g} to {largest:.6g}"
    return text + f": {line.description}"


def _pieces(file, name, shape):
    """Values of a dataset, a few at a time, so that memory does not grow with the samples."""
    if len(shape) < 2:
        yield np.asarray(file.read(name), dtype=float)
        return
    rows = max(1, AT_ONCE // max(1, math.prod(shape[2:])))
    for level in range(shape[0]):
        for first in range(0, shape[1], rows):
            yield file.read(name, (level, slice(first, first + rows))).astype(float)
