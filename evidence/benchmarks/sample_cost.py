"""What a sample costs: by part, by size of the disk, cold and warm, and on one and two ranks."""

import os
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from evidence.benchmarks import cases
from evidence.benchmarks.kernel_speed import Lanes, best
from hpcrub.config import schema as config
from hpcrub.response import sweep
from hpcrub.response.linear import linear_peak
from hpcrub.results import contact_file
from hpcrub.results.layout import DONE
from hpcrub.studies.amplification import point_values
from hpcrub.studies.files import lay_out, open_result
from tests.program import ENVIRONMENT, ROOT

N_BLADES = (6, 12, 24, 48, 96)
N_MODES = (36, 48, 84, 144)  # of all of them, 24 + η
N_BUMPS = (2, 3, 4, 6)
STUDY = """\
speeds: {from_hz: 33.5, to_hz: 35.5, step_hz: 0.1}
mistuning: {half_range_percent: [3], samples: 128}
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
        lay_out(path, config.Config(mistuning={"samples": 1}))
        file = open_result(path, mode="r+")
        seconds = best(lambda: contact_file.write_sample(file, 0, 0, values))
        file.close()
    return seconds


def whole_samples():
    """Seconds of a sample of 41 speeds, (step [s], longest time [s]) → mean of eight samples.

    Of modes and contact sweep; all else is below 1 % (`parts`).
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


def shortcuts():
    """Seconds of the sweep with each shortcut switched off, and with all switched on.

    `nothing_touches` where the bumps are lower than the clearance, the others where blades rub.
    """
    model = cases.problem()
    modes, scene = cases.modes_of(model.reduced, 0), model.scene
    scene = scene._replace(steady=scene.steady._replace(max_time=1.0))
    low = scene._replace(bump_height=scene.clearance)
    seconds = {name: [np.inf, np.inf] for name in scene.shortcuts._fields}
    for _ in range(3):  # in turns: the machine's speed drifts
        for name, fastest in seconds.items():
            here = low if name == "nothing_touches" else scene
            off = here._replace(shortcuts=scene.shortcuts._replace(**{name: False}))
            for i, case in enumerate((off, here)):
                run = best(lambda s=case: sweep.run_sweep(modes, s, cases.SPEEDS), 1)
                fastest[i] = min(fastest[i], run)
    return seconds


def seconds_per_step(n_blades=12, n_modes=60, n_bumps=4):
    """Seconds of one step of one of 16 lanes, for a disk of another size."""
    model = cases.problem(n_modes, n_blades=n_blades)
    scene = model.scene._replace(n_bumps=n_bumps)
    return 1.0 / Lanes(16, model=(cases.modes_of(model.reduced, 0), scene)).rate(2)


def scaling():
    """{name: (sizes, seconds per step, fitted exponent, exponents from size to size)}."""
    cases_of = {
        "blades, five modes each": (N_BLADES, lambda n: seconds_per_step(n, 5 * n)),
        "modes 24 + η, 12 blades": (N_MODES, lambda n: seconds_per_step(n_modes=n - 24)),
        "bumps, 12 blades": (N_BUMPS, lambda n: seconds_per_step(n_bumps=n)),
    }
    out = {}
    for name, (sizes, cost) in cases_of.items():
        seconds = [cost(size) for size in sizes]
        logs = np.log(sizes), np.log(seconds)
        local = np.diff(logs[1]) / np.diff(logs[0])
        out[name] = sizes, seconds, float(np.polyfit(*logs, 1)[0]), local
    return out


def start_up():
    """Seconds of `warm_up` in a new process, with an empty and with a filled cache."""
    code = (
        "import time; t = time.perf_counter(); from hpcrub.response import sweep; sweep.warm_up();"
        "print(time.perf_counter() - t)"
    )
    with tempfile.TemporaryDirectory() as cache:
        environment = os.environ | {"XDG_CACHE_HOME": cache, "PYTHONPATH": str(ROOT)}
        environment.pop("NUMBA_CACHE_DIR", None)
        runs = [
            subprocess.run([sys.executable, "-c", code], check=True, capture_output=True,
                           text=True, env=environment).stdout
            for _ in range(2)
        ]  # fmt: skip
    cold, warm = map(float, runs)
    return {"cold": cold, "warm": warm}


def memory():
    """Largest memory of rank 0 and of another rank in a study of two samples on two ranks [MB]."""
    code = (
        "import sys, resource; from hpcrub.commands.run import main; code = main(sys.argv[1:]);"
        "from mpi4py import MPI; rank = MPI.COMM_WORLD.rank;"
        "open(f'{rank}.kb', 'w').write(str(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss));"
        "sys.exit(code)"
    )
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "study.yaml").write_text(STUDY)
        few = ["--set", "mistuning.samples=2", "--set", "convergence.step=1"]
        command = ["mpirun", "-n", "2", sys.executable, "-c", code, "study.yaml", *few]
        environment = os.environ | ENVIRONMENT | {"PYTHONPATH": str(ROOT)}
        subprocess.run(command, check=True, capture_output=True, cwd=folder, env=environment)
        return [int((Path(folder) / f"{rank}.kb").read_text()) / 1024 for rank in (0, 1)]


def ranks():
    """Wall seconds of the same study on one and two ranks, as the program tells, best of three.

    Without the figure, which one rank draws.
    """
    seconds = {1: np.inf, 2: np.inf}
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "study.yaml"
        path.write_text(STUDY)
        for _ in range(3):
            for n in seconds:
                command = ["mpirun", "-n", str(n), sys.executable, str(ROOT / "main.py"), path.name]
                command += ["--overwrite", "--no-figures"]
                run = subprocess.run(command, check=True, capture_output=True, text=True,
                                     cwd=folder, env=os.environ | ENVIRONMENT)  # fmt: skip
                told = float(re.search(r"wall time ([\d.]+) s", run.stdout)[1])
                seconds[n] = min(seconds[n], told)
    return seconds
