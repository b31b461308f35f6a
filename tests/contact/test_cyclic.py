"""The cyclic basis: poles of its step, and the kernel against programs that share no code with it.

The twin of a step is a matrix: it sums the modes of all blades, where the kernel takes a Fourier
series, and has the forces of the deviations in the matrix. Truth are also the modes of every
mistuned disk by itself, which the dense basis integrates; its tests are elsewhere.
"""

import numpy as np
import pytest
from scipy.linalg import expm

from evidence.truth.energy import audit
from evidence.validation.report import fitted_order
from hpcrub.contact.bank import allocate, fill_lane, motion, set_motion
from hpcrub.contact.cyclic_arrays import blade_stiffness
from hpcrub.contact.integrate import run
from hpcrub.contact.observers import Record
from hpcrub.contact.recurrence import coefficients
from hpcrub.model.casing import CasingShape
from hpcrub.model.casing_modes import CasingModes
from hpcrub.model.coating import Coating, ElasticCasing
from hpcrub.model.damping import ratios_of, state_matrix
from hpcrub.model.tuned_basis import tuned_basis
from hpcrub.response.revolution import Grid
from hpcrub.response.scene import Scene
from hpcrub.response.steady import SteadyCriteria
from hpcrub.response.sweep import Disk, Motion, run_sweep, run_sweeps
from tests.contact.test_kernel import plain_python, textbook
from tests.model.test_tuned_basis import WIDE, in_air, small_disk, stiffness_of, with_stress

WIDTH, REVOLUTION, SPEED, XI = 8, 1200, 80.0, 0.01
ORDINARY = 0.1 * WIDE  # deviations up to 5 % [-]


def sample(n_blades=5, deviation=ORDINARY, reference=0.06, by_modes=False):
    """Modes of a mistuned disk on the basis of its tuned one."""
    basis = tuned_basis(with_stress(small_disk(n_blades, by_modes)), reference)
    return basis.modes_of(deviation[:n_blades]).fixed


def by_itself(modes):
    """The Modes of the same disk, which no blade deviates from."""
    squared, vectors = np.linalg.eigh(stiffness_of(modes))
    names = "normal", "tangential", "axial", "observed", "shapes"
    rows = {name: getattr(modes, name) @ vectors for name in names}
    stress = modes.blades.stiffer[:, None] * (modes.stress @ vectors)
    return modes._replace(omega=np.sqrt(squared), **rows, stress=stress, blades=None)


def late(modes, damping_ratio, h):
    """Matrices (K, K) of q and of q before, and factors (K,) of the forces, in a step h."""
    decay, gain = coefficients("exact_modal", modes.omega, ratios_of(damping_ratio, modes.omega), h)
    y, (deviations, lag) = modes.blades.modes, blade_stiffness(modes, damping_ratio, h, True)
    K = np.einsum("bj,bjk,bjl->kl", deviations, y, y) + np.diag(modes.omega**2)
    C = np.einsum("bj,bj,bjk,bjl->kl", deviations, lag, y, y)
    one, g = np.eye(len(gain)), gain[:, None]
    return one + np.diag(decay) - g * (K + C), g * C - np.diag(decay), gain


def matrix_of(modes, damping_ratio, h):
    """Matrix of a step without contact on q and q before (2K, 2K)."""
    now, before, _ = late(modes, damping_ratio, h)
    return np.block([[now, before], [np.eye(len(now)), np.zeros_like(now)]])


def step_of(modes, damping_ratio, h):
    """The step in the terms of `textbook`."""
    now, before, gain = late(modes, damping_ratio, h)
    return lambda q, p: now @ q + before @ p, gain


def poles(modes, damping_ratio, h, n):
    """Frequencies [rad/s] and damping ratios of the lowest n motions of the scheme."""
    values = np.log(np.linalg.eigvals(matrix_of(modes, damping_ratio, h)).astype(complex)) / h
    values = sorted(values[values.imag > 0.0], key=abs)[:n]
    return np.abs(values), -np.real(values) / np.abs(values)


