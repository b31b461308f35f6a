"""One contact point on any modal structure, integrated by the kernel of the studies."""

from typing import NamedTuple

import numpy as np

from hpcrub.contact.bank import allocate, fill_lane
from hpcrub.contact.integrate import run
from hpcrub.model.interface import planar_interface
from hpcrub.model.reduction import Modes
from hpcrub.response.revolution import Grid
from hpcrub.response.scene import Scene

WIDTH = 8  # lanes of every bank here


class Structure(NamedTuple):
    """Mass-normalised modes of a structure and its one contact point."""

    omega: np.ndarray  # (K,) [rad/s]
    radial: np.ndarray  # R (K,) towards the wall [1/√kg]
    tangential: np.ndarray  # T (K,) along it [1/√kg]
    damping_ratio: float
    friction: float


class Trace(NamedTuple):
    """Motion of a few observed displacements; level n is t = n h."""

    displacement: np.ndarray  # (n + 1, n_observed, L) [m]
    velocity: np.ndarray  # (n, n_observed, L) half a step before levels 1 ... n [m/s]
    force: np.ndarray  # λ (n, L) that led to levels 1 ... n [N]


def make_bank(structure, scheme_name, steps, clearance, n_rows=1):
    """Bank of up to WIDTH lanes, one for each time step, at rest; the wall does not move.

    Args:
        structure: Structure.
        scheme_name: as in the configuration.
        steps: time steps h [s].
        clearance: of the wall [m].
        n_rows: rows of the bump table.

    Returns:
        arrays.Bank.
    """
    modes = Modes.planar(structure.omega, structure.radial[None], structure.tangential[None])
    scene = Scene(
        interface=planar_interface(np.zeros(1), 1.0),
        damping_ratio=structure.damping_ratio,
        n_bumps=1,
        bump_height=0.0,
        clearance=clearance,
        ramp_time=0.0,
        friction=structure.friction,
        scheme=scheme_name,
    )
    bank = allocate(modes, scene, Grid(n_rows, 1, n_rows), WIDTH)
    for lane, h in enumerate(steps):
        fill_lane(bank, lane, modes, scene, h)
    return bank


def start_free(bank, structure, q, v, steps):
    """Put every lane on the exact free motion through q, v (K,) at t = 0 (bank is modified)."""
    for lane, h in enumerate(steps):
        before = free_motion(structure, q, v, -h)
        bank.state.position[:, lane] = q
        bank.state.increment[:, lane] = q - before


def free_motion(structure, q, v, t):
    """Modal displacements (K,) of the free motion through q, v at time t from there."""
    decay = structure.damping_ratio * structure.omega
    omega_d = structure.omega * np.sqrt(1.0 - structure.damping_ratio**2)
    turn = omega_d * t
    swing = t * np.sinc(turn / np.pi)  # sin(ω_d t)/ω_d, also for ω = 0
    return np.exp(-decay * t) * (q * np.cos(turn) + (v + decay * q) * swing)


def single_steps(bank, n_steps):
    """Integrate a Bank in time, at the start of its table, step by step (bank is modified).

    Yields the number of steps done; ``bank.state`` is then corrected, and its ``multiplier`` holds
    the contact forces of this step alone.
    """
    scheme, n_rows = bank.scheme, len(bank.scheme.bump)
    for n in range(n_steps):
        row = slice(n % n_rows, n % n_rows + 1)
        one = scheme._replace(bump=scheme.bump[row], external=scheme.external[row])
        bank.state.multiplier[:] = 0.0
        run(bank._replace(scheme=one), 1)
        yield n + 1


def trace(bank, n_steps, observed):
    """Integrate in time and watch displacements ``observed`` (n_observed, K) (bank is modified)."""
    state, step = bank.state, bank.scheme.step
    h = np.where(step > 0.0, step, 1.0)
    displacement, velocity, force = [observed @ state.position], [], []
    for _ in single_steps(bank, n_steps):
        displacement.append(observed @ state.position)
        velocity.append(observed @ state.increment / h)
        force.append(state.multiplier[0].copy())
    return Trace(np.array(displacement), np.array(velocity), np.array(force))
