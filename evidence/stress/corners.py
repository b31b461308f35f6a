"""The corners of the parameter space, as cases drawn with a fixed seed.

A case is one disk and a few neighbouring speeds. Every corner varies its own parameters far beyond
reason and leaves the others near the reference study, with a scatter.
"""

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from evidence.truth.disk import reference_scene
from hpcrub.config.schema import Config
from hpcrub.model.disk import build_disk
from hpcrub.model.reduction import craig_bampton, mistuned_modes
from hpcrub.response.steady import SteadyCriteria

SEED = 4
SPEEDS_PER_CASE = 8
STEPS = 8000  # of the shortest run
REVOLUTION = 100_000  # steps, at most


class Case(NamedTuple):
    """Input of one sweep, small enough to be sent to another process."""

    corner: str
    number: int
    disk: dict = {}  # noqa: RUF012, keys of the input file
    n_modes: int = 12
    half_range: float = 0.03
    scene: dict = {}  # noqa: RUF012, fields that are changed
    casing: dict = {}  # noqa: RUF012, those of its shape
    speed: float = 34.5  # [Hz], the middle one
    step: float = 2e-5  # [s]


@lru_cache(maxsize=16)
def _reduced(disk, n_modes):
    config = Config().replace(dict(disk) | {"reduction.n_modes": 0})
    full = build_disk(config.disk, config.material)
    inside = len(full.mass) - 2 * config.disk.n_blades
    return craig_bampton(full, inside if n_modes < 0 else min(n_modes, inside))


def build(case):
    """Modes, Scene and speeds (S,) [Hz] of a case."""
    reduced = _reduced(tuple(case.disk.items()), case.n_modes)
    rng = np.random.default_rng([SEED, case.number, 1])
    n = reduced.interface.n_blades
    modes = mistuned_modes(reduced, case.half_range * rng.uniform(-1.0, 1.0, n))
    duration = STEPS * case.step
    fields = {
        "interface": reduced.interface,
        "scheme": "exact_modal",
        "step": case.step,
        "steady": SteadyCriteria(first_check=duration, max_time=3.0 * duration),
    }
    speeds = case.speed * np.linspace(0.97, 1.03, SPEEDS_PER_CASE)
    found = reference_scene(**(fields | case.scene))
    return modes, found._replace(casing=found.casing._replace(**case.casing)), speeds


def _step(rng):
    h = 10.0 ** rng.uniform(-8.0, -2.0)
    scheme = rng.choice(["central_difference", "exact_modal"])
    speed = max(1.0 / (REVOLUTION * h), rng.uniform(30.0, 38.0))
    return {"step": h, "speed": speed, "scene": {"scheme": str(scheme), "ramp_time": 1e-3}}


def _blades(rng):
    n = int(rng.choice([2, 3, 5, 13, 24, 25, 37, 48, 96]))
    bumps = int(rng.integers(1, n + 1))
    return {
        "disk": {"disk.n_blades": n, "disk.blade.n_elements": 1},
        "scene": {"friction": rng.uniform(0.0, 0.5)},
        "casing": {"n_bumps": bumps},
        "speed": 138.0 / bumps,
        "step": max(2e-5, bumps / 138.0 / 4000.0),
    }


def _bumps(rng):
    bumps = int(rng.integers(1, 61))
    fields = {"n_bumps": bumps, "bump_height": rng.uniform(0.5e-3, 3e-3)}
    return {"casing": fields, "speed": 138.0 / bumps, "step": max(2e-5, bumps / 138.0 / 8000.0)}


def _speed(rng):
    speed = 10.0 ** rng.uniform(-1.0, 3.0)
    return {"speed": speed, "step": float(np.clip(1.0 / (4000.0 * speed), 1e-6, 2e-3))}


def _tiny_and_huge(rng):
    size = float(rng.choice([5e-324, 1e-310, 1e-200, 1e-30, 1e10, 1e150, 1e300]))
    return {
        "casing": {"bump_height": size},
        "scene": {"clearance": float(rng.choice([0.0, 0.2])) * size},
        "disk": {"material.young_modulus_gpa": float(rng.choice([1e-6, 210.0, 1e5]))},
    }


CORNERS = {  # what is drawn, and how many
    "time step 1e-8 to 1e-2 s": (_step, 80),
    "modes 0 to all": (lambda rng: {
        "disk": {"disk.blade.n_elements": int(rng.integers(1, 4))},
        "n_modes": int(rng.choice([-1, 0, 1, 2, 5, 30])),
    }, 60),
    "friction 0 to 1.5, lean -75 to 75 deg": (lambda rng: {
        "disk": {"disk.blade.lean_deg": rng.uniform(-75.0, 75.0),
                 "disk.blade.bow": rng.uniform(-0.1, 0.1)},
        "scene": {"friction": rng.uniform(0.0, 1.5)},
        "step": 10.0 ** rng.uniform(-5.0, -3.5),
    }, 160),
    # steps so long that every blade feels every other: sweeps converge slowly or not at all
    "strong coupling, long steps": (lambda rng: {
        "disk": {"disk.ring_thickness_mm": rng.uniform(0.5, 3.0)},
        "scene": {"friction": rng.uniform(0.0, 1.5)},
        "casing": {"bump_height": 5e-3},
        "step": 10.0 ** rng.uniform(-4.0, -2.5),
        "n_modes": int(rng.choice([0, 12])),
    }, 80),
    "bump height 0.2 to 20 mm": (lambda rng: {
        "casing": {"bump_height": 10.0 ** rng.uniform(np.log10(2e-4), np.log10(2e-2))},
    }, 80),
    "no clearance": (lambda rng: {
        "casing": {"bump_height": float(rng.choice([0.0, 1e-6, 1e-3, 5e-3]))},
        "scene": {"clearance": 0.0, "ramp_time": float(rng.choice([0.0, 1e-2, 10.0]))},
    }, 60),
    "2 to 96 blades": (_blades, 36),
    "1 to 60 bumps": (_bumps, 80),
    "damping 0 to 0.99": (lambda rng: {
        "scene": {"damping_ratio": float(rng.choice([0.0, 1e-6, 0.5, 0.99]))},
    }, 48),
    "speed 0.1 to 1000 Hz": (_speed, 80),
    "mistuning 20 %": (lambda rng: {"half_range": 0.2, "n_modes": int(rng.choice([12, 60]))}, 48),
    "nearly double frequencies": (lambda rng: {"half_range": 10.0 ** rng.uniform(-16.0, -6.0)}, 48),
    "identical blades": (lambda rng: {
        "half_range": 0.0, "casing": {"bump_height": rng.uniform(0.3e-3, 3e-3)},
    }, 48),
    "spokes without stiffness": (lambda rng: {
        "disk": {"disk.spoke_thickness_mm": 10.0 ** rng.uniform(-6.0, 0.0)},
    }, 48),
    "denormal and huge numbers": (_tiny_and_huge, 80),
}  # fmt: skip


def cases(share=1.0):
    """All cases, or the first ``share`` of every corner."""
    number = 0
    for corner, (draw, n) in CORNERS.items():
        for i in range(n):
            number += 1
            if i < share * n:
                yield Case(corner, number, **draw(np.random.default_rng([SEED, number, 0])))