@pytest.mark.parametrize(
    ("n_blades", "by_modes", "ratio"), [(5, False, 0.0), (6, True, 0.002), (5, False, 0.02)]
)
def test_poles_are_those_of_the_mistuned_disk(n_blades, by_modes, ratio):
    """Of three families; one mode alone would be exact: a tenth of δ(ωh)²/24 is left.

    Damping changes a frequency by δξωh/4, and damping ratios are exact to δ²/8 of them.
    """
    modes, n = sample(n_blades, by_modes=by_modes), 3 * n_blades
    exact = np.sqrt(np.linalg.eigvalsh(stiffness_of(modes)))[:n]
    most = np.abs(modes.blades.deviation).max()
    for h in (1e-5, 5e-6):
        found, damping = poles(modes, ratio, h, n)
        bound = most * (0.1 * (exact * h) ** 2 / 24.0 + ratio * exact * h / 4.0)
        assert (np.abs(found / exact - 1.0) < bound).all()
        off = np.abs(damping - ratio)
        assert off[:n_blades].max() < ratio * most**2 / 8.0 + 1e-9
        assert off.max() < ratio * most / 8.0 + 1e-9  # where families lie near each other


@pytest.mark.parametrize(("n_blades", "ratio"), [(5, 0.0), (6, 1e-3), (5, 0.3)])
def test_every_step_is_stable_at_any_deviation_up_to_the_reference(n_blades, ratio):
    """Steps that resolve all modes, and steps of hundreds of periods; not so above it."""
    basis = tuned_basis(small_disk(n_blades, n_families=0), 0.5)

    def largest(deviation, h):
        modes = basis.modes_of(np.full(n_blades, 0.5))
        change = modes.blades._replace(deviation=deviation[:n_blades] - 0.5)
        return np.abs(np.linalg.eigvals(matrix_of(modes._replace(blades=change), ratio, h))).max()

    for deviation in (WIDE, np.full(6, -0.5), np.where(np.arange(6) == 1, 0.5, -0.5)):
        for h in (1e-6, 4e-6, 1e-5, 5e-5, 1e-3, 0.3):
            assert largest(deviation, h) < 1.0 + 1e-10, h
    assert largest(np.full(6, 1.5), 1e-3) > 1.01


def scene_of(face, **changes):
    """A casing with two bumps that the tips touch."""
    scene = Scene(face, XI, CasingShape(2, 3e-4), 1e-4, 1e-3, 0.2, scheme="exact_modal")
    return scene._replace(**changes)


def integrated(disks, scene, n_steps, speeds=(SPEED,), revolution=REVOLUTION, starts=None, width=8):
    """Observed displacements (n_steps, O, lanes) of some disks of one basis, and the Bank.

    starts: position and velocity (K,) of every disk; None: rest.
    """
    bank = allocate(disks[0], scene, Grid(revolution, 1, 1), width)
    for lane, (modes, speed) in enumerate(zip(disks, np.resize(speeds, len(disks)), strict=True)):
        fill_lane(bank, lane, modes.at(speed), scene, 1.0 / (speed * revolution))
        if starts:
            set_motion(bank, lane, *starts[lane], 0.0, None)
    bank = bank._replace(scheme=bank.scheme._replace(bump=bank.scheme.bump[:n_steps]))
    record = Record.allocate(bank, 1, 1)
    run(bank, 1, record)
    found = record.history.reshape(n_steps, -1, width)
    return found[:, : len(disks[0].observed), : len(disks)], bank


BOOK = {"revolution": REVOLUTION, "reach": 1e-3, "rounding": 1e-15, "step_of": step_of}


