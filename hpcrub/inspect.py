"""`python -m hpcrub.inspect FILE.h5`: what a result file holds, how far it is, if it is sound."""

import argparse
import sys

import numpy as np

from hpcrub import config as configuration
from hpcrub import storage, studies
from hpcrub.config_text import flatten, show
from hpcrub.errors import HpcrubError
from hpcrub.layout import DONE, FAILED
from hpcrub.progress import console


def main(argv=None):
    """Print the description of every file; returns the exit code."""
    parser = argparse.ArgumentParser(prog="python -m hpcrub.inspect", description=__doc__)
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
    yield f"{path}: sound, study {config.study}, {studies.file_size(config) / 1e6:.4g} MB"
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
    values = np.asarray(file.read(line.name), dtype=float)
    known = values[np.isfinite(values)]
    shape = " x ".join(f"{d} {n}" for d, n in zip(line.dimensions, values.shape, strict=True))
    text = f"{line.name} ({shape or 'one value'}) [{line.units}] "
    if known.size:
        text += f"{known.size / values.size:.0%}, {known.min():.6g} to {known.max():.6g}"
    return text + f": {line.description}"


if __name__ == "__main__":
    sys.exit(main())
