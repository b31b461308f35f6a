"""Checks that time step, model and times of a study resolve its motions.

The limits come from the errors that docs/stress.md measures. A study that cannot have a result is
refused; a doubtful one continues, with warnings in its result file and under its figures.
"""

from collections.abc import Iterator
from typing import Any

import numpy as np

from hpcrub.config import resolution
from hpcrub.config.run_up import runs_up
from hpcrub.config.schema import Config
from hpcrub.config.text import lines_of
from hpcrub.model import families
from hpcrub.model.casing import noise_left
from hpcrub.model.reduction import Modes, mistuned_modes
from hpcrub.model.tuned_basis import own_modes
from hpcrub.response.ensemble import SETTLED
from hpcrub.response.linear import linear_peak
from hpcrub.response.scene import Scene, can_touch
from hpcrub.response.sliding import critical_friction, growth_rate
from hpcrub.setup import imported
from hpcrub.setup.disks import deviation
from hpcrub.setup.problem import Problem

STEPS_PER_BUMP_WIDTH = 12.0
STEPS_PER_PERIOD = 16.0
MODES_PER_BLADE = 2  # fixed-interface modes of a planar disk; one more beyond FAST
STEPS_PER_REBOUND = 36.0  # time steps while a blade springs back from an elastic casing or coating
WHOLE = "time_response", "interaction_map"  # studies of whole histories, history.duration_s long
FASTEST_TIP = 800.0  # [m/s]; fans run at 300 to 550
WIDEST_CLEARANCE = 0.02  # of the tips' radius; fans have 0.001 to 0.005
STEEP = 0.03  # slope of the casing; friction that differs by it moves a tuned peak by 3 to 12 %
NOISE = 0.1  # share of the casing's height that blades meet, which smoothing may take away
NOISY = 0.2  # share of the slope of a smoothed casing that may be noise
TRANSIENT = 0.05  # share of a transient that may be left at the first check of last_window
# error of a linear resonance by the shapes of another speed that need not be told; where it is
# 1.5 % on rotor 67, amplitudes in contact are 3 and 4 % off
ACCURATE = 0.01
COMPARED = 3  # mistuned disks whose resonances are compared for that
FAST = 1.5  # passing frequency of the bumps over the highest frequency of the first family


def steady_problems(config: Config) -> Iterator[str]:
    """Reasons why no point of a study could pass a test of its steady state."""
    steady, speeds = config.steady_state, config.speeds
    longest = steady.window_revolutions / speeds.from_hz  # window [s]
    windows = steady.window_revolutions / speeds.values_hz
    # the bump ramp must end before the last window begins, at the speed where it begins first
    begins = (np.maximum(steady.first_check, 2.0 * windows) - windows).min()
    has_no_test = 2.0 * longest > steady.max_time
    return lines_of(
        (has_no_test,
         f"steady_state.max_time_s: {steady.max_time_s:g} s are over before the first test, which "
         f"compares twice {steady.window_revolutions} revolutions at {speeds.from_hz:g} Hz; at "
         f"least {2.0 * longest:.4g} s are needed"),
        (steady.rule == "last_window" and steady.extend_revolutions < steady.window_revolutions,
         f"steady_state.extend_revolutions: {steady.extend_revolutions} are less than the "
         f"{steady.window_revolutions} of steady_state.window_revolutions, so that the windows of "
         "two checks would overlap"),
        (not has_no_test and config.casing.growth_time > begins,
         f"casing.growth_time_s: the bumps still grow at {begins:.4g} s, when the first test of "
         "the steady state begins; a shorter one, or steady_state.first_check_s of at least "
         f"{config.casing.growth_time + longest:.4g}, is needed"),
    )  # fmt: skip


def warnings(config: Config, problem: Problem) -> Iterator[str]:
    """Warnings about unresolved numbers, for the result file and its figures.

    Those of the effects come beside them (`effects`).
    """
    yield from _unit_warnings(config)
    yield from _model_warnings(config)
    yield from _shape_warnings(config, problem)
    yield from _noise_warnings(config)
    if not can_touch(problem.scene):
        return
    yield from _slope_warnings(config)
    yield from _step_warnings(config, problem)
    yield from _mode_warnings(config, problem)
    tuned = mistuned_modes(problem.reduced, np.zeros(config.disk.n_blades))
    if not runs_up(config):
        yield from _time_warnings(config, tuned)
    yield from _friction_warnings(problem.scene, tuned)
    yield from _rebound_warnings(config, problem)


