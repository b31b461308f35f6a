"""What an input says by the name of a file: its model and what has been measured (rank 0)."""

import numpy as np

from hpcrub.config.casing import MOST_POINTS
from hpcrub.config.checks import deviation_of
from hpcrub.config.schema import Config, replaced
from hpcrub.errors import InputError
from hpcrub.results import tables
from hpcrub.studies import imported

PROFILE_COLUMNS = "angle_deg", "radius_change_mm"
BLADE_COLUMNS = "blade", "frequency_hz"
DIGITS = 6  # of degrees and millimetres that are kept


def resolved(config: Config) -> Config:
    """The configuration with all that its files tell; the result file keeps it.

    Raises InputError for a file that cannot be used, or has changed.
    """
    return imported.resolved(with_tables(config))


def with_tables(config: Config) -> Config:
    """The same without a look at the model file, which may be large."""
    if not config.casing.is_resolved:
        config = replaced(config, _profile(config.casing.profile_csv))
    mistuning = config.mistuning
    if mistuning.blade_frequencies_csv and mistuning.blade_frequencies_hz is None:
        config = replaced(config, _blade_frequencies(mistuning))
    return config


def _blade_frequencies(mistuning):
    """Keys of blades that have been measured one by one: an explicit sample."""
    path = mistuning.blade_frequencies_csv
    if others := {"samples", "half_range_percent"} & mistuning.model_fields_set:
        raise InputError(
            f"mistuning.{max(others)}: cannot be combined with mistuning.blade_frequencies_csv, "
            "which is one sample; leave one out"
        )
    table = tables.columns(path, BLADE_COLUMNS)
    blade, frequency = table[np.argsort(table[:, 0], kind="stable")].T
    if not np.array_equal(blade, np.arange(1, len(blade) + 1)):
        raise InputError(
            f"mistuning.blade_frequencies_csv: {path}: a line for each blade is expected, numbered "
            "from 1"
        )
    if not (frequency > 0.0).all():
        raise InputError(f"mistuning.blade_frequencies_csv: {path}: frequencies above 0 Hz")
    deviation = deviation_of("blade_frequencies_hz", frequency, 1.0)
    return {
        "mistuning.blade_frequencies_hz": frequency.tolist(),
        "mistuning.samples": 1,
        "mistuning.half_range_percent": [100 * float(np.abs(deviation).max())],
    }


def _profile(path):
    """Keys of a measured casing: its points in the order of their angles, 360° as 0°."""
    table = np.round(tables.columns(path, PROFILE_COLUMNS), DIGITS)
    angle, change = table.T
    if (angle < 0.0).any() or (angle > 360.0).any():
        raise InputError(f"casing.profile_csv: {path}: angles from 0 to 360 degrees are allowed")
    if 0.0 in angle:
        table = table[angle < 360.0]  # the first point again
    table[:, 0] %= 360.0
    table = table[np.argsort(table[:, 0], kind="stable")]
    if not 4 <= len(table) <= MOST_POINTS:
        raise InputError(
            f"casing.profile_csv: {path} has {len(table)} points; 4 to {MOST_POINTS:,} are allowed"
        )
    twice = np.flatnonzero(np.diff(table[:, 0]) == 0.0)
    if len(twice):
        raise InputError(
            f"casing.profile_csv: {path} has two points at {table[twice[0], 0]:g} degrees"
        )
    if np.abs(change).max() > 1e4:
        raise InputError(f"casing.profile_csv: {path}: changes of radius of more than 10 m")
    return {"casing.profile_deg": table[:, 0].tolist(), "casing.profile_mm": table[:, 1].tolist()}
