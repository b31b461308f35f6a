"""One simulation in full: displacements, gaps and contact forces of all tips, steady or not."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from hpcrub.config.schema import Config
from hpcrub.contact import status
from hpcrub.contact.status import AVERAGED, DIVERGED, STEADY
from hpcrub.response import casing_motion, history
from hpcrub.response.revolution import cut_revolution
from hpcrub.response.scene import Scene
from hpcrub.response.steady import correlation
from hpcrub.results.layout import POINT_REASON, POINT_STATUS, Dataset
from hpcrub.results.storage import ResultFile
from hpcrub.runs import verdict
from hpcrub.runs.study import Poll, StudyInTime, Values
from hpcrub.runs.verdict import Finding
from hpcrub.setup.disks import disks
from hpcrub.setup.problem import time_grid
from hpcrub.statistics.percentiles import Z_95
from hpcrub.studies.interaction_map import DISKS
from hpcrub.studies.shared import worn

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
)
_STRESS = Dataset(
    "stress_pa", ("disk", "time", "stress"), "Pa", "stress at each place; both faces of a root"
)
_CASING = (
    Dataset(
        "casing_radial_m", ("disk", "time", "casing_angle"), "m",
        "outward motion of the casing at an angle of its own",
    ),
    Dataset("casing_angle_deg", ("casing_angle",), "degree", "angle, from tip 0 at the time zero"),
    Dataset("casing_waves", ("disk",), "1", "waves of a casing that runs away; NaN: it does not"),
    Dataset("casing_growth_per_s", ("disk",), "1/s", "rate at which they grow; NaN: they do not"),
)  # fmt: skip
N_ANGLES = 120
# angles in the frame of the casing at which its motion is kept [rad]
CASING_ANGLES = np.arange(N_ANGLES) * (2.0 * np.pi / N_ANGLES)
_COATING = (
    Dataset("block_s", ("block",), "s", "ends of the parts of a turn after which depths are kept"),
    Dataset("worn_depth_m", ("disk", "block"), "m", "largest worn depth of the coating until then"),
)


def _times(config):
    """Times of the checks, and those at which the blocks of the history end [s]."""
    span, grid = (config.speeds.from_hz, config.history.duration_s), time_grid(config)
    turn = cut_revolution(span[0], grid)
    blocks = np.array(history.checks(*span, grid)), np.arange(1, history.n_blocks(*span, turn) + 1)
    return [number / (span[0] * turn.blocks_per_revolution) for number in blocks]


def _judged(followed, task):
    """Status and amplitude of a disk, and the time of the check that they come from."""
    yield "judged_s", task, followed.time
    yield "point_status", task, followed.found.status
    yield "amplitude_m", task, followed.found.amplitude
    yield "amplitude_error_m", task, followed.found.error


def gap(scene: Scene, speed_hz: float, time: np.ndarray, radial: np.ndarray) -> np.ndarray:
    """Gap of every tip, (T, n_c) [m], to a casing that does not move."""
    clearance = scene.at(speed_hz).clearance + scene.interface.clearance
    angle = 2 * np.pi * speed_hz * time[:, None] + scene.interface.angle
    return scene.casing.gap(clearance, time[:, None], scene.ramp_time, angle, radial)


def _motion(pieces, followed):
    """Times, forces, positions and casing of all pieces, worn depths, and the last Piece."""
    parts, worn_depth, piece = [], [], None
    for piece in pieces:
        followed.take(piece, 0)
        worn_depth += [depth.max() for depth in piece.worn]
        values = piece.time, piece.normal_force, piece.position, piece.casing
        parts.append([of_lanes[..., 0].copy() for of_lanes in values])  # other lanes are empty
    return map(np.concatenate, zip(*parts, strict=True)), worn_depth, piece


def _tests(followed, task, tangential):
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


class TimeResponse(StudyInTime):
    """One simulation in full."""

    name = "time_response"
    what = "one simulation in full"
    figures = "5"
    sections = ("history",)
    scales = {"time": "time_s", "check": "check_s", "block": "block_s"}

    def layout(self, config: Config) -> tuple[Dataset, ...]:
        """Datasets; where blades have several contact points, every point has its own motion."""
        more = (*_COATING, *worn.layout(config, ("disk",))) if config.contact.wears else ()
        more += (_STRESS,) if config.observes_stress else ()
        more += _CASING if config.casing.vibrates else ()
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
        speed, duration = config.speeds.from_hz, config.history.duration_s
        checks, block_ends = _times(config)
        return {
            "disk": len(disks(config)),
            "time": history.n_records(speed, duration, time_grid(config)),
            "point": config.disk.n_points,
            "stress": config.disk.n_stresses or 2 * config.disk.n_blades,
            "casing_angle": N_ANGLES,
            "check": len(checks),
            "block": len(block_ends),
        }

    def constants(self, config: Config) -> dict[str, Any]:
        """The disks and the times of the checks."""
        checks, block_ends = _times(config)
        return {
            "deviation": disks(config),
            "check_s": checks,
            "window_s": config.steady_state.window_revolutions / config.speeds.from_hz,
            "block_s": block_ends,
            "casing_angle_deg": np.degrees(CASING_ANGLES),
        }

    def problems(self, config: Config) -> Iterator[str]:
        """Keys that do not fit this study."""
        if config.speeds.n_values != 1:
            first, last = config.speeds.from_hz, config.speeds.to_hz
            yield (
                f"speeds.to_hz: {last} is not speeds.from_hz, {first}; a time_response is of one "
                "speed"
            )

    def compute(self, config: Config, problem: Any, task: int, poll: Poll) -> Iterator[Values]:
        """Integrate one disk in time and test its steady state, or tell why it diverged."""
        scene, modes = problem.problem.scene, problem.modes[task]
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
        if config.casing.vibrates:
            yield "casing_waves", task, end.growth[0, 0]
            yield "casing_growth_per_s", task, end.growth[0, 1]
        if status.are_fatal(end.reason[0]):
            return
        wall = casing_motion.radial(modes.pairs, casing, scene.interface.angle)
        yield "radial_m", task, radial
        yield "tangential_m", task, tangential
        yield "gap_m", task, gap(scene, speed, time, radial) + wall
        yield "force_n", task, force
        if scene.observes_stress:
            yield "stress_pa", task, position @ modes.stress.T
        if config.casing.vibrates:
            still = casing_motion.at_rest(modes.pairs, casing, 2.0 * np.pi * speed * time)
            yield "casing_radial_m", task, casing_motion.radial(modes.pairs, still, CASING_ANGLES)
        if scene.coating:
            yield "worn_depth_m", task, np.array(worn_depth)
            yield from worn.of_speed(followed.wear, task)
        yield from _tests(followed, task, tangential[followed.seen])
        if not status.are_fatal(reason):
            yield from _judged(followed, task)

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
            if "casing_radial_m" in file:
                moved = np.abs(file.read("casing_radial_m", disk)).max()
                known += f", casing moves by {1e3 * moved:.3g} mm"
            if "stress_pa" in file:
                stress = np.abs(file.read("stress_pa", disk)).max()
                known += f", largest stress {1e-6 * stress:,.0f} MPa"
            care = f"; {status.words(reason[disk])}" if reason[disk] else ""
            yield (
                f"{name}: {known}, largest |u_t| {size:.1f} mm, "
                f"largest mean force {force:.4g} N{care}"
            )
            yield from (f"{name}: {line}" for line in worn.report(file, disk))

    def findings(self, file: ResultFile) -> Iterator[Finding]:
        """Reasons to distrust the motions of the disks."""
        moved = np.abs(np.nan_to_num(file.read("tangential_m"))).max(axis=(1, 2))
        states, reasons = file.read("point_status"), file.read("point_reason")
        of_disks = moved[:, None], states[:, None], reasons[:, None]
        yield from verdict.of_points(file.config, *of_disks, self.time_key)
        yield from verdict.kinematics(file.config, moved)


STUDY = TimeResponse()
