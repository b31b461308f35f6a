"""A casing that gives and a coating that wears, against implementations that share no code.

One mass on a spring against one bar is linear between two events: `evidence.truth.bars` solves it
piece by piece. The kernel takes the force at the end of a step, which is of first order in the
step. On a whole disk the forces of recorded steps are those of the incremental law of plasticity,

    σ* = E (ε − ε_p),  f = σ* − (σ_Y + H ε_p),
    f > 0:  ε_p ← ε_p + f/(E + H),  σ = σ* − E f/(E + H).
"""

import os
import subprocess
import sys

import numpy as np
import pytest

from evidence.truth.bars import Bar, Mass, Reference
from evidence.truth.disk import reference_reduced, reference_scene
from evidence.truth.one_mass import scene as wall
from evidence.truth.one_mass import spatial, thrown
from evidence.validation.report import fitted_order
from hpcrub.contact.bank import allocate, fill_lane
from hpcrub.contact.integrate import run
from hpcrub.model.casing import bump_table, ramp
from hpcrub.model.coating import Coating, ElasticCasing
from hpcrub.model.reduction import mistuned_modes
from hpcrub.response import history
from hpcrub.response.revolution import Grid, cut_revolution
from hpcrub.setup.plausibility import rebound_lost
from tests.contact.test_kernel import integrate_lanes
from tests.contact.test_spatial import integrate, made_up
from tests.program import ROOT

MASS = Mass(0.8, 15.0, 0.8 * (2.0 * np.pi * 150.0) ** 2)
GAP, SPEED, DURATION = 1e-4, 2.0, 6e-3
HARD = Coating(2e-3, 1e9, 8e6, 2e8, 5e-4)
THIN = Coating(4e-4, 1e9, 1e6, 1e9, 5e-5)
WORN_THROUGH = THIN._replace(thickness=2e-4, hardening=2e7, area=5e-4)
SPRING, DAMPED = ElasticCasing(2e7), ElasticCasing(2e7, 300.0)
WALLS = {
    "elastic": (None, SPRING),
    "damped": (None, DAMPED),
    "coated": (HARD, None),
    "pressed to the casing": (THIN, DAMPED),
    "worn through": (WORN_THROUGH, DAMPED),
}
# a disk: the coating is cut by some tips, and by others pressed to the casing
SOFT = Coating(0.6e-3, 3e8, 1e6, 1e8, 1.4e-3)
MILD = ElasticCasing(1e7, 50.0)
LAWS = {
    "elastic": {"elastic_casing": MILD},
    "coated": {"coating": SOFT},
    "both": {"coating": SOFT, "elastic_casing": MILD},
}


def exact(coating, casing, duration=DURATION):
    bar = Bar(*coating[:5]) if coating else Bar()
    return Reference(MASS, bar, GAP, *(casing or ())).run(SPEED, 1e-5, round(duration / 1e-5))


def computed(coating, casing, h, duration=DURATION, **kind):
    found = wall(GAP, 0.0, coating=coating, elastic_casing=casing)
    return thrown(MASS, SPEED, found, h, duration, **kind)


def extrapolated(values):
    """Limit of values at steps halved again and again, their error a power series of the step."""
    values = np.array(values)
    for order in range(1, len(values)):
        values = (2.0**order * values[1:] - values[:-1]) / (2.0**order - 1.0)
    return values[0]


@pytest.mark.parametrize("name", WALLS)
def test_one_mass_is_the_event_driven_motion(name):
    coating, casing = WALLS[name]
    truth = exact(coating, casing, 2e-3)
    assert len(truth.events) >= 2
    assert coating is None or 0.0 < truth.worn[-1] <= coating.thickness
    steps, peaks, worn = 1e-8 / 2.0 ** np.arange(4), [], []
    for h in steps:
        place, _, bank = computed(coating, casing, h, 2e-3)
        peaks.append(place.max())
        worn.append(bank.law.surface.worn[0, 0] if coating else 0.0)
    errors = np.abs(np.array(peaks) / truth.highest - 1.0)
    assert abs(fitted_order(steps, errors) - 1.0) < 0.02
    assert abs(extrapolated(peaks[:3]) / truth.highest - 1.0) < 1e-6
    if coating:
        assert abs(extrapolated(worn[:3]) - truth.worn[-1]) < 1e-6 * truth.worn[-1]


