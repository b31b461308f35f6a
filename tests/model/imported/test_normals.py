"""Contact along the normals of a cone: one mass on three springs inside a conical casing.

The casing is a circle that presses the mass inwards by d along its normal n = (c, 0, s). The mass
has the stiffness k_r, k_t, k_z. At rest, with friction mu against +theta,

    u = -lam K^-1 (n + mu t),    n u = -d,    so lam = d / (c^2 / k_r + s^2 / k_z).

Without friction it slides freely along the generator e = (-s, 0, c), held to n u = -d, and vibrates
there about its rest with w^2 = (s^2 k_r + c^2 k_z) / m.
"""

import numpy as np
import pytest

from hpcrub.errors import InputError
from hpcrub.model.imported import neutral, reduced
from hpcrub.model.reduction import mistuned_modes
from hpcrub.response.scene import Scene
from hpcrub.response.sweep import Motion
from tests.program import whole

MASS, STIFFNESS = 0.3, np.array([4e5, 7e5, 1.5e5])
C, S, PRESSED = np.cos(0.4), np.sin(0.4), 1e-4


def one_mass(normal=(C, 0.0, S)):
    return {
        "hpcrub_model": np.array(1),
        "kind": np.array("reduced"),
        "M": MASS * np.eye(3),
        "K": np.diag(STIFFNESS),
        "nodes": np.array([[0.2, 0.0, 0.03]]),
        "dof": np.array([[0, 1], [0, 2], [0, 3]]),
        "contact_node": np.array([0]),
        "contact_clearance": np.array([-PRESSED]),
        "contact_normal": np.array([normal]),
    }


def motion_of(friction, damping, duration, start=None):
    """Times, displacements u_r, u_t, u_z (R, 3) and normal force (R,) at one speed."""
    model = reduced.reduced_model(neutral.from_arrays(one_mass()), 0.0)
    modes = mistuned_modes(model, np.zeros(1))
    scene = Scene(model.interface, damping, 1, 0.0, 0.0, 1e-3, friction, step=2e-6)
    speed = np.array([80.0])
    motion = Motion.at_rest(1, 3)
    if start is not None:
        motion.position[0] = np.linalg.solve(modes.shapes, start)
    names = "time", "position", "normal_force"
    time, position, force = whole(modes, scene, speed, duration, *names, motion=motion)
    return time[:, 0], position[:, :, 0] @ modes.shapes.T, force[:, 0, 0]


def test_a_mass_pressed_by_a_cone_rests_where_statics_say():
    mu = 0.3
    _, u, force = motion_of(mu, 0.1, 0.5)
    expected = PRESSED / (C**2 / STIFFNESS[0] + S**2 / STIFFNESS[2])
    np.testing.assert_allclose(force[-50:], expected, rtol=1e-6)
    rest = -expected * np.array([C, mu, S]) / STIFFNESS
    np.testing.assert_allclose(u[-1], rest, rtol=1e-6)


def test_a_mass_held_by_a_cone_vibrates_along_its_generator():
    generator, normal = np.array([-S, 0.0, C]), np.array([C, 0.0, S])
    w = np.sqrt(generator**2 @ STIFFNESS / MASS)
    middle = PRESSED * (generator * STIFFNESS @ normal) / (generator**2 @ STIFFNESS)
    start = middle + 0.2 * PRESSED
    time, u, force = motion_of(0.0, 0.0, 0.05, -PRESSED * normal + start * generator)
    assert (force > 0.0).all()
    np.testing.assert_allclose(u @ normal, -PRESSED, rtol=1e-9)
    np.testing.assert_allclose(u[:, 1], 0.0, atol=1e-12)
    exact = middle + (start - middle) * np.cos(w * time)
    np.testing.assert_allclose(u @ generator, exact, atol=2e-3 * abs(start - middle))


@pytest.mark.parametrize("normal", [(2.0, 0.0, 0.0), (-1.0, 0.0, 0.0), (C, S, 0.0)])
def test_vectors_that_are_no_normals_of_a_casing_are_refused(normal):
    with pytest.raises(InputError, match="contact_normal: unit vectors"):
        neutral.from_arrays(one_mass(normal))


def test_normals_go_through_a_file_and_a_cylinder_needs_none():
    model = neutral.from_arrays(one_mass())
    back = neutral.from_arrays(neutral.to_arrays(model))
    np.testing.assert_array_equal(back.contact_normal, [[C, 0.0, S]])
    assert "contact_normal" not in neutral.to_arrays(neutral.from_arrays(one_mass((1.0, 0.0, 0.0))))
