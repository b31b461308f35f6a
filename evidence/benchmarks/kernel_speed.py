"""Simulated steps per second and core, against plain C and the machine's limit."""

import itertools
import subprocess
import tempfile
import time
from pathlib import Path

import numpy as np

from evidence.page import table
from hpcrub.config.schema import Config
from hpcrub.contact.bank import allocate
from hpcrub.contact.integrate import run
from hpcrub.contact.lanes import WIDTH
from hpcrub.contact.observers import NOTHING, Record
from hpcrub.contact.recurrence import coefficients
from hpcrub.model.mistuning import stiffness_deviation
from hpcrub.model.reduction import mistuned_modes
from hpcrub.response.revolution import cut_revolution
from hpcrub.setup.problem import build_problem

SPEEDS = np.round(np.arange(33.5, 35.501, 0.05), 10)  # [Hz], as in the paper
HALF_RANGE = 0.03  # mistuning level 1.7 %
N_MODES = (36, 60, 120)
WARM = 80  # blocks until the blades rub as they do most of the time
REPEATS = 7  # of which the best counts
SIDES = 5  # comparisons, in turns
LARGE = 1024  # rows of the matrices whose product shows the machine's limit


def best(function, repeats=REPEATS):
    """Shortest processor time of a call [s]."""
    times = []
    for _ in range(repeats):
        start = time.process_time()
        function()
        times.append(time.process_time() - start)
    return min(times)


def problem(n_modes=60, scheme="exact_modal", step=3.3e-5):
    """Reduced model and scene of the reference disk."""
    keys = {"reduction.n_modes": n_modes, "time.scheme": scheme, "time.step_s": step}
    return build_problem(Config().replace(keys))


def modes_of(reduced, sample):
    """Modes of a mistuned sample."""
    n_blades = len(reduced.blade_stiffness)
    return mistuned_modes(reduced, stiffness_deviation(2020, 0, sample, n_blades, HALF_RANGE))


def planar(n_modes=60, name="exact_modal"):
    """Modes and Scene of a mistuned sample of the reference disk."""
    step = 2e-5 if n_modes <= 60 or name == "exact_modal" else 1e-5
    built = problem(n_modes, name, step)
    return modes_of(built.reduced, 0), built.scene


class Lanes:
    """Lanes of one disk that rub, ready to be timed."""

    def __init__(self, modes, scene, width=WIDTH, speeds=(33.5, 35.5), warm=WARM):
        self.modes, self.scene, self.width = modes, scene, width
        self.grid = cut_revolution(speeds[0], scene)
        self.bank = allocate(modes, scene, self.grid, width, np.linspace(*speeds, width))
        run(self.bank, warm)

    def rate(self, n_blocks=10, recording=False):
        """Simulated steps per second."""
        every = self.grid.stride, self.grid.look
        record = Record.allocate(self.bank, n_blocks, *every) if recording else NOTHING
        seconds = best(lambda: run(self.bank, n_blocks, record))
        return n_blocks * self.grid.steps_per_block * self.width / seconds

    def contacts(self, n_blocks, n_looks):
        """Mean number of points in contact in a lane, looked at so often over each block."""
        scheme, points, counts = self.bank.scheme, self.bank.scheme.normal.shape[1], []
        cuts = np.linspace(0, len(scheme.bump), n_looks + 1).astype(int)
        for first, last in [*itertools.pairwise(cuts)] * n_blocks:
            part = scheme._replace(bump=scheme.bump[first:last])
            run(self.bank._replace(scheme=part), 1)
            counts.append((self.bank.state.multiplier[:points] > 0.0).sum() / self.width)
        return float(np.mean(counts))


def plain_c(lanes, speed=34.0, n_steps=100_000):
    """Steps per second of ``dense.c``: the same scheme in the coordinates of the reduced model."""
    modes, scene, grid = lanes.modes, lanes.scene, lanes.grid
    h = 1.0 / (speed * grid.steps_per_revolution)
    keep, push = coefficients(scene.scheme, modes.omega, scene.damping_ratio, h)
    inverse = np.linalg.inv(modes.shapes)
    load = -(modes.normal + scene.friction * modes.tangential).T
    moved = modes.shapes @ (push[:, None] * load)
    bump = scene.casing.table(
        scene.interface.angle, grid.steps_per_revolution, grid.steps_per_block
    )
    arrays = (  # u+ = A1 u + A2 u-, push, W, bump
        modes.shapes @ np.diag(1.0 + keep - modes.omega**2 * push) @ inverse,
        -modes.shapes @ np.diag(keep) @ inverse,
        moved,
        -moved[: len(modes.normal)],
        bump,
    )
    sizes = len(inverse), bump.shape[1], len(bump), n_steps
    return n_steps / run_c("dense.c", sizes, (h, scene.ramp_time, scene.clearance), arrays)[0]


