"""A casing that vibrates: how far it moves, where it meets blades, how often it runs away."""

from collections.abc import Iterator
from typing import Any, ClassVar

import numpy as np

from hpcrub.config.schema import Config
from hpcrub.contact.status import RUNAWAY
from hpcrub.effects import casing_waves
from hpcrub.effects.effect import Change, Effect, History, Load, times
from hpcrub.model.reduction import Modes
from hpcrub.response import casing_motion
from hpcrub.response.casing_motion import CasingMotion
from hpcrub.response.scene import can_touch
from hpcrub.results.layout import Dataset
from hpcrub.results.samples import rows
from hpcrub.results.storage import ResultFile
from hpcrub.results.verdict import REMARK, Finding
from hpcrub.setup.casing import overtaken
from hpcrub.setup.problem import Problem
from hpcrub.statistics.percentiles import finite

PERMANENT = Dataset(
    "tuned/permanent_growth_per_s", ("friction", "speed"), "1/s",
    "fastest growth of the linear disk and casing with all tips in permanent contact, without "
    "friction and with it; below 0: decays",
)  # fmt: skip
N_ANGLES = 120
# angles in the frame of the casing at which its motion is kept [rad]
ANGLES = np.arange(N_ANGLES) * (2.0 * np.pi / N_ANGLES)
OF_TIME = (
    Dataset(
        "casing_radial_m", ("disk", "time", "casing_angle"), "m",
        "outward motion of the casing at an angle of its own",
    ),
    Dataset("casing_angle_deg", ("casing_angle",), "degree", "angle, from tip 0 at the time zero"),
    Dataset("casing_waves", ("disk",), "1", "waves of a casing that runs away; NaN: it does not"),
    Dataset("casing_growth_per_s", ("disk",), "1/s", "rate at which they grow; NaN: they do not"),
)  # fmt: skip


def _half_damped(c: Any) -> dict[Any, Any]:
    if c.casing.ring.thickness_mm is not None:
        return {"casing.ring.damping_ratio": 0.5 * c.casing.ring.damping_ratio}
    modes = [m.model_dump() | {"damping_ratio": 0.5 * m.damping_ratio} for m in c.casing.modes]
    return {"casing.modes": modes} if modes else {}


def _wider_ring(c: Any) -> dict[Any, Any]:
    ring = c.casing.ring
    if ring.thickness_mm is None:
        return {}
    at_tips = c.disk.tip_radius_mm + ring.thickness_mm / 2.0
    return {"casing.ring.radius_mm": 1.01 * (ring.radius_mm or at_tips)}


class VibratingCasing(Effect):
    """A casing that vibrates."""

    name = "waves"
    needed = "a casing that vibrates (casing.ring)"
    omitted = (
        "The casing does not vibrate (casing.ring). One that does decides amplitudes as much as "
        "the disk, both ways."
    )
    datasets: ClassVar = {
        "contact": (PERMANENT,),
        "modal": casing_waves.LAYOUT,
        "time_response": OF_TIME,
    }
    points = tuple(CasingMotion.declared().values())
    changes = (
        Change("half the casing's damping", "damping_ratio of casing.ring, casing.modes",
               _half_damped),
        Change("ring 10 % thicker", "casing.ring.thickness_mm", times(
            {"casing.ring.thickness_mm": 1.1})),
        Change("ring 1 % wider in radius", "casing.ring.radius_mm", _wider_ring),
    )  # fmt: skip

    def exists(self, config: Config) -> bool:
        """Whether the casing has a ring or modes."""
        return config.casing.vibrates

    def warnings(self, config: Config, problem: Problem) -> Iterator[str]:
        """Warn of rings that no casing is, and of waves that the rotor overtakes."""
        if config.casing.ring.thickness_mm is not None:
            yield from _ring_warnings(config)
        if can_touch(problem.scene):
            yield from _wave_warnings(config, problem)

    def sizes(self, config: Config) -> dict[str, int]:
        """Numbers of waves, families of blades, speeds and angles."""
        return casing_waves.sizes(config) | {"casing_angle": N_ANGLES}

    def of_tuned(
        self, config: Config, modes: Modes, runs: list[dict[str, Any]]
    ) -> dict[str, np.ndarray]:
        """Growth in permanent contact."""
        growths = casing_waves.permanent_growth(config, modes, config.speeds.values_hz)
        return {"permanent_growth_per_s": growths[0]}

    def of_history(self, study: str, history: History) -> Iterator[tuple[str, Any]]:
        """Motion of the casing at angles of its own."""
        if study == "time_response":
            pairs, turned = history.modes.pairs, 2.0 * np.pi * history.speed_hz * history.time
            still = casing_motion.at_rest(pairs, history.casing, turned)
            yield "casing_radial_m", casing_motion.radial(pairs, still, ANGLES)

    def of_model(self, study: str, config: Config, loads: list[Load]) -> Iterator[tuple[str, Any]]:
        """Waves, and where they meet blades, for the modal study."""
        if study == "modal":
            yield from casing_waves.values(config, loads[0].model.reduced)

    def lines(self, file: ResultFile, disk: int) -> Iterator[str]:
        """How far the casing moves."""
        if file.config.study == "modal":
            yield from casing_waves.report(file)
        elif file.config.study == "time_response":
            moved = np.abs(file.read("casing_radial_m", disk)).max()
            yield f"casing moves by {1e3 * moved:.3g} mm"
        elif file.config.study == "contact":
            yield from _around_tuned(file)
            yield from _around_mistuned(file)

    def findings(self, file: ResultFile) -> Iterator[Finding]:
        """Remark that a casing which vibrates must be known as well as the disk."""
        if file.config.study != "contact":
            return
        is_ring = file.config.casing.ring.thickness_mm is not None
        what = "damping, thickness and radius" if is_ring else "damping and frequencies"
        yield Finding(
            REMARK,
            "a casing that vibrates",
            f"{what} of the casing can move peaks by tens of per cent: study: checklist shows by "
            f"how much (casing.{'ring' if is_ring else 'modes'})",
        )


