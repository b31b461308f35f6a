"""Is what a study calls steady true? Its default time step beside one ten times finer.

`limits` lowers the number of steps per bump width, and per period, until amplitudes are wrong:
from there come the limits of `hpcrub.studies.plausibility`. `scenes` draws disks, casings and
speeds over the input, and compares every amplitude that is steady at both steps.
"""

import argparse
import math
import random
from typing import Any, NamedTuple

import numpy as np

from hpcrub import studies
from hpcrub.config.schema import Config, replaced
from hpcrub.contact.status import STEADY
from hpcrub.errors import InputError
from hpcrub.response.sweep import run_sweep
from hpcrub.studies import plausibility
from hpcrub.studies.problem import build_problem
from hpcrub.studies.samples import modes_of

FINER = 10.0
TOLERANCE = 0.05  # of an amplitude that is steady and periodic
STRICT = {  # periodic, and not only much alike from window to window
    "steady_state.min_correlation": 0.9999,
    "steady_state.max_amplitude_change": 1e-3,
    "steady_state.confirmations": 2,
}
SMALL = {
    "disk.n_blades": 3,
    "disk.blade.n_elements": 3,
    "reduction.n_modes": 4,
    "steady_state.max_time_s": 2.0,
}


class Row(NamedTuple):
    """What became of the scenes."""

    scenes: int
    refused: int
    marked: int
    points: int  # of the others, steady and periodic at both steps
    wrong: int  # of these, further apart than the tolerance
    largest: float  # relative difference


def scene(rng: random.Random) -> dict[str, Any]:
    """Keys of a random disk, casing and speed."""

    def log(low, high):
        return math.exp(rng.uniform(math.log(low), math.log(high)))

    height = log(0.05, 5.0)
    n_bumps = rng.choice((1, 2, 3, 4, 6, 12, 50, 300))
    speed = log(20.0, 500.0) / n_bumps if rng.random() < 0.6 else log(2.0, 10_000.0)
    return {
        "disk.blade.thickness_mm": log(5.0, 30.0),
        "disk.blade.lean_deg": rng.uniform(0.0, 50.0),
        "material.damping_ratio": log(0.003, 0.3),
        "casing.n_bumps": n_bumps,
        "casing.bump_height_mm": height,
        "casing.clearance_mm": height * rng.choice((0.0, rng.random(), 1.0 - log(1e-6, 0.1))),
        "casing.growth_time_s": log(1e-3, 2.0),
        "contact.friction": rng.choice((0.0, 0.15, rng.uniform(0.0, 0.5))),
        "time.step_s": log(1e-6, 1e-2),
        "speeds.from_hz": speed,
        "speeds.to_hz": speed * 1.04,
        "speeds.step_hz": speed * 0.04 / 7.5,
    }


def amplitudes(config: Config) -> np.ndarray:
    """Amplitude of the tuned disk at every speed [m], NaN where not steady."""
    problem = build_problem(config)
    modes = modes_of(config, problem, np.zeros(config.disk.n_blades))
    result = run_sweep(modes, problem.scene, config.speeds.values_hz)
    return np.where(result.point_status == STEADY, result.amplitude, np.nan)


def finer(config: Config, factor: float) -> Config:
    """The same with a time step so many times shorter."""
    return replaced(config, {"time.step_s": config.step / factor})


def differences(config: Config, reference: Config) -> np.ndarray:
    """Relative differences of the amplitudes that are steady in both, and not zero."""
    found, true = amplitudes(config), amplitudes(reference)
    both = np.isfinite(found) & np.isfinite(true) & (np.maximum(found, true) > 0.0)
    return np.abs(found - true)[both] / np.maximum(found, true)[both]


def scenes(n: int, seed: int, most_steps: float) -> Row:
    """Random scenes, each at its own step and at one ten times finer."""
    rng = random.Random(seed)
    refused = marked = 0
    found: list[np.ndarray] = []
    while len(found) + refused + marked < n:
        keys = SMALL | STRICT | scene(rng)
        try:
            config = studies.check(replaced(Config(), keys))
            problem = build_problem(config)
        except InputError:
            refused += 1
            continue
        if any(plausibility.warnings(config, problem)):
            marked += 1
            continue
        if config.steady_state.max_time / config.step > most_steps:  # takes too long here
            continue
        found.append(differences(config, finer(config, FINER)))
    every = np.concatenate(found) if found else np.zeros(0)
    wrong = int(np.count_nonzero(every > TOLERANCE))
    return Row(n, refused, marked, every.size, wrong, float(every.max(initial=0.0)))


def limit(key: str, number: float) -> tuple[float, float]:
    """Median and 95th percentile of the difference with so few steps, from 64 times as many.

    A strongly damped disk, whose motion is periodic, at speeds through its resonance.
    """
    every = []
    for n_bumps in (1, 4):
        keys = SMALL | STRICT | {
            "material.damping_ratio": 0.05,
            "casing.n_bumps": n_bumps,
            "contact.friction": 0.0,
            "speeds.from_hz": 80.0 / n_bumps,
            "speeds.to_hz": 160.0 / n_bumps,
            "speeds.step_hz": 10.0 / n_bumps,
            "time.steps_per_bump_width": 1.0,
            "time.steps_per_period": 1.0,
            "time.step_s": 1e-2,
            f"time.{key}": number,
        }  # fmt: skip
        config = replaced(Config(), keys)
        every.append(differences(config, finer(config, 64.0 / number)))
    joined = np.concatenate(every)
    return float(np.median(joined)), float(np.percentile(joined, 95))


def table(row: Row) -> str:
    """The row as a table of the page."""
    return (
        "| scenes | refused | marked | steady points | apart by more than 5 % | largest |\n"
        "|---|---|---|---|---|---|\n"
        f"| {row.scenes} | {row.refused} | {row.marked} | {row.points} | {row.wrong} | "
        f"{100 * row.largest:.2f} % |"
    )


def main(argv: list[str] | None = None) -> int:
    """Print both tables; returns 1 when an amplitude is wrong and was not marked."""
    parser = argparse.ArgumentParser(prog="python -m evidence.stress.plausibility")
    parser.add_argument("--scenes", type=int, default=300, metavar="N")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--most-steps", type=float, default=1e6, help="leave out longer scenes")
    parser.add_argument("--limits", action="store_true", help="measure the limits, too")
    options = parser.parse_args(argv)
    if options.limits:
        print("| steps per bump width | median difference | 95 % of the points below |")
        print("|---|---|---|")
        for number in (1, 2, 4, 8, 16):
            middle, high = limit("steps_per_bump_width", number)
            print(f"| {number} | {100 * middle:.2f} % | {100 * high:.2f} % |", flush=True)
    row = scenes(options.scenes, options.seed, options.most_steps)
    print(table(row))
    return int(row.wrong > 0)


if __name__ == "__main__":
    raise SystemExit(main())