@pytest.mark.parametrize("n_blades", [5, 6])
def test_contact_of_a_mistuned_disk_is_the_textbook_scheme(n_blades):
    """With the forces of the deviations in its matrix."""
    modes, scene = sample(n_blades), scene_of(small_disk(n_blades).interface)
    n_steps = 300
    expected, forces = textbook(modes, scene, SPEED, n_steps, **BOOK)
    found, bank = integrated([modes], scene, n_steps)
    touching = forces > 0.0
    assert touching.sum(axis=1).max() >= 3
    assert touching.any(axis=0).sum() >= 6
    assert (np.diff(touching.astype(int), axis=0) < 0).sum() >= 2  # points that lose contact
    assert np.abs(found[:, :, 0] - expected).max() < 1e-10 * np.abs(expected).max()


PAIRS = CasingModes(
    np.array([0, 1, 3, 4, 7]), np.array([2e4, 1.5e4, 1.8e4, 3e4, 4e4]), np.full(5, 0.01),
    np.array([1.0, 2.0, 1.5, 1.0, 0.7]), np.array([0.0, -1.0, -0.5, -0.3, -0.1]),
)  # fmt: skip


def with_all_rows(deviation, n_blades=5, n_families=4):
    """A disk in air, in a casing that vibrates: all kinds of rows."""
    model = in_air(small_disk(n_blades, False, n_families))[0]._replace(casing=PAIRS)
    return tuned_basis(model, 0.06).modes_of(deviation[:n_blades])


def test_a_casing_is_seen_at_the_ends_of_blocks_as_in_the_records():
    """Its forces were read beyond the end of a table that only the dense basis has."""
    modes, scene = with_all_rows(np.full(6, 0.06)).fixed, scene_of(small_disk(5).interface)
    bank = allocate(modes, scene, Grid(REVOLUTION, 6, 1), WIDTH, [SPEED])
    record = Record.allocate(bank, 6, 1, most=6)
    run(bank, 6, record)
    ends = record.ends[:, 0].reshape(6, -1)
    np.testing.assert_array_equal(ends, record.casing[:, 0].reshape(6, -1, ends.shape[1])[:, -1])
    assert np.abs(ends[-1]).max() > 0.0
    assert bank.law.touched[:, 0].max() > 0.0


def test_rows_of_air_and_casing_move_as_in_the_dense_basis():
    modes, scene = with_all_rows(np.full(6, 0.06)).fixed, scene_of(small_disk(5).interface)
    assert modes.n_rows == len(modes.omega) + 5 + 10
    found, bank = integrated([modes], scene, REVOLUTION)
    dense, same = integrated([modes._replace(blades=None)], scene, REVOLUTION)
    assert bank.law.touched[:, 0].max() > 0.0
    np.testing.assert_array_equal(bank.law.touched[:, 0], same.law.touched[:, 0])
    assert np.abs(found - dense).max() < 1e-9 * np.abs(dense).max()
    q, own = bank.state.position[:, 0], same.state.position[:, 0]
    for rows in np.split(np.arange(modes.n_rows), np.cumsum(modes.rows.counts)[:2]):
        assert np.abs(q - own)[rows].max() < 1e-8 * np.abs(own[rows]).max() > 0.0


def test_a_free_motion_in_air_is_that_of_its_equations():
    """Of a mistuned disk, by the exponential of its matrices of damping and stiffness.

    The first push of a deviation is whole, where half a step has gone: an error of the first order.
    """
    modes = with_all_rows(ORDINARY).fixed
    waves, K = modes.waves, len(modes.omega)
    q, v = np.zeros((2, K))
    q[waves.rows], v[waves.rows] = np.random.default_rng(4).normal(size=(2, 5))
    v *= modes.omega
    stiffness, damping = stiffness_of(modes), np.diag(2.0 * XI * modes.omega)
    family = np.ix_(waves.rows, waves.rows)
    stiffness[family] += waves.stiffness
    damping[family] = waves.damping
    errors, finer = [], np.array([1, 2])
    for n in REVOLUTION * finer:
        h, n_steps, state, exact = 1.0 / (SPEED * n), n // 3, np.append(q, v), []
        step = expm(h * state_matrix(damping, stiffness))
        start = np.zeros((2, modes.n_rows))  # nothing but the waves moves, which have no velocity
        start[0, len(modes.real) :][:10] = waves.parts(q[waves.rows], v[waves.rows])
        scene = scene_of(small_disk(5).interface, clearance=1e3)
        found, _ = integrated([modes], scene, n_steps, revolution=n, starts=[start])
        for _ in range(n_steps):
            state = step @ state
            exact.append(modes.observed @ state[:K])
        errors.append(np.abs(found[:, :, 0] - exact).max() / np.abs(exact).max())
    assert errors[0] < 1e-2
    assert 0.9 < fitted_order(1.0 / finer, np.array(errors)) < 1.1


