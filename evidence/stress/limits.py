"""Where the limits of `hpcrub.studies.plausibility` come from: errors against what is resolved.

The scenes are those of `plausibility`, with a damping ratio of at least 0.02, so that most motions
are periodic. Every one starts from the periodic motion of a much better resolved run, and ends in
an amplitude that is compared with that run's.
"""

import argparse
import random
from typing import Any

import numpy as np

from evidence import page
from evidence.stress.plausibility import apart, input_of, scene, sweep
from hpcrub.config import resolution
from hpcrub.config.schema import Config, replaced
from hpcrub.errors import InputError
from hpcrub.response.sweep import can_touch
from hpcrub.studies import plausibility
from hpcrub.studies.problem import build_problem

NUMBERS = 4, 8, 12, 16, 24, 32, 64  # steps per bump width, or per period
FINEST = 256
MOST = 2.5e5  # steps of the finest run
DAMPING = 0.02, 0.3
MODES_PER_BLADE = 0, 1, 2, 3, 4
PASSING = "up to 1.5 times as fast as the first family vibrates", "faster"


def periodic(rng: random.Random) -> dict[str, Any]:
    """Keys of a scene that is likely to become periodic soon."""
    return scene(rng) | {
        "material.damping_ratio": rng.uniform(*DAMPING),
        "contact.friction": rng.choice((0.0, 0.15)),
        "time.scheme": "exact_modal",
        "time.step_s": 1e-2,
    }


def configured(keys: dict[str, Any], number: float) -> Config:
    """A scene with so many steps per bump width, or per period where that is shorter.

    Raises InputError.
    """
    steps = {"time.steps_per_bump_width": number, "time.steps_per_period": number}
    return replaced(Config(), keys | steps)


def resolved(n: int, seed: int) -> dict[str, dict[float, np.ndarray]]:
    """Errors for every number of steps of n scenes, {what is shorter: {number: errors}}."""
    rng = random.Random(seed)
    errors: dict[str, dict[float, list[np.ndarray]]] = {
        name: {number: [] for number in NUMBERS} for name in ("bump width", "period")
    }
    left = dict.fromkeys(errors, n // 2)
    while any(left.values()):
        keys = periodic(rng)
        try:
            config = configured(keys, FINEST)
            bump = resolution.bump_time(config)
            name = "bump width" if bump < resolution.blade_period(config) else "period"
            if not left[name] or bump == np.inf or not fits(config):
                continue
            fine = input_of(keys | keys_of(config), MOST)
            if next(plausibility.warnings(fine, build_problem(fine)), ""):
                continue
            true, end = sweep(fine)
            if not np.any(true.amplitude > 0.0):
                continue
            left[name] -= 1
            for number in NUMBERS:
                coarse = replaced(fine, keys_of(configured(keys, number)))
                start = type(end)(*(values.copy() for values in end))
                found, _ = sweep(coarse, start)
                difference = apart(found, true)
                errors[name][number].append(difference[~np.isnan(difference)])
        except InputError:
            continue
    return {
        name: {number: np.concatenate(found) for number, found in rows.items()}
        for name, rows in errors.items()
    }


def keys_of(config: Config) -> dict[str, Any]:
    """Keys of a configuration that say how it is resolved."""
    names = "steps_per_bump_width", "steps_per_period", "step_s"
    return {f"time.{name}": getattr(config.time, name) for name in names}


def fits(config: Config) -> bool:
    """Whether a scene takes no longer than there is time for here."""
    two_windows = 2.2 * config.steady_state.window_revolutions / config.speeds.from_hz
    return max(two_windows, 0.25) < MOST * config.step


def modelled(n: int, seed: int) -> dict[tuple[int, str], np.ndarray]:
    """Errors of n scenes with few modes, {(modes for each blade, how fast bumps pass): errors}."""
    rng = random.Random(seed)
    errors: dict[tuple[int, str], list[np.ndarray]] = {
        (modes, fast): [] for fast in PASSING for modes in MODES_PER_BLADE
    }
    while n:
        keys = periodic(rng)
        n_blades, n_elements = keys["disk.n_blades"], keys["disk.blade.n_elements"]
        most = n_blades * (3 * n_elements + 3)
        try:
            config = configured(keys, 24)
            if not fits(config):
                continue
            keys |= keys_of(config)
            full = input_of(keys | {"reduction.n_modes": most}, MOST)
            problem = build_problem(full)
            if not can_touch(problem.scene):
                continue
            n -= 1
            true, _ = sweep(full)
            family = np.sqrt(problem.reduced.tuned_eigenvalues[n_blades - 1]) / (2.0 * np.pi)
            passing = plausibility.orders(full)[0] * full.speeds.to_hz
            for modes in (m for m in MODES_PER_BLADE if m * n_blades < most):
                found, _ = sweep(input_of(keys | {"reduction.n_modes": modes * n_blades}, MOST))
                difference = apart(found, true)
                place = modes, PASSING[int(passing > plausibility.FAST * family)]
                errors[place].append(difference[~np.isnan(difference)])
        except InputError:
            continue
    return {place: np.concatenate([*found, np.zeros(0)]) for place, found in errors.items()}


def tables(n: int, seed: int) -> str:
    """The errors as tables of the page."""
    heads = ["steps per bump width, or per period", "scenes ruled by", "amplitudes"]
    heads += ["median error", "90 % below", "95 % below"]
    rows = [
        [number, name, *_row(errors)]
        for name, found in resolved(n, seed).items()
        for number, errors in found.items()
    ]
    first = page.table(heads, rows)
    heads = ["modes with the tips held for each blade", "the bumps pass", *heads[2:]]
    rows = [[*place, *_row(errors)] for place, errors in modelled(n // 2, seed).items()]
    return f"{first}\n{page.table(heads, rows)}"


def _row(errors):
    if not errors.size:
        return [0, "-", "-", "-"]
    return [errors.size, *(f"{100 * np.percentile(errors, p):.2g} %" for p in (50, 90, 95))]


def main(argv: list[str] | None = None) -> int:
    """Print both tables."""
    parser = argparse.ArgumentParser(prog="python -m evidence.stress.limits", description=__doc__)
    parser.add_argument("--scenes", type=int, default=80, metavar="N")
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args(argv)
    print(tables(options.scenes, options.seed))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
