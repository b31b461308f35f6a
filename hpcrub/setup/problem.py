"""Construction of the tuned disk, full and reduced, and of the scene."""

import math
import os
from typing import Any, NamedTuple

import numpy as np

from hpcrub.config import resolution, run_up
from hpcrub.config.schema import Config
from hpcrub.contact.cyclic import Cyclic
from hpcrub.contact.dense import Dense
from hpcrub.contact.lanes import WIDTHS
from hpcrub.errors import InputError
from hpcrub.model.coating import Coating, ElasticCasing
from hpcrub.model.disk import build_disk
from hpcrub.model.interface import Interface, planar_interface
from hpcrub.model.reduction import ReducedModel, craig_bampton
from hpcrub.model.second_order_planar import planar_second_order
from hpcrub.model.tuned_basis import TunedBasis, tuned_basis
from hpcrub.response.revolution import speed_bands
from hpcrub.response.run_up import LANES as REPEATS
from hpcrub.response.scene import RECORD_INTERVAL, Scene, enough
from hpcrub.response.steady import SteadyCriteria
from hpcrub.setup import imported
from hpcrub.setup.aero import in_air
from hpcrub.setup.casing import casing_modes_of
from hpcrub.setup.laws import law_of

# Numbers of samples, for a planar disk and for a model file, from which kernels of several widths
# gain more time than their compilation takes (docs/kernel.md).
MANY_SAMPLES = 500, 20
# A step may cost so much more with a basis that samples share, as it needs no eigenproblem of a
# sample, has the frequencies and shapes of every speed, and fills lanes with samples.
DEARER = 4.0 / 3.0
ALONE = 8  # most lanes of a sweep that cannot go on with fewer at its end
FURTHEST = 3e-4  # bound of the change of stiffness in a run of one disk (`disks.run_deviation`)
CRITERIA = SteadyCriteria._fields[:-2]  # those that are keys
SMALLEST = 1e-13  # of the largest eigenvalue: smaller eigenvalues have hardly a correct digit


class Model(NamedTuple):
    """The tuned disk, full and reduced."""

    disk: Any  # Disk, or assembled NeutralModel; None: a model file that is reduced already
    reduced: ReducedModel


class Problem(NamedTuple):
    """Data from which every rank can compute any sample."""

    reduced: ReducedModel
    scene: Scene
    basis: TunedBasis | None = None  # that all samples share; None: every sample has its own modes


def build_model(config: Config) -> Model:
    """Build the tuned disk and its air. Raises InputError for impossible geometry or model file."""
    disk, reduced = imported.build(config) if config.disk.model else _planar(config)
    return Model(disk, in_air(config, reduced))


def _planar(config: Config) -> tuple[Any, Any]:
    try:
        with np.errstate(all="ignore"):
            disk = build_disk(config.disk, config.material)
            reduced = craig_bampton(disk, config.reduction.n_modes)
        values = reduced.tuned_eigenvalues
    except np.linalg.LinAlgError:  # not positive definite, by rounding
        values = np.array([np.nan])
    except (ValueError, ArithmeticError) as error:
        raise InputError(f"disk: {error}") from None
    if not (np.isfinite(values).all() and values[0] > SMALLEST * values[-1]):
        raise InputError(
            "disk: the stiffnesses of its parts are too far apart for the arithmetic of this "
            "program (lengths and thicknesses of disk, material)"
        )
    return disk, reduced