def _are_few(steps: Any, wanted: Any) -> Any:
    return steps < wanted * (1.0 - 1e-9)


def _slope_warnings(config: Config) -> Iterator[str]:
    """Warn of a casing whose slope tilts contact forces, radial ones at small displacements."""
    slope = config.casing.outline.slope / config.disk.tip_radius
    if slope > STEEP and not config.contact.bends:
        yield (
            f"steep casing: its slope of up to {slope:.2g} would add as much of a contact force to "
            f"the friction of {config.contact.friction:g} on a way up, and take it on a way down; "
            "forces are radial here: compare with contact.friction higher and lower by that, "
            "or take contact.kinematics: second_order"
        )


def _step_warnings(config: Config, problem: Problem) -> Iterator[str]:
    """Warn of too few time steps for bumps, also where the casing is only grazed."""
    in_bump = resolution.bump_time(config) / config.step  # infinite without contact
    in_graze = resolution.bump_time(config, least=0.0) / config.step
    family = problem.reduced.tuned_eigenvalues[: config.disk.n_blades]
    in_period = 2.0 * np.pi / np.sqrt(family[-1]) / config.step
    in_growth = config.casing.growth_time / config.step
    in_bump_are_few = _are_few(in_bump, STEPS_PER_BUMP_WIDTH)
    return lines_of(
        (in_bump_are_few,
         f"not resolved: {in_bump:.3g} time steps per bump width, fewer than "
         f"{STEPS_PER_BUMP_WIDTH:g} (time.steps_per_bump_width)"),
        (_are_few(in_graze, STEPS_PER_BUMP_WIDTH) and not in_bump_are_few,
         f"not resolved: the casing is grazed, {in_graze:.3g} time steps for what reaches beyond "
         f"the clearance, fewer than {STEPS_PER_BUMP_WIDTH:g}; where blades hardly vibrate, a "
         "shorter step is needed (time.steps_per_bump_width)"),
        (_are_few(in_growth, STEPS_PER_BUMP_WIDTH),
         f"not resolved: the casing grows within {in_growth:.2g} time steps, fewer than "
         f"{STEPS_PER_BUMP_WIDTH:g}, and throws blades away, the faster the shorter the step is: "
         f"casing.growth_time_s above {STEPS_PER_BUMP_WIDTH * config.step:.2g}, 0.01 is usual"),
        (_are_few(in_period, STEPS_PER_PERIOD),
         f"not resolved: {in_period:.3g} time steps per period of the first family, fewer than "
         f"{STEPS_PER_PERIOD:g} (time.steps_per_period, time.step_s)"),
    )  # fmt: skip


def shape_errors(config: Config, problem: Problem, speeds_hz: np.ndarray) -> np.ndarray:
    """Errors of linear resonances by the shapes of one speed, relative, (disks, S) [-].

    The disk is looked at with the stiffness of each speed (S,) [Hz], once with the shapes of that
    speed and once with those with which the study integrates; frequencies belong to it both times.
    The disks are the tuned one and the first samples of the last level. NaN: a disk flutters.
    """
    scene, n, basis = problem.scene, config.disk.n_blades, problem.basis
    reduced = problem.reduced._replace(air=None) if basis else problem.reduced
    load = scene.damping_ratio, 1.0, config.forcing.sense * (config.engine_order or 1)
    own = [
        deviation(config, len(config.levels) - 1, k) for k in range(len(config.samples))[:COMPARED]
    ]

    def size(modes: Modes) -> Any:
        return linear_peak(modes.fixed, *load, scene.interface, n)[0]

    found = []
    for blades in (np.zeros(n), *own):
        near = basis.modes_of(blades) if basis else mistuned_modes(reduced, blades)
        used = [own_modes(near.at(hz)) if basis else near.at(hz) for hz in speeds_hz]
        exact = [mistuned_modes(reduced, blades, 2.0 * np.pi * hz) for hz in speeds_hz]
        pairs = [(size(a), size(b)) for a, b in zip(used, exact, strict=True)]
        found.append([a / b - 1.0 if np.isfinite(a + b) else np.nan for a, b in pairs])
    return np.array(found)


