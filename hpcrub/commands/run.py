"""Command line → study, exit codes: 0 done, 1 failure, 2 bad input, 75 stopped on request."""

import os

# One thread per rank; the libraries look at this when they are imported. Not a default: another
# number of BLAS threads rounds differently, and a resumed study would mix the two.
os.environ.update({f"{name}_NUM_THREADS": "1" for name in ("OMP", "OPENBLAS", "MKL", "NUMBA")})

import argparse
import json
import time
from pathlib import Path

import numpy as np

from hpcrub import __version__, studies
from hpcrub.config import parts
from hpcrub.config import schema as config
from hpcrub.errors import HpcrubError, InputError, Interrupted, reason
from hpcrub.model.reduction import mistuned_modes
from hpcrub.response import sweep
from hpcrub.results import ownership, storage
from hpcrub.results.layout import PENDING
from hpcrub.run import parallel, progress
from hpcrub.run.runlog import RunLog, Work
from hpcrub.statistics.percentiles import first_converged, judged_error
from hpcrub.studies import files, monte_carlo, size
from hpcrub.studies import problem as study
from hpcrub.studies.tasks import TaskStudy

MEASURED_STEP = 2e-5  # [s] of the sweep that measures the cost: a step costs the same at any length
MEASURED_SPEEDS = 41


class Parser(argparse.ArgumentParser):
    """A parser whose errors are one line."""

    def error(self, message):
        raise InputError(f"{message} (--help lists the options)")


def main(argv=None):
    """Run the program with command line arguments argv; returns the exit code."""
    return parallel.run(lambda team: program(team, argv))


def program(team, argv):
    """What every rank does; returns the exit code."""
    arguments = team.on_root(lambda: parse(argv))
    if arguments is None:  # --help, --version
        return 0
    options, runs = arguments
    if options.status:
        return team.on_root(lambda: status(runs))
    if options.dry_run:
        team.on_root(lambda: [dry_run(cfg, team.size) for cfg in runs])
        return 0
    if team.size > 1:
        team.together(storage.require_parallel)
    if len(runs) > 1:  # what is wrong with the last one is said before the first one takes its time
        team.on_root(lambda: examine_all(runs, options))
    for cfg in runs:
        one_run(team, options, cfg)
    if len(runs) > 1 and not (options.no_figures or runs[0].is_part):
        team.on_root(lambda: draw([cfg.output for cfg in runs]))
    return 0


def one_run(team, options, cfg):
    """One study from its input to its figures."""
    problem = team.on_root(lambda: examine(cfg, options))
    team.stop_if_asked(cfg.output)
    lock = Holder()
    try:
        earlier = team.on_root(lambda: claim(cfg, options, lock))
        with Accounting(cfg, team, earlier) as log:
            run(team, cfg, problem, log, not options.no_figures)
    finally:
        lock.release()


def parse(argv):
    """Options and the Config of every run; None when --help or --version has been answered."""
    parser = Parser(prog="main.py", description="Contact and linear response of mistuned disks.")
    parser.add_argument("input", metavar="INPUT.yaml", help="input file")
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
    parser.add_argument("--part-by", choices=parts.BY, help="what --part cuts (samples)")
    parser.add_argument(
        "--status", action="store_true", help="say how far the output is; exit code 0: complete"
    )
    parser.add_argument(
        "--no-figures", action="store_true", help="draw none: all other ranks would wait"
    )
    parser.add_argument("--dry-run", action="store_true", help="check, estimate the cost, stop")
    parser.add_argument("--version", action="version", version=f"hpcrub {__version__}")
    try:
        options = parser.parse_args(argv)
    except SystemExit:
        return None
    overrides = list(options.set)
    if options.output is not None:
        overrides.append(f"output={json.dumps(options.output, ensure_ascii=False)}")
    runs = config.load_runs(options.input, overrides)
    if options.part:
        number, count = parts.parse(options.part)
        runs = [parts.cut(cfg, number, count, options.part_by or parts.BY[0]) for cfg in runs]
    elif options.part_by:
        raise InputError(f"--part-by {options.part_by}: without --part nothing is cut")
    return options, [placed(cfg) for cfg in runs]


def placed(cfg):
    """A Config whose output and sources do not depend on the working folder, which may be removed
    or left while a study runs; ~ is the home folder."""
    output = os.path.abspath(os.path.expanduser(cfg.output.strip()))
    sources = tuple(os.path.expanduser(path) for path in cfg.sources)
    return cfg.model_copy(update={"output": output, "sources": sources})


def status(runs):
    """Print how far every result file is; returns 0 when all are complete, 75 otherwise."""
    out, complete = progress.console(), True
    for cfg in runs:
        if not os.path.lexists(cfg.output):
            out.print(f"{cfg.output}: not there yet", soft_wrap=True)
            complete = False
            continue
        file = files.open_result(cfg.output, cfg)
        done = file.status() != PENDING
        what = TaskStudy.what if studies.is_tasks(cfg) else monte_carlo.Study.what
        text = f"{cfg.output}: {np.count_nonzero(done)} of {done.size} {what}"
        enough = done.all()
        if not enough and cfg.study == "contact" and cfg.convergence.stop_when_converged:
            names = "convergence_error", "percentile_low", "percentile_high"
            known = {name: file.read(f"statistics/contact/{name}") for name in names}
            error = judged_error(cfg.convergence.criterion, known.get)
            enough = first_converged(error, cfg.convergence.target_error) is not None
            text += ", converged" if enough else ""
        out.print(text, soft_wrap=True)
        complete = complete and bool(enough)
        file.close()
    return 0 if complete else Interrupted.exit_code


