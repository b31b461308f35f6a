"""Time steps that resolve bumps and blades, computed from the input alone.

All functions take a `Config`, whose module imports this one.
"""

import math
from typing import Any

# a Gaussian bump of steepest slope S and curvature κ at the crest has the 1/e width FLANK S/κ
FLANK = 4.0 / math.sqrt(2.0 / math.e)
# Share of the casing's height above its mean that the step resolves at least, if the clearance
# changes with the speed. `setup.plausibility` warns where blades meet less of the casing.
LEAST_HEIGHT = 0.05
CLAMPED = 3.516  # first eigenvalue of a clamped beam, squared: omega = 3.516 sqrt(EI / rho A) / l^2
RECORDS_PER_PERIOD = 20  # records for comparing windows
# The largest of so many displacements a period is at most 0.05 % below the largest of all steps, by
# 1 − cos(π/100), as far as the first family alone vibrates.
LOOKS_PER_PERIOD = 100


def width_of_bump(config: Any, least: float = LEAST_HEIGHT) -> float:
    """Angle of the narrowest crest of a casing that blades meet [rad].

    It is the width, at the level of the clearance, of a Gaussian bump with the casing's height and
    largest curvature; vibrating blades reach the sharpest crest wherever it is. The 1/e width of a
    bump with this curvature and the casing's steepest slope counts instead, if it is smaller: steps
    that resolve this width resolve the velocity that the flank gives to blades.

    The angle is 0 if no tip reaches the casing. A load during contact may bring tips to any bump.
    If the clearance changes with the speed, the narrowest width at any speed counts.

    least: smallest part of the casing's height above its mean that blades are taken to meet then.
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
    """Largest clearance of the nearest tip at the speeds at which it touches the casing [m]."""
    casing, own = config.casing, min(config.casing.blade_clearance_mm or (0.0,)) / 1000
    nearest = config.disk.least_clearance + own
    if casing.running is None:
        return float(casing.clearances(0.0)) + nearest
    gaps = casing.clearances(config.speeds.values_hz) + nearest
    top, mean = casing.outline.highest, casing.outline.mean
    touching = gaps[gaps < top]
    return min(touching.max(), top - least * (top - mean)) if touching.size else gaps.min()


def bump_time(config: Any, least: float = LEAST_HEIGHT) -> float:
    """Time in which a tip passes a bump at the highest speed [s]; infinite without contact.

    least: see `width_of_bump`.
    """
    width = width_of_bump(config, least)
    return width / (2.0 * math.pi * config.speeds.to_hz) if width > 0.0 else math.inf


def least_steps(config: Any) -> float:
    """Time steps per revolution that bumps need, at any speed."""
    width = width_of_bump(config)
    return config.time.steps_per_bump_width * 2.0 * math.pi / width if width > 0.0 else 0.0


def blade_period(config: Any) -> float:
    """Approximate period of the first bending mode of a blade clamped at the ring [s].

    For a model file it is the period of the first family, infinite before the file has been read.
    """
    if config.disk.model is not None:
        family = config.disk.first_family_hz
        return 1.0 / family if family else math.inf
    length = config.disk.tip_radius - config.disk.hub_radius
    wave_speed = math.sqrt(config.material.young_modulus / config.material.density)
    slenderness = math.sqrt(12.0) * length**2 / config.disk.blade.thickness
    return 2.0 * math.pi / CLAMPED * slenderness / wave_speed


def longest_step(config: Any) -> float:
    """Longest time step at any speed [s]: `time.step_s`, or less if blades need it."""
    return min(config.time.step_s, blade_period(config) / config.time.steps_per_period)


def record_interval(config: Any, usual: float) -> float:
    """Longest time between two recorded displacements [s]; `usual`: for most disks."""
    return min(usual, blade_period(config) / RECORDS_PER_PERIOD)


def look_interval(config: Any) -> float:
    """Longest time between two displacements of which the largest counts [s].

    0, every step, in three dimensions: steps are short, and more than one family moves the tips.
    """
    return 0.0 if config.disk.n_directions == 3 else blade_period(config) / LOOKS_PER_PERIOD
