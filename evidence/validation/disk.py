"""The reference disk of the program: the defaults of its configuration."""

from functools import cache

from hpcrub.config.schema import Config
from hpcrub.model.disk import build_disk
from hpcrub.model.reduction import craig_bampton


@cache
def full():
    """The tuned Disk with all its dof."""
    config = Config()
    return build_disk(config.disk, config.material)


@cache
def reduced(n_modes):
    """ReducedModel with n_modes fixed-interface modes."""
    return craig_bampton(full(), n_modes)