class Holder:
    """Rank 0's lock, empty on other ranks."""

    lock = None

    def release(self):
        if self.lock:
            self.lock.release()


def examine_all(runs, options):
    """Raises InputError for what is wrong with any run of a sweep, before all work (rank 0)."""
    for n, cfg in enumerate(runs):
        made = {os.path.realpath(other.output) for other in runs[:n]}
        if made.isdisjoint(map(os.path.realpath, cfg.sources)):  # else they are not there yet
            examine(cfg, options)


def examine(cfg, options):
    """What a study computes with. Raises InputError for all that is wrong before work (rank 0)."""
    goes_on = check_output(cfg, options)
    size.check(cfg, None if goes_on else cfg.output)
    return studies.find(cfg).prepare(cfg)


def check_output(cfg, options):
    """Whether to go on with a sound result file, and not to make one. Raises InputError."""
    path = Path(cfg.output)
    if os.path.isdir(path):
        raise InputError(f"output: {path} is a folder")
    if os.path.realpath(path) in map(os.path.realpath, cfg.sources):
        raise InputError(f"output: {path} is one of the sources")
    if not os.path.lexists(path):
        return False
    if not (options.resume or options.overwrite):
        raise InputError(f"{path} exists: --resume goes on with it, --overwrite replaces it")
    if options.resume:
        files.check_resumable(path, cfg, options.allow_mixed)
    else:
        storage.refuse_foreign(path)
    return options.resume


def claim(cfg, options, holder):
    """Make sure that a sound result file is there, and nobody else's (rank 0).

    Returns what that was, and its seconds.
    """
    holder.lock = ownership.Lock(cfg.output)  # first: another job may just have finished it
    began = time.monotonic()
    if check_output(cfg, options):
        return "check", time.monotonic() - began
    files.lay_out(cfg.output, cfg)
    return "lay-out", time.monotonic() - began


class Accounting:
    """Writes the log of a run on rank 0, however the run ends."""

    def __init__(self, cfg, team, earlier):
        """earlier: name and seconds of what came before the log could be written."""
        self.work = None  # TaskStudy or Study
        self.log = RunLog(cfg.output, team.size, *earlier) if team.rank == 0 else None

    def phase(self, name):
        """The phase `name` begins."""
        if self.log:
            self.log.phase(name)

    def __enter__(self):
        return self

    def __exit__(self, kind, error, trace):
        if self.log:
            code = getattr(error, "exit_code", 1) if error else 0
            done = self.work.work if self.work else Work()
            self.log.end(done, code, str(error or "").partition("\n")[0])


def run(team, cfg, problem, log, figures):
    """Compute what the result file lacks, then print the summary and draw the figures."""
    began = time.monotonic()
    file = team.together(lambda: storage.ResultFile(cfg.output, team.comm, "r+"))
    file.program = team.on_root(lambda: files.register(file))
    bar = progress.Progress(cfg) if team.rank == 0 else None
    kind = TaskStudy if studies.is_tasks(cfg) else monte_carlo.Study
    work = log.work = kind(team, cfg, problem, file, bar, log.phase)
    team.on_root(lambda: announce(bar, cfg, team.size))
    try:
        work.run()
    except Interrupted as error:
        n_done, n_all = team.on_root(lambda: stop(bar, work))
        close(team, file, log)
        error.args = (
            f"{error} came; {n_done} of {n_all} {work.what} are in {cfg.output}, and the same "
            "command with --resume computes the others, on any number of ranks",
        )
        raise
    log.phase("summary")
    team.on_root(lambda: stop(bar, work))
    team.on_root(lambda: work.summary(time.monotonic() - began))
    close(team, file, log)
    team.on_root(work.require_results)
    if figures and not cfg.is_part:
        log.phase("figures")
        team.on_root(lambda: draw([cfg.output]))


def close(team, file, log):
    """Close the file, and say when somebody has taken it away while it was written."""
    log.phase("close")
    file.close()
    team.on_root(lambda: require_there(file.path))


def require_there(path):
    """Raises HpcrubError when a result file has lost its name."""
    if not path.exists():
        raise HpcrubError(f"{path} was removed or moved while this job ran")


def announce(bar, cfg, n_ranks):
    """Say what will be computed."""
    levels, samples, speeds = len(cfg.levels), cfg.samples, cfg.speeds.n_values
    what = f"levels x samples x speeds = {levels} x {len(samples)} x {speeds}"
    if cfg.is_part:
        which = ", ".join(map(str, cfg.levels))
        what += f" (levels {which}; samples {samples[0]} to {samples[-1]})"
    if studies.is_tasks(cfg):
        n_tasks = studies.find(cfg).n_tasks(cfg)
        what = f"{cfg.study}, {n_tasks} task{'s'[: n_tasks > 1]}"
    ranks = f"{n_ranks} rank{'s'[: n_ranks > 1]}"
    bar.say(f"hpcrub {__version__}: {what}, {ranks}, into {cfg.output}")


