"""Air forces of an input on a family of the reduced model."""

import numpy as np

from hpcrub.config.schema import Config
from hpcrub.errors import InputError
from hpcrub.model import aero
from hpcrub.model.imported import cyclic
from hpcrub.model.reduction import ReducedModel, mistuned_modes, powers


def curve_of(config: Config) -> aero.Curve:
    """Damping ratio and frequency shift of every wave, given or from influence coefficients."""
    given, n_blades = config.aero, config.disk.n_blades
    if not given.influence:
        return aero.Curve(given.family - 1, *given.table(n_blades))
    rows = [(row.blades, row.damping_ratio, row.frequency_shift) for row in given.influence]
    return aero.Curve(given.family - 1, *aero.of_influence(n_blades, *np.array(rows).T))


def in_air(config: Config, reduced: ReducedModel, speed: float | None = None) -> ReducedModel:
    """The tuned disk with the air forces of an input, if any.

    speed: of rotation, of which the shapes are on which the air acts [rad/s]; None: that of the
    reduced model.
    Raises InputError for a missing family.
    """
    if not config.aero.exists:
        return reduced
    tuned = mistuned_modes(reduced._replace(air=None), np.zeros(config.disk.n_blades), speed)
    blades, angle = cyclic.tips(tuned, reduced.interface)
    diameters = cyclic.nodal_diameters(blades, angle)
    forward = blades[:, np.argsort(angle % (2.0 * np.pi))]
    try:
        air = aero.air_of(curve_of(config), tuned.omega**2, diameters, forward)
    except ValueError as error:
        raise InputError(f"aero.family: {error}") from None
    waves = reduced.tuned_modes.T @ reduced.mass @ tuned.shapes @ air.waves
    slopes = [np.einsum("mr,mr->r", waves.conj(), K @ waves).real for K in reduced.stiffening]
    air = air._replace(waves=waves, stiffening=np.array(slopes).reshape(-1, config.disk.n_blades))
    return reduced._replace(air=air.at(-powers(tuned.speed, reduced.speed)))
