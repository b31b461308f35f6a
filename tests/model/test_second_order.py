"""Second order of bent blades, against the same elements with exact rotations.

`evidence.truth.corotational` solves a clamped blade by Newton's method; it is held against Euler's
elastica. Of a slender straight beam theory knows the shortening, −½∫w'² dx.
"""

import numpy as np
import pytest
from scipy.linalg import eigh

from evidence.truth.corotational import (
    Blade,
    clamped_force,
    equilibrium,
    planar_blade,
    tangent,
)
from evidence.truth.disk import MATERIAL, disk_section, make_disk
from hpcrub.model.second_order_planar import planar_second_order

BOWS = 0.0, 0.07924
FORCES = 100.0 * 0.5 ** np.arange(4)  # the tip moves from 0.3 mm down [N]
DIRECTION = np.array([0.4, 0.9])  # radial and tangential part of the force


def second_order(**blade):
    section, disk = disk_section(blade), make_disk(blade)
    return planar_second_order(disk, np.eye(len(disk.mass)), section, MATERIAL)


def bent_modes(K, model):
    """Bent modes (3n, p) of a blade of stiffness K, with the signs that a model gave them."""
    own = slice(5, 5 + len(K))  # after the ring's dof of the first sector
    return np.linalg.solve(K, model.participation[0, :-1, own].T * model.omega[:-1] ** 2)


def pushed(blade, model, force, turn=0.0):
    """Motion of the tip (2,) by a force on it (2,) and a turn of the root.

    To second order, and to first order.
    """
    K = tangent(blade, np.zeros(3 * len(blade.nodes) - 3))
    modes = bent_modes(K, model)[-3:-1]
    load = np.zeros(len(K))
    load[-3:-1] = force
    x, y = blade.nodes[-1] - blade.nodes[0]
    linear = np.linalg.solve(K, load)[-3:-1] + turn * np.array([-y, x])
    G, C, values = model.shortening[0, :2], model.coupling, model.omega[:-1] ** 2
    rest = np.append(force @ modes / values, turn)
    s = rest.copy()
    for _ in range(100):
        less = np.einsum("e,eab,b->a", force, G, s) + 0.5 * C @ s @ s
        s[:-1] = rest[:-1] - less[:-1] / values
    return linear + modes @ (s - rest)[:-1] - 0.5 * G @ s @ s, linear


def turned(angle):
    """Matrix that turns a vector of the plane."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s], [s, c]])


def test_corotational_elements_follow_the_elastica():
    """Tip of a cantilever under PL² = EI, of great stiffness along: Mattiasson (1981), table 1."""
    n = 40
    beam = Blade(np.column_stack([np.linspace(0, 1, n + 1), np.zeros(n + 1)]), 1e6, 1.0)
    load = np.zeros(3 * n)
    load[-2] = 1.0
    u = equilibrium(beam, load)
    np.testing.assert_allclose(u[-3:], [-0.05643, 0.30172, 0.46135], atol=3e-5)


@pytest.mark.parametrize("bow", BOWS)
def test_coupling_and_shortening_are_differences_of_the_tangent_stiffness(bow):
    model = second_order(bow=bow)
    blade, mass = planar_blade(disk_section({"bow": bow}), MATERIAL)
    K = tangent(blade, np.zeros(len(mass)))
    modes = bent_modes(K, model)
    tip = np.linalg.solve(K, np.eye(len(K))[:, -3:-1])
    tip -= modes @ (modes[-3:-1].T / model.omega[:-1, None] ** 2)

    def changed(y):
        small = 1e-5 / np.abs(y).max()
        change = tangent(blade, small * y) - tangent(blade, -small * y)
        return modes.T @ change @ modes / (2 * small)

    found = np.array([changed(y) for y in [*modes.T, *tip.T]])
    size = model.omega[:-1] ** 2 / np.abs(modes[-3:-1]).max()  # of a coupling that counts
    assert np.abs(found[:3] - model.coupling[:-1, :-1, :-1]).max() < 1e-7 * size.max()
    np.testing.assert_allclose(found[3:], model.shortening[0, :2, :-1, :-1], rtol=1e-5)


@pytest.mark.parametrize("bow", BOWS)
def test_quartic_is_what_equilibrium_leaves_of_the_energy(bow):
    """Elastic force on the first bent mode, moved far and held there, all other modes but two free.

    The force on it is ω²s + ½C s s + ⅙D s s s, in which C counts for both signs alike.
    """
    model = second_order(bow=bow)
    blade, mass = planar_blade(disk_section({"bow": bow}), MATERIAL)
    K = tangent(blade, np.zeros(len(mass)))
    modes = bent_modes(K, model)
    s = 2e-3 / np.abs(modes[-2, 0])  # the tip moves 2 mm

    def force(s):
        """On the bent modes (3,) at amplitudes (s, 0, 0), Newton's method on the others."""
        u, free = s * modes[:, 0], eigh(K, mass)[1][:, 3:]
        for _ in range(20):
            u = u - free @ np.linalg.solve(free.T @ tangent(blade, u) @ free,
                                           free.T @ clamped_force(blade, u))  # fmt: skip
        return modes.T @ clamped_force(blade, u)

    odd = (force(s) - force(-s)) / 2.0 - np.array([model.omega[0] ** 2 * s, 0.0, 0.0])
    even = (force(s) + force(-s)) / 2.0
    D, C = model.quartic[0, 0, 0, :-1], model.coupling[0, 0, :-1]
    np.testing.assert_allclose(odd, D * s**3 / 6.0, rtol=0.02, atol=2e-3 * np.abs(odd).max())
    np.testing.assert_allclose(even, C * s**2 / 2.0, rtol=0.01, atol=1e-3 * np.abs(odd).max())


@pytest.mark.parametrize("turn", [0.0, 2e-5])  # of the root, for each newton
@pytest.mark.parametrize("bow", BOWS)
def test_three_bent_modes_leave_little_of_what_is_of_second_order(bow, turn):
    """A blade whose root turns, too, does what one does that is held, seen from its root."""
    blade, mass = planar_blade(disk_section({"bow": bow}), MATERIAL)
    model = second_order(bow=bow)
    errors = []
    for force in FORCES[:, None] * DIRECTION:
        load = np.zeros(len(mass))
        angle = turn * np.hypot(*force)
        load[-3:-1] = turned(-angle) @ force
        chord = blade.nodes[-1] - blade.nodes[0]
        exact = turned(angle) @ (chord + equilibrium(blade, load)[-3:-1]) - chord
        found, linear = pushed(blade, model, force, angle)
        errors.append([np.hypot(*(place - exact)) for place in (linear, found)])
    first, second = np.transpose(errors)
    assert first[:-1] / first[1:] == pytest.approx(4.0, rel=0.01)
    assert (second < 0.03 * first).all()


def test_a_rigid_motion_of_the_root_bends_no_blade():
    """Participation of a displaced blade is that of what the root does not carry along."""
    disk, model = make_disk(), second_order()
    K = disk.blade_stiffness[0]
    rigid = np.linalg.svd(K)[2][-3:]  # the three motions without strain
    assert np.abs(K @ rigid.T).max() < 1e-6 * np.abs(K).max()
    motion = np.zeros((3, len(disk.mass)))
    motion[:, disk.blade_dof[4]] = rigid
    assert np.abs(model.participation[4, :-1] @ motion.T).max() < 1e-9
