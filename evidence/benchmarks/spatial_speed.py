"""Steps per second and core of a disk that rubs in three dimensions: against C and the limit.

The disk is the blisk of `inputs/blisk`, with its contact points interpolated along the chord of the
tip, and its modes continued above the highest by made-up ones of a small amplitude.
"""

import numpy as np

from evidence.benchmarks.kernel_speed import Lanes, beside, run_c
from hpcrub.config.schema import load_runs
from hpcrub.contact.recurrence import coefficients
from hpcrub.setup.disks import modes_of
from hpcrub.setup.imported import resolved
from hpcrub.setup.problem import build_problem

INPUT = "inputs/blisk/contact.yaml"
SLOWEST, FASTEST = 211.0, 217.0  # [Hz] where the tips rub
REVOLUTIONS = 20  # until they rub as they do most of the time: the casing has grown
POINTS, MODES = 48, 250  # of the comparison


def blisk():
    """Modes and Scene of the blisk with POINTS contact points and MODES modes."""
    config = resolved(load_runs(INPUT)[0])
    problem = build_problem(config)
    rng = np.random.default_rng(1)
    modes = modes_of(config, problem, 0.02 * rng.uniform(-1.0, 1.0, config.disk.n_blades))
    face = problem.scene.interface
    along = _chord(face, POINTS // face.n_blades)
    rows = {name: along @ getattr(modes, name) for name in ("normal", "tangential", "axial")}
    n_extra = MODES - len(modes.omega)
    rows = {name: _continued(value, n_extra, rng) for name, value in rows.items()}
    rise = np.linspace(1.01, 1.5, n_extra)
    modes = modes._replace(
        omega=np.append(modes.omega, modes.omega[-1] * rise),
        observed=np.pad(modes.observed, ((0, 0), (0, n_extra))),
        stiffening=np.pad(modes.stiffening, ((0, 0), (0, n_extra))),
        shapes=np.eye(MODES),
        **rows,
    )
    face = face._replace(
        blade=np.repeat(np.arange(face.n_blades), POINTS // face.n_blades),
        **{name: along @ getattr(face, name)
           for name in ("angle", "radius", "axial_position", "clearance")},
        **rows,
    )  # fmt: skip
    return modes, problem.scene._replace(interface=face)


def _chord(face, n):
    """Matrix (N·n, C) that interpolates n points along the tip of each blade by a polynomial."""
    own = face.points_per_blade[0]
    knots, places = np.linspace(0.0, 1.0, own), np.linspace(0.0, 1.0, n)
    weights = np.vander(places, own) @ np.linalg.inv(np.vander(knots, own))
    matrix = np.zeros((face.n_blades * n, len(face.blade)))
    for blade in range(face.n_blades):
        matrix[blade * n : (blade + 1) * n, face.blade == blade] = weights
    return matrix


def _continued(rows, n_extra, rng):
    """Rows with n_extra more modes, as large as the last ones, each point by itself."""
    size = np.sqrt(np.mean(rows[:, -20:] ** 2))
    return np.hstack([rows, size * rng.normal(size=(len(rows), n_extra))])


def rubbing(modes, scene):
    """Lanes of such a disk."""
    return Lanes(modes, scene, speeds=(SLOWEST, FASTEST), warm=REVOLUTIONS * scene.casing.n_bumps)


def plain_c(lanes, speed=214.0, n_steps=20_000):
    """Steps per second of ``dense3d.c`` on the same disk."""
    modes, scene, grid = lanes.modes.at(speed), lanes.scene, lanes.grid
    h = 1.0 / (speed * grid.steps_per_revolution)
    decay, gain = coefficients(scene.scheme, modes.omega, scene.damping_ratio, h)
    rows = np.vstack([modes.normal, modes.tangential, modes.axial])
    rest = np.linalg.svd(rows)[2][len(rows) :] * np.sqrt(np.mean(rows**2)) * np.sqrt(rows.shape[1])
    shapes = np.vstack([rows, rest])  # any coordinates will do, these begin with the points
    inverse = np.linalg.inv(shapes)
    face, pitch = scene.interface, grid.steps_per_revolution
    bump = scene.casing.table(face.angle, pitch, grid.steps_per_block)
    sizes = len(shapes), len(face.blade), len(bump), n_steps
    arrays = (
        shapes @ np.diag(1.0 + decay - modes.omega**2 * gain) @ inverse,
        -shapes @ np.diag(decay) @ inverse,
        -rows @ np.diag(gain) @ shapes.T,
        scene.clearance + face.clearance,
        face.radius * 2.0 * np.pi / pitch,
        bump,
    )
    scalars = h, scene.ramp_time, scene.friction
    return n_steps / run_c("dense3d.c", sizes, scalars, arrays)[0]


def needed_flops(n_modes, n_points, n_contacts):
    """Floating-point operations of one step of one speed: modes, penetrations, slip, contacts."""
    modal = 6 * n_modes
    penetrations = 2 * n_modes * n_points + 2 * n_points
    slip = 2 * n_modes * 2 * n_contacts
    correction = 2 * n_modes * 3 * n_contacts + n_modes
    columns = 4 * n_points * n_contacts
    multipliers = 2 * n_contacts**3 / 3 + 2 * n_contacts**2 + 2 * n_points * n_contacts
    return modal + penetrations + slip + correction + columns + multipliers


def section():
    """Parts of the page: hpcrub beside C and the machine's limit."""
    lanes = rubbing(*blisk())
    contacts = lanes.contacts(1, 40)
    flops = needed_flops(MODES, POINTS, contacts)
    return beside(lanes, plain_c, flops, contacts, 3, ["the same while recording"])
