"""One contact point on any modal structure, integrated by the kernel of the studies."""

from typing import NamedTuple

import numpy as np

from hpcrub.contact.bank import allocate, fill_lane
from hpcrub.contact.integrate import run
from hpcrub.contact.jit import compiled
from hpcrub.model.casing import CasingShape
from hpcrub.model.interface import planar_interface
from hpcrub.model.reduction import Modes
from hpcrub.response.revolution import Grid
from hpcrub.response.scene import Scene

WIDTH = 8  # lanes of every bank here
AT_ONCE = 512  # steps that are kept before they are looked at


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


class Steps(NamedTuple):
    """Observer: the motion at the ends of some steps, and the forces that led there."""

    position: np.ndarray  # q (n, K, L) [m·√kg]
    increment: np.ndarray  # d (n, K, L) [m·√kg]
    force: np.ndarray  # of all multipliers (n, M, L) [N]

    @staticmethod
    @compiled
    def observe(lanes, bank, steps, block, step, n_active):
        """Apply the forces of a step and keep what has become; see ``contact.observers``."""
        state, row = bank.state, block * bank.scheme.bump.shape[0] + step
        for i in state.active[:n_active]:
            steps.force[row, i] = state.multiplier[i]
        bank.basis.correct(lanes, bank, n_active)
        steps.position[row] = state.position
        steps.increment[row] = state.increment
        return 0


def wall(structure, clearance, **changes):
    """Scene of a structure before a wall that does not move, at a clearance [m], with changes."""
    values = {
        "interface": planar_interface(np.zeros(1), 1.0),
        "damping_ratio": structure.damping_ratio,
        "casing": CasingShape(1, 0.0),
        "clearance": clearance,
        "ramp_time": 0.0,
        "friction": structure.friction,
        "scheme": "exact_modal",
    }
    return Scene(**(values | changes))


def make_bank(structure, scene, steps, n_rows=1, kind=lambda modes: modes):
    """Bank of up to WIDTH lanes, one for each time step, at rest.

    structure: Structure; scene: of `wall`; steps: time steps h [s]; n_rows: rows of the bump table;
    kind: of modes, as `spatial` makes them of planar ones. Returns an arrays.Bank.
    """
    modes = Modes.planar(structure.omega, structure.radial[None], structure.tangential[None])
    modes = kind(modes)
    bank = allocate(modes, scene, Grid(n_rows, 1, n_rows), WIDTH)
    for lane, h in enumerate(steps):
        fill_lane(bank, lane, modes, scene, h)
    return bank


def spatial(modes):
    """The Modes of a planar structure as those of one that could move axially, too.

    A single mode gets a second one, which moves no point: arrays of one mode have another memory
    layout, for which the kernel would be compiled once more.
    """
    if len(modes.omega) == 1:
        rows = (np.pad(part, ((0, 0), (0, 1))) for part in (modes.normal, modes.tangential))
        modes = Modes.planar(np.repeat(modes.omega, 2), *rows)
    return modes._replace(axial=np.zeros_like(modes.normal))


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


def recorded(bank, n_steps, most=AT_ONCE):
    """Integrate a Bank in time, from the start of its table (bank is modified).

    Yields Steps, at most so many at a time; the bank is then at the end of the last one.
    """
    scheme, n_rows, done = bank.scheme, len(bank.scheme.bump), 0
    while done < n_steps:
        first, left = done % n_rows, min(n_steps - done, most)
        part, n_tables = bank, left // n_rows
        if first or not n_tables:
            rows, n_tables = slice(first, first + left), 1
            load = None if scheme.external is None else scheme.external[rows]
            part = scheme._replace(bump=scheme.bump[rows], external=load)
            part = bank._replace(scheme=part)
        n = n_tables * len(part.scheme.bump)
        kept = bank.state.position, bank.state.increment, bank.state.multiplier
        steps = Steps(*(np.zeros((n, *values.shape)) for values in kept))
        run(part, n_tables, steps)
        yield steps
        done += n


def trace(bank, n_steps, observed):
    """Integrate in time and watch displacements ``observed`` (n_observed, K) (bank is modified)."""
    h = np.where(bank.scheme.step > 0.0, bank.scheme.step, 1.0)
    displacement, velocity, force = [(observed @ bank.state.position)[None]], [], []
    for steps in recorded(bank, n_steps):
        displacement.append(observed @ steps.position)
        velocity.append(observed @ steps.increment / h)
        force.append(steps.force[:, 0])
    return Trace(*map(np.concatenate, (displacement, velocity, force)))
