"""The contact study's members; `hpcrub.study` computes it."""

import numpy as np

from hpcrub.results.layout import KINDS, LAYOUT, SCALES
from hpcrub.studies.problem import build_problem as prepare
from hpcrub.studies.problem import sigma_of

__all__ = ["LAYOUT", "SCALES", "constants", "prepare", "sizes"]


def sizes(config):
    """Length of every dimension."""
    return {
        "speed": config.speeds.n_values,
        "level": len(config.levels),
        "sample": len(config.samples),
        "blade": config.disk.n_blades,
        "mode": config.n_coordinates,
        "percentile": len(config.convergence.percentiles),
        "run": config.mistuning.tuned_runs,
        "block": len(config.samples) // config.convergence.step,
    }


def constants(config):
    """What is known before any computation."""
    n_blocks = sizes(config)["block"]
    seen = config.convergence.step * np.arange(1, n_blocks + 1)
    return {
        "speeds_hz": config.speeds.values_hz,
        "half_range": config.mistuning.half_range[list(config.levels)],
        "sigma": sigma_of(config),
        "sample": np.array(config.samples),
    } | {f"statistics/{kind}/samples_seen": seen for kind in KINDS}
