"""A casing that gives and a coating that wears: what these laws are held against, by the tests."""

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from evidence.truth.bars import Mass, Reference
from evidence.truth.disk import reference_reduced, reference_scene
from evidence.truth.energy import audit
from evidence.truth.motion import Structure, make_bank, recorded, start_free, wall
from evidence.validation import report
from hpcrub.contact.bank import allocate
from hpcrub.model.casing import CasingShape
from hpcrub.model.coating import Coating, ElasticCasing
from hpcrub.model.interface import planar_interface
from hpcrub.model.reduction import Modes, mistuned_modes
from hpcrub.response import history
from hpcrub.response.revolution import cut_revolution
from hpcrub.response.scene import Scene
from hpcrub.response.steady import SteadyCriteria
from hpcrub.response.sweep import run_sweep

MASS = Mass(0.8, 15.0, 0.8 * (2.0 * np.pi * 150.0) ** 2)
GAP, SPEED, DURATION = 1e-4, 2.0, 6e-3
LEDGER_STEPS = 2e-6, 1e-6, 2.5e-7  # [s]
HARD = Coating(2e-3, 1e9, 8e6, 2e8, 5e-4)
THIN = Coating(4e-4, 1e9, 1e6, 1e9, 5e-5)
SPRING, DAMPED = ElasticCasing(2e7), ElasticCasing(2e7, 300.0)
WALLS = {
    "elastic": (None, SPRING),
    "damped": (None, DAMPED),
    "coated": (HARD, None),
    "pressed to the casing": (THIN, DAMPED),
    "worn through": (THIN._replace(thickness=2e-4, hardening=2e7, area=5e-4), SPRING),
}
# of a disk: some tips cut, others are pressed to the casing behind
SOFT = Coating(0.6e-3, 3e8, 1e6, 1e8, 1.4e-3)
MILD = ElasticCasing(1e7, 50.0)
LAWS = {
    "elastic": {"elastic_casing": MILD},
    "coated": {"coating": SOFT},
    "both": {"coating": SOFT, "elastic_casing": MILD},
}
OWN = 150.0  # frequency of the blade that cuts lobes [Hz]
ORDERS = 2.85, 3.25, 3.75, 4.25, 4.75, 5.25, 5.65, 6.2, 6.65  # OWN over the speeds it runs at
CUTS = Coating(5e-3, 1e8, 1e5, 2e7, 1e-4, 0.02)


def exact(coating, casing, duration=DURATION, dt=1e-5):
    """Event-driven motion of MASS, at times dt; see `bars.Reference`."""
    bar = coating[:5] if coating else (0.0,) * 5
    return Reference(MASS, bar, GAP, *(casing or ())).run(SPEED, dt, round(duration / dt))


def ready(mass, velocity, h, gap=GAP, **law):
    """Bank of a `bars.Mass` at u = 0 with a velocity [m/s], steps h [s], and its Scene.

    law: changes of the Scene, and kind, see `motion.make_bank`.
    """
    omega, root = np.sqrt(mass.spring / mass.mass), np.sqrt(mass.mass)
    ratio = mass.damper / (2.0 * mass.mass * omega)
    body = Structure(np.array([omega]), np.array([1.0 / root]), np.zeros(1), ratio, 0.0)
    kind = {"kind": law.pop("kind")} if "kind" in law else {}
    scene = wall(body, gap, **law)
    bank = make_bank(body, scene, [h], **kind)
    start_free(bank, body, np.zeros(1), np.array([root * velocity]), [h])
    return bank, scene


def thrown(mass, velocity, h, duration, **law):
    """Motion of a mass from u = 0; arguments as of `ready`.

    Returns the places u (n,) [m] and forces (n,) [N] at the ends of n steps h, and the bank.
    """
    bank, _ = ready(mass, velocity, h, **law)
    kept = [(steps.position[:, 0, 0].copy(), steps.force[:, 0, 0].copy())
            for steps in recorded(bank, round(duration / h))]  # fmt: skip
    place, force = map(np.concatenate, zip(*kept, strict=True))
    return place / np.sqrt(mass.mass), force, bank


def computed(coating, casing, h, duration=DURATION, **kind):
    """The same as `exact` by the kernel; see `thrown`."""
    return thrown(MASS, SPEED, h, duration, coating=coating, elastic_casing=casing, **kind)


def first_peak(name):
    """Errors of the first peak and of the depth that is worn then, with steps of 20 ns [-]."""
    coating, casing = WALLS[name]
    truth = exact(coating, casing, 2e-3, 2e-6)
    assert len(truth.events) >= 2
    curve = CubicHermiteSpline(2e-6 * np.arange(1001), truth.place, truth.velocity)
    highest = curve(curve.derivative().roots()).max()
    place, _, bank = computed(coating, casing, 2e-8, 2e-3)
    worn, depth = bank.law.surface.worn[0, 0], truth.worn[-1]
    assert coating is None or 0.0 < depth <= coating.thickness
    return abs(place.max() / highest - 1.0), abs(worn / depth - 1.0) if coating else 0.0