def build_problem(config: Config) -> Problem:
    """Build the reduced model and the scene of a configuration.

    Raises InputError for an impossible geometry, for a time step above the stability limit, and for
    a load without a known engine order.
    """
    if config.forcing.in_contact and config.engine_order is None:
        raise InputError(
            "forcing.engine_order: a casing without equal bumps does not say how many periods the "
            "load has; give their number"
        )
    model = build_model(config)
    reduced = model.reduced
    # samples do not need the basis of the full model, which would be sent to all ranks
    no_basis = np.zeros((0, len(reduced.mass)))
    interface = interface_of(config, model)
    reduced = reduced._replace(basis=no_basis, casing=casing_modes_of(config), interface=interface)
    # K = K0 + sum_i d_i K_i <= (1 + max d) K0, hence omega <= omega_tuned sqrt(1 + max d)
    stiffest = _stiffest(config)
    fastest = float(np.sqrt(reduced.tuned_eigenvalues[-1] * (1.0 + stiffest)))
    if reduced.casing:
        fastest = max(fastest, reduced.casing.omega.max())
    limit = 2.0 / fastest
    if config.time.scheme == "central_difference" and not resolution.longest_step(config) < limit:
        raise InputError(
            f"time.step_s: {config.time.step_s:g} is not below {limit:.4g} s, the stability limit "
            f"of central_difference for this {'disk and casing' if reduced.casing else 'model'}"
        )
    scene = scene_of(config, interface)._replace(law=law_of(config))
    # runs of a sample may be stiffer; a law of one's own has its own multipliers
    is_spatial = config.disk.model is not None and scene.law is None
    basis = _basis(reduced, stiffest + FURTHEST) if is_spatial else None
    if basis:
        scene = scene._replace(lanes=_lanes(config, are_shared=True))
    return Problem(reduced, scene, basis)


def _stiffest(config: Config) -> float:
    """Largest deviation of a blade in any disk of a configuration [-]."""
    pattern = config.pattern_deviation
    added = max(config.patterns.types_percent) / 100.0 if config.study == "patterns" else 0.0
    largest = config.mistuning.largest if pattern is None else float(np.max(pattern)) + FURTHEST
    return max(largest + max(added, 0.0), FURTHEST)


def _basis(reduced: ReducedModel, reference: float) -> TunedBasis | None:
    """Basis that all samples share, where a step with it costs little more, or less.

    reference: deviation of its blades, above that of any blade of a sample [-].
    """
    forced = os.environ.get("HPCRUB_BASIS")  # for tests: dense or cyclic
    if forced == "dense" or not len(reduced.interface.axial):
        return None
    basis = tuned_basis(reduced, reference)
    if basis is None or forced == "cyclic":
        return basis
    return basis if Cyclic.cost(basis.modes) < DEARER * Dense.cost(basis.modes) else None


def interface_of(config: Config, model: Model) -> Interface:
    """Interface of a disk with second order, clearances and strength of a configuration.

    Raises InputError for a model file that does not know the second order that is asked for.
    """
    interface = model.reduced.interface
    if not config.contact.bends:
        interface = interface._replace(second_order=None)
    elif config.disk.model is None:
        second = planar_second_order(model.disk, model.reduced.basis, config.disk, config.material)
        # directions turn as in three dimensions, so that the law is that of such disks
        axial = np.zeros_like(interface.normal)
        interface = interface._replace(second_order=second, axial=axial)
    elif interface.second_order is None:
        raise InputError(
            f"contact.kinematics: {config.disk.model} does not hold the second order of its "
            "blades; import it with --second-order, or leave displacements small"
        )
    own = np.array(config.casing.blade_clearance_mm or [0.0] * interface.n_blades) / 1000
    interface = interface._replace(clearance=interface.clearance + own[interface.blade])
    strength, static = config.limits.strength_mpa, interface.stress_static
    if strength is None or not len(static):
        return interface
    # stresses are raised for the tension of rotation (Goodman); compression is no margin
    left = 1.0 - np.maximum(static, 0.0) / (1e6 * strength)
    return interface._replace(stress=interface.stress / left[:, None])


def second_order_size(config: Config) -> tuple[float, ...] | None:
    """Shift and bend of `model.second_order.size_of` [1/m]; None: the model file tells none."""
    if config.disk.model is not None:
        return config.disk.second_order_per_m
    disk = build_disk(config.disk, config.material)
    whole = np.eye(len(disk.mass))
    return planar_second_order(disk, whole, config.disk, config.material).size


