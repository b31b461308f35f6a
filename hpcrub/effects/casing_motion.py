"""A casing that vibrates: how far it moves, where it meets blades, how often it runs away.

The linear analysis: its waves, and permanent contact of all tips.
"""

from collections.abc import Iterator
from typing import Any, ClassVar

import numpy as np

from hpcrub.config.schema import Config
from hpcrub.contact.status import RUNAWAY
from hpcrub.effects.effect import Change, Effect, History, Load, times
from hpcrub.model import crossings
from hpcrub.model.casing_modes import CasingModes
from hpcrub.model.crossings import MEETINGS, N_FAMILIES
from hpcrub.model.imported import cyclic
from hpcrub.model.reduction import Modes, ReducedModel, mistuned_modes
from hpcrub.response import casing_motion
from hpcrub.response.casing_motion import CasingMotion
from hpcrub.response.casing_stability import growth
from hpcrub.response.scene import can_touch
from hpcrub.results.layout import Dataset
from hpcrub.results.samples import rows
from hpcrub.results.storage import ResultFile
from hpcrub.results.verdict import REMARK, Finding
from hpcrub.setup.casing import casing_modes_of, overtaken
from hpcrub.setup.problem import Problem
from hpcrub.statistics.percentiles import finite

REACH = 10.0  # times the highest speed of the input: interactions are stored up to there
SHOWN = 1.5  # times the highest speed of the input: report and figures go up to there
N_SPEEDS = 90  # speeds at which the growth in permanent contact is computed
OF_MODAL = (
    Dataset("casing/waves", ("casing_mode",), "1", "waves n around the casing", "i8"),
    Dataset("casing/frequencies_hz", ("casing_mode",), "Hz", "its natural frequency f_c"),
    Dataset("casing/critical_speed_hz", ("casing_mode",), "Hz", "speed f_c/n of its travel"),
    Dataset(
        "casing/interaction_hz", ("casing_mode", "family", "sum_or_difference"), "Hz",
        "speeds at which n times the speed is f_c + f_b, or |f_c - f_b|, f_b of a family of blades "
        "with the nodal diameters that n waves fold to; nan: never, or far above",
    ),
    Dataset("casing/blades_hz", ("casing_mode", "family"), "Hz", "this f_b, at the highest speed"),
    Dataset("casing/speed_hz", ("stability",), "Hz", "speeds at which permanent contact is judged"),
    Dataset(
        "casing/growth_per_s", ("friction", "stability"), "1/s",
        "fastest growth in permanent contact of all tips; without friction, then with it",
    ),
    Dataset("casing/growing_waves", ("friction", "stability"), "1", "its n that moves most", "i8"),
    Dataset("casing/growing_hz", ("friction", "stability"), "Hz", "its frequency, from the rotor"),
)  # fmt: skip
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
        "modal": OF_MODAL,
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
        return wave_sizes(config) | {"casing_angle": N_ANGLES}

    def of_tuned(
        self, config: Config, modes: Modes, runs: list[dict[str, Any]]
    ) -> dict[str, np.ndarray]:
        """Growth in permanent contact."""
        growths = permanent_growth(config, modes, config.speeds.values_hz)
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
            yield from wave_values(config, loads[0].model.reduced)

    def lines(self, file: ResultFile, disk: int) -> Iterator[str]:
        """How far the casing moves."""
        if file.config.study == "modal":
            yield from wave_report(file)
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


def permanent_growth(config: Config, modes: Modes, speeds_hz: np.ndarray) -> np.ndarray:
    """Growth of the linear disk and casing, which vibrates, in permanent contact at speeds (S,).

    modes: Modes of the tuned disk. Returns rates [1/s], waves that move most, and frequencies seen
    from the rotor [Hz], (3, 2, S): each without friction, then with it.
    """
    found = [
        [growth(modes.at(speed), config.damping, friction, speed) for speed in speeds_hz]
        for friction in (0.0, config.contact.friction)
    ]
    return np.moveaxis(np.array(found), -1, 0)


def wave_sizes(config: Config) -> dict[str, int]:
    """Lengths of the dimensions of these datasets."""
    casing = config.casing
    n_pairs = len(casing.modes) if casing.ring.thickness_mm is None else len(casing.ring.waves)
    kinds = {"family": N_FAMILIES, "sum_or_difference": len(MEETINGS), "friction": 2}
    return kinds | {"casing_mode": n_pairs, "stability": N_SPEEDS}


def interactions(config: Config, reduced: ReducedModel, casing: CasingModes) -> np.ndarray:
    """Speeds at which waves of the casing meet blades, as of `crossings.interactions` [Hz]."""
    highest = 2.0 * np.pi * REACH * config.speeds.to_hz
    speeds = crossings.interactions(reduced, cyclic.tuned_diameters(reduced), casing, highest)
    return speeds / (2.0 * np.pi)


