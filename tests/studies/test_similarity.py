"""Similarity: a disk four times as large, of the same material, does the same four times slower.

Stresses stay what they are, lengths and times become four times as large, forces sixteen times. All
factors are powers of two, and so are those of masses and mode shapes: every number of a result is
the same to the last bits, as its unit says, unless a quantity enters with a wrong power somewhere
between input and file, or the code has a length, time or force of its own.
"""

import h5py
import numpy as np
import pytest

from hpcrub.config.schema import Config
from hpcrub.response.scene import RECORD_INTERVAL
from hpcrub.setup import problem
from tests.program import TINY, run_here

LARGER = 4.0
# powers of the factor, of keys by the ends of their names and of datasets by their units
KEYS = {"hz_mm": (-1, 1), "per_s": -2, "mm2": 2, "mm": 1, "hz": -1, "s": 1, "per_m": 1, "n": 2}
UNITS = {"m": 1, "s": 1, "Hz": -1, "1/s": -1, "Hz/s": -2, "N": 2, "J": 3, "m3": 3}
PARTS = "casing.ring", "contact.coating", "run_up", "limits"  # refused where they have no effect
SAME = "1", "Pa", "percent", "degree"
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


def larger(path, value):
    """Value of a key for the larger disk."""
    ends = [end for end in KEYS if path.endswith(f"_{end}")]
    if not ends or value is None:
        return value
    powers = KEYS[ends[0]]
    return (np.array(value) * LARGER ** np.array(powers, dtype=float)).tolist()


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
def test_a_larger_disk_does_the_same_more_slowly(case, tmp_path, monkeypatch):
    small = Config.from_yaml(TINY).replace({"speeds.from_hz": 34, "speeds.to_hz": 35})
    small = small.replace({"speeds.step_hz": 0.5} | CASES[case])
    unused = tuple(part for part in PARTS if not any(key.startswith(part) for key in CASES[case]))
    keys = {key: larger(key, value) for key, value in small.by_path().items()}
    large = small.replace({key: v for key, v in keys.items() if not key.startswith(unused)})
    files = []
    for config, factor in ((small, 1.0), (large, LARGER)):
        monkeypatch.setattr(problem, "RECORD_INTERVAL", factor * RECORD_INTERVAL)
        path = tmp_path / f"{factor:g}.yaml"
        path.write_text(config.replace({"output": f"{path}.h5"}).to_yaml())
        assert run_here(path) == 0
        files.append(results(f"{path}.h5"))
    assert files[0].keys() == files[1].keys() != set()
    for name, (values, unit) in files[0].items():
        power = 0 if unit in SAME else UNITS[unit]
        np.testing.assert_allclose(
            files[1][name][0], values * LARGER**power, rtol=1e-12, err_msg=name
        )
