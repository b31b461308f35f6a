"""Run-ups: what they add to the steps of the kernel, and ten seconds beside a sweep."""

import time
from unittest import mock

import numpy as np

from evidence.page import table
from hpcrub.config.schema import load_runs
from hpcrub.contact import integrate
from hpcrub.response.run_up import Asked, Runner
from hpcrub.response.schedule import Schedule
from hpcrub.response.sweep import run_sweep
from hpcrub.setup.disks import deviation, rubbing_modes
from hpcrub.setup.input_files import resolved
from hpcrub.setup.problem import build_problem

# input, range of speeds [Hz], rates [Hz/s], keys beside
SCENES = {
    "the paper's disk": ("inputs/quickstart.yaml", (32.0, 37.0), (0.5, 2.0, 10.0), ()),
    "rotor 67": ("inputs/rotor67/contact.yaml", (255.0, 262.0), (5.0, 20.0), ()),
}
LASTS, REPEATS, TURNS, N_SPEEDS = 10.0, 8, 3, 41


def _disk(name, *overrides):
    config = resolved(load_runs(name, overrides)[0])
    problem = build_problem(config)
    return problem.scene, rubbing_modes(config, problem, deviation(config, 0, 0))


def _seconds(runner):
    """Seconds of a run, and those of the kernel among them."""
    inside, run = [], integrate.run

    def timed(*arguments):
        began = time.perf_counter()
        run(*arguments)
        inside.append(time.perf_counter() - began)

    with mock.patch.object(integrate, "run", timed):
        began = time.perf_counter()
        for _ in runner.go_on():
            pass
        return time.perf_counter() - began, sum(inside)


def steps():
    """Table: µs of a step of eight lanes in a run-up, and the kernel's part of it."""
    rows = []
    for name, (path, ends, rates, overrides) in SCENES.items():
        scene, modes = _disk(path, *overrides)
        borders = np.linspace(*ends, 65)
        for rate in rates:
            found = []
            for _ in range(TURNS + 1):  # the first one loads the kernel
                runner = Runner(
                    modes, scene, Schedule.of_rate(*ends, rate), Asked(borders, REPEATS)
                )
                whole, kernel = _seconds(runner)
                n_steps = runner.n_done * runner.period
                found.append((whole / n_steps, kernel / n_steps))
            whole, kernel = min(found[1:])
            rows.append([f"{name}, {rate:g} Hz/s", f"{1e6 * whole:.2f}", f"{1e6 * kernel:.2f}",
                         f"{whole / kernel:.2f}"])  # fmt: skip
    heads = "run-up", "µs of a step", "of these the kernel", "ratio"
    return table(heads, rows)


def beside():
    """Table: ten seconds of a run-up beside a sweep over as many Hz, of one disk on one core."""
    path, ends, _, overrides = SCENES["the paper's disk"]
    scene, modes = _disk(path, *overrides)
    speeds, borders = np.linspace(*ends, N_SPEEDS), np.linspace(*ends, 65)
    schedule, taken = Schedule.of_rate(*ends, (ends[1] - ends[0]) / LASTS), []
    for _ in range(TURNS + 1):
        whole, _ = _seconds(Runner(modes, scene, schedule, Asked(borders, REPEATS)))
        began = time.perf_counter()
        run_sweep(modes, scene, speeds)
        taken.append((whole, time.perf_counter() - began))
    run, sweep = np.min(taken[1:], axis=0)
    rows = [[f"{LASTS:g} s of a run-up, {REPEATS} repetitions", f"{run:.2f}"],
            [f"sweep of {N_SPEEDS} speeds", f"{sweep:.2f}"]]  # fmt: skip
    return table(("one mistuned disk on one core", "s"), rows)


def section():
    """Parts of the page."""
    return {"steps": steps(), "beside": beside()}
