"""The second programs for rotors that gain or lose speed: against closed forms and each other."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from evidence.truth import events, ring, run_up, run_up_rubbing
from evidence.truth.motion import Structure as OnePoint
from evidence.truth.run_up import Harmonic, linear_run, passage, passed, turned
from evidence.truth.run_up_rubbing import Structure, Wall, rubbing_run, work_and_energy

HZ = 2.0 * np.pi
TABLE = [0.0, 0.05, 0.08, 0.2], HZ * np.array([20.0, 24.0, 24.0, 21.0])  # up, hold, down


def of(value):
    """One mode."""
    return np.array([value])


@pytest.fixture(scope="module")
def disk():
    """Six modes, three tips: nothing of it is regular."""
    draw = np.random.default_rng(7)
    omega = HZ * np.array([85.0, 92.0, 97.0, 230.0, 410.0, 600.0])
    damping = np.array([5e-3, 4e-3, 6e-3, 5e-3, 1e-2, 5e-3])
    normal, tangential = draw.normal(size=(2, 3, 6)) * np.array([[[0.3]], [[0.5]]])
    return Structure(omega, damping, normal, tangential, np.array([0.0, 2.0, 4.3]))


def test_the_angle_is_the_integral_of_the_speed_and_leads_back_to_the_time():
    turning = turned(*TABLE)
    t = np.linspace(-0.01, 0.25, 1301)
    node, weight = np.polynomial.legendre.leggauss(2)
    for first, last in ((0.0, 0.03), (0.01, 0.05), (0.05, 0.08), (0.08, 0.19), (0.2, 0.3)):
        at = first + (last - first) * (node + 1.0) / 2.0
        gained = weight @ turning.speed(at) * (last - first) / 2.0
        assert turning.angle(last) - turning.angle(first) == pytest.approx(gained, rel=1e-14)
    np.testing.assert_allclose(turning.speed(t), np.interp(t, *TABLE), rtol=1e-14)
    np.testing.assert_allclose(turning.time(turning.angle(t)), t, atol=1e-15)
    assert turning.angle(0.0) == 0.0
    assert turning.acceleration(0.05) == 0.0
    with pytest.raises(ValueError, match="must increase"):
        turned([0.0, 1.0, 1.0], [1.0, 2.0, 3.0])


@pytest.mark.parametrize(("order", "start", "rate"), [
    (4, 22.0, 8.0), (4, 25.0, -8.0), (4, 23.5, 8.0), (4, 22.5, -8.0), (4, 23.0, 0.0),
    (0, 23.0, 8.0), (4, 0.0, 200.0), (4, 23.0, 1e-6),
])  # fmt: skip
def test_the_closed_form_is_the_motion_that_an_ode_solver_finds(order, start, rate):
    """Up, down, begun behind the resonance, at constant speed, from standstill, a constant load."""
    omega, force, times = HZ * 92.5, 1.0 - 0.4j, np.linspace(0.0, 0.3, 200)
    turning = turned([0.0, 1.0], [HZ * start, HZ * (start + rate)])
    exact = passed(omega, 5e-3, order, force, start, rate, times)
    run = linear_run(of(omega), of(5e-3), [Harmonic(order, of(force))], turning, times)
    assert np.abs(run[:, 0] - exact).max() < 1e-10 * np.abs(exact).max()


def test_what_the_rotating_wave_leaves_out_falls_with_the_width_of_the_resonance():
    """ω q = ω Im[F e^{iθ} z]/(2 ω_d) against the whole motion, at one rate in units of (ξω)²."""
    omega, errors = HZ * 92.5, []
    for damping in (0.04, 0.01):
        rate = 4.0 * (damping * omega) ** 2 / (4 * HZ)
        start = 92.5 / 4 * (1.0 - 5.0 * damping)
        turning = turned([0.0, 9.0], [HZ * start, HZ * (start + 9.0 * rate)])
        t = np.linspace(0.0, 3.5 / (damping * omega), 2000)
        run = linear_run(of(omega), of(damping), [Harmonic(4, of(1.0))], turning, t)[:, 0]
        z = passage(omega, damping, 4, start, rate, t)
        wave = (np.exp(4j * turning.angle(t)) * z).imag / (2.0 * omega * np.sqrt(1 - damping**2))
        errors.append(np.abs(run - wave).max() / np.abs(run).max())
    assert errors[1] < 0.3 * errors[0]
    narrow = 3e-4  # and its envelope, by the closed form of both
    rate = 4.0 * (narrow * omega) ** 2 / (4 * HZ)
    start, t = 92.5 / 4 * (1.0 - 5.0 * narrow), np.linspace(0.0, 5.0 / (narrow * omega), 200_001)
    z = passage(omega, narrow, 4, start, rate, t)
    run = passed(omega, narrow, 4, 1.0, start, rate, t)
    assert np.abs(run).max() == pytest.approx(np.abs(z).max() / (2.0 * omega), rel=1e-3)


@pytest.mark.parametrize("way", [1.0, -1.0])
@pytest.mark.parametrize(("rate", "peak", "late"), [
    (0.1, 0.993, 0.04), (1.0, 0.871, 0.27), (5.0, 0.637, 0.76), (20.0, 0.413, 1.69),
])  # fmt: skip
def test_a_passage_reaches_less_than_the_steady_peak_and_late(way, rate, peak, late):
    """A mode of 137.8 Hz, four waves, ξ = 0.005; the slow limit is the steady amplitude."""
    omega, at = HZ * 137.8, 137.8 / 4
    away = 8.0 * max(rate, 0.5) ** 0.5
    t = np.linspace(0.0, 2.0 * away / rate, 20_001)
    hz = at - way * away + way * rate * t
    z = np.abs(passage(omega, 5e-3, 4, hz[0], way * rate, t)) * 5e-3 * omega
    assert z.max() == pytest.approx(peak, abs=6e-4)
    assert way * (hz[z.argmax()] - at) == pytest.approx(late, abs=6e-3)
    slow = passage(omega, 5e-3, 4, hz[0], way * 1e-4, np.abs(hz - hz[0]) / 1e-4)
    steady = run_up.steady(omega, 5e-3, 4, hz)
    assert np.abs(slow - steady)[20:].max() < 1e-2 * np.abs(steady).max()
    assert np.abs(steady).max() == pytest.approx(1.0 / (5e-3 * omega), rel=1e-5)


def test_passages_of_any_size_neither_overflow_nor_lose_a_digit():
    """Far from resonance z = −1/λ + λ'/λ³ + ... of ż = λ(t) z + 1."""
    for order, start, rate, damping in (
        (4, 0.0, 1e-3, 0.05), (4, 5e3, -1e-3, 0.05), (4, 1e3, 1e-9, 0.2), (1, 0.0, 1e6, 1e-6),
    ):  # fmt: skip
        t = np.linspace(0.0, 100.0, 1001)
        assert np.isfinite(passage(HZ * 92.5, damping, order, start, rate, t)).all()
    times, rate = np.array([10.0, 100.0, 400.0]), 0.1  # of these the last is past the resonance
    far = passage(HZ * 92.5, 0.01, 4, 0.0, rate, times)
    steady = run_up.steady(HZ * 92.5, 0.01, 4, rate * times)  # -1/λ
    series = steady + 1j * rate * 4 * HZ * steady**3
    np.testing.assert_allclose(far, series, rtol=3e-9)


