"""Motion of a casing that vibrates: how far, in how many waves, and whether it runs away."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from hpcrub.contact import status
from hpcrub.contact.arrays import Bank
from hpcrub.model.casing_modes import Pairs
from hpcrub.model.reduction import Modes
from hpcrub.response.quantities import Quantities, quantity

LARGEST = 0.1  # motion of the casing over the tips' radius, up to which it counts as small
ANGLES_PER_WAVE = 16


@dataclass
class CasingMotion(Quantities):
    """Motion of the casing at S speeds (S,); NaN where it is rigid, or nothing is known."""

    largest: np.ndarray = quantity(
        "casing_motion_m", "m", "largest radial motion of the casing, angle and time, last window"
    )
    waves: np.ndarray = quantity(
        "casing_waves",
        "1",
        "waves around the casing that move most, or that run away",
        at_rest=np.nan,
    )
    share: np.ndarray = quantity(
        "casing_energy_share",
        "1",
        "energy of the casing over that of disk and casing, at the end",
        at_rest=np.nan,
    )
    growth: np.ndarray = quantity(
        "casing_growth_per_s",
        "1/s",
        "rate at which a casing runs away; NaN: it does not",
        at_rest=np.nan,
    )


def radial(pairs: Pairs, coordinates: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Outward motion of the casing (R, A) [m].

    coordinates: of the pairs, turned with the disk (R, 2J) [m·√kg].
    angle: in the rotating frame (A,) [rad]; in that of the casing for coordinates `at_rest`.
    """
    phase = np.outer(pairs.n_waves, angle)
    rows = pairs.radial[:, None, None] * np.stack([np.cos(phase), np.sin(phase)], axis=1)
    return coordinates @ rows.reshape(-1, len(angle))


def at_rest(pairs: Pairs, coordinates: np.ndarray, turned: np.ndarray) -> np.ndarray:
    """Coordinates of the pairs (R, 2J) in the casing's frame, after angles turned (R,) [rad]."""
    y = coordinates[:, ::2] - 1j * coordinates[:, 1::2]
    y = y * np.exp(-1j * np.outer(turned, pairs.n_waves))
    return np.stack([y.real, -y.imag], axis=2).reshape(coordinates.shape)


def amplitudes(pairs: Pairs, coordinates: np.ndarray) -> np.ndarray:
    """Radial amplitude of every wave (..., J) [m] at coordinates of the pairs (..., 2J)."""
    squares = coordinates**2
    return np.sqrt(squares[..., ::2] + squares[..., 1::2]) * np.abs(pairs.radial)


def largest(pairs: Pairs, coordinates: np.ndarray) -> tuple[float, int]:
    """Largest radial motion [m] at coordinates (R, 2J), and n of the wave that moves most."""
    n_angles = ANGLES_PER_WAVE * max(int(pairs.n_waves.max()), 1)
    angle = np.arange(n_angles) * (2.0 * np.pi / n_angles)
    size = amplitudes(pairs, coordinates)
    most, bound = int(np.argmax((size**2).mean(axis=0))), size.sum(axis=1)
    least = np.abs(radial(pairs, coordinates[[bound.argmax()]], angle)).max()
    near = coordinates[bound >= least]  # no other record can have a larger motion
    return float(np.abs(radial(pairs, near, angle)).max()), int(pairs.n_waves[most])


def share_of_energy(modes: Modes, bank: Bank, lane: int) -> float:
    """Casing's part of the energy of disk and casing in a lane [-]; modes: at its speed."""
    velocity = bank.state.increment[:, lane] / bank.scheme.step[lane]
    position = bank.state.position[:, lane]
    omega = modes.omega, np.repeat(modes.pairs.omega, 2)
    moving = zip(modes.of_rows(velocity), omega, modes.of_rows(position), strict=True)
    disk, casing = (v**2 + w**2 * q**2 for v, w, q in moving)
    total = np.concatenate([disk, casing]).sum()
    if modes.blades:  # blades deviate from the stiffness of the modes
        y = modes.blades.modes @ modes.of_rows(position)[0]
        total += modes.blades.deviation @ (y**2).sum(axis=1)
    return float(casing.sum() / total)


class Runaway:
    """Watches whether a wave of the casing grows beyond a limit in a lane."""

    def __init__(self, pairs: Pairs, scene: Any, blocks_per_revolution: int) -> None:
        """Start from rest; scene: a Scene, for the radius of the tips."""
        self.pairs, self.per_turn = pairs, blocks_per_revolution
        self.limit = LARGEST * scene.interface.radius.max()
        self.sizes = np.zeros((0, len(pairs.omega)))  # of every wave, at the ends of blocks [m]

    def see(self, coordinates: np.ndarray) -> int:
        """Note the pairs' coordinates (B, 2J) after each of some blocks.

        Returns the number of blocks after which the casing runs away, or 0.
        """
        with np.errstate(all="ignore"):  # a casing that ran away goes on to the end of a call
            new = amplitudes(self.pairs, coordinates)
        beyond = ~(new <= self.limit).all(axis=1)
        n = int(beyond.argmax()) + 1 if beyond.any() else 0
        self.sizes = np.concatenate([self.sizes, new[: n or len(new)]])[-self.per_turn - 1 :]
        return n

    def growth(self, speed_hz: float) -> tuple[int, float]:
        """Number n of the largest wave, and its rate of growth [1/s]; speed_hz: of rotation."""
        now, before = np.nan_to_num(self.sizes[-1], nan=np.inf), self.sizes[0]
        wave = int(np.argmax(now))
        time = (len(self.sizes) - 1) / (self.per_turn * speed_hz)
        with np.errstate(all="ignore"):
            rate = float(np.log(now[wave] / before[wave]) / time)
        return int(self.pairs.n_waves[wave]), rate if np.isfinite(rate) else np.nan

    def reason(self, speed_hz: float) -> int:
        """Code of ``status``: RUNAWAY only of a wave that the rotor overtakes at a speed [Hz]."""
        wave = int(np.argmax(np.nan_to_num(self.sizes[-1], nan=np.inf)))
        overtaken = self.pairs.omega[wave] < 2.0 * np.pi * speed_hz * self.pairs.n_waves[wave]
        return status.RUNAWAY if overtaken else status.NOT_FED
