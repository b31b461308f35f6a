"""The assembled disk: geometry, rigid-body motions, cyclic symmetry, reference frequencies.

A rigid motion of the whole disk (translation, rotation) strains no blade. Without spokes it
strains nothing, but for the ring's translation, which cubic functions follow only to a fitted
order. A tuned disk is the same after a turn by one sector: its matrices are block-circulant.
"""

import numpy as np
import pytest
from scipy.linalg import eigh

from evidence.truth.disk import disk_section, earlier_disk, make_disk, reference_disk
from hpcrub.studies.modal import displacements

# Reference values of an independent implementation of the same equations and geometry.
REFERENCE_HZ = [90.1212, 90.5767, 90.5767, 91.5801, 91.5801, 91.6116, 92.5558, 92.5558]
REFERENCE_HZ += [93.2003, 93.2003, 93.2267, 93.2267]


def rigid_motions(disk, n_elements):
    """Translations along x and y and rotation by 1 rad, on the dof of the disk, (3, n)."""
    n_blades, per_sector = len(disk.blade_dof), 5 + 3 * n_elements
    points, R_h = disk.points, 0.2
    motions = np.zeros((3, n_blades, per_sector))
    for i, nodes in enumerate(points.blades):
        root, tip = points.frame[nodes[0]], points.frame[nodes[-1]]
        for motion, angle in ((0, 0.0), (1, np.pi / 2)):
            u, v = np.cos(angle - root), np.sin(angle - root)
            motions[motion, i, :5] = u, v / R_h, v, -u / R_h, 0
            motions[motion, i, 5::3] = np.cos(angle - tip)
            motions[motion, i, 6::3] = np.sin(angle - tip)
        x, y = points.position[nodes[1:]].T
        motions[2, i, 2] = R_h
        motions[2, i, 5::3] = -y * np.cos(tip) + x * np.sin(tip)
        motions[2, i, 6::3] = y * np.sin(tip) + x * np.cos(tip)
        motions[2, i, 7::3] = 1
    return motions.reshape(3, -1)


def test_a_motion_to_draw_is_in_x_and_y():
    """Clamped nodes stand still; the largest displacement is 1."""
    disk = reference_disk()
    moved = displacements(disk.points, rigid_motions(disk, 5).T)
    free = (disk.points.dof[:, 0] >= 0)[:, None]
    x, y = disk.points.position.T / 0.5
    for found, expected in zip(moved, ([1, 0], [0, 1], np.column_stack([-y, x])), strict=True):
        np.testing.assert_allclose(found, expected * free, atol=1e-12)


def test_frequencies_are_the_reference_values_to_the_last_digit():
    disk = earlier_disk()
    f = np.sqrt(eigh(disk.stiffness, disk.mass, eigvals_only=True)) / (2 * np.pi)
    assert len(f) == 240
    np.testing.assert_allclose(f[:12], REFERENCE_HZ, atol=5.1e-5)
    np.testing.assert_allclose(f[12:14], [540.28, 561.93], atol=5.1e-3)


def test_tip_is_at_its_nominal_angle_and_root_behind_by_the_lean():
    section, disk = disk_section(), reference_disk()
    points = disk.points
    np.testing.assert_allclose(disk.contact_angle, 2 * np.pi * np.arange(12) / 12)
    np.testing.assert_allclose(disk.contact_radius, 0.5)
    np.testing.assert_array_equal(points.dof[points.blades[:, -1]], disk.contact_dof)
    np.testing.assert_allclose(points.frame[points.blades[:, -1]], disk.contact_angle)
    root, tip = (points.position[points.blades[:, end]] for end in (0, -1))
    nominal = np.column_stack([np.cos(disk.contact_angle), np.sin(disk.contact_angle)])
    np.testing.assert_allclose(tip, 0.5 * nominal, atol=1e-15)
    np.testing.assert_allclose(np.linalg.norm(root, axis=1), 0.2)

    def angle(vectors):
        return np.arctan2(vectors[:, 1], vectors[:, 0])

    lean = np.angle(np.exp(1j * (angle(tip - root) - angle(root))))
    np.testing.assert_allclose(lean, section.blade.lean)


def test_bow_lies_to_the_left_of_the_chord():
    points = make_disk(blade={"n_elements": 4, "bow": 0.1}).points
    for nodes in points.blades:
        root, quarter, middle, _, tip = points.position[nodes]
        along = (tip - root) / np.linalg.norm(tip - root)
        left = np.array([-along[1], along[0]])
        chord = np.linalg.norm(tip - root)
        assert (middle - root) @ along == pytest.approx(chord / 2)
        assert (middle - root) @ left == pytest.approx(0.1 * chord)
        assert (quarter - root) @ left == pytest.approx(0.075 * chord)


@pytest.mark.parametrize("n_elements", [1, 5])
def test_rigid_motion_strains_no_blade(n_elements):
    disk = make_disk(blade={"n_elements": n_elements})
    motions = rigid_motions(disk, n_elements)
    for dof, stiffness in zip(disk.blade_dof, disk.blade_stiffness, strict=True):
        assert np.linalg.matrix_rank(stiffness, tol=1e-9 * stiffness.max()) == len(dof) - 3
        np.testing.assert_allclose(motions[:, dof] @ stiffness, 0, atol=1e-8 * stiffness.max())


def test_a_rigid_motion_strains_the_clamped_spokes_alone():
    """Each as a cantilever whose end goes by u, v and turns by w:
    2 E = 6/5 EA u²/L + EI (12 v² − 12 v w L + 4 w² L²)/L³, stretched as 3x² − 2x³, x = 0 ... 1.
    Of translations, u and v are cosines and sines, whose squares add up to 6."""
    disk = make_disk(ring_thickness=1e-30)  # the ring's translation is not exact
    length, area = 0.2 - 0.1608, 0.1 * 7.899e-3
    axial = 1.2 * 2.1e11 * area / length
    bending = 2.1e11 * area * 7.899e-3**2 / 12 / length**3
    motions = rigid_motions(disk, 5)
    energy = np.einsum("kn,nm,km->k", motions, disk.stiffness, motions)
    moved = 6 * axial + 6 * 12 * bending
    turned = 12 * bending * (12 * 0.2**2 - 12 * 0.2 * length + 4 * length**2)
    np.testing.assert_allclose(energy, [moved, moved, turned], rtol=1e-7)


def test_mass_of_the_unclamped_disk():
    disk = make_disk(spoke_thickness=1e-30)
    motions = rigid_motions(disk, 5)
    inertia = motions @ disk.mass @ motions.T
    ends = disk.points.position[disk.points.blades]
    lengths = np.linalg.norm(np.diff(ends, axis=1), axis=2)
    masses = 7800 * 0.1 * 13.309e-3 * lengths
    ring = 7800 * 0.1 * 14.25e-3 * 2 * np.pi * 0.2
    total = masses.sum() + ring  # of the ring, cubic functions weigh 1e-4 too little
    np.testing.assert_allclose(inertia[:2, :2], np.eye(2) * total, atol=1e-4 * total)
    middle = np.linalg.norm((ends[:, 1:] + ends[:, :-1]) / 2, axis=2)
    polar = np.sum(masses * (middle**2 + lengths**2 / 12)) + ring * 0.2**2
    assert inertia[2, 2] == pytest.approx(polar)


def test_chord_that_misses_the_tip_circle_is_refused():
    with pytest.raises(ValueError, match="does not reach the tip circle"):
        make_disk(hub_radius=0.6, inner_radius=0.5)
