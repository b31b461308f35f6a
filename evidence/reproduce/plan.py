"""What is run, with the paper's numbers of samples; a scale multiplies these and nothing else."""

import json
from typing import NamedTuple

from evidence.page import ROOT
from hpcrub.config import schema as config


class Step(NamedTuple):
    """One input of `inputs/`, the keys that it is given, and how many samples at full scale."""

    name: str
    input: str
    keys: dict = {}  # noqa: RUF012, never changed
    samples: tuple = ()  # (key, number at full scale, fewest)
    sources: tuple = ()  # names of results below the folder
    weight: float = 1.0  # times the scale, up to the paper's numbers


PAPERS_RULE = {"steady_state.rule": "last_window", "mistuning.reference": "symmetric"}
LINEAR = ("mistuning.samples", 10_000, 50)
CONTACT = ("mistuning.samples", 5_000, 20)
PERTURBED = {  # runs of one disk that differ by a rounding: where a motion is chaotic, so do they
    "mistuning.pattern": None,
    "mistuning.half_range_percent": [1e-6],
    "mistuning.samples": 64,
    "mistuning.tuned_runs": 1,
}
TABLE_2 = config.load_runs(ROOT / "inputs" / "table2.yaml")[0]
MODULUS = TABLE_2.material.young_modulus_gpa
PATTERN = {
    "mistuning.intentional_percent": [
        100.0 * (E / MODULUS - 1.0) for E in TABLE_2.mistuning.pattern
    ]
}
FINE = {"speeds.from_hz": 33.5, "speeds.to_hz": 35.5, "speeds.step_hz": 0.005}
REFERENCE = {"mistuning.tuned_runs": 65}
LOW = {"material.damping_ratio": 4e-3}
CASES = {  # speeds of inputs/nodal_diameters.yaml [Hz]; the paper says most of four bumps
    run.casing.n_bumps: {
        "casing.n_bumps": run.casing.n_bumps,
        "speeds.from_hz": run.speeds.from_hz,
        "speeds.to_hz": run.speeds.to_hz,
    }
    for run in config.load_runs(ROOT / "inputs" / "nodal_diameters.yaml")
}
WEIGHT = {3: 1.0, 4: 5.0, 5: 1.0, 6: 1.0}  # of their samples
FILE_4, FILE_6 = "contact/n_bumps=4.h5", "contact/n_bumps=6.h5"
STEPS = (
    Step("modal", "modal"),
    Step("linear", "linear", samples=LINEAR, weight=5.0),
    Step("time_response", "time_response", {"history.duration_s": 1.0}),
    Step("interaction_map", "interaction_map", {"speeds.step_hz": 0.25}),
    Step("table2", "table2"),
    Step("perturbed_pattern", "table2", PERTURBED | PATTERN),
    Step("perturbed_tuned", "table2", PERTURBED),
    Step("casing_parameters", "casing_parameters"),
    Step("time_step", "time_step"),
    Step("reduction", "reduction"),
    Step("branches", "branches", FINE),
    *(
        Step(f"contact/n_bumps={n}", "paper_nd4", CASES[n] | REFERENCE, CONTACT, weight=WEIGHT[n])
        for n in CASES
    ),
    Step("contact_low", "paper_nd4", LOW | REFERENCE, CONTACT, weight=2.0),
    Step("sensitivity", "sensitivity", {}, ("mistuning.samples", 1_000, 20)),
    Step("energy_4", "energy", CASES[4] | PAPERS_RULE, ("energy.samples", 100, 5), (FILE_4,), 5.0),
    Step("energy_6", "energy", CASES[6] | PAPERS_RULE, ("energy.samples", 100, 5), (FILE_6,), 5.0),
)


def n_samples(step, scale):
    """How many samples a step has at a scale."""
    _, full, fewest = step.samples
    return max(fewest, round(min(1.0, step.weight * scale) * full))


def overrides(step, folder, scale):
    """Options --set of a step, as "key=value"."""
    keys = dict(step.keys)
    if step.samples:
        keys[step.samples[0]] = n_samples(step, scale)
    if step.sources:
        keys["sources"] = [str(folder / source) for source in step.sources]
    return [f"{key}={json.dumps(value)}" for key, value in keys.items()]


def arguments(step, folder, scale):
    """Arguments of main.py."""
    found = [str(ROOT / "inputs" / f"{step.input}.yaml")]
    found += ["--output", str(folder / f"{step.name}.h5")]
    for override in overrides(step, folder, scale):
        found += ["--set", override]
    return found