def wave_values(config: Config, reduced: ReducedModel) -> Iterator[tuple[str, Any]]:
    """Yield (name, values) of waves, interaction speeds and growth rates."""
    casing = casing_modes_of(config)
    assert casing is not None  # it vibrates
    yield "casing/waves", casing.n_waves
    yield "casing/frequencies_hz", casing.omega / (2.0 * np.pi)
    yield "casing/critical_speed_hz", casing.critical_speeds / (2.0 * np.pi)
    yield "casing/interaction_hz", interactions(config, reduced, casing)
    yield "casing/blades_hz", _blades(reduced, casing, config.speeds.to_hz)
    speeds = np.linspace(0.0, SHOWN * config.speeds.to_hz, N_SPEEDS + 1)[1:]
    modes = mistuned_modes(reduced._replace(casing=casing), np.zeros(config.disk.n_blades))
    rates, waves, frequencies = permanent_growth(config, modes, speeds)
    yield "casing/speed_hz", speeds
    yield "casing/growth_per_s", rates
    yield "casing/growing_waves", waves
    yield "casing/growing_hz", frequencies


def _blades(reduced: ReducedModel, casing: Any, speed_hz: Any) -> Any:
    """Frequencies of blades that waves of the casing can meet (casing modes, families) [Hz]."""
    diameters, speed = cyclic.tuned_diameters(reduced), 2.0 * np.pi * speed_hz

    def frequency(n: Any, family: Any) -> Any:
        folded = crossings.folded(int(n), reduced.interface.n_blades)
        blades = crossings.family_frequency(reduced, diameters, folded, family)
        return blades(speed) / (2.0 * np.pi) if blades else np.nan

    return np.array([[frequency(n, f) for f in range(N_FAMILIES)] for n in casing.n_waves])


def wave_lines(config: Config, casing: CasingModes, found: np.ndarray) -> Iterator[str]:
    """Lines about the waves of the casing: where they meet blades, which the rotor overtakes.

    found: speeds as `interactions` returns them [Hz].
    """
    critical, highest = casing.critical_speeds / (2.0 * np.pi), config.speeds.to_hz
    for j, n in enumerate(casing.n_waves):
        text = f"casing, n = {n}: {casing.omega[j] / (2.0 * np.pi):.4g} Hz"
        if n:
            text += f", travels at {critical[j]:.4g} Hz"
        meets = [
            f"family {family + 1} at {found[j, family, k]:.4g} Hz ({kind})"
            for family in range(N_FAMILIES)
            for k, kind in enumerate(MEETINGS)
            if found[j, family, k] <= SHOWN * highest
        ]
        yield text + (f", meets {', '.join(meets)}" if meets else "")
    followed, _ = overtaken(config, casing)
    if len(followed):
        yield (
            f"casing: from {critical.min():.4g} Hz on the rotor overtakes waves of the casing (n = "
            f"{', '.join(map(str, followed))}); contact feeds these, and motions may grow"
        )
    else:
        yield f"casing: no wave is overtaken up to {critical.min():.4g} Hz"


def wave_report(file: ResultFile) -> Iterator[str]:
    """Lines about the waves, and about the speed from which permanent contact is unstable."""
    config, read, casing = file.config, file.read, casing_modes_of(file.config)
    assert casing is not None  # it vibrates
    yield from wave_lines(config, casing, read("casing/interaction_hz"))
    speeds, rates = read("casing/speed_hz"), read("casing/growth_per_s")
    waves, friction = read("casing/growing_waves"), config.contact.friction
    moves = read("casing/growing_hz")
    for row, words in enumerate(("without friction", f"with a friction of {friction:g}")):
        grows = np.flatnonzero(rates[row] > 0.0)
        if len(grows):
            first, most = grows[0], grows[np.argmax(rates[row, grows])]
            since = f"from {speeds[first]:.3g} Hz on" if first else "at all speeds"
            yield (
                f"permanent contact of all tips, {words}: grows {since}, first by "
                f"{rates[row, first]:.3g} 1/s in a motion of {moves[row, first]:.3g} Hz seen from "
                f"the rotor; up to {speeds[-1]:.3g} Hz at most by {rates[row, most]:.3g} 1/s, at "
                f"{speeds[most]:.3g} Hz with n = {waves[row, most]}, in a motion of "
                f"{moves[row, most]:.3g} Hz"
            )
        else:
            yield f"permanent contact of all tips, {words}: decays up to {speeds[-1]:.3g} Hz"
