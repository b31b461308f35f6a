"""Stiffness deviations of the blades: each random number depends on its place alone."""

from typing import Any, NamedTuple

import numpy as np
from scipy.special import gammainc, ndtr, ndtri

STIFFNESS, START, RUNS = 0, 1, 3  # streams of random numbers, one for each use


class Law(NamedTuple):
    """Distribution of the blades' deviations within the half range of a level."""

    distribution: str = "uniform"  # normal: truncated; measured: drawn from a list
    truncation: float = 3.0  # half range of a normal distribution, in standard deviations
    measured: tuple[float, ...] = ()  # deviations of real blades, scaled to the half range
    neighbour_correlation: float = 0.0  # correlation of the normal scores of two neighbours
    intentional: tuple[float, ...] = ()  # pattern [-], repeated, under the random deviations

    @property
    def sigma(self) -> float:
        """Standard deviation of the random part over the half range [-]."""
        if self.distribution == "measured":
            return float(np.std(self.measured) / np.abs(self.measured).max())
        if self.distribution == "normal":
            t = self.truncation  # the integrals of x² and of 1, weighted by exp(-x²/2)
            return float(np.sqrt(gammainc(1.5, t**2 / 2.0) / gammainc(0.5, t**2 / 2.0)) / t)
        return float(1.0 / np.sqrt(3.0))

    def deviation(self, drawn: np.ndarray, half_range: float) -> np.ndarray:
        """Deviations (N,) [-] from random numbers (N,) that are uniform in [-1, 1)."""
        if self.neighbour_correlation:
            drawn = correlated(drawn, self.neighbour_correlation)
        random = half_range * self._quantile(drawn)
        if not self.intentional:
            return random
        return random + np.resize(self.intentional, len(random))

    def _quantile(self, drawn: Any) -> Any:
        """Values of this distribution in [-1, 1], from uniform random numbers."""
        if self.distribution == "normal":
            low = ndtr(-self.truncation)
            return ndtri(low + (drawn + 1.0) / 2.0 * (1.0 - 2.0 * low)) / self.truncation
        if self.distribution == "measured":
            values = np.array(self.measured) / np.abs(self.measured).max()
            return values[((drawn + 1.0) / 2.0 * len(values)).astype(int)]
        return drawn


UNIFORM = Law()


def correlated(drawn: np.ndarray, correlation: float) -> np.ndarray:
    """Uniform numbers whose normal scores are correlated around the disk.

    - drawn: (N,) independent numbers in [-1, 1), one for each blade.
    - correlation: of two neighbours, 0 or more; k blades apart it is the k-th power of this.

    Returns (N,), in (-1, 1).
    """
    n = len(drawn)
    apart = np.minimum(np.arange(n), n - np.arange(n))
    spectrum = np.fft.rfft(correlation**apart).real  # eigenvalues of a circulant matrix
    scores = ndtri((drawn + 1.0) / 2.0 + 2.0**-55)  # ndtri is infinite at zero
    mixed = np.fft.irfft(np.fft.rfft(scores) * np.sqrt(np.maximum(spectrum, 0.0)), n)
    return np.clip(2.0 * ndtr(mixed) - 1.0, -1.0, np.nextafter(1.0, 0.0))


def stiffness_deviation(
    seed: int, level: int, sample: int, n_blades: int, half_range: float, law: Law = UNIFORM
) -> np.ndarray:
    """Random stiffness deviations of the blades of one sample.

    - seed, level, sample: place of the draw, as in `uniform`.
    - half_range: largest deviation [-].
    - law: distribution of the deviations, uniform by default.

    Returns (N,); deviations in [-half_range, half_range), plus the intentional pattern [-].
    Source: Joachim, Nyssen, Batailly (2020), equations (3) and (4).
    """
    return law.deviation(uniform(seed, STIFFNESS, level, sample, n_blades), half_range)


def uniform(seed: int, stream: int, level: int, sample: int, n: int) -> np.ndarray:
    """Random numbers in [-1, 1), (n,) [-].

    The seed, 0 ... 2^128 - 1, is the key of a Philox 4x64 generator; stream, sample and level,
    0 ... 2^64 - 1 each, are the upper words of its counter, so that no two places ever share a
    draw. The function takes raw bits because numpy promises to keep these from version to version,
    but not its distributions.
    """
    key = np.array([seed % 2**64, seed >> 64], dtype=np.uint64)
    counter = np.array([0, stream, sample, level], dtype=np.uint64)
    bits = np.random.Philox(key=key, counter=counter).random_raw(n)
    unit = (bits >> np.uint64(11)) * 2.0**-53  # the 53 upper bits, in [0, 1)
    return 2 * unit - 1
