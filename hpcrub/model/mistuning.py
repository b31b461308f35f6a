"""Stiffness deviation of every blade: random draws that depend on nothing but their place."""

import numpy as np

STIFFNESS, START = range(2)  # streams: what is drawn


def stiffness_deviation(
    seed: int, level: int, sample: int, n_blades: int, half_range: float
) -> np.ndarray:
    """Uniform stiffness deviations of the blades of one sample.

    Parameters
    ----------
    seed : int
        0 ... 2^128 - 1.
    level, sample : int
        0 ... 2^64 - 1, their place in the study.
    n_blades : int
        Number N of blades.
    half_range : float
        Largest deviation [-].

    Returns
    -------
    ndarray (N,)
        Deviations in [-half_range, half_range) [-].

    Notes
    -----
    Joachim, Nyssen, Batailly (2020), equations (3) and (4).
    """
    return half_range * uniform(seed, STIFFNESS, level, sample, n_blades)


def uniform(seed: int, stream: int, level: int, sample: int, n: int) -> np.ndarray:
    """Random numbers in [-1, 1), (n,) [-].

    The seed, 0 ... 2^128 - 1, is the key of a Philox 4x64 generator; stream, sample and level,
    0 ... 2^64 - 1 each, are the upper words of its counter, so that no two places ever share a
    draw. Raw bits are used because numpy promises to keep them from version to version, and not
    its distributions.
    """
    key = [seed % 2**64, seed >> 64]
    counter = [0, stream, sample, level]
    bits = np.random.Philox(key=_words(key), counter=_words(counter)).random_raw(n)
    unit = (bits >> np.uint64(11)) * 2.0**-53  # the 53 upper bits, in [0, 1)
    return 2 * unit - 1


def _words(values):
    return np.array(values, dtype=np.uint64)