def test_all_modes_under_all_loads_follow_duhamels_integral(disk):
    """Two harmonics, a ramp, corners of the speed and the force of its change, by quadrature."""
    turning, times, ramp = turned(*TABLE), np.array([0.03, 0.08, 0.17]), 0.06
    draw = np.random.default_rng(3)
    force = draw.normal(size=(2, 6)) + 1j * draw.normal(size=(2, 6))
    loads, euler = [Harmonic(4, force[0]), Harmonic(0, force[1], ramped=False)], draw.normal(size=6)
    run = linear_run(disk.omega, disk.damping, loads, turning, times, None, euler, ramp)
    decay, turn = disk.damping * disk.omega, disk.omega * np.sqrt(1.0 - disk.damping**2)
    node, weight = np.polynomial.legendre.leggauss(200)
    for time, found in zip(times, run, strict=True):
        total = np.zeros(6)
        ends = np.unique(np.append([t for t in (0.0, 0.05, 0.06, 0.08) if t < time], time))
        for first, last in zip(ends[:-1], ends[1:], strict=True):
            s = (first + (last - first) * (node + 1.0) / 2.0)[:, None]
            grown = (1.0 - np.exp(-5.0 * np.minimum(s / ramp, 1.0))) / (1.0 - np.exp(-5.0))
            f = (grown * force[0] * np.exp(4j * turning.angle(s)) + force[1]).real
            f = f - euler * turning.acceleration(s)
            answer = np.exp(-decay * (time - s)) * np.sin(turn * (time - s)) / turn
            total += weight @ (f * answer) * (last - first) / 2.0
        np.testing.assert_allclose(found, total, atol=1e-10 * np.abs(total).max())


