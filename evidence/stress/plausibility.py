"""Is what a study calls steady true? Random scenes at their own time step and at a finer one.

Disks, casings (bumps, harmonics, measured points with spikes, jumps and noise), dampings, speeds
and model files of other frequencies are drawn over the allowed input, so wildly that many are
refused or marked. All others are integrated at every speed, at the step that the input gets, and at
one ten times finer. Amplitudes that are steady at both must agree, means of averaged motions
within their stated errors. Where they do not, the finer step goes on from the motion of the longer
one: a motion that stays is one of several that the disk has at that speed, and no error. And a
motion that goes on must keep its amplitude, or its mean.

Two more kinds of scenes are of small disks before casings on which a step may miss something: bumps
as narrow as the input allows beside a harmonic, and measured casings with noise.
"""

import itertools
import math
import multiprocessing
import os
import random
import tempfile
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from evidence import page, progress
from hpcrub import studies
from hpcrub.config.schema import Config
from hpcrub.contact.lanes import WIDTHS
from hpcrub.contact.status import AVERAGED, STEADY
from hpcrub.errors import InputError
from hpcrub.response.sweep import Motion, SweepResult, run_sweep
from hpcrub.results import model_file
from hpcrub.setup import imported, plausibility
from hpcrub.setup.disks import BETWEEN_RUNS, deviation, modes_of
from hpcrub.setup.problem import build_problem

WORKERS = 2
SCENES = {"random": 500, "narrow bumps": 95, "noise": 95}
FAST_SCENES = {"narrow bumps": 4, "noise": 4}
FINER = 10.0
TOLERANCE = 0.1  # of an amplitude that is steady and periodic
STRICT = {  # periodic, and not only much alike from window to window
    "steady_state.min_correlation": 0.9999,
    "steady_state.max_amplitude_change": 1e-3,
    "steady_state.confirmations": 2,
}
N_SPEEDS = 8
BLISKS = 0.06  # of all scenes: their contact costs ten times as much
SCALED = {"K0": 2, "K1": 0, "K2": -2, "K_blade": 2}  # powers of a factor of all times' inverse
# half range [%] of tuned disks, as a study has them: equal to the last bit they would keep for
# long the symmetry of a motion that the smallest difference ends
TUNED = 100.0 * BETWEEN_RUNS
ERRORS = 2.0  # standard errors that 95 % of the means differ by, at most
MANY = 4.0  # standard errors that hardly one should differ by
FIRST_CHECK = 0.5  # [s]
MOST = 3e5  # steps of the longest point: the simulated time is cut


class Pairs(NamedTuple):
    """Amplitudes of one speed each, found twice."""

    difference: np.ndarray = np.zeros(0)  # relative; NaN where one of them has no result
    errors: np.ndarray = np.zeros(0)  # so many standard errors of both; inf where both are steady

    def __getitem__(self, where: Any) -> "Pairs":
        return Pairs(self.difference[where], self.errors[where])

    @property
    def apart(self) -> np.ndarray:
        """Which are not the same by what is said of them."""
        return (self.difference > TOLERANCE) & (self.errors > MANY)


class Outcome(NamedTuple):
    """What became of a scene."""

    keys: dict[str, Any]
    said: str = ""  # why it was refused, or how it is marked
    marked: bool = False
    pairs: Pairs = Pairs()  # at both steps
    other: np.ndarray = np.zeros(0, dtype=bool)  # of these, that the finer step keeps, too
    later: Pairs = Pairs()  # at one step, and gone on

    @property
    def wrong(self) -> np.ndarray:
        """Differences of steady amplitudes that are no other motion, or change when they go on."""
        finer, later = (pairs.apart & np.isinf(pairs.errors) for pairs in (self.pairs, self.later))
        wrong = self.pairs.difference[finer & ~self.other], self.later.difference[later]
        return np.concatenate(wrong)


def log_uniform(rng: random.Random, low: float, high: float) -> float:
    """A number whose logarithm is uniform."""
    return math.exp(rng.uniform(math.log(low), math.log(high)))


