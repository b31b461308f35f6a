"""A casing that vibrates: the same run in its own frame, and energy.

`evidence.truth.ring` integrates disk and casing in the frame of the casing, with projections that
turn; hpcrub sees the casing from the rotor, with coordinates that turn. They share no line.
"""

import numpy as np

from evidence.page import table
from evidence.truth import ring as truth
from evidence.truth.disk import reference_reduced, reference_scene
from evidence.truth.energy import TOLERANCE
from evidence.validation import report
from evidence.validation.coating import ledger
from hpcrub.model.casing_modes import Ring, ring_modes
from hpcrub.model.reduction import mistuned_modes
from hpcrub.response import casing_motion, history
from hpcrub.response.revolution import cut_revolution

SPEED_HZ, REVOLUTIONS = 34.0, 2
STEEL = Ring(radius=0.5025, thickness=0.02, width=0.1, young=2.1e11, density=7800.0)
ALUMINIUM = STEEL._replace(thickness=5e-3, young=7e10, density=2700.0)
HELD = ALUMINIUM._replace(bed_radial=2e7, bed_tangential=2e6)
RINGS = {
    "steel, 20 mm": STEEL,
    "steel, 40 mm": STEEL._replace(thickness=0.04),
    "aluminium, 5 mm, on a bed": HELD,
}
WAVES = np.arange(2, 9)
KNOWN_HZ = 50.657, 143.274, 274.710, 444.261, 651.717, 897.002, 1180.08
AGREE = 1e-9


def in_both_frames(ring, deviation):
    """Largest tip motion [m], of the casing [m], difference of both runs over the largest, and
    share of the energy of disk, casing, friction and shaft that does not balance."""
    scene = reference_scene(60, scheme="exact_modal", record_interval=0.0, step=2e-5)
    casing = ring_modes(ring, WAVES, 0.005)
    modes = mistuned_modes(reference_reduced(60)._replace(casing=casing), deviation)
    pieces = list(history.integrate(modes, scene, [SPEED_HZ], REVOLUTIONS / SPEED_HZ))
    q = np.concatenate([piece.position[:, :, 0] for piece in pieces])
    pairs = np.concatenate([piece.casing[:, :, 0] for piece in pieces])
    steps = cut_revolution(SPEED_HZ, scene).steps_per_revolution
    true = truth.integrate(
        modes.omega, scene.damping_ratio, modes.normal, modes.tangential, scene.interface.angle,
        truth.Ring(*casing), truth.wall_of(scene), SPEED_HZ, steps, len(q),
    )  # fmt: skip
    difference = np.abs(q - true.disk).max() / np.abs(true.disk).max()
    moved, _ = casing_motion.largest(modes.pairs, pairs)
    energy = ledger(modes, scene, SPEED_HZ, REVOLUTIONS).unexplained()[0]
    return np.abs(q @ modes.tangential.T).max(), moved, difference, energy


def section(_folder):
    """Parts of the page, and verdicts."""
    rows, verdicts = [], []
    for name, ring in RINGS.items():
        for words, deviation in (("tuned", np.zeros(12)), ("±3 %", np.linspace(-0.03, 0.03, 12))):
            tips, moved, difference, energy = in_both_frames(ring, deviation)
            rows.append([name, words, f"{1e3 * tips:.2f}", f"{1e3 * moved:.2f}",
                         f"{difference:.1e}", f"{energy:.0e}"])  # fmt: skip
            verdicts.append(report.at_most(f"{name}, {words}, both frames", difference, AGREE))
        verdicts.append(report.at_most(f"{name}, unexplained energy", energy, TOLERANCE))
    head = ["casing", "disk", "tips [mm]", "casing [mm]", "difference", "unexplained energy"]
    return {"frames": table(head, rows)}, verdicts
