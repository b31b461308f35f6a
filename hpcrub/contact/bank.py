"""Banks of lanes: the arrays with which the kernel integrates speeds of one sample in time."""

from collections.abc import Iterable
from typing import Any

import numpy as np

from hpcrub.contact.arrays import Bank, Scheme, State, clear_lane, packed
from hpcrub.contact.cyclic import Cyclic
from hpcrub.contact.dense import Dense
from hpcrub.contact.lanes import TILE, lane_arrays
from hpcrub.contact.laws.planar import Planar
from hpcrub.contact.laws.solid import Solid
from hpcrub.contact.lcp.gauss_seidel import ROOM
from hpcrub.contact.protocols import Grid, Scene
from hpcrub.contact.recurrence import coefficients
from hpcrub.contact.tables import columns, vectors
from hpcrub.model.reduction import Modes

KIB = 128  # numbers in a KiB


def allocate(
    modes: Modes, scene: Scene, grid: Grid, width: int, speeds_hz: Iterable[float] = ()
) -> Bank:
    """Bank of lanes at rest, for one sample and one band of speeds.

    modes: of the sample.
    scene: response.scene.Scene, with casing, contact law and integration scheme.
    grid: response.revolution.Grid, the division of a revolution into steps and blocks.
    width: number of lanes.
    speeds_hz: speeds of the first lanes, at most ``width`` [Hz]; the other lanes are idle.
    """
    law = scene.law or (Solid if len(modes.axial) else Planar)
    rows = modes.rows
    scheme = _allocate_scheme(modes, rows, scene, grid, width, law)
    state = _allocate_state(scheme, width, len(modes.axial) > 0, len(rows.bent), scene)
    basis = Cyclic.allocate(rows, modes.blades, width) if modes.blades else Dense()
    bank = packed(Bank(scheme, state, law.allocate(rows, scene, grid, width), basis))
    for lane, speed in enumerate(speeds_hz):
        h = 1.0 / (speed * grid.steps_per_revolution)
        fill_lane(bank, lane, modes.at(speed), scene.at(speed), h)
    return bank


