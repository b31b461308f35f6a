"""Checks that the keys of a configuration fit each other; each misfit gives an error line."""

from collections.abc import Iterator
from itertools import accumulate, pairwise
from operator import attrgetter
from typing import Any

import numpy as np

from hpcrub.config import aero, resolution, run_up
from hpcrub.config.text import counted, flatten, lines_of, show

MAX_SPEEDS = 100_000
MOST_STEPS = 1_000_000  # most time steps of a revolution
LARGEST_DAMPING = 0.1  # ratio that blades may have, air and dampers included
ALIKE = 1.1  # frequency ratio below which casing modes of equal wave numbers are one pair
FIGURES_AND_LOGS = ".png", ".pdf", ".svg", ".gif", ".log", ".jsonl"  # beside a result file
# Keys that must not be above others, and keys that must be below others.
NOT_ABOVE = {
    "speeds.from_hz": "speeds.to_hz",
    "steady_state.first_check_s": "steady_state.max_time_s",
}
BELOW = {"threshold.lowest": "threshold.highest"}
BELOW_IN_A_PLANAR_DISK = {
    "disk.hub_radius_mm": "disk.tip_radius_mm",
    "disk.inner_radius_mm": "disk.hub_radius_mm",
}
# What keys go with: a key, one of several, a key with one of some values, or "no" key; and those
# keys, or keys of whole sections, which are meant where they are not the default, or one value.
GOES_WITH = {
    "disk.model": ("disk.model_sha256", "disk.n_blades: 1", "mistuning.by"),
    "disk.model_sha256": (
        *("disk.n_contact_nodes", "disk.n_directions", "disk.n_strips", "disk.n_stresses"),
        *("disk.static_mpa", "disk.first_family_hz", "disk.least_clearance_mm"),
        "disk.second_order_per_m",
    ),
    "material.damping_ratios": ("material.damping_of",),
    "material.damping_of: bands": ("material.damping_bands_hz",),
    "casing.profile_mm": ("casing.profile_deg",),
    "casing.profile_deg": ("casing.profile_mm",),
    "casing.ring.thickness_mm": ("casing.ring",),
    "no casing.ring.thickness_mm": ("casing.modes", "casing.modes_csv"),
    "no aero.influence": ("aero.waves", "aero.waves_csv"),
    "contact.law: abradable": ("contact.coating",),
    "contact.law: elastic or abradable": ("contact.casing_stiffness_n_per_m",),
    "contact.law: rigid": ("contact.own_law",),
    "contact.own_law": ("contact.own_law_sha256",),
    "contact.casing_stiffness_n_per_m": ("contact.law: elastic", "contact.casing_damping_ns_per_m"),
    "mistuning.measured_percent": ("mistuning.distribution: measured",),
    "mistuning.distribution: measured": ("mistuning.measured_percent",),
    "no mistuning.pattern": (
        *("mistuning.distribution", "mistuning.neighbour_correlation"),
        "mistuning.intentional_percent",
    ),
    "limits.stress_mpa": ("limits.static_mpa", "limits.strength_mpa"),
    "no run_up.speed_s_hz": (
        *("run_up.from_hz", "run_up.to_hz", "run_up.hz_per_s", "run_up.hold_s", "run_up.passes"),
    ),
    "no casing.clearance_hz_mm": ("casing.clearance_s_mm",),
    # waves are met where tips rest, and a law of one's own has its forces along directions at rest
    "no casing.ring.thickness_mm or casing.modes or casing.modes_csv or contact.own_law": (
        "contact.kinematics: second_order",
    ),
    # what blades cut at one speed would stay cut at all that follow
    "contact.law: rigid or elastic": ("study: branches",),
    "no convergence.stop_when_converged": ("part",),  # of the whole study, which a part cannot see
}
# The same of keys that are not refused, but have no effect without it.
USELESS_WITHOUT = {
    "study: energy or run_up": ("sources",),
    "study: rare": ("limits.probability_error", "limits.probability_below"),
    "study: contact or run_up or threshold or rare": ("limits.amplitude_mm",),
    "study: contact or run_up or threshold or rare or checklist or energy or time_response": (
        "limits.stress_mpa",
    ),
    "study: contact": ("convergence.stop_when_converged",),
    "limits.stress_mpa": ("limits.stress_mpa_per_mm",),
    "no casing.clearance_hz_mm or casing.clearance_s_mm": ("casing.clearance_mm",),
    "study: run_up or threshold or rare or checklist": ("run_up",),
    "casing.profile_csv or casing.profile_mm": ("casing.smoothing_mm",),
    "no material.damping_ratios": ("material.damping_ratio",),
    "steady_state.rule: ensemble": ("steady_state.max_error",),
    "steady_state.rule: last_window": (
        *("steady_state.extend_revolutions", "steady_state.confirmations"),
    ),
    "mistuning.distribution: normal": ("mistuning.truncation",),
    "mistuning.pattern": ("mistuning.pattern_unit",),
}


