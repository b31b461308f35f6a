"""How long a time step may be for bumps and blades to be resolved, from the input alone.

All functions take the `Config` of which they are a part.
"""

import math
from typing import Any

# a crest of the slope S and the curvature κ of a Gaussian bump is as wide, FLANK S/κ
FLANK = 4.0 / math.sqrt(2.0 / math.e)
# of the height of a casing above its mean: what the step resolves, at least, where the clearance
# changes with the speed; speeds at which blades meet less are marked (`setup.plausibility`)
LEAST = 0.05
CLAMPED = 3.516  # first eigenvalue of a clamped beam, squared: omega = 3.516 sqrt(EI / rho A) / l^2
RECORDS_PER_PERIOD = 20  # of the displacements that windows are compared by; peaks are of all steps


def width_of_bump(config: Any, least: float = LEAST) -> float:
    """Angle of the narrowest crest of a casing that blades meet [rad].

    A Gaussian bump as sharp as the sharpest crest is taken, wherever that is: blades that vibrate
    reach everything. Its width is that of its height and curvature at the level of the clearance,
    or its 1/e width by the steepest slope of the casing, where that is less: a crest that is passed
    in so many steps gives blades the velocity of its flank to a share of the largest they get.

    Zero when nothing reaches the tips; a load during contact may bring them to any bump. Where the
    clearance changes with the speed, it is the narrowest of all speeds.

    least: part of the height of a casing above its mean that blades meet then, at least.
    """
    outline, clearance = config.casing.outline, _clearance(config, least)
    if config.forcing.in_contact:
        clearance = min(clearance, 0.0)
    if outline.highest <= clearance:
        return 0.0
    if outline.curvature <= 0.0:
        return 2.0 * math.pi
    height, level = outline.highest - outline.lowest, clearance - outline.lowest
    width = FLANK * outline.slope / outline.curvature
    if level > 0.0:
        across = 2.0 * math.sqrt(2.0 * height / outline.curvature)
        width = min(width, across * math.sqrt(math.log(height / level)))
    return min(width, 2.0 * math.pi)


def _clearance(config: Any, least: float) -> float:
    """Clearance of the nearest tip, the largest at any speed that brings it to the casing [m]."""
    casing, own = config.casing, min(config.casing.blade_clearance_mm or (0.0,)) / 1000
    nearest = config.disk.least_clearance + own
    if casing.running is None:
        return casing.clearance_mm / 1000 + nearest
    found = casing.clearances(config.speeds.values_hz) + nearest
    top, mean = casing.outline.highest, casing.outline.mean
    touching = found[found < top]
    return min(touching.max(), top - least * (top - mean)) if touching.size else found.min()


def bump_time(config: Any, least: float = LEAST) -> float:
    """Time in which a tip passes the width of a bump at the highest speed [s]; inf: no contact.

    least: as of `width_of_bump`.
    """
    width = width_of_bump(config, least)
    return width / (2.0 * math.pi * config.speeds.to_hz) if width > 0.0 else math.inf


def least_steps(config: Any) -> float:
    """Steps of a revolution that bumps need, at any speed."""
    width = width_of_bump(config)
    return config.time.steps_per_bump_width * 2.0 * math.pi / width if width > 0.0 else 0.0


def blade_period(config: Any) -> float:
    """Period of the first bending mode of a blade clamped at the ring [s], about.

    Of a model file: of its first family; infinite before it has been looked at.
    """
    if config.disk.model is not None:
        family = config.disk.first_family_hz
        return 1.0 / family if family else math.inf
    length = config.disk.tip_radius - config.disk.hub_radius
    wave_speed = math.sqrt(config.material.young_modulus / config.material.density)
    slenderness = math.sqrt(12.0) * length**2 / config.disk.blade.thickness
    return 2.0 * math.pi / CLAMPED * slenderness / wave_speed


def longest_step(config: Any) -> float:
    """Longest time step at any speed [s]: `time.step_s`, or less where blades need it."""
    return min(config.time.step_s, blade_period(config) / config.time.steps_per_period)


def record_interval(config: Any, usual: float) -> float:
    """Longest time between two recorded displacements [s]; `usual`: what most disks need."""
    return min(usual, blade_period(config) / RECORDS_PER_PERIOD)
