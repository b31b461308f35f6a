"""Disks from model files: keys of the configuration, full and reduced model, figure geometry."""

import functools
from typing import Any, NamedTuple

import numpy as np

from hpcrub.config.schema import Config
from hpcrub.errors import InputError, reading
from hpcrub.model import families
from hpcrub.model.imported import assembly, bent_blades, checks, cyclic, neutral, reduced
from hpcrub.model.imported.neutral import NeutralModel
from hpcrub.model.interface import strips
from hpcrub.model.reduction import ReducedModel, mistuned_modes
from hpcrub.results import model_file

DIGITS = 4  # digits kept of a frequency: further digits may differ between machines


def resolved(config: Config) -> Config:
    """Complete a configuration from its model file, if it has one (rank 0).

    Raises InputError for a model file that cannot be used or has changed.
    """
    path = config.disk.model
    if path is None or config.disk.is_resolved:
        return config
    checksum = model_file.checksum(path)
    model = _read(path, checksum)
    if len(model.stress_blade) and config.limits.stress_mpa_per_mm is not None:
        raise InputError(f"limits.stress_mpa_per_mm: {path} has stresses of its own; leave it out")
    static, (of_node, direction) = model.stress_static, model.dof.T
    moves = (of_node == model.contact_node[0]) & np.isin(direction, (1, 2, 3))
    directions = min(3, max(2, int(moves.sum())))
    n_points = len(model.contact_node) * (model.n_sectors or 1)
    x, y, z = model.nodes[model.contact_node].T
    radius = np.hypot(x, y)
    keys = {
        "disk.model_sha256": checksum,
        "disk.n_blades": model.n_blades,
        "disk.n_contact_nodes": n_points,
        "disk.n_directions": directions,
        "disk.n_strips": 1 + int(strips(z, radius).max()),
        "disk.n_stresses": len(model.stress_blade) * (model.n_sectors or 1),
        "disk.static_mpa": float(1e-6 * static.max(initial=0.0)) if len(static) else None,
        "disk.tip_radius_mm": float(1e3 * radius.max()),
        "disk.least_clearance_mm": float(1e3 * model.contact_clearance.min()),
    }
    n_modes = families.whole(config.reduction.n_modes, model.n_blades)
    if model.kind == "reduced":
        n_modes = len(model.dof) - directions * n_points
    keys["reduction.n_modes"] = n_modes
    by_diameter = functools.partial(cyclic.frequencies_by_diameter, model)
    family = checks.at_speed("speeds", by_diameter, mid_speed(config))[:, 0]
    keys["disk.second_order_per_m"] = bent_blades.size_of(model)
    keys["disk.first_family_hz"] = float(f"{np.nanmax(family):.{DIGITS}g}")
    return config.replace(keys)


def mid_speed(config: Config) -> float:
    """Speed at which mode shapes are computed: the middle of all, or rest if none is given [rad/s].

    A linear study has no speeds; it goes from rest to the resonance of every disk and load.
    """
    if config.study == "linear":
        return 0.0
    return np.pi * (config.speeds.from_hz + config.speeds.to_hz)


def build(config: Config) -> tuple[NeutralModel | None, ReducedModel]:
    """Build the assembled disk of a model file (None if it is reduced) and its reduced model.

    Raises InputError for a file that cannot be used or is not the file of the configuration.
    """
    path, checksum = str(config.disk.model), str(config.disk.model_sha256)
    model_file.require("disk.model", path, checksum)
    model = _read(path, checksum)
    disk = None if model.kind == "reduced" else assembly.assemble(model)
    by_modes = config.mistuning.by == "cantilever_modes"

    def reduce(speed: Any) -> Any:
        if disk is None:
            return reduced.reduced_model(model, speed, by_modes)
        rows, basis = reduced.reduce_disk(disk, config.reduction.n_modes, speed)
        return reduced.reduced_model(rows, speed, by_modes)._replace(basis=basis)

    small = checks.at_speed("speeds", reduce, mid_speed(config))
    speeds = 2 * np.pi * config.speeds.values_hz if mid_speed(config) else np.zeros(1)
    lowest = mistuned_modes(small, np.zeros(model.n_blades)).omega_at(speeds).min(axis=-1)
    if not lowest.all():
        raise checks.too_fast("speeds", speeds[lowest == 0.0][0])
    return disk, small


class Scenery(NamedTuple):
    """Geometry of a model file's disk for figures: n nodes with places."""

    nodes: np.ndarray  # (n, 3) [m]
    surface: np.ndarray  # (F, 4) nodes of faces
    contact_node: np.ndarray  # (C,)
    contact_blade: np.ndarray  # (C,)
    rows: np.ndarray  # (n, 3) rows of u_r, u_theta, u_z, of coordinates if reduced; -1: none
    is_reduced: bool


def scenery(config: Config) -> Scenery:
    """Nodes for figures of a model file: of surface and contact, or all without a surface."""
    disk = assembly.assemble(_read(str(config.disk.model), str(config.disk.model_sha256)))
    shown = np.isfinite(disk.nodes).all(axis=1)
    if len(disk.surface):
        shown &= np.isin(np.arange(len(shown)), np.union1d(disk.surface, disk.contact_node))
    place = np.cumsum(shown) - 1
    nodes, surface, contact = disk.nodes[shown], place[disk.surface], place[disk.contact_node]
    is_reduced = disk.kind == "reduced"
    return Scenery(nodes, surface, contact, disk.contact_blade, disk.row[shown], is_reduced)


def known_speeds(config: Config) -> np.ndarray:
    """Speeds [Hz] of the matrices of a model file; (0,) where there is none or it does not tell."""
    if config.disk.model is None:
        return np.zeros(0)
    return _read(config.disk.model, str(config.disk.model_sha256)).speeds


def require_blade_stiffness(config: Config, drawn: bool) -> None:
    """Raise InputError when blades are mistuned and the model file lacks their stiffness.

    drawn: whether the study draws disks at random; otherwise only a pattern mistunes blades.
    """
    path, mistuning = config.disk.model, config.mistuning
    if path is None or mistuning.by == "cantilever_modes":
        return
    pattern = config.pattern_deviation
    wanted = (mistuning.half_range if drawn else 0.0) if pattern is None else pattern
    if np.any(wanted) and _read(path, str(config.disk.model_sha256)).blade_stiffness is None:
        raise InputError(f"disk.model: {path} has no K_blade; its blades cannot be mistuned")


@functools.lru_cache(maxsize=1)
def _read(path: str, checksum: str) -> NeutralModel:
    """Read and check the model of a file; cached, because a run uses it several times."""
    try:
        with reading(path):
            model = neutral.from_arrays(model_file.read(path))
            checks.check(model)
    except InputError as error:
        text = str(error)
        raise InputError(text if text.startswith(str(path)) else f"{path}: {text}") from None
    return model
