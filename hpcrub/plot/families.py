"""Differences between files that are compared: their order, labels for a legend, the reference."""

import re
from collections import Counter
from typing import Any

import numpy as np
from matplotlib.ticker import EngFormatter

from hpcrub.config.schema import PROFILE, Config
from hpcrub.config.text import counted, is_table, key_table, show
from hpcrub.config.types import without_suffix
from hpcrub.plot.style import shades
from hpcrub.results.layout import FAILED, PENDING
from hpcrub.results.samples import n_counted
from hpcrub.results.storage import ResultFile

FINEST = {"time.step_s": min, "reduction.n_modes": max, "disk.blade.n_elements": max}
OF_ANY_SIZE = "s", "N/m", "N s/m"  # units with prefixes, such as 240 MN/m
COATING = "contact.coating."  # first part of keys that mean nothing for a file without a coating
FEW_KEYS = 3  # largest number of keys that are all named; of more keys, only unusual values are


def level_colours(files: list[ResultFile]) -> dict[float, Any]:
    """Return the colour of each mistuning level σ of files, the smallest first."""
    sigmas = np.unique(np.concatenate([file.read("sigma") for file in files]))
    return dict(zip(sigmas, shades(len(sigmas)), strict=True))


def lost_disks(files: list[ResultFile]) -> list[str]:
    """Return a note for each file whose figure leaves out disks without a result."""
    notes = []
    for file in files:
        status = file.status[:, : n_counted(file)]
        if n := int(np.count_nonzero(status == FAILED)):
            name = f"{without_suffix(file.path).name}: " * (len(files) > 1)
            of = counted(int(np.count_nonzero(status != PENDING)), "disk")
            notes.append(f"{name}{n} of {of} have no result and are left out")
    return notes


def ordered(files: list[ResultFile]) -> list[ResultFile]:
    """Sort files by their number of bumps, then by the values of the keys in which they differ."""
    rows, differing = _flat(files)
    keys = ["casing.n_bumps", *differing]
    order = sorted(range(len(files)), key=lambda i: [_rank(rows[i][key]) for key in keys])
    return [files[i] for i in order]


def reference(files: list[ResultFile]) -> ResultFile:
    """Return the file that others are compared with: the finest, else that of the default values.

    The finest time step, reduced model or mesh is nearest to the truth. If no file has the default
    values of all keys in which the files differ, the file with the most default values is taken.
    """
    rows, keys = _flat(files)
    for key, finest in FINEST.items():
        if keys == [key]:
            return files[rows.index(finest(rows, key=lambda row: row[key]))]
    usual = Config().by_path()
    return max(files, key=lambda f: sum(rows[files.index(f)][k] in (usual[k], None) for k in keys))


def labels(files: list[ResultFile]) -> list[str]:
    """Return a label for each file, such as "clearance 0.20 mm, bump height 1.25 mm"."""
    rows, keys = _flat(files)
    if "casing.n_bumps" in keys:
        return [f"$n_d$ = {row['casing.n_bumps']}" for row in rows]
    known = {*PROFILE, *(key for key in keys if any(is_table(row[key]) for row in rows))}
    words = {key: _words(key, [row[key] for row in rows]) for key in keys if key not in known}
    if not {*keys}.isdisjoint(PROFILE):
        words = {PROFILE[0]: [file.config.casing.words for file in files]} | words
    if not {*keys} & known <= {*PROFILE}:  # tables of waves or modes: the user's name of the file
        words = {"output": [without_suffix(file.path).name for file in files]} | words
    keys, usual = list(words), {}
    if len(keys) > FEW_KEYS:
        usual = {key: Counter(words[key]).most_common(1)[0][0] for key in keys}
    texts = []
    for i, file in enumerate(files):
        named = [words[key][i] for key in keys if words[key][i] not in ("", usual.get(key))]
        texts.append(", ".join(named) or ("reference" if usual else without_suffix(file.path).name))
    return texts


def _flat(files: list[ResultFile]) -> tuple[list[dict[str, Any]], list[str]]:
    """Return keys and values of every file, and the keys in which files differ.

    A file without a coating has None for keys of a coating, which is no difference. Where
    `time.step_s` differs, its value is the step that was used, or None where the contact laws
    differ, too, because their default steps do.
    """
    rows = [file.config.by_path() for file in files]
    n_steps, n_laws = (len({row[key] for row in rows}) for key in ("time.step_s", "contact.law"))
    for row, file in zip(rows, files, strict=True):
        if n_steps > 1:  # the key is only a bound of the step
            row["time.step_s"] = None if n_laws > 1 else float(file.attributes["time_step_s"])
        if not file.config.contact.wears:
            row |= dict.fromkeys(key for key in row if key.startswith(COATING))
    keys = []
    for key in rows[0]:
        values = [row[key] for row in rows if row[key] is not None or not key.startswith(COATING)]
        if key not in ("output", "sources") and any(value != values[0] for value in values):
            keys.append(key)
    return rows, keys


def _rank(value: Any) -> tuple[bool, Any, str]:
    """Return a sort key: numbers by their size, before all other values."""
    number = isinstance(value, (int, float))
    return not number, value if number else 0, show(value)


def _words(key: str, values: list[Any]) -> list[str]:
    """Return quantity, value and unit of one key for every file, all with the same decimals.

    The text is empty where a file has no value of the key.
    """
    description = next(entry.description for entry in key_table(Config) if entry.path == key)
    bracket = re.search(r"\[(.+)\]$", description)
    unit = bracket.group(1) if bracket else "-"
    slug = {"%": "percent"}.get(unit, unit.lower().replace("³", "3").replace(" ", ""))
    name = key.rpartition(".")[2].removeprefix("n_")
    for per in ("_per_", "_"):
        name = name.removesuffix("_" + slug.replace("/", per))
    name, numbers = name.replace("_", " "), _numbers([v for v in values if v is not None], unit)
    return ["" if value is None else f"{name} {numbers.pop(0)}" for value in values]


def _numbers(values: list[Any], unit: str) -> list[str]:
    if unit in OF_ANY_SIZE:
        return [EngFormatter(unit)(value) for value in values]
    ends = {"-": "", "deg": "°"}.get(unit, f" {unit}")
    texts = [show(value).strip("'").replace("_", " ") for value in values]
    if all(isinstance(value, float) for value in values) and not any("e" in t for t in texts):
        decimals = max(len(text.partition(".")[2]) for text in texts)
        texts = [f"{value:.{decimals}f}" for value in values]
    return [text + ends for text in texts]
