"""A casing that gives and a coating that wears, against implementations that share no code.

One mass on a spring against one bar is linear between two events: `evidence.truth.bars` solves it
piece by piece. The kernel's error is of second order in the step, but for a damper's. On a whole
disk the forces of recorded steps are those of the incremental law of plasticity,

    σ* = E (ε − ε_p),  f = σ* − (σ_Y + H ε_p),
    f > 0:  ε_p ← ε_p + f/(E + H),  σ = σ* − E f/(E + H).
"""

import numpy as np
import pytest
from scipy.interpolate import CubicHermiteSpline

from evidence.truth.bars import Mass
from evidence.truth.disk import reference_reduced, reference_scene
from evidence.truth.energy import audit
from evidence.truth.motion import recorded, spatial
from evidence.validation.report import fitted_order
from hpcrub.contact.bank import allocate, fill_lane, motion, set_motion
from hpcrub.contact.integrate import run
from hpcrub.contact.recurrence import newmark
from hpcrub.model.casing import CasingShape, ramp
from hpcrub.model.coating import Coating, ElasticCasing
from hpcrub.model.reduction import mistuned_modes
from hpcrub.response.revolution import Grid, cut_revolution
from tests.contact.laws.test_solid import made_up
from tests.contact.laws.thrown import (
    GAP,
    HARD,
    LAWS,
    MASS,
    MILD,
    SOFT,
    SPEED,
    SPRING,
    WALLS,
    computed,
    exact,
    ready,
    thrown,
)
from tests.contact.test_kernel import integrate_lanes, plain_python
from tests.program import whole


@pytest.mark.parametrize("name", WALLS)
def test_one_mass_is_the_event_driven_motion(name):
    """The first peak and the depth that is worn then, with steps of 20 ns."""
    wall, dt = WALLS[name], 2e-6
    truth = exact(*wall, 2e-3, dt)
    assert len(truth.events) >= 2
    curve = CubicHermiteSpline(dt * np.arange(1001), truth.place, truth.velocity)
    peak = curve(curve.derivative().roots()).max()
    place, _, bank = computed(*wall, 2e-8, 2e-3)
    assert place.max() == pytest.approx(peak, rel=3e-6 if name == "damped" else 1e-8)
    if wall[0]:
        assert 0.0 < truth.worn[-1] <= wall[0].thickness
        assert bank.law.surface.worn[0, 0] == pytest.approx(truth.worn[-1], rel=2e-8)


@pytest.mark.parametrize("kind", [{}, {"kind": spatial}], ids=["planar", "spatial"])
def test_a_motion_goes_on_from_any_step_of_a_contact(kind):
    """From its memory it has the forces of the motion as a whole, the last of a rebound, too."""
    h, n_steps = 2e-5, 45

    def at_start():
        return ready(MASS, SPEED, h, elastic_casing=SPRING, **kind)[0]

    def forces(bank, n):
        return np.concatenate([steps.force[:, 0, 0] for steps in recorded(bank, n)])

    whole = forces(at_start(), n_steps)
    assert 20 < np.count_nonzero(whole) < n_steps - 5
    for cut in range(1, n_steps):
        stopped, goes_on = at_start(), at_start()
        forces(stopped, cut)
        set_motion(goes_on, 0, *motion(stopped, 0))
        found = forces(goes_on, n_steps - cut)
        assert np.abs(found - whole[cut:]).max() < 1e-12 * whole.max(), cut


@pytest.mark.parametrize("name", WALLS)
def test_the_whole_motion_converges_with_the_second_order(name):
    """But for a damper, whose force begins with a jump.

    Of many steps: where in a step a contact begins is chance, and so is the factor of the error.
    """
    truth, errors = exact(*WALLS[name]), []
    parts = np.unique(np.round(3.0 * 2.0 ** (np.arange(20) / 4.0)).astype(int))
    for n in parts:
        place, _, _ = computed(*WALLS[name], 1e-5 / n)
        errors.append(np.abs(place[n - 1 :: n] - truth.place[1:]).max())
    order = fitted_order(1e-5 / parts, np.array(errors))
    assert abs(order - 1.0) < 0.05 if name == "damped" else 1.8 < order < 2.5


