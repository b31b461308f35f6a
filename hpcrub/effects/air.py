"""Air between the blades: damping of waves, and the disks that flutter."""

from collections.abc import Iterator
from typing import Any, ClassVar

import numpy as np

from hpcrub.config.schema import Config
from hpcrub.effects.effect import Change, Effect, Load
from hpcrub.model.aero import largest_amplification
from hpcrub.model.reduction import Modes, ReducedModel, mistuned_modes
from hpcrub.results.layout import Dataset, Values
from hpcrub.results.storage import ResultFile
from hpcrub.results.verdict import MOST_LOST, SINGLE, USELESS, Finding
from hpcrub.setup.aero import curve_of
from hpcrub.setup.disks import deviation
from hpcrub.setup.problem import Problem
from hpcrub.statistics.percentiles import Z_95, finite, probability_interval

LOOKED_AT = 100  # mistuned disks, of all levels, that are checked for flutter before a run
FAMILY_ALONE = 0.2  # deviation of stiffness up to which mistuning hardly couples families
MOST_SHOWN = 200  # disks of a level whose complex modes are kept
_WAVE, _SHOWN = ("wave",), ("level", "disk", "wave")
TUNED = (
    Dataset("aero/diameters", _WAVE, "1", "nodal diameters, below 0: against the rotation", "i8"),
    Dataset("aero/given_damping_ratio", _WAVE, "1", "damping ratio of every wave, as given"),
    Dataset("aero/tuned_damping_ratio", _WAVE, "1", "damping ratio of the tuned disk's wave"),
    Dataset("aero/tuned_decay_per_s", _WAVE, "1/s", "rate at which it decays; below 0: grows"),
    Dataset("aero/tuned_frequency_hz", _WAVE, "Hz", "frequency of the tuned disk's wave"),
)
LIMITS = (
    Dataset(
        "aero/largest_amplification", ("n_diameters",), "1",
        "Whitehead's limit of the linear amplification; NaN where its conditions do not hold",
    ),
)  # fmt: skip
MISTUNED = (
    Dataset("aero/decay_per_s", _SHOWN, "1/s", "of the complex modes of the first samples"),
    Dataset("aero/frequency_hz", _SHOWN, "Hz", "frequencies of these"),
    Dataset(
        "aero/least_damping_ratio", ("level", "sample"), "1",
        "damping ratio of the least stable complex mode of a sample; below 0: it flutters",
    ),
)  # fmt: skip


def _half_damped(c: Any) -> dict[Any, Any]:
    """Keys of an air with half the damping."""
    rows = "influence" if c.aero.influence else "waves"
    halved = [
        row.model_dump() | {"damping_ratio": 0.5 * row.damping_ratio}
        for row in getattr(c.aero, rows)
    ]
    return {f"aero.{rows}": halved} if halved else {}


