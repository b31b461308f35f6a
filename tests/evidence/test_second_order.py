"""The second programs of second order: they agree with each other, and keep what they must."""

import numpy as np
import pytest
from scipy.linalg import eigh

from evidence.truth import second_order
from evidence.truth.bent_blade import clamped
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
    """½(d/h)² + ½ω²q² + ⅙ C s s s + D s s s s/24 of a bowed blade, to second order in the step."""
    structure = both(0.07924)[1]
    C, D, omega = structure.coupling, structure.quartic, structure.omega
    drift = []
    for h in (4e-6, 2e-6):
        start = np.eye(len(omega))[0] * 0.02, 0.0 * omega
        run = second_order.integrate(structure, FREE, HZ, h, round(8e-3 / h), start=start)
        q = run.position
        d, q = np.diff(q, axis=0), (q[1:] + q[:-1]) / 2.0
        s = q @ structure.bent[0].T
        cubic = np.einsum("abc,na,nb,nc->n", C, s, s, s) / 6.0
        quartic = np.einsum("abcd,na,nb,nc,nd->n", D, s, s, s, s) / 24.0
        energy = ((d / h) ** 2 + (omega * q) ** 2).sum(axis=1) / 2.0 + cubic + quartic
        assert np.abs(cubic).max() > 1e-3 * energy[0]
        drift.append(np.ptp(energy) / energy[0])
    assert drift[0] < 1e-3
    assert drift[1] < 0.3 * drift[0]


def test_a_bowed_blade_vibrates_as_fast_as_one_with_exact_rotations():
    """Shift of its first frequency by an amplitude of 13 mm: 0.05 %, and -0.22 % without D."""
    beams, structure = both(0.07924)
    h, n = 6e-6, 10_000
    first = np.eye(len(structure.omega))[0] * 0.013 / np.abs(structure.tangential[0, 0])
    start = first, 0.0 * first
    modes = eigh(beams.stiffness, beams.mass)[1]
    u, d, exact = modes @ first, 0.0 * first, np.empty(n)
    step = h * h * np.linalg.inv(beams.mass)
    for k in range(n):
        d = d - step @ beams.force(u)
        u = u + d
        exact[k] = u[-2]

    def frequency(motion):
        """From zero to zero, upwards [Hz]."""
        i = np.flatnonzero((motion[:-1] < 0.0) & (motion[1:] >= 0.0))
        at = i - motion[i] / (motion[i + 1] - motion[i])
        return (len(at) - 1) / ((at[-1] - at[0]) * h)

    shifts = [frequency(exact)]
    for kind in (structure, structure._replace(quartic=0.0 * structure.quartic)):
        run = second_order.integrate(kind, FREE, HZ, h, n, start=start)
        shifts.append(frequency(run.place[:, 0, 1]))
    exact, full, cubic = np.array(shifts) / (structure.omega[0] / (2.0 * np.pi)) - 1.0
    assert abs(full - exact) < 2e-4
    assert cubic < exact - 2e-3
