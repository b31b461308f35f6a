"""Similarity: every number of a result scales as its unit does when all keys do.

Lengths become twice, times four times and masses sixteen times as large, and so stresses half as
large. All factors are powers of two, also that of the square root of a mass in the mode shapes, so
that rounding stays what it is: the numbers are the same to the last bits, unless a quantity enters
with a wrong power somewhere between input and file, or the code has a length, time, mass or stress
of its own.
"""

import h5py
import numpy as np
import pytest

from hpcrub.config.schema import Config
from hpcrub.response.scene import RECORD_INTERVAL
from hpcrub.setup import problem
from tests.program import TINY, run_here

FACTORS = np.array([2.0, 4.0, 16.0])  # of lengths, times and masses
# powers of length, time and mass: of keys by the ends of their names, of datasets by their units
KEYS = {
    "hz_mm": ((0, -1, 0), (1, 0, 0)),
    "per_s": (0, -2, 0),
    "mm2": (2, 0, 0),
    "mm": (1, 0, 0),
    "hz": (0, -1, 0),
    "s": (0, 1, 0),
    "n": (1, -2, 1),
    "kg_m3": (-3, 0, 1),
    "gpa": (-1, -2, 1),
    "mpa": (-1, -2, 1),
    "n_per_m2": (-1, -2, 1),
}
UNITS = {
    "m": (1, 0, 0),
    "s": (0, 1, 0),
    "Hz": (0, -1, 0),
    "1/s": (0, -1, 0),
    "Hz/s": (0, -2, 0),
    "N": (1, -2, 1),
    "J": (2, -2, 1),
    "Pa": (-1, -2, 1),
    "m3": (3, 0, 0),
    "1": (0, 0, 0),
    "percent": (0, 0, 0),
    "degree": (0, 0, 0),
}
PARTS = "casing.ring", "contact.coating", "run_up", "limits"  # refused where they have no effect
CASES = {
    "rigid": {"mistuning.checked_samples": 1, "limits.stress_mpa": 300, "limits.amplitude_mm": 30},
    "coated": {
        "contact.law": "abradable",
        "contact.coating.thickness_mm": 2,
        "casing.clearance_hz_mm": [[30, 0.5], [40, 0.2]],
    },
    "ring": {
        "study": "time_response",
        "speeds.to_hz": 34,
        "casing.ring.thickness_mm": 20,
        "casing.ring.radius_mm": 502.5,
        "casing.ring.width_mm": 100,
        "history.duration_s": 0.25,
    },
    "run-up": {"study": "run_up", "run_up.hz_per_s": [8], "limits.amplitude_mm": 10},
}


def factor(powers):
    """Factors (...) of quantities with powers (..., 3) of length, time and mass."""
    return np.prod(FACTORS ** np.array(powers, dtype=float), axis=-1)


def scaled(path, value):
    """Value of a key for the other disk."""
    ends = [end for end in KEYS if path.endswith(f"_{end}")]
    if not ends or value is None:
        return value
    return (np.array(value) * factor(KEYS[ends[0]])).tolist()


def results(path):
    """All numbers of a result file, and their units."""
    found = {}

    def take(name, item):
        if isinstance(item, h5py.Dataset) and item.dtype.kind in "fiu":
            found[name] = item[()], item.attrs["units"].decode()

    with h5py.File(path) as file:
        file.visititems(take)
    return found


@pytest.mark.parametrize("case", CASES)
@pytest.mark.long
def test_results_scale_by_their_units(case, tmp_path, monkeypatch):
    small = Config.from_yaml(TINY).replace({"speeds.from_hz": 34, "speeds.to_hz": 35})
    small = small.replace({"speeds.step_hz": 0.5} | CASES[case])
    unused = tuple(part for part in PARTS if not any(key.startswith(part) for key in CASES[case]))
    keys = {key: scaled(key, value) for key, value in small.by_path().items()}
    other = small.replace({key: v for key, v in keys.items() if not key.startswith(unused)})
    files = []
    for config, times in ((small, 1.0), (other, FACTORS[1])):
        monkeypatch.setattr(problem, "RECORD_INTERVAL", times * RECORD_INTERVAL)
        path = tmp_path / f"{times:g}.yaml"
        path.write_text(config.replace({"output": f"{path}.h5"}).to_yaml())
        assert run_here(path) == 0
        files.append(results(f"{path}.h5"))
    assert files[0].keys() == files[1].keys() != set()
    for name, (values, unit) in files[0].items():
        expected = values * factor(UNITS[unit])
        np.testing.assert_allclose(files[1][name][0], expected, rtol=1e-12, err_msg=name)
