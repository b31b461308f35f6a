"""A mass that is thrown at a casing that gives or wears; the walls and coatings of these tests."""

import numpy as np

from evidence.truth.bars import Mass, Reference
from evidence.truth.motion import Structure, make_bank, recorded, start_free, wall
from hpcrub.model.coating import Coating, ElasticCasing

MASS = Mass(0.8, 15.0, 0.8 * (2.0 * np.pi * 150.0) ** 2)
GAP, SPEED, DURATION = 1e-4, 2.0, 6e-3
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