def test_a_slow_incursion_wears_what_statics_say():
    """A stiff damped tip before a casing that comes 1.5 mm nearer: x = w + (σ_Y + H w/t) t/E."""
    omega, height, gap = 1e4, 1.5e-3, 0.5e-3
    mass = Mass(1e6, 2e6 * 0.9 * omega, 1e6 * omega**2)
    comes = {"casing": CasingShape(1, height), "ramp_time": 0.2}
    place, _, bank = thrown(mass, 0.0, 1e-5, 0.21, gap=gap, coating=HARD, **comes)
    x, w, t = place[-1] + height - gap, bank.law.surface.worn[0, 0], HARD.thickness
    assert x == pytest.approx(height - gap, rel=1e-3)
    statics = w + (HARD.yield_stress + HARD.hardening * w / t) * t / HARD.young
    assert statics == pytest.approx(x, rel=1e-10)
    assert w > 0.5 * x


@pytest.mark.parametrize("bar", [HARD, None], ids=["coated", "elastic"])
@pytest.mark.long
def test_energy_goes_into_wear_and_what_a_step_loses(bar):
    """The balance of every step closes, nothing is stored in the end, and what steps gain or lose
    has the second order."""
    steps, mass, books = (2e-6, 1e-6, 5e-7), MASS._replace(damper=0.0), []
    for h in steps:
        spring = None if bar else SPRING
        bank, scene = ready(mass, SPEED, h, coating=bar, elastic_casing=spring)
        books.append(audit(bank, round(2e-3 / h), scene))
    assert max(found.unexplained()[0] for found in books) < 1e-10
    start = books[-1].energy[0, 0]
    lost = np.abs([found.impact[:, 0].sum() for found in books]) / start
    assert (lost < 2e9 * np.square(steps)).all()
    assert abs(books[-1].elastic[:, 0].sum()) < 1e-12 * start
    assert books[-1].elastic[:, 0].cumsum().max() > 0.1 * start
    assert (books[-1].plastic >= 0.0).all()
    assert books[-1].plastic[:, 0].sum() > (0.2 * start if bar else -1.0)


@pytest.mark.parametrize("turn", [0.5, 2.0])
def test_a_rebound_loses_what_is_said_of_the_time_step(turn):
    """A free mass thrown at a spring, √(k/m) h = turn, mean of where in a step it meets it."""
    a, b, c = newmark(turn**2)
    assert a + b + c == pytest.approx(1.0, rel=1e-14)  # a constant force is what it is
    half_turn = np.pi / np.arctan2(2.0 * turn, 2.0 - b * turn**2)
    lost = 1.0 - ((1.0 + c * turn**2) / (1.0 + a * turn**2)) ** half_turn
    mass, h, left = Mass(1.0, 0.0, 1e-9), turn / np.sqrt(SPRING.stiffness), []
    duration = 2.0 * GAP / SPEED + 10.0 * h + 4.0 * h / turn
    for later in np.arange(16) / 16.0 * h * SPEED:
        gap = GAP + later
        place, _, _ = thrown(mass, SPEED, h, duration, gap=gap, elastic_casing=SPRING)
        assert place[-1] < place[-2]
        left.append(((place[-1] - place[-2]) / (h * SPEED)) ** 2)
    assert abs(1.0 - np.mean(left) - lost) < 0.03