def run_c(name, sizes, scalars, arrays):
    """What a C program of this folder prints of a problem: seconds first, of the fastest run.

    sizes are written first, then scalars and arrays in their order.
    """
    with tempfile.TemporaryDirectory() as folder:
        source, program = Path(__file__).with_name(name), Path(folder) / "dense"
        options = ["-O3", "-march=native", "-ffast-math"]
        subprocess.run(["gcc", *options, "-o", program, source, "-lm"], check=True)
        with open(Path(folder) / "case.bin", "wb") as file:
            for values in (sizes, scalars, *arrays):
                np.ascontiguousarray(values).tofile(file)
        runs = [
            subprocess.run([program, file.name], check=True, capture_output=True, text=True)
            for _ in range(3)
        ]
    return min([float(word) for word in run.stdout.split()] for run in runs)


def needed_flops(n_modes, n_points, n_contacts, sweeps=6):
    """Floating-point operations that one step of one speed needs: modes, penetrations, contacts."""
    modal = 6 * n_modes
    penetrations = 2 * n_modes * n_points + 2 * n_points
    correction = 2 * n_modes * n_contacts + n_modes
    multipliers = sweeps * n_contacts * (2 * n_contacts + 2)
    return modal + penetrations + correction + multipliers


def beside(lanes, c, flops, contacts, n_blocks=10, recording=()):
    """Two tables: steps per second in turns with C and the machine's limit, and what that says.

    In turns, as the machine's speed drifts; c: function of the lanes.
    """
    rows, over_c, below = [], [], []
    large = np.random.default_rng(0).random((LARGE, LARGE))
    for _ in range(SIDES):
        ours = lanes.rate(n_blocks)
        others = [lanes.rate(n_blocks, recording=True) for _ in recording]
        theirs, gflops = c(lanes), 2e-9 * LARGE**3 / best(lambda: large @ large)
        limit = 1e9 * gflops / flops
        over_c.append(ours / theirs)
        below.append(limit / ours)
        rates = [*(f"{rate / 1e6:.3f}" for rate in (ours, *others)), f"{theirs / 1e6:.4f}"]
        rows.append([*rates, f"{over_c[-1]:.1f}", f"{gflops:.0f} GFLOP/s", f"{limit / 1e6:.2f}",
                     f"{below[-1]:.1f}"])  # fmt: skip
    heads = ["hpcrub", *recording, "C, dense", "hpcrub / C", "large matrix product", "its limit",
             "limit / hpcrub"]  # fmt: skip
    facts = [
        ["times as fast as the C program, median", f"{np.median(over_c):.1f}",
         goal(np.median(over_c) >= 16.0, "at least 16")],
        ["times from the machine's limit, median", f"{np.median(below):.1f}",
         goal(np.median(below) <= 4.0, "at most 4")],
        ["floating-point operations of a step of one speed", f"{flops:.0f}", ""],
        ["points in contact at a time, on average", f"{contacts:.1f}", ""],
    ]  # fmt: skip
    return {"sides": table(heads, rows), "facts": table(["what", "value", "goal"], facts)}


def goal(reached, words):
    """A goal, and whether it is reached."""
    return f"{words}: {'reached' if reached else '**not reached**'}"


def section():
    """Parts of the page: schemes and modes, then the comparison."""
    reference, rows = Lanes(*planar()), []
    for name in ("central_difference", "exact_modal"):
        for n_modes in N_MODES:
            lanes = Lanes(*planar(n_modes, name))
            rates = lanes.rate(), lanes.rate(recording=True)
            rows.append([name, n_modes, *(f"{rate / 1e6:.2f}" for rate in rates)])
    heads = ["scheme", "η", "million steps/s", "the same while recording"]
    contacts = reference.contacts(20, 1)
    flops = needed_flops(len(reference.modes.omega), 12, contacts)
    return {"modes": table(heads, rows)} | beside(reference, plain_c, flops, contacts)
