"""What a casing that vibrates does: how far it moves, with how many waves, whether it runs away."""

from typing import NamedTuple

import numpy as np

from hpcrub.contact.arrays import Bank
from hpcrub.model.casing_modes import Pairs
from hpcrub.model.reduction import Modes

LARGEST = 0.1  # of the tips' radius: small displacements say nothing of a casing that moves further
ANGLES_PER_WAVE = 16


class CasingMotion(NamedTuple):
    """Motion of the casing at S speeds; NaN where it does not vibrate, or nothing is known."""

    largest: np.ndarray  # radial motion over angle and time of the last window (S,) [m]
    waves: np.ndarray  # n of the pair that moves most then, or that runs away (S,) [-]
    share: np.ndarray  # energy of the casing over that of disk and casing, at the end (S,) [-]
    growth: np.ndarray  # rate at which a casing runs away (S,) [1/s]

    @classmethod
    def empty(cls, n: int) -> "CasingMotion":
        """Of n speeds, not known yet."""
        return cls(*np.full((4, n), np.nan))


def radial(pairs: Pairs, coordinates: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Outward motion of the casing (R, A) [m].

    coordinates: of the pairs, as the kernel has them (R, 2J); angle: rotating (A,) or (R, A) [rad].
    """
    moved = np.zeros((len(coordinates), np.shape(angle)[-1]))
    for j, n in enumerate(pairs.n_waves):
        c, s = coordinates[:, 2 * j, None], coordinates[:, 2 * j + 1, None]
        moved += pairs.radial[j] * (c * np.cos(n * angle) + s * np.sin(n * angle))
    return moved


def amplitudes(pairs: Pairs, coordinates: np.ndarray) -> np.ndarray:
    """Radial amplitude of every wave (..., J) [m]; coordinates: of the pairs (..., 2J) [m·√kg]."""
    return np.hypot(coordinates[..., ::2], coordinates[..., 1::2]) * np.abs(pairs.radial)


def largest(pairs: Pairs, coordinates: np.ndarray) -> tuple[float, int]:
    """Largest radial motion [m] of pairs at (R, 2J), and n of the wave that moves most."""
    n_angles = ANGLES_PER_WAVE * max(int(pairs.n_waves.max()), 1)
    angle = np.arange(n_angles) * (2.0 * np.pi / n_angles)
    most = np.argmax((amplitudes(pairs, coordinates) ** 2).mean(axis=0))
    return float(np.abs(radial(pairs, coordinates, angle)).max()), int(pairs.n_waves[most])


def share_of_energy(modes: Modes, bank: Bank, lane: int) -> float:
    """Energy of the casing over that of disk and casing, of a lane now [-]; modes: at its speed."""
    velocity = bank.state.increment[:, lane] / bank.scheme.step[lane]
    omega = modes.omega, np.repeat(modes.pairs.omega, 2)
    moving = zip(
        modes.of_rows(velocity), omega, modes.of_rows(bank.state.position[:, lane]), strict=True
    )
    disk, casing = (v**2 + w**2 * q**2 for v, w, q in moving)
    return float(casing.sum() / np.concatenate([disk, casing]).sum())


class Runaway:
    """Watches the waves of a lane, from one revolution to the next."""

    def __init__(self, pairs: Pairs, limit: float, blocks_per_revolution: int) -> None:
        """Nothing moves yet; limit: radial motion beyond which it runs away [m]."""
        self.pairs, self.limit, self.per_turn = pairs, limit, blocks_per_revolution
        self.sizes: list[np.ndarray] = []  # amplitudes of every wave (J,) [m] at the ends of blocks

    def see(self, coordinates: np.ndarray) -> bool:
        """Take the pairs' coordinates (2J,) after a block; returns whether the casing runs away."""
        self.sizes = [*self.sizes[-self.per_turn :], amplitudes(self.pairs, coordinates)]
        return not bool((self.sizes[-1] <= self.limit).all())

    def growth(self, speed_hz: float) -> tuple[int, float]:
        """Number n of the wave that is largest, and how fast it grows at a speed [Hz] [1/s]."""
        now, before = np.nan_to_num(self.sizes[-1], nan=np.inf), self.sizes[0]
        wave = int(np.argmax(now))
        time = (len(self.sizes) - 1) / (self.per_turn * speed_hz)
        with np.errstate(all="ignore"):
            rate = float(np.log(now[wave] / before[wave]) / time)
        return int(self.pairs.n_waves[wave]), rate if np.isfinite(rate) else np.nan
