"""Reading of files that an input names: model, measured casing, waves, patterns (rank 0)."""

import functools
import os
from typing import Any

import numpy as np

from hpcrub.config.casing import MOST_POINTS, CasingMode
from hpcrub.config.checks import deviation_of, pattern_problem
from hpcrub.config.schema import Config
from hpcrub.errors import InputError
from hpcrub.model.imported.readers.text import columns, table
from hpcrub.results import model_file
from hpcrub.setup import imported

PROFILE_COLUMNS = "angle_deg", "radius_change_mm"
WAVE_COLUMNS = "diameters", "damping_ratio", "frequency_shift"
# columns of the tables of curves
CURVES = {
    "casing.clearance_hz_mm": ("speed_hz", "clearance_mm"),
    "casing.clearance_s_mm": ("time_s", "clearance_mm"),
    "run_up.speed_s_hz": ("time_s", "speed_hz"),
}
MOST_MODES, MOST_WAVES, MOST_POINTS_OF_CURVE = 100, 1000, 1000  # rows that keys of tables can hold


def resolved(config: Config) -> Config:
    """Complete a configuration from the files that it names; the result file keeps the outcome.

    Raises InputError for a file that cannot be used or has changed.
    """
    config = imported.resolved(with_tables(config))
    own = config.contact.own_law
    if own is not None and config.contact.own_law_sha256 is None:
        checksum = model_file.checksum(own.rpartition(":")[0])
        config = config.replace({"contact.own_law_sha256": checksum})
    if config.mistuning.pattern_file is not None:
        patterns(config)
    return config


def with_tables(config: Config) -> Config:
    """Complete a configuration from its tables only; a model file may be too large to read."""
    casing, aero, mistuning = config.casing, config.aero, config.mistuning
    curves = {
        key: _table(key, path, names, MOST_POINTS_OF_CURVE).tolist()
        for key, names in CURVES.items()
        if isinstance(path := config.value(key), str)
    }
    config = config.replace(curves) if curves else config
    config = _filled(config, casing.profile_csv, casing.profile_mm, _profile)
    config = _filled(config, casing.modes_csv, casing.modes, _modes)
    config = _filled(config, aero.waves_csv, aero.waves, _waves)
    if mistuning.pattern_file is not None and mistuning.pattern_sha256 is None:
        config = config.replace(_patterns(config))
    return config


def _filled(config: Config, path: Any, given: Any, keys_of: Any) -> Any:
    """Fill in the keys of a table; if the input gives them, too, they must be those of the table.

    The configuration of a result file has both, and the table may no longer be there.
    """
    if path is None or (given and not os.path.exists(path)):
        return config
    keys = keys_of(path)
    try:
        filled = config.replace(keys)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    if given and filled != config:
        raise InputError(f"{min(keys)}: given beside {path}, which says otherwise; leave one out")
    return filled


def patterns(config: Config) -> np.ndarray:
    """Stiffness deviations of all disks in the file of patterns (samples, N) [-].

    Raises InputError when the file has changed or does not fit the disk.
    """
    mistuning, n_blades = config.mistuning, config.disk.n_blades
    path, unit = mistuning.pattern_file, mistuning.pattern_unit
    young = config.material.young_modulus_gpa
    deviations = _deviations(path, mistuning.pattern_sha256, unit, young)
    if deviations.shape[1] != n_blades:
        raise InputError(
            f"mistuning.pattern: {path} has {deviations.shape[1]} columns for the {n_blades} "
            f"blades of disk.{'model' if config.disk.model else 'n_blades'}"
        )
    if len(deviations) < mistuning.samples:
        raise InputError(
            f"mistuning.samples: {mistuning.samples} asked for, {path} has {len(deviations)} disks"
        )
    return deviations[: mistuning.samples]


def _patterns(config: Any) -> Any:
    """Keys for measured disks: one level as wide as the largest deviation, each disk a sample."""
    mistuning, path = config.mistuning, config.mistuning.pattern_file
    if "half_range_percent" in mistuning.model_fields_set:
        raise InputError(
            "mistuning.half_range_percent: cannot be combined with mistuning.pattern, whose "
            "disks are one level; leave it out"
        )
    checksum = model_file.checksum(path)
    changes = _deviations(path, checksum, mistuning.pattern_unit, config.material.young_modulus_gpa)
    largest = 100.0 * float(np.abs(changes).max())
    keys: dict[str, Any] = {"mistuning.pattern_sha256": checksum}
    keys["mistuning.half_range_percent"] = [largest]
    if "samples" not in mistuning.model_fields_set:
        keys["mistuning.samples"] = len(changes)
    return keys


@functools.lru_cache(maxsize=4)
def _deviations(path: str, checksum: str, unit: str, young_modulus_gpa: float) -> np.ndarray:
    """Deviations (disks, N) in a table of patterns [-]; cached, because every sample reads it."""
    model_file.require("mistuning.pattern", path, checksum)
    values = table(path)[1]
    deviations = np.array([deviation_of(row, unit, young_modulus_gpa) for row in values])
    if problem := pattern_problem(values, deviations, unit):
        raise InputError(f"mistuning.pattern: {path}: {problem}")
    return deviations


def _table(key: str, path: Any, names: Any, most: Any) -> Any:
    """Columns (rows, names) of the table that a key names, of `most` rows at most."""
    try:
        return columns(path, names, most)
    except InputError as error:
        raise InputError(f"{key}: {error}") from None


def _modes(path: Any) -> dict[Any, Any]:
    """Keys of the modes of a casing that vibrates."""
    names = tuple(CasingMode.model_fields)
    rows = _table("casing.modes_csv", path, names, MOST_MODES).tolist()
    return {"casing.modes": [dict(zip(names, row, strict=True)) for row in rows]}


def _waves(path: Any) -> dict[Any, Any]:
    """Keys of a family's waves; the sign of the diameters says which way a wave travels."""
    rows = _table("aero.waves_csv", path, WAVE_COLUMNS, MOST_WAVES)
    ways = {1.0: "forward", -1.0: "backward", 0.0: "neither"}
    waves = [
        {
            "diameters": abs(h),
            "travels": "neither" if 2 * abs(h) == len(rows) else ways[float(np.sign(h))],
            "damping_ratio": damping,
            "frequency_shift": shift,
        }
        for h, damping, shift in rows.tolist()
    ]
    return {"aero.waves": waves}


def _profile(path: Any) -> dict[Any, Any]:
    """Keys of a measured casing: its points sorted by angle, of which 360° is 0°."""
    points = _table("casing.profile_csv", path, PROFILE_COLUMNS, MOST_POINTS + 1)
    points[points[:, 0] == 360.0, 0] = 0.0
    points = np.unique(points, axis=0)  # by angle; at 360 degrees may stand the first one again
    return {"casing.profile_deg": points[:, 0].tolist(), "casing.profile_mm": points[:, 1].tolist()}
