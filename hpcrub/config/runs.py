"""Expansion of an input with `runs` into the inputs of several runs, one result file each.

    runs:
      - {casing.clearance_mm: 0.20}
      - {casing.clearance_mm: 0.25, casing.n_bumps: 3}

Every entry replaces keys of the input, by their whole path, for one run. The result files lie in a
folder named after the input's output; each file is named after the keys that its run replaces.
"""

import copy
from typing import Any

from hpcrub.config.text import flatten, set_key, show
from hpcrub.config.types import without_suffix
from hpcrub.errors import InputError

MOST = 1000  # most runs of an input


def expand(data: dict[str, Any], names_output: bool = False) -> list[dict[str, Any]]:
    """Inputs of all runs, from an input that is not validated yet and has an `output`.

    names_output: whether the command line has named the output, which a run may not do as well.
    Raises InputError when `runs` is not a list of mappings, or names an output a second time.
    """
    data = dict(data)
    if "runs" not in data:
        return [data]
    entries = data.pop("runs")
    if not isinstance(entries, list) or not 1 <= len(entries) <= MOST:
        raise InputError(f"runs: {show(entries)} is not a list of 1 to {MOST} runs")
    return [_run(data, entry, names_output) for entry in entries]


def _run(data, entry, names_output):
    if not isinstance(entry, dict) or not entry:
        raise InputError(f"runs: {show(entry)} does not replace keys, as {{key.path: value}}")
    run = copy.deepcopy(data)
    replaced = flatten(entry)
    if "output" not in replaced:
        label = "_".join(f"{key.rpartition('.')[2]}={_short(v)}" for key, v in replaced.items())
        run["output"] = str(without_suffix(str(data["output"])) / f"{label[:200]}.h5")
    elif names_output:
        raise InputError(
            f"output: {show(data['output'])} would not reach the runs that name their own "
            f"({show(replaced['output'])}); give these runs no output in the input, or the command "
            "no --output"
        )
    for path, value in replaced.items():
        set_key(run, path, value)
    return run


def _short(value):
    return show(value).strip("'").replace("/", "-").replace(" ", "")
