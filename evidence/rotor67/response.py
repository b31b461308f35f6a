"""The fan in contact: the studies of inputs/rotor67 on some ranks, their numbers and figures."""

import os
import shutil
import subprocess
from pathlib import Path

import numpy as np

import hpcrub
from evidence.page import ROOT
from evidence.program import ENVIRONMENT, command
from evidence.rotor67.numbers import Number
from hpcrub.config.schema import load_runs
from hpcrub.plot import pictures
from hpcrub.results.reader import Results
from hpcrub.statistics.pairs import rank_correlation, share_interval
from hpcrub.statistics.percentiles import Z_95, percentile_interval

INPUTS = ROOT / "inputs" / "rotor67"
STUDIES = "modes", "contact", "interaction_map", "percentiles", "coating", "motion"
FIGURES = {  # of the results to those of the page
    "modes_safe": "rotor67_safe",
    "contact": "rotor67_contact",
    "interaction_map": "rotor67_map",
    "percentiles": "rotor67_percentiles",
    "coating": "rotor67_coating",
    "coating_wear": "rotor67_wear",
    "motion_rubbing": "rotor67_rubbing",
}
SCALED = {  # keys of the numbers of fans, and how many there are at the scale 1
    "percentiles": "mistuning.samples",
    "coating": "mistuning.samples",
}
FEWEST = 4  # fans of a level
PERCENTILES = 1.0, 50.0, 99.0


def numbers(model: Path, scale: float, ranks: int, folder: Path, figures: Path) -> list[Number]:
    """Run all studies; figures go to a folder."""
    found = []
    for study in STUDIES:
        output = folder / f"{study}.h5"
        run(study, model, scale, ranks, output)
        if study == "motion":
            pictures.draw(hpcrub.plot.rubbing, [output])
        for name, figure in FIGURES.items():
            for drawn in folder.glob(f"{name}.*"):
                if name.startswith(study) and drawn.suffix in (".png", ".gif"):
                    shutil.copy(drawn, figures / f"{figure}{drawn.suffix}")
        with hpcrub.open(output) as file:
            if study == "contact":
                found += response_of(file)
            elif study == "percentiles":
                found += percentiles_of(file) + conclusions_of(file)
            elif study == "coating":
                found += wear_of(file)
    return found


def run(study: str, model: Path, scale: float, ranks: int, output: Path) -> None:
    """Run a study of INPUTS, or go on with it. Raises CalledProcessError."""
    source = INPUTS / f"{study}.yaml"
    changes = ["--set", f"disk.model={model}"]
    if study in SCALED and scale < 1:
        samples = load_runs(str(source), [])[0].mistuning.samples
        few = max(FEWEST, round(scale * samples))
        changes += ["--set", f"{SCALED[study]}={few}", "--set", f"convergence.step={few}"]
    words = command(ranks, ROOT / "main.py", source, *changes, "--output", output, "--resume")
    subprocess.run(words, check=True, env=os.environ | ENVIRONMENT, cwd=ROOT)


def response_of(file: Results) -> list[Number]:
    """Amplitude of the tuned fan at all speeds."""
    return [
        Number("amplitude of the tuned fan in contact", f"{speed:g} Hz", 1e3 * a, "mm")
        for speed, a in zip(file.config.speeds.values_hz, file["tuned/amplitude_m"], strict=True)
    ]


def percentiles_of(file: Results) -> list[Number]:
    """Percentiles of both amplifications at all levels, with 95 % intervals; tuned repeats."""
    runs = 1e3 * np.sort(file["tuned/run_peaks_m"])
    middle = 1e3 * file["tuned/reference_amplitude_m"]
    found = [
        Number("largest amplitude of the tuned fan", f"{len(runs)} runs", middle, "mm",
               runs[0], runs[-1])
    ]  # fmt: skip
    levels = file.config.mistuning.half_range_percent
    for kind, name in (("A_nl", "amplification"), ("A_lin", "linear_amplification")):
        for level, half_range in enumerate(levels):
            values = file[f"samples/{name}"][level]
            values = values[np.isfinite(values)]
            ends = percentile_interval(values, list(PERCENTILES), Z_95)
            for k, p in enumerate(PERCENTILES):
                low, high = (float(np.ravel(end)[k]) for end in ends)
                at = f"percentile {p:g}, blades within {half_range:g} %"
                found.append(Number(f"amplification {kind}", at, np.percentile(values, p), "1",
                                    low, high))  # fmt: skip
    return found


def conclusions_of(file: Results) -> list[Number]:
    """What the paper concludes of amplifications, as numbers of these fans at every level.

    Median of A_nl/A_lin, share of fans with A_nl above A_lin, rank correlation of both, with their
    intervals, 95 %.
    """
    found = []
    for level, half_range in enumerate(file.config.mistuning.half_range_percent):
        pairs = np.array([file[f"samples/{name}"][level]
                          for name in ("amplification", "linear_amplification")])  # fmt: skip
        nonlinear, linear = pairs[:, np.isfinite(pairs).all(axis=0)]
        ratio, at = nonlinear / linear, f"blades within {half_range:g} %"
        low, high = (float(np.ravel(end)[0]) for end in percentile_interval(ratio, [50.0], Z_95))
        above = int((ratio > 1.0).sum())
        r, r_low, r_high = rank_correlation(nonlinear, linear)
        found += [
            Number("median of A_nl/A_lin", at, float(np.median(ratio)), "1", low, high),
            Number("share of A_nl above A_lin", at, above / len(ratio), "1",
                   *share_interval(above, len(ratio))),
            Number("rank correlation of A_nl and A_lin", at, r, "1", r_low, r_high),
        ]  # fmt: skip
    return found


def wear_of(file: Results) -> list[Number]:
    """Amplitude and depth of the tuned fan at all speeds; percentiles of both over the fans."""
    found = []
    for name, what in (("largest_amplitude_m", "largest amplitude of the tuned fan on a coating"),
                       ("worn_depth_m", "worn depth of the tuned fan")):  # fmt: skip
        values = zip(file.config.speeds.values_hz, file[f"tuned/{name}"], strict=True)
        found += [Number(what, f"{speed:g} Hz", 1e3 * value, "mm") for speed, value in values]
    (half_range,) = file.config.mistuning.half_range_percent
    for name, what in (("peak_amplitude_m", "largest amplitude on a coating"),
                       ("deepest_m", "largest worn depth")):  # fmt: skip
        values = 1e3 * file[f"samples/{name}"][0]
        values = values[np.isfinite(values)]
        ends = percentile_interval(values, list(PERCENTILES), Z_95)
        for k, p in enumerate(PERCENTILES):
            low, high = (float(np.ravel(end)[k]) for end in ends)
            at = f"percentile {p:g}, blades within {half_range:g} %"
            found.append(Number(what, at, np.percentile(values, p), "mm", low, high))
    return found
