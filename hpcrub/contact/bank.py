"""Banks of lanes: all that the kernel works on to integrate speeds of one sample in time."""

import math
from collections.abc import Iterable
from typing import Any

import numpy as np

from hpcrub.contact import complementarity
from hpcrub.contact.arrays import Bank, Contact, Polar, Record, Scheme, Spatial, State
from hpcrub.contact.complementarity import FLAW
from hpcrub.contact.lanes import TILE, aligned, aligned_zeros
from hpcrub.contact.recurrence import coefficients
from hpcrub.contact.status import NONE, NOT_FINITE, UNPROVEN
from hpcrub.model.casing import bump_table
from hpcrub.model.damping import ratios
from hpcrub.model.reduction import Modes

GROUP = 48  # contact points of neighbouring blades whose forces are found at once


def delassus(motion: np.ndarray, load: np.ndarray, gain: np.ndarray) -> np.ndarray:
    """Displacement of every contact point per unit force on every other in one step.

    Parameters
    ----------
    motion : ndarray (K, C)
        Displacement of the points per unit modal coordinate [1/√kg].
    load : ndarray (K, C)
        Modal force of a unit force on each point [1/√kg].
    gain : ndarray (K,)
        Factor of a modal force in the scheme [s²].

    Returns
    -------
    ndarray (C, C)
        [m/N].
    """
    return (motion * gain[:, None]).T @ load


def allocate(
    modes: Modes, scene: Any, grid: Any, width: int, speeds_hz: Iterable[float] = ()
) -> Bank:
    """Lanes for one sample and one band of speeds.

    Parameters
    ----------
    modes : Modes
        Of the sample.
    scene : response.sweep.Scene
        Casing, friction and integration scheme.
    grid : response.sweep.Grid
        How a revolution is cut into steps, blocks and records.
    width : int
        Number of lanes.
    speeds_hz : iterable of float, optional
        Speeds of the first lanes, at most ``width`` [Hz]; the others are idle.

    Returns
    -------
    Bank
        Lanes at rest.

    Raises
    ------
    ValueError
        For polar kinematics of a disk with axial motion.
    """
    moves_axially = len(modes.axial) > 0
    if scene.kinematics == "polar" and moves_axially:
        raise ValueError("polar kinematics are for disks without axial motion")
    scheme = _allocate_scheme(modes, scene, grid, width)
    n_points = scheme.normal.shape[1]
    contact = Contact(
        coupling=aligned_zeros(((n_points + 1) ** 2, width)),
        stiffness=aligned_zeros((n_points, width)),
        reach=aligned_zeros((1, width)),
    )
    state = _allocate_state(scheme, width)
    record = _allocate_record(scene, grid, scheme.observed.shape[1], width)
    polar = _allocate_polar(scene, grid, n_points, width)
    spatial = _allocate_spatial(scene, grid, modes, width) if moves_axially else ()
    bank = Bank(scheme, contact, state, record, polar, spatial)
    for lane, speed in enumerate(speeds_hz):
        h = 1.0 / (speed * grid.steps_per_revolution)
        fill_lane(bank, lane, modes.at(speed), scene, h)
    return bank


def _allocate_scheme(modes, scene, grid, width):
    polar = scene.kinematics == "polar"
    interface = scene.interface
    normal = _columns(modes.normal)
    bump = bump_table(
        interface.angle,
        scene.n_bumps,
        0.0 if polar else scene.bump_height,
        grid.steps_per_revolution,
        grid.steps_per_block,
        scene.profile,
    )
    clearance = np.full((1, normal.shape[1]), np.inf)  # nothing touches at the padding
    clearance[0, : len(modes.normal)] = 0.0 if polar else scene.clearance + interface.clearance
    n_modes = len(modes.omega)
    load = np.pad(_unit_loads(modes, scene), ((0, 0), (0, 1)))
    # in three dimensions a few columns of many are read, so each of them lies in one piece
    laid_out = _by_columns if len(modes.axial) > 0 else aligned
    return Scheme(
        normal=aligned(normal),
        tangential=laid_out(_columns(modes.tangential)),
        observed=aligned(_columns(modes.observed)),
        load=laid_out(load),
        decay=aligned_zeros((n_modes, width)),
        gain=aligned_zeros((n_modes, width)),
        squared=aligned_zeros((n_modes, width)) if len(modes.stiffening) else modes.omega**2,
        clearance=aligned(clearance),
        step=np.zeros(width),
        bump=aligned(_columns(bump.T)),
        external=_engine_order_forces(modes, scene, grid),
        ramp_time=scene.ramp_time,
        shortcuts=scene.shortcuts,
    )


