"""The interface of a disk whose displacements are small, or of second order."""

from typing import Any

import numpy as np

from hpcrub.config.schema import Config
from hpcrub.errors import InputError
from hpcrub.model.disk import build_disk
from hpcrub.model.interface import Interface
from hpcrub.model.second_order_planar import planar_second_order


def interface_of(config: Config, model: Any) -> Interface:
    """Interface of a `problem.Model`, with its second order where the configuration asks for it.

    Raises InputError for a model file that does not know its second order.
    """
    interface = model.reduced.interface
    if not config.contact.bends:
        return interface._replace(second_order=None)
    if config.disk.model is None:
        second = planar_second_order(model.disk, model.reduced.basis, config.disk, config.material)
        # directions turn as in three dimensions, so that the law is that of such disks
        return interface._replace(second_order=second, axial=np.zeros_like(interface.normal))
    if interface.second_order is None:
        raise InputError(
            f"contact.kinematics: {config.disk.model} does not hold the second order of its "
            "blades; import it with --second-order, or leave displacements small"
        )
    return interface


def size_of(config: Config) -> tuple[float, ...] | None:
    """Shift and bend of `model.second_order.size_of` [1/m]; None: the model file tells none."""
    if config.disk.model is not None:
        return config.disk.second_order_per_m
    disk = build_disk(config.disk, config.material)
    whole = np.eye(len(disk.mass))
    return planar_second_order(disk, whole, config.disk, config.material).size
