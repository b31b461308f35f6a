"""One mass on a spring that the kernel throws against a wall, every step recorded."""

from typing import NamedTuple

import numpy as np

from hpcrub.contact.bank import allocate, fill_lane
from hpcrub.contact.integrate import run
from hpcrub.contact.jit import compiled
from hpcrub.contact.passes import correct
from hpcrub.model.interface import planar_interface
from hpcrub.model.reduction import Modes
from hpcrub.response.revolution import Grid
from hpcrub.response.scene import Scene

WIDTH = 8


class Recorded(NamedTuple):
    """Observer: place and force at the end of every step of the first lane."""

    place: np.ndarray  # modal (n,) [m·√kg]
    force: np.ndarray  # (n,) [N]

    @staticmethod
    @compiled(inline=True, inner=True)
    def observe(lanes, bank, recorded, block, step, n_active):
        recorded.force[block] = bank.state.multiplier[0, 0] if n_active > 0 else 0.0
        correct(lanes, bank.scheme, bank.state, n_active)
        recorded.place[block] = bank.state.position[0, 0]
        return 0


def scene(gap, damping_ratio, **law):
    """A wall behind a gap that stands still, with one bar of coating: a turn is one step."""
    return Scene(
        interface=planar_interface(np.zeros(1), 1.0),
        damping_ratio=damping_ratio,
        n_bumps=1,
        bump_height=0.0,
        clearance=gap,
        ramp_time=0.0,
        friction=0.0,
        scheme="exact_modal",
        **law,
    )


def spatial(modes):
    """The Modes of a planar structure as those of one that could move axially, too."""
    return modes._replace(axial=np.zeros_like(modes.normal))


def ready(mass, velocity, scene, h, kind=lambda modes: modes):
    """Bank of a mass (`bars.Mass`) at u = 0 with a velocity [m/s] that takes steps h [s].

    kind: `spatial`, or the planar mass as it is.
    """
    omega = np.sqrt(mass.spring / mass.mass)
    ratio = mass.damper / (2.0 * mass.mass * omega)
    root = np.sqrt(mass.mass)
    modes = Modes.planar(np.array([omega]), np.array([[1.0 / root]]), np.zeros((1, 1)))
    modes = kind(modes)
    scene = scene._replace(damping_ratio=ratio)
    bank = allocate(modes, scene, Grid(1, 1, 1), WIDTH)
    fill_lane(bank, 0, modes, scene, h)
    turn = omega * np.sqrt(1.0 - ratio**2)
    # the exact free motion one step before
    bank.state.increment[0, 0] = (
        root * velocity * np.sin(turn * h) / turn * np.exp(ratio * omega * h)
    )
    return bank


def thrown(mass, velocity, scene, h, duration, **kind):
    """Motion of a mass from u = 0; arguments as of `ready`.

    Returns the places u (n,) [m] and forces (n,) [N] at the ends of n steps h, and the bank.
    """
    bank, n = ready(mass, velocity, scene, h, **kind), round(duration / h)
    recorded = Recorded(np.zeros(n), np.zeros(n))
    run(bank, n, recorded)
    return recorded.place / np.sqrt(mass.mass), recorded.force, bank