def test_constant_speed_and_coupling_have_their_closed_form():
    """Two coupled modes, undamped, against their eigenvectors, from rest."""
    omega, coupling = HZ * np.array([80.0, 95.0]), 4e4 * np.array([[1.0, 1.0], [1.0, 2.0]])
    value, vector = np.linalg.eigh(np.diag(omega**2) + coupling)
    force, t, drive = np.array([1.0, -2.0]), np.linspace(0.0, 0.2, 50), 4 * HZ * 22.0
    loads, turning = [Harmonic(4, force)], turned([0.0, 1.0], [HZ * 22.0] * 2)
    run = linear_run(omega, np.zeros(2), loads, turning, t, coupling)
    modal = (np.cos(drive * t) - np.cos(np.sqrt(value)[:, None] * t)).T / (value - drive**2)
    exact = modal * (vector.T @ force) @ vector.T
    np.testing.assert_allclose(run, exact, atol=1e-10 * np.abs(exact).max())


def error(disk, h, exact, n, wall, turning, **options):
    run = rubbing_run(disk, wall, turning, h, n, **options)
    step = n // (len(exact) - 1)
    return np.abs(run.position[::step] - exact).max() / np.abs(exact).max()


@pytest.mark.parametrize("scheme", ["exact_modal", "central_difference"])
def test_without_contact_errors_are_of_second_order(disk, scheme):
    """A load of four waves and the force of a changing speed, over its corners."""
    turning, n, times = turned(*TABLE), 2000, np.linspace(0.0, 0.2, 51)
    loads, euler = [Harmonic(4, np.ones(6), ramped=False)], np.full(6, 1e-2)
    exact = linear_run(disk.omega, disk.damping, loads, turning, times, euler=euler)
    wall = Wall(run_up_rubbing.bumps(4, 1e-3), 1.0)
    coarse, fine = (
        error(disk, 0.2 / m, exact, m, wall, turning, forces=loads, euler=euler, scheme=scheme)
        for m in (n, 2 * n)
    )
    assert 3.8 < coarse / fine < 4.2
    assert fine < 6e-3


def test_free_motion_is_exact_at_every_step(disk):
    q, v = np.random.default_rng(1).normal(size=(2, 6)) * np.array([[1.0], [500.0]])
    wall = Wall(run_up_rubbing.bumps(4, 1e-3), 1e3)
    run = rubbing_run(disk, wall, turned(*TABLE), 2e-4, 1000, start=(q, v))
    c, turn = disk.damping * disk.omega, disk.omega * np.sqrt(1.0 - disk.damping**2)
    t = run.times[:, None]
    exact = np.exp(-c * t) * (q * np.cos(turn * t) + (v + c * q) / turn * np.sin(turn * t))
    np.testing.assert_allclose(run.position, exact, atol=1e-11 * np.abs(exact).max())