@pytest.mark.parametrize("name", WALLS)
def test_one_mass_in_three_dimensions_moves_alike(name):
    """The set of points that is solved exactly, and Gauss–Seidel, find the same forces."""
    (place, force, bank), (same, as_large, solid) = (
        computed(*WALLS[name], 1e-6, **kind) for kind in ({}, {"kind": spatial})
    )
    assert type(bank.law) is not type(solid.law)
    assert np.abs(same - place).max() < 1e-12 * place.max()
    assert np.abs(as_large - force).max() < 1e-9 * force.max()
    assert abs(solid.law.surface.worn[0, 0] - bank.law.surface.worn[0, 0]) < 1e-15


@pytest.mark.parametrize("name", WALLS)
def test_the_whole_motion_converges_with_the_first_order(name):
    truth, steps, errors = exact(*WALLS[name]), 1e-5 / 2.0 ** np.arange(5, 10), []
    for h in steps:
        place, _, _ = computed(*WALLS[name], h)
        every = round(1e-5 / h)
        errors.append(np.abs(place[every - 1 :: every] - truth.place[1:]).max())
    assert 0.9 < fitted_order(steps, np.array(errors)) < 1.1


def test_a_slow_incursion_wears_what_statics_say():
    """A stiff damped tip before a casing that comes 1.5 mm nearer: x = w + (σ_Y + H w/t) t/E."""
    omega, height, gap = 1e4, 1.5e-3, 0.5e-3
    found = wall(gap, 0.0, coating=HARD)._replace(bump_height=height, ramp_time=0.2)
    mass = Mass(1e6, 2e6 * 0.9 * omega, 1e6 * omega**2)
    place, _, bank = thrown(mass, 0.0, found, 1e-5, 0.21)
    x, w, t = place[-1] + height - gap, bank.law.surface.worn[0, 0], HARD.thickness
    assert abs(x - (height - gap)) < 1e-3 * x
    assert abs(w + (HARD.yield_stress + HARD.hardening * w / t) * t / HARD.young - x) < 1e-10 * x
    assert w > 0.5 * x


@pytest.mark.parametrize("coating", [HARD, None], ids=["coated", "elastic"])
def test_energy_goes_into_wear_and_what_a_step_loses(coating):
    """E = ½ v v₋ + … of the scheme; N (Δp + Δp₋)/2 is stored, worn away, or lost by the step.

    The end of a step is where the law holds, so ½ ΔN²/k₁ of every step is lost, ½ H A/t Δw² of
    wear, what a force takes in the step in which a gap closes, and N (Δp₋ − Δp)/2 because forces
    act for a step in which the motion is a mean of two.
    """
    mass = MASS._replace(damper=0.0)
    found = wall(GAP, 0.0, coating=coating, elastic_casing=None if coating else SPRING)
    lost = []
    steps = 1e-7 / 2.0 ** np.arange(3)
    for h in steps:
        u, force, bank = thrown(mass, SPEED, found, h, 2e-3)
        u = np.concatenate([[-SPEED * h], [0.0], u])  # close: the first step is free
        gain, stiff = bank.scheme.gain[0, 0] / mass.mass, mass.spring
        moved = np.diff(u)
        energy = moved[1:] ** 2 / (2.0 * gain) + stiff / 2.0 * u[2:] * u[1:-1]
        work = force * (u[2:] - u[:-2]) / 2.0
        start = energy[0]  # no force yet
        assert np.abs(energy - start + np.cumsum(work)).max() < 1e-9 * start
        p = u[2:] - GAP
        by_step = np.sum(force * (moved[:-1] - moved[1:]) / 2.0)
        k = coating.stiffnesses(coating.area)[0] if coating else SPRING.stiffness
        wasted = np.sum(np.diff(force) ** 2) / (2.0 * k)
        worn, w = 0.0, np.zeros_like(p)
        if coating:
            w = np.maximum.accumulate(np.maximum(coating.kept * (p - coating.depth_at_yield), 0.0))
            hard = coating.hardening * coating.area / coating.thickness
            worn = coating.area * coating.yield_stress * w[-1] + hard * w[-1] ** 2 / 2.0
            wasted += hard * np.sum(np.diff(w) ** 2) / 2.0
            assert worn > 0.2 * start
        gap = force / k + w - p
        wasted += np.sum(force[1:] * gap[:-1])
        assert force[-1] == 0.0  # nothing is stored at the end
        assert abs(work.sum() - worn - wasted - by_step) < 1e-9 * start
        lost.append((wasted + by_step) / start)
    assert abs(fitted_order(steps, np.abs(lost)) - 1.0) < 0.05


