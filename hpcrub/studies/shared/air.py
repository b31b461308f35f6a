"""Disks in air, for modal and linear studies: damping of waves, and the disks that flutter."""

from collections.abc import Iterator

import numpy as np

from hpcrub.config.schema import Config
from hpcrub.config.text import counted
from hpcrub.model.aero import Air, Waves, largest_amplification
from hpcrub.model.reduction import ReducedModel, mistuned_modes
from hpcrub.results.layout import Dataset
from hpcrub.results.storage import ResultFile
from hpcrub.results.verdict import MOST_LOST, SINGLE, USELESS, Finding
from hpcrub.runs.study import Values
from hpcrub.setup.aero import curve_of
from hpcrub.statistics.percentiles import Z_95, finite, probability_interval

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


def layout(config: Config, *parts: tuple[Dataset, ...]) -> tuple[Dataset, ...]:
    """Datasets of a study in air; parts: TUNED, MISTUNED or both. None without air."""
    return sum(parts, ()) if config.aero.exists else ()


def sizes(config: Config) -> dict[str, int]:
    """Lengths of the dimensions of these datasets."""
    return {"wave": config.disk.n_blades, "disk": min(MOST_SHOWN, config.mistuning.samples)}


def values_of_tuned(
    config: Config, reduced: ReducedModel, speed: float | None = None
) -> Iterator[Values]:
    """Damping of the tuned disk's waves, given and by complex modes; nothing without air.

    speed: of rotation [rad/s]; None: that of the reduced model.
    """
    if reduced.air is None:
        return
    n_blades = config.disk.n_blades
    eigenvalues = tuned_eigenvalues(reduced, reduced.air, speed)
    r = np.arange(n_blades)
    yield "aero/diameters", (), np.where(2 * r <= n_blades, r, r - n_blades)
    yield "aero/given_damping_ratio", (), curve_of(config).damping_ratio
    yield "aero/tuned_damping_ratio", (), -eigenvalues.real / np.abs(eigenvalues)
    yield "aero/tuned_decay_per_s", (), -eigenvalues.real
    yield "aero/tuned_frequency_hz", (), eigenvalues.imag / (2.0 * np.pi)


def tuned_eigenvalues(reduced: ReducedModel, air: Air, speed: float | None) -> np.ndarray:
    """Eigenvalues of the tuned disk's complex modes, assigned to waves by their shapes (N,)."""
    modes = mistuned_modes(reduced, np.zeros(reduced.interface.n_blades), speed)
    waves = modes.waves
    assert waves is not None  # there is air
    shapes = modes.shapes[:, waves.rows] @ waves.right
    wanted = reduced.tuned_modes @ air.waves
    alike = np.abs(wanted.conj().T @ reduced.mass @ shapes)
    return waves.eigenvalue[np.argmax(alike / np.linalg.norm(alike, axis=0), axis=1)]


def limit(config: Config, reduced: ReducedModel, speed: float | None, diameters: int) -> float:
    """Whitehead's limit of the linear amplification under a load; NaN where it does not hold [-].

    It is one of velocities: a softer disk moves further for the same velocity. It needs waves that
    are all damped, and mistuning that leaves the family alone.
    """
    largest = config.mistuning.largest
    assert reduced.air is not None
    decay = -tuned_eigenvalues(reduced, reduced.air, speed).real
    if not (decay > 0.0).all() or largest > FAMILY_ALONE:
        return np.nan
    tips = reduced.interface.observed @ (reduced.tuned_modes @ reduced.air.waves)
    found = largest_amplification(decay, tips, config.forcing.sense * diameters)
    return found / np.sqrt(1.0 - largest)


def values(waves: list[Waves], level: int, first: int) -> Iterator[Values]:
    """Complex modes of consecutive samples; first: number of the first of these samples."""
    eigenvalues = np.array([each.eigenvalue for each in waves])
    least = np.array([each.damping_ratio.min() for each in waves])
    yield "aero/least_damping_ratio", (level, slice(first, first + len(waves))), least
    shown = eigenvalues[: max(0, MOST_SHOWN - first)]
    if len(shown):
        where = level, slice(first, first + len(shown))
        yield "aero/decay_per_s", where, -shown.real
        yield "aero/frequency_hz", where, shown.imag / (2.0 * np.pi)


def report_of_tuned(file: ResultFile) -> Iterator[str]:
    """Least stable wave of the tuned disk; nothing without air."""
    if not file.config.aero.exists:
        return
    ratio, diameters = file.read("aero/tuned_damping_ratio"), file.read("aero/diameters")
    least = int(np.argmin(ratio))
    n = diameters[least]
    way = "" if 2 * n % len(ratio) == 0 else " forward" if n > 0 else " backward"
    yield (
        f"air: the tuned disk's least stable wave has {abs(n)} nodal diameters{way} and "
        f"a damping ratio of {ratio[least]:.3g}; the mean of all is {ratio.mean():.3g}"
        + (", and below 0 no mistuning helps" if ratio.mean() < 0.0 else "")
    )


def report_of_mistuned(file: ResultFile) -> Iterator[str]:
    """Least stable mode of the mistuned disks of every level; nothing without air."""
    if not file.config.aero.exists:
        return
    for sigma, least in zip(file.read("sigma"), file.read("aero/least_damping_ratio"), strict=True):
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


def findings(file: ResultFile) -> Iterator[Finding]:
    """Flutter of the tuned disk, and of mistuned ones at every level; nothing without air."""
    if not file.config.aero.exists:
        return
    least = float(file.read("aero/tuned_damping_ratio").min())
    if least <= 0.0:
        yield Finding(
            USELESS if "aero/least_damping_ratio" in file else SINGLE,
            "the tuned disk flutters",
            f"the tuned disk flutters without contact (damping ratio of {least:.3g}): it has no "
            "linear response, and no amplification is relative to it: aero, or more damping",
        )
    if "aero/least_damping_ratio" not in file:
        return
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


def left_out(file: ResultFile, level: int) -> str:
    """Number of disks of a level that flutter and have no linear response, in words."""
    if not file.config.aero.exists:
        return ""
    lost = int(np.count_nonzero(file.read("aero/least_damping_ratio", level) <= 0.0))
    return f", without {counted(lost, 'disk')} that flutter" if lost else ""