@pytest.mark.parametrize("scheme", ["exact_modal", "central_difference"])
def test_springs_that_always_push_or_pull_are_a_linear_load(disk, scheme):
    """Bumps with their ramp, friction, three tips, up and hold and down: second order."""
    turning, times, terms = (
        turned(*TABLE),
        np.linspace(0.0, 0.2, 41),
        [(4, 1e-3, 0.2), (7, 4e-4, 1.0)],
    )
    wall = Wall(run_up_rubbing.waves(terms), 2e-4, 0.15, 0.05, 1e5, always=True)
    coupling, loads = run_up_rubbing.spring_loads(disk, 1e5, 2e-4, 0.15, terms)
    exact = linear_run(disk.omega, disk.damping, loads, turning, times, coupling, None, 0.05)
    coarse, fine = (
        error(disk, 0.2 / n, exact, n, wall, turning, scheme=scheme) for n in (2000, 4000)
    )
    assert 3.7 < coarse / fine < 4.3
    assert fine < 1e-2


def test_bumps_have_their_series():
    phi = np.linspace(0.0, 7.0, 501)
    series = run_up_rubbing.waves(run_up_rubbing.bump_waves(4, 1e-3, 0.1, 24))
    np.testing.assert_allclose(series(phi), run_up_rubbing.bumps(4, 1e-3)(phi), atol=1e-12)


def test_forces_hold_what_they_touch_and_nothing_else():
    draw = np.random.default_rng(5)
    for _ in range(50):
        A = draw.normal(size=(6, 6))
        W, p = A @ A.T + 0.1 * np.eye(6) + 0.05 * draw.normal(size=(6, 6)), draw.normal(size=6)
        force = run_up_rubbing.pressing(W, p)
        left = p - W @ force
        assert force.min() >= 0.0
        assert left.max() < 1e-12
        assert np.abs(force * left).max() < 1e-11 * max(force.max(), 1.0)


def test_springs_that_only_push_are_followed_with_an_error_of_second_order(disk):
    """Against an ODE solver with short steps; the clearance falls with time and with the speed."""

    def room(t, speed):
        return 3e-4 - 1e-3 * t - 2e-6 * (speed - HZ * 20.0)

    turning, k, mu, times = turned(*TABLE), 1e6, 0.15, np.linspace(0.0, 0.04, 21)
    bumps = run_up_rubbing.bumps(4, 1.25e-3)
    push = (disk.normal + mu * disk.tangential).T

    def rates(t, y):
        depth = bumps(turning.angle(t) + disk.angle) - room(t, turning.speed(t))
        force = k * np.maximum(depth + disk.normal @ y[:6], 0.0)
        pull = disk.omega**2 * y[:6] + 2.0 * disk.damping * disk.omega * y[6:]
        return np.concatenate([y[6:], -pull - push @ force])

    options = {"rtol": 1e-8, "atol": 1e-12, "max_step": 1e-4}
    solved = solve_ivp(rates, (0.0, 0.04), np.zeros(12), "DOP853", times, **options)
    wall, exact = Wall(bumps, room, mu, 0.0, k), solved.y[:6].T
    assert np.abs(exact).max() > 1e-4
    coarse, fine = (error(disk, 0.04 / n, exact, n, wall, turning) for n in (2000, 8000))
    assert 10.0 < coarse / fine < 24.0
    assert fine < 1e-4


def bump_that_passes(start, rate, height, clearance):
    """Place of the wall, velocity and acceleration where one bump passes faster and faster."""
    wide = (0.1 * np.pi / 2.0) ** 2

    def off(t):
        return start * t + rate * t * t / 2.0 - np.pi / 2.0

    def place(t):
        return clearance - height * np.exp(-(off(t) ** 2) / wide)

    def velocity(t):
        return 2.0 * off(t) / wide * (start + rate * t) * (clearance - place(t))

    def acceleration(t):
        x, speed = off(t), start + rate * t
        slope = 2.0 / wide * (speed**2 + x * rate) - (2.0 * x * speed / wide) ** 2
        return (clearance - place(t)) * slope

    def bump(phi):
        return height * np.exp(-((phi - np.pi / 2.0) ** 2) / wide)

    return events.Wall(place, velocity, acceleration), Wall(bump, clearance, friction=0.15)


