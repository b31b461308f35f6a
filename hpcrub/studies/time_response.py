"""One simulation in full: displacements, gaps and contact forces of all tips, steady or not."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from hpcrub import effects
from hpcrub.config.schema import Config
from hpcrub.contact import status
from hpcrub.contact.status import AVERAGED, DIVERGED, POINT_REASON, POINT_STATUS, STEADY
from hpcrub.effects import casing_motion as casing_effect
from hpcrub.effects.effect import History
from hpcrub.response import casing_motion, history
from hpcrub.response.revolution import cut_revolution
from hpcrub.response.scene import Scene
from hpcrub.response.steady import correlation
from hpcrub.results.layout import Dataset
from hpcrub.results.storage import ResultFile
from hpcrub.results.verdict import Finding
from hpcrub.runs import findings
from hpcrub.runs.study import Poll, Values
from hpcrub.setup.disks import fixed_disks
from hpcrub.setup.problem import scene_of
from hpcrub.statistics.percentiles import Z_95
from hpcrub.studies.contact.trials import bent_table
from hpcrub.studies.interaction_map import DISKS
from hpcrub.studies.shared.motions import Motions

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
    Dataset("tip", _DC, "1", "tip that was looked at; means nothing where diverged", "i8"),
    Dataset("point_status", ("disk",), "1", POINT_STATUS, "u1"),
    Dataset("point_reason", ("disk",), "1", POINT_REASON, "u1"),
    Dataset("judged_s", ("disk",), "s", "check that point_status, amplitude are of"),
    Dataset("amplitude_m", ("disk",), "m", "amplitude, as in a contact study"),
    Dataset("amplitude_error_m", ("disk",), "m", "standard error; NaN: unknown"),
    *bent_table("disk"),
)


def gap(scene: Scene, speed_hz: float, time: np.ndarray, radial: np.ndarray) -> np.ndarray:
    """Gap of every tip, (T, n_c) [m], to a casing that does not move."""
    clearance = scene.at(speed_hz).clearance + scene.interface.clearance
    angle = 2 * np.pi * speed_hz * time[:, None] + scene.interface.angle
    return scene.casing.gap(clearance, time[:, None], scene.ramp_time, angle, radial)


def _motion(pieces: Any, followed: Any) -> tuple[Any, Any, Any]:
    """Times, forces, positions and casing of all pieces, worn depths, and the last Piece."""
    parts, worn_depth, piece = [], [], None
    for piece in pieces:
        followed.take(piece, 0)
        worn_depth += [depth.max() for depth in piece.worn]
        values = piece.time, piece.normal_force, piece.position, piece.casing
        parts.append([of_lanes[..., 0].copy() for of_lanes in values])  # other lanes are empty
    return map(np.concatenate, zip(*parts, strict=True)), worn_depth, piece


def _tests(followed: Any, task: Any, tangential: Any) -> Iterator[Any]:
    """Tip, correlation and change of amplitude in the steady-state test at every check."""
    tips = np.zeros(len(followed.checks), dtype=int)
    correlated, change = np.zeros((2, len(tips)))
    per_block = len(tangential) // followed.n_blocks
    window = followed.window * per_block
    for check, block in enumerate(followed.checks):
        end = block * per_block
        before, last = (tangential[end - k * window :][:window] for k in (2, 1))
        tip = tips[check] = np.abs(last).max(axis=0).argmax()
        size_before, size = (np.abs(part[:, tip]).max() for part in (before, last))
        correlated[check] = correlation(before[:, tip], last[:, tip])
        change[check] = abs(size - size_before) / size if size else 0.0
    yield "tip", task, tips
    yield "correlation", task, correlated
    yield "amplitude_change", task, change


def first_known(file: ResultFile, disk: int) -> int | None:
    """Number of the check at which the amplitude of a disk of a result file was known, or None."""
    if file.read("point_status", disk) not in (STEADY, AVERAGED):
        return None
    return int(np.abs(file.read("check_s") - file.read("judged_s", disk)).argmin())


class TimeResponse(Motions):
    """One simulation in full."""

    name = "time_response"
    what = "one simulation in full"
    sections = ("history",)
    scales = {"time": "time_s", "check": "check_s", "block": "block_s"}

    def layout(self, config: Config) -> tuple[Dataset, ...]:
        """Datasets; where blades have several contact points, every point has its own motion."""
        more = self.of_effects(config)
        if config.disk.n_points == config.disk.n_blades:
            return LAYOUT + more
        of_points = ("disk", "time", "point")
        return (
            *(s._replace(dimensions=of_points) if s.dimensions == _DTB else s for s in LAYOUT),
            *more,
            Dataset("contact_blade", ("point",), "1", "blade of a contact point", "i8"),
            Dataset("contact_angle_rad", ("point",), "rad", "its angle at the time zero"),
        )

    def sizes(self, config: Config) -> dict[str, int]:
        """Lengths of this study's own dimensions."""
        span, scene = (config.speeds.from_hz, config.history.duration_s), scene_of(config)
        return {
            "disk": len(fixed_disks(config)),
            "time": history.n_records(*span, scene),
            "point": config.disk.n_points,
            "check": len(history.checks(*span, scene)),
            "block": history.n_blocks(*span, cut_revolution(span[0], scene)),
        }

    def constants(self, config: Config) -> dict[str, Any]:
        """The disks and the times of the checks."""
        speed, duration, grid = config.speeds.from_hz, config.history.duration_s, scene_of(config)
        turn = cut_revolution(speed, grid)
        per_second = speed * turn.blocks_per_revolution
        n_blocks = history.n_blocks(speed, duration, turn)
        return {
            "deviation": fixed_disks(config),
            "check_s": np.array(history.checks(speed, duration, grid)) / per_second,
            "window_s": config.steady_state.window_revolutions / speed,
            "block_s": np.arange(1, n_blocks + 1) / per_second,
            "casing_angle_deg": np.degrees(casing_effect.ANGLES),
        }

    def problems(self, config: Config) -> Iterator[str]:
        """Keys that do not fit this study."""
        if config.speeds.n_values != 1:
            first, last = config.speeds.from_hz, config.speeds.to_hz
            yield (
                f"speeds.to_hz: {last} is not speeds.from_hz, {first}; a time_response is of one "
                "speed"
            )

    def compute(self, config: Config, prepared: Any, task: int, poll: Poll) -> Iterator[Values]:
        """Integrate one disk in time and test its steady state, or tell why it diverged."""
        scene, modes = prepared.problem.scene, prepared.modes[task]
        speed, duration = config.speeds.from_hz, config.history.duration_s
        followed = history.Follower(modes, scene, speed, duration)
        pieces = history.integrate(modes, scene, np.array([speed]), duration, poll=poll)
        (time, force, position, casing), worn_depth, end = _motion(pieces, followed)
        tangential, radial = position @ modes.tangential.T, position @ modes.normal.T
        window = round(config.steady_state.window_revolutions / speed / (time[1] - time[0]))
        touching = scene.interface.of_points(force[-window:] > 0.0)
        reason = followed.doubt(end.reason[0], touching.mean(axis=0))
        if task == 0:  # all disks share times and contact points
            yield "time_s", (), time
            if config.disk.n_points != config.disk.n_blades:
                yield "contact_blade", (), scene.interface.blade
                yield "contact_angle_rad", (), scene.interface.angle
        yield "point_reason", task, reason
        yield "point_status", task, DIVERGED
        if len(modes.pairs.omega):
            yield "casing_waves", task, end.growth[0, 0]
            yield "casing_growth_per_s", task, end.growth[0, 1]
        if status.are_fatal(end.reason[0]):
            return
        wall = casing_motion.radial(modes.pairs, casing, scene.interface.angle)
        yield "radial_m", task, radial
        yield "tangential_m", task, tangential
        yield "gap_m", task, gap(scene, speed, time, radial) + wall
        yield "force_n", task, force
        whole = time, position, casing, np.array(worn_depth)
        motion = History(modes, scene, speed, lambda: followed.wear, *whole)
        for effect in effects.of(config):
            for name, values in effect.of_history(self.name, motion):
                yield name, task, values
        yield from _tests(followed, task, tangential[followed.seen])
        if not status.are_fatal(reason):
            yield "judged_s", task, followed.time
            yield "point_status", task, followed.verdict.status
            yield "amplitude_m", task, followed.verdict.amplitude
            yield "amplitude_error_m", task, followed.verdict.error

    def report(self, file: ResultFile) -> Iterator[str]:
        """Amplitudes and the times from which they are known, or reasons why there are none."""
        states, reason = file.read("point_status"), file.read("point_reason")
        for disk, name in enumerate(DISKS[: len(states)]):
            if states[disk] == DIVERGED:
                why = status.words(reason[disk])
                if reason[disk] in status.OF_CASING:
                    why += f", n = {file.read('casing_waves', disk):.0f} with "
                    why += f"{file.read('casing_growth_per_s', disk):.3g} 1/s"
                yield f"{name}: {why}"
                continue
            check, known = first_known(file, disk), "not steady"
            if check is not None:
                word = "averaged" if states[disk] == AVERAGED else "steady"
                known = f"{word} at {file.read('check_s')[check]:.3f} s"
                known += f" with {1e3 * file.read('amplitude_m', disk):.1f} mm"
            if states[disk] == AVERAGED:
                error = Z_95 * file.read("amplitude_error_m", disk)
                known += f" ± {1e3 * error:.1f} (mean of windows, 95 % interval)"
            size = 1e3 * np.abs(file.read("tangential_m", disk)).max()
            force = file.read("force_n", disk).max()
            care = f"; {status.words(reason[disk])}" if reason[disk] else ""
            yield (
                f"{name}: {known}, largest |u_t| {size:.1f} mm, "
                f"largest mean force {force:.4g} N{care}"
            )
            yield from (f"{name}: {line}" for line in effects.lines(file, disk))

    def findings(self, file: ResultFile) -> Iterator[Finding]:
        """Reasons to distrust the motions of the disks."""
        moved = np.abs(np.nan_to_num(file.read("tangential_m"))).max(axis=(1, 2))
        states, reasons = file.read("point_status"), file.read("point_reason")
        of_disks = moved[:, None], states[:, None], reasons[:, None]
        yield from findings.of_points(file.config, *of_disks, self.time_key)
        yield from self.kinematics(file, moved)


STUDY = TimeResponse()
