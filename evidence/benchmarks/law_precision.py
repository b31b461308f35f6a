"""Step against error where the casing gives or is worn: of the amplitude, and of the worn depth.

A sweep of some disks is cut short, while blades still cut: then nearly all points are the same
after a change as small as rounding, and what a step does to them can be told from chance.
"""

import time

import numpy as np

from evidence.page import table
from hpcrub.config.schema import Config, load_runs
from hpcrub.response.sweep import run_sweep
from hpcrub.setup.disks import modes_of
from hpcrub.setup.imported import resolved
from hpcrub.setup.problem import build_problem

FACTORS = (4.0, 2.0, 1.0, 0.5, 0.25, 0.125)  # of the default step; the last is the reference
SAMPLES = 3  # the first is tuned, the others mistuned by HALF_RANGE
HALF_RANGE = 0.02
NUDGE = 1e-12  # relative change of the blades' stiffness, as small as rounding
SAME = 1e-4  # values that a nudge changes by less do not depend on rounding
WORDS = f"""The tuned disk and {SAMPLES - 1} with ±{100 * HALF_RANGE:g} % in sweeps that are cut
short, while blades still cut; errors against the finest step, at points that blades stiffer by
{NUDGE:g} leave as they are. The default is the step of an input that sets none. Force and wear are
those of the end of a step, so that errors fall with its first power; where they stop falling, the
motion is chaotic and any change, that of the step too, leads to another draw of it."""
# kind and law: input, which of its runs, other keys, speeds [Hz], simulated time [s]
CASES = {
    ("planar", "elastic"): ("coating", 1, {}, np.arange(33.5, 35.6, 0.2), 0.5),
    ("planar", "abradable"): ("coating", 2, {}, np.arange(33.5, 35.6, 0.2), 0.5),
    ("three-dimensional", "elastic"): (
        "blisk/contact", 0, {"contact.law": "elastic", "contact.casing_stiffness_n_per_m": 2e7},
        np.arange(207.0, 221.1, 2.0), 0.2,
    ),
    ("three-dimensional", "abradable"): (
        "blisk/coating", 1, {}, np.arange(207.0, 221.1, 2.0), 0.1,
    ),
}  # fmt: skip


def measure():
    """{kind and law: (default step, {step: (seconds a sample, values)}, same)}.

    values: (SAMPLES, S, 1 or 2) amplitudes and worn depths [m]; same: (SAMPLES, S) bool, points
    that do not depend on rounding.
    """
    return {case: _measure(*how) for case, how in CASES.items()}


def _measure(name, number, keys, speeds, duration):
    given = load_runs(f"inputs/{name}.yaml")[number].model_dump(mode="json", exclude_unset=True)
    given.pop("time", None)
    steady = {"steady_state.first_check_s": duration, "steady_state.max_time_s": duration}
    config = resolved(Config(**given).replace(steady | keys))
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

    values(FACTORS[0] * default)  # compile
    found = {factor * default: values(factor * default) for factor in FACTORS}
    fine = FACTORS[-2] * default
    change = np.abs(values(fine, NUDGE)[1] / found[fine][1] - 1.0)
    return default, found, np.nan_to_num(change).max(axis=2) < SAME


def errors(found, same):
    """{step: (median, largest) error of every value where the points do not depend on rounding}.

    Against the finest step. Points that are at rest, or not worn, have no error.
    """
    known = found[min(found)][1][same]
    off = {}
    for step, (_, values) in found.items():
        with np.errstate(invalid="ignore", divide="ignore"):
            off[step] = np.abs(values[same] / known - 1.0)
    return {step: (np.nanmedian(e, axis=0), np.nanmax(e, axis=0)) for step, e in off.items()}


def section(measured):
    """Markdown: a table for each case."""
    parts = ["## Run time against error where the casing gives or wears", WORDS]
    for (kind, law), (default, found, same) in measured.items():
        head = ["step", "s/sample", "amplitude: median error, %", "largest, %"]
        head += ["worn depth: median error, %", "largest, %"] if law == "abradable" else []
        rows = [
            (f"{1e6 * step:.3g} µs" + (" (default)" if step == default else ""),
             f"{found[step][0]:.2f}",
             *(f"{100 * number:.2f}" for pair in zip(*off, strict=True) for number in pair))
            for step, off in errors(found, same).items()
        ]  # fmt: skip
        parts.append(
            f"{kind.capitalize()}, {law}; {np.sum(same)} of {same.size} points do not depend on "
            f"rounding:\n\n{table(tuple(head), rows)}"
        )
    return "\n\n".join(parts)
