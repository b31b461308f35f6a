"""Stiffness deviation of every blade: random draws that depend on nothing but their place."""

import numpy as np

STIFFNESS, START = range(2)  # streams: what is drawn


def stiffness_deviation(seed, level, sample, n_blades, half_range):
    """Uniform stiffness deviations of the blades of one sample.

    seed: 0 ... 2^128 - 1; level, sample: 0 ... 2^64 - 1, their place in the study; n_blades;
    half_range: largest deviation [-].
    Returns deviations in [-half_range, half_range), (n_blades,) [-].
    Source: Joachim, Nyssen, Batailly 2020, equations (3) and (4).
    """
    return half_range * uniform(seed, STIFFNESS, level, sample, n_blades)


def uniform(seed, stream, level, sample, n):
    """Random numbers in [-1, 1), (n,) [-].

    seed: 0 ... 2^128 - 1; stream, level, sample: 0 ... 2^64 - 1, the place of the draw.

    The seed is the key of a Philox 4x64 generator; stream, sample and level are the upper words of
    its counter, so that no two places ever share a draw. Raw bits are used because numpy promises
    to decay them from version to version, and not its distributions.
    """
    key = [seed % 2**64, seed >> 64]
    counter = [0, stream, sample, level]
    bits = np.random.Philox(key=_words(key), counter=_words(counter)).random_raw(n)
    unit = (bits >> np.uint64(11)) * 2.0**-53  # the 53 upper bits, in [0, 1)
    return 2 * unit - 1


def _words(values):
    return np.array(values, dtype=np.uint64)
