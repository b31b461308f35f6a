"""Coexisting stable motions: the same speeds integrated from several initial states.

A motion that passes the steady-state test is often not periodic, and its amplitude differs from
window to window; some motions jump to another one after a second or two. So every motion goes on
for N_WINDOWS windows after the test, and `coexistence` tells by these windows which motions differ.

- rest: the disk is at rest, as in every other study
- up, down: every speed starts from the final motion of the next lower, or higher, speed
- perturbed: the blades have a random deflection; there are several of these states
"""

from collections.abc import Iterator
from typing import Any

import numpy as np

from hpcrub.config.schema import Config
from hpcrub.config.text import counted
from hpcrub.contact import status
from hpcrub.contact.lanes import WIDTHS
from hpcrub.contact.status import DIVERGED, POINT_REASON, POINT_STATUS, STEADY
from hpcrub.model import mistuning
from hpcrub.model.reduction import Modes
from hpcrub.response import history, steady
from hpcrub.response.scene import Scene
from hpcrub.response.sweep import Motion, SweepResult, run_sweep
from hpcrub.results.layout import SPEEDS, Dataset
from hpcrub.results.storage import ResultFile
from hpcrub.runs.cost import Cost
from hpcrub.runs.study import Poll, Values
from hpcrub.setup.disks import fixed_disks
from hpcrub.statistics import coexistence
from hpcrub.studies.contact.trials import bent_table
from hpcrub.studies.shared.motions import Motions

_SS = ("start", "speed")
LAYOUT = (
    SPEEDS,
    Dataset("deviation", ("blade",), "1", "stiffness deviations of the disk"),
    Dataset("amplitude_m", _SS, "m", "largest tangential displacement of any tip"),
    Dataset("localisation", _SS, "1", "localisation factor of the blade-tip amplitudes"),
    Dataset("window_amplitude_m", (*_SS, "window"), "m", "amplitudes of the windows that follow"),
    Dataset("window_localisation", (*_SS, "window"), "1", "localisation factors of these windows"),
    Dataset("time_s", _SS, "s", "simulated time until steady or given up"),
    Dataset("point_status", _SS, "1", POINT_STATUS, "u1"),
    Dataset("point_reason", _SS, "1", POINT_REASON, "u1"),
    *bent_table("start"),
)
LISTED = 6  # branches that the report describes, those with the most points
N_WINDOWS = 60  # 5 s at 36 Hz; many motions jump to another one within the first second


def starts(config: Config) -> list[str]:
    """Names of the initial states."""
    return ["rest", "up", "down", *(f"perturbed {i + 1}" for i in range(config.branches.perturbed))]


def follow(
    modes: Modes, scene: Scene, speeds_hz: np.ndarray, motion: Motion, downwards: bool, poll: Poll
) -> SweepResult:
    """Integrate every speed from the final motion of the speed before it; modifies `motion`."""
    order = range(len(speeds_hz))[:: -1 if downwards else 1]
    whole = SweepResult.empty(len(speeds_hz), scene.n_strips)
    for before, i in zip((None, *order), order, strict=False):
        if before is not None and whole.point_status[before] != DIVERGED:
            for values in motion:
                values[i] = values[before]
        whole.take(i, run_sweep(modes, scene, speeds_hz, poll, selection=[i], motion=motion))
    return whole


def windows(modes: Modes, scene: Scene, speeds_hz: np.ndarray, motion: Motion, poll: Poll) -> Any:
    """Amplitude [m] and localisation of the N_WINDOWS windows that follow, (S, N_WINDOWS) each.

    motion: Motion of all speeds to start from. Also returns the codes of ``status`` (S,); the code
    of a speed that has diverged before means nothing.
    """
    results = np.full((2, len(speeds_hz), N_WINDOWS), np.nan)
    reason = np.zeros(len(speeds_hz), dtype=np.uint8)
    for group in history.groups(speeds_hz):
        part = Motion(*(values[group] for values in motion))
        duration = scene.steady.window_revolutions / speeds_hz[group].max()
        for window in range(N_WINDOWS):
            largest = np.zeros(1)
            for piece in history.integrate(modes, scene, speeds_hz[group], duration, part, poll):
                largest = np.maximum(largest, np.abs(piece.observed).max(axis=0).T)
            largest = scene.interface.of_blades(largest)  # (speeds of the group, N)
            well = ~status.are_fatal(piece.reason)
            at, largest = group[well], largest[well]
            results[:, at, window] = largest.max(axis=1), steady.localisation(largest)
            reason[group] = np.where(status.are_fatal(reason[group]), reason[group], piece.reason)
    return *results, reason


