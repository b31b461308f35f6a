"""Modes of an elastic casing, from the sections of an input."""

from typing import Any

import numpy as np

from hpcrub.config.casing import MOST_WAVES
from hpcrub.config.schema import Config
from hpcrub.errors import InputError
from hpcrub.model.casing_modes import CasingModes, Ring, ring_modes

STEPS_PER_WAVE = 16  # least time steps while a wave of the casing passes a blade


def casing_modes_of(config: Config) -> CasingModes | None:
    """Modes of the casing; None if rigid. Raises InputError for waves that cannot be followed."""
    casing = config.casing
    if not casing.vibrates:
        return None
    modes = _of_ring(config) if casing.ring.thickness_mm is not None else _of_table(casing.modes)
    most, needed = int(modes.n_waves.max()), 1.0 / (config.speeds.to_hz * config.step)
    if needed < STEPS_PER_WAVE * most:
        raise InputError(
            f"casing.{'modes' if casing.modes else 'ring.waves'}: n = {most} passes a blade within "
            f"{needed / most:.3g} time steps, fewer than {STEPS_PER_WAVE}; leave it out, or give "
            f"time.step_s of {1.0 / (config.speeds.to_hz * STEPS_PER_WAVE * most):.2g}"
        )
    return modes


def overtaken(config: Config, casing: CasingModes) -> tuple[np.ndarray, np.ndarray]:
    """Waves n (J,) that the rotor overtakes: those that are followed, and of a ring all others."""
    highest, ring = 2.0 * np.pi * config.speeds.to_hz, config.casing.ring
    of_all = casing.n_waves[casing.critical_speeds < highest]
    if ring.thickness_mm is None:
        return of_all, of_all[:0]
    is_held = ring.bed_radial_n_per_m2 > 0.0 or ring.bed_tangential_n_per_m2 > 0.0
    others = np.setdiff1d(np.arange(1 if is_held else 2, MOST_WAVES + 1), casing.n_waves)
    modes = ring_modes(_elastic(config), others, 0.0)
    return of_all, others[modes.critical_speeds < highest]


def _elastic(config: Any) -> Any:
    ring, tips = config.casing.ring, config.disk.tip_radius_mm
    radius = tips + ring.thickness_mm / 2.0 if ring.radius_mm is None else ring.radius_mm
    if radius + ring.thickness_mm / 2.0 < tips:
        raise InputError(
            f"casing.ring.radius_mm: a ring of {radius:g} mm lies inside the blade tips, which "
            f"have a radius of {tips:g} mm; null stands at the tips"
        )
    section = radius / 1000, ring.thickness_mm / 1000, ring.width
    bed = ring.bed_radial_n_per_m2, ring.bed_tangential_n_per_m2
    return Ring(*section, ring.young_modulus, ring.density_kg_m3, *bed)


def _of_ring(config: Any) -> CasingModes:
    ring, elastic = config.casing.ring, _elastic(config)
    try:
        return ring_modes(elastic, np.array(sorted(ring.waves)), ring.damping_ratio)
    except ValueError as error:
        raise InputError(
            f"casing.ring.waves: {error} in a ring of {ring.thickness_mm:g} mm on a bed of "
            f"{elastic.bed_radial:g} N/m²; leave it out, or give more "
            "casing.ring.bed_radial_n_per_m2"
        ) from None


def _of_table(pairs: Any) -> Any:
    n, frequency, mass, ratio, damping = np.array(
        sorted(tuple(pair.model_dump().values()) for pair in pairs)
    ).T
    if len(wrong := ratio[(n == 0) & (ratio != 0.0)]):
        raise InputError(
            f"casing.modes: tangential_ratio of {wrong[0]:g} at n = 0, where the casing moves "
            "outward alone; 0 is allowed"
        )
    radial = 1.0 / np.sqrt(mass)
    return CasingModes(n.astype(int), 2.0 * np.pi * frequency, damping, radial, ratio * radial)