@pytest.mark.parametrize("turn", [0.01, 0.05, 0.2])
def test_a_rebound_loses_what_is_said_of_the_time_step(turn):
    """A free mass thrown at a spring, √(k/m) h = turn; a step more or less of contact aside."""
    mass, h = Mass(1.0, 0.0, 1e-9), turn / np.sqrt(SPRING.stiffness)
    found = wall(GAP, 0.0, elastic_casing=SPRING)
    place, _, _ = thrown(mass, SPEED, found, h, 3.0 * GAP / SPEED + 4.0 * h / turn)
    left = ((place[-1] - place[-2]) / (h * SPEED)) ** 2
    assert place[-1] < place[-2]
    assert abs(1.0 - left - rebound_lost(turn)) < 2.0 * turn**2 + 1e-3


def test_limits_of_the_law():
    """k → ∞ and E, σ_Y → ∞ are the rigid casing, σ_Y → ∞ the elastic one of stiffness EA/t."""
    h = 1e-5
    rigid, _, _ = computed(None, None, h)
    stiffness = 10.0 ** np.arange(13, 17)
    elastic = [
        np.abs(computed(None, ElasticCasing(k), h)[0] - rigid).max() / rigid.max()
        for k in stiffness
    ]
    assert abs(fitted_order(1.0 / stiffness, np.array(elastic)) - 1.0) < 0.02
    hard = HARD._replace(yield_stress=1e30)
    coated = [
        np.abs(
            computed(hard._replace(young=k * hard.thickness / hard.area), None, h)[0] - rigid
        ).max() / rigid.max()
        for k in stiffness
    ]  # fmt: skip
    assert np.allclose(coated, elastic, rtol=1e-3)
    k = HARD.stiffnesses(HARD.area)[0]
    spring, _, _ = computed(None, ElasticCasing(k), h)
    place, _, _ = computed(hard, None, h)
    assert np.abs(place - spring).max() < 1e-11 * spring.max()


def worn_by(points, scene, h, n_steps):
    """Forces (n, C) and worn depths (Z, S) by the incremental law of plasticity, step by step.

    points: penetrations of the new coating at the ends of the steps (n, C) [m].
    """
    coating, casing, face = scene.coating, scene.elastic_casing, scene.interface
    offset = np.round(face.angle * n_steps / (2.0 * np.pi)).astype(int)
    places = sorted(set(face.axial_position))
    strip = [places.index(place) for place in face.axial_position]
    strain, forces = np.zeros((len(places), n_steps)), np.zeros_like(points)
    before = np.zeros(points.shape[1])
    E, H, t = coating.young, coating.hardening, coating.thickness
    for n, row in enumerate(points):
        for i, p in enumerate(row):
            bar = strip[i], (n + 1 + offset[i]) % n_steps
            trial = max(E * (p / t - strain[bar]), 0.0)
            beyond = trial - (coating.yield_stress + H * strain[bar])
            if beyond > 0.0:
                strain[bar] = min(strain[bar] + beyond / (E + H), 1.0)
                trial -= E * beyond / (E + H)
            forces[n, i] = coating.area * face.share[i] * trial
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
    pieces = list(history.integrate(modes, scene, [speed], 2.4 / speed))
    force = np.concatenate([piece.normal_force[:, :, 0] for piece in pieces])
    position = np.concatenate([piece.position[:, :, 0] for piece in pieces])
    n, h, face = grid.steps_per_revolution, pieces[0].time[0, 0], scene.interface
    rows = bump_table(face.angle, scene.n_bumps, scene.bump_height, n, n)
    done = np.arange(len(force))
    grown = np.array([ramp(h * (step + 1), scene.ramp_time) for step in done])
    p = position @ modes.normal.T + grown[:, None] * rows[done % n]
    p -= scene.clearance + face.clearance
    expected, worn = worn_by(p, scene, h, n)
    assert (expected > 0.0).sum(axis=1).max() >= 3
    t = scene.coating.thickness
    pressed = p > t * (1.0 - 1e-9)
    assert pressed.any()
    assert worn.max() > 0.01 * t
    assert (worn.max(axis=1) > 0.0).all()
    free = np.ones_like(pressed) if scene.elastic_casing else ~pressed
    assert np.abs(force - expected)[free].max() < 1e-6 * expected.max()
    assert p.max() < t * (1.0 + 1e-9) or scene.elastic_casing