def test_a_motion_goes_on_as_if_it_had_not_stopped():
    """From a step in contact, with all kinds of rows."""
    modes, h = with_all_rows(ORDINARY).fixed, 1.0 / (SPEED * REVOLUTION)
    scene = scene_of(small_disk(5).interface, casing=CasingShape(8, 3e-4))

    def part(n_blocks, start):
        bank = allocate(modes, scene, Grid(REVOLUTION, 8, 1), WIDTH, [SPEED])
        if start is not None:
            set_motion(bank, 0, *start)
        record = Record.allocate(bank, n_blocks, 1)
        run(bank, n_blocks, record)
        return record.history[:, 0], motion(bank, 0), bank

    whole, end, _ = part(4, None)
    first, start, bank = part(1, None)
    later, same, _ = part(3, start)
    assert (bank.state.multiplier[:, 0] > 0.0).any()
    assert start[2] == pytest.approx(h * REVOLUTION / 8)
    assert np.abs(np.append(first, later) - whole).max() < 1e-11 * np.abs(whole).max()
    np.testing.assert_allclose(same[0], end[0], atol=1e-11 * np.abs(end[0]).max())


FEW = 16  # steps
EVERYTHING = {
    "coating": Coating(2e-4, 1e9, 8e6, 2e8, 5e-4),
    "elastic_casing": ElasticCasing(2e8, 300.0),
    "load": 50.0,
    "load_order": 3,
}


SCENES = ("load", "load_order"), ("coating", "elastic_casing")


@pytest.mark.parametrize("names", SCENES, ids=["rigid", "both"])
def test_energy_of_a_mistuned_disk_in_a_ring_is_balanced(names):
    """To rounding, with the springs of the deviations; no impact on a rigid casing gives energy."""
    face = small_disk(5).interface
    scene = scene_of(face, **{name: EVERYTHING[name] for name in names})
    modes = sample()._replace(pairs=PAIRS.seen_from(face.angle))
    bank = allocate(modes, scene, Grid(REVOLUTION, 1, 1), WIDTH, [SPEED])
    books = audit(bank, 2 * REVOLUTION, scene, modes)
    assert books.unexplained()[0] < 1e-13
    assert books.is_balanced()[0] or scene.coating
    assert books.impact[:, 0].sum() > 0.0


def turned(n_steps, deviation, dense=False, width=WIDTH, **changes):
    """Displacements of a disk of few modes with all kinds of rows, and what it has worn."""
    modes = with_all_rows(deviation, n_families=0)
    modes = modes if changes else modes.fixed
    modes = modes._replace(blades=None) if dense else modes
    scene = scene_of(small_disk(5).interface, ramp_time=1e-4, **changes)
    found, bank = integrated([modes, modes], scene, n_steps, (SPEED, 1.03 * SPEED), width=width)
    worn = getattr(bank.law.surface, "worn", np.zeros((0, width)))
    return np.concatenate([found.reshape(-1, 2), worn[:, :2]])


