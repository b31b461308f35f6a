"""Moving walls and the cantilever with a stop against the event-driven reference."""

import numpy as np
import pytest

from evidence.truth.events import Reference, Wall, fixed_wall
from evidence.truth.motion import Structure
from evidence.validation import cantilever, moving_wall
from evidence.validation.report import fitted_order

SCHEMES = ["central_difference", "exact_modal"]


def test_reference_finds_a_known_impact_and_release():
    """A mass on a spring (ω = 2, q = sin 2t) stopped at 1/2: at t = π/12; it leaves at once.

    There q' = √3 is taken off; the spring then pulls it back from rest, q = cos(2(t − t₁))/2.
    """
    mass = Structure(np.full(1, 2.0), np.ones(1), np.zeros(1), 0.0, 0.0)
    motion = Reference(mass, fixed_wall(0.5), 0.01).run(np.zeros(1), np.full(1, 2.0), 200)
    hit = np.pi / 12.0
    assert abs(motion.impacts[0] - hit) < 1e-12
    assert abs(motion.impulse[-1] - np.sqrt(3.0)) < 1e-12
    t = 0.01 * np.arange(201)
    exact = np.where(t < hit, np.sin(2.0 * t), np.cos(2.0 * (t - hit)) / 2.0)
    assert np.abs(motion.position[:, 0] - exact).max() < 1e-12


def test_reference_follows_a_wall_and_leaves_it_in_time():
    """A mass on a spring (ω = 1), at rest on a wall that moves in as w = −a sin² t, a = 0.3.

    λ = −(ẅ + w) = a (2 cos 2t + sin² t) turns zero where cos 2t = −1/3.
    """
    a, left = 0.3, np.arccos(-1.0 / 3.0) / 2.0
    wall = Wall(
        lambda t: 1e-9 - a * np.sin(t) ** 2,
        lambda t: -a * np.sin(2.0 * t),
        lambda t: -2.0 * a * np.cos(2.0 * t),
    )
    mass = Structure(np.ones(1), np.ones(1), np.zeros(1), 0.0, 0.0)
    motion = Reference(mass, wall, 0.01).run(np.zeros(1), np.zeros(1), 120)
    t = 0.01 * np.arange(121)
    free = t > left
    on_wall = wall.place(t)
    assert np.abs(motion.position[1:, 0] - on_wall[1:])[~free[1:]].max() < 1e-12
    u, v = wall.place(left), wall.velocity(left)
    exact = u * np.cos(t - left) + v * np.sin(t - left)
    assert np.abs(motion.position[:, 0] - exact)[free].max() < 1e-8


@pytest.mark.parametrize("wall", moving_wall.WALLS)
def test_reference_does_not_depend_on_its_own_step(wall):
    coarse, fine = (moving_wall.reference(wall, 0.4, n) for n in (500, 2000))
    assert len(fine.impacts) >= 2
    assert np.abs(np.subtract(coarse.impacts, fine.impacts)).max() < 1e-12
    assert np.abs(coarse.position - fine.position[::4]).max() < 1e-11
    assert abs(coarse.impulse[-1] - fine.impulse[-1]) < 1e-11


@pytest.mark.parametrize("wall", moving_wall.WALLS)
@pytest.mark.parametrize("friction", [0.0, 0.4])
@pytest.mark.parametrize("name", SCHEMES)
def test_mass_and_moving_wall_are_of_first_order(wall, friction, name):
    divisions = np.array([500, 1000, 2000, 4000])
    exact = moving_wall.reference(wall, friction, 4000)
    rows = [moving_wall.errors(exact, wall, friction, name, n) for n in divisions]
    normal, tangential, impulse = np.array(rows).T
    for error in (normal, tangential, impulse):
        assert fitted_order(1.0 / divisions, error) > 0.7
        assert error[-1] < 5e-3


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


def test_cantilever_with_eight_modes_converges_to_the_events():
    divisions = 6400 * 2 ** np.arange(3)
    error = cantilever.step_errors(8, "exact_modal", divisions)
    assert fitted_order(1.0 / divisions, error) > 0.7
    assert error[-1] < 1e-4


def test_cantilever_converges_in_modes():
    modes = np.array([1, 2, 4, 8])
    by_events, by_kernel = cantilever.mode_errors(modes, 16, 6400)
    assert fitted_order(1.0 / modes, by_events) > 1.0
    assert np.abs(by_kernel / by_events - 1.0).max() < 0.1
