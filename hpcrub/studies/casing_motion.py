"""What studies store and say of a casing that vibrates: names, units and words, in all of them."""

from collections.abc import Iterator

import numpy as np

from hpcrub.contact.status import RUNAWAY
from hpcrub.response.casing_motion import CasingMotion
from hpcrub.results.layout import Dataset
from hpcrub.results.storage import ResultFile

# of every speed: {name: (units, description)}, in the order of `CasingMotion`
_NUMBERS = {
    "casing_motion_m": ("m", "largest radial motion of the casing, angle and time, last window"),
    "casing_waves": ("1", "waves around the casing that move most, or that run away"),
    "casing_energy_share": ("1", "energy of the casing over that of disk and casing, at the end"),
    "casing_growth_per_s": ("1/s", "rate at which a casing runs away; NaN: it does not"),
}
NAMES = tuple(_NUMBERS)


def numbers(group: str, dimensions: tuple[str, ...]) -> Iterator[Dataset]:
    """Datasets of the numbers of every speed; group: of the file."""
    return (Dataset(f"{group}/{n}", dimensions, *what) for n, what in _NUMBERS.items())


def values(casing: CasingMotion) -> dict[str, np.ndarray]:
    """Arrays of some speeds by their names in a group of the file."""
    return dict(zip(NAMES, casing, strict=True))


def lines(file: ResultFile) -> Iterator[str]:
    """How far the casing of a contact study moves, and how often it runs away; else nothing."""
    if not file.config.casing.vibrates:
        return
    reason, n = file.read("tuned/point_reason"), len(file.config.speeds.values_hz)
    moved, waves = (file.read(f"tuned/{name}") for name in NAMES[:2])
    if np.isfinite(moved).any():
        at = int(np.nanargmax(moved))
        speed = file.config.speeds.values_hz[at]
        yield (
            f"casing around the tuned disk: moves by {1e3 * moved[at]:.3g} mm at {speed:g} Hz, "
            f"most with n = {waves[at]:.0f}"
        )
    away = reason == RUNAWAY
    if away.any():
        growth, at = file.read("tuned/casing_growth_per_s"), int(np.flatnonzero(away)[0])
        yield (
            f"casing around the tuned disk: runs away at {np.count_nonzero(away)} of {n} speeds, "
            f"from {file.config.speeds.values_hz[at]:g} Hz with n = {waves[at]:.0f} and "
            f"{growth[at]:.3g} 1/s"
        )
    done = file.read("samples/status") == 1
    motion = file.read("samples/casing_motion_m")[done]
    if np.isfinite(motion).any():
        most = np.nanmax(np.where(np.isfinite(motion), motion, 0.0), axis=-1)
        low, middle, high = 1e3 * np.percentile(most, [1, 50, 99])
        yield (
            f"casing around mistuned disks: moves by {low:.3g}/{middle:.3g}/{high:.3g} mm "
            "(percentiles 1/50/99 of the largest of any speed)"
        )