def _by_columns(table):
    """A copy whose columns lie in memory one after the other."""
    return aligned(table.T).T


def _engine_order_forces(modes, scene, grid):
    """Modal forces of the travelling load at the start of every step of a block, (P or 0, K)."""
    if not scene.load:
        return np.zeros((0, len(modes.omega)))
    interface = scene.interface
    turned = np.arange(grid.steps_per_block) * (2.0 * np.pi / grid.steps_per_revolution)
    load = scene.load * interface.share
    force = load * np.cos(scene.load_order * (interface.angle + turned[:, None]))
    return aligned(force @ modes.normal)


def _unit_loads(modes, scene):
    """Modal forces of a unit multiplier in every row of `State.multiplier` but the last."""
    normal, tangential = _columns(modes.normal), _columns(modes.tangential)
    if len(modes.axial) > 0:
        return -np.hstack([normal, tangential, _columns(modes.axial)])
    if scene.kinematics == "polar":
        return -np.hstack([normal, tangential])
    return -(normal + scene.friction * tangential)


def _allocate_state(scheme, width):
    n_modes, n_points = scheme.normal.shape
    n_forces = scheme.load.shape[1]
    return State(
        position=aligned_zeros((n_modes, width)),
        increment=aligned_zeros((n_modes, width)),
        penetration=aligned_zeros((n_points + 1, width)),
        multiplier=aligned_zeros((n_forces, width)),
        depth=aligned_zeros((n_points + 1, width)),
        active=np.full(n_forces + TILE, n_forces - 1),
        ramp=aligned_zeros((1, width)),
        n_steps=np.zeros(width, dtype=np.int64),
        report=aligned_zeros((4, width)),
    )


def _allocate_record(scene, grid, n_observed, width):
    n_blocks = 2 * scene.steady.window_revolutions * grid.blocks_per_revolution
    n_records = grid.steps_per_block // grid.stride
    return Record(
        history=aligned_zeros((n_blocks * n_records * n_observed, width)),
        peak=aligned_zeros((n_blocks * n_observed, width)),
    )