TWIN = """
import sys
import numpy as np
sys.path.insert(0, {root!r})
from tests.contact.test_coating import LAWS, turned
np.savez({out!r}, **{{str(solid): turned("both", solid=solid, revolution=240)
                  for solid in (False, True)}})
"""


def turned(name, speeds=(33.5, 34.0, 34.5), width=8, n_blocks=1, revolution=1200, solid=False):
    """Displacements and worn depths of some lanes after some blocks, in one row."""
    modes = mistuned_modes(reference_reduced(), np.linspace(-0.04, 0.04, 12))
    scene = reference_scene(**LAWS[name])._replace(scheme="exact_modal")
    if solid:
        modes = spatial(modes)
    found, bank = integrate_lanes(modes, scene, speeds, n_blocks, width, revolution)
    worn = bank.law.surface.worn
    return np.concatenate([found.reshape(-1, len(speeds)), worn[:, : len(speeds)]])


def test_compiled_laws_are_their_plain_python_twins(tmp_path):
    out = tmp_path / "twin.npz"
    code = TWIN.format(root=str(ROOT), out=str(out))
    subprocess.run(
        [sys.executable, "-c", code], check=True, env={**os.environ, "NUMBA_DISABLE_JIT": "1"}
    )
    with np.load(out) as twins:
        for solid in (False, True):
            twin = twins[str(solid)]
            assert np.abs(twin).max() > 1e-5
            off = turned("both", revolution=240, solid=solid) - twin
            assert np.abs(off).max() < 1e-10 * np.abs(twin).max()


@pytest.mark.parametrize("name", LAWS)
def test_a_planar_disk_is_the_same_disk_in_three_dimensions(name):
    planar = turned(name, n_blocks=3)
    assert np.abs(turned(name, n_blocks=3, solid=True) - planar).max() < 1e-9 * planar.max()


@pytest.mark.parametrize("solid", [False, True])
@pytest.mark.parametrize("name", LAWS)
def test_lanes_do_not_see_each_other(name, solid):
    speeds = np.linspace(33.5, 36.0, 8)
    together = turned(name, speeds, n_blocks=6, solid=solid)
    for lane in (0, 3, 7):
        alone = turned(name, speeds[lane : lane + 1], n_blocks=6, solid=solid)
        assert np.array_equal(alone[:, 0], together[:, lane])


def test_stiff_casings_are_the_rigid_one_in_three_dimensions():
    """With the error 1/k, of stiffly coupled points and friction that turns."""
    modes, scene = made_up(0)
    rigid, _ = integrate(modes, scene, [30.0], 500)
    stiffness = 10.0 ** np.arange(9, 13)
    errors = [
        np.abs(integrate(modes, scene._replace(elastic_casing=ElasticCasing(k)), [30.0], 500)[0]
               - rigid).max() / np.abs(rigid).max()
        for k in stiffness
    ]  # fmt: skip
    assert errors[0] < 1e-2
    assert abs(fitted_order(1.0 / stiffness, np.array(errors)) - 1.0) < 0.02


def test_a_lane_filled_later_meets_a_new_coating():
    """A block further on the casing is the same, and its bars are counted from where it starts."""
    modes = mistuned_modes(reference_reduced(), np.linspace(-0.04, 0.04, 12))
    scene, grid, speed = reference_scene(coating=SOFT), Grid(1200, 4, 1), 34.0
    h = 1.0 / (speed * 1200)
    bank = allocate(modes, scene, grid, 8, [33.0])
    run(bank, 3)
    fill_lane(bank, 0, modes, scene, h)
    fill_lane(bank, 5, modes, scene, h)
    run(bank, 7)
    fresh = allocate(modes, scene, grid, 8, [speed])
    run(fresh, 7)
    for lane in (0, 5):
        assert np.array_equal(bank.state.position[:, lane], fresh.state.position[:, 0])
        assert np.array_equal(bank.law.surface.worn_depth(lane), fresh.law.surface.worn_depth(0))
    assert fresh.law.surface.worn_depth(0).max() > 1e-5
