"""Second order of the motion on a whole disk, against twelve blades with exact rotations.

The reference disk, with all its modes, meets four bumps from rest. Its ring and spokes are linear
in both programs (`evidence.truth.exact_rubbing`, `evidence.truth.second_order`): what a ring that
turns the roots does to second order is seen here alone.
"""

import numpy as np

from evidence.page import table
from evidence.truth import second_order
from evidence.truth.corotational import planar_blade
from evidence.truth.disk import DAMPING_RATIO, MATERIAL, disk_section, reference_disk
from evidence.truth.exact_rubbing import of_disk, rub
from evidence.truth.ring import Wall
from evidence.validation import report
from evidence.validation.bent_blade import NAMES
from hpcrub.model.reduction import craig_bampton, mistuned_modes
from hpcrub.model.second_order_planar import planar_second_order

HZ, STEP, SECONDS = 34.5, 2e-6, 0.03
SCALES = 0.25, 0.5, 1.0  # of bumps of 1.25 mm and a clearance of 0.25 mm
BETTER = 2.5  # least ratio of the errors at first and second order


def structures():
    """The disk of both programs."""
    disk, section = reference_disk(), disk_section()
    blade, _ = planar_blade(section, MATERIAL)
    reduced = craig_bampton(disk, len(disk.mass) - disk.contact_dof.size)
    modes = mistuned_modes(reduced, np.zeros(section.n_blades))
    model = planar_second_order(disk, reduced.basis, section, MATERIAL)
    bent = second_order.structure_of(modes, reduced.interface, model, DAMPING_RATIO)
    return of_disk(disk, blade, section.hub_radius), bent


def errors(exact, bent, scale):
    """Largest motion of any tip [m], and the largest error of every order over it [-]."""
    wall, n = Wall(4, scale * 1.25e-3, scale * 0.25e-3), round(SECONDS / STEP)
    motion, _ = rub(exact, wall, HZ, STEP, n, DAMPING_RATIO)
    peak, casing = np.hypot(*motion.T).max(), second_order.casing_of(wall)
    found = []
    for order in second_order.ORDERS:
        how = wall.clearance, wall.friction, HZ, STEP, n, order
        run = second_order.integrate(bent, casing, *how)
        found.append(np.hypot(*(run.place[..., :2] - motion).T).max() / peak)
    return peak, found


def section(_folder):
    """Parts of the page, and verdicts."""
    exact, bent = structures()
    rows, verdicts = [], []
    for scale in SCALES:
        peak, found = errors(exact, bent, scale)
        rows.append([f"{1e3 * peak:.1f}", *(f"{100 * e:.2f}" for e in found)])
        times = report.Verdict(
            f"tips that move {1e3 * peak:.1f} mm, times better", found[0] / found[2], BETTER, np.inf
        )
        verdicts.append(times)
    heads = ["tips move [mm]", *(f"{NAMES[order]} [%]" for order in second_order.ORDERS)]
    return {"errors": table(heads, rows)}, verdicts