def test_a_rigid_casing_is_followed_with_an_error_of_first_order():
    """Two modes that hit the wall, are carried by a bump, and hit again: from event to event."""
    rows, start, rate = np.array([[0.6, 0.4], [1.0, -0.5]]), HZ * 20.0, HZ * 2000.0
    one = OnePoint(HZ * np.array([92.5, 410.0]), *rows, 5e-3, 0.15)
    disk = Structure(one.omega, np.full(2, 5e-3), rows[:1], rows[1:], np.zeros(1))
    moving, wall = bump_that_passes(start, rate, 1.25e-3, 0.25e-3)
    turning, exact = turned([0.0, 1.0], [start, start + rate]), events.Reference(one, moving, 1e-4)
    hitting = np.array([-2e-4, 0.0]), np.array([0.3, -0.1])
    steps = np.array([700, 980, 1400, 1960, 2800, 3920, 5600])
    for begin, order in ((np.zeros((2, 2)), 1.8), (hitting, 0.9)):
        moved = exact.run(*begin, 140)
        assert len(moved.impacts) >= 2
        errors = [
            error(disk, 14e-3 / n, moved.position, n, wall, turning, start=tuple(begin))
            for n in steps
        ]
        assert np.polyfit(np.log(1.0 / steps), np.log(errors), 1)[0] > order - 0.2
        assert errors[-1] < 3e-4


def test_at_constant_speed_three_tips_rub_as_in_another_program(disk, monkeypatch):
    """Its steps are constant in angle, here of the same length; it finds forces by relaxation."""
    for name in ("bump", "forces"):  # compiling them takes longer than the run
        monkeypatch.setattr(ring, name, getattr(ring, name).py_func)
    one = disk._replace(damping=np.full(6, 5e-3))
    speed, steps = 24.0, 2000
    other = ring.integrate(
        *one._replace(damping=5e-3), ring.Ring(*np.zeros((5, 0))), ring.Wall(), speed, steps, steps
    )
    wall = Wall(run_up_rubbing.bumps(4, 1.25e-3), 0.25e-3, 0.15, 0.01)
    turning = turned([0.0, 1.0], [HZ * speed, HZ * speed])
    run = rubbing_run(one, wall, turning, 1.0 / (speed * steps), steps)
    assert (run.force > 0.0).sum(axis=0).min() > 100
    np.testing.assert_allclose(run.position[1:], other.disk, atol=1e-8 * np.abs(other.disk).max())
    np.testing.assert_allclose(run.force, other.force, atol=1e-6 * other.force.max())


@pytest.mark.parametrize("scheme", ["exact_modal", "central_difference"])
def test_energy_changes_by_the_work_of_wall_friction_and_damping(disk, scheme):
    """Of rigid casings and of springs; impacts only take energy; nothing is lost elsewhere."""
    turning = turned(*TABLE)
    casing = run_up_rubbing.bumps(4, 1.25e-3)
    for stiffness, friction, damped in ((np.inf, 0.0, 0.0), (np.inf, 0.15, 1.0), (1e6, 0.15, 1.0)):
        wall = Wall(casing, lambda t, speed: 3e-4 - 1e-3 * t, friction, 0.01, stiffness)
        free = disk._replace(damping=damped * disk.damping)
        run = rubbing_run(free, wall, turning, 2e-5, 5000, scheme=scheme)
        balance = work_and_energy(free, wall, turning, run, scheme)
        assert run.force.max() > 0.0
        assert np.abs(balance.unexplained()).max() < 1e-12 * balance.energy.max()
        if stiffness == np.inf:
            assert balance.kept.min() > -1e-12 * balance.energy.max()
        if not damped:
            assert not balance.friction.any()
            assert not balance.damping.any()
            gained = balance.casing().sum() - balance.kept.sum()
            assert balance.energy[-1] == pytest.approx(gained, rel=1e-9)