def _wave_warnings(config: Config, problem: Any) -> Iterator[str]:
    """Warn of waves around an elastic casing that the rotor overtakes."""
    casing = problem.reduced.casing
    critical = casing.critical_speeds / (2.0 * np.pi)
    followed, others = overtaken(config, casing)
    if len(followed):
        yield (
            f"overtaken waves: from {critical.min():.4g} Hz on the rotor is faster than waves "
            f"around the casing (n = {_listed(followed)}); contact feeds them, so "
            "that motions may grow until tips leave the casing, or without bound"
        )
    if len(others):
        yield (
            f"overtaken waves: up to {config.speeds.to_hz:g} Hz the rotor is faster, too, than the "
            f"waves n = {_listed(others)}, which are not followed (casing.ring.waves) and which "
            "contact would feed as well"
        )


def _listed(waves: Any) -> str:
    """Numbers of waves in words, a row without gaps by its ends."""
    is_row = len(waves) > 2 and np.ptp(waves) == len(waves) - 1
    return f"{min(waves)} to {max(waves)}" if is_row else ", ".join(map(str, waves))


def _ring_warnings(config: Config) -> Iterator[str]:
    """Warn of dimensions and materials that no casing has and that wrong units give."""
    ring, tips = config.casing.ring, config.disk.tip_radius_mm
    for key, low, high in (
        ("thickness_mm", 1e-3 * tips, 0.2 * tips),
        ("width_mm", 1e-2 * tips, 2.0 * tips),
        ("radius_mm", 0.9 * tips, 1.3 * tips),
        ("young_modulus_gpa", 1.0, 1000.0),
        ("density_kg_m3", 500.0, 20000.0),
    ):
        value = getattr(ring, key)
        if value is not None and not low <= value <= high:
            yield (
                f"units: casing.ring.{key} is {value:g}, where casings around tips of {tips:g} mm "
                f"have {low:.3g} to {high:,.5g}"
            )


def _around_tuned(file: ResultFile) -> Iterator[str]:
    """Motion of the casing around the tuned disk, and the speeds at which it runs away."""
    read, speeds = file.read, file.config.speeds.values_hz
    moved, waves = map(read, ("tuned/casing_motion_m", "tuned/casing_waves"))
    if np.isfinite(moved).any():
        at = int(np.nanargmax(moved))
        yield (
            f"casing around the tuned disk: moves by {1e3 * moved[at]:.3g} mm at {speeds[at]:g} "
            f"Hz, most with n = {waves[at]:.0f}"
        )
    away = read("tuned/point_reason") == RUNAWAY
    if away.any():
        growth, at = read("tuned/casing_growth_per_s"), int(np.flatnonzero(away)[0])
        yield (
            f"casing around the tuned disk: runs away at {np.count_nonzero(away)} of {len(speeds)} "
            f"speeds, from {speeds[at]:g} Hz with n = {waves[at]:.0f} and {growth[at]:.3g} 1/s"
        )


def _around_mistuned(file: ResultFile) -> Iterator[str]:
    """Largest motions of the casing around mistuned disks."""
    motion = np.concatenate([rows(file, level, "casing_motion_m") for level in file.config.levels])
    most = finite(np.where(np.isfinite(motion), motion, -np.inf).max(axis=-1, initial=-np.inf))
    if not most.size:
        return
    low, middle, high = 1e3 * np.percentile(most, [1, 50, 99])
    if file.config.pattern_deviation is not None:
        yield f"casing around the mistuned disk: moves by {middle:.3g} mm at most"
        return
    yield (
        f"casing around mistuned disks: moves by {low:.3g}/{middle:.3g}/{high:.3g} mm "
        "(percentiles 1/50/99 of the largest of any speed)"
    )
