"""Sliding contact that locks itself: a scan of the friction in time against the linear criterion.

The tip of one blade of a disk whose blades lean with the rotation is pressed onto the casing and
left to itself. What the kernel integrates knows nothing of `hpcrub.response.sliding`, whose
critical friction and growth rates come from static compliances and from eigenvalues of the disk
with the tip held.
"""

import numpy as np

from evidence import page
from evidence.truth.motion import Structure, make_bank, trace, wall
from evidence.validation import report
from hpcrub.config.schema import Config
from hpcrub.model.reduction import mistuned_modes
from hpcrub.response.sliding import critical_friction, growth_rate
from hpcrub.setup.problem import build_model

LEANING = {"disk.blade.lean_deg": 43.74, "disk.blade.bow": -0.07924}  # with the rotation
DAMPING_RATIO, PRESSED = 5e-3, 1e-4  # beyond the casing at the start [m]
SECONDS, STEP = 0.1, 1e-5
SCANNED = np.array([0.5, 0.9, 0.98, 0.99, 1.01, 1.02, 1.1, 1.3])  # of the critical friction
RATE_ERROR = 1e-4  # allowed


def growths(modes, frictions):
    """Rates at which the tangential displacement grows in time, one for each friction [1/s]."""
    found, n = [], round(SECONDS / STEP)
    half = slice(n // 2, None)
    for friction in frictions:
        structure = Structure(
            modes.omega, modes.normal[0], modes.tangential[0], DAMPING_RATIO, friction
        )
        bank = make_bank(structure, wall(structure, -PRESSED), [STEP])
        moved = trace(bank, n, structure.tangential[None]).displacement[1:, 0, 0]
        # of the largest so far: a motion that oscillates and decays has no rate
        size = np.log(np.maximum.accumulate(np.abs(moved)))
        found.append(np.polyfit(STEP * np.arange(1, n + 1)[half], size[half], 1)[0])
    return np.array(found)


def section(_folder):
    """Parts of the page, and verdicts."""
    modes = mistuned_modes(build_model(Config().replace(LEANING)).reduced, np.zeros(12))
    critical = critical_friction(modes)
    frictions = SCANNED * critical
    found = growths(modes, frictions)
    said = np.array([growth_rate(modes, DAMPING_RATIO, friction) for friction in frictions])
    rows = [
        [f"{part:g}", f"{friction:.4f}", f"{rate:.4g}", f"{of_time:.4g}"]
        for part, friction, rate, of_time in zip(SCANNED, frictions, said, found, strict=True)
    ]
    head = ["of the critical", "friction", "growth said [1/s]", "growth in time [1/s]"]
    grows = said > 0.0
    error = np.abs(found[grows] / said[grows] - 1.0).max()
    verdicts = [
        report.at_most("largest growth below the critical friction [1/s]", found[~grows].max(), 1),
        report.Verdict("lowest friction that grows in time, over the critical one",
                       SCANNED[found > 1.0].min(), 1.0, 1.011),
        report.at_most("error of a growth rate", error, RATE_ERROR),
    ]  # fmt: skip
    text = f"The critical friction is {critical:.4f}."
    return {"growth": f"{page.table(head, rows)}\n{text}"}, verdicts