def left_out(config: Config, size: float) -> tuple[float, float]:
    """What small displacements leave out of the place of a tip that moves by `size` [m].

    Returns the shift of the tip outwards, u²/2R where the model file tells none, and how far the
    casing reaches into the tips' path [m].
    """
    told = second_order_size(config)
    shift = size**2 * (told[0] if told else 0.5 / config.disk.tip_radius)
    return shift, config.casing.outline.highest - config.clearance


def allows_second_order(config: Config) -> bool:
    """Whether an input of small displacements can be computed to second order as well."""
    fits = not (config.contact.bends or config.casing.vibrates or config.contact.own_law)
    return fits and (config.disk.model is None or config.disk.second_order_per_m is not None)


def checks_second_order(config: Config) -> bool:
    """Whether a study that draws disks computes some of them to second order as well."""
    return config.mistuning.checked_samples > 0 and allows_second_order(config)


def to_second_order(config: Config) -> Config:
    """The input with displacements to second order."""
    return config.replace({"contact.kinematics": "second_order"})


def scene_of(config: Config, interface: Interface | None = None) -> Scene:
    """Casing, contact, time step, steady-state test of a configuration, without a law of its own.

    interface: of the disk (`interface_of`); None before there is a model, for the division of a
    revolution into time steps alone.
    """
    contact, steady = config.contact, config.steady_state
    interface = interface or planar_interface(np.zeros(config.disk.n_blades), 1.0)
    stiffness, damping = contact.casing_stiffness_n_per_m, contact.casing_damping_ns_per_m
    return Scene(
        interface=interface,
        damping_ratio=config.damping,
        casing=config.casing.shape,
        clearance=config.clearance,
        running=config.casing.running,
        over_time=config.casing.over_time if run_up.runs_up(config) else None,
        ramp_time=config.casing.growth_time,
        friction=contact.friction,
        load=config.forcing.amplitude if config.forcing.in_contact else 0.0,
        load_order=config.engine_order or 1,
        elastic_casing=None if stiffness is None else ElasticCasing(stiffness, damping),
        coating=coating_of(config, interface),
        scheme=config.time.scheme,
        step=resolution.longest_step(config),
        least_steps=resolution.least_steps(config),
        record_interval=resolution.record_interval(config, RECORD_INTERVAL),
        history_interval=config.history.record_interval_s or math.inf,
        look_interval=resolution.look_interval(config),
        steady=SteadyCriteria(*(getattr(steady, name) for name in CRITERIA)),
        furthest=interface.second_order.furthest if interface.second_order else math.inf,
        observes_stress=config.observes_stress,
        lanes=_lanes(config),
    )


def _lanes(config: Config, are_shared: bool = False) -> Any:
    """Numbers of lanes for a configuration: as many as its speeds fill, and fewer at the end.

    are_shared: whether the samples fill the lanes together.
    """
    if run_up.runs_up(config):
        return (enough(REPEATS, config.run_up.repeats),)
    fit = enough(WIDTHS, max(map(len, speed_bands(config.speeds.values_hz))))
    fit = WIDTHS[-1] if are_shared else fit
    many = config.mistuning.samples >= MANY_SAMPLES[config.disk.model is not None]
    return tuple(n for n in WIDTHS if n <= fit) if many else (min(fit, ALONE),)


def coating_of(config: Config, interface: Interface) -> Coating | None:
    """Coating that wears; None unless the contact law is abradable."""
    if not config.contact.wears:
        return None
    c = config.contact.coating
    area, width = config.disk.blade.thickness * config.disk.width, config.disk.width
    if config.disk.model is not None:
        width = float(np.ptp(interface.axial_position)) if interface.n_strips > 1 else np.nan
    if c.tip_area_mm2 is not None:
        area = c.tip_area_mm2 / 1e6
    return Coating(c.thickness, c.young, c.yield_stress, c.hardening, area, width)
