"""Datasets and report lines of a casing that vibrates, the same in all studies."""

from collections.abc import Iterator

import numpy as np

from hpcrub.config.schema import Config
from hpcrub.contact.status import RUNAWAY
from hpcrub.model.reduction import Modes
from hpcrub.response.casing_stability import growth
from hpcrub.results.layout import DONE, Dataset
from hpcrub.results.storage import ResultFile

PERMANENT = Dataset(
    "tuned/permanent_growth_per_s", ("friction", "speed"), "1/s",
    "fastest growth of the linear disk and casing with all tips in permanent contact, without "
    "friction and with it; below 0: decays",
)  # fmt: skip


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


def lines(file: ResultFile, n_samples: int) -> Iterator[str]:
    """Lines about a casing that vibrates: how far it moves, and how often it runs away.

    n_samples: number of samples of every level that count.
    """
    if not file.config.casing.vibrates:
        return
    reason, speeds = file.read("tuned/point_reason"), file.config.speeds.values_hz
    moved, waves = map(file.read, ("tuned/casing_motion_m", "tuned/casing_waves"))
    if np.isfinite(moved).any():
        at = int(np.nanargmax(moved))
        yield (
            f"casing around the tuned disk: moves by {1e3 * moved[at]:.3g} mm at {speeds[at]:g} "
            f"Hz, most with n = {waves[at]:.0f}"
        )
    away = reason == RUNAWAY
    if away.any():
        growth, at = file.read("tuned/casing_growth_per_s"), int(np.flatnonzero(away)[0])
        yield (
            f"casing around the tuned disk: runs away at {np.count_nonzero(away)} of {len(speeds)} "
            f"speeds, from {speeds[at]:g} Hz with n = {waves[at]:.0f} and {growth[at]:.3g} 1/s"
        )
    done = file.read("samples/status")[:, :n_samples] == DONE
    motion = file.read("samples/casing_motion_m")[:, :n_samples][done]
    if np.isfinite(motion).any():
        most = np.nanmax(np.where(np.isfinite(motion), motion, 0.0), axis=-1)
        low, middle, high = 1e3 * np.percentile(most, [1, 50, 99])
        if file.config.pattern_deviation is not None:
            yield f"casing around the mistuned disk: moves by {middle:.3g} mm at most"
            return
        yield (
            f"casing around mistuned disks: moves by {low:.3g}/{middle:.3g}/{high:.3g} mm "
            "(percentiles 1/50/99 of the largest of any speed)"
        )