def _padded(n):
    """The next multiple of a tile."""
    return -(-n // TILE) * TILE


def _columns(rows):
    """Rows (n, K) as columns of a table, padded with zeros to whole tiles (K, n_padded)."""
    return np.pad(rows.T, ((0, 0), (0, _padded(len(rows)) - len(rows))))


def _allocate_polar(scene, grid, n_points, width):
    enabled = scene.kinematics == "polar"
    rows = n_points if enabled else 0
    return Polar(
        enabled=enabled,
        angle=scene.interface.angle.copy(),
        radius=scene.interface.radius,
        pitch=2.0 * np.pi / scene.n_bumps,
        height=scene.bump_height,
        clearance=scene.clearance + scene.interface.clearance,
        friction=scene.friction,
        turn=2.0 * np.pi / grid.steps_per_revolution,
        compliance=aligned_zeros((4 * rows**2, width)),
        moved=aligned_zeros((3 * rows, width)),
        cosine=aligned_zeros((rows, width)),
        sine=aligned_zeros((rows, width)),
        deepest=aligned_zeros((1, width)),
    )


def _allocate_spatial(scene, grid, modes, width):
    interface, axial = scene.interface, _columns(modes.axial)
    n_modes, n_points = axial.shape
    starts = _groups(interface.points_per_blade)
    most = int(np.diff(starts).max())
    way = np.zeros(n_points)
    way[: len(interface.radius)] = interface.radius * 2.0 * np.pi / grid.steps_per_revolution
    return Spatial(
        points=np.argsort(interface.blade, kind="stable"),
        blade=interface.blade,
        starts=starts,
        way=way,
        friction=scene.friction,
        axial=_by_columns(axial),
        compliance=aligned_zeros((3 * n_points**2, width)),
        before=aligned_zeros((n_modes, width)),
        cosine=aligned_zeros((n_points, width)),
        sine=aligned_zeros((n_points, width)),
        touching=aligned_zeros((n_points, width)),
        groups=np.zeros(len(starts), dtype=np.int64),
        turned=np.zeros(n_points, dtype=np.bool_),
        deepest=aligned_zeros((interface.n_blades, width)),
        fresh=np.zeros(n_points + TILE, dtype=np.int64),
        slipping=np.zeros(TILE, dtype=np.int64),
        chosen=np.zeros(most, dtype=np.int64),
        factor=aligned_zeros((most**2, width)),
        right=aligned_zeros((most, width)),
        wrong=aligned_zeros((most, width)),
        steps_touched=aligned_zeros((interface.n_blades, width)),
    )


def _groups(points_per_blade):
    """Starts of groups of neighbouring blades: as few as hold at most GROUP points each."""
    starts, ends = [0], np.cumsum(points_per_blade)
    for begin, end in zip(ends[:-1], ends[1:], strict=True):
        if end - starts[-1] > GROUP:
            starts.append(int(begin))
    return np.array([*starts, int(ends[-1])])


def empty_lane(bank: Bank, lane: int) -> None:
    """Leave a lane idle (bank is modified): its time stands still, so no bump ever grows for it.

    Parameters
    ----------
    bank : Bank
        Bank of the lane (modified).
    lane : int
        Index of the lane.
    """
    scheme, state = bank.scheme, bank.state
    for array in (scheme.decay, scheme.gain, *bank.contact):
        array[:, lane] = 0.0
    if bank.spatial:
        for array in (bank.spatial.before, bank.spatial.touching, bank.spatial.steps_touched):
            array[:, lane] = 0.0
    for array in (state.position, state.increment, state.multiplier, state.ramp, state.report):
        array[:, lane] = 0.0
    scheme.step[lane] = state.n_steps[lane] = 0


def fill_lane(bank: Bank, lane: int, modes: Modes, scene: Any, h: float) -> None:
    """Put a lane at rest, with the coefficients of one speed (bank is modified).

    Parameters
    ----------
    bank : Bank
        Bank of the lane (modified).
    lane : int
        Index of the lane.
    modes : Modes
        Of the sample, at the lane's speed.
    scene : response.sweep.Scene
        Casing, friction and integration scheme.
    h : float
        Time step [s].
    """
    empty_lane(bank, lane)
    scheme = bank.scheme
    scheme.decay[:, lane], scheme.gain[:, lane] = coefficients(
        scene.scheme, modes.omega, ratios(scene.damping_ratio, modes.omega), h
    )
    if scheme.squared.ndim == 2:
        scheme.squared[:, lane] = modes.omega**2
    scheme.step[lane] = h
    motion = np.stack([modes.normal.T, modes.tangential.T])
    gain = scheme.gain[:, lane]
    W = np.array([[delassus(to, by, gain) for by in motion] for to in motion])
    if bank.spatial:
        _fill_spatial(bank, lane, modes, scene.friction)
        return
    if bank.polar.enabled:
        _spread(bank.polar.compliance.reshape(2, 2, -1, scheme.decay.shape[1]), lane, W)
        bank.contact.reach[0, lane] = reach = _polar_reach(W, scene.friction)
        known = NONE if np.isfinite(reach) else UNPROVEN
        bank.state.report[FLAW, lane] = known if np.isfinite(W).all() else NOT_FINITE
        return
    normal = W[0, 0] + scene.friction * W[0, 1]
    bank.state.report[FLAW, lane] = flaw = complementarity.flaw(normal)
    if flaw in (NONE, UNPROVEN):  # else the point has no forces, and no result once it touches
        _fill_contact(bank.contact, lane, normal)


def _fill_spatial(bank, lane, modes, friction):
    """Give a lane its compliances, and what is known of them for any direction of friction."""
    gain, spatial = bank.scheme.gain[:, lane], bank.spatial
    forces = modes.normal, modes.tangential, modes.axial
    W = np.stack([delassus(modes.normal.T, by.T, gain) for by in forces])
    flaw = complementarity.flaw(W[0] + friction * W[1])
    bank.state.report[FLAW, lane] = flaw
    if flaw in (NONE, UNPROVEN):
        table = spatial.compliance.reshape(-1, 3, spatial.compliance.shape[1])
        _spread(np.moveaxis(table, 1, 0), lane, np.swapaxes(W, 1, 2))
        bound = np.abs(W[0]) + friction * np.hypot(W[1], W[2])
        others = spatial.blade[:, None] != spatial.blade
        bank.contact.reach[0, lane] = (bound * others).max()


def _fill_contact(contact, lane, W):
    """Give a lane its Delassus operator (contact is modified)."""
    diagonal = np.diag(W)
    coupling = W / diagonal
    np.fill_diagonal(coupling, 0.0)
    _spread(contact.coupling, lane, coupling)
    contact.stiffness[: len(diagonal), lane] = 1.0 / diagonal
    contact.reach[0, lane] = _reach(np.abs(coupling).sum(axis=1).max())


def set_motion(
    bank: Bank, lane: int, position: np.ndarray, velocity: np.ndarray, time: float
) -> None:
    """Start a filled lane from a motion at the begin of a block (bank is modified).

    Parameters
    ----------
    bank : Bank
        Bank of the lane (modified).
    lane : int
        Index of the lane.
    position : ndarray (K,)
        Modal coordinates [m·√kg].
    velocity : ndarray (K,)
        Modal velocities, mean over the step before [m·√kg/s].
    time : float
        Since the bumps began to grow [s].
    """
    h = bank.scheme.step[lane]
    bank.state.position[:, lane] = position
    bank.state.increment[:, lane] = h * velocity
    bank.state.n_steps[lane] = round(time / h)


def motion(bank: Bank, lane: int) -> tuple[np.ndarray, np.ndarray, float]:
    """Motion of a lane, as `set_motion` takes it.

    Parameters
    ----------
    bank : Bank
        Bank of the lane.
    lane : int
        Index of the lane.

    Returns
    -------
    position : ndarray (K,)
        Modal coordinates [m·√kg].
    velocity : ndarray (K,)
        Modal velocities, mean over the step before [m·√kg/s].
    time : float
        Since the bumps began to grow [s].
    """
    h, state = bank.scheme.step[lane], bank.state
    velocity = state.increment[:, lane] / h
    return state.position[:, lane].copy(), velocity, state.n_steps[lane] * h


def steps_touched(bank: Bank, lane: int) -> np.ndarray:
    """Steps in which every blade carried a force since its lane was filled (N,).

    (0,) of a disk without axial motion, whose contacts are not counted.
    """
    return bank.spatial.steps_touched[:, lane].copy() if bank.spatial else np.zeros(0)


def _spread(table, lane, values):
    """Write values (..., n, n) to the lane's padded rows of a table (..., C·C, L) (modified)."""
    n_points = math.isqrt(table.shape[-2])
    n = values.shape[-1]
    rows = (np.arange(n)[:, None] * n_points + np.arange(n)[None, :]).ravel()
    table[..., rows, lane] = values.reshape(*values.shape[:-2], n * n)


def _reach(rho):
    return rho / (1.0 - rho) if rho < 1.0 else np.inf


def _polar_reach(W, friction):
    """Bound of `Contact.reach` for any normals: spectral norms over the smallest own compliance."""
    if not np.isfinite(W).all():
        return np.inf
    blocks = np.moveaxis(W, (0, 1), (2, 3))
    size = np.linalg.norm(blocks, 2, axis=(2, 3)) * math.sqrt(1.0 + friction**2)
    own = np.einsum("iiab->iab", blocks) @ np.array([[1.0, -friction], [friction, 1.0]])
    smallest = np.linalg.eigvalsh((own + np.swapaxes(own, 1, 2)) / 2.0)[:, 0].min()
    if smallest <= 0.0:
        return np.inf
    np.fill_diagonal(size, 0.0)
    return _reach(size.sum(axis=1).max() / smallest)
