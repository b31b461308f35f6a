"""The physical effects that an input may have, one module each; how to add one: `effect`."""

from hpcrub.config.schema import Config
from hpcrub.effects import air, casing_motion, coating, stress
from hpcrub.effects.effect import EFFECTS, Effect

__all__ = ["EFFECTS", "air", "casing_motion", "coating", "of", "stress"]


def of(config: Config) -> list[Effect]:
    """Effects that an input has."""
    return [effect for effect in EFFECTS if effect.exists(config)]