def problems(config: Any) -> Iterator[str]:
    """Yield error lines about keys that do not fit together."""
    if lines := [*_order_problems(config)]:  # without speeds nothing else can be said
        yield from lines
        return
    yield from (f"{key}: {show(value)} {why}" for key, value, why in _misfits(config, GOES_WITH))
    yield from _disk_problems(config)
    of_casing = [*_casing_problems(config)]
    yield from of_casing or _steep_problems(config)
    yield from _ring_problems(config.casing)
    if config.disk.is_resolved:
        yield from aero.problems(config.aero, config.disk.n_blades)
    yield from (*_contact_problems(config), *_limit_problems(config), *_run_problems(config))
    yield from _pattern_problems(config)
    yield from run_up.problems(config)


def keys_without_effect(config: Any) -> Iterator[str]:
    """Yield lines about keys that an input gives and that other keys leave without effect."""
    for key, value, why in _misfits(config, USELESS_WITHOUT):
        yield f"{key}: {show(value)} has no effect: it {why}"


def doubtful(c: Any) -> Iterator[str]:
    """Yield lines about numbers that no rotor has and that wrong units give."""
    m = c.material
    for key, ratios in (
        ("material.damping_ratio", m.damping_ratios or (m.damping_ratio,)),
        ("aero.waves", [wave.damping_ratio for wave in c.aero.waves]),
        ("aero.influence", [part.damping_ratio for part in c.aero.influence]),
    ):
        if (ratio := max(map(abs, ratios), default=0.0)) > LARGEST_DAMPING:
            yield (
                f"units: {key}: {ratio:g} is {100 * ratio:.4g} % of critical damping, blades have "
                f"0.01 to {100 * LARGEST_DAMPING:g} %; damping is a ratio here, no percentage"
            )


@np.errstate(all="ignore")  # `pattern_problem` refuses a sum of zero or infinity
def deviation_of(values: Any, unit: str, modulus: float) -> np.ndarray:
    """Relative stiffness deviations (N,) [-] from the values of a pattern in its unit."""
    values = np.array(values, dtype=float)
    if unit == "gpa":
        return values / modulus - 1
    if unit == "percent":
        return values / 100
    return (values * len(values) / values.sum()) ** 2 - 1


def pattern_problem(values: Any, deviation: np.ndarray, unit: str) -> str:
    """Error line about the values and deviations [-] of patterns; "" without an error."""
    largest = 100.0 * float(np.abs(deviation).max())
    lines = lines_of(
        (unit != "percent" and np.min(values) <= 0.0, f"values above 0 are expected in {unit}"),
        (unit == "hz" and np.shape(values)[-1] == 1,
         "the frequency of one blade deviates from no mean; give its stiffness in percent"),
        (not largest < 100.0,
         f"the stiffness of a blade deviates by {largest:.6g} % (mistuning.pattern_unit: {unit}); "
         "less than 100 % is allowed"),
    )  # fmt: skip
    return next(lines, "")


def _misfits(config: Any, table: Any) -> Iterator[Any]:
    """Yield (key, its value, why) of keys that lack what they go with, by a table above."""
    changed = flatten(config.model_dump(mode="json", exclude_defaults=True))
    for other, keys in table.items():
        if not (why := _missing(config, other)):
            continue
        for key, value in changed.items():
            parts = accumulate(key.split("."), "{}.{}".format)
            if not {f"{key}: {value}", *parts}.isdisjoint(keys):
                yield key, value, why


def _missing(config: Any, other: Any) -> str:
    """What an input lacks of the first part of a row in a table above, in words; "" for nothing."""
    names, _, values = other.partition(": ")
    keys = names.removeprefix("no ").split(" or ")
    given = [key for key in keys if attrgetter(key)(config)]
    if values:
        value = attrgetter(names)(config)
        return "" if value in values.split(" or ") else f"goes with {other}, not {value}"
    if names.startswith("no "):
        return f"cannot be combined with {given[0]}; leave one out" if given else ""
    return "" if given else f"goes with {names}, which is not given"


