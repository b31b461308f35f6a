"""What a sample costs: by part, by size of the disk, cold and warm, and on one and two ranks."""

import os
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from benchmarks import cases
from benchmarks.kernel_speed import Lanes, best
from hpcrub import sweep
from hpcrub.linear import linear_peak

ROOT = Path(__file__).resolve().parent.parent
N_BLADES = (6, 12, 24, 48, 96)
N_MODES = (12, 24, 60, 120)
N_BUMPS = (2, 3, 4, 6)
MPI = {
    "OMPI_ALLOW_RUN_AS_ROOT": "1",
    "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
    "OMPI_MCA_rmaps_base_oversubscribe": "1",
}
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
    load = (scene.damping_ratio, 150.0, scene.n_bumps, scene.contact_angle, 12)
    return {
        "model and reduction (once)": built,
        "eigenproblem": best(lambda: cases.modes_of(model.reduced, 0)),
        "linear peak": best(lambda: linear_peak(modes, *load)),
        "contact sweep, 41 speeds": best(lambda: sweep.run_sweep(modes, scene, cases.SPEEDS), 3),
    }


def whole_samples():
    """Seconds of a sample of 41 speeds, (step [s], longest time [s]) → mean of four samples."""
    out = {}
    for step, max_time in ((4e-5, 2.0), (3.3e-5, 2.0), (2e-5, 2.0), (2e-5, 5.0), (1e-6, 2.0)):
        model = cases.problem(step=step)
        steady = model.scene.steady._replace(max_time=max_time)
        scene = model.scene._replace(steady=steady)
        samples = [cases.modes_of(model.reduced, i) for i in range(4 if step > 1e-6 else 1)]
        runs = [best(lambda m=m, s=scene: sweep.run_sweep(m, s, cases.SPEEDS), 2) for m in samples]
        out[step, max_time] = float(np.mean(runs))
    return out


def shortcuts():
    """Seconds of the sweep with each shortcut switched off, relative to all switched on."""
    model = cases.problem()
    modes, scene = cases.modes_of(model.reduced, 0), model.scene
    scene = scene._replace(steady=scene.steady._replace(max_time=1.0))
    options = {"all on": scene.shortcuts}
    for name in scene.shortcuts._fields:
        options[f"without {name}"] = scene.shortcuts._replace(**{name: False})
    seconds = dict.fromkeys(options, np.inf)
    for _ in range(3):  # in turns: the machine's speed drifts
        for name, value in options.items():
            changed = scene._replace(shortcuts=value)
            run = best(lambda s=changed: sweep.run_sweep(modes, s, cases.SPEEDS), 1)
            seconds[name] = min(seconds[name], run)
    return {name: value / seconds["all on"] for name, value in seconds.items()}


def seconds_per_step(n_blades=12, n_modes=60, n_bumps=4):
    """Seconds of one step of one of 16 lanes, for a disk of another size."""
    model = cases.problem(n_modes, n_blades=n_blades)
    scene = model.scene._replace(n_bumps=n_bumps)
    return 1.0 / Lanes(16, model=(cases.modes_of(model.reduced, 0), scene)).rate(2)


def scaling():
    """{name: (sizes, seconds per step, fitted exponent)}."""
    cases_of = {
        "blades, five modes each": (N_BLADES, lambda n: seconds_per_step(n, 5 * n)),
        "modes η, 12 blades": (N_MODES, lambda n: seconds_per_step(n_modes=n)),
        "bumps, 12 blades": (N_BUMPS, lambda n: seconds_per_step(n_bumps=n)),
    }
    out = {}
    for name, (sizes, cost) in cases_of.items():
        seconds = [cost(size) for size in sizes]
        total = sizes if "modes" not in name or "blades, f" in name else [24 + n for n in sizes]
        out[name] = sizes, seconds, float(np.polyfit(np.log(total), np.log(seconds), 1)[0])
    return out


def start_up():
    """Seconds of `warm_up` in a new process, with an empty and with a filled cache, and MB."""
    code = (
        "import time; t = time.perf_counter(); from hpcrub import sweep; sweep.warm_up();"
        "print(time.perf_counter() - t,"
        " [int(l.split()[1]) / 1024 for l in open('/proc/self/status') if 'VmHWM' in l][0])"
    )
    with tempfile.TemporaryDirectory() as cache:
        environment = os.environ | {"XDG_CACHE_HOME": cache, "PYTHONPATH": str(ROOT)}
        environment.pop("NUMBA_CACHE_DIR", None)
        runs = [
            subprocess.run([sys.executable, "-c", code], check=True, capture_output=True,
                           text=True, env=environment).stdout.split()
            for _ in range(2)
        ]  # fmt: skip
    (cold, _), (warm, megabytes) = (map(float, run) for run in runs)
    return {"cold": cold, "warm": warm, "memory_mb": megabytes}


def ranks():
    """Wall seconds of the same study on one and two ranks, as the program tells, best of two."""
    seconds = {1: np.inf, 2: np.inf}
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "study.yaml"
        path.write_text(STUDY)
        for _ in range(2):
            for n in seconds:
                command = ["mpirun", "-n", str(n), sys.executable, str(ROOT / "main.py"), path.name]
                run = subprocess.run([*command, "--overwrite"], check=True, capture_output=True,
                                     text=True, cwd=folder, env=os.environ | MPI)  # fmt: skip
                told = float(re.search(r"wall time ([\d.]+) s", run.stdout)[1])
                seconds[n] = min(seconds[n], told)
    return seconds
