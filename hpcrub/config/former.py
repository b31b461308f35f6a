"""Keys that earlier versions had: what to write now."""

from typing import Any, NamedTuple


class Former(NamedTuple):
    """A key that is gone."""

    usual: Any  # its default, which files hold and which says nothing
    now: str  # what whoever gave another value can do


# of the mistuning: keys of one explicit disk or a file of many, and the unit of what they hold
PATTERNS = {
    "pattern_gpa": "gpa",
    "pattern_percent": "percent",
    "blade_frequencies_hz": "hz",
    "patterns_file": "percent",
}
FORMER = {
    "contact.kinematics": Former(
        "small",
        "contact of displaced tips is gone: it was half of the second order (docs/theory.md); "
        "leave the key out",
    ),
    "sweep": Former(None, "called runs now"),
    "reduction.basis": Former(
        "tuned",
        "a basis of each sample's own is gone: it changed results by 2e-5; leave the key out",
    ),
    "speeds.search": Former(
        "full", "the search for the peak is gone: it could miss a narrow one; leave the key out"
    ),
    "part.levels": Former(None, "a part holds all levels now; cut the samples with --part K/N"),
    "mistuning.patterns_unit": Former("percent", "now mistuning.pattern_unit"),
    "mistuning.patterns_sha256": Former(None, "now mistuning.pattern_sha256"),
} | {
    f"mistuning.{key}": Former(None, f"now mistuning.pattern with mistuning.pattern_unit: {unit}")
    for key, unit in PATTERNS.items()
}

# studies of hpcrub 0.1 that only drew what result files or the input hold
FIGURES = {
    "casing": "a figure of any result file or input",
    "cross": "a figure of a contact study",
    "damping": "a figure of contact studies that differ in their damping",
}


def without_former(data: dict[str, Any]) -> dict[str, Any]:
    """An input, or the configuration of an old file, without keys that are gone.

    Raises ValueError for one that was given a value of its own, and for a study that is gone.
    """
    study = data.get("study")
    if isinstance(study, str) and study in FIGURES:
        raise ValueError(
            f"study: {study} is {FIGURES[study]} now: hpcrub plot --figure {study} FILE.h5"
        )
    for key, former in FORMER.items():
        section, _, name = key.rpartition(".")
        values = data.get(section) if section else data
        if isinstance(values, dict) and name in values:
            if values[name] != former.usual:
                raise ValueError(f"{key}: {former.now}")
            kept = {k: v for k, v in values.items() if k != name}
            data = data | {section: kept} if section else kept
    return data


def translated(data: dict[str, Any]) -> dict[str, Any]:
    """The configuration of an older file, in whose words patterns had other keys.

    Before there were rules of the steady state, all were computed by the paper's.
    """
    data = data | {"steady_state": {"rule": "last_window"} | (data.get("steady_state") or {})}
    mistuning = dict(data.get("mistuning") or {})
    unit, checksum = mistuning.pop("patterns_unit", None), mistuning.pop("patterns_sha256", None)
    for key, usual in PATTERNS.items():
        pattern = mistuning.pop(key, None)
        if pattern is not None:
            is_file = key == "patterns_file"
            mistuning |= {"pattern": pattern, "pattern_unit": unit if is_file else usual}
            mistuning |= {"pattern_sha256": checksum} if is_file else {}
    return data | {"mistuning": mistuning}