def scene(rng: random.Random) -> dict[str, Any]:
    """Keys of a random disk, casing and speed, now and then of the blisk."""
    if rng.random() < BLISKS:
        return blisk(rng)
    log = partial(log_uniform, rng)
    n_blades, n_elements = rng.choice((2, 3, 4, 6)), rng.choice((1, 2, 3))
    most = n_blades * (3 * n_elements + 3)
    height, n_bumps = log(0.02, 5.0), rng.choice((1, 2, 3, 4, 6, 12, 50, 300))
    speed = log(20.0, 500.0) / n_bumps if rng.random() < 0.7 else log(2.0, 10_000.0)
    keys = speeds_from(speed) | {
        "disk.n_blades": n_blades,
        "disk.blade.n_elements": n_elements,
        "disk.blade.thickness_mm": log(5.0, 50.0),
        "disk.blade.lean_deg": rng.uniform(-60.0, 60.0),
        "disk.blade.bow": rng.uniform(-0.1, 0.1),
        "disk.tip_radius_mm": rng.uniform(350.0, 900.0),
        "material.young_modulus_gpa": log(50.0, 400.0),
        "material.damping_ratio": log(3e-4, 0.5),
        "reduction.n_modes": min(most, rng.choice((0, 3 * n_blades, most, most))),
        "casing.clearance_mm": height * rng.choice((0.0, rng.random(), 1.0 - log(1e-6, 0.1))),
        "casing.growth_time_s": log(1e-3, 0.1),
        "contact.friction": rng.choice((0.0, 0.0, 0.15, rng.uniform(0.0, 1.0))),
        "time.step_s": log(1e-5, 1e-2),
        "mistuning.half_range_percent": [rng.choice((TUNED, 4.0))],
        "mistuning.seed": rng.randrange(1000),
        "steady_state.window_revolutions": rng.choice((1, 3, 3, 10)),
    }
    kind = rng.random()
    if kind < 0.45:
        keys["forcing.engine_order"] = rng.choice((1, 2, 3))
    if kind < 0.25:
        keys |= measured(rng, height)
    elif kind < 0.45:
        amplitudes = (height * rng.random(), height * rng.random())
        keys["casing.harmonics"] = [
            {"order": rng.choice((1, 2, 3, 5)), "amplitude_mm": a, "phase_deg": 360 * rng.random()}
            for a in amplitudes
        ]
    else:
        keys |= {"casing.n_bumps": n_bumps, "casing.bump_height_mm": height}
    if rng.random() < 0.2:
        keys |= {"time.scheme": "central_difference", "time.step_s": log(3e-7, 1e-5)}
    return keys


def speeds_from(speed: float) -> dict[str, Any]:
    """Keys of every scene: strict criteria, and speeds from one on [Hz]."""
    step = speed * 0.04 / (N_SPEEDS - 0.5)
    speeds = {"speeds.from_hz": speed, "speeds.to_hz": speed * 1.04, "speeds.step_hz": step}
    return STRICT | speeds


def small(rng: random.Random) -> dict[str, Any]:
    """Keys of a small disk at some speeds, of which many steps are cheap."""
    n_blades = rng.choice((2, 3, 4))
    return speeds_from(log_uniform(rng, 20.0, 150.0)) | {
        "disk.n_blades": n_blades,
        "disk.blade.n_elements": 1,
        "disk.blade.thickness_mm": rng.uniform(8.0, 25.0),
        "disk.blade.lean_deg": rng.uniform(-50.0, 50.0),
        "reduction.n_modes": 3 * n_blades,
        "material.damping_ratio": log_uniform(rng, 0.01, 0.2),
        "contact.friction": rng.choice((0.0, 0.0, 0.15)),
        "forcing.engine_order": 1,
        "mistuning.half_range_percent": [rng.choice((TUNED, 4.0))],
        "mistuning.seed": rng.randrange(1000),
    }


def narrow_bumps(rng: random.Random) -> dict[str, Any]:
    """Keys of bumps that are narrow, beside a harmonic that is lower or much higher than they."""
    height, wave = (log_uniform(rng, 0.02, 1.0) for _ in range(2))
    order, phase = rng.choice((1, 1, 2, 3, 5)), 360.0 * rng.random()
    return small(rng) | {
        "casing.n_bumps": rng.choice((1, 2, 3, 4, 6, 12)),
        "casing.bump_height_mm": height,
        "casing.bump_width": log_uniform(rng, 1.2e-3, 0.03),
        "casing.harmonics": [{"order": order, "amplitude_mm": wave, "phase_deg": phase}],
        "casing.clearance_mm": rng.choice((0.0, rng.random() * wave, rng.random() * height)),
    }


def noisy(rng: random.Random) -> dict[str, Any]:
    """Keys of a measured casing with noise of a standard deviation of 0.5 to 4 % of its shape."""
    n = rng.choice((360, 1000, 2000, 3600))
    height, order = log_uniform(rng, 0.05, 1.0), rng.choice((1, 2, 3, 5))
    noise = np.random.default_rng(rng.randrange(10**6)).standard_normal(n)
    noise *= height * log_uniform(rng, 0.005, 0.04)
    angle = 360.0 * np.arange(n) / n
    change = np.round(-height * np.cos(order * np.radians(angle) + rng.random()) - noise, 6)
    return small(rng) | {
        "casing.profile_deg": np.round(angle, 6).tolist(),
        "casing.profile_mm": change.tolist(),
        "casing.clearance_mm": height * rng.choice((0.0, 0.0, 0.3 * rng.random())),
    }


