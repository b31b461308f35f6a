"""Whether matrices at three speeds tell the stiffness between them."""

import numpy as np

from hpcrub.model.imported import assembly, craig_bampton, cyclic
from hpcrub.model.imported.neutral import NeutralModel


def error_between(model: NeutralModel, speeds: np.ndarray) -> float:
    """Relative error of the first frequency half-way between the speeds of a model's matrices.

    Rotation changes the square of a frequency smoothly with the square of the speed. The entries of
    the matrices do not, where blades turn by degrees: a parabola through each of them then gives a
    blade that is none.

    model: of kind "sector" or "disk", with stiffness fitted through three speeds.
    speeds: (3,) these speeds, 0 among them [rad/s].
    Returns that of the larger magnitude of both places; the parabola through the frequencies'
    squares is taken to be right.
    """
    if model.kind == "sector":
        diameters = model.n_sectors // 2
        first = [
            cyclic.sector_frequencies(model, diameters, 1, s)[0] for s in _with_middles(speeds)
        ]
    else:
        disk = assembly.assemble(model)
        first = [craig_bampton.frequencies(disk, 1, s)[0] for s in _with_middles(speeds)]
    square = np.sort(speeds) ** 2
    parabola = np.polyfit(square / square[-1], np.square(first[:3]), 2)
    middles = (square[1:] + square[:-1]) / 2 / square[-1]
    errors = np.array(first[3:]) / np.sqrt(np.polyval(parabola, middles)) - 1.0
    return float(errors[np.abs(errors).argmax()])


def _with_middles(speeds):
    square = np.sort(speeds) ** 2
    return np.sqrt(np.concatenate([square, (square[1:] + square[:-1]) / 2]))
