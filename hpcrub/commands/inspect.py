"""`hpcrub inspect FILE.h5 ...`: of which study result files are, how complete, how trustworthy."""

import argparse
from collections.abc import Iterator, Sequence

import numpy as np

from hpcrub.config.schema import Config, differences
from hpcrub.config.text import one_line
from hpcrub.errors import InputError, complain
from hpcrub.ranks.progress import say
from hpcrub.results.layout import DONE, FAILED
from hpcrub.results.storage import ResultFile
from hpcrub.studies import open_result, run_of

MOST_CHARACTERS = 200  # printed of an attribute


def main(argv: Sequence[str] | None = None) -> int:
    """Print the description of every file; returns the exit code."""
    parser = argparse.ArgumentParser(prog="hpcrub inspect", description=__doc__)
    parser.add_argument("files", nargs="+", metavar="FILE.h5")
    code = 0
    for path in parser.parse_args(argv).files:
        try:
            with open_result(path) as file:
                say("\n".join(description(file)))
                if (file.status == DONE).any():
                    run_of(file.config).study.print_results(file)
        except InputError as error:
            complain(f"hpcrub: error: {error}")
            code = error.exit_code
    return code


def description(file: ResultFile) -> Iterator[str]:
    """Yield lines that describe one result file."""
    config, study = file.config, run_of(file.config).study
    megabytes = file.path.stat().st_size / 1e6
    yield f"{one_line(str(file.path))}: sound, study {config.study}, {megabytes:.4g} MB"
    for name, value in sorted(file.attributes.items()):
        if name != "config":
            yield f"  {one_line(f'{name}: {value}'[:MOST_CHARACTERS])}"
    yield "  keys that differ from their defaults:"
    for line in differences(config, Config(), ("here", "by default")):
        yield f"    {one_line(line)}"
    n_done, n_failed = (int(np.count_nonzero(study.parts(file) == s)) for s in (DONE, FAILED))
    failed = f", {n_failed} failed" if n_failed else ""
    yield f"  done: {study.amount_done(file, n_done)}{failed}"