def _shape_warnings(config: Config, problem: Problem) -> Iterator[str]:
    """Warn of shapes of the middle of the speeds where those of the ends differ too much."""
    if not problem.reduced.stiffening:
        return
    ends = config.speeds.values_hz[[0, -1]]
    errors = np.nan_to_num(np.abs(shape_errors(config, problem, ends))).max(axis=0)
    if errors.max() > ACCURATE:
        middle, (low, high) = problem.reduced.speed / (2.0 * np.pi), 100.0 * errors
        yield (
            f"not resolved: mode shapes are those of {middle:.4g} Hz at all speeds; for that "
            f"linear resonances of the tuned disk and the first samples are off by up to {low:.2g} "
            f"% at {ends[0]:g} Hz and {high:.2g} % at {ends[1]:g} Hz, and amplitudes in contact by "
            "about three times as much: compare with speeds.from_hz and to_hz around the peak"
        )


def _unit_warnings(config: Config) -> Iterator[str]:
    """Warn of numbers that no rotor has and that wrong units give."""
    speed = 2.0 * np.pi * config.speeds.to_hz * config.disk.tip_radius
    share = config.clearance / config.disk.tip_radius
    return lines_of(
        (speed > FASTEST_TIP,
         f"units: at {config.speeds.to_hz:g} Hz the blade tips run at {speed:,.0f} m/s, faster "
         f"than any fan ({FASTEST_TIP:g} m/s); speeds are turns per second (rpm/60), "
         "disk.tip_radius_mm is in mm"),
        (share > WIDEST_CLEARANCE,
         f"units: the clearance is {100 * share:.3g} % of the tips' radius, more than any fan has "
         f"({100 * WIDEST_CLEARANCE:g} %); casing.clearance_mm is in mm"),
    )  # fmt: skip


def _model_warnings(config: Config) -> Iterator[str]:
    """Warn of speeds beyond those of a model file's matrices."""
    known, asked = imported.known_speeds(config), config.speeds.values_hz[[0, -1]]
    if len(known) and (asked[0] < known.min() or asked[1] > known.max()):
        yield (
            f"not resolved: speeds of {asked[0]:g} to {asked[1]:g} Hz, but matrices of "
            f"{known.min():g} to {known.max():g} Hz in {config.disk.model}: beyond these the "
            "stiffness by rotation is extrapolated; import matrices of higher speeds"
        )


def _noise_warnings(config: Config) -> Iterator[str]:
    """Warn of a measured casing whose noise, or smoothing, decides the results."""
    casing, outline = config.casing, config.casing.outline
    away = outline.smoothed_away
    nearest = config.clearance + config.disk.least_clearance
    met = max(0.0, outline.highest - max(nearest, outline.mean))
    is_raw = casing.profile.measured and casing.smoothing == 0.0
    left = noise_left(casing.profile)
    is_taken = away > NOISE * met and outline.highest + away > nearest
    return lines_of(
        (is_raw,
         "noise: the measured points of the casing are not smoothed, and noise of the measurement "
         "counts as its shape; leave out casing.smoothing_mm and compare"),
        (not is_raw and not is_taken and left > NOISY,
         f"noise: smoothing over {1e3 * casing.smoothing:.3g} mm leaves noise from point to point "
         f"whose slope is {left:.2g} of the measured casing's, and it counts as its shape: more "
         "points, or a longer casing.smoothing_mm, and compare"),
        (not is_raw and is_taken,
         f"noise: smoothing over {1e3 * casing.smoothing:.3g} mm takes up to {1e3 * away:.2g} mm "
         f"from the measured casing, of which blades meet {1e3 * met:.2g} mm; the results depend "
         "on that: compare with half of casing.smoothing_mm"),
    )  # fmt: skip


def _time_warnings(config: Config, tuned: Modes) -> Iterator[str]:
    """Warn of windows shorter than a period, and of times too short for transients to decay."""
    steady = config.steady_state
    decay = float((tuned.damping_ratios(config.damping) * tuned.rows.omega).min())  # slowest
    constant = 1.0 / decay if decay > 0.0 else np.inf  # of casing or air without damping [s]
    within = f"decay within {SETTLED * constant:.2g} s" if decay > 0.0 else "never decay"
    needed = int(np.ceil(config.speeds.to_hz * 2.0 * np.pi / tuned.omega[0]))
    left = float(np.exp(-steady.first_check / constant))
    key, longest = "steady_state.max_time_s", steady.max_time
    if config.study in WHOLE:
        key, longest = "history.duration_s", config.history.duration_s
    return lines_of(
        (needed > steady.window_revolutions,
         f"not resolved: {steady.window_revolutions} revolutions at {config.speeds.to_hz:g} Hz are "
         "less than a period of the slowest mode; steady_state.window_revolutions of "
         f"{needed} are needed"),
        (steady.rule == "ensemble" and SETTLED * constant > longest,
         f"not steady: transients {within}, {key} is {longest:g}; motions that do not repeat stay "
         "marked as not steady"),
        (steady.rule == "last_window" and left > TRANSIENT,
         f"not resolved: transients decay with a time constant of {constant:.2g} s, of which "
         f"steady_state.first_check_s of {steady.first_check_s:g} leaves up to {100 * left:.2g} %: "
         "what the rule last_window calls steady may still grow or decay; the rule ensemble waits "
         "for it"),
    )  # fmt: skip


