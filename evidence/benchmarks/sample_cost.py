"""What a sample costs, and the start of a study, cold and warm, with its memory."""

import os
import tempfile

import numpy as np

from evidence.benchmarks import cases
from evidence.benchmarks.kernel_speed import best, goal
from evidence.page import ROOT, table
from evidence.program import ENVIRONMENT, run
from hpcrub.response import sweep

# Largest memory of this process [MB]. Linux keeps that of getrusage when a program starts another.
PEAK = "int(open('/proc/self/status').read().split('VmHWM:')[1].split()[0]) / 1024"


def whole_samples():
    """Seconds of a sample of 41 speeds, (step [s], longest time [s]) → mean of eight samples.

    Counted are modes and contact sweep; all else is about 1 % (docs/scaling.md).
    """
    out = {}
    for step, max_time in ((4e-5, 2.0), (3.3e-5, 2.0), (2e-5, 2.0), (2e-5, 5.0), (1e-6, 2.0)):
        model = cases.problem(step=step)
        steady = model.scene.steady._replace(max_time=max_time)
        scene = model.scene._replace(steady=steady)

        def sample(i, reduced=model.reduced, scene=scene):
            sweep.run_sweep(cases.modes_of(reduced, i), scene, cases.SPEEDS)

        runs = [best(lambda i=i: sample(i), 3) for i in range(8 if step > 1e-6 else 1)]
        out[step, max_time] = float(np.mean(runs))
    return out


def start_up():
    """Start of a study of one sample at one speed, with an empty and with a filled cache.

    For the planar disk and the blisk: processor seconds of the whole process, and its memory [MB].
    """
    code = (
        "import sys, time; sys.argv[0] = 'main.py';"
        "from hpcrub.commands.run import main; main(sys.argv[1:]);"
        f"print('used', time.process_time(), {PEAK})"
    )
    few = ["--set", "mistuning.samples=1", "--set", "mistuning.tuned_runs=1",
           "--set", "speeds.step_hz=1000", "--set", "steady_state.max_time_s=0.5"]  # fmt: skip
    out = {}
    for name in ("quickstart", "blisk/contact"):
        with tempfile.TemporaryDirectory() as folder:
            words = [ROOT / f"inputs/{name}.yaml", *few, "--no-figures", "--overwrite",
                     "--output", f"{folder}/out.h5"]  # fmt: skip
            environment = os.environ | ENVIRONMENT | {"XDG_CACHE_HOME": folder}
            environment.pop("NUMBA_CACHE_DIR", None)
            for cache in ("cold", "warm"):
                text = run(0, "-c", code, *words, env=environment, capture_output=True)
                out[name, cache] = tuple(map(float, text.rsplit("used", 1)[1].split()))
    return out


def sample():
    """Parts of the page: what samples take."""
    rows = [(f"{step:g} s", f"{longest:g} s", f"{seconds:.3f} s", goal(seconds <= 0.2, "0.2 s"))
            for (step, longest), seconds in whole_samples().items()]  # fmt: skip
    return {"whole": table(("step", "longest simulated time", "time", "goal"), rows)}


def start():
    """Parts of the page: what a rank takes before its first step."""
    rows = [[f"{name}, {cache} cache", *(f"{x:.1f}" for x in used)]
            for (name, cache), used in start_up().items()]  # fmt: skip
    return {"used": table(("input", "processor [s]", "memory [MB]"), rows)}
