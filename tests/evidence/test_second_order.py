"""The second programs of second order: they agree with each other, and keep what they must."""

import numpy as np
import pytest
from scipy.linalg import eigh

from evidence.truth import second_order
from evidence.truth.bent_blade import clamped
from evidence.truth.corotational import equilibrium, planar_blade
from evidence.truth.disk import MATERIAL, disk_section
from evidence.truth.exact_rubbing import rub
from evidence.truth.ring import Wall

HZ, STEP = 40.0, 4e-6
FREE = Wall(clearance=1.0, friction=0.0)


def both(bow):
    """A clamped blade for either program."""
    beams, modes, face = clamped(bow)
    return beams, second_order.structure_of(modes, face, face.second_order, 0.0)


def meeting(scale, bow):
    """Largest error of the tip's motion over its largest, at every order, until after one bump."""
    beams, structure = both(bow)
    wall, n = Wall(4, scale * 1.25e-3, scale * 0.25e-3, 0.15, 0.02), round(9e-3 / STEP)
    exact = rub(beams, wall, HZ, STEP, n)[0][:, 0]
    errors = []
    for order in second_order.ORDERS:
        run = second_order.integrate(structure, wall, HZ, STEP, n, order)
        errors.append(np.hypot(*(run.place[:, 0, :2] - exact).T).max())
    return np.array(errors) / np.abs(exact).max()


@pytest.mark.parametrize(("bow", "better"), [(0.0, 20.0), (0.07924, 5.0)])
def test_second_order_follows_blades_with_exact_rotations(bow, better):
    """A tip that moves by millimetres: the error falls by half and more with the motion."""
    (first, polar, second), (_, _, smaller) = meeting(1.0, bow), meeting(0.5, bow)
    assert second < first / better
    assert smaller < 0.8 * second
    assert polar > 0.8 * first  # the displaced tip alone is no better


def test_motion_without_contact_conserves_energy():
    """½(d/h)² + ½ω²q² + ⅙ C s s s + D s s s s/24 + ½ J s ṡ s ṡ, but for parts of sixth order."""
    structure, h = both(0.07924)[1], 2e-6
    C, D, J = structure.coupling, structure.quartic, structure.inertia
    omega, drift = structure.omega, []
    for size in (0.02, 0.01):
        start = np.eye(len(omega))[0] * size, 0.0 * omega
        q = second_order.integrate(structure, FREE, HZ, h, round(8e-3 / h), start=start).position
        d, q = np.diff(q, axis=0), (q[1:] + q[:-1]) / 2.0
        s, n = q @ structure.bent[0].T, len(J)
        v = d @ structure.bent[0, :n].T / h
        parts = (
            ((d / h) ** 2 + (omega * q) ** 2).sum(axis=1) / 2.0,
            np.einsum("abc,na,nb,nc->n", C, s, s, s) / 6.0,
            np.einsum("abcd,na,nb,nc,nd->n", D, s, s, s, s) / 24.0,
            np.einsum("abcd,na,nb,nc,nd->n", J, s[:, :n], v, s[:, :n], v) / 2.0,
        )
        energy = sum(parts)
        drift.append(np.ptp(energy) / energy[0])
    assert np.ptp(parts[3]) > 100.0 * drift[1] * energy[0]
    assert drift[0] < 2e-5
    assert drift[1] < 0.15 * drift[0]


@pytest.mark.parametrize("bow", [0.0, 0.07924, -0.0459])
def test_a_blade_vibrates_as_fast_as_one_with_exact_rotations(bow):
    """Shift of the first frequency by a motion of 35 mm: 0.02 %, and 0.35 % without inertia.

    Both begin at rest, bent by a load along the first mode: a blade that is bent to first order
    alone is stretched, and trembles along its length.
    """
    beams, structure = both(bow)
    h, n = 4e-6, 8_000
    values, modes = eigh(beams.stiffness, beams.mass)
    load = beams.mass @ modes[:, 0] * values[0] * 0.035 / np.abs(modes[-2, 0])
    u = equilibrium(planar_blade(disk_section({"bow": bow}), MATERIAL)[0], load, parts=5)
    start = modes.T @ beams.mass @ u
    step, exact = h * h * np.linalg.inv(beams.mass), np.empty(n)
    d = step @ beams.force(u) / 2.0  # half an increment back
    for k in range(n):
        d = d - step @ beams.force(u)
        u = u + d
        exact[k] = modes[:, 0] @ beams.mass @ u

    def frequency(motion):
        """From mean to mean, upwards [Hz]."""
        motion = motion - motion.mean()
        i = np.flatnonzero((motion[:-1] < 0.0) & (motion[1:] >= 0.0))
        at = i - motion[i] / (motion[i + 1] - motion[i])
        return (len(at) - 1) / ((at[-1] - at[0]) * h)

    shifts = [frequency(exact)]
    for kind in (structure, structure._replace(inertia=0.0 * structure.inertia)):
        run = second_order.integrate(kind, FREE, HZ, h, n, start=(start, 0.0 * start))
        shifts.append(frequency(run.position[:, 0]))
    exact, full, light = np.array(shifts) / (structure.omega[0] / (2.0 * np.pi)) - 1.0
    assert abs(full - exact) < 2e-4
    assert light > exact + 3e-3