def measured(rng: random.Random, height: float) -> dict[str, Any]:
    """A measured casing: an oval or a bump, and spikes, a jump or noise on it."""
    n = rng.choice((12, 36, 120, 360))
    angle = 360.0 * np.arange(n) / n
    order, rough = rng.choice((1, 2, 3)), height * log_uniform(rng, 1e-3, 1.0)
    inward = height * np.cos(order * np.radians(angle) + rng.random())
    what, at = rng.choice(("spike", "jump", "noise", "smooth")), rng.randrange(n)
    if what == "spike":
        inward[at] += rough
    elif what == "jump":
        inward[at : at + n // 3] += rough
    elif what == "noise":
        inward += rough * np.random.default_rng(rng.randrange(10**6)).standard_normal(n)
    change = np.round(-inward, 6).tolist()
    return {"casing.profile_deg": np.round(angle, 6).tolist(), "casing.profile_mm": change}


def blisk(rng: random.Random) -> dict[str, Any]:
    """Keys of a scene of the blisk, its frequencies scaled: first family from 60 Hz to 6 kHz."""
    factor = rng.choice((0.1, 0.3, 1.0, 3.0, 10.0))
    path = Path(tempfile.gettempdir()) / f"hpcrub-plausibility-{os.getpid()}-{factor:g}.h5"
    if not path.exists():
        arrays = model_file.read("inputs/blisk/blisk.h5")
        scaled = {k: factor**power * arrays[k] for k, power in SCALED.items()}
        model_file.write(path, arrays | scaled)
    n_bumps, height = rng.choice((2, 3, 4, 24)), math.exp(rng.uniform(-4.0, 0.0))
    speed = factor * rng.uniform(550.0, 700.0) / n_bumps
    return speeds_from(speed) | {
        "casing.growth_time_s": 1e-3,
        "disk.model": str(path),
        "material.damping_ratio": log_uniform(rng, 3e-3, 0.05),
        "casing.n_bumps": n_bumps,
        "casing.bump_height_mm": height,
        "casing.clearance_mm": height * (1.0 - 0.3 * rng.random()),
        "contact.friction": rng.choice((0.0, 0.02, 0.05)),
        "time.step_s": 1e-4,
        "mistuning.half_range_percent": [rng.choice((TUNED, 2.0))],
    }


def sweep(config: Config, motion: Motion | None = None) -> tuple[SweepResult, Motion]:
    """Every speed of the disk of a configuration, from rest or from a motion, and its end."""
    problem = build_problem(config)
    modes = modes_of(config, problem, deviation(config, 0, 0))
    speeds = config.speeds.values_hz
    if motion is None:
        motion = Motion.at_rest(len(speeds), len(modes.omega))
    return run_sweep(modes, problem.scene, speeds, None, WIDTHS[0], motion=motion), motion


def pairs_of(a: SweepResult, b: SweepResult) -> Pairs:
    """Amplitudes of two sweeps side by side."""
    known = [np.isin(r.point_status, (STEADY, AVERAGED)) for r in (a, b)]
    error = np.hypot(*(np.where(r.point_status == STEADY, 0.0, r.error) for r in (a, b)))
    largest = np.maximum(a.amplitude, b.amplitude)
    scale = np.where(largest > 0.0, largest, 1.0)
    apart = np.where(np.logical_and(*known), np.abs(a.amplitude - b.amplitude), np.nan)
    errors = np.divide(apart, error, out=np.full(len(apart), np.inf), where=error > 0.0)
    return Pairs(apart / scale, errors)


def compare(keys: dict[str, Any]) -> Outcome:
    """A scene at its own step and at a finer one."""
    try:
        config = imported.resolved(Config().replace(keys))
        window = config.steady_state.window_revolutions / config.speeds.from_hz
        # as long a simulated time as the step allows here
        time = min(4.0 * max(FIRST_CHECK, 2.0 * window), MOST * config.step)
        times = {"steady_state.first_check_s": time / 4.0, "steady_state.max_time_s": time}
        config = studies.run_of(config.replace(times)).checked().config
        problem = build_problem(config)
        lines = plausibility.warnings(config, problem)  # a finer step leaves the same forces out
        said = next((line for line in lines if not line.startswith("steep casing")), "")
        if said:
            return Outcome(keys, said, marked=True)
        fine = config.replace({"time.step_s": config.step / FINER})
        (found, end), (true, _) = sweep(config), sweep(fine)
    except InputError as error:
        return Outcome(keys, str(error))
    pairs = pairs_of(found, true)
    later = pairs_of(found, sweep(config, Motion(*(values.copy() for values in end)))[0])
    other = np.zeros(len(pairs.difference), dtype=bool)
    if pairs.apart.any():
        stays = pairs_of(found, sweep(fine, end)[0])
        other = ~np.isnan(stays.difference) & ~stays.apart
    both, goes_on = ~np.isnan(pairs.difference), ~np.isnan(later.difference)
    return Outcome(keys, "", False, pairs[both], other[both], later[goes_on])


def is_short(keys: dict[str, Any]) -> bool:
    """Whether a scene needs no more steps than there is time for here, or will be refused."""
    try:
        config = Config().replace(keys)
    except InputError:
        return True
    two_windows = 2.2 * config.steady_state.window_revolutions / config.speeds.from_hz
    return two_windows < MOST * config.step


def scenes(n: int, seed: int, kind: str = "random") -> list[Outcome]:
    """Scenes of a kind, each at its own step and at one ten times finer, some at a time."""
    rng = random.Random(seed)
    draw = {"narrow bumps": narrow_bumps, "noise": noisy}.get(kind, scene)
    short = filter(is_short, (draw(rng) for _ in itertools.count()))
    with multiprocessing.get_context("spawn").Pool(WORKERS) as pool:
        found = pool.imap(compare, list(itertools.islice(short, n)))
        return list(progress.followed(found, f"scenes, {kind}", n))


def table(found: dict[str, list[Outcome]]) -> str:
    """What became of all scenes of every kind, as a table of the page."""
    columns = [numbers(outcomes) for outcomes in found.values()]
    rows = [[row[0][0], *(number for _, number in row)] for row in zip(*columns, strict=True)]
    return page.table(["what", *found], rows)


def numbers(found: list[Outcome]) -> list[tuple[str, Any]]:
    """What became of the scenes of a kind: rows of words and a number."""
    compared = [f for f in found if not f.said]
    pairs, later = (
        Pairs(*map(np.concatenate, zip(*(getattr(f, name) for f in compared), strict=True)))
        for name in ("pairs", "later")
    )
    steady, other = np.isinf(pairs.errors), np.concatenate([f.other for f in compared])
    difference, means = pairs.difference[steady], pairs[~steady]
    return [
        ("scenes", len(found)),
        ("of these with the blisk's model file", sum("disk.model" in f.keys for f in found)),
        ("refused", sum(bool(f.said) and not f.marked for f in found)),
        ("marked as not resolved, or not to become steady", sum(f.marked for f in found)),
        ("compared", len(compared)),
        ("of these with the model file", sum("disk.model" in f.keys for f in compared)),
        ("of these without a result at both steps",
         sum(not f.pairs.difference.size for f in compared)),
        ("amplitudes steady and periodic at both steps", difference.size),
        ("median difference", _percent(difference, 50)),
        ("95 % differ by less than", _percent(difference, 95)),
        (f"steady, and more than {TOLERANCE:.0%} apart: another motion, which the finer step keeps",
         int(np.count_nonzero((pairs.apart & other)[steady]))),
        (f"steady, and more than {TOLERANCE:.0%} apart: wrong",
         int(np.count_nonzero((pairs.apart & ~other)[steady]))),
        ("steady, and as far from itself when it goes on",
         int(later.apart[np.isinf(later.errors)].sum())),
        ("means of averaged motions, at one step or both", means.difference.size),
        ("median difference", _percent(means.difference, 50)),
        (f"within {ERRORS:g} standard errors of both", _share(means.errors <= ERRORS)),
        ("of these that go on at the same step: within as many",
         _share(later.errors[~np.isinf(later.errors)] <= ERRORS)),
        (f"more than {TOLERANCE:.0%} and {MANY:g} standard errors apart, although the finer step "
         "does not keep the other motion", int(np.count_nonzero((pairs.apart & ~other)[~steady]))),
        ("as far from their own mean when they go on at the same step",
         int(later.apart[~np.isinf(later.errors)].sum())),
    ]  # fmt: skip


def _percent(values, part):
    return f"{100 * np.percentile(values, part):.2g} %" if values.size else "none"


def _share(which):
    return f"{100 * np.mean(which):.0f} % of {which.size}" if which.size else "none"