def twins():
    """Columns: a mistuned disk; all features, the same disk in both bases, and in fewer lanes."""
    found = [turned(FEW, np.full(6, 0.06), dense, **EVERYTHING) for dense in (False, True)]
    found.append(turned(FEW, np.full(6, 0.06), width=4, **EVERYTHING))
    rigid = turned(FEW, ORDINARY)
    return np.hstack([np.pad(rigid, ((0, len(found[0]) - len(rigid)), (0, 0))), *found])


def test_compiled_steps_are_their_plain_python_twins(tmp_path):
    """And plain ones the same in both bases with all features, which take long to compile."""
    rigid, same, dense, few = np.split(plain_python("twins()", __name__, tmp_path), 4, axis=1)
    np.testing.assert_array_equal(few, same)
    assert np.abs(same - dense).max() < 1e-9 * np.abs(dense).max()
    assert same[FEW * 10 :].max() > 0.0  # something is worn
    found = turned(FEW, ORDINARY)
    assert np.abs(found).max() > 1e-5
    assert np.abs(rigid[: len(found)] - found).max() < 1e-10 * np.abs(found).max()


ASKED = np.array([90.0, 78.0, 80.0, 81.5])  # [Hz], on two rungs


def short_sweep():
    """A Scene whose speeds end after three or four revolutions, and that observes stresses."""
    steady = SteadyCriteria(0.02, window_revolutions=1, extend_revolutions=1, max_time=0.045)
    face = with_stress(small_disk(5)).interface
    return scene_of(face, step=2e-5, steady=steady, observes_stress=True)


def same_bits(found, expected):
    """Whether all arrays of two sweeps are the same."""
    ours, others = found.by_name(), expected.by_name()
    return all(np.array_equal(ours[n], others[n], equal_nan=True) for n in others)


def test_disks_that_fill_the_lanes_together_have_the_bits_of_each_alone():
    """In any order, some speeds alone, started at rest or going on; more points than lanes."""
    scene = short_sweep()
    samples = [sample(5, s * ORDINARY) for s in (1.0, -1.0, 0.3, 0.0)]
    chosen = [None, [3, 2, 0], None, [1]]

    def disks(order, motions):
        return [Disk(samples[i], chosen[i], motions[i]) for i in order]

    def at_rest():
        return [Motion.at_rest(len(ASKED), samples[0].n_rows) if i != 2 else None for i in range(4)]

    alone, kept = at_rest(), at_rest()
    for _ in range(2):
        expected = [run_sweep(disk.modes, scene, ASKED, selection=disk[1], motion=disk[2])
                    for disk in disks(range(4), alone)]  # fmt: skip
        order = [0, 3, 1, 2]  # a lane that is taken again starts at rest
        found = dict(run_sweeps(disks(order, kept), scene, ASKED))
        for place, i in enumerate(order):
            assert same_bits(found[place], expected[i])
            assert found[place].n_steps == expected[i].n_steps > 0
        for ours, others in zip(kept, alone, strict=True):
            for name in ("position", "velocity", "time") if ours else ():
                assert np.array_equal(getattr(ours, name), getattr(others, name))
    amplitudes = [result.amplitude for result in expected]
    assert np.isfinite(amplitudes[0]).all()
    assert np.isfinite(expected[0].stress).all()
    assert np.isfinite(amplitudes[1]).tolist() == [True, False, True, True]
    assert abs(amplitudes[0] / amplitudes[2] - 1.0).max() > 1e-2


def test_a_sweep_finds_the_amplitudes_and_stresses_of_the_dense_basis():
    """At the reference the same disk, and near it nearly so."""
    scene = short_sweep()
    for deviation, error in ((np.full(6, 0.06), 1e-9), (ORDINARY, 2e-2)):
        modes = sample(5, deviation)
        found, own = (run_sweep(m, scene, ASKED) for m in (modes, by_itself(modes)))
        for name in ("amplitude", "stress", "half_peak_to_peak"):
            np.testing.assert_allclose(getattr(found, name), getattr(own, name), rtol=error)