def motion_order(name):
    """Order of the error of a whole motion, of many steps: where in a step a contact begins is
    chance, and so is the factor of the error."""
    truth, errors = exact(*WALLS[name]), []
    parts = np.unique(np.round(3.0 * 2.0 ** (np.arange(20) / 4.0)).astype(int))
    for n in parts:
        place, _, _ = computed(*WALLS[name], 1e-5 / n)
        errors.append(np.abs(place[n - 1 :: n] - truth.place[1:]).max())
    return report.fitted_order(1e-5 / parts, np.array(errors))


def incursion():
    """Error of x = w + (σ_Y + H w/t) t/E where a casing comes 1.5 mm nearer, over x; and w/x."""
    omega, height, gap = 1e4, 1.5e-3, 0.5e-3
    mass = Mass(1e6, 2e6 * 0.9 * omega, 1e6 * omega**2)  # a stiff damped tip
    wall = {"casing": CasingShape(1, height), "ramp_time": 0.2}
    place, _, bank = thrown(mass, 0.0, 1e-5, 0.21, gap=gap, coating=HARD, **wall)
    x, w, t = place[-1] + height - gap, bank.law.surface.worn[0, 0], HARD.thickness
    assert abs(x - (height - gap)) < 1e-3 * x
    return abs(w + (HARD.yield_stress + HARD.hardening * w / t) * t / HARD.young - x) / x, w / x


def limits():
    """Order in 1/k of an elastic casing and of E, σ_Y → ∞ against the rigid one, and the error of
    σ_Y → ∞ against the elastic one of stiffness EA/t."""
    h, stiffness = 1e-5, 10.0 ** np.arange(13, 17)
    rigid, _, _ = computed(None, None, h)
    hard = HARD._replace(yield_stress=1e30)

    def off(*wall):
        return np.abs(computed(*wall, h)[0] - rigid).max() / rigid.max()

    elastic = [off(None, ElasticCasing(k)) for k in stiffness]
    coated = [off(hard._replace(young=k * hard.thickness / hard.area), None) for k in stiffness]
    spring, _, _ = computed(None, ElasticCasing(HARD.stiffnesses(HARD.area)[0]), h)
    place, _, _ = computed(hard, None, h)
    orders = [report.fitted_order(1.0 / stiffness, np.array(e)) for e in (elastic, coated)]
    return *orders, np.abs(place - spring).max() / spring.max()


def thrown_ledgers(coating):
    """Energy of a mass without damper that hits a bar or a spring and leaves it, by the step."""
    found, mass = [], MASS._replace(damper=0.0)
    for h in LEDGER_STEPS:
        spring = None if coating else SPRING
        bank, scene = ready(mass, SPEED, h, coating=coating, elastic_casing=spring)
        found.append(audit(bank, round(2e-3 / h), scene))
    return found


def reference_disk(**law):
    """Modes, Scene and speed [Hz] of the planar reference disk, with another law."""
    modes = mistuned_modes(reference_reduced(), np.linspace(-0.03, 0.03, 12))
    found = reference_scene(scheme="exact_modal", step=1e-5, casing=CasingShape(4, 1e-3), **law)
    return modes, found, 34.25


def ledger(modes, found, speed, revolutions):
    """Energy of one disk at a speed [Hz], from rest; see `energy.audit`."""
    grid = cut_revolution(speed, found)
    bank = allocate(modes, found, grid, 8, [speed])
    return audit(bank, revolutions * grid.steps_per_revolution, found)


def lobes():
    """At OWN/ORDERS: lobes that the program reports, vibrations in a turn, amplitude and depth."""
    modes = Modes.planar(np.array([2.0 * np.pi * OWN]), np.eye(1), np.eye(1))
    face = planar_interface(np.zeros(1), 0.5)
    found = Scene(
        face, 5e-4, CasingShape(2, 0.5e-3), 0.25e-3, 0.05, 0.0, coating=CUTS, step=2e-5,
        scheme="exact_modal", steady=SteadyCriteria(max_time=3.0),
    )  # fmt: skip
    speeds = OWN / np.array(ORDERS)
    swept = run_sweep(modes, found, speeds).wear
    per_turn = []
    for speed, end in zip(speeds, swept.time, strict=True):
        pieces = list(history.integrate(modes, found, [speed], end))
        time = np.concatenate([piece.time[:, 0] for piece in pieces])
        u = np.concatenate([piece.observed[:, 0, 0] for piece in pieces])
        turns = time > time[-1] - 20.0 / speed
        size = np.abs(np.fft.rfft(u[turns] - u[turns].mean()))
        per_turn.append(size.argmax() / 20.0)
    return swept.lobes, np.array(per_turn), swept.amplitude, swept.depth
