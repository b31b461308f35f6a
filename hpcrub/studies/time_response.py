"""One simulation in full: displacements, gaps and contact forces of all tips, steady or not."""

import math

import numpy as np

from hpcrub import history
from hpcrub.casing import bump_height, growth
from hpcrub.layout import Dataset
from hpcrub.steady import correlation
from hpcrub.studies.sources import disks, prepare_disks, time_grid
from hpcrub.sweep import cut_revolution

KERNEL = True
_DTB = ("disk", "time", "blade")
_DC = ("disk", "check")
LAYOUT = (
    Dataset("time_s", ("time",), "s", "time since the bumps began to grow"),
    Dataset("deviation", ("disk", "blade"), "1", "stiffness deviations: tuned disk, then pattern"),
    Dataset("radial_m", _DTB, "m", "radial displacement of the tips"),
    Dataset("tangential_m", _DTB, "m", "tangential displacement of the tips"),
    Dataset("gap_m", _DTB, "m", "gap between tips and casing"),
    Dataset("force_n", _DTB, "N", "radial contact force, mean over the time between two records"),
    Dataset("check_s", ("check",), "s", "times of the steady-state test"),
    Dataset("window_s", (), "s", "length of each of its two windows"),
    Dataset("correlation", _DC, "1", "correlation of the two windows at a check"),
    Dataset("amplitude_change", _DC, "1", "relative change of the amplitude at a check"),
    Dataset("tip", _DC, "1", "tip that was looked at", "i8"),
)
SCALES = {"time": "time_s", "check": "check_s"}


prepare = prepare_disks


def sizes(config):
    """Length of every dimension."""
    return {
        "disk": len(disks(config)),
        "time": history.n_records(
            config.speeds.from_hz, config.history.duration_s, time_grid(config)
        ),
        "blade": config.disk.n_blades,
        "check": len(_checks(config)),
    }


def _checks(config):
    """Blocks after which the steady state is tested, as `sweep` does."""
    steady, speed = config.steady_state, config.speeds.from_hz
    per_revolution = cut_revolution(speed, time_grid(config)).blocks_per_revolution
    first = math.ceil(steady.first_check_s * speed * per_revolution)
    first = max(first, 2 * steady.window_revolutions * per_revolution)
    last = math.ceil(config.history.duration_s * speed * per_revolution)
    return range(first, last + 1, steady.extend_revolutions * per_revolution)


def constants(config):
    """The disks and the times of the checks."""
    speed = config.speeds.from_hz
    per_revolution = cut_revolution(speed, time_grid(config)).blocks_per_revolution
    return {
        "deviation": disks(config),
        "check_s": np.array(_checks(config)) / (speed * per_revolution),
        "window_s": config.steady_state.window_revolutions / speed,
    }


def n_tasks(config):
    """One for every disk."""
    return len(disks(config))


def cost(config):
    """Time steps of all lanes, idle ones too."""
    return int(len(history.LANES) * n_tasks(config) * config.history.duration_s / config.time.step)


def compute(problem, task, poll):
    """March one disk and test its steady state."""
    config, scene, modes = problem.config, problem.scene, problem.modes[task]
    speed, duration = config.speeds.from_hz, config.history.duration_s
    pieces = list(history.march(modes, scene, [speed], duration, poll=poll))
    time = np.concatenate([piece.time[:, 0] for piece in pieces])
    position = np.concatenate([piece.position[:, :, 0] for piece in pieces])
    radial, tangential = position @ modes.radial.T, position @ modes.tangential.T
    if task == 0:
        yield "time_s", (), time
    yield "radial_m", task, radial
    yield "tangential_m", task, tangential
    yield "gap_m", task, gap(scene, speed, time, radial, tangential)
    yield "force_n", task, np.concatenate([piece.radial_force[:, :, 0] for piece in pieces])
    yield from _tests(config, tangential, task, len(time) // len(pieces))


def gap(scene, speed_hz, time, radial, tangential):
    """Gap of every tip, (T, n_c) [m]; the paper's, or that of the displaced position."""
    grown = np.array([growth(t, scene.growth_time) for t in time])[:, None]
    angle = 2 * np.pi * speed_hz * time[:, None] + scene.contact_angle
    outward = radial
    if scene.kinematics == "polar":
        angle = angle + np.arctan2(tangential, scene.contact_radius + radial)
        outward = np.hypot(scene.contact_radius + radial, tangential) - scene.contact_radius
    bump = bump_height(angle, scene.n_bumps, scene.bump_height)
    return scene.clearance - grown * bump - outward


def _tests(config, tangential, task, per_block):
    """The steady-state test at every check."""
    grid = cut_revolution(config.speeds.from_hz, time_grid(config))
    window = config.steady_state.window_revolutions * grid.blocks_per_revolution * per_block
    for check, block in enumerate(_checks(config)):
        end = block * per_block
        before, last = (tangential[end - k * window :][:window] for k in (2, 1))
        tip = int(np.abs(last).max(axis=0).argmax())
        size_before, size = (np.abs(part[:, tip]).max() for part in (before, last))
        yield "tip", (task, check), tip
        yield "correlation", (task, check), correlation(before[:, tip], last[:, tip])
        yield "amplitude_change", (task, check), abs(size - size_before) / size if size else 0.0


def first_steady(file, disk):
    """Number of the first check that was passed, None if none was."""
    steady = file.config.steady_state
    passed = file.read("correlation", disk) > steady.min_correlation
    passed &= file.read("amplitude_change", disk) <= steady.max_amplitude_change
    return int(np.argmax(passed)) if passed.any() else None


def report(file):
    """Amplitudes and the time of the steady state."""
    for disk, name in enumerate(("tuned disk", "pattern")[: len(file.read("deviation"))]):
        check = first_steady(file, disk)
        steady = "not steady" if check is None else f"steady at {file.read('check_s')[check]:.3f} s"
        size = 1e3 * np.abs(file.read("tangential_m", disk)).max()
        force = file.read("force_n", disk).max()
        yield f"{name}: {steady}, largest |u_t| {size:.1f} mm, largest mean force {force:.4g} N"
