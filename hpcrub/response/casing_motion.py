"""Motion of a casing that vibrates: how far, in how many waves, and whether it runs away."""

from typing import NamedTuple

import numpy as np

from hpcrub.contact.arrays import Bank
from hpcrub.model.casing_modes import Pairs
from hpcrub.model.reduction import Modes

LARGEST = 0.1  # motion of the casing over the tips' radius, up to which it counts as small
ANGLES_PER_WAVE = 16


class CasingMotion(NamedTuple):
    """Motion of the casing at S speeds; NaN where the casing is rigid, or nothing is known."""

    largest: np.ndarray  # largest radial motion in the last window, at any angle (S,) [m]
    waves: np.ndarray  # n of the pair that moves most in this window, or runs away (S,) [-]
    share: np.ndarray  # casing's part of the energy of disk and casing, at the end (S,) [-]
    growth: np.ndarray  # rate at which a casing runs away (S,) [1/s]


def radial(pairs: Pairs, coordinates: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Outward motion of the casing (R, A) [m].

    coordinates: of the pairs, turned with the disk (R, 2J) [m·√kg].
    angle: in the rotating frame (A,) or (R, A) [rad].
    """
    moved = np.zeros((len(coordinates), np.shape(angle)[-1]))
    for j, n in enumerate(pairs.n_waves):
        c, s = coordinates[:, 2 * j, None], coordinates[:, 2 * j + 1, None]
        moved += pairs.radial[j] * (c * np.cos(n * angle) + s * np.sin(n * angle))
    return moved


def amplitudes(pairs: Pairs, coordinates: np.ndarray) -> np.ndarray:
    """Radial amplitude of every wave (..., J) [m] at coordinates of the pairs (..., 2J)."""
    return np.hypot(coordinates[..., ::2], coordinates[..., 1::2]) * np.abs(pairs.radial)


def largest(pairs: Pairs, coordinates: np.ndarray) -> tuple[float, int]:
    """Largest radial motion [m] at coordinates (R, 2J), and n of the wave that moves most."""
    n_angles = ANGLES_PER_WAVE * max(int(pairs.n_waves.max()), 1)
    angle = np.arange(n_angles) * (2.0 * np.pi / n_angles)
    most = np.argmax((amplitudes(pairs, coordinates) ** 2).mean(axis=0))
    return float(np.abs(radial(pairs, coordinates, angle)).max()), int(pairs.n_waves[most])


def share_of_energy(modes: Modes, bank: Bank, lane: int) -> float:
    """Casing's part of the energy of disk and casing in a lane [-]; modes: at its speed."""
    velocity = bank.state.increment[:, lane] / bank.scheme.step[lane]
    position = bank.state.position[:, lane]
    omega = modes.omega, np.repeat(modes.pairs.omega, 2)
    moving = zip(modes.of_rows(velocity), omega, modes.of_rows(position), strict=True)
    disk, casing = (v**2 + w**2 * q**2 for v, w, q in moving)
    return float(casing.sum() / np.concatenate([disk, casing]).sum())


class Runaway:
    """Watches whether a wave of the casing grows beyond a limit in a lane."""

    def __init__(self, pairs: Pairs, limit: float, blocks_per_revolution: int) -> None:
        """Start from rest; limit: amplitude beyond which the casing runs away [m]."""
        self.pairs, self.limit, self.per_turn = pairs, limit, blocks_per_revolution
        self.sizes: list[np.ndarray] = []  # amplitudes of every wave (J,) [m] at the ends of blocks

    def see(self, coordinates: np.ndarray) -> bool:
        """Note the pairs' coordinates (2J,) after a block; return whether the casing runs away."""
        self.sizes = [*self.sizes[-self.per_turn :], amplitudes(self.pairs, coordinates)]
        return not bool((self.sizes[-1] <= self.limit).all())

    def growth(self, speed_hz: float) -> tuple[int, float]:
        """Number n of the largest wave, and its rate of growth [1/s]; speed_hz: of rotation."""
        now, before = np.nan_to_num(self.sizes[-1], nan=np.inf), self.sizes[0]
        wave = int(np.argmax(now))
        time = (len(self.sizes) - 1) / (self.per_turn * speed_hz)
        with np.errstate(all="ignore"):
            rate = float(np.log(now[wave] / before[wave]) / time)
        return int(self.pairs.n_waves[wave]), rate if np.isfinite(rate) else np.nan
