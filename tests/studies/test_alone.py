"""Results at a speed do not depend on the other speeds of a study, nor on the number of ranks."""

import os
import subprocess

import numpy as np

import hpcrub
from evidence.program import ENVIRONMENT, ROOT, TINY, command

SPEED = 34.2
GRIDS = {  # ranks, keys
    "alone": (0, ("speeds.from_hz=34.2", "speeds.to_hz=34.2")),
    "many_rungs": (0, ("speeds.from_hz=26.2", "speeds.to_hz=42.2", "speeds.step_hz=4")),
}
NAMES = "amplitude_m", "amplitude_error_m", "localisation", "time_s", "point_status"


def test_a_speed_has_the_same_bits_alone_and_among_others(tmp_path):
    found = {}
    (tmp_path / "tiny.yaml").write_text(TINY)
    for name in GRIDS:
        ranks, keys = GRIDS[name]
        sets = [part for key in (*keys, "mistuning.tuned_runs=1") for part in ("--set", key)]
        output = tmp_path / f"{name}.h5"
        arguments = ["tiny.yaml", "--no-figures", "--output", output, *sets]
        line = command(ranks, ROOT / "main.py", *arguments)
        subprocess.run(
            line, cwd=tmp_path, env=os.environ | ENVIRONMENT, check=True, capture_output=True
        )
        with hpcrub.open(output) as file:
            at = int(np.argmin(abs(file["speeds_hz"] - SPEED)))
            arrays = [file[f"tuned/{n}"][at] for n in NAMES]
            arrays += [file[f"samples/{n}"][..., at] for n in NAMES]
            found[name] = b"".join(np.asarray(values).tobytes() for values in arrays)
    assert found["many_rungs"] == found["alone"]
