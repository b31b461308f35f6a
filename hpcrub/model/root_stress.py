"""Bending stress at the root of a planar blade, in closed form."""

import math
from typing import Any

CLAMPED = 3.516  # first eigenvalue of a clamped beam, squared


def root_stress(disk: Any, material: Any) -> float:
    """Largest bending stress at the root for a tangential displacement of the tip [Pa/m].

    The blade bends in the first mode of a clamped beam of length l, whose curvature at the root is
    3.516/l² times its displacement w at the end, and the stress E t/2 times the curvature. The tip
    moves across the chord, so that w is its tangential part over the cosine of the chord's angle
    with the radius there. Centrifugal stress is not in it.

    disk, material: sections of the configuration.
    """
    at_root = disk.hub_radius * math.cos(disk.blade.lean)
    across = disk.hub_radius * math.sin(disk.blade.lean)  # distance of the chord from the axis
    length = math.sqrt(disk.tip_radius**2 - across**2) - at_root
    cosine = math.sqrt(1.0 - (across / disk.tip_radius) ** 2)
    stress = material.young_modulus * disk.blade.thickness / 2.0 * CLAMPED / length**2
    return float(stress / cosine)
