"""Validation in small: a whole disk, and a cantilever with a stop.

Truth: full matrices with an implicit scheme, and a reference that goes from event to event. All
other cases have their thresholds in `make validate`.
"""

import numpy as np
import pytest

from evidence.truth import moreau_jean
from evidence.truth.disk import MATERIAL, disk_section, mistune, reference_scene
from evidence.truth.events import Reference, fixed_wall
from evidence.truth.ring import Wall
from evidence.validation import cantilever
from evidence.validation.report import SCHEMES, fitted_order
from hpcrub.contact.status import STEADY
from hpcrub.model.disk import build_disk
from hpcrub.model.reduction import craig_bampton, mistuned_modes
from hpcrub.response.steady import SteadyCriteria
from hpcrub.response.sweep import run_sweep

DAMPING_RATIO = 0.02
SPEEDS = np.array([33.25, 34.5])


def test_periodic_contact_of_a_mistuned_disk_is_that_of_its_full_matrices():
    """12 blades of two elements, all modes kept: both programs solve the same equations."""
    deviation = np.linspace(-0.02, 0.02, 12)[[3, 8, 1, 11, 5, 0, 9, 2, 6, 10, 4, 7]]
    tuned = build_disk(disk_section(blade={"n_elements": 2}), MATERIAL)
    n_modes = len(tuned.mass) - 24
    reduced = craig_bampton(tuned, n_modes)
    modes = mistuned_modes(reduced, deviation)
    how = {"damping_ratio": DAMPING_RATIO, "scheme": "exact_modal", "step": 4e-6}
    steady = SteadyCriteria(first_check=0.4, max_time=0.4)
    scene = reference_scene(interface=reduced.interface, steady=steady, **how)
    result = run_sweep(modes, scene, SPEEDS, width=8)
    full = moreau_jean.unreduced(mistune(tuned, deviation))
    before, last = moreau_jean.amplitudes(full, DAMPING_RATIO, Wall(), SPEEDS, 1e-5, 0.4)
    assert (result.point_status == STEADY).all()
    assert np.abs(before / last - 1.0).max() < 5e-3
    assert np.abs(result.amplitude / last - 1.0).max() < 0.01
    assert last.min() > 5e-3


def test_reference_of_the_cantilever_balances_its_energy():
    """Without damping: energy at the start − losses in impacts = energy at the end."""
    structure, q, v = cantilever.beam(4)
    structure = structure._replace(damping_ratio=0.0)
    motion = Reference(structure, fixed_wall(cantilever.GAP), 0.15 / 1600).run(q, v, 1600)
    q, v = motion.position, motion.velocity
    energy = np.sum(v**2 + (structure.omega * q) ** 2, axis=1) / 2.0
    assert len(motion.impacts) >= 3
    assert abs(energy[-1] - (energy[0] - motion.lost)) < 1e-9 * energy[0]
    assert (q @ structure.radial).max() < cantilever.GAP + 1e-12


@pytest.mark.parametrize("name", SCHEMES)
def test_cantilever_with_a_stop_converges_to_the_events(name):
    divisions = 800 * 2 ** np.arange(4)
    error = cantilever.step_errors(2, name, divisions)
    assert len(cantilever.reference(2, 1600).impacts) >= 3
    assert fitted_order(1.0 / divisions, error) > 0.7
    assert error[-1] < 2e-3
