"""Results at a speed do not depend on the other speeds of a study."""

import numpy as np

import hpcrub
from hpcrub.commands import run as cli
from tests.program import TINY

SPEED = 34.2
GRIDS = {
    "alone": ("speeds.from_hz=34.2", "speeds.to_hz=34.2"),
    "many_rungs": ("speeds.from_hz=26.2", "speeds.to_hz=42.2", "speeds.step_hz=4"),
}
NAMES = "amplitude_m", "amplitude_error_m", "localisation", "time_s", "point_status"


def test_a_speed_has_the_same_bits_alone_and_among_others(folder):
    found = {}
    (folder / "tiny.yaml").write_text(TINY)
    for name, keys in GRIDS.items():
        sets = [part for key in (*keys, "mistuning.tuned_runs=1") for part in ("--set", key)]
        assert cli.main(["tiny.yaml", "--no-figures", "--output", f"{name}.h5", *sets]) == 0
        with hpcrub.open(f"{name}.h5") as file:
            at = int(np.argmin(abs(file["speeds_hz"] - SPEED)))
            arrays = [file[f"tuned/{n}"][at] for n in NAMES]
            arrays += [file[f"samples/{n}"][..., at] for n in NAMES]
            found[name] = b"".join(np.asarray(values).tobytes() for values in arrays)
    assert found["many_rungs"] == found["alone"]
