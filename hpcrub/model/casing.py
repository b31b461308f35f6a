"""The rigid casing: its shape over the circumference and the ramp at the start of a run.

Heights are inward. Angles run around the casing in the direction of rotation, and start where the
angle zero of the disk is at the start of a run.
"""

import math
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

BUMP_WIDTH = 0.1  # distance from the crest where a bump has 1/e of its height [pitches]
N_ANGLES = 2**14  # angles at which spectra are computed
MOST_ANGLES = 2**17
FINER = 16  # angles per cut-off wavelength of smoothed points, at least
ORDER = 4  # exponent of the spline filter
RELEVANT = 0.01  # amplitude of a relevant order, over the largest of any order
FEWEST_POINTS = 50  # measured points, below which a shape is not told from noise
ALTERNATES = -0.3  # correlation of neighbours below which measured points are noisy
ACROSS = np.union1d(np.linspace(-3.0, 3.0, 49), (-math.sqrt(0.5), 0.0, math.sqrt(0.5)))


class Profile(NamedTuple):
    """Inward deformation of the casing beside its bumps: harmonics plus measured points."""

    # order n [-], amplitude a [m], angle of a crest b [rad] of each: a cos(n(phi - b))
    harmonics: tuple[tuple[int, float, float], ...] = ()
    # angle, increasing within one turn [rad], and height [m] of each point
    measured: tuple[tuple[float, float], ...] = ()
    cut_off: float = 0.0  # wavelength that smoothing reduces to one half [rad]; 0: no smoothing

    def height(self, phi: np.ndarray, derivative: int = 0) -> np.ndarray:
        """Height [m] at angles [rad] of any shape, or its first or second derivative there."""
        total = np.zeros(np.shape(phi))
        for order, amplitude, crest in self.harmonics:
            turned = order * (phi - crest) + derivative * np.pi / 2.0
            total += amplitude * order**derivative * np.cos(turned)
        if self.measured:
            angle, *curves = smoothed(self.measured, self.cut_off)
            total += np.interp(phi, angle, curves[derivative], period=2.0 * np.pi)
        return total

    @property
    def exists(self) -> bool:
        """Whether the profile has any harmonic or point."""
        return bool(self.harmonics or self.measured)


class Outline(NamedTuple):
    """Measures of a casing's shape that loads and time steps depend on."""

    highest: float  # [m]
    lowest: float  # [m], 0 at most
    mean: float  # [m]
    slope: float  # largest, either way [m/rad]
    curvature: float  # of the sharpest crest [m/rad²]
    orders: tuple[int, ...]  # relevant orders, the strongest first; () for a circle
    smoothed_away: float  # largest change of the measured profile by smoothing [m]


@lru_cache(maxsize=16)
def smoothed(measured: tuple[tuple[float, float], ...], cut_off: float) -> np.ndarray:
    """Measured points of a casing, smoothed.

    - measured: points as in `Profile`.
    - cut_off: wavelength that is reduced to one half [rad]; 0: lines between the points.

    Returns (4, n): angles [rad], height [m], slope [m/rad] and second derivative [m/rad²]; without
    smoothing the mean slope at each point, and its change over the shorter of the adjacent lines.
    Source: ISO 16610-22, the periodic spline filter, which reduces an order n by 1/(1 + (n/n_c)⁴).
    """
    angle, height = np.array(measured).T
    if cut_off == 0.0:
        distance = np.diff(angle, append=angle[0] + 2.0 * np.pi)
        slope = np.diff(height, append=height[0]) / distance
        before, shorter = np.roll(slope, 1), np.minimum(distance, np.roll(distance, 1))
        return np.array([angle, height, 0.5 * (slope + before), (slope - before) / shorter])
    finest = 2.0 * np.pi * FINER / cut_off
    n = min(max(N_ANGLES, 2 ** math.ceil(math.log2(finest))), MOST_ANGLES)
    grid = 2.0 * np.pi * np.arange(n) / n
    spectrum = np.fft.rfft(np.interp(grid, angle, height, period=2.0 * np.pi))
    order = np.arange(len(spectrum))
    spectrum /= 1.0 + (order * cut_off / (2.0 * np.pi)) ** ORDER
    rows = [np.fft.irfft((1j * order) ** k * spectrum, n) for k in range(3)]
    return np.array([grid, *rows])


