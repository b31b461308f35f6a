"""Validation in small: a whole disk. Truth: full matrices with an implicit scheme.

All other cases have their thresholds in `make validate`.
"""

import numpy as np
import pytest

from evidence.truth import moreau_jean
from evidence.truth.disk import MATERIAL, disk_section, mistune, reference_scene
from evidence.truth.ring import Wall
from hpcrub.contact.status import STEADY
from hpcrub.model.disk import build_disk
from hpcrub.model.reduction import craig_bampton, mistuned_modes
from hpcrub.response.steady import SteadyCriteria
from hpcrub.response.sweep import run_sweep

DAMPING_RATIO = 0.02
SPEEDS = np.array([34.5])


@pytest.mark.long
def test_periodic_contact_of_a_mistuned_disk_is_that_of_its_full_matrices():
    """12 blades of two elements, all modes kept: both programs solve the same equations."""
    deviation = np.linspace(-0.02, 0.02, 12)[[3, 8, 1, 11, 5, 0, 9, 2, 6, 10, 4, 7]]
    tuned = build_disk(disk_section(blade={"n_elements": 2}), MATERIAL)
    n_modes = len(tuned.mass) - 24
    reduced = craig_bampton(tuned, n_modes)
    modes = mistuned_modes(reduced, deviation)
    how = {"damping_ratio": DAMPING_RATIO, "scheme": "exact_modal", "step": 4e-6}
    steady = SteadyCriteria(first_check=0.3, max_time=0.3)
    scene = reference_scene(interface=reduced.interface, steady=steady, **how)
    result = run_sweep(modes, scene, SPEEDS, width=8)
    full = moreau_jean.unreduced(mistune(tuned, deviation))
    before, last = moreau_jean.amplitudes(full, DAMPING_RATIO, Wall(), SPEEDS, 1e-5, 0.3)
    assert (result.point_status == STEADY).all()
    assert np.abs(before / last - 1.0).max() < 5e-3
    assert np.abs(result.amplitude / last - 1.0).max() < 0.01
    assert last.min() > 5e-3
