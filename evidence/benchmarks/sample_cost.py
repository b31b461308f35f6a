"""What a sample costs: by part, cold and warm; memory."""

import os
import tempfile
import time
from pathlib import Path

import numpy as np

from evidence.benchmarks import cases
from evidence.benchmarks.kernel_speed import best, goal
from evidence.page import ROOT, table
from evidence.program import ENVIRONMENT, run
from hpcrub import studies
from hpcrub.config import schema as config
from hpcrub.response import sweep
from hpcrub.response.linear import linear_peak
from hpcrub.results.layout import DONE
from hpcrub.runs.result_files import lay_out
from hpcrub.studies import open_result
from hpcrub.studies.contact import file as contact_file
from hpcrub.studies.contact.amplification import point_values

# Largest memory of this process [MB]. Linux keeps that of getrusage when a program starts another.
PEAK = "int(open('/proc/self/status').read().split('VmHWM:')[1].split()[0]) / 1024"
STUDY = """\
speeds: {from_hz: 33.5, to_hz: 35.5, step_hz: 0.1}
mistuning: {half_range_percent: [3], samples: 2}
convergence: {step: 1}
"""


def parts():
    """Seconds of one sample by part: model (once), eigenproblem, linear peak, contact sweep."""
    start = time.perf_counter()
    model = cases.problem()
    built = time.perf_counter() - start
    modes, scene = cases.modes_of(model.reduced, 0), model.scene
    load = (scene.damping_ratio, 150.0, scene.n_bumps, scene.interface, 12)
    values = point_values(sweep.run_sweep(modes, scene, cases.SPEEDS)) | {"status": DONE}
    return {
        "model and reduction (once)": built,
        "eigenproblem": best(lambda: cases.modes_of(model.reduced, 0)),
        "linear peak": best(lambda: linear_peak(modes, *load)),
        "contact sweep, 41 speeds": best(lambda: sweep.run_sweep(modes, scene, cases.SPEEDS), 3),
        "writing to the file": writing(values),
    }


def writing(values):
    """Seconds for writing one sample with its status into a result file, on one rank."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "one.h5"
        lay_out(path, studies.run_of(config.Config(mistuning={"samples": 1})))
        file = open_result(path, mode="r+")
        seconds = best(lambda: contact_file.write_sample(file, 0, 0, values))
        file.close()
    return seconds


def whole_samples():
    """Seconds of a sample of 41 speeds, (step [s], longest time [s]) → mean of eight samples.

    Counted are modes and contact sweep; all else is below 1 % (`parts`).
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
           "--set", "steady_state.max_time_s=0.5"]  # fmt: skip
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


def memory():
    """Largest memory of rank 0 and of another rank in a study of two samples on two ranks [MB]."""
    code = (
        "import sys; from hpcrub.commands.run import main; code = main(sys.argv[1:]);"
        "from mpi4py import MPI; rank = MPI.COMM_WORLD.rank;"
        f"open(f'{{rank}}.mb', 'w').write(str({PEAK}));"
        "sys.exit(code)"
    )
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "study.yaml").write_text(STUDY)
        run(2, "-c", code, "study.yaml", folder=folder, capture_output=True)
        return [float((Path(folder) / f"{rank}.mb").read_text()) for rank in (0, 1)]


def sample():
    """Parts of the page: where the time of a sample goes, and what samples take."""
    by_part = parts()
    total = sum(v for k, v in by_part.items() if "once" not in k)
    rows = [(k, f"{1e3 * v:.2f} ms", "" if "once" in k else f"{100 * v / total:.2f} %")
            for k, v in by_part.items()]  # fmt: skip
    whole = [(f"{step:g} s", f"{longest:g} s", f"{seconds:.3f} s", goal(seconds <= 0.2, "0.2 s"))
             for (step, longest), seconds in whole_samples().items()]  # fmt: skip
    return {
        "parts": table(("part", "time", "share of a sample"), rows),
        "whole": table(("step", "longest simulated time", "time", "goal"), whole),
    }


def start():
    """Parts of the page: what a rank takes before its first step."""
    rows = [[f"{name}, {cache} cache", *(f"{x:.1f}" for x in used)]
            for (name, cache), used in start_up().items()]  # fmt: skip
    rows += [[f"study on two ranks, rank {rank}", "", f"{mb:.1f}"]
             for rank, mb in enumerate(memory())]  # fmt: skip
    return {"used": table(("input", "processor [s]", "memory [MB]"), rows)}
