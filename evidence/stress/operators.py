"""Whether a disk whose contact forces are called flawed, or sound, is: by its principal minors.

A linear complementarity problem has one solution for every penetration if and only if all principal
minors of its matrix are positive. Here they are all computed, as determinants.
"""

import itertools

import numpy as np

from hpcrub.contact import status
from hpcrub.contact.recurrence import coefficients
from hpcrub.contact.status import DIVERGED
from hpcrub.response.sweep import cut_revolution

MOST_POINTS = 14  # up to which all minors are looked at
SOUND_EVERY = 8  # cases of which one sound point is looked at
ROUND_OFF = 1e-12  # of a minor of a matrix whose diagonal is 1
ANGLES = np.linspace(0.0, 2.0 * np.pi, 720, endpoint=False)  # [rad] of normals


def operator(modes, scene, speed, grid):
    """Motions by forces in one step, radial and tangential each (2, 2, n, n) [m/N]."""
    h = 1.0 / (speed * grid.steps_per_revolution)
    _, push = coefficients(scene.scheme, modes.omega, scene.damping_ratio, h)
    parts = modes.normal, modes.tangential
    return np.array([[(to * push) @ by.T for by in parts] for to in parts])


def smallest_minor(W):
    """Smallest principal minor of W (n, n), its columns divided by the diagonal if positive."""
    diagonal, n = np.diag(W), len(W)
    if not diagonal.min() > 0.0:
        return diagonal.min() / np.abs(diagonal).max()
    scaled, smallest = W / diagonal, 1.0
    for size in range(2, n + 1):
        rows = np.array(list(itertools.combinations(range(n), size)))
        smallest = min(smallest, np.linalg.det(scaled[rows[:, :, None], rows[:, None, :]]).min())
    return smallest


def smallest_own(own, friction):
    """Smallest normal motion of a tip by its own force over all normals; own: (2, 2, n) [m/N]."""
    c, s = np.cos(ANGLES), np.sin(ANGLES)
    force = np.array([c - friction * s, s + friction * c])
    return np.einsum("aq,abi,bq->qi", np.array([c, s]), own, force).min()


def judge(case, modes, scene, speeds, result):
    """Look again at the points that are called flawed, and at one in many of the sound ones.

    Returns the number of points looked at, and faults.
    """
    grid, seen, faults = cut_revolution(speeds.min(), scene), 0, []
    sound = np.flatnonzero((result.point_status != DIVERGED) & (result.point_reason == status.NONE))
    asked = sound[:1] if case.number % SOUND_EVERY == 0 else sound[:0]
    called = (status.JAMMING, status.NOT_UNIQUE)
    for i in (*np.flatnonzero(np.isin(result.point_reason, called)), *asked):
        reason, W = result.point_reason[i], operator(modes, scene, speeds[i], grid)
        if scene.kinematics == "polar":
            if reason == status.NONE:
                continue  # the normals that it had are not known
            flawed = smallest_own(np.einsum("abii->abi", W), scene.friction) <= 0.0
        elif reason == status.JAMMING:
            flawed = not np.diag(W[0, 0] + scene.friction * W[0, 1]).min() > 0.0
        elif len(modes.normal) <= MOST_POINTS:
            smallest = smallest_minor(W[0, 0] + scene.friction * W[0, 1])
            flawed = smallest <= (-ROUND_OFF if reason == status.NONE else ROUND_OFF)
        else:
            continue
        seen += 1
        if flawed != (reason != status.NONE):
            faults.append(f"{status.WORDS[reason]}, against its principal minors")
    return seen, faults