def _allocate_scheme(
    modes: Modes, rows: Any, scene: Scene, grid: Grid, width: int, law: Any
) -> Any:
    interface, normal = scene.interface, columns(rows.normal)
    bump = scene.casing.table(interface.angle, grid.steps_per_revolution, grid.steps_per_block)
    own = np.full((1, normal.shape[1]), np.inf)  # nothing touches at the padding
    own[0, : len(modes.normal)] = interface.clearance
    n_modes = len(rows.omega)
    # tiles of modes may begin anywhere; rows whole KiB apart would share few places of a cache
    room = TILE if (n_modes + TILE) % KIB else TILE + 8
    kept = 0 if modes.blades else n_modes  # the cyclic basis has its own tables, of one blade
    load = np.pad(np.ascontiguousarray(law.loads(rows, scene)[:kept].T), ((0, 1), (0, room)))
    observed, bent = columns(rows.observed), columns(rows.bent)
    stress = vectors(rows.stress[: len(rows.stress) * scene.observes_stress])
    return Scheme(
        normal=normal[:kept],
        observed=observed[:kept],
        stress=stress,
        stiffer=np.ones((stress.size // max(n_modes + n_modes % 2, 1), width)),
        load=load,
        decay=np.zeros((n_modes, width)),
        gain=np.zeros((n_modes, width)),
        omega2=np.zeros((n_modes, width)) if len(modes.stiffening) else rows.omega**2,
        # the three forces of a point in three dimensions would take longer than the corrector
        observed_per_force=np.zeros(
            (0 if len(modes.axial) else len(load) * observed.shape[1], width)
        ),
        clearance=np.full((1, width), scene.clearance),
        point_clearance=own,
        step=np.zeros(width),
        bump=columns(bump.T),
        external=_engine_order_forces(modes, rows, scene, grid),
        bent=bent[:kept],
        push=np.pad(rows.bent_forces[:, :n_modes], ((0, 0), (0, room))) if len(rows.bent) else None,
        turn=_turns(modes, grid, width),
        casing=2 * len(modes.pairs.omega),
        ramp_time=scene.ramp_time,
    )


def _turns(modes: Modes, grid: Grid, width: int) -> Any:
    """Cosine and sine of the angle by which each pair of the casing turns in a step."""
    angle = modes.pairs.n_waves * (2.0 * np.pi / grid.steps_per_revolution)
    of_casing = np.stack([np.cos(angle), np.sin(angle)], axis=-1).ravel()
    n_turned = modes.n_rows - len(modes.real)
    turn = np.zeros((n_turned, width))
    turn[n_turned - len(of_casing) :] = of_casing[:, None]
    return turn


def _engine_order_forces(modes: Modes, rows: Any, scene: Scene, grid: Grid) -> Any:
    """Modal forces of the travelling load at the start of every step of a block (P, K), or None."""
    if not scene.load:
        return None
    interface = scene.interface
    turned = np.arange(grid.steps_per_block) * (2.0 * np.pi / grid.steps_per_revolution)
    load = scene.load * interface.share
    force = load * np.cos(scene.load_order * (interface.angle + turned[:, None]))
    n_casing = 2 * len(modes.pairs.omega)
    on_disk = rows.forces[0][:, : modes.n_rows - n_casing]
    return np.pad(force @ on_disk, ((0, 0), (0, n_casing)))


def _allocate_state(scheme: Scheme, width: int, turns: Any, n_bent: Any, scene: Scene) -> Any:
    second: Any = scene.interface.second_order
    n_modes, n_points = len(scheme.decay), scheme.normal.shape[1]
    n_forces = len(scheme.load)
    return State(
        **lane_arrays(
            width, position=n_modes, increment=n_modes, penetration=n_points + 1,
            multiplier=n_forces, depth=n_points + 1, ramp=1, report=4,
        ),
        increment_before=np.zeros((n_modes, width)) if turns else None,
        active=np.full(n_forces + ROOM, n_forces - 1),
        n_steps=np.zeros(width, dtype=np.int64),
        late=np.zeros((n_bent, width)) if n_bent else None,
        beyond=np.zeros((scheme.observed.shape[1], width)) if n_bent else None,
        before=np.zeros((n_bent, width)) if n_bent and len(second.inertia) else None,
    )  # fmt: skip


def empty_lane(bank: Bank, lane: int) -> None:
    """Leave a lane idle (bank is modified): its time stands still, and its bumps never grow."""
    scheme, state = bank.scheme, bank.state
    moved = state.position, state.increment, state.multiplier, state.ramp, state.report
    for array in (scheme.decay, scheme.gain, *moved, state.late, state.beyond, state.before):
        if array is not None:
            array[:, lane] = 0.0
    clear_lane(bank.law, lane)
    clear_lane(bank.basis, lane)
    scheme.step[lane] = state.n_steps[lane] = 0


def fill_lane(bank: Bank, lane: int, modes: Modes, scene: Scene, h: float) -> None:
    """Put a lane at rest, with the coefficients of one speed (bank is modified).

    modes, scene: as in `allocate`, but at the speed of the lane; h: time step [s].
    """
    empty_lane(bank, lane)
    scheme, ratios = bank.scheme, modes.damping_ratios(scene.damping_ratio)
    rows, waves, n_real = modes.rows, modes.waves, len(modes.real)
    scheme.decay[:, lane], scheme.gain[:, lane] = coefficients(scene.scheme, rows.omega, ratios, h)
    if waves:
        _fill_waves(bank, lane, n_real, waves.eigenvalue, h)
    if len(turn := scheme.turn[:, lane]):
        rows = _kicked(rows, turn[::2], turn[1::2])
    if scheme.omega2.ndim == 2:
        scheme.omega2[:, lane] = rows.omega**2
    if len(scheme.observed_per_force):
        kicks = scheme.load[:, : len(rows.omega)] * scheme.gain[:, lane]
        moved = scheme.observed_per_force[:, lane].reshape(len(kicks), -1)  # a view
        # not a matrix product, whose rounding may depend on the padding
        np.einsum("fk,ok->fo", kicks, rows.observed, out=moved[:, : len(rows.observed)])
    scheme.step[lane], scheme.clearance[0, lane] = h, scene.clearance
    bank.law.fill(bank, lane, rows, scene)
    bank.basis.fill(bank, lane, modes, scene)
    if scheme.external is not None:
        _halve_first_impulse(bank, lane, n_real)


def _halve_first_impulse(bank: Bank, lane: int, n_real: Any) -> None:
    """Take half an impulse of the load from a lane at rest (bank is modified).

    A step takes a whole impulse at its begin, of which the first step has the second half alone.
    """
    half = bank.scheme.gain[:, lane] * bank.scheme.external[0] / 2.0
    bank.state.increment[:n_real, lane] -= half[:n_real]
    bank.state.position[n_real:, lane] -= half[n_real:]  # complex modes, which have no increment


def _fill_waves(bank: Bank, lane: int, first: Any, eigenvalue: Any, h: Any) -> None:
    """Give a lane its complex modes in the rows from ``first`` on (bank is modified).

    A force kicks z along e^{λh}. The gain is taken from a real mode of the same frequency and
    damping, so that the response to a constant force is exact; what `Waves.force` tells, times
    Im λ, is the same in all lanes.
    """
    scheme, size, angle = bank.scheme, np.abs(eigenvalue), eigenvalue.imag * h
    gain = coefficients("exact_modal", size, -eigenvalue.real / size, h)[1]
    gain, decay = gain / np.sin(angle), np.exp(eigenvalue.real * h)
    n = 2 * len(angle)
    scheme.gain[first : first + n, lane] = np.repeat(gain, 2)
    scheme.decay[first : first + n, lane] = np.repeat(decay, 2)
    scheme.turn[0:n:2, lane], scheme.turn[1:n:2, lane] = np.cos(angle), -np.sin(angle)


def _kicked(rows: Any, cosine: Any, sine: Any) -> Any:
    """Rows whose last are pairs, with `normal` and `observed` turned against a kick."""

    def moved(displacement: Any) -> Any:
        turned, first = displacement.copy(), displacement.shape[1] - 2 * len(cosine)
        re, im = displacement[:, first::2], displacement[:, first + 1 :: 2]
        turned[:, first::2] = cosine * re - sine * im
        turned[:, first + 1 :: 2] = sine * re + cosine * im
        return turned

    return rows._replace(normal=moved(rows.normal), observed=moved(rows.observed))


def set_motion(
    bank: Bank, lane: int, position: np.ndarray, velocity: np.ndarray, time: float, memory: Any
) -> None:
    """Start a filled lane from a motion at the begin of a block (bank is modified).

    position: (K,) modal coordinates [m·√kg].
    velocity: (K,) modal velocities, mean over the step before, without a load at time 0 [m·√kg/s].
    time: since the bumps began to grow [s].
    memory: memory of the contact law; None: nothing has touched before.
    """
    h, state = bank.scheme.step[lane], bank.state
    if time > 0.0:  # else the load begins as at rest
        state.position[:, lane] = state.increment[:, lane] = 0.0
    state.position[:, lane] += position
    state.increment[:, lane] += h * velocity
    bank.basis.start(bank, [lane])
    state.n_steps[lane] = round(time / h)
    if memory is not None:
        bank.law.remember(lane, memory)


def motion(bank: Bank, lane: int) -> tuple[np.ndarray, np.ndarray, float, Any]:
    """Motion of a lane: position, velocity, time and memory as in `set_motion`."""
    h, state = bank.scheme.step[lane], bank.state
    velocity, memory = state.increment[:, lane] / h, bank.law.memory(lane)
    return state.position[:, lane].copy(), velocity, state.n_steps[lane] * h, memory