def _order_problems(c: Any) -> Iterator[str]:
    """Error lines about keys that are not below others, and about too many speeds."""
    below = BELOW | (BELOW_IN_A_PLANAR_DISK if c.disk.model is None else {})
    for table, words in ((NOT_ABOVE, "above"), (below, "not below")):
        for key, other in table.items():
            low, high = attrgetter(key, other)(c)
            if low > high or (low == high and table is below):
                yield f"{key}: {low} is {words} {other}, {high}"
    if c.speeds.n_values > MAX_SPEEDS:
        yield (
            f"speeds.step_hz: {c.speeds.step_hz} gives {c.speeds.n_values:,} speeds; at most "
            f"{MAX_SPEEDS:,} are allowed"
        )


def _disk_problems(c: Any) -> Iterator[str]:
    m, most = c.material, c.disk.n_dof - 2 * c.disk.n_blades
    bands, ratios = m.damping_bands_hz or (), m.damping_ratios or ()
    yield from lines_of(
        (c.disk.model is None and c.reduction.n_modes > most,
         f"reduction.n_modes: {c.reduction.n_modes} is more than the {most} fixed-interface modes "
         "that this disk has"),
        (ratios and m.damping_of == "bands" and len(bands) != len(ratios) - 1,
         f"material.damping_bands_hz: {len(bands)} ends of bands given for {len(ratios)} damping "
         "ratios; the last band has none"),
    )  # fmt: skip


def _casing_problems(c: Any) -> Iterator[str]:
    casing, low, high = c.casing, c.speeds.from_hz, c.speeds.to_hz
    angles, changes = casing.profile_deg, casing.profile_mm
    if angles and changes and len(angles) != len(changes):
        yield f"casing.profile_mm: {len(changes)} values for {len(angles)} angles"
    if isinstance(casing.clearance_hz_mm, tuple):
        yield from run_up.short_curve(
            "casing.clearance_hz_mm", casing.clearance_hz_mm, low, high,
            f"Hz say nothing of all speeds from {low:g} to {high:g} Hz",
        )  # fmt: skip
    blades, is_known = casing.blade_clearance_mm, casing.is_resolved
    if blades and c.disk.is_resolved and len(blades) != c.disk.n_blades:
        yield (
            f"casing.blade_clearance_mm: {len(blades)} values given for the "
            f"{counted(c.disk.n_blades, 'blade')} of the disk"
        )
    if is_known and (least := 1e3 * c.clearance) + min(0.0, *(blades or (0.0,))) < 0.0:
        own = f", and {min(blades):g} mm of casing.blade_clearance_mm" if blades else ""
        yield (
            f"casing: a clearance of {least:g} mm, casing.clearance_offset_mm included{own}, "
            "leaves less than none"
        )


def _steep_problems(c: Any) -> Iterator[str]:
    if c.casing.is_resolved and (steps := resolution.least_steps(c)) > MOST_STEPS:
        yield (
            f"casing: its narrowest crest needs {steps:,.0f} time steps a turn, more than "
            f"{MOST_STEPS:,}; widen its bumps (casing.bump_width), lengthen casing.smoothing_mm "
            "or lower time.steps_per_bump_width"
        )


def _ring_problems(casing: Any) -> Iterator[Any]:
    if casing.vibrates and casing.growth_time_s == 0.0:
        yield (
            "casing.growth_time_s: 0 starts with bumps that overlap the tips, and a casing that "
            "vibrates is thrown away by a force that grows as the step shrinks; give a time > 0"
        )
    modes = sorted(casing.modes, key=lambda mode: (mode.waves, mode.frequency_hz))
    for one, other in pairwise(modes):
        alike = other.frequency_hz <= ALIKE * one.frequency_hz
        if one.waves == other.waves and alike:
            yield (
                f"casing.modes: n = {one.waves} at {one.frequency_hz:g} and "
                f"{other.frequency_hz:g} Hz; cos nθ and sin nθ are one pair of one frequency, "
                "given once; a casing whose pairs differ is not in the model"
            )


