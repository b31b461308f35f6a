"""`hpcrub run INPUT.yaml`: compute a study on all ranks, and draw its figures.

Exit codes: 0 done, 1 failure, 2 bad input, 75 stopped on request.
"""

import os

# One thread per rank; the libraries read this when they are imported. The user's own numbers are
# replaced: other numbers of BLAS threads round differently, and a resumed study would mix both.
os.environ.update({f"{name}_NUM_THREADS": "1" for name in ("OMP", "OPENBLAS", "MKL", "NUMBA")})

import argparse
import json
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

from hpcrub import __version__, studies
from hpcrub.commands import dry_run
from hpcrub.commands.status import status
from hpcrub.config import parts
from hpcrub.config.schema import Config, load_runs
from hpcrub.errors import HpcrubError, InputError, Interrupted, reason
from hpcrub.ranks import parallel, progress
from hpcrub.ranks.parallel import Team
from hpcrub.results import storage
from hpcrub.runs.execution import Existing, examine_all, execute
from hpcrub.runs.study import Run
from hpcrub.setup import input_files

STUDY_LIST = "\n".join(f"  {s.name:15} {s.what}" for s in studies.STUDIES.values())
STUDIES_AND_EXAMPLE = f"""\
studies, as the key `study` of an input file names them:
{STUDY_LIST}

example, on two ranks:
  mpirun -n 2 hpcrub run inputs/quickstart.yaml
  hpcrub run inputs/quickstart.yaml --dry-run      what it would take
  hpcrub run inputs/quickstart.yaml --resume       go on after a stop
"""

Draw = Callable[[list[str]], None]


class Parser(argparse.ArgumentParser):
    """An argument parser whose errors are one line."""

    def error(self, message: str) -> Any:
        """Raise the message that argparse would print as an InputError."""
        raise InputError(f"{message} (--help lists the options)")


def main(argv: Sequence[str] | None = None) -> int:
    """Run the program with command line arguments; returns the exit code."""
    return parallel.run(lambda team: program(team, argv))


def program(team: Team, argv: Sequence[str] | None) -> int:
    """Run the program on this rank, as every rank does; returns the exit code."""
    arguments = team.on_root(lambda: parse(argv))
    if arguments is None:  # --help, --version
        return 0
    options, configs = arguments
    runs = [studies.run_of(config) for config in configs]
    if options.status:
        return team.on_root(lambda: status(runs))
    existing = Existing(options.resume, options.overwrite, options.allow_mixed)
    if options.dry_run:
        parallel.listen()  # a trial has nothing to save: a stop signal ends it at once
        team.on_root(lambda: dry_run.report(runs, existing, team.size))
        return 0
    if team.size > 1:
        team.together(storage.require_parallel)
    draw = None if options.no_figures else draw_figures
    if len(runs) == 1:
        execute(team, runs[0], existing, draw)
        return 0
    return series(team, runs, existing, draw)


def series(team: Team, runs: list[Run], existing: Existing, draw: Draw | None) -> int:
    """Execute several runs; if one fails, the others go on. Returns the largest exit code."""
    team.on_root(lambda: examine_all(runs, existing))  # before the first run takes its time
    outcomes: list[float | HpcrubError] = []  # core seconds, or what went wrong
    for number, run in enumerate(runs, 1):
        team.on_root(partial(progress.say, f"run {number} of {len(runs)}: {run.config.output}"))
        try:
            outcomes.append(execute(team, run, existing, draw))
        except Interrupted:
            raise
        except HpcrubError as error:
            if not getattr(error, "shared", False):  # an error of one rank ends the job
                raise
            outcomes.append(error)
            team.on_root(partial(progress.say, f"this run failed: {error}"))
    team.on_root(lambda: progress.console().print(dry_run.table(runs, outcomes)))
    done = [r.config.output for r, o in zip(runs, outcomes, strict=True) if isinstance(o, float)]
    if draw and len(done) > 1 and not runs[0].config.is_part:
        team.on_root(partial(draw, done))
    return max((end.exit_code for end in outcomes if isinstance(end, HpcrubError)), default=0)


def draw_figures(paths: list[str]) -> None:
    """Draw the figures of one run, or those that compare several, and print the names of the files.

    The results exist: a figure that cannot be drawn gives a line, and the run does not fail. A
    figure that does not suit the files, such as the convergence of few samples, is left out.
    """
    if len(paths) == 1:
        progress.say(f"results: {paths[0]}")
    try:
        from hpcrub.commands.plot import of_study  # matplotlib takes a second to import

        lines = [
            f"no figure: {picture}" if isinstance(picture, HpcrubError) else f"figure:  {picture}"
            for _, picture in of_study(paths)
            if not isinstance(picture, InputError)
        ]
        for line in dict.fromkeys(lines):  # several figures may fail for one reason
            progress.say(line)
    except Exception as error:  # a user's own set-up of matplotlib may raise anything
        progress.say(f"no figure: {type(error).__name__}: {reason(error)}")


def parse(argv: Sequence[str] | None) -> tuple[argparse.Namespace, list[Config]] | None:
    """Return the options and the Config of every run; None after --help or --version."""
    parser = _parser()
    try:
        options = parser.parse_args(argv)
    except SystemExit:
        return None
    overrides = list(options.set)
    if options.output is not None:
        overrides.append(f"output={json.dumps(options.output, ensure_ascii=False)}")
    configs = [input_files.resolved(cfg) for cfg in load_runs(options.input, overrides)]
    if options.part:
        number, count = parts.parse(options.part)
        configs = [parts.cut(cfg, number, count) for cfg in configs]
    return options, [studies.run_of(placed(cfg)).checked().config for cfg in configs]


def placed(config: Config) -> Config:
    """Return a Config whose output and sources do not depend on the working folder.

    The working folder may be removed or left while a study runs. ~ stands for the home folder.
    """
    try:
        output = os.path.abspath(os.path.expanduser(config.output.strip()))
    except FileNotFoundError:
        raise InputError("the working folder was removed while the program started") from None
    sources = tuple(os.path.expanduser(path) for path in config.sources)
    return config.replace({"output": output, "sources": sources})


def _parser() -> Any:
    parser = Parser(
        prog="hpcrub run",
        description="Compute the study that an input file describes, and draw its figures.",
        epilog=STUDIES_AND_EXAMPLE,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("input", metavar="INPUT.yaml", help="input file (hpcrub keys: its keys)")
    parser.add_argument("--output", metavar="FILE", help="result file, instead of the input's")
    parser.add_argument(
        "--set", metavar="key.path=value", action="append", default=[], help="replace a key"
    )
    existing = parser.add_mutually_exclusive_group()
    existing.add_argument("--resume", action="store_true", help="go on with an existing output")
    existing.add_argument("--overwrite", action="store_true", help="replace an existing output")
    parser.add_argument(
        "--allow-mixed",
        action="store_true",
        help="with --resume: go on with what another state of the program has begun",
    )
    parser.add_argument("--part", metavar="K/N", help="compute part K of N only, in its own file")
    parser.add_argument(
        "--status",
        action="store_true",
        help="say how far the output is, and the time left; exit code 0: complete",
    )
    parser.add_argument(
        "--no-figures", action="store_true", help="draw none: all other ranks would wait"
    )
    parser.add_argument("--dry-run", action="store_true", help="check, estimate the cost, stop")
    parser.add_argument("--version", action="version", version=f"hpcrub {__version__}")
    return parser
