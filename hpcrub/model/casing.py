"""The rigid casing: its shape over the circumference and the ramp at the start of a run.

Heights are inward, angles those around the casing in the direction of rotation, from the place of
the angle zero of the disk at the start of a run.
"""

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np

N_ANGLES = 2**14  # of a shape whose spectrum is asked for
RELEVANT = 0.01  # of the largest amplitude of any order


class Profile(NamedTuple):
    """Inward deformation of the casing beside its bumps: harmonics plus measured points."""

    # order n [-], amplitude a [m], angle of a crest b [rad] of each: a cos(n(phi - b))
    harmonics: tuple[tuple[int, float, float], ...] = ()
    # angle, increasing within one turn [rad], and height [m] of each point, linear between them
    measured: tuple[tuple[float, float], ...] = ()

    def height(self, phi: np.ndarray) -> np.ndarray:
        """Height [m] at an angle [rad], of any shape."""
        total = np.zeros(np.shape(phi))
        for order, amplitude, crest in self.harmonics:
            total += amplitude * np.cos(order * (phi - crest))
        if self.measured:
            angle, height = np.array(self.measured).T
            total += np.interp(phi, angle, height, period=2.0 * np.pi)
        return total

    @property
    def exists(self) -> bool:
        """Whether there is any."""
        return bool(self.harmonics or self.measured)

    @property
    def repeats(self) -> int:
        """Times that it repeats itself in a turn, 0 when it is the same everywhere."""
        return 1 if self.measured else math.gcd(*(order for order, *_ in self.harmonics))


NO_PROFILE = Profile()


class Outline(NamedTuple):
    """What the shape of a casing says about loads and time steps."""

    highest: float  # [m]
    mean: float  # [m]
    curvature: float  # largest second derivative at a crest, of all relevant orders [m/rad²]
    orders: tuple[int, ...]  # relevant ones, the strongest first; none of a circle


def bump_height(phi: np.ndarray, n_bumps: int, height: float) -> np.ndarray:
    """Height of the casing's bumps at an angle.

    Parameters
    ----------
    phi : ndarray
        Angle from any bump [rad], of any shape.
    n_bumps : int
        Number n_d of evenly spaced bumps.
    height : float
        Bump height c_rd [m].

    Returns
    -------
    ndarray
        Height above the undeformed casing [m], same shape as ``phi``.

    Notes
    -----
    Joachim, Nyssen, Batailly (2020), equation (1), inward counted positive.
    """
    pitch = 2.0 * np.pi / n_bumps
    nearest = phi - pitch * np.round(phi / pitch)
    return height * np.exp(-((nearest / (0.1 * pitch)) ** 2))


def casing_height(
    phi: np.ndarray, n_bumps: int, height: float, profile: Profile = NO_PROFILE
) -> np.ndarray:
    """Height of the casing at an angle [m]: bumps (see `bump_height`) and profile together."""
    bumps = bump_height(phi, n_bumps, height)
    return bumps + profile.height(phi) if profile.exists else bumps


@lru_cache(maxsize=16)
def outline(n_bumps: int, height: float, profile: Profile) -> Outline:
    """Outline of a casing; arguments as of `casing_height`.

    An order is relevant when its amplitude is at least one hundredth of the largest: of Gaussian
    bumps the first six multiples of their number. So measuring noise below that has no say.
    """
    phi = 2.0 * np.pi * np.arange(N_ANGLES) / N_ANGLES
    measured = np.array([angle for angle, _ in profile.measured])
    there = casing_height(np.concatenate([phi, measured]), n_bumps, height, profile)
    spectrum = np.fft.rfft(there[:N_ANGLES])
    mean, spectrum[0] = spectrum[0].real / N_ANGLES, 0.0
    size = 2.0 * np.abs(spectrum) / N_ANGLES
    size[size < 1e-12 * np.abs(there).max()] = 0.0  # rounding
    kept = (size > 0.0) & (size >= RELEVANT * size.max())
    orders = np.arange(len(size))
    bend = np.fft.irfft(np.where(kept, orders**2 * spectrum, 0.0), N_ANGLES)
    strongest = orders[kept][np.argsort(-size[kept], kind="stable")]
    return Outline(
        float(there.max()), float(mean), float(bend.max()), tuple(int(n) for n in strongest)
    )


def highest(n_bumps: int, height: float, profile: Profile = NO_PROFILE) -> float:
    """Largest height of a casing [m]; arguments as of `casing_height`."""
    return outline(n_bumps, height, profile).highest if profile.exists else height


def repeats(n_bumps: int, height: float, profile: Profile) -> int:
    """Times that a casing repeats itself in a turn; arguments as of `casing_height`."""
    if not profile.exists:
        return n_bumps
    return math.gcd(n_bumps if height > 0.0 else 0, profile.repeats)


def bump_table(
    contact_angle: np.ndarray,
    n_bumps: int,
    height: float,
    steps_per_revolution: int,
    n_steps: int,
    profile: Profile = NO_PROFILE,
) -> np.ndarray:
    """Heights of the casing that every contact point meets in the first steps of a revolution.

    Parameters
    ----------
    contact_angle : ndarray (C,)
        Angles of the contact points in the rotating frame [rad].
    n_bumps : int
        Number of bumps.
    height : float
        Bump height [m].
    steps_per_revolution : int
        Time steps in which the disk turns once.
    n_steps : int
        Rows of the table.
    profile : Profile
        Beside the bumps.

    Returns
    -------
    ndarray (n_steps, C)
        Heights [m]; row j holds the heights after j + 1 steps.
    """
    rotation = (np.arange(n_steps) + 1.0) * (2.0 * np.pi / steps_per_revolution)
    return casing_height(rotation[:, None] + contact_angle[None, :], n_bumps, height, profile)


def ramp(t: float, ramp_time: float) -> float:
    """Bump ramp s(t), the factor of all heights: 0 until t = 0, 1 from ``ramp_time`` [s] on."""
    if t <= 0.0:
        return 0.0
    if t >= ramp_time:
        return 1.0
    return (1.0 - math.exp(-5.0 * t / ramp_time)) / (1.0 - math.exp(-5.0))
