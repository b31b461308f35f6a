"""Run all studies of the paper, or go on with them, and hold them against its numbers.

Writes docs/reproduction.md. At 1 % of the samples it takes some minutes; the time of every step is
told first.
"""

import argparse
import subprocess
import sys
import time
from pathlib import Path

from evidence.reproduce import plan, report
from hpcrub.config import schema as config
from hpcrub.ranks.progress import duration
from hpcrub.runs import cost
from hpcrub.setup import problem as study
from hpcrub.studies import linear

FEW = 20  # samples that tell what a linear one costs


def main(argv=None):
    """Run and report; returns the exit code."""
    options = parse(argv)
    folder = options.results or Path("results") / f"reproduction_{options.scale:g}"
    if not options.report_only:
        announce(folder, options)
        for step in plan.STEPS:
            if options.only and step.name not in options.only:
                continue
            code = run(step, folder, options)
            if code:
                print(f"{step.name} ended with code {code}; the same command goes on from here")
                return code
    target = options.report
    report.write(folder, options.scale, target)
    print(f"report: {target}")
    return 0


def parse(argv):
    """Options of the command line."""
    parser = argparse.ArgumentParser(prog="python -m evidence.reproduce", description=__doc__)
    parser.add_argument("--scale", type=float, default=0.01, help="of the paper's sample counts")
    parser.add_argument("--ranks", type=int, default=2)
    parser.add_argument("--results", type=Path, help="folder, results/reproduction_SCALE if left")
    parser.add_argument("--report", type=Path, default=Path("docs/reproduction.md"))
    parser.add_argument("--only", nargs="*", metavar="STEP", help="these steps only")
    parser.add_argument("--report-only", action="store_true", help="run nothing")
    return parser.parse_args(argv)


def announce(folder, options):
    """Print how long every step will take on this machine, and all together."""
    cfg = config.Config()
    problem = study.build_problem(cfg)
    cost.trial(cfg, problem)  # compiles, which is no part of the rate
    rate = cost.trial(cfg, problem).steps_per_second
    total = 0.0
    for step in plan.STEPS:
        if options.only and step.name not in options.only:
            continue
        if step.sources and not all((folder / s).exists() for s in step.sources):
            steps = 50 * plan.USUAL_TIME / cfg.step * plan.n_samples(step, options.scale)
        else:
            steps = plan.time_steps(step, folder, options.scale)
        seconds = steps / rate
        if step.name == "linear":
            seconds = linear_seconds(4 * plan.n_samples(step, options.scale))
        total += seconds
        print(f"{step.name:20} {duration(seconds / options.ranks)}")
    print(
        f"all together about {duration(total / options.ranks)} on {options.ranks} ranks "
        f"({rate / 1e6:.3g} million steps per second and core), less what is already there",
        flush=True,
    )


def linear_seconds(n_samples):
    """What linear samples take on a core."""
    cfg = config.Config(study="linear", mistuning={"samples": FEW})
    problem = linear.prepare(cfg)
    began = time.perf_counter()
    list(linear.compute(cfg, problem, 0, lambda: None))
    return (time.perf_counter() - began) * n_samples / FEW


def run(step, folder, options):
    """Run one step, or the rest of it; returns the exit code."""
    began = time.monotonic()
    print(f"--- {step.name}", flush=True)
    launcher = ["mpirun", "-n", str(options.ranks)] if options.ranks > 1 else []
    command = [*launcher, sys.executable, str(plan.ROOT / "main.py")]
    command += [*plan.arguments(step, folder, options.scale), "--resume"]
    code = subprocess.run(command, check=False).returncode
    print(f"--- {step.name}: {duration(time.monotonic() - began)}", flush=True)
    return code


if __name__ == "__main__":
    sys.exit(main())
