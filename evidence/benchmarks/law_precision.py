"""Step against error of the blisk, and where the casing gives or is worn: amplitude, worn depth.

A sweep of some disks before a casing that gives or wears is cut short, while blades still cut: then
nearly all points are the same after a change as small as rounding, and what a step does to them can
be told from chance.
"""

import time

import numpy as np

from evidence.page import table
from hpcrub.config.schema import Config, load_runs
from hpcrub.response.sweep import run_sweep
from hpcrub.setup.disks import modes_of
from hpcrub.setup.imported import resolved
from hpcrub.setup.problem import build_problem

FINE = 8e-6, 4e-6, 2e-6, 1e-6  # [s], the last is the reference
PLANAR, SOLID = (3.3e-5, 1.6e-5, *FINE), (1.6e-5, 1.2e-5, *FINE)  # and the default
SAMPLES = 3  # the first is tuned, the others mistuned by HALF_RANGE
HALF_RANGE = 0.02
NUDGE = 1e-12  # relative change of the blades' stiffness, as small as rounding
SAME = 1e-4  # values that a nudge changes by less do not depend on rounding
WORDS = f"""The tuned disk and {SAMPLES - 1} with ±{100 * HALF_RANGE:g} %; errors against the finest
step, at points that blades stiffer by {NUDGE:g} leave as they are. The default is the step of an
input that sets none. Where the casing gives or wears, sweeps are cut short, while blades still cut.
Where errors do not fall with the second power of the step, the motion is chaotic, or jumps, and any
change, that of the step too, leads to another draw of it."""
# kind and law: input, which of its runs, other keys, speeds [Hz], simulated time [s], steps [s]
AROUND = np.arange(207.0, 221.1, 2.0)
CASES = {
    ("three-dimensional", "rigid"): (
        "blisk/contact", 0, {}, AROUND[:-1], None, SOLID,
    ),
    ("planar", "elastic"): ("coating", 1, {}, np.arange(33.5, 35.6, 0.2), 0.5, PLANAR),
    ("planar", "abradable"): ("coating", 2, {}, np.arange(33.5, 35.6, 0.2), 0.5, PLANAR),
    ("three-dimensional", "elastic"): (
        "blisk/contact", 0, {"contact.law": "elastic", "contact.casing_stiffness_n_per_m": 2e7},
        AROUND, 0.2, SOLID,
    ),
    ("three-dimensional", "abradable"): ("blisk/coating", 1, {}, AROUND, 0.1, SOLID),
}  # fmt: skip
MORE = {  # columns of a law beside the errors of the amplitude
    "rigid": ["median error of the peak, %"],
    "elastic": [],
    "abradable": ["worn depth: median error, %", "largest, %"],
}


def measure(name, number, keys, speeds, duration, steps):
    """Default step, {step: (seconds a sample, values)} and same of a case.

    values: (SAMPLES, S, 1 or 2) amplitudes and worn depths [m]; same: (SAMPLES, S) bool, points
    that do not depend on rounding.
    """
    given = load_runs(f"inputs/{name}.yaml")[number].model_dump(mode="json", exclude_unset=True)
    given.pop("time", None)
    if duration:
        keys = {"steady_state.first_check_s": duration, "steady_state.max_time_s": duration} | keys
    config = resolved(Config(**given).replace(keys))
    problem = build_problem(config)
    default = min(problem.scene.step, 1.0 / (float(speeds.mean()) * problem.scene.least_steps))
    rng = np.random.default_rng(3)
    deviations = HALF_RANGE * rng.uniform(-1.0, 1.0, (SAMPLES, config.disk.n_blades))
    deviations[0] = 0.0

    def values(step, nudge=0.0):
        scene = problem.scene._replace(step=step, least_steps=0.0)
        start = time.process_time()
        found = [run_sweep(modes_of(config, problem, deviation + nudge), scene, speeds)
                 for deviation in deviations]  # fmt: skip
        seconds = (time.process_time() - start) / SAMPLES
        if scene.coating:
            worn = [np.transpose([r.wear.amplitude, r.wear.depth]) for r in found]
            return seconds, np.array(worn)
        return seconds, np.array([r.amplitude[:, None] for r in found])

    values(steps[0])  # compile
    found = {step: values(step) for step in sorted({*steps, default}, reverse=True)}
    fine = sorted(found)[1]
    change = np.abs(values(fine, NUDGE)[1] / found[fine][1] - 1.0)
    return default, found, np.nan_to_num(change).max(axis=2) < SAME


def errors(law, found, same):
    """{step: errors in the order of the table's columns}, where points do not depend on rounding.

    Median and largest of every value against the finest step; of a rigid casing, too, the median of
    the samples' peaks. Points that are at rest, or not worn, have no error.
    """
    exact, out = found[min(found)][1], {}
    for step, (_, values) in found.items():
        with np.errstate(invalid="ignore", divide="ignore"):
            off = np.abs(values[same] / exact[same] - 1.0)
        out[step] = np.transpose([np.nanmedian(off, axis=0), np.nanmax(off, axis=0)]).ravel()
        if law == "rigid":
            peaks = np.nanmax(values, axis=1) / np.nanmax(exact, axis=1)
            out[step] = np.append(out[step], np.median(np.abs(peaks - 1.0)))
    return out


def section():
    """Parts of the page: a table for each case."""
    parts = ["## Run time against error: the blisk, and a casing that gives or wears", WORDS]
    for (kind, law), case in CASES.items():
        default, found, same = measure(*case)
        head = ["step", "s/sample", "amplitude: median error, %", "largest, %", *MORE[law]]
        rows = [
            (f"{1e6 * step:.3g} µs" + (" (default)" if step == default else ""),
             f"{found[step][0]:.2f}", *(f"{100 * number:.2f}" for number in off))
            for step, off in errors(law, found, same).items()
        ]  # fmt: skip
        parts.append(
            f"{kind.capitalize()}, {law}; {np.sum(same)} of {same.size} points do not depend on "
            f"rounding:\n\n{table(head, rows)}"
        )
    return {"errors": "\n\n".join(parts)}
