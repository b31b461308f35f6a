"""The reference disk of all tests and measurements: its dimensions in SI units, no input file."""

from functools import cache
from types import SimpleNamespace

import numpy as np

from hpcrub.model.casing import CasingShape
from hpcrub.model.casing_modes import Ring
from hpcrub.model.disk import build_disk
from hpcrub.model.reduction import craig_bampton
from hpcrub.response.scene import Scene

MATERIAL = SimpleNamespace(young_modulus=2.1e11, density=7800.0)
DAMPING_RATIO = 5e-3
LOAD = 150.0  # [N]
# casings that vibrate
STEEL = Ring(radius=0.5025, thickness=0.02, width=0.1, young=2.1e11, density=7800.0)
ALUMINIUM = STEEL._replace(thickness=5e-3, young=7e10, density=2700.0)


def disk_section(blade=None, **changes):
    """Geometry of the reference disk, with changes; blade: changes of the blade."""
    values = {
        "n_blades": 12,
        "tip_radius": 0.5,
        "hub_radius": 0.2,
        "inner_radius": 0.1608,
        "width": 0.1,
        "ring_thickness": 14.25e-3,
        "spoke_thickness": 7.899e-3,
    }
    blade_values = {
        "n_elements": 5,
        "thickness": 13.309e-3,
        "lean": np.radians(-43.74),
        "bow": 0.07924,
    }
    blade_section = SimpleNamespace(**(blade_values | (blade or {})))
    return SimpleNamespace(**(values | changes), blade=blade_section)


def make_disk(blade=None, **changes):
    """Disk of `disk_section`."""
    return build_disk(disk_section(blade, **changes), MATERIAL)


EARLIER = {  # the first of inputs/earlier_disk.yaml: other programs have its frequencies
    "inner_radius": 0.1699,
    "ring_thickness": 13.39e-3,
    "spoke_thickness": 7.23e-3,
    "blade": {"thickness": 13.44e-3, "lean": np.radians(45.41), "bow": -0.0459},
}


@cache
def earlier_disk():
    """The tuned Disk of the dimensions that hpcrub 0.1 had."""
    return make_disk(**EARLIER)


@cache
def earlier_reduced(n_modes=60):
    """ReducedModel of it with n_modes fixed-interface modes."""
    return craig_bampton(earlier_disk(), n_modes)


@cache
def reference_disk():
    """The tuned Disk with all its dof."""
    return make_disk()


@cache
def reference_reduced(n_modes=60):
    """ReducedModel with n_modes fixed-interface modes."""
    return craig_bampton(reference_disk(), n_modes)


def reference_scene(n_modes=60, **changes):
    """Scene of the reference disk with four bumps, with changes."""
    values = {
        "interface": reference_reduced(n_modes).interface,
        "damping_ratio": DAMPING_RATIO,
        "casing": CasingShape(4, 1.25e-3),
        "clearance": 0.25e-3,
        "ramp_time": 0.01,
        "friction": 0.15,
    }
    return Scene(**(values | changes))


def mistune(disk, deviation):
    """Full model whose blade i is 1 + deviation[i] times as stiff; deviation: (N,) [-]."""
    scale = np.asarray(deviation)[:, None, None]
    stiffness = disk.stiffness.copy()
    rows, columns = disk.blade_dof[:, :, None], disk.blade_dof[:, None, :]
    np.add.at(stiffness, (rows, columns), scale * disk.blade_stiffness)
    return disk._replace(stiffness=stiffness, blade_stiffness=(1 + scale) * disk.blade_stiffness)