def _friction_warnings(scene: Scene, tuned: Modes) -> Iterator[str]:
    critical = critical_friction(tuned, scene.elastic_casing)
    if scene.friction > critical:
        rate = growth_rate(tuned, scene.damping_ratio, scene.friction)
        yield (
            f"flutter: with a friction above {critical:.2g} a blade that slides along the casing "
            f"locks itself; at contact.friction of {scene.friction:g} its displacement grows by "
            f"{rate:.3g} 1/s. Less friction, or a casing that reaches less beyond the clearance, "
            "may keep contacts short"
            + (", and a coating is cut until they are" if scene.coating else "")
        )


def rebound_time(problem: Problem, stiffness: np.ndarray) -> float:
    """Time in which a blade that hits the casing, moving in its first family, springs back [s].

    stiffness: of casing or coating at the contact points of one blade (points of the blade,) [N/m].

    It is half a period of the blade's modes on these springs: of the mean of the squared periods,
    each weighted by the share of the springs' energy that the hit gives to its mode.
    """
    face, n = problem.scene.interface, problem.scene.interface.n_blades
    modes = mistuned_modes(problem.reduced, np.zeros(n))
    tips = modes.normal[face.blade == face.blade[0]]
    squared, shapes = np.linalg.eigh(np.diag(modes.omega**2) + tips.T @ (stiffness[:, None] * tips))
    hit = shapes[:n].T @ tips[:, :n].sum(axis=0)
    stored = hit**2 * (stiffness[:, None] * (tips @ shapes) ** 2).sum(axis=0)
    return float(np.pi * np.sqrt((stored / squared).sum() / stored.sum()))


def _rebound_warnings(config: Config, problem: Problem) -> Iterator[str]:
    scene = problem.scene
    if not (scene.coating or scene.elastic_casing):
        return
    share = scene.interface.share[scene.interface.blade == scene.interface.blade[0]]
    spring = np.full(len(share), scene.elastic_casing.stiffness if scene.elastic_casing else 0.0)
    if scene.coating:
        spring = np.maximum(spring, scene.coating.stiffnesses(scene.coating.area * share)[0])
    time = rebound_time(problem, spring)
    if _are_few(time / config.step, STEPS_PER_REBOUND):
        yield (
            f"not resolved: a blade springs back from the casing within {1e6 * time:.3g} µs, in "
            f"{time / config.step:.2g} time steps, fewer than {STEPS_PER_REBOUND:g}; amplitudes "
            "and depths may be wrong: compare with time.step_s of "
            f"{time / (2.0 * STEPS_PER_REBOUND):.2g}"
        )


def _mode_warnings(config: Config, problem: Problem) -> Iterator[str]:
    frequencies = np.sqrt(problem.reduced.tuned_eigenvalues) / (2.0 * np.pi)
    top, family = float(frequencies[-1]), float(frequencies[config.disk.n_blades - 1])
    passing = config.casing.main_order * config.speeds.to_hz
    n, per_blade = config.disk.n_blades, MODES_PER_BLADE + (passing > FAST * family)
    wanted = min(per_blade * n, config.disk.n_dof - 2 * n)
    return lines_of(
        (config.disk.model is None and families.whole(config.reduction.n_modes, n) < wanted,
         f"not resolved: reduction.n_modes is {config.reduction.n_modes}, fewer than {per_blade} "
         f"for each blade, {wanted}"),
        (top < passing,
         f"not resolved: the bumps pass at {passing:.4g} Hz, above all modes of the model (up to "
         f"{top:.4g} Hz; reduction.n_modes)"),
    )  # fmt: skip
