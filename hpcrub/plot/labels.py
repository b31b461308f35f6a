"""What tells the files of a family from each other: their order, and words for a legend."""

import re
from collections import Counter

from matplotlib.ticker import EngFormatter

from hpcrub.config.schema import key_table
from hpcrub.config.text import flatten, show
from hpcrub.config.types import without_suffix

SYMBOLS = {"time.step_s": "h", "reduction.n_modes": "η", "material.damping_ratio": "ξ"}
FEW = 3  # keys that are all named; with more, only those with an unusual value


def ordered(files):
    """Files by number of bumps, then by the values of the keys in which they differ."""
    rows = _flat(files)
    keys = ["casing.n_bumps", *_differing(rows)]
    order = sorted(range(len(files)), key=lambda i: [_rank(rows[i][key]) for key in keys])
    return [files[i] for i in order]


def labels(files):
    """A label for each file, such as "clearance 0.20 mm, bump height 1.25 mm"."""
    rows = _flat(files)
    keys = _differing(rows)
    if "casing.n_bumps" in keys:
        return [f"$n_d$ = {row['casing.n_bumps']}" for row in rows]
    words = {key: _words(key, [row[key] for row in rows]) for key in keys}
    usual = {}
    if len(keys) > FEW:
        usual = {key: Counter(words[key]).most_common(1)[0][0] for key in keys}
    found = []
    for i, file in enumerate(files):
        named = [words[key][i] for key in keys if words[key][i] != usual.get(key)]
        found.append(", ".join(named) or ("reference" if keys else without_suffix(file.path).name))
    return found


def _flat(files):
    return [flatten(file.config.model_dump(mode="json")) for file in files]


def _differing(rows):
    return [
        key
        for key in rows[0]
        if key not in ("output", "sources") and any(row[key] != rows[0][key] for row in rows)
    ]


def _rank(value):
    """Numbers by their size, before all other values."""
    number = isinstance(value, (int, float))
    return not number, value if number else 0, show(value)


def _words(key, values):
    """Quantity, value and unit of one key in every file, all with the same decimals."""
    description = next(entry.description for entry in key_table() if entry.path == key)
    bracket = re.search(r"\[(.+)\]$", description)
    unit = bracket.group(1) if bracket else "-"
    slug = {"%": "percent"}.get(unit, unit.lower().replace("/", "_").replace("³", "3"))
    name = key.rpartition(".")[2].removesuffix(f"_{slug}").removeprefix("n_").replace("_", " ")
    name = f"{SYMBOLS[key]} =" if key in SYMBOLS else name
    return [f"{name} {number}" for number in _numbers(values, unit)]


def _numbers(values, unit):
    if unit == "s":
        return [EngFormatter("s")(value) for value in values]
    ends = {"-": "", "deg": "°"}.get(unit, f" {unit}")
    texts = [show(value).strip("'").replace("_", " ") for value in values]
    if all(isinstance(value, float) for value in values) and not any("e" in t for t in texts):
        decimals = max(len(text.partition(".")[2]) for text in texts)
        texts = [f"{value:.{decimals}f}" for value in values]
    return [text + ends for text in texts]