def test_limits_of_the_law():
    """k → ∞ and E, σ_Y → ∞ are the rigid casing, σ_Y → ∞ the elastic one of stiffness EA/t."""
    h, stiffness = 1e-5, 10.0 ** np.arange(13, 17)
    rigid, _, _ = computed(None, None, h)
    hard = HARD._replace(yield_stress=1e30)

    def off(*wall):
        return np.abs(computed(*wall, h)[0] - rigid).max() / rigid.max()

    elastic = [off(None, ElasticCasing(k)) for k in stiffness]
    coated = [off(hard._replace(young=k * hard.thickness / hard.area), None) for k in stiffness]
    for errors in (elastic, coated):
        assert abs(fitted_order(1.0 / stiffness, np.array(errors)) - 1.0) < 0.02
    spring, _, _ = computed(None, ElasticCasing(HARD.stiffnesses(HARD.area)[0]), h)
    place, _, _ = computed(hard, None, h)
    assert np.abs(place - spring).max() < 1e-11 * spring.max()


def worn_by(points, scene, h, n_steps):
    """Forces (n, C) and worn depths (Z, S) by the incremental law of plasticity, step by step.

    points: penetrations of the new coating at the ends of the steps (n, C) [m].
    """
    bar_of, casing, face = scene.coating, scene.elastic_casing, scene.interface
    offset = np.round(face.angle * n_steps / (2.0 * np.pi)).astype(int)
    places = sorted(set(face.axial_position))
    strip = [places.index(place) for place in face.axial_position]
    strain, forces = np.zeros((len(places), n_steps)), np.zeros_like(points)
    before = np.zeros(points.shape[1])
    E, H, t = bar_of.young, bar_of.hardening, bar_of.thickness
    for n, row in enumerate(points):
        for i, p in enumerate(row):
            bar = strip[i], (n + 1 + offset[i]) % n_steps
            trial = max(E * (min(p / t, 1.0) - strain[bar]), 0.0)
            beyond = trial - (bar_of.yield_stress + H * strain[bar])
            if beyond > 0.0:
                strain[bar] += beyond / (E + H)
                trial -= E * beyond / (E + H)
            forces[n, i] = bar_of.area * face.share[i] * trial
            if casing:
                rate = (p - t - max(before[i] - t, 0.0)) / h
                forces[n, i] += max(casing.stiffness * (p - t) + casing.damping * rate, 0.0)
        before = np.maximum(row, 0.0)
    return forces, t * strain


def rubbing(kind, law):
    """Modes, Scene and speed of a disk that rubs."""
    if kind == "planar":
        modes = mistuned_modes(reference_reduced(), np.linspace(-0.04, 0.04, 12))
        return modes, reference_scene(step=2e-5, record_interval=2e-5, **law), 34.6
    modes, scene = made_up()
    face = scene.interface._replace(axial_position=np.repeat([0.0, 0.01, 0.02, 0.03], 3))
    h = 1.0 / (1200 * 30.0)
    return modes, scene._replace(interface=face, step=h, record_interval=h, **law), 30.0


# four points of a blade, stiffly coupled: some cut, some are pressed to the casing
SOFTER = Coating(1e-3, 2e3, 0.15, 1e3, 1.0)
KINDS = {
    "planar coated": ("planar", {"coating": SOFT}),
    "planar both": ("planar", {"coating": SOFT, "elastic_casing": MILD}),
    "spatial coated": ("spatial", {"coating": SOFTER}),
    "spatial both": ("spatial", {"coating": SOFTER, "elastic_casing": ElasticCasing(5e5, 10.0)}),
}


