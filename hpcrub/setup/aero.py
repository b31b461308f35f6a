"""Air forces of an input on a family of the reduced model."""

import numpy as np

from hpcrub.config.schema import Config
from hpcrub.errors import InputError
from hpcrub.model import aero
from hpcrub.model.imported import cyclic
from hpcrub.model.reduction import ReducedModel


def curve_of(config: Config) -> aero.Curve:
    """Damping ratio and frequency shift of every wave, given or from influence coefficients."""
    given, n_blades = config.aero, config.disk.n_blades
    if not given.influence:
        return aero.Curve(given.family - 1, *given.table(n_blades))
    rows = [(row.blades, row.damping_ratio, row.frequency_shift) for row in given.influence]
    return aero.Curve(given.family - 1, *aero.of_influence(n_blades, *np.array(rows).T))


def air_of(config: Config, reduced: ReducedModel) -> aero.Air | None:
    """Air forces on the tuned disk; None without air. Raises InputError for a missing family."""
    if not config.aero.exists:
        return None
    blades, angle = cyclic.tuned_tips(reduced)
    forward = blades[:, np.argsort(angle % (2.0 * np.pi))]
    diameters = cyclic.tuned_diameters(reduced)
    try:
        return aero.air_of(curve_of(config), reduced.tuned_eigenvalues, diameters, forward)
    except ValueError as error:
        raise InputError(f"aero.family: {error}") from None
