"""What a sample costs, and the start of a study, cold and warm, with its memory."""

import os
import tempfile

import numpy as np

from evidence.benchmarks.kernel_speed import SPEEDS, best, goal, modes_of, problem
from evidence.page import ROOT, table
from evidence.program import ENVIRONMENT, run
from hpcrub.response import sweep

# Largest memory of this process [MB]. Linux keeps that of getrusage when a program starts another.
PEAK = "int(open('/proc/self/status').read().split('VmHWM:')[1].split()[0]) / 1024"


def sample():
    """Parts of the page: what a sample of 41 speeds takes, mean of eight.

    Counted are modes and contact sweep; all else is about 1 % (docs/scaling.md).
    """
    rows = []
    for step, max_time in ((4e-5, 2.0), (3.3e-5, 2.0), (2e-5, 2.0), (2e-5, 5.0), (1e-6, 2.0)):
        model = problem(step=step)
        steady = model.scene.steady._replace(max_time=max_time)
        scene = model.scene._replace(steady=steady)

        def compute(i, reduced=model.reduced, scene=scene):
            sweep.run_sweep(modes_of(reduced, i), scene, SPEEDS)

        runs = [best(lambda i=i: compute(i), 3) for i in range(8 if step > 1e-6 else 1)]
        seconds = float(np.mean(runs))
        rows.append([f"{step:g} s", f"{max_time:g} s", f"{seconds:.3f} s",
                     goal(seconds <= 0.2, "0.2 s")])  # fmt: skip
    return {"whole": table(("step", "longest simulated time", "time", "goal"), rows)}


def start():
    """Parts of the page: what a study of one sample at one speed takes, with an empty and with a
    filled cache, of the planar disk and the blisk: the whole process, and its memory."""
    code = (
        "import sys, time; sys.argv[0] = 'main.py';"
        "from hpcrub.commands.run import main; main(sys.argv[1:]);"
        f"print('used', time.process_time(), {PEAK})"
    )
    few = ["--set", "mistuning.samples=1", "--set", "mistuning.tuned_runs=1",
           "--set", "speeds.step_hz=1000", "--set", "steady_state.max_time_s=0.5"]  # fmt: skip
    rows = []
    for name in ("quickstart", "blisk/contact"):
        with tempfile.TemporaryDirectory() as folder:
            words = [ROOT / f"inputs/{name}.yaml", *few, "--no-figures", "--overwrite",
                     "--output", f"{folder}/out.h5"]  # fmt: skip
            environment = os.environ | ENVIRONMENT | {"XDG_CACHE_HOME": folder}
            environment.pop("NUMBA_CACHE_DIR", None)
            for cache in ("cold", "warm"):
                text = run(0, "-c", code, *words, env=environment, capture_output=True)
                used = map(float, text.rsplit("used", 1)[1].split())
                rows.append([f"{name}, {cache} cache", *(f"{x:.1f}" for x in used)])
    return {"used": table(("input", "processor [s]", "memory [MB]"), rows)}