class Aero(Effect):
    """Air between the blades."""

    name = "air"
    needed = "a disk in air (aero.waves)"
    omitted = "Air couples no blades; its damping is in one ratio for all waves (aero)."
    changes = (Change("half the air's damping", "damping_ratio of aero", _half_damped),)
    datasets: ClassVar = {"modal": TUNED, "linear": (*TUNED, *LIMITS, *MISTUNED)}

    def exists(self, config: Config) -> bool:
        """Whether the input knows the air."""
        return config.aero.exists

    def warnings(self, config: Config, problem: Problem) -> Iterator[str]:
        """Warn of modes that the air excites: of the tuned disk and the first of every level."""
        n = min(LOOKED_AT // len(config.levels) + 1, len(config.samples))

        def least(blades: Any) -> Any:
            waves = mistuned_modes(problem.reduced, blades).waves
            assert waves is not None  # there is air
            return waves.damping_ratio.min()

        tuned = least(np.zeros(config.disk.n_blades))
        ratios = [[least(deviation(config, level, k)) for k in range(n)] for level in config.levels]
        lost = np.count_nonzero(np.array(ratios) <= 0.0, axis=1)
        if tuned <= 0.0 or lost.any():
            pairs = zip(lost, config.mistuning.half_range_percent, strict=True)
            at = ", ".join(f"{n_lost} at ±{level:g} %" for n_lost, level in pairs)
            yield (
                "flutter without contact: the least stable wave of the tuned disk has a damping "
                f"ratio of {tuned:.3g}, and of the first {n} mistuned disks flutter {at}: "
                "aero.waves"
            )

    def sizes(self, config: Config) -> dict[str, int]:
        """Numbers of waves, and of disks whose complex modes are kept."""
        return {"wave": config.disk.n_blades, "disk": min(MOST_SHOWN, config.mistuning.samples)}

    def of_model(self, study: str, config: Config, loads: list[Load]) -> Iterator[tuple[str, Any]]:
        """Damping of the tuned disk's waves, given and by complex modes; Whitehead's limits."""
        n_blades = config.disk.n_blades
        eigenvalues = tuned_eigenvalues(loads[0].model.reduced, loads[0].speed)
        r = np.arange(n_blades)
        yield "aero/diameters", np.where(2 * r <= n_blades, r, r - n_blades)
        yield "aero/given_damping_ratio", curve_of(config).damping_ratio
        yield "aero/tuned_damping_ratio", -eigenvalues.real / np.abs(eigenvalues)
        yield "aero/tuned_decay_per_s", -eigenvalues.real
        yield "aero/tuned_frequency_hz", eigenvalues.imag / (2.0 * np.pi)
        if study == "linear":
            yield "aero/largest_amplification", [limit(config, load) for load in loads]

    def of_samples(self, level: int, first: int, modes: list[Modes]) -> Iterator[Values]:
        """Complex modes of consecutive samples."""
        waves = [of_sample.waves for of_sample in modes if of_sample.waves]
        eigenvalues = np.array([each.eigenvalue for each in waves])
        least = np.array([each.damping_ratio.min() for each in waves])
        yield "aero/least_damping_ratio", (level, slice(first, first + len(waves))), least
        shown = eigenvalues[: max(0, MOST_SHOWN - first)]
        if len(shown):
            where = level, slice(first, first + len(shown))
            yield "aero/decay_per_s", where, -shown.real
            yield "aero/frequency_hz", where, shown.imag / (2.0 * np.pi)

    def lines(self, file: ResultFile, disk: int) -> Iterator[str]:
        """Least stable waves of the tuned disk and of mistuned ones."""
        if file.config.study in ("modal", "linear"):
            yield _of_tuned(file)
        if file.config.study == "linear":
            yield from _of_mistuned(file)

    def findings(self, file: ResultFile) -> Iterator[Finding]:
        """Flutter of the tuned disk, and of mistuned ones at every level."""
        if file.config.study in ("modal", "linear"):
            yield from _flutter_of_tuned(file)
        if file.config.study == "linear":
            yield from _flutter_of_mistuned(file)


def tuned_eigenvalues(reduced: ReducedModel, speed: float | None) -> np.ndarray:
    """Eigenvalues of the tuned disk's complex modes, assigned to waves by their shapes (N,).

    reduced: the tuned disk in air; speed: of rotation [rad/s]; None: that of the reduced model.
    """
    modes = mistuned_modes(reduced, np.zeros(reduced.interface.n_blades), speed)
    waves = modes.waves
    assert waves is not None  # there is air
    assert reduced.air is not None
    shapes = modes.shapes[:, waves.rows] @ waves.right
    wanted = reduced.tuned_modes @ reduced.air.waves
    alike = np.abs(wanted.conj().T @ reduced.mass @ shapes)
    return waves.eigenvalue[np.argmax(alike / np.linalg.norm(alike, axis=0), axis=1)]


def limit(config: Config, load: Load) -> float:
    """Whitehead's limit of the linear amplification under a load; NaN where it does not hold [-].

    It is one of velocities: a softer disk moves further for the same velocity. It needs waves that
    are all damped, and mistuning that leaves the family alone.
    """
    largest, reduced = config.mistuning.largest, load.model.reduced
    decay = -tuned_eigenvalues(reduced, load.speed).real
    if not (decay > 0.0).all() or largest > FAMILY_ALONE:
        return np.nan
    assert reduced.air is not None
    tips = reduced.interface.observed @ (reduced.tuned_modes @ reduced.air.waves)
    found = largest_amplification(decay, tips, config.forcing.sense * load.n_diameters)
    return found / np.sqrt(1.0 - largest)


def _of_tuned(file: ResultFile) -> str:
    """Least stable wave of the tuned disk, in words."""
    ratio, diameters = map(file.read, ("aero/tuned_damping_ratio", "aero/diameters"))
    least = int(np.argmin(ratio))
    n = diameters[least]
    way = "" if 2 * n % len(ratio) == 0 else " forward" if n > 0 else " backward"
    return (
        f"air: the tuned disk's least stable wave has {abs(n)} nodal diameters{way} and "
        f"a damping ratio of {ratio[least]:.3g}; the mean of all is {ratio.mean():.3g}"
        + (", and below 0 no mistuning helps" if ratio.mean() < 0.0 else "")
    )


def _of_mistuned(file: ResultFile) -> Iterator[str]:
    """Least stable mode of the mistuned disks of every level."""
    for sigma, least in zip(*map(file.read, ("sigma", "aero/least_damping_ratio")), strict=True):
        least = finite(least)
        if not len(least):
            continue
        low, middle, high = np.percentile(least, [1, 50, 99])
        n_flutter = int(np.count_nonzero(least <= 0.0))
        low_share, high_share = 100.0 * probability_interval(n_flutter, len(least), Z_95)
        yield (
            f"air, sigma = {100 * sigma:.2f} %: least stable mode {low:.3g} / {middle:.3g} / "
            f"{high:.3g} (percentiles 1/50/99 of the damping ratio); {n_flutter} of {len(least)} "
            f"disks flutter without contact ({low_share:.3g} to {high_share:.3g} %)"
        )


def _flutter_of_tuned(file: ResultFile) -> Iterator[Any]:
    """Flutter of the tuned disk, which a linear study needs."""
    least = float(file.read("aero/tuned_damping_ratio").min())
    if least <= 0.0:
        yield Finding(
            USELESS if file.config.study == "linear" else SINGLE,
            "the tuned disk flutters",
            f"the tuned disk flutters without contact (damping ratio of {least:.3g}): it has no "
            "linear response, and no amplification is relative to it: aero, or more damping",
        )


def _flutter_of_mistuned(file: ResultFile) -> Iterator[Any]:
    """Flutter of mistuned disks, which are missing in percentiles."""
    ratios = [finite(level) for level in file.read("aero/least_damping_ratio")]
    lost = [int(np.count_nonzero(level <= 0.0)) for level in ratios]
    if any(lost):
        levels, n = file.config.mistuning.half_range_percent, [*map(len, ratios)]
        at = ", ".join(f"{lost[v]} of {n[v]} at ±{level:g} %" for v, level in enumerate(levels))
        yield Finding(
            USELESS if any(lost[v] > MOST_LOST * n[v] for v in range(len(n))) else SINGLE,
            "disks flutter",
            f"disks flutter without contact and are missing in the percentiles: {at}: aero, or "
            "more mistuning",
        )
