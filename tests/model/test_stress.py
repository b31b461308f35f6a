"""Stress at the roots of planar blades: statics, reactions of whole blades, and every step."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.linalg import eigh

from evidence.truth.disk import (
    disk_section,
    make_disk,
    mistune,
    reference_disk,
    reference_reduced,
    reference_scene,
)
from evidence.truth.section import largest, root_stress
from hpcrub.contact.observers import largest_stress
from hpcrub.contact.status import AVERAGED, NOT_STEADY, STEADY
from hpcrub.contact.tables import vectors
from hpcrub.model.reduction import mistuned_modes
from hpcrub.response.steady import SteadyCriteria
from hpcrub.response.sweep import run_sweep

DEVIATION = np.random.default_rng(30).uniform(-0.04, 0.04, 12)
FORCES = np.array([[0.0, 900.0], [700.0, 0.0], [-300.0, 500.0]])  # radial, tangential [N]


@pytest.mark.parametrize("blade", [{"lean": 0.0, "bow": 0.0}, {}])
@pytest.mark.parametrize("force", FORCES)
def test_a_force_on_a_tip_bends_its_root_alone_as_a_beam(blade, force):
    """σ = N/A ± M c/I of the force in the first element's direction and its lever."""
    disk, section = make_disk(blade), disk_section(blade)
    load = np.zeros(len(disk.mass))
    load[disk.contact_dof[0]] = force
    x = np.linalg.solve(disk.stiffness, load)
    faces = np.einsum("isk,ik->is", disk.blade_stress, x[disk.blade_dof])
    root, first, tip = disk.points.position[disk.points.blades[0, [0, 1, -1]]]
    axis = (first - root) / np.linalg.norm(first - root)  # the tip lies at the angle 0
    normal, lever = force @ axis, tip - root
    moment = lever[0] * force[1] - lever[1] * force[0]
    direct = normal / (section.width * section.blade.thickness)
    bending = abs(moment) / (section.width * section.blade.thickness**2 / 6.0)
    np.testing.assert_allclose(np.sort(faces[0]), [direct - bending, direct + bending], rtol=1e-7)
    np.testing.assert_allclose(faces[1:], 0.0, atol=1e-7 * (bending + abs(direct)))


def test_modes_of_a_mistuned_disk_have_the_stress_that_holds_their_blades():
    """Of the reduced disk in its basis, and of the full one in its own first modes.

    All modes with the tips held are kept: the 60 of the default lose up to 0.7 % of the stress.
    """
    disk, reduced = reference_disk(), reference_reduced(216)
    modes = mistuned_modes(reduced, DEVIATION)
    own = root_stress(disk, disk_section(), reduced.basis @ modes.shapes, DEVIATION)
    found = modes.stress.reshape(own.shape)
    np.testing.assert_allclose(np.sort(found, axis=1), np.sort(own, axis=1), rtol=1e-9, atol=1e-3)
    full = mistune(disk, DEVIATION)
    shapes = eigh(full.stiffness, full.mass, subset_by_index=[0, 11])[1]
    exact = root_stress(disk, disk_section(), shapes, DEVIATION)
    size = np.abs(exact).max(axis=(0, 1))
    np.testing.assert_allclose(np.abs(found).max(axis=(0, 1))[:12], size, rtol=1e-6)


@pytest.mark.parametrize(
    ("criteria", "status"),
    [
        ({"rule": "ensemble", "first_check": 0.2}, AVERAGED),
        ({"first_check": 0.2, "max_time": 0.5, "max_amplitude_change": 0.5,
          "min_correlation": 0.0, "confirmations": 2}, STEADY),
        # between the second check and the end there is less than a window
        ({"first_check": 0.2, "max_time": 0.52, "min_correlation": 1.0}, NOT_STEADY),
    ],
)  # fmt: skip
def test_the_largest_stress_is_that_of_every_step_of_the_last_window(criteria, status):
    """Of all steps of a run of its own; amplitudes have the same bits as without stresses.

    Disks of seventeen speeds end at different checks, and lanes are filled again.
    """
    steady = SteadyCriteria(**criteria)
    scene = reference_scene(scheme="exact_modal", step=6e-5, steady=steady, ramp_time=0.01)
    modes = mistuned_modes(reference_reduced(), DEVIATION)
    speeds = np.linspace(33.6, 35.2, 17)
    without = run_sweep(modes, scene, speeds)
    found = run_sweep(modes, scene._replace(observes_stress=True), speeds)
    np.testing.assert_array_equal(found.amplitude, without.amplitude)
    assert np.isnan(without.stress).all()
    assert np.isfinite(found.stress).all()
    assert status in found.point_status
    shapes = reference_reduced().basis @ modes.shapes
    rows = root_stress(reference_disk(), disk_section(), shapes, DEVIATION)
    for i in (0, 11, 16):
        end = found.time[i] * speeds[i]
        end = round(4 * end) / 4  # of the pitches of four bumps
        own = largest(modes, scene, speeds[i], end - 3, end, rows.reshape(24, -1))
        assert found.stress[i] == pytest.approx(own, rel=1e-9)


@pytest.mark.parametrize(("n_places", "n_modes"), [(1, 3), (24, 84), (25, 7), (60, 1)])
def test_the_largest_stress_of_any_number_of_places_and_modes(n_places, n_modes):
    rng = np.random.default_rng(n_places)
    rows, q = rng.normal(size=(n_places, n_modes)), rng.normal(size=(n_modes, 2))
    stiffer = rng.uniform(0.9, 1.1, size=(len(vectors(rows)) * 8, 2))
    scheme = SimpleNamespace(stress=vectors(rows), stiffer=stiffer)
    bank = SimpleNamespace(scheme=scheme, state=SimpleNamespace(position=q))
    found = largest_stress.py_func(bank, 1, np.zeros((1, 8)))
    expected = np.abs(stiffer[:n_places, 1] * (rows @ q[:, 1])).max()
    assert found == pytest.approx(expected, rel=1e-13)
