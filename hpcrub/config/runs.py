"""Expansion of an input with `runs` into the inputs of several runs, one result file each.

    runs:
      - {casing.clearance_mm: 0.20}
      - {casing.clearance_mm: 0.25, casing.n_bumps: 3}

Every entry replaces keys of the input, by their whole path, for one run. The result files lie in a
folder named after the input's output; each file is named after the keys that its run replaces.
"""

import copy
from collections.abc import Sequence
from typing import Any

from hpcrub.config.text import flatten, set_key, show
from hpcrub.config.types import without_suffix
from hpcrub.errors import InputError

MOST_RUNS = 1000  # of an input


def expand(data: dict[str, Any], given: Sequence[str] = ()) -> list[dict[str, Any]]:
    """Inputs of all runs, from an input that is not validated yet and has an `output`.

    given: keys that the command line has set. No run may replace an output among them, which it
        would write in spite of it; some run must keep every other of them.
    Raises InputError when `runs` is not a list of mappings, or replaces a given key so.
    """
    data = dict(data)
    if "runs" not in data:
        return [data]
    entries = data.pop("runs")
    if not isinstance(entries, list) or not 1 <= len(entries) <= MOST_RUNS:
        raise InputError(f"runs: {show(entries)} is not a list of 1 to {MOST_RUNS} runs")
    for entry in entries:
        if not isinstance(entry, dict) or not entry:
            raise InputError(f"runs: {show(entry)} does not replace keys, as {{key.path: value}}")
    replaced = [flatten(entry) for entry in entries]
    for key in given:
        n_lost = sum(key in values for values in replaced)
        if n_lost == len(replaced) or (n_lost and key == "output"):
            value = show(flatten(data).get(key))
            raise InputError(
                f"{key}: {n_lost} of {len(replaced)} runs of the input replace {value} of the "
                "command line; leave one of the two out"
            )
    return [_run(data, values) for values in replaced]


def _run(data: Any, replaced: Any) -> Any:
    run = copy.deepcopy(data)
    if "output" not in replaced:
        label = "_".join(f"{key.rpartition('.')[2]}={_short(v)}" for key, v in replaced.items())
        run["output"] = str(without_suffix(str(data["output"])) / f"{label[:200]}.h5")
    for path, value in replaced.items():
        set_key(run, path, value)
    return run


def _short(value: Any) -> Any:
    return show(value).strip("'").replace("/", "-").replace(" ", "")
