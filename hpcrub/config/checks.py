"""Keys of a configuration that must fit each other, and a line for each that does not."""

from collections.abc import Iterator
from itertools import pairwise
from typing import Any

import numpy as np

from hpcrub.config.text import scientific_notation, show

PATTERNS = "pattern_gpa", "pattern_percent", "blade_frequencies_hz"
MAX_SPEEDS = 100_000
BESIDE = (".png", ".pdf", ".svg", ".gif", ".log", ".jsonl")  # figures and logs of a result


def problems(config: Any) -> Iterator[str]:
    """Lines that say which keys do not fit together; none when all is well."""
    yield from _disk_problems(config)
    yield from _damping_problems(config.material)
    yield from _casing_problems(config)
    yield from _run_problems(config)
    yield from _pattern_problems(config)
    yield from _part_problems(config)


def patterns(mistuning: dict[str, Any]) -> list[tuple[str, Any]]:
    """Keys of a section `mistuning`, as a dict, that give one explicit sample, and their values."""
    return [(key, mistuning[key]) for key in PATTERNS if mistuning.get(key) is not None]


def deviation_of(key: str, values: Any, modulus: float) -> np.ndarray:
    """Relative deviation of every blade's stiffness (N,) [-] that a key of `patterns` gives."""
    values = np.array(values, dtype=float)
    if key == "pattern_gpa":
        return values / modulus - 1
    if key == "pattern_percent":
        return values / 100
    return (values * len(values) / values.sum()) ** 2 - 1


def pattern_half_range(data: dict[str, Any], default_modulus: float) -> float:
    """Width of the level that holds a pattern, from an input not yet validated.

    Parameters
    ----------
    data : dict[str, Any]
        Input file as a dict, one of the `patterns` of `mistuning` given.
    default_modulus : float
        Young's modulus when the input gives none [GPa].

    Returns
    -------
    float
        Largest |E/E0 - 1| [%]; 0 when it cannot be computed or is 100 or more, which the
        validation of the keys concerned then refuses.
    """
    try:
        e0 = data.get("material", {}).get("young_modulus_gpa", default_modulus)
        key, values = patterns(data["mistuning"])[0]
        found = deviation_of(key, [scientific_notation(v) for v in values], scientific_notation(e0))
        width = float(np.abs(found).max(initial=0.0)) * 100
        return width if width < 100 else 0.0
    except (AttributeError, TypeError, ValueError, ArithmeticError):
        return 0.0


def _disk_problems(c):
    d = c.disk
    if d.model is not None:
        if c.reduction.basis == "per_sample":
            yield "reduction.basis: per_sample is for the planar disk, not for disk.model"
        if c.contact.kinematics == "polar" and d.n_directions == 3:
            yield (
                "contact.kinematics: polar is for planar disks; the disk of disk.model moves "
                "axially, too, and small is the one for it"
            )
        return
    if c.mistuning.by != "blade_stiffness":
        yield f"mistuning.by: {c.mistuning.by} needs disk.model"
    if d.hub_radius_mm >= d.tip_radius_mm:
        yield (
            f"disk.hub_radius_mm: {d.hub_radius_mm} is not below "
            f"disk.tip_radius_mm, {d.tip_radius_mm}"
        )
    if d.inner_radius_mm >= d.hub_radius_mm:
        yield (
            f"disk.inner_radius_mm: {d.inner_radius_mm} is not below "
            f"disk.hub_radius_mm, {d.hub_radius_mm}"
        )
    most = d.n_dof - 2 * d.n_blades
    if c.reduction.n_modes > most:
        yield (
            f"reduction.n_modes: {c.reduction.n_modes} is more than the {most} fixed-interface "
            "modes that this disk has"
        )


def _damping_problems(m):
    bands = m.damping_bands_hz
    if m.damping_ratios is None:
        if bands is not None or m.damping_of != "modes":
            yield f"material.damping_of: {m.damping_of} needs material.damping_ratios"
    elif m.damping_of != "bands":
        if bands is not None:
            yield f"material.damping_bands_hz: goes with damping_of: bands, not {m.damping_of}"
    elif len(bands or ()) != len(m.damping_ratios) - 1:
        yield (
            f"material.damping_bands_hz: {len(bands or ())} ends of bands given for "
            f"{len(m.damping_ratios)} damping ratios; the last band has none"
        )
    elif any(low >= high for low, high in pairwise(bands or ())):
        yield f"material.damping_bands_hz: {show(bands)} are not increasing"


def _casing_problems(c):
    angles, changes = c.casing.profile_deg, c.casing.profile_mm
    if (angles is None) != (changes is None):
        given, missing = ("deg", "mm") if changes is None else ("mm", "deg")
        yield f"casing.profile_{given}: goes with casing.profile_{missing}, which is not given"
    elif angles is not None:
        if len(angles) != len(changes):
            yield f"casing.profile_mm: {len(changes)} values for {len(angles)} angles"
        if any(a >= b for a, b in pairwise(angles)):
            yield "casing.profile_deg: the angles are not increasing"
    has_profile = c.casing.harmonics or c.casing.profile_csv or changes
    if has_profile and c.contact.kinematics == "polar":
        yield (
            "contact.kinematics: polar is for casings with bumps alone; small is the one for "
            "casing.harmonics and measured profiles"
        )