def _contact_problems(c: Any) -> Iterator[Any]:
    coating = c.contact.coating
    if not c.contact.wears:
        return
    yield from lines_of(
        (coating.yield_stress >= coating.young,
         f"contact.coating.yield_mpa: {coating.yield_mpa:g} is not below contact.coating."
         f"young_gpa, {coating.young_gpa:g}: such a coating is pressed flat before it wears"),
        (c.disk.model is not None and coating.tip_area_mm2 is None,
         "contact.coating.tip_area_mm2: a model file does not say how large the tip of a blade is; "
         "give its area"),
    )  # fmt: skip


def _limit_problems(c: Any) -> Iterator[str]:
    limits, disk = c.limits, c.disk
    known = disk.model is None or not disk.is_resolved or disk.n_stresses
    if limits.stress_mpa and not known and limits.stress_mpa_per_mm is None:
        yield (
            "limits.stress_mpa: this model file has no stress; import it with --stress, or give "
            "limits.stress_mpa_per_mm of its first family, or limits.amplitude_mm"
        )
    static, strength = limits.static_mpa, limits.strength_mpa
    if static is None and strength is None:
        return
    of_file = disk.model is not None and (not disk.is_resolved or disk.static_mpa is not None)
    if strength is None or (static is None and not of_file):
        yield (
            "limits.static_mpa, limits.strength_mpa: Goodman's line needs both, or strength_mpa "
            "and a model file with the stress of rotation (stress_static)"
        )
    elif static is not None and disk.static_mpa is not None:
        yield "limits.static_mpa: the model file knows the stress of rotation; leave it out"
    elif max(static or 0.0, disk.static_mpa or 0.0) >= strength:
        of = "limits.static_mpa" if static else "the stress of rotation in the model file"
        yield (
            f"limits.strength_mpa: {strength:g} is not above {of}, {static or disk.static_mpa:g}: "
            "nothing is left for a vibration"
        )


def _run_problems(c: Any) -> Iterator[Any]:
    types, waves = c.patterns.types_percent, c.casing.ring.waves
    yield from lines_of(
        (c.output.lower().endswith(FIGURES_AND_LOGS),
         f"output: {show(c.output)} ends as the figures and logs beside a result file do"),
        (len(set(types)) < len(types),
         f"patterns.types_percent: {show(types)} are not different types"),
        (len(set(waves)) < len(waves), f"casing.ring.waves: {show(waves)} are not different"),
        (c.study == "rare" and c.mistuning.half_range_percent[0] == 0.0,
         "mistuning.half_range_percent: of 0 makes all disks of a rare study alike"),
        (not c.samples.start < c.samples.stop <= c.mistuning.samples,
         f"part.samples: {show(c.part.samples)} is no range of the {c.mistuning.samples} of "
         "mistuning.samples"),
    )  # fmt: skip


def _pattern_problems(c: Any) -> Iterator[Any]:
    m = c.mistuning
    if m.pattern is None:
        yield from _law_problems(c)
        return
    if m.pattern_file is not None:
        return  # its contents are checked when it is read
    if len(m.pattern) != c.disk.n_blades and c.disk.is_resolved:
        yield (
            f"mistuning.pattern: {len(m.pattern)} values given for the "
            f"{counted(c.disk.n_blades, 'blade')} of disk.{'model' if c.disk.model else 'n_blades'}"
        )
    if problem := pattern_problem(m.pattern, c.pattern_deviation, m.pattern_unit):
        yield f"mistuning.pattern: {problem}"
        return
    largest = 100.0 * float(np.abs(c.pattern_deviation).max())
    alone = "cannot be combined with mistuning.pattern, which is one sample; leave one out"
    if len(m.half_range_percent) != 1 or not np.isclose(m.half_range_percent[0], largest, 1e-9):
        yield f"mistuning.half_range_percent: {show(m.half_range_percent)} {alone}"


def _law_problems(c: Any) -> Iterator[Any]:
    m = c.mistuning
    measured, beneath = m.measured_percent, m.intentional_percent or ()
    yield from lines_of(
        (measured is not None and not any(measured),
         "mistuning.measured_percent: all values are 0"),
        (beneath and c.disk.is_resolved and c.disk.n_blades % len(beneath),
         f"mistuning.intentional_percent: {len(beneath)} values cannot be repeated around "
         f"{counted(c.disk.n_blades, 'blade')}"),
        (m.largest >= 1.0,
         f"mistuning.intentional_percent: with the half range a blade deviates by "
         f"{100 * m.largest:.4g} %; less than 100 % is allowed"),
    )  # fmt: skip