def noise_left(profile: Profile) -> float:
    """Noise that smoothing leaves in measured points: rms slope over that of the smoothed points.

    Points with noise of variance v stand out of the line between their neighbours by 1.5 v, in
    turns: the correlation of neighbours is then -2/3, and 1 for a shape. 0 where they do not, or
    where points are too few to tell. The noise has 2 v/n in each order, of which the filter leaves
    a part; points are taken for evenly spaced.
    """
    angle, height = np.array(profile.measured).reshape(-1, 2).T
    if len(angle) < FEWEST_POINTS:
        return 0.0
    after = np.diff(angle, append=angle[0] + 2.0 * np.pi)
    before = np.roll(after, 1)
    line = (np.roll(height, 1) * after + np.roll(height, -1) * before) / (before + after)
    noise = height - line
    if not (noise * np.roll(noise, 1)).sum() < ALTERNATES * (noise * noise).sum():
        return 0.0
    n, order = len(angle), np.arange(1.0, len(angle) // 2 + 1)
    kept = order * np.sinc(order / n) ** 2  # of the lines between points
    kept /= 1.0 + (order * profile.cut_off / (2.0 * np.pi)) ** ORDER
    left = (noise * noise).mean() / 1.5 * 2.0 / n * (kept * kept).sum()
    return math.sqrt(left / np.square(smoothed(profile.measured, profile.cut_off)[2]).mean())


def bump_height(
    phi: np.ndarray, n_bumps: int, height: float, width: float = BUMP_WIDTH
) -> np.ndarray:
    """Height of n_d evenly spaced bumps [m], inward, at angles from the crest of any bump [rad].

    - height: of a bump, c_rd [m].
    - width: distance from its crest at which a bump has 1/e of its height, in pitches [-].

    Source: Joachim, Nyssen, Batailly (2020), equation (1).
    """
    pitch = 2.0 * np.pi / n_bumps
    return height * np.exp(-((_from_crest(phi, pitch) / (width * pitch)) ** 2))


def _from_crest(phi: Any, pitch: Any) -> Any:
    return phi - pitch * np.round(phi / pitch)


class CasingShape(NamedTuple):
    """The shape of a casing over the circumference: n_d even bumps, and a profile."""

    n_bumps: int
    bump_height: float  # [m]
    profile: Profile = Profile()
    bump_width: float = BUMP_WIDTH  # from the crest to 1/e of a bump's height [pitches]

    def height(self, phi: np.ndarray) -> np.ndarray:
        """Height [m] of bumps and profile together, at angles from a bump, of any shape."""
        bumps = bump_height(phi, self.n_bumps, self.bump_height, self.bump_width)
        return bumps + self.profile.height(phi) if self.profile.exists else bumps

    @property
    def highest(self) -> float:
        """Largest height [m]."""
        return outline(self).highest if self.profile.exists else self.bump_height

    @property
    def repeats(self) -> int:
        """Number of periods of the shape in a turn."""
        if not self.profile.exists:
            return self.n_bumps
        if self.profile.measured:
            return 1
        orders = (order for order, *_ in self.profile.harmonics)
        return math.gcd(self.n_bumps if self.bump_height > 0.0 else 0, *orders)

    def gap(
        self, clearance: npt.ArrayLike, time: npt.ArrayLike, ramp_time: float, angle: npt.ArrayLike,
        outward: npt.ArrayLike = 0.0,
    ) -> np.ndarray:  # fmt: skip
        """Gap [m] between points and the casing, clearance − s h − outward motion.

        clearance: of the points at rest without the shape [m]; time: since the shape began to grow
        [s], for ``ramp_time`` [s]; angle: of the points on the casing [rad]; outward: displacement
        of the points [m]. All have shapes that go together. `contact.passes.begin_gaps` is its
        twin in the kernel.
        """
        grown = np.vectorize(ramp, otypes=[float])(time, ramp_time)
        return clearance - grown * self.height(np.asarray(angle)) - outward

    def table(self, angle: np.ndarray, steps_per_revolution: int, n_steps: int) -> np.ndarray:
        """Heights (n_steps, C) [m] after each step, at points (C,) [rad] of the rotating frame."""
        rotation = (np.arange(n_steps) + 1.0) * (2.0 * np.pi / steps_per_revolution)
        return self.height(rotation[:, None] + angle[None, :])


@lru_cache(maxsize=16)
def outline(shape: CasingShape) -> Outline:
    """Outline of a casing: bumps, harmonics and smoothed points together.

    Slope and curvature are sampled at evenly spaced angles, across every bump and at every measured
    point. For Gaussian bumps the relevant orders are the first six multiples of their number.
    """
    n_bumps, height, profile, width = shape
    around = 2.0 * np.pi * np.arange(N_ANGLES) / N_ANGLES
    own = width * 2.0 * np.pi / n_bumps  # 1/e width of a bump [rad]
    crests = np.arange(n_bumps if height > 0.0 else 0) * (2.0 * np.pi / n_bumps)
    measured = np.array(profile.measured).reshape(-1, 2)
    phi = np.concatenate([around, (crests[:, None] + own * ACROSS).ravel(), measured[:, 0]])
    off = _from_crest(phi, 2.0 * np.pi / n_bumps) / own
    bumps = np.array([off**0, -2.0 * off / own, (4.0 * off**2 - 2.0) / own**2])
    bumps *= height * np.exp(-(off**2))
    there, slope, second = bumps + [profile.height(phi, k) for k in range(3)]
    spectrum = np.fft.rfft(there[:N_ANGLES])
    mean, spectrum[0] = spectrum[0].real / N_ANGLES, 0.0
    size = 2.0 * np.abs(spectrum) / N_ANGLES
    size[size < 1e-12 * np.abs(there).max()] = 0.0  # rounding
    orders = np.flatnonzero((size > 0.0) & (size >= RELEVANT * size.max()))
    strongest = tuple(orders[np.argsort(-size[orders], kind="stable")].tolist())
    lines = profile._replace(harmonics=(), cut_off=0.0).height(phi)
    away = np.abs(lines - profile._replace(harmonics=()).height(phi)).max()
    highest, lowest = float(there.max()), min(0.0, float(there.min()))
    steepest, sharpest = float(np.abs(slope).max()), float(-second.min())
    return Outline(highest, lowest, float(mean), steepest, sharpest, strongest, float(away))


def ramp(t: float, ramp_time: float) -> float:
    """Bump ramp s(t), the factor of all heights: 0 until t = 0, 1 from ``ramp_time`` [s] on."""
    if t <= 0.0:
        return 0.0
    if t >= ramp_time:
        return 1.0
    return (1.0 - math.exp(-5.0 * t / ramp_time)) / (1.0 - math.exp(-5.0))