@pytest.mark.parametrize("name", KINDS)
def test_a_disk_feels_the_incremental_law(name):
    """Penetrations and forces of every step of a disk; all of its blades cut the same bars."""
    modes, scene, speed = rubbing(*KINDS[name])
    grid = cut_revolution(speed, scene)
    assert grid.stride == 1
    names = "time", "position", "normal_force"
    time, position, force = whole(modes, scene, [speed], 2.4 / speed, *names)
    position, force = position[:, :, 0], force[:, :, 0]
    n, h, face = grid.steps_per_revolution, time[0, 0], scene.interface
    rows = scene.casing.table(face.angle, n, n)
    done = np.arange(len(force))
    grown = np.array([ramp(h * (step + 1), scene.ramp_time) for step in done])
    p = position @ modes.normal.T + grown[:, None] * rows[done % n]
    p -= scene.clearance + face.clearance
    law, worn = worn_by(p, scene, h, n)
    a, b, c = allocate(modes, scene, grid, 8, [speed]).law.surface.weights[:, 0].reshape(-1, 3).T
    before = np.pad(law, ((2, 0), (0, 0)))
    expected = a[: len(face.angle)] * law
    expected += b[: len(face.angle)] * before[1:-1] + c[: len(face.angle)] * before[:-2]
    assert (expected > 0.0).sum(axis=1).max() >= 3
    t = scene.coating.thickness
    pressed = p > t * (1.0 - 1e-9)
    assert pressed.any()
    assert worn.max() > 0.01 * t
    assert (worn.max(axis=1) > 0.0).all()
    assert worn.max() == pytest.approx(scene.coating.worn_through, rel=1e-9)
    free = np.ones_like(pressed) if scene.elastic_casing else ~pressed
    assert np.abs(force - expected)[free].max() < 1e-6 * expected.max()
    assert p.max() < t * (1.0 + 1e-9) or scene.elastic_casing


def turned(name, speeds=(33.5, 34.0, 34.5), width=8, n_blocks=1, revolution=1200, solid=False):
    """Displacements and worn depths of some lanes after some blocks, in one row."""
    modes = mistuned_modes(reference_reduced(), np.linspace(-0.04, 0.04, 12))
    scene = reference_scene(**LAWS.get(name, {}))._replace(scheme="exact_modal")
    if solid:
        modes = spatial(modes)
    found, bank = integrate_lanes(modes, scene, speeds, n_blocks, width, revolution)
    worn = getattr(bank.law.surface, "worn", np.zeros((0, width)))
    return np.concatenate([found.reshape(-1, len(speeds)), worn[:, : len(speeds)]])


@pytest.mark.long
def test_a_compiled_law_is_its_plain_python_twin(tmp_path):
    twin = plain_python("turned('both', revolution=120, solid=True)", __name__, tmp_path)
    assert np.abs(twin).max() > 1e-5  # contact did occur: without it nothing moves
    off = turned("both", revolution=120, solid=True) - twin
    assert np.abs(off).max() < 1e-10 * np.abs(twin).max()


@pytest.mark.parametrize("name", LAWS)
def test_a_planar_disk_is_the_same_disk_in_three_dimensions(name):
    planar = turned(name, n_blocks=3)
    assert np.abs(turned(name, n_blocks=3, solid=True) - planar).max() < 1e-9 * planar.max()


def test_lanes_do_not_see_each_other():
    """In three dimensions; `tests.response.test_clearance` has planar disks."""
    speeds = np.linspace(33.5, 36.0, 8)
    together = turned("both", speeds, n_blocks=6, solid=True)
    for lane in (0, 3, 7):
        alone = turned("both", speeds[lane : lane + 1], n_blocks=6, solid=True)
        assert np.array_equal(alone[:, 0], together[:, lane])


def test_a_lane_filled_later_meets_a_new_coating():
    """Whole blocks further on the casing is the same; bars count from where a lane starts."""
    modes = mistuned_modes(reference_reduced(), np.linspace(-0.04, 0.04, 12))
    scene, grid, speed = reference_scene(coating=SOFT), Grid(1200, 4, 1), 34.0
    h = 1.0 / (speed * 1200)
    bank = allocate(modes, scene, grid, 8, [33.0])
    run(bank, 3)
    fill_lane(bank, 0, modes, scene, h)
    run(bank, 2)
    fill_lane(bank, 5, modes, scene, h)
    run(bank, 7)
    for lane, n_blocks in ((0, 9), (5, 7)):
        fresh = allocate(modes, scene, grid, 8, [speed])
        run(fresh, n_blocks)
        assert np.array_equal(bank.state.position[:, lane], fresh.state.position[:, 0])
        assert np.array_equal(bank.law.surface.worn_depth(lane), fresh.law.surface.worn_depth(0))
    assert fresh.law.surface.worn_depth(0).max() > 1e-5
