"""The rigid casing: its shape over the circumference and the ramp at the start of a run.

Heights are inward, angles those around the casing in the direction of rotation, from the place of
the angle zero of the disk at the start of a run.
"""

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np

BUMP_WIDTH = 0.1  # of the pitch: where a bump has 1/e of its height, on each side of its crest
N_ANGLES = 2**14  # of a shape whose spectrum is asked for
RELEVANT = 0.01  # of the largest amplitude of any order
# of the height that blades meet: a change of the casing that counts, and the part of a Gaussian
# bump whose steepest flank rises by it in the width of the bump over so much
ROUGH, FLANK = 0.1, 2.0 * math.sqrt(2.0 / math.e)


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
    rest: np.ndarray  # heights less the relevant orders, at N_ANGLES angles [m]
    cliffs: np.ndarray  # (2, n) angle [rad] and change [m] between closer measured points


def bump_height(
    phi: np.ndarray, n_bumps: int, height: float, width: float = BUMP_WIDTH
) -> np.ndarray:
    """Height of the casing's bumps at an angle.

    - phi: angle from any bump [rad], of any shape.
    - n_bumps: number n_d of evenly spaced bumps.
    - height: bump height c_rd [m].
    - width: distance from its crest at which a bump has 1/e of its height, in pitches [-].

    Returns height above the undeformed casing [m], same shape as ``phi``.
    Source: Joachim, Nyssen, Batailly (2020), equation (1), inward counted positive.
    """
    pitch = 2.0 * np.pi / n_bumps
    nearest = phi - pitch * np.round(phi / pitch)
    return height * np.exp(-((nearest / (width * pitch)) ** 2))


def casing_height(
    phi: np.ndarray,
    n_bumps: int,
    height: float,
    profile: Profile = NO_PROFILE,
    width: float = BUMP_WIDTH,
) -> np.ndarray:
    """Height of the casing at an angle [m]: bumps (see `bump_height`) and profile together."""
    bumps = bump_height(phi, n_bumps, height, width)
    return bumps + profile.height(phi) if profile.exists else bumps


@lru_cache(maxsize=16)
def outline(n_bumps: int, height: float, profile: Profile, width: float = BUMP_WIDTH) -> Outline:
    """Outline of a casing; arguments as of `casing_height`.

    An order is relevant when its amplitude is at least one hundredth of the largest: of Gaussian
    bumps the first six multiples of their number. So measuring noise below that has no say.
    """
    phi = 2.0 * np.pi * np.arange(N_ANGLES) / N_ANGLES
    measured = np.array([angle for angle, _ in profile.measured])
    there = casing_height(np.concatenate([phi, measured]), n_bumps, height, profile, width)
    spectrum = np.fft.rfft(there[:N_ANGLES])
    mean, spectrum[0] = spectrum[0].real / N_ANGLES, 0.0
    size = 2.0 * np.abs(spectrum) / N_ANGLES
    size[size < 1e-12 * np.abs(there).max()] = 0.0  # rounding
    kept = (size > 0.0) & (size >= RELEVANT * size.max())
    orders = np.arange(len(size))
    bend = np.fft.irfft(np.where(kept, orders**2 * spectrum, 0.0), N_ANGLES)
    rest = np.fft.irfft(np.where(kept, 0.0, spectrum), N_ANGLES) if measured.size else np.zeros(1)
    points = np.array(profile.measured + profile.measured[:1]).T.reshape(2, -1)
    cliffs = np.abs(np.diff(points))
    cliffs = cliffs[:, (cliffs[0] > 0.0) & (cliffs[0] < 2.0 * np.pi / N_ANGLES)]
    strongest = orders[kept][np.argsort(-size[kept], kind="stable")]
    return Outline(
        float(there.max()),
        float(mean),
        float(bend.max()),
        tuple(int(n) for n in strongest),
        rest,
        cliffs,
    )


def width_of_rest(found: Outline, met: float) -> float:
    """Angle in which a bump would be as steep as spikes, jumps and noise of a casing [rad].

    met: height of the casing that blades meet [m]; smaller changes than ROUGH of it do not count.
    Infinite where there are none.
    """
    from scipy.ndimage import maximum_filter1d, minimum_filter1d  # a quarter of a second

    depth, grid = ROUGH * met, 2.0 * np.pi / N_ANGLES

    def change(n):
        parts = (
            maximum_filter1d(found.rest, n + 1, mode="wrap"),
            minimum_filter1d(found.rest, n + 1, mode="wrap"),
        )
        return float((parts[0] - parts[1]).max())

    rises = found.cliffs[0, found.cliffs[1] >= depth] / found.cliffs[1, found.cliffs[1] >= depth]
    steepest = [float(rises.min())] if rises.size else []
    low, high = 0, N_ANGLES // 4  # grid points over which the rest changes by too little, by enough
    if change(high) >= depth > 0.0:
        while high - low > 1:
            middle = (low + high) // 2
            low, high = (low, middle) if change(middle) >= depth else (middle, high)
        steepest.append(high * grid / change(high))
    return FLANK * met * min(steepest, default=math.inf)


def highest(
    n_bumps: int, height: float, profile: Profile = NO_PROFILE, width: float = BUMP_WIDTH
) -> float:
    """Largest height of a casing [m]; arguments as of `casing_height`."""
    return outline(n_bumps, height, profile, width).highest if profile.exists else height


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
    width: float = BUMP_WIDTH,
) -> np.ndarray:
    """Heights of the casing that every contact point meets in the first steps of a revolution.

    - contact_angle: (C,) angles of the contact points in the rotating frame [rad].
    - n_bumps, height, profile, width: of the casing, as of `casing_height`.
    - steps_per_revolution: time steps in which the disk turns once.
    - n_steps: rows of the table.

    Returns heights (n_steps, C) [m]; row j holds the heights after j + 1 steps.
    """
    rotation = (np.arange(n_steps) + 1.0) * (2.0 * np.pi / steps_per_revolution)
    phi = rotation[:, None] + contact_angle[None, :]
    return casing_height(phi, n_bumps, height, profile, width)


def ramp(t: float, ramp_time: float) -> float:
    """Bump ramp s(t), the factor of all heights: 0 until t = 0, 1 from ``ramp_time`` [s] on."""
    if t <= 0.0:
        return 0.0
    if t >= ramp_time:
        return 1.0
    return (1.0 - math.exp(-5.0 * t / ramp_time)) / (1.0 - math.exp(-5.0))
