"""How deep mistuned disks cut into a coating, beside the tuned one."""

from collections.abc import Iterator

import numpy as np

from hpcrub.model.coating import Coating
from hpcrub.results.storage import ResultFile
from hpcrub.statistics.percentiles import Z_95, probability_interval
from hpcrub.studies.contact import trust

REACHED = 1.0 - 1e-9  # of the depth of a coating that is worn through: rounding


def lines(file: ResultFile) -> Iterator[str]:
    """How much deeper the worst disk of every level cuts than the tuned one.

    Nothing of a casing without a coating.
    """
    if "tuned/run_deepest_m" not in file:
        return
    runs = 1e3 * file.read("tuned/run_deepest_m")
    tuned = float(np.median(runs[np.isfinite(runs)])) if np.isfinite(runs).any() else np.nan
    c, through, n_disks = file.config.contact.coating, 0, 0
    depth_of_all = Coating(c.thickness, c.young, c.yield_stress, c.hardening, area=0.0).worn_through
    extent = f"{np.nanmin(runs):.3g} to {np.nanmax(runs):.3g} mm in {len(runs)} runs of it"
    yield f"the tuned disk cuts {tuned:.3g} mm deep ({extent})"
    for level, half_range in enumerate(file.read("half_range")):
        depth = 1e3 * trust.finished(file, level, "deepest_m")
        n_disks += len(depth)
        through += int(np.count_nonzero(depth >= 1e3 * REACHED * depth_of_all))
        if not len(depth) or not tuned > 0.0:
            continue
        beyond = probability_interval(0, len(depth), Z_95)[1]
        yield (
            f"±{100 * half_range:.3g} %: the worst of {len(depth)} disks cuts {depth.max():.3g} mm "
            f"deep, {depth.max() / tuned:.2f} times the tuned one; another disk cuts deeper with a "
            f"probability below {100 * beyond:.2g} % (95 % confidence)"
        )
    if through:
        yield (
            f"{through} of {n_disks} disks cut through the coating, {1e3 * depth_of_all:.3g} mm, "
            "at some speed: their tips reach the casing behind it, and depths say no more"
        )