def stop(bar, work):
    """End the bar; returns the number of finished samples or tasks, and of all."""
    bar.stop()
    return work.n_done()


def draw(paths):
    """Draw the figures of one run, or those of several together, and name all files."""
    out = progress.console()
    if len(paths) == 1:
        out.print(f"results: {paths[0]}", soft_wrap=True)
    try:
        from hpcrub.commands.plot import of_study  # matplotlib takes a second to import

        for found in of_study(paths):
            whole = isinstance(found, Path)
            out.print(f"figure:  {found}" if whole else f"no figure: {found}", soft_wrap=True)
    except Exception as error:  # whatever it is, the results are whole and the study has not failed
        out.print(f"no figure: {type(error).__name__}: {reason(error)}", soft_wrap=True)


def dry_run(cfg, n_ranks):
    """Print what a study would compute and cost."""
    if studies.is_tasks(cfg):
        dry_run_tasks(cfg, n_ranks)
        return
    out = progress.console()
    problem = study.build_problem(cfg)
    levels, samples, speeds = len(cfg.levels), len(cfg.samples), cfg.speeds
    n_points = (levels * samples + cfg.mistuning.tuned_runs) * speeds.n_values
    rate, simulated = measure(cfg, problem)
    if not sweep.can_touch(problem.scene):
        simulated = 0.0
        out.print("contact:              none, the bumps do not reach the blades")
    seconds = n_points * simulated / cfg.time.step / rate
    print_model(out, cfg, problem)
    out.print(
        f"simulations:          {n_points:,} = ({levels} levels x {samples:,} samples + "
        f"{cfg.mistuning.tuned_runs} tuned) x {speeds.n_values} speeds"
    )
    out.print(f"output:               {files.file_size(cfg) / 1e6:,.4g} MB in {cfg.output}")
    out.print(f"measured:             {rate / 1e6:.3g} million steps per second and core")
    out.print(
        f"estimated run time:   {progress.duration(seconds / n_ranks)} on {n_ranks} "
        f"rank{'s'[: n_ranks > 1]}, {seconds / 3600:,.3g} core hours "
        f"({simulated:.3g} s simulated per point)"
    )


def print_model(out, cfg, model):
    """Frequencies of a Model or Problem, and the stability limit of the latter's time step."""
    omega = np.sqrt(model.reduced.tuned_eigenvalues)
    first = ", ".join(f"{f:.4f}" for f in omega[: cfg.disk.n_blades + 2] / (2 * np.pi))
    out.print(f"first frequencies:    {first} Hz", soft_wrap=True)
    out.print(f"highest frequency:    {omega[-1] / (2 * np.pi):.4g} Hz ({len(omega)} modes)")
    if isinstance(model, study.Problem):
        out.print(
            f"stability limit:      {model.stability_limit:.4g} s for central_difference; "
            f"time.step_s is {cfg.time.step:.4g} s ({cfg.time.scheme})"
        )


def dry_run_tasks(cfg, n_ranks):
    """The same for a study of independent tasks."""
    out, module = progress.console(), studies.find(cfg)
    module.prepare(cfg)
    problem = study.build_problem(cfg) if module.KERNEL else None
    if studies.STUDIES[cfg.study].has_disk:
        print_model(out, cfg, problem or study.build_model(cfg))
    out.print(f"tasks:                {module.n_tasks(cfg):,}")
    out.print(f"output:               {files.file_size(cfg) / 1e6:,.4g} MB in {cfg.output}")
    n_steps = module.cost(cfg)
    if n_steps:
        usual = cfg.model_copy(update={"speeds": config.Speeds()})  # enough for all lanes
        rate, _ = measure(usual, problem)
        seconds = n_steps / rate
        n_ranks = min(n_ranks, module.n_tasks(cfg))
        out.print(
            f"time steps:           {n_steps:,}, {rate / 1e6:.3g} million per second and core"
        )
        out.print(
            f"estimated run time:   {progress.duration(seconds / n_ranks)} on {n_ranks} ranks"
        )


def measure(cfg, problem):
    """Time steps per second and simulated time of a point [s], by a sweep of one mistuned disk."""
    sweep.warm_up()
    step = max(cfg.time.step, MEASURED_STEP)
    marched = problem.scene.shortcuts._replace(nothing_touches=False)
    scene = problem.scene._replace(scheme="exact_modal", step=step, shortcuts=marched)
    modes = mistuned_modes(problem.reduced, study.deviation(cfg, len(cfg.levels) - 1, 0))
    speeds = cfg.speeds.values_hz
    some = np.linspace(0, len(speeds) - 1, min(len(speeds), MEASURED_SPEEDS)).round().astype(int)
    start = time.perf_counter()
    result = sweep.run_sweep(modes, scene, speeds[some])
    return result.n_steps / (time.perf_counter() - start), result.time.mean()