def _run_problems(c):
    if c.output.lower().endswith(BESIDE):
        yield f"output: {show(c.output)} ends as the figures and logs beside a result file do"
    s = c.speeds
    if s.to_hz < s.from_hz:
        yield f"speeds.to_hz: {s.to_hz} is below speeds.from_hz, {s.from_hz}: no speeds"
    elif s.n_values > MAX_SPEEDS:
        yield (
            f"speeds.step_hz: {s.step_hz} gives {s.n_values:,} speeds; "
            f"at most {MAX_SPEEDS:,} are allowed"
        )
    steady = c.steady_state
    if steady.max_time_s < steady.first_check_s:
        yield (
            f"steady_state.max_time_s: {steady.max_time_s} is below "
            f"steady_state.first_check_s, {steady.first_check_s}"
        )
    p = c.convergence.percentiles
    if any(low >= high for low, high in pairwise(p)):
        yield f"convergence.percentiles: {show(p)} are not increasing"


def _pattern_problems(c):
    m, given = c.mistuning, patterns(vars(c.mistuning))
    is_random = m.distribution == "uniform" and not (
        m.neighbour_correlation or m.intentional_percent
    )
    if m.patterns_file is not None and (given or not is_random):
        other = given[0][0] if given else "distribution"
        yield (
            f"mistuning.patterns_file: cannot be combined with mistuning.{other}; its disks are "
            "all samples, and nothing of them is random"
        )
    if not given:
        yield from _law_problems(c)
        return
    if m.distribution != "uniform" or m.neighbour_correlation or m.intentional_percent:
        yield f"mistuning.{given[0][0]}: one explicit sample; nothing of it is random or added"
    if len(given) > 1:
        yield f"mistuning.{given[1][0]}: mistuning.{given[0][0]} is given too; leave one out"
    key, values = given[0]
    if len(values) != c.disk.n_blades and c.disk.is_resolved:
        what = "moduli" if key == "pattern_gpa" else "values"
        yield (
            f"mistuning.{key}: {len(values)} {what} given for the "
            f"{c.disk.n_blades} blades of disk.{'model' if c.disk.model else 'n_blades'}"
        )
    largest = float(np.abs(c.pattern_deviation).max()) * 100
    if largest >= 100:
        if key == "pattern_gpa":
            text = "a modulus deviates by {:.6g} % from material.young_modulus_gpa"
        else:
            text = "the stiffness of a blade deviates by {:.6g} %"
        yield f"mistuning.{key}: {text.format(largest)}; less than 100 % is allowed"
        return
    alone = f"cannot be combined with mistuning.{key}, which is one sample; leave one out"
    if m.samples != 1:
        yield f"mistuning.samples: {m.samples} {alone}"
    if len(m.half_range_percent) != 1 or not np.isclose(m.half_range_percent[0], largest, 1e-9):
        yield f"mistuning.half_range_percent: {show(m.half_range_percent)} {alone}"


def _law_problems(c):
    m = c.mistuning
    if (m.distribution == "measured") != (m.measured_percent is not None):
        yield (
            "mistuning.measured_percent: goes with mistuning.distribution: measured, which is "
            f"{m.distribution}"
        )
    elif m.measured_percent is not None and not any(m.measured_percent):
        yield "mistuning.measured_percent: all values are 0"
    beneath = m.intentional_percent
    if beneath and c.disk.is_resolved and c.disk.n_blades % len(beneath):
        yield (
            f"mistuning.intentional_percent: {len(beneath)} values cannot be repeated around "
            f"{c.disk.n_blades} blades"
        )
    if m.largest >= 1.0:
        yield (
            f"mistuning.intentional_percent: with the half range a blade deviates by "
            f"{100 * m.largest:.4g} %; less than 100 % is allowed"
        )


def _part_problems(c):
    levels, samples = c.part.levels, c.part.samples
    if levels is None and samples is None:
        return
    key = "part.samples" if levels is None else "part.levels"
    if c.convergence.stop_when_converged:
        yield (
            f"{key}: a part cannot know when the whole study has converged; leave out "
            "convergence.stop_when_converged"
        )
    n_levels = len(c.mistuning.half_range_percent)
    if levels is not None and (levels[-1] >= n_levels or any(a >= b for a, b in pairwise(levels))):
        yield f"part.levels: {show(levels)} are not increasing numbers of levels below {n_levels}"
    if samples is not None and not samples[0] < samples[1] <= c.mistuning.samples:
        yield (
            f"part.samples: {show(samples)} is no range of the {c.mistuning.samples} of "
            "mistuning.samples"
        )