def deflection(modes: Modes, n_family: int, seed: int, task: int, size: float) -> np.ndarray:
    """Random modal coordinates (K,) in the first family, scaled to largest |u| = size [m]."""
    random = mistuning.uniform(seed, mistuning.START, 0, task, n_family)
    first = np.sort(np.argsort(modes.omega, kind="stable")[:n_family])
    position = np.zeros(len(modes.omega))
    position[first] = random * (size / np.abs(modes.observed[:, first] @ random).max())
    return position


def label_file(file: ResultFile) -> np.ndarray:
    """Branches of all points of a result file, as `coexistence.label` returns them."""
    names = "window_amplitude_m", "window_localisation", "point_status"
    return coexistence.label(*map(file.read, names))


class Branches(Motions):
    """Coexisting stable motions."""

    name = "branches"
    what = "coexisting stable motions, from several initial states"
    sections = ("branches",)
    datasets = LAYOUT
    at_rest, disks = slice(1), slice(-1, None)

    def sizes(self, config: Config) -> dict[str, int]:
        """Lengths of this study's own dimensions."""
        return {"start": len(starts(config)), "window": N_WINDOWS}

    def constants(self, config: Config) -> dict[str, Any]:
        """Stiffness deviations of the disk."""
        return {"deviation": fixed_disks(config)[-1]}

    def prepare(self, config: Config) -> Any:
        """Problem and modes, with few lanes for continuations, which take a speed at a time."""
        prepared = super().prepare(config)
        scene = prepared.problem.scene
        scene = scene._replace(lanes=tuple(sorted({WIDTHS[0], *scene.lanes})))
        return prepared._replace(problem=prepared.problem._replace(scene=scene))

    def n_tasks(self, config: Config) -> int:
        """One task for every initial state."""
        return len(starts(config))

    def cost(self, config: Config) -> Cost:
        """Cost of all starts; a step of a continuation, alone in four lanes, costs up to eight."""
        n, revolutions = self.n_tasks(config), N_WINDOWS * config.steady_state.window_revolutions
        return Cost(2 * 8 + n - 2, n * revolutions / config.speeds.from_hz, 1)

    def compute(self, config: Config, prepared: Any, task: int, poll: Poll) -> Iterator[Values]:
        """Integrate all speeds from one initial state."""
        scene, modes = prepared.problem.scene, prepared.modes[-1]
        name, speeds = starts(config)[task], config.speeds.values_hz
        motion = Motion.at_rest(len(speeds), modes.n_rows)
        if name in ("up", "down"):
            result = follow(modes, scene, speeds, motion, name == "down", poll)
        else:
            if name != "rest":
                size = config.branches.perturbation
                n_blades, seed = scene.interface.n_blades, config.mistuning.seed
                motion.position[:] = modes.at_rest(deflection(modes, n_blades, seed, task, size))
            result = run_sweep(modes, scene, speeds, poll, motion=motion)
        amplitude, local, reason = windows(modes, scene, speeds, motion, poll)
        result = result.continued(reason)
        amplitude[result.point_status == DIVERGED] = np.nan
        local[result.point_status == DIVERGED] = np.nan
        yield "window_amplitude_m", task, amplitude
        yield "window_localisation", task, local
        yield "amplitude_m", task, result.amplitude
        yield "time_s", task, result.time
        for name in ("localisation", "point_status", "point_reason"):
            yield name, task, getattr(result, name)

    def report(self, file: ResultFile) -> Iterator[str]:
        """Points without a result, speeds at which branches coexist, and the largest branches."""
        labels = label_file(file)
        several = coexistence.coexisting(labels) > 1
        speeds, local = file.read("speeds_hz"), file.read("window_localisation").mean(axis=-1)
        reason = file.read("point_reason")
        yield from status.lines(status.count(reason), reason.size)
        share = np.mean(file.read("point_status") == STEADY)
        n_branches = labels.max() + 1
        branches = "1 branch" if n_branches == 1 else f"{n_branches} branches"
        yield f"{100 * share:.0f} % of the points are steady, {branches}"
        if several.any():
            yield (
                f"several stable motions at {several.sum()} of {len(speeds)} speeds, between "
                f"{speeds[several].min():.6g} and {speeds[several].max():.6g} Hz"
            )
        for branch in range(min(LISTED, n_branches)):
            mine = labels == branch
            at = speeds[mine.any(axis=0)]
            yield (
                f"branch {branch + 1}: {at.min():.6g} to {at.max():.6g} Hz, mean localisation "
                f"{100 * local[mine].mean():.1f} %, {mine.sum()} points"
            )
        if n_branches > LISTED:
            left, first = int((labels >= LISTED).sum()), LISTED + 1
            names = f"branches {first} to" if n_branches > first else "branch"
            yield f"{names} {n_branches}: {counted(left, 'point')} in all"


STUDY = Branches()
